"""How long two runs of one system stay together: chaos makes differences grow, by a factor in each impact or fall."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from linkages.arrays import Array
from linkages.errors import InputError
from linkages.results.akima import interpolated
from linkages.results.configuration import configuration
from linkages.results.trajectory import Trajectory
from linkages.system import System

#: Difference of two configurations (journals in parts of their clearances, angles in rad, lengths in parts of the
#: linkage's) beyond which two runs have parted: where something can touch, an impact may soon be missed; elsewhere
#: differences grow smoothly, and tell the errors while they are small.
PARTED, STRAYED = 1e-3, 0.05


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
    evaluate, end = dense(run), min(run.time[-1], other.time[-1])
    steps = np.flatnonzero(other.time <= end)[::every]
    times, touching = other.time[steps], bool(system.touching.any())
    there = configuration(system, {name: column[steps] for name, column in other.columns.items()})
    here = interpolated(run.time, configuration(system, run.columns), times)
    limit = PARTED if touching else STRAYED
    doubtful = np.flatnonzero(touching | ~(_distances(here, there) <= limit))  # else interpolation is exact enough
    if len(doubtful):
        here[doubtful] = configuration(system, evaluate(times[doubtful]))
    beyond = np.flatnonzero(~(_distances(here, there) <= limit))
    if not len(beyond):
        return None
    return float(times[max(beyond[0] - 1, 0)]), float(times[beyond[-1] + 1] if beyond[-1] + 1 < len(times) else end)


def _distances(here: Array, there: Array) -> Array:
    """Largest differences of the entries of configurations (nt, m), (nt,)."""
    return np.asarray(np.abs(here - there).max(axis=1, initial=0.0))


def dense(run: Trajectory) -> Callable[[Array], dict[str, Array]]:
    """Dense output of a run; InputError if the run was loaded from a file, and has none."""
    if run.evaluate is None:
        problem = "was loaded from a file and has no dense output; run it anew"
        raise InputError("argument", "trajectory", problem)
    return run.evaluate
