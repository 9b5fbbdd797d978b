"""Step by step from start to end: error control, events, records; for any method and any problem.

`driver` makes the function that integrates, from compiled functions of a method and of a problem:

========== ==========================================================================================================
function   what it does
========== ==========================================================================================================
rhs        ``rhs(problem, t, y, dy)`` fills the derivatives
attempt    ``attempt(problem, s, t, h, y, exact) -> (error, factor)`` tries a step, see `linkages.integrate.radau`
signs      ``signs(problem, g, dg)`` fills event functions and their rates, as of the last evaluation of `rhs`
settle     ``settle(problem, t, y, event) -> (status, changed)`` is called with every new state, the first too, and the
           event that ended the step, or -1; it may change y
observe    ``observe(problem, t, y, row)`` fills what is recorded beside t and y
========== ==========================================================================================================
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from linkages.integrate.stepper import COUNT, ERROR, Stepper, accept, copy, restart
from linkages.kernel import Array, Indices, inlined_kernel, kernel

#: How a run ends: at its end; after the steps it was given; where `settle` says so (larger values); step too small.
DONE, PAUSED, COLLAPSED = 0, 1, 2

_SMALLEST = 1e-14  # step, in parts of the time so far or of the first step: below it the run has collapsed
_TRIES = 60  # attempts at landing on an event
_STUCK = 200  # events in a row without a step worth its name
# The first step that the driver chooses, over the sixth root of the accuracy: how far it moves an entry of the state,
# in parts of its scale; its length, in parts of the shortest time constant; and its length where nothing moves.
_REACH, _CALM, _AT_REST = 0.01, 0.5, 1e-6
_WAY = 1e-7  # of its scale: how far the state is moved to find the shortest time constant


class Options(NamedTuple):
    """Settings of a run."""

    end: float  # last time
    first: float  # step to try first; 0: the driver chooses it
    largest: float  # step
    most: int  # steps after which the run pauses
    relative: float  # tolerance that is multiplied by an entry's magnitude and added to its absolute one
    landing: Array  # how close to zero an event function must come, (ne,)
    accuracy: float  # tolerance of an entry of the state in parts of its scale, for the choice of the first step


class Record(NamedTuple):
    """What happened: times (nt,), states (nt, n), what `observe` gave (nt, m); numbers of steps and evaluations."""

    times: Array
    states: Array
    observed: Array
    status: int
    steps: int
    rejected: int
    evaluations: int
    next_step: float


@kernel
def first_event(
    modes: Indices, landing: Array, g0: Array, d0: Array, g1: Array, d1: Array, h: float
) -> tuple[int, float]:
    """Event function that first leaves its sign within a step, and where, in parts of the step; -1 if none does.

    Each is taken as the cubic through its values and rates at both ends: also one that has its sign at both ends is
    found to lose it between.
    """
    which, where = -1, 2.0
    for k in range(len(modes)):
        m = modes[k]
        a, b = m * g0[k], m * g1[k]
        a = max(a, 0.0)  # landed just across and turned back: zero is behind
        da, db = m * d0[k] * h, m * d1[k] * h
        right = 1.0
        if b >= 0.0:
            right = _lowest(a, da, b, db)
            if right <= 0.0 or _cubic(right, a, da, b, db) >= -landing[k]:
                continue
        left = 0.0
        for _ in range(50):
            middle = 0.5 * (left + right)
            if _cubic(middle, a, da, b, db) < 0.0:
                right = middle
            else:
                left = middle
        if right < where:
            which, where = k, right
    return which, where


@inlined_kernel
def _cubic(x: float, a: float, da: float, b: float, db: float) -> float:
    """Evaluate Hermite's cubic on [0, 1]."""
    c2 = 3.0 * (b - a) - 2.0 * da - db
    c3 = 2.0 * (a - b) + da + db
    return a + x * (da + x * (c2 + x * c3))


@inlined_kernel
def _lowest(a: float, da: float, b: float, db: float) -> float:
    """Where Hermite's cubic on [0, 1] has its inner minimum; 0 if there is none."""
    c2 = 3.0 * (b - a) - 2.0 * da - db
    c3 = 2.0 * (a - b) + da + db
    root = c2 * c2 - 3.0 * c3 * da
    if root < 0.0:
        return 0.0
    root = math.sqrt(root)
    x = (-c2 + root) / (3.0 * c3) if abs(c3) > 1e-14 * abs(c2) else (-0.5 * da / c2 if c2 > 0.0 else 0.0)
    return x if 0.0 < x < 1.0 else 0.0


@kernel
def _taller(old: Array) -> Array:
    """Return the same lines with room for as many more."""
    new = np.empty((2 * len(old), old.shape[1]))
    for i in range(len(old)):
        copy(old[i], new[i])
    return new


@inlined_kernel
def _fitted(h: float, t: float, options: Options) -> tuple[float, bool]:
    """Size of the next attempt, not beyond the end nor just short of it; whether it reaches the end."""
    h = min(h, options.largest)
    if t + 1.0001 * h >= options.end:
        return options.end - t, True
    return (0.5 * (options.end - t) if t + 2.0 * h > options.end else h), False


@kernel
def _largest(entries: Array, scale: Array) -> float:
    """Return the largest magnitude of the entries, each in parts of its scale."""
    found = 0.0
    for i in range(len(entries)):
        found = max(found, abs(entries[i]) / scale[i])
    return found


@inlined_kernel
def _set_scale(s: Stepper, tolerance: Array, relative: float, y: Array) -> None:
    """Fill the error that counts as 1, for each entry of the state."""
    for i in range(len(y)):
        s.scale[i] = tolerance[i] + relative * abs(y[i])


def _starter(rhs: Any) -> Any:
    """Make the function that chooses the first step."""

    @kernel
    def first_step(problem: Any, s: Stepper, t: float, y: Array, accuracy: float) -> float:
        """Choose the first step from (t, y), with f0 known.

        It depends on the state and on the accuracy, not on the time at which the run ends. A stiff start (a film that
        stops a journal within nanoseconds) is resolved: three differences of the rates, each in the direction of the
        one before, give the shortest time constant.
        """
        speed = _largest(s.f0, s.scale)
        if not 0.0 < speed < math.inf:
            return _AT_REST
        direction, trial = s.error, s.trial[0]
        copy(s.f0, direction)
        size, square, way = speed, 1.0, _WAY / accuracy
        for k in range(3):
            for i in range(len(y)):
                trial[i] = y[i] + way * direction[i] / size
            rhs(problem, t, trial, s.f1)
            for i in range(len(y)):
                direction[i] = s.f1[i] - s.f0[i]
            size = _largest(direction, s.scale)
            if not 0.0 < size < math.inf:
                square = 0.0
                break
            if k > 0:
                square *= size / way
        rhs(problem, t, y, s.f0)
        step = _REACH / (accuracy * speed)
        if square > 0.0:
            step = min(step, _CALM / math.sqrt(square))
        return step * accuracy ** (1.0 / 6.0)

    return first_step


def _lander(attempt: Any, signs: Any) -> Any:
    """Make the function that shortens a step so that it ends on an event."""

    @kernel
    def land(
        problem: Any, s: Stepper, t: float, h: float, y: Array, modes: Indices, landing: Array,
        g0: Array, d0: Array, g1: Array, d1: Array,
    ) -> tuple[int, float]:  # fmt: skip
        """Return the event within an accurate step of size h, and a size that ends just across it; -1 and h if none.

        The shorter steps are of given size, without error control. If they fail the size is negative.
        """
        signs(problem, g1, d1)
        event, fraction = first_event(modes, landing, g0, d0, g1, d1, h)
        if event < 0:
            return event, h
        m, tiny = modes[event], landing[event]
        low, high = 0.0, h
        size = fraction * h
        for _ in range(_TRIES):
            size = min(max(size, low), high)
            error, _ = attempt(problem, s, t, size, y, True)
            if not error <= 1.0:
                return event, -1.0
            signs(problem, g1, d1)
            value, rate = m * g1[event], m * d1[event]
            if -tiny <= value < 0.0 or high - low <= 4e-16 * (t + h):
                return event, size
            if value >= 0.0:
                low = size
            else:
                high = size
            guess = size - (value + 0.5 * tiny) / rate if rate < 0.0 else 0.5 * (low + high)
            size = guess if low < guess < high else 0.5 * (low + high)
        return event, size

    return land


def driver(rhs: Any, attempt: Any, signs: Any, settle: Any, observe: Any) -> Any:
    """Make the function that integrates, from compiled functions; see the table above."""
    first_step, land = _starter(rhs), _lander(attempt, signs)

    @kernel
    def note(problem: Any, t: float, y: Array, line: Array) -> None:
        """Record a state: time, state, what is observed."""
        line[0] = t
        copy(y, line[1 : 1 + len(y)])
        observe(problem, t, y, line[1 + len(y) :])

    @kernel
    def drive(
        problem: Any, s: Stepper, tolerance: Array, t: float, start: Array, modes: Indices, width: int, options: Options
    ) -> Record:
        """Integrate from (t, start).

        Parameters
        ----------
        tolerance : (n,) array
            Absolute tolerance of each entry.
        modes : (ne,) array of int
            Sign of each event function, +1 or -1; kept up to date.
        width : int
            Length of what `observe` fills.
        """
        n, ne = len(start), len(modes)
        restart(s)
        s.memory[COUNT] = 0.0
        y = start.copy()
        g0, d0, g1, d1 = np.zeros(ne), np.zeros(ne), np.zeros(ne), np.zeros(ne)
        rhs(problem, t, y, s.f0)
        status, changed = settle(problem, t, y, -1)
        if changed:
            rhs(problem, t, y, s.f0)
        _set_scale(s, tolerance, options.relative, y)
        first = options.first if options.first > 0.0 else first_step(problem, s, t, y, options.accuracy)
        signs(problem, g0, d0)
        lines = np.empty((256, 1 + n + width))
        note(problem, t, y, lines[0])
        steps, rejected, stuck, failed = 0, 0, 0, False
        h = first
        while status == DONE and t < options.end:
            smallest = _SMALLEST * max(abs(t), first)
            if steps >= options.most:
                status = PAUSED
                break
            _set_scale(s, tolerance, options.relative, y)
            h, last = _fitted(h, t, options)
            error, factor = attempt(problem, s, t, h, y, False)
            event, size = -1, h
            if error <= 1.0 and ne:
                event, size = land(problem, s, t, h, y, modes, options.landing, g0, d0, g1, d1)
            if not error <= 1.0 or size < 0.0:
                rejected += 1
                failed = failed or error == math.inf
                h *= 0.5 if error <= 1.0 else min(factor, 0.9)
                if h < smallest:
                    status = COLLAPSED
                continue
            if failed:  # the equations of a longer step would most likely not be solved either
                factor = min(factor, 1.0)
            failed = False
            if event >= 0:
                stuck = stuck + 1 if size < smallest else 0
                if stuck > _STUCK:
                    status = COLLAPSED
                    break
                last = last and size == h
                factor = max(factor, 1.0) * h / size if size > smallest else 1.0
                factor = min(factor, h / max(size, smallest))
                modes[event] = -modes[event]
            else:
                stuck = 0
            accept(s, size, error)
            h = size
            t = options.end if last else t + h
            copy(s.new, y)
            steps += 1
            status, changed = settle(problem, t, y, event)
            if changed or event >= 0:
                rhs(problem, t, y, s.f0)
                s.memory[ERROR] = 0.0  # it was that of another state
            if event >= 0:
                restart(s)
            if ne:
                signs(problem, g0, d0)
            h = max(h * factor, 2.0 * smallest)
            if steps == len(lines):
                lines = _taller(lines)
            note(problem, t, y, lines[steps])
        lines = lines[: steps + 1]
        found = lines[:, 0].copy(), lines[:, 1 : 1 + n].copy(), lines[:, 1 + n :].copy()
        return Record(*found, status, steps, rejected, int(s.memory[COUNT]), h)

    return drive
