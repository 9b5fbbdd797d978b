"""The motion of the linkage with every joint ideal, over time: closed exactly wherever it is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import AssemblyError, Status
from linkages.planar.bodies import make_pose
from linkages.planar.closure import closure_error, closure_quality, follow
from linkages.planar.passage import GAP, WEIGHTS
from linkages.system.system import System

Array = NDArray[np.float64]

_GRID = 0.02  # step of the fastest drive between two stored positions [rad or m]
_BLURRED = 1e-3  # quality below which rates and accelerations have lost their digits
_LOCKED = 1e-3  # quality below which a motion that cannot go on has met a dead point
_HALVINGS = 40  # of a stored step, to find where a motion cannot go on


class IdealMotion:
    """Exact motion, reactions and drive torques of the linkage with every joint ideal.

    Only for linkages whose prescribed drives determine the motion (`System.determinate`). The motion is
    closed by Newton's method at every time asked for; a stored table of positions supplies the guesses.

    Attributes
    ----------
    times : (nt,) array
        Times of the stored table, dense enough to follow the branch [s].
    status : Status
        OK, or why the table ends early: LOCKED at a dead point of the drives, else NO_ASSEMBLY.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"))
    >>> motion = linkages.IdealMotion(system)
    >>> q, v, a = motion.states(motion.times[:3])
    >>> q.shape == (3, len(system.tree.coordinates))
    True
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.status = Status.OK
        duration = system.experiment.duration
        count = int(np.clip(np.ceil(duration * system.drive_rate / _GRID), 200, 200_000))
        self.times = np.linspace(0.0, duration, count + 1)
        self._follow_branch()

    def _follow_branch(self) -> None:
        """Fill the table; positions whose rates have no digits are passed over."""
        free = self.system.tree.closing_dofs
        q, v, a = self._prescribed(self.times)
        q[0, free] = self.system.assembly.q[free]
        quality = np.zeros(len(self.times))
        kept: list[int] = []
        for k, time in enumerate(self.times):
            line = q[k : k + 1], v[k : k + 1], a[k : k + 1]
            if kept:
                last = kept[-1]
                line[0][:, free] = _predicted(time - self.times[last], q[last], v[last], a[last])[free]
            if not self._close(*line, quality[k : k + 1]):
                if kept:
                    self._find_end(k, kept, q, v, a, quality)
                break
            if quality[k] > _BLURRED or not kept:
                kept.append(k)
        self.times, self.q, self.v, self.a, self.quality = (x[kept] for x in (self.times, q, v, a, quality))

    def _find_end(self, k: int, kept: list[int], q: Array, v: Array, a: Array, quality: Array) -> None:
        """Put line k of the table where the motion, which reaches none there, ends."""
        last, free = kept[-1], self.system.tree.closing_dofs
        low, high = self.times[last], self.times[k]
        self.status, start = Status.NO_ASSEMBLY, (q[last], v[last], a[last])
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            line = self._prescribed(np.array([middle]))
            line[0][:, free] = _predicted(middle - self.times[last], *start)[free]
            found = np.zeros(1)
            if not self._close(*line, found):
                high = middle
                continue
            low = self.times[k] = middle
            q[k], v[k], a[k], quality[k] = *(x[0] for x in line), found[0]
        if low > self.times[last]:
            kept.append(k)
        if quality[kept[-1]] < _LOCKED:
            self.status = Status.LOCKED

    def _close(self, q: Array, v: Array, a: Array, quality: Array, offset: Array | None = None) -> int:
        """Close the loops in each line; returns how many were closed."""
        tree = self.system.tree
        rows = tree.closure_rows
        if offset is None:
            offset = np.zeros((len(q), len(rows)))
        return follow(tree.bodies, rows, offset, tree.closing_dofs, tree.extent, q, v, a, quality)

    def _prescribed(self, times: Array) -> tuple[Array, Array, Array]:
        tree = self.system.tree
        q, v, a = np.zeros((3, len(times), tree.size))
        for table, values in zip((q, v, a), self.system.motions(times), strict=True):
            table[:, tree.driven_dofs] = values
        return q, v, a

    def states(
        self, times: Array, offset: Array | None = None, hinges: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Coordinates, rates and accelerations (nt, n) at any times within the table.

        Parameters
        ----------
        times : (nt,) array
        offset : (nt, nr) array, optional
            Wanted values of the tree's closure rows instead of zero (rates and accelerations are then those of a
            constant offset): places journals away from their bearings' centres.
        hinges : (nt, nh) array, optional
            Angles of the hinges of links in segments instead of zero [rad]; likewise.

        Raises
        ------
        AssemblyError
            If the loops do not close.
        """
        q, v, a = self._prescribed(times)
        if hinges is not None:
            q[:, self.system.tree.hinge_dofs] = hinges
        near = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        near -= times - self.times[near - 1] < self.times[near] - times
        if self.status is Status.LOCKED:  # rates of the last line have no bound
            near = np.minimum(near, len(self.times) - 2)
        free, step = self.system.tree.closing_dofs, (times - self.times[near])[:, None]
        q[:, free] = _predicted(step, self.q[near], self.v[near], self.a[near])[:, free]
        quality = np.zeros(len(times))
        done = self._close(q, v, a, quality, offset)
        if done < len(times):
            raise AssemblyError(Status.NO_ASSEMBLY, f"the loops do not close at t = {times[done]:.6g} s")
        if offset is None:
            for k in np.flatnonzero(quality < _BLURRED):
                self._interpolate(times[k], quality[k], q[k], v[k], a[k])
        return q, v, a

    def _interpolate(self, time: float, quality: float, q: Array, v: Array, a: Array) -> None:
        """Replace a state by one between others before and behind, as `linkages.planar.passage` does in runs.

        It stays as it is where they are no farther from a singular position, or no branch goes through.
        """
        tree, count = self.system.tree, len(WEIGHTS)
        steps = np.concatenate([np.arange(-count, 0), np.arange(1, count + 1)])
        times = time + 2.0 * _GRID / (self.system.drive_rate or np.inf) * steps
        if times[0] < 0.0 or times[-1] > self.times[-1]:
            return
        beside, free = self.states(times), tree.closing_dofs
        if min(closure_quality(tree.bodies, tree.closure_rows, free, x) for x in beside[0]) <= _BLURRED:
            return
        middle = [np.concatenate([WEIGHTS[::-1], WEIGHTS]) @ x for x in beside]
        pose = make_pose(tree.bodies)
        gap = closure_error(tree.bodies, tree.closure_rows, np.zeros(len(tree.closure_rows)), middle[0], pose)
        if np.abs(gap).max() <= GAP * tree.extent:
            for state, found in zip((q, v, a), middle, strict=True):
                state[free] = found[free]


def cause(status: Status, system: System, time: float) -> tuple[Status, float]:
    """Find why a run ended, and up to which time its numbers count.

    Where a step collapsed or a loop came apart, the drives may have reached a dead point. A run without play and
    without flexible links counts up to there.

    Parameters
    ----------
    status : Status
        Of the engine.
    system : System
    time : float
        At which the run ended [s].

    Returns
    -------
    status : Status
        LOCKED at a dead point, else the given one.
    end : float
        [s]
    """
    if status not in (Status.STEP_SIZE_COLLAPSE, Status.LOOP_OPEN) or not system.determinate or not system.drive_rate:
        return status, time
    motion = IdealMotion(system)
    if motion.status is not Status.LOCKED or time <= motion.times[-1] - _GRID / system.drive_rate:
        return status, time
    exact = not system.tree.play and not system.experiment.flexible
    return Status.LOCKED, min(time, float(motion.times[-1])) if exact else time


def _predicted(step: Any, q: Array, v: Array, a: Array) -> Array:
    return q + step * (v + 0.5 * step * a)
