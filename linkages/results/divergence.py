"""Divergence of two runs of one system: chaos multiplies their difference in each impact or fall."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.results.akima import interpolated
from linkages.results.trajectory import Trajectory
from linkages.system import System
from linkages.system.rigid_segments import system_of

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
    # where the interpolation is not accurate enough
    doubtful = np.flatnonzero(touching | ~(_distances(here, there) <= limit))
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
    if not run.evaluate:
        problem = "has no values between its steps: it was loaded from a file, or its steps collapsed; repeat the run"
        raise InputError("argument", "trajectory", problem)
    return run.evaluate


def configuration(system: System, columns: Mapping[str, Array]) -> Array:
    """Compute the configuration (nt, m) of a linkage from the columns of a run, at its steps or at any times.

    It has the eccentricities of the journals over their clearances, and coordinates of joints without prescribed
    motion: cosine and sine of angles, lengths over the linkage's length. Empty (m = 0) if the drives determine
    everything.
    """
    entries = []
    for (_, label), clearance in zip(system.tree.contacts, system.laws["clearance"], strict=False):
        if f"{label}.ex" in columns:
            entries += [columns[f"{label}.{axis}"] / clearance for axis in ("ex", "ey")]
    if not system.determinate:
        tree = system_of(system, columns).tree
        for name in (tree.coordinates[k] for k in tree.closing_dofs):
            joint = system.mechanism.joint.get(name)
            slides = joint.type == "prismatic" if joint else "." in name and not name.endswith(".angle")
            value = columns[f"q.{name}"]
            entries += [value / system.tree.extent] if slides else [np.cos(value), np.sin(value)]
    return np.array(entries).T if entries else np.zeros((len(columns["time"]), 0))
