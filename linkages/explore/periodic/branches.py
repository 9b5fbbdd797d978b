"""Branches of periodic motions of a linkage over one value, and their bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from linkages.base.arguments import Names, validated
from linkages.base.brief import Brief, counted
from linkages.base.errors import ARGUMENT, InputError, Status
from linkages.engines.compiled.effects import check_varied
from linkages.explore.numerics import BRANCHES_MOST, BRANCHES_SAME, BRANCHES_SHOWN
from linkages.explore.periodic.continuation import Settings, Solution, rescaled, solve
from linkages.explore.periodic.motion import PeriodicMotion, made
from linkages.explore.periodic.multipliers import DOUBLING, FOLD
from linkages.explore.periodic.return_map import ReturnMap, least_clearance
from linkages.explore.periodic.settings import ACCURACY, STEP, TOLERANCE, check_settings
from linkages.explore.periodic.tracing import INTERRUPTED, Bifurcation, Trace, doubled, trace, turned
from linkages.results.outputs.registry import pack
from linkages.system import System

_FIRST, _LEAST = 0.2, 1e-4  # first and smallest step, over the largest


@dataclass(frozen=True, eq=False)
class Event:
    """A bifurcation of a branch.

    Attributes
    ----------
    kind : str
        See `linkages.explore.periodic.multipliers`.
    motion : PeriodicMotion
        The motion there.
    multiplier : complex
        The Floquet multiplier on the unit circle; NaN for grazing.
    """

    kind: str
    motion: PeriodicMotion
    multiplier: complex


@dataclass(frozen=True, eq=False)
class Branch:
    """A branch of motions with the same period.

    Attributes
    ----------
    periods : int
        Common periods of the drives in a period of the motion.
    source : (int, int) or None
        Index of the branch and of its event, a period doubling, from which this branch comes.
    motions : tuple of PeriodicMotion
        In the order along the branch.
    events : tuple of Event
        In the same order.
    ends : tuple of str
        Why the branch ends, in each direction in which it was followed (`linkages.explore.periodic.tracing.ENDS`).
    """

    periods: int
    source: tuple[int, int] | None
    motions: tuple[PeriodicMotion, ...]
    events: tuple[Event, ...]
    ends: tuple[str, ...]


@dataclass(frozen=True, eq=False, repr=False)
class Branches(Brief):
    """All branches found from one motion; made by `branches`.

    Attributes
    ----------
    path : str
        Dotted path of the varied value.
    low, high : float
        Range of the value.
    outputs : tuple of str
        Outputs that each motion keeps.
    branches : tuple of Branch
    status : Status
        INTERRUPTED if the search was: the branches then end with the motions up to then.
    """

    path: str
    low: float
    high: float
    outputs: tuple[str, ...]
    branches: tuple[Branch, ...]
    status: Status = Status.OK

    def _facts(self) -> tuple[str, dict[str, str]]:
        points = sum(len(branch.motions) for branch in self.branches)
        line = f"{self.path}, {counted(len(self.branches), 'branch')[:-1]}, {counted(points, 'motion')}"
        kinds = [event.kind for branch in self.branches for event in branch.events]
        return line, {"bifurcations": ", ".join(kinds) or "none"}


@validated
def branches(
    system: System,
    path: str,
    low: float,
    high: float,
    start: float | None = None,
    outputs: Names = (),
    periods: int = 1,
    transient: int = 50,
    doublings: int = 2,
    step: float = STEP,
    accuracy: float = ACCURACY,
    tolerance: float = TOLERANCE,
    progress: Callable[[float], None] | None = None,
    origin: str = ARGUMENT,
) -> Branches:
    """Follow periodic motions over a value by pseudo-arclength continuation, and switch branches at period doublings.

    Unstable motions are followed as well as stable ones. Use `sweep` for motions that do not repeat.

    Parameters
    ----------
    system : System
    path : str
        Dotted path of the value, of the experiment or, with ``sdf.``, of the machine.
    low, high : float
        Range of the value.
    start : float, optional
        Value of the first motion; default: `low`.
    outputs : sequence of str
        Outputs that each motion keeps, see `linkages.results.outputs.registry`.
    periods : int
        Number of common periods of the drives in one period of the first motion.
    transient : int
        Common periods of the drives from the experiment's start to the guess of the first motion.
    doublings : int
        Period doublings in sequence at which branches are followed.
    step : float
        Largest step along a branch, over the range.
    accuracy, tolerance : float
        See `linkages.periodic_motion`.
    progress : callable, optional
        Called with the finished part, 0 to 1: each branch, up to the last doubling, counts by the part of the range
        that it has covered.
    origin : str
        Origin of the values, named in errors.

    Returns
    -------
    Branches
        Ctrl-C after the first motion ends the search, not the call: `Branches.status` tells it.

    Raises
    ------
    InputError
        If path, range or a setting is not valid; see also `linkages.periodic_motion`.
    RunError
        If the first motion is not found.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"))
    >>> found = linkages.branches(system, "joints.B.viscosity", 0.3, 0.4, transient=3, step=0.5)
    >>> [motion.stable for motion in found.branches[0].motions][-1]
    True
    """
    if not low < high:
        raise InputError(origin, path, f"the range {low:g} to {high:g} is empty; give low < high")
    numbers = {"periods": periods, "transient": transient, "doublings": doublings}
    check_settings(**numbers, step=step, accuracy=accuracy, tolerance=tolerance)
    first = low if start is None else start
    if not low <= first <= high:
        raise InputError(origin, path, f"the first motion's value {first:g} is not from {low:g} to {high:g}")
    for value in (low, high, first):
        system.replaced({path: value}, origin)
    check_varied(system, path, [low, high], origin, outputs)
    outputs = tuple(outputs)
    pack(system, outputs)
    search = _BranchSearch(system, path, low, high, step, accuracy, tolerance, outputs, progress or (lambda done: None))
    found = tuple(search.all(first, periods, transient, doublings))
    return Branches(path, low, high, outputs, found, Status.INTERRUPTED if search.interrupted else Status.OK)


#: Return map and traces of a branch, and where it comes from.
_Level = tuple[ReturnMap, list[Trace], tuple[int, int] | None]


@dataclass
class _BranchSearch:
    system: System
    path: str
    low: float
    high: float
    step: float
    accuracy: float
    tolerance: float
    outputs: tuple[str, ...]
    progress: Callable[[float], None]  # called with the finished part of all branches up to the last doubling
    interrupted: bool = False  # nothing is then traced any more
    known: dict[int, tuple[Solution, PeriodicMotion]] = field(default_factory=dict)  # by the identity of the point

    def all(self, first: float, periods: int, transient: int, doublings: int) -> list[Branch]:
        """Trace the branch of the first motion, and the branches from period doublings."""
        given = ReturnMap(self.system.replaced({self.path: first}), self.path, periods, transient, self.accuracy)
        settings = self._settings(given)
        point, settings = rescaled(solve(given, given.start, first, settings), settings)
        ends = [turned(point)] * (first > self.low) + [point] * (first < self.high)
        share = 1.0 / (doublings + 1.0)
        below_first = share * (first - self.low) / self._range
        lines = [self._trace(given, ends[0], settings, 0.0, share)]
        lines += [self._trace(given, end, settings, below_first, share) for end in ends[1:] if not self.interrupted]
        level: list[_Level] = [(given, lines, None)]
        found: list[Branch] = []
        for depth in range(doublings + 1):
            below: list[_Level] = []
            for of, traces, source in level:
                found.append(self._branch(of, traces, source))
                if depth < doublings and not self.interrupted:
                    below += self._switched(of, traces, len(found) - 1, settings, (depth + 1.0) * share, share)
            level = below
        return found

    def _switched(
        self, given: ReturnMap, traces: list[Trace], index: int, settings: Settings, done: float, share: float
    ) -> Iterator[tuple[ReturnMap, list[Trace], tuple[int, int]]]:
        """Trace the branches from the period doublings of a branch, each once: one may join two doublings."""
        rejoined: list[float] = []
        for k, event in enumerate(_in_order(traces)[1]):
            if event.kind != DOUBLING or any(abs(event.point.p - p) < BRANCHES_SAME * self._range for p in rejoined):
                continue
            new = self._doubled(event, given.periods, settings, done, share)
            if new is not None:
                line = new[1]
                rejoined += [found.point.p for found in line.bifurcations if found.kind == FOLD]
                yield new[0], [line], (index, k)
            if self.interrupted:
                return

    @property
    def _range(self) -> float:
        return self.high - self.low

    def _settings(self, given: ReturnMap) -> Settings:
        ends = [self.system.replaced({self.path: value}) for value in (self.low, self.high)]
        sizes = given.sizes(max(map(least_clearance, ends)))
        steps = {"first": _FIRST * self.step, "least": _LEAST * self.step, "most": self.step}
        return Settings(sizes, self._range, np.minimum(given.error, sizes), self.tolerance, **steps)

    def _trace(self, given: ReturnMap, point: Solution, settings: Settings, done: float, share: float) -> Trace:
        """Trace a branch from a point in the direction of its tangent: its share of the work comes after `done`."""
        start = point.p

        def report(point: Solution) -> None:
            self._motion(given, point)  # not at the end, which an interruption should reach soon
            self.progress(BRANCHES_SHOWN * (done + share * abs(point.p - start) / self._range))

        found = trace(given, point, (self.low, self.high), settings, BRANCHES_MOST, report)
        self.interrupted |= found.end == INTERRUPTED
        return found

    def _doubled(
        self, event: Bifurcation, periods: int, settings: Settings, done: float, share: float
    ) -> tuple[ReturnMap, Trace] | None:
        """Trace the branch that begins at a period doubling; None if its start is not found."""
        try:
            last = event.point.detail
            given = ReturnMap(last.system, self.path, 2 * periods, 0, self.accuracy, (last.y, last.memory))
            first = doubled(given, event.point, settings)
        except KeyboardInterrupt:
            self.interrupted, first = True, None
        return None if first is None else (given, self._trace(given, first, settings, done, share))

    def _branch(self, given: ReturnMap, traces: list[Trace], source: tuple[int, int] | None) -> Branch:
        """Join the traces of a branch, and compute the outputs of its motions."""
        points, found = _in_order(traces)
        motions = tuple(self._motion(given, point) for point in points)
        events = tuple(Event(b.kind, self._motion(given, b.point), b.multiplier) for b in found)
        return Branch(given.periods, source, motions, events, tuple(trace.end for trace in traces))

    def _motion(self, given: ReturnMap, point: Solution) -> PeriodicMotion:
        """Return the motion of a point with its outputs, computed once."""
        if id(point) not in self.known:
            motion = made(given, point, point.p)
            motion = replace(motion, outputs=motion.section(self.outputs)) if self.outputs else motion
            self.known[id(point)] = point, motion
        return self.known[id(point)][1]


def _in_order(traces: list[Trace]) -> tuple[list[Solution], list[Bifurcation]]:
    """Join one trace, or the traces in both directions from the same point, the backward one first."""
    first, *rest = traces
    if not rest:
        return first.points, first.bifurcations
    return first.points[:0:-1] + rest[0].points, first.bifurcations[::-1] + rest[0].bifurcations
