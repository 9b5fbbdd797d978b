"""Dynamics of planar linkages with imperfect joints.

Each folder imports only from those above it:

| folder    | what lives there                                                                              |
|-----------|-----------------------------------------------------------------------------------------------|
| base      | what every folder uses: arrays, errors, checked arguments, files, interrupts, the compiler    |
| laws      | force laws of a joint with clearance: contact, film, friction, wear                           |
| mechanics | kernels on plain arrays: integrators, elastic bodies, planar multibody dynamics               |
| elements  | elements of machines: one module for each kind; above `input.functions`, below `input.model`  |
| input     | SDFormat and TOML: read, imported, written; `Mechanism` and `Experiment`: validated input     |
| system    | `System`: the numeric model, built once from both                                             |
| results   | named outputs; trajectories, extremes, impacts, summaries                                     |
| engines   | the compiled and the Drake engine; runs that belong together                                  |
| explore   | periodic motions, sections, sweeps, exponents, linear models, derivatives, bearings, wear life |
| three_rrr | the flexible 3-RRR parallel robot                                                             |
| show      | figures and animations, report pages, the live page                                           |
| plots     | public path of the figures                                                                    |
| cli       | the command line                                                                              |

Conventions: SI units; angles counter-clockwise about the plane's normal; a joint's coordinate is zero in the reference
configuration (the pose of the SDF file); joint forces act on the joint's child (the journal); eccentricity points
from the bearing's centre to the journal's.
"""

from __future__ import annotations

import signal
import sys

_program, _handler = sys.orig_argv[1:3], signal.getsignal(signal.SIGINT)
_command = _program == ["-m", "linkages.cli.main"] or "".join(_program[:1]).endswith("/linkages")
if _command and _handler is signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # no traceback at Ctrl-C while the command is imported

from typing import Any  # noqa: E402

import lazy_loader  # noqa: E402

_loaded, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

_FORMER = {"study": "assess", "Study": "Assessment"}


def __getattr__(name: str) -> Any:
    """Return a public name, loaded on first use; a former name with a line of notice, once."""
    if name not in _FORMER:
        return _loaded(name)
    print(f"notice: linkages.{name} is now linkages.{_FORMER[name]}", file=sys.stderr)
    globals()[name] = found = _loaded(_FORMER[name])
    return found
