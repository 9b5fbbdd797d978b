"""Motion of the linkage with ideal joints over time, with exactly closed loops at any requested time."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arguments import Vector, inside, shaped, validated
from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, InputError, Status
from linkages.mechanics.planar.closure import BLURRED, closure_quality, follow, follow_branch, is_straight
from linkages.mechanics.planar.record_types import PRISMATIC
from linkages.mechanics.planar.singularities import GAP, WEIGHTS
from linkages.system.assembly import coordinate_scale
from linkages.system.system import System

_GRID = 0.02  # step of the fastest drive between two stored positions [rad or m]
_FEWEST, _MANY = 200, 200_000  # fewest steps between stored positions; most before the drive steps become longer
_COARSEST = 0.1  # step of the fastest drive between two stored positions in a long motion [rad or m]
_REPEATED = 10  # times as many positions may follow from the first turn: the columns of a run need the same memory
_PARTS = 100  # in which the speeds of drives over a long motion are compared, to save memory
#: Ends of runs that a dead point may cause: steps shrink near it without a bound, loops open behind it.
_AT_DEAD_POINTS = Status.STEP_SIZE_COLLAPSE, Status.TOO_MANY_STEPS, Status.LOOP_OPEN, Status.JOURNAL_LEFT_BEARING
_LOCKED = 1e-3  # conditioning below which a motion ends at a dead point
_RETURNED = 1e-9  # largest change of a coordinate over a turn that repeats itself [rad, or linkage lengths]
_SHORTEST = 2.0**-40  # smallest part of a stored step: if this fails, the motion ends


class _Lines(NamedTuple):
    """Stored positions of the motion: times (nt,), coordinates, rates, accelerations (nt, n), qualities (nt,)."""

    times: Array
    q: Array
    v: Array
    a: Array
    quality: Array

    def part(self, places: Any) -> _Lines:
        return _Lines(*(column[places] for column in self))


class IdealMotion:
    """Exact motion, reactions and drive torques of the linkage with ideal joints.

    Use it if the prescribed drives determine the motion (`System.determinate`); otherwise simulate the system
    `System.ideal()`. Newton's method closes the loops at every requested time. A stored table supplies initial guesses:
    one position per 0.02 rad or m of the fastest drive (at most 0.1 rad in motions of more than 4,000 rad; of drives at
    one constant speed these repeat the first turn if the linkage returns to its start). So a motion has up to 20,000
    rad or m, a repeated one ten times as many; an oscillation counts as 2 pi rad.

    Parameters
    ----------
    system : System

    Attributes
    ----------
    times : (nt,) array
        Times of the stored table, dense enough to follow the branch [s].
    q, v, a : (nt, n) arrays
        Coordinates of the tree, their rates and accelerations at these times, or of the turn that repeats itself alone
        [rad, m, s].
    quality : (nt,) array
        Conditioning of the closure at these times, see `linkages.system.assembly.Assembly` [1].
    status : Status
        OK, or why the table ends early: LOCKED at a dead point of the drives, else NO_ASSEMBLY.

    Raises
    ------
    InputError
        If the fastest drive moves farther.

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
        _check_travel(system, _REPEATED)
        self.system = system
        self.status = Status.OK
        self._scale = coordinate_scale(system.tree)
        count = int(np.clip(np.ceil(system.drive_travel / _GRID), _FEWEST, _MANY))
        self.times, turn = np.linspace(0.0, system.experiment.duration, count + 1), 0
        if system.drive_travel > _MANY * _GRID:
            self.times, turn = self._in_turns()
        self._turn, self._around = 0, np.zeros(system.tree.size)
        if not (turn and self._turn_repeats(turn)):
            _check_travel(system)
            self._follow_branch()

    def _in_turns(self) -> tuple[Array, int]:
        """Return times that divide each turn of drives at one constant speed alike, and their number in a turn.

        The number is zero for other drives, whose times stay as they are.
        """
        parts = map(self.system.motions, np.array_split(self.times, _PARTS))
        speed = abs(float(self.system.motions(self.times[:1])[1][0, 0]))
        if any(accelerations.any() or (np.abs(rates) != speed).any() for _, rates, accelerations in parts):
            return self.times, 0
        end, turn = float(self.times[-1]), 2.0 * np.pi / speed
        count = int(np.ceil(max(turn / self.times[1], 2.0 * np.pi / _COARSEST)))
        times = turn / count * np.arange(end / turn * count + 2.0)
        last = int(np.searchsorted(times, end))
        times[last] = end
        return times[: last + 1], count

    def _turn_repeats(self, turn: int) -> bool:
        """Follow the first turn alone; keep it for all turns, and return True, if the linkage returns to its start."""
        records, grid = self.system.tree.bodies.records, self.times
        self.times = grid[: turn + 1]
        self._follow_branch()
        ways = self.q[-1] - self.q[0]
        around = 2.0 * np.pi * np.round(ways / (2.0 * np.pi))
        around[records["dof"][records["type"] == PRISMATIC]] = 0.0
        back = np.abs(ways - around) <= _RETURNED * self._scale
        whole = np.array_equal(self.times, grid[: turn + 1]) and self.quality.min() > BLURRED and back.all()
        self.times = grid
        if whole:
            self._turn, self._around = turn, around
        else:
            self.status = Status.OK
        return bool(whole)

    def _follow_branch(self) -> None:
        """Fill the table; skip inaccurate positions."""
        tree, grid, done = self.system.tree, self.times, 1
        lines = _Lines(grid.copy(), *self._prescribed(grid), np.zeros(len(grid)))
        lines.q[0, tree.closing_dofs] = self.system.assembly.q[tree.closing_dofs]
        self._close(*(column[:1] for column in lines[1:]))
        table = [lines.part(slice(done))]
        while done < len(grid):
            rows, first = (tree.bodies, tree.closure_rows, tree.closing_dofs), done
            done = follow_branch(*rows, tree.extent, self._scale, first, *lines)
            good = first + np.flatnonzero(lines.quality[first:done] > BLURRED)
            table.append(lines.part(good))
            if done == len(grid):
                break
            start = lines.part([good[-1] if len(good) else first - 1])
            reached = self._creep(start, float(grid[done]))
            last = reached[-1] if reached else start
            if last.times[0] < grid[done]:
                table += reached
                self.status = Status.LOCKED if last.quality[0] < _LOCKED else Status.NO_ASSEMBLY
                break
            kept = [line for line in reached if line.quality[0] > BLURRED]
            table += kept
            for column, value in zip(lines, (kept or [start])[-1], strict=True):  # from which the next is predicted
                column[done] = value[0]
            done += 1
        self.times, self.q, self.v, self.a, self.quality = map(np.concatenate, zip(*table, strict=True))

    def _creep(self, start: _Lines, end: float) -> list[_Lines]:
        """Advance from a line of the table to a time in shorter steps, or to the end of the motion."""
        lines, line, free = [], start, self.system.tree.closing_dofs
        now = float(start.times[0])
        whole = step = end - now
        while now < end and step >= _SHORTEST * whole:
            then = end if now + 1.5 * step > end else now + step
            (q, v, a), quality = self._prescribed(np.array([then])), np.zeros(1)
            q[:, free] = _predicted(then - now, line.q, line.v, line.a)[:, free]
            straight = is_straight(then - now, self._scale, line.v[0], line.a[0], line.quality[0])
            if straight and self._close(q, v, a, quality):
                line, now = _Lines(np.array([then]), q, v, a, quality), then
                lines.append(line)
                step *= 2.0
            else:
                step *= 0.5
        return lines

    def _close(self, q: Array, v: Array, a: Array, quality: Array, offset: Array | None = None) -> int:
        """Close the loops in each line; return the number of closed lines."""
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

    @validated
    def states(
        self, times: Vector, offset: Array | None = None, hinges: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Compute coordinates, rates and accelerations (nt, n) at any times within the table.

        Parameters
        ----------
        times : (nt,) array
            In any order, from 0 to the last of `times`.
        offset : (nt, nr) array, optional
            Prescribed values of the tree's closure rows instead of zero (rates and accelerations belong to a
            constant offset): they displace journals from the bearings' centres.
        hinges : (nt, nh) array, optional
            Constant hinge angles of links in rigid segments instead of zero [rad].

        Raises
        ------
        AssemblyError
            If the loops do not close.
        InputError
            If a time lies outside the table.
        """
        times, tree = inside(times, 0.0, float(self.times[-1])), self.system.tree
        if offset is not None:
            offset = shaped(offset, (len(times), len(tree.closure_rows)), "offset", "values")
        if hinges is not None:
            hinges = shaped(hinges, (len(times), len(tree.hinge_dofs)), "hinges", "angles")
        near = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        near -= times - self.times[near - 1] < self.times[near] - times
        if self.status is Status.LOCKED or self._turn:  # rates of the last line are unbounded, or it is in no turn
            near = np.minimum(near, len(self.times) - 2)
        turns, lines = np.divmod(near, self._turn or len(self.times))
        stored = self.q[lines] + turns[:, None] * self._around, self.v[lines], self.a[lines]
        (q, v, a), free = self._prescribed(times), tree.closing_dofs
        if offset is None and hinges is None and np.array_equal(times, self.times[near]):
            for table, known in zip((q, v, a), stored, strict=True):
                table[:, free] = known[:, free]
            return q, v, a
        if hinges is not None:
            q[:, tree.hinge_dofs] = hinges
        q[:, free] = _predicted((times - self.times[near])[:, None], *stored)[:, free]
        quality = np.zeros(len(times))
        done = self._close(q, v, a, quality, offset)
        if done < len(times):
            raise AssemblyError(Status.NO_ASSEMBLY, f"the loops do not close at t = {times[done]:.6g} s")
        if offset is None:
            for k in np.flatnonzero(quality < BLURRED):
                self._interpolate(times[k], quality[k], q[k], v[k], a[k])
        return q, v, a

    def _interpolate(self, time: float, quality: float, q: Array, v: Array, a: Array) -> None:
        """Replace a state by one between others before and behind, as `singularities` does in runs.

        The state is kept if the neighbours are equally close to a singular position, or if no branch continues.
        """
        tree, count = self.system.tree, len(WEIGHTS)
        steps = np.concatenate([np.arange(-count, 0), np.arange(1, count + 1)])
        times = time + 2.0 * _GRID / (self.system.drive_rate or np.inf) * steps
        if times[0] < 0.0 or times[-1] > self.times[-1]:
            return
        beside, free = self.states(times), tree.closing_dofs
        if min(closure_quality(tree.bodies, tree.closure_rows, free, x) for x in beside[0]) <= BLURRED:
            return
        middle = [np.concatenate([WEIGHTS[::-1], WEIGHTS]) @ x for x in beside]
        if np.abs(tree.gaps(middle[0])).max() <= GAP * tree.extent:
            for state, found in zip((q, v, a), middle, strict=True):
                state[free] = found[free]


@lru_cache(maxsize=4)
def ideal_motion(system: System) -> IdealMotion:
    """Return the ideal motion of a system, which is followed once."""
    return IdealMotion(system)


def check_duration(system: System) -> None:
    """Reject a motion of more travel than `IdealMotion` follows; a long one is followed over its first turn."""
    if system.drive_travel > _MANY * _COARSEST:
        ideal_motion(system)


def _check_travel(system: System, times: int = 1) -> None:
    """Reject a motion whose fastest drive moves more than 20,000 rad or m, or several times as much."""
    most = times * _MANY * _COARSEST
    if system.drive_travel > most:
        asked, followed = (way / (2.0 * np.pi) for way in (system.drive_travel, most))
        longest = system.experiment.duration * most / system.drive_travel
        problem = (
            f"is {asked:.0f} revolutions (or oscillations) of the fastest drive; the ideal linkage supports at most "
            f"{followed:.0f}{' equal ones' if times > 1 else ''}: give {longest:.4g} s or less, or slow the drive"
        )
        raise InputError(system.experiment.source, "duration", problem)


def cause(status: Status, system: System, time: float) -> tuple[Status, float]:
    """Find the cause of a run's end, and the time up to which its numbers are valid; the one rule of all runs.

    After a step collapse, too many steps, an open loop or the failure of a film the drives may have reached a dead
    point; a run without clearance joints and flexible links is valid up to that point. The run ended at a time [s] with
    the engine's status; the result is LOCKED at a dead point, else this status, and the end of the valid part [s].
    """
    if status not in _AT_DEAD_POINTS or not system.determinate or not system.drive_rate:
        return status, time
    try:
        motion = ideal_motion(system)
    except InputError:  # the motion is too long to search for a dead point
        return status, time
    if motion.status is not Status.LOCKED or time <= motion.times[-1] - _GRID / system.drive_rate:
        return status, time
    exact = not system.tree.play and not system.tree.deformable
    return Status.LOCKED, min(time, float(motion.times[-1])) if exact else time


def _predicted(step: Any, q: Array, v: Array, a: Array) -> Array:
    return q + step * (v + 0.5 * step * a)
