"""Dynamics of planar linkages with imperfect joints.

Each folder imports only from those above it:

| folder    | what lives there                                                                              |
|-----------|-----------------------------------------------------------------------------------------------|
| base      | what every folder uses: arrays, errors, checked arguments, files, interrupts, the compiler    |
| laws      | force laws of a joint with clearance: contact, film, friction, wear                           |
| mechanics | kernels on plain arrays: integrators, elastic bodies, planar multibody dynamics               |
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

from typing import TYPE_CHECKING, Any  # noqa: E402

import lazy_loader  # noqa: E402

# ruff: noqa: F401 - for type checkers, names that are loaded on first use below
if TYPE_CHECKING:
    from linkages.base.errors import AssemblyError, InputError, RunError, Status
    from linkages.engines.assessment import assess, ideal, simulate
    from linkages.engines.compiled.batch.batch import Batch, simulate_batch
    from linkages.engines.compiled.stepping import Stepper
    from linkages.explore.bearing import bearing
    from linkages.explore.bearing_heat import warm_bearing
    from linkages.explore.compare import compare
    from linkages.explore.grid import sweep_grid
    from linkages.explore.linearisation import StateSpace, linearise
    from linkages.explore.lyapunov import largest_exponent
    from linkages.explore.modes import Modes, modes
    from linkages.explore.periodic.branches import branches
    from linkages.explore.periodic.motion import PeriodicMotion, periodic_motion
    from linkages.explore.sections import crossings, horizon, stroboscopic
    from linkages.explore.sensitivity import Sensitivities, sensitivities
    from linkages.explore.spectra import spectrum
    from linkages.explore.sweep import sweep
    from linkages.explore.wear.life import wear_life
    from linkages.input.files.fits import Fit, fit
    from linkages.input.files.general_tolerances import general_tolerance
    from linkages.input.files.shipped import find_file
    from linkages.input.model.experiment import Experiment, load_experiment
    from linkages.input.model.mechanism import Mechanism, load_mechanism
    from linkages.laws.heat import Heat
    from linkages.results.assessment import Assessment
    from linkages.results.derivatives import Direction
    from linkages.results.extremes import extremes, integral
    from linkages.results.impacts import impacts, phases
    from linkages.results.steady_state import Motion, motion_of
    from linkages.results.summary import summarize
    from linkages.results.trajectory import Trajectory, load_trajectory
    from linkages.show.live.answers import play
    from linkages.show.report.terminal import format_summary
    from linkages.system.ideal_motion import IdealMotion
    from linkages.system.system import System, load

#: Modules and their public names, which are loaded on first use, so that ``import linkages`` is fast.
_loaded, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "engines.assessment": ("assess", "ideal", "simulate"),
        "engines.compiled.batch.batch": ("Batch", "simulate_batch"),
        "engines.compiled.stepping": ("Stepper",),
        "base.errors": ("AssemblyError", "InputError", "RunError", "Status"),
        "explore.bearing": ("bearing",),
        "explore.bearing_heat": ("warm_bearing",),
        "explore.compare": ("compare",),
        "explore.grid": ("sweep_grid",),
        "explore.linearisation": ("StateSpace", "linearise"),
        "explore.lyapunov": ("largest_exponent",),
        "explore.modes": ("Modes", "modes"),
        "explore.periodic.branches": ("branches",),
        "explore.periodic.motion": ("PeriodicMotion", "periodic_motion"),
        "explore.sections": ("crossings", "horizon", "stroboscopic"),
        "explore.sensitivity": ("Sensitivities", "sensitivities"),
        "explore.spectra": ("spectrum",),
        "explore.sweep": ("sweep",),
        "explore.wear.life": ("wear_life",),
        "input.files.fits": ("Fit", "fit"),
        "input.files.general_tolerances": ("general_tolerance",),
        "input.files.shipped": ("find_file",),
        "laws.heat": ("Heat",),
        "show.live.answers": ("play",),
        "input.model.experiment": ("Experiment", "load_experiment"),
        "input.model.mechanism": ("Mechanism", "load_mechanism"),
        "show.report.terminal": ("format_summary",),
        "results.assessment": ("Assessment",),
        "results.derivatives": ("Direction",),
        "results.extremes": ("extremes", "integral"),
        "results.impacts": ("impacts", "phases"),
        "results.steady_state": ("Motion", "motion_of"),
        "results.summary": ("summarize",),
        "results.trajectory": ("Trajectory", "load_trajectory"),
        "system.ideal_motion": ("IdealMotion",),
        "system.system": ("System", "load"),
    },
)

_FORMER = {"study": "assess", "Study": "Assessment"}


def __getattr__(name: str) -> Any:
    """Return a public name, loaded on first use; a former name with a line of notice, once."""
    if name not in _FORMER:
        return _loaded(name)
    print(f"notice: linkages.{name} is now linkages.{_FORMER[name]}", file=sys.stderr)
    globals()[name] = found = _loaded(_FORMER[name])
    return found
