"""Divergence of two runs of one system: chaos multiplies their difference in each impact or fall."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from linkages.arrays import Array
from linkages.errors import InputError
from linkages.results.akima import interpolated
from linkages.results.configuration import configuration
from linkages.results.trajectory import Trajectory
from linkages.system import System

#: Difference of two configurations (eccentricities over clearances, angles in rad, lengths over the linkage's length)
#: beyond which two runs have diverged. With contacts the limit is small, as an impact may soon be missed. Without
#: contacts differences grow smoothly, and measure the errors while small.
PARTED, STRAYED = 1e-3, 0.05


def horizon(run: Trajectory, other: Trajectory, system: System) -> float:
    """Return the time up to which two runs agree [s]; see `apart`."""
    span = apart(run, other, system)
    return float(min(run.time[-1], other.time[-1])) if span is None else span[0]


def apart(run: Trajectory, other: Trajectory, system: System, every: int = 1) -> tuple[float, float] | None:
    """Find the time at which two runs diverge, and the time of their final convergence [s]; None if they never diverge.

    Runs that forget their start converge to the same motion, whatever their history. Without convergence the second
    time is the end of the shorter run. `run` needs dense output; both are compared at every n-th step of `other`, as
    each contact has many steps.
    """
    evaluate, end = dense(run), min(run.time[-1], other.time[-1])
    steps = np.flatnonzero(other.time <= end)[::every]
    times, touching = other.time[steps], system.experiment.can_touch
    there = configuration(system, {name: column[steps] for name, column in other.columns.items()})
    here = interpolated(run.time, configuration(system, run.columns), times)
    limit = PARTED if touching else STRAYED
    doubtful = np.flatnonzero(
        touching | ~(_distances(here, there) <= limit)
    )  # elsewhere interpolation is accurate enough
    if len(doubtful):
        here[doubtful] = configuration(system, evaluate(times[doubtful]))
    beyond = np.flatnonzero(~(_distances(here, there) <= limit))
    if not len(beyond):
        return None
    return float(times[max(beyond[0] - 1, 0)]), float(times[beyond[-1] + 1] if beyond[-1] + 1 < len(times) else end)


def _distances(here: Array, there: Array) -> Array:
    """Compute the largest difference of two configurations (nt, m) at each time, (nt,)."""
    return np.asarray(np.abs(here - there).max(axis=1, initial=0.0))


def dense(run: Trajectory) -> Callable[[Array], dict[str, Array]]:
    """Return the dense output of a run; InputError if it was loaded from a file without one."""
    if run.evaluate is None:
        problem = "was loaded from a file and has no dense output; repeat the run"
        raise InputError("argument", "trajectory", problem)
    return run.evaluate
