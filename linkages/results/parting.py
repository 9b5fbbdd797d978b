"""How long two runs of one system stay together: where joints touch, a difference grows by a factor in each impact."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError
from linkages.results.trajectory import Trajectory
from linkages.system import System

Array = NDArray[np.float64]

#: Two solutions have parted when a journal's places differ by this part of its clearance.
PARTED = 1e-3


def horizon(run: Trajectory, other: Trajectory, system: System) -> float:
    """Time up to which two runs stay together [s]; see `apart`."""
    span = apart(run, other, system)
    return float(min(run.time[-1], other.time[-1])) if span is None else span[0]


def apart(run: Trajectory, other: Trajectory, system: System, every: int = 1) -> tuple[float, float] | None:
    """Time at which two runs part, and when they have come together for good [s]; None if they never part.

    Runs that forget their start come to the same motion, whatever they did before. The second time is that of the end,
    at which the shorter run ends, if they do not.

    Parameters
    ----------
    run : Trajectory
        With dense output.
    other : Trajectory
        It is looked for at its steps, many in every contact.
    system : System
    every : int
        At one of so many of them.

    Raises
    ------
    InputError
        If the run was loaded from a file, and has no dense output.
    """
    end = min(run.time[-1], other.time[-1])
    steps = np.flatnonzero(other.time <= end)[::every]
    times = other.time[steps]
    exact = dense(run)(times)
    distance = np.zeros(len(times))
    for (_, label), clearance in zip(system.tree.contacts, system.laws["clearance"], strict=False):
        for column in (f"{label}.ex", f"{label}.ey"):
            distance = np.maximum(distance, np.abs(exact[column] - other[column][steps]) / clearance)
    beyond = np.flatnonzero(~(distance <= PARTED))
    if not len(beyond):
        return None
    return float(times[max(beyond[0] - 1, 0)]), float(times[beyond[-1] + 1] if beyond[-1] + 1 < len(times) else end)


def dense(run: Trajectory) -> Callable[[Array], dict[str, Array]]:
    """Dense output of a run; InputError if the run was loaded from a file, and has none."""
    if run.evaluate is None:
        problem = "was loaded from a file and has no dense output; run it anew"
        raise InputError("argument", "trajectory", problem)
    return run.evaluate
