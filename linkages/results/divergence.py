"""Divergence of two runs of one system: chaos multiplies their difference in each impact or fall."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from linkages.base.arrays import Array, Indices
from linkages.base.errors import InputError
from linkages.results import numerics
from linkages.results.akima import interpolated
from linkages.results.trajectory import Trajectory
from linkages.system import System
from linkages.system.rigid_segments import system_of

#: Difference of two configurations (eccentricities over clearances, angles in rad, lengths over the linkage's length)
#: beyond which two runs have diverged. With contacts the limit is small, as an impact may soon be missed. Without
#: contacts differences grow smoothly, and measure the errors while small.
PARTED, STRAYED = 1e-3, 0.05


def horizon(
    run: Trajectory, other: Trajectory, system: System, progress: Callable[[float], None] | None = None
) -> float:
    """Return the time up to which two runs agree [s]; see `apart`. `progress` is called with the time reached [s]."""
    pair = _Pair(run, other, system)
    first = pair.first(progress)
    return pair.end if first is None else float(pair.times[max(first - 1, 0)])


def apart(run: Trajectory, other: Trajectory, system: System, every: int = 1) -> tuple[float, float] | None:
    """Find the time at which two runs diverge, and the time of their final convergence [s]; None if they never diverge.

    Runs that forget their start converge to the same motion, whatever their history. Without convergence the second
    time is the end of the shorter run. `run` needs dense output; both are compared at every n-th step of `other`, as
    each contact has many steps.
    """
    pair = _Pair(run, other, system, every)
    first, times = pair.first(), pair.times
    if first is None:
        return None
    after = pair.last() + 1
    return float(times[max(first - 1, 0)]), float(times[after] if after < len(times) else pair.end)


class _Pair:
    """Two runs at every n-th step of the second one; the first is evaluated where its interpolation leaves a doubt.

    Attributes
    ----------
    end : float
        End of the shorter run [s].
    times : (nt,) array
        Times of the steps up to there [s].
    """

    def __init__(self, run: Trajectory, other: Trajectory, system: System, every: int = 1) -> None:
        self._system, self._evaluate = system, dense(run)
        self.end = float(min(run.time[-1], other.time[-1]))
        steps = np.flatnonzero(other.time <= self.end)[::every]
        self.times, touching = other.time[steps], system.can_touch
        self._there = configuration(system, {name: column[steps] for name, column in other.columns.items()})
        self._limit = PARTED if touching else STRAYED
        here = interpolated(run.time, configuration(system, run.columns), self.times)
        clear = _distances(here, self._there) <= (numerics.DIVERGENCE_CLEAR if touching else 1.0) * self._limit
        doubtful = np.flatnonzero(~clear)
        self._parts = [
            doubtful[k : k + numerics.DIVERGENCE_PART] for k in range(0, len(doubtful), numerics.DIVERGENCE_PART)
        ]

    def first(self, progress: Callable[[float], None] | None = None) -> int | None:
        """Return the first step at which the runs have diverged; None without any."""
        for part in self._parts:
            if len(found := self._beyond(part)):
                return int(found[0])
            if progress is not None:
                progress(float(self.times[part[-1]]))
        return None

    def last(self) -> int:
        """Return the last step at which the runs have diverged, after `first` has found one."""
        return next(int(found[-1]) for part in reversed(self._parts) if len(found := self._beyond(part)))

    def _beyond(self, steps: Indices) -> Indices:
        """Return those of some steps at which the runs have diverged."""
        here = configuration(self._system, self._evaluate(self.times[steps]))
        return steps[~(_distances(here, self._there[steps]) <= self._limit)]


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
            joint = system.joints.get(name)
            slides = joint.type == "prismatic" if joint else "." in name and not name.endswith(".angle")
            value = columns[f"q.{name}"]
            entries += [value / system.tree.extent] if slides else [np.cos(value), np.sin(value)]
    return np.array(entries).T if entries else np.zeros((len(columns["time"]), 0))
