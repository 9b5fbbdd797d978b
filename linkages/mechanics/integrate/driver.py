"""The loop over the steps of a run: error control, events, records; for any method and any equations.

`driver` makes the function that integrates, from compiled functions of a method and of a problem:

========== ==========================================================================================================
function   purpose
========== ==========================================================================================================
rhs        ``rhs(problem, t, y, dy)`` fills the derivatives
attempt    ``attempt(problem, s, t, h, y, exact) -> (error, ratio)`` attempts a step of size h from (t, y), with f0
           known, and fills new and f1. `error` is relative to the tolerance, infinite if the step failed; `ratio` is
           the next step size over h. With `exact` the size is fixed: the error is not estimated, and Newton's method
           iterates to a smaller residual
signs      ``signs(problem, g, dg)`` fills the event functions and their rates at the last evaluation of `rhs`
settle     ``settle(problem, t, y, event) -> (status, changed)`` is called with every new state, the first one included,
           and with the event at the end of the step, or -1; it may change y
stop       ``stop(problem, t) -> time`` is the next time at which a step must end and `settle` may change the state at
           once; infinite if there is none
limit      ``limit(problem) -> size`` is the longest next step, which may change in `settle`; infinite if there is none
divide     ``divide(problem, s, t, h, y, divisions) -> size`` shortens an attempted step to end where the equations stop
           being smooth, and attempts it again; h if they are smooth, negative if the attempt failed
observe    ``observe(problem, observer, t, y, row)`` fills further columns of the record; the last evaluation of
           the problem belongs to the state, if `attempt` ends with it
========== ==========================================================================================================
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel
from linkages.mechanics.integrate.events import lander
from linkages.mechanics.integrate.stepper import COUNT, ERROR, Stepper, accept, copy, restart

#: Status of a run: complete; paused after its number of steps; step size too small. `settle` may return larger values.
DONE, PAUSED, COLLAPSED = 0, 1, 2

# Limits of the first step, over the sixth root of the accuracy: change of an entry of the state relative to its scale;
# length relative to the shortest time constant; length where all rates are zero.
_CHANGE, _TIME_CONSTANT, _AT_REST = 0.01, 0.5, 1e-6
_DISTANCE = 1e-7  # of the state, relative to its scale, for the differences that give the time constant

_SMALLEST = 1e-14  # smallest step size, relative to the time so far or to the first step
_STUCK = 200  # consecutive events without a step above the smallest size, after which the run has collapsed


class Options(NamedTuple):
    """Settings of a run."""

    end: float  # last time
    first: float  # size of the first step; 0: chosen by the driver
    largest: float  # largest step size
    most: int  # steps after which the run pauses
    relative: float  # relative tolerance, added to the absolute one
    landing: Array  # magnitude of each event function that counts as zero, (ne,)
    divisions: Array  # data of `divide`, which is called only if there are any
    accuracy: float  # tolerance of an entry of the state relative to its scale, for the choice of the first step
    stop: Indices  # (1,): not zero as soon as the run is to pause after its present step


class Record(NamedTuple):
    """Result of a run: times (nt,), states (nt, n), columns of `observe` (nt, m); numbers of steps and evaluations."""

    times: Array
    states: Array
    observed: Array
    status: int
    steps: int
    rejected: int
    evaluations: int
    next_step: float


@kernel(makes_arrays=True)
def _doubled(old: Array) -> Array:
    """Copy rows into an array for twice as many."""
    new = np.empty((2 * len(old), old.shape[1]))
    for i in range(len(old)):
        copy(old[i], new[i])
    return new


@kernel(makes_arrays=True)
def joined(before: Record, after: Record) -> Record:
    """Join the records of two runs of which the second continues the first."""
    n, m = len(before.times), len(before.times) + len(after.times) - 1
    times, states = np.empty(m), np.empty((m, before.states.shape[1]))
    observed = np.empty((m, before.observed.shape[1]))
    times[:n], states[:n], observed[:n] = before.times, before.states, before.observed
    times[n:], states[n:], observed[n:] = after.times[1:], after.states[1:], after.observed[1:]
    steps, rejected = before.steps + after.steps, before.rejected + after.rejected
    evaluations = before.evaluations + after.evaluations
    return Record(times, states, observed, after.status, steps, rejected, evaluations, after.next_step)


@kernel
def without_last(record: Record) -> Record:
    """Return a record without its last line."""
    times, states, observed = record.times[:-1], record.states[:-1], record.observed[:-1]
    numbers = record.status, record.steps, record.rejected, record.evaluations, record.next_step
    return Record(times, states, observed, *numbers)


@kernel
def with_status(record: Record, status: int) -> Record:
    """Return a record with another status."""
    numbers = record.steps, record.rejected, record.evaluations, record.next_step
    return Record(record.times, record.states, record.observed, status, *numbers)


@inlined_kernel
def _fitted(h: float, t: float, end: float, largest: float) -> tuple[float, bool]:
    """Limit the size of the next step so that the last two steps are of similar size; whether it reaches the end."""
    h = min(h, largest)
    if t + 1.0001 * h >= end:
        return end - t, True
    return (0.5 * (end - t) if t + 2.0 * h > end else h), False


@inlined_kernel
def _set_scale(s: Stepper, tolerance: Array, relative: float, y: Array) -> None:
    """Fill the tolerance of each entry of the state."""
    for i in range(len(y)):
        s.scale[i] = tolerance[i] + relative * abs(y[i])


def driver(rhs: Any, attempt: Any, signs: Any, settle: Any, observe: Any, stop: Any, limit: Any, divide: Any) -> Any:
    """Make the function that integrates, from compiled functions; see the table at the head of the module."""
    first_step, land = starter(rhs), lander(attempt, signs)

    @kernel
    def note(problem: Any, observer: Any, t: float, y: Array, line: Array) -> None:
        """Fill a line of the record: time, state, columns of `observe`."""
        line[0] = t
        copy(y, line[1 : 1 + len(y)])
        observe(problem, observer, t, y, line[1 + len(y) :])

    @kernel(makes_arrays=True)
    def drive(
        problem: Any, observer: Any, s: Stepper, tolerance: Array, t: float, start: Array, modes: Indices, width: int,
        options: Options,
    ) -> Record:  # fmt: skip
        """Integrate from (t, start), with an absolute tolerance of each entry.

        ``modes`` (ne,) are the signs of the event functions, +1 or -1, updated at each event. `observer` is the further
        argument of `observe`, `width` the number of columns that it fills.
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
        note(problem, observer, t, y, lines[0])
        steps, rejected, stuck, failed = 0, 0, 0, False
        h = first
        while status == DONE and t < options.end:
            smallest = _SMALLEST * max(abs(t), first)
            if steps >= options.most or options.stop[0] != 0:
                status = PAUSED
                break
            _set_scale(s, tolerance, options.relative, y)
            end = min(options.end, stop(problem, t))
            h, last = _fitted(h, t, end, min(options.largest, limit(problem)))
            error, ratio = attempt(problem, s, t, h, y, False)
            event, size = -1, h
            if error <= 1.0 and ne:
                event, size = land(problem, s, t, h, y, modes, options.landing, g0, d0, g1, d1)
            divided = False
            if error <= 1.0 and size > 0.0 and len(options.divisions):
                part = divide(problem, s, t, size, y, options.divisions)
                if part < size:
                    event, size, divided = -1, part, True
            if not error <= 1.0 or size < 0.0:
                rejected += 1
                failed = failed or error == math.inf
                h *= 0.5 if error <= 1.0 else min(ratio, 0.9)
                if h < smallest:
                    status = COLLAPSED
                continue
            if failed:  # Newton's method would most likely fail again for a longer step
                ratio = min(ratio, 1.0)
            failed = False
            if event >= 0 or divided:
                stuck = stuck + 1 if size < smallest else 0
                if stuck > _STUCK:
                    status = COLLAPSED
                    break
                last = last and size == h
                ratio = max(ratio, 1.0) * h / size if size > smallest else 1.0
                ratio = min(ratio, h / max(size, smallest))
                if event >= 0:
                    modes[event] = -modes[event]
            else:
                stuck = 0
            accept(s, size, error)
            h = size
            t = end if last else t + h
            stopped = last and end < options.end
            copy(s.new, y)
            steps += 1
            status, changed = settle(problem, t, y, event)
            if changed or event >= 0 or divided:
                rhs(problem, t, y, s.f0)
                s.memory[ERROR] = 0.0  # the error belongs to the state before the change
            if event >= 0 or divided or stopped:
                restart(s)
            if ne:
                signs(problem, g0, d0)
            h = max(h * ratio, 2.0 * smallest)
            if steps == len(lines):
                lines = _doubled(lines)
            note(problem, observer, t, y, lines[steps])
        lines = lines[: steps + 1]
        found = lines[:, 0].copy(), lines[:, 1 : 1 + n].copy(), lines[:, 1 + n :].copy()
        return Record(*found, status, steps, rejected, int(s.memory[COUNT]), h)

    return drive


def starter(rhs: Any) -> Any:
    """Make the compiled function that chooses the first step."""

    @kernel(makes_arrays=True)
    def first_step(problem: Any, s: Stepper, t: float, y: Array, accuracy: float) -> float:
        """Choose the size of the first step from (t, y), with f0 and the scale known.

        The size depends on the state and on the accuracy, and not on the end of the run. It resolves a stiff start,
        such as a film that stops a journal within nanoseconds: three differences of the rates, each in the direction of
        the previous one, give the shortest time constant.
        """
        speed = _largest(s.f0, s.scale)
        if not 0.0 < speed < math.inf:
            return _AT_REST
        direction, trial = s.error, s.trial[0]
        copy(s.f0, direction)
        size, square, distance = speed, 1.0, _DISTANCE / accuracy
        for k in range(3):
            for i in range(len(y)):
                trial[i] = y[i] + distance * direction[i] / size
            rhs(problem, t, trial, s.f1)
            for i in range(len(y)):
                direction[i] = s.f1[i] - s.f0[i]
            size = _largest(direction, s.scale)
            if not 0.0 < size < math.inf:
                square = 0.0
                break
            if k > 0:
                square *= size / distance
        rhs(problem, t, y, s.f0)
        step = _CHANGE / (accuracy * speed)
        if square > 0.0:
            step = min(step, _TIME_CONSTANT / math.sqrt(square))
        return step * accuracy ** (1.0 / 6.0)

    return first_step


@kernel
def _largest(entries: Array, scale: Array) -> float:
    """Find the largest magnitude of the entries relative to their scales."""
    found = 0.0
    for i in range(len(entries)):
        found = max(found, abs(entries[i]) / scale[i])
    return found
