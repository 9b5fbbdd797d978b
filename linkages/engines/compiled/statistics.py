"""Extremes, mean and rms of outputs over windows of a run, over continuous time; values at the windows' ends."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.equations import solve_state
from linkages.engines.compiled.job import Job
from linkages.engines.compiled.replay import Steps, remember, replay
from linkages.integrate.parabola import parabola_top
from linkages.integrate.stepper import copy
from linkages.kernel import Array, Indices, kernel
from linkages.kernel.by_reference import reference
from linkages.outputs.evaluation import output_value
from linkages.outputs.quantity import Snapshot
from linkages.planar.ideal import ideal_state
from linkages.planar.loads import load_outputs
from linkages.planar.newton_euler import inertial_forces
from linkages.planar.reactions import joint_forces

#: Statistics of each window and output. To add one: its name here, at the end, and its formula in `_averages`.
STATISTICS = ("minimum", "maximum", "time_of_minimum", "time_of_maximum", "mean", "rms", "last")
_EXTREMES = 4  # of them

_CANDIDATES = 12  # local extremes that are refined, as long as their parabolas promise more than is found
_ROUNDS = 24  # of parabolas; smooth extremes take two or three, jumps all
_INSIDE = 0.02  # of a bracket's half: a new point keeps so far from the old ones
_KEPT = 0.1  # of a parabola's promise: a point that departs more from it is beside a jump or a kink
_FLAT = 1e-10  # relative gain that a parabola promises, after one that kept its promise, at which an extreme is known


class Sampler(NamedTuple):
    """A run that is evaluated at any time."""

    job: Job
    steps: Steps


@kernel
def look(job: Job, t: float, out: Array) -> bool:
    """Fill ``out`` (no,) with the outputs of the solved state; returns False if the ideal linkage does not close."""
    ideal, model, work = job.ideal, job.equations.model, job.equations.work
    w = work.dynamics
    if job.with_ideal and not ideal_state(model, w, job.rows, job.closing, ideal):
        return False
    if job.with_loads and len(model.loads):
        load_outputs(
            (model.loads, model.signals, model.load_t, model.load_c, model.load_n), t, w.pose, w.vel, work.applied
        )
    if job.with_forces:
        inertial_forces(model.bodies, w, model.gravity, w.bias, w.modal_bias)
        joint_forces(model, w, work.contacts, work.forces, work.efforts)
    snapshot = Snapshot(model, w, work.contacts, work.forces, work.efforts, work.applied)
    seen, outputs = reference(snapshot), job.outputs
    for k in range(len(outputs)):
        out[k] = output_value(outputs[k], seen)
        if outputs[k].jitter:
            exact = Snapshot(model, ideal, work.contacts, work.forces, work.efforts, work.applied)
            out[k] -= output_value(outputs[k], reference(exact))
    return True


@kernel
def asked(job: Job, t: float, valid: float) -> bool:
    """Whether a time is in a window that ends before the time `valid`."""
    inside = False
    for m in range(len(job.windows)):
        inside |= job.windows[m, 0] <= t <= job.windows[m, 1] < valid
    return inside


@kernel
def knows_outputs(job: Job) -> bool:
    """Whether outputs are recorded during the run: the explicit method leaves the equations solved at each state."""
    return not (job.equations.implicit or job.with_ideal)


@kernel
def _sample(sampler: Sampler, t: float, out: Array) -> bool:
    """Fill ``out`` (no,) with the outputs at time t; returns False if the ideal linkage does not close."""
    job = sampler.job
    replay(job.equations, job.stepper, job.tolerance, sampler.steps, t, job.y)
    return look(job, t, out)


@kernel
def _top(bracket: Array) -> tuple[float, float]:
    """Where the parabola through a bracket's three points, times and values (2, 3), is highest, and how high."""
    t, f = bracket[0], bracket[1]
    return parabola_top(t[0], t[1], t[2], f[0], f[1], f[2])


@kernel
def _narrow(bracket: Array, t: float, f: float) -> None:
    """Put a point within a bracket in the middle if it is higher than what is there, else at its end."""
    end = 0 if t < bracket[0, 1] else 2
    if f > bracket[1, 1]:
        bracket[0, 2 - end], bracket[1, 2 - end] = bracket[0, 1], bracket[1, 1]
        end = 1
    bracket[0, end], bracket[1, end] = t, f


@kernel
def _refine(sampler: Sampler, k: int, sign: float, bracket: Array) -> tuple[float, float]:
    """Largest sign * output k within a bracket of signed values whose middle is highest, and its time.

    Where a parabola's promise is not kept, at a jump or a kink, the middle of the longer half is looked at too.
    """
    kept = False
    for _ in range(_ROUNDS):
        a, b, c, highest = bracket[0, 0], bracket[0, 1], bracket[0, 2], bracket[1, 1]
        top, promised = _top(bracket)
        t, gain = min(max(top, a + _INSIDE * (b - a)), c - _INSIDE * (c - b)), promised - highest
        if (kept and gain <= _FLAT * abs(highest)) or abs(t - b) < 1e-5 * (c - a):
            break
        if not _sample(sampler, t, sampler.job.row):
            break
        f = sign * sampler.job.row[k]
        if f == highest:  # a plateau, such as the force of a free journal: its end promises more
            break
        _narrow(bracket, t, f)
        kept = abs(f - promised) <= _KEPT * gain + _FLAT * abs(bracket[1, 1])
        if not kept:
            a, b, c = bracket[0, 0], bracket[0, 1], bracket[0, 2]
            t = 0.5 * (b + c) if c - b > b - a else 0.5 * (a + b)
            if not _sample(sampler, t, sampler.job.row):
                break
            _narrow(bracket, t, sign * sampler.job.row[k])
    return bracket[0, 1], bracket[1, 1]


@kernel
def _turn(sampler: Sampler, k: int, sign: float, bracket: Array) -> bool:
    """Narrow a bracket whose highest point is at an end to one whose middle is highest; False if there is none."""
    t, _ = _top(bracket)
    if not _sample(sampler, t, sampler.job.row):
        return False
    f = sign * sampler.job.row[k]
    if f <= max(bracket[1, 0], bracket[1, 2]):
        return False
    _narrow(bracket, t, f)
    return True


@kernel
def summarise(job: Job, steps: Steps, table: Array, valid: float, out: Array) -> bool:
    """Fill `STATISTICS` (nw, no, ns) of a run over the job's windows; returns False if the ideal linkage is open.

    Parameters
    ----------
    job : Job
        Whose contacts remember nothing.
    steps : Steps
        Of the run.
    table : (nt, no) array
        Outputs at the steps, filled unless `knows_outputs`.
    valid : float
        Time up to which the run is valid [s]; windows that do not end before it get NaN.
    """
    sampler, windows = reference(Sampler(job, steps)), job.windows
    grid, states = steps.times, steps.states
    nt, no = len(grid), len(job.outputs)
    bracket = np.empty((2, 3))
    for i in range(nt):
        if knows_outputs(job) or not asked(job, grid[i], valid):
            continue
        remember(job.equations, steps, i)
        solve_state(job.equations, grid[i], states[i])
        if not look(job, grid[i], table[i]):
            return False
    for m in range(len(windows)):
        t0, t1 = windows[m, 0], windows[m, 1]
        if not t1 < valid:
            out[m] = math.nan
            continue
        first, last = np.searchsorted(grid, t0), np.searchsorted(grid, t1, side="right")
        size = last - first + 4
        times, values = np.empty(size), np.empty((size, no))
        count = 0
        if first == last or grid[first] > t0:
            if not _sample(sampler, t0, values[0]):
                return False
            times[0] = t0
            count = 1
        for i in range(first, last):
            if count and grid[i] == times[count - 1]:  # an event without a step: the state after it counts
                count -= 1
            times[count] = grid[i]
            copy(table[i], values[count])
            count += 1
        if times[count - 1] < t1:
            if not _sample(sampler, t1, values[count]):
                return False
            times[count] = t1
            count += 1
        for k in range(no):
            _averages(times[:count], values[:count, k], out[m, k, _EXTREMES:])
        # an extreme within the first or the last step has samples on both sides then
        for place in (count - 1, 1):
            if 0 < place < count:
                for i in range(count, place, -1):
                    times[i] = times[i - 1]
                    copy(values[i - 1], values[i])
                times[place] = 0.5 * (times[place - 1] + times[place + 1])
                count += 1
                if not _sample(sampler, times[place], values[place]):
                    return False
        for k in range(no):
            for side in range(2):
                sign = -1.0 if side == 0 else 1.0
                best, when = -np.inf, t0
                for i in range(count):
                    if sign * values[i, k] > best:
                        best, when = sign * values[i, k], times[i]
                places, tops = _candidates(times[:count], values[:count, k], sign, best)
                for _ in range(min(_CANDIDATES, len(places))):
                    highest = np.argmax(tops)
                    if not tops[highest] > best:
                        break
                    i, tops[highest] = places[highest], -np.inf
                    left = min(max(i - 1, 0), count - 3)
                    for j in range(3):
                        bracket[0, j], bracket[1, j] = times[left + j], sign * values[left + j, k]
                    if i in (0, count - 1) and not _turn(sampler, k, sign, bracket):
                        continue
                    t, f = _refine(sampler, k, sign, bracket)
                    if f > best:
                        best, when = f, t
                out[m, k, side] = sign * best
                out[m, k, 2 + side] = when
    return True


@kernel
def _candidates(times: Array, values: Array, sign: float, floor: float) -> tuple[Indices, Array]:
    """Find the samples at local maxima whose parabolas rise above the floor within them, and how high these rise."""
    count, n = 0, len(times)
    places, tops = np.empty(n, np.int64), np.empty(n)
    for i in range(n if n > 2 else 0):
        f, left = sign * values[i], min(max(i - 1, 0), n - 3)
        fa, fb, fc = sign * values[left], sign * values[left + 1], sign * values[left + 2]
        if f < fa or f < fb or f < fc:
            continue
        t, top = parabola_top(times[left], times[left + 1], times[left + 2], fa, fb, fc)
        if top > floor and times[left] < t < times[left + 2]:
            places[count], tops[count] = i, top
            count += 1
    return places[:count], tops[:count]


@kernel
def _averages(times: Array, values: Array, out: Array) -> None:
    """Fill ``out`` with the statistics after the extremes, by parabolas through three neighbouring samples."""
    n = len(times)
    last, span = values[n - 1], times[n - 1] - times[0]
    one, two = 0.0, 0.0  # integrals of the value and of its square
    if n < 2 or not span > 0.0:
        n, span, one, two = 1, 1.0, values[0], values[0] ** 2
    i = 0
    while i + 2 < n:
        h0, h1 = times[i + 1] - times[i], times[i + 2] - times[i + 1]
        total = (h0 + h1) / 6.0
        w0, w1, w2 = 2.0 - h1 / h0, (h0 + h1) ** 2 / (h0 * h1), 2.0 - h0 / h1
        one += total * (w0 * values[i] + w1 * values[i + 1] + w2 * values[i + 2])
        two += total * (w0 * values[i] ** 2 + w1 * values[i + 1] ** 2 + w2 * values[i + 2] ** 2)
        i += 2
    if i + 1 < n:
        h = times[i + 1] - times[i]
        one += 0.5 * h * (values[i] + values[i + 1])
        two += 0.5 * h * (values[i] ** 2 + values[i + 1] ** 2)
    out[0] = one / span
    out[1] = math.sqrt(max(two / span, 0.0))
    out[2] = last
