"""The subcommands of ``linkages``, one module each; they may import everything of `linkages`.

| module        | responsibility                                                        |
|---------------|-----------------------------------------------------------------------|
| main          | entry point: parser, errors, failed runs and their exit statuses      |
| simulate      | ``linkages simulate``: run an experiment                              |
| compare       | ``linkages compare``: both engines on one experiment                  |
| sweep         | ``linkages sweep``: over the values of one variable or two            |
| sweep_grid    | the same over two                                                     |
| sweep_tables  | tables and files of sweeps                                            |
| continue_     | ``linkages continue``: branches of periodic motions                   |
| wear          | ``linkages wear``: profiles and clearance over the service life       |
| animate       | ``linkages animate``: a run as a GIF or MP4 file                      |
| overlay       | ``linkages overlay``: several runs in one figure                      |
| report        | ``linkages report``: one HTML page from a folder of results           |
| export        | ``linkages export``: a trajectory for other programs                  |
| bearing       | ``linkages bearing``: a journal bearing under a static load           |
| draw          | ``linkages draw``: a labelled picture of a mechanism                  |
| new           | ``linkages new``: template files of a linkage                         |
| import_       | ``linkages import``: SDFormat or URDF of other programs               |
| play          | ``linkages play``: the live page of an experiment                     |
| modes         | ``linkages modes``: chooses linkage or 3-RRR robot; the robot         |
| linearise     | ``linkages linearise``: a linear state-space model                    |
| sensitivity   | ``linkages sensitivity``: derivatives with respect to values          |
| linkage_modes | natural frequencies and mode shapes of a linkage                      |
| keys          | ``linkages keys``: keys of an experiment file, outputs of a run       |
| doctor        | ``linkages doctor``: check of the installation                        |
| preparation   | the code of all commands, compiled before it is needed                |
| completion    | ``linkages completion``: a script for the shell                       |
| options       | options of several commands, numbers, their system, their folders     |
| printing      | text on standard output: 78 columns, marks, colours                   |
| progress      | progress: bars, lines, heartbeat                                      |

A command's module has ``HELP`` (one line), ``add_options(parser)`` and ``run(options) -> exit status``, optionally
``EXAMPLES`` (text below the help), ``WRITES`` (the files of each of its kinds of results by name, the first of which
identifies them), ``SHORT_RUNS`` and ``SHORT_FILES`` (see `preparation`); it imports its heavy dependencies inside
`run`. Other packages add commands through entry points of the group ``linkages.commands``; one that cannot be loaded is
skipped with a warning.
"""

from __future__ import annotations

import importlib
import keyword
import sys
from importlib.metadata import entry_points
from typing import Any

_OWN = (
    *("simulate", "compare", "sweep", "continue", "wear", "animate", "overlay", "report", "export", "bearing", "draw"),
    *("new", "import", "modes", "linearise", "sensitivity", "play", "keys", "doctor", "completion"),
)


def commands(wanted: str = "") -> dict[str, Any]:
    """Find subcommands by name: the `wanted` one if this package has it, otherwise all.

    Prints a warning for each unusable command of other packages.
    """
    alone = wanted in _OWN
    names = (wanted,) if alone else _OWN
    modules = {name: f"{__name__}.{name}{'_' * keyword.iskeyword(name)}" for name in names}
    found = {name: importlib.import_module(module) for name, module in modules.items()}
    for point in () if alone else entry_points(group="linkages.commands"):
        try:
            if point.name in found:
                raise ValueError("the name is taken")
            command = point.load()
            if missing := [part for part in ("HELP", "add_options", "run") if not hasattr(command, part)]:
                raise TypeError(f"it has no {missing[0]}")
            found[point.name] = command
        except Exception as problem:  # an error of another package must not disable all commands
            reason = " ".join(f"{type(problem).__name__}: {problem}".split())
            print(f"warning: command {point.name} ({point.value}) is skipped: {reason}", file=sys.stderr)
    return found
