"""The experiments that come with the package, and runs that several tests look at."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

import linkages
import optim
from linkages.input.files.shipped import data_folder
from linkages.results.outputs import registry

#: The studies that come with `optim`.
STUDIES_FOLDER = Path(optim.__file__).parent / "studies"

#: Experiments with flexible links, for which Drake uses another model; the others, with rigid links. The
#: flexible robot has a separate command, and separate tests as a linkage (flexible/test_robot.py).
BENT = ["slider_crank_flexible"]
NAMES = sorted(
    path.stem
    for path in data_folder().glob("*.toml")
    if not path.stem.startswith("three_rrr") and path.stem not in BENT
)

_ANGLES = 2.0 * np.pi * np.arange(120) / 120
#: Both parts of the joint of `slider_crank_wear`, worn all around: two pockets and three.
WORN = {
    "joints.B.wear.bearing_depth": (3e-5 * (1.0 + np.cos(2.0 * _ANGLES - 0.4))).tolist(),
    "joints.B.wear.journal_depth": (1e-5 * (1.0 + np.sin(3.0 * _ANGLES))).tolist(),
}


#: The press of the benchmarks: both cranks at one turn per second, no weight, long films.
FAST_PRESS = Path(__file__).resolve().parents[1] / "benchmarks" / "seven_bar_fast.toml"


def shipped(name: str, **overrides) -> linkages.System:
    """Load a shipped experiment, or the press of the benchmarks, with values replaced by dotted path."""
    file = FAST_PRESS if name == FAST_PRESS.stem else data_folder() / f"{name}.toml"
    return linkages.load(file, overrides)


@cache
def run(engine: str, name: str, **overrides) -> linkages.Trajectory:
    """Run a shipped experiment; repeated calls return the same trajectory."""
    return linkages.simulate(shipped(name, **overrides), engine)


@cache
def run_compiled(system: linkages.System) -> linkages.Trajectory:
    """Run a system with the compiled engine to its end, once."""
    result = linkages.simulate(system, "compiled")
    assert result.status is linkages.Status.OK
    return result


def points(system: linkages.System) -> list[str]:
    """Outputs of the system's links and frames: those whose jitter there is."""
    return [name for name in registry.names(system) if name.rpartition(".")[0] in system.mechanism.point]
