"""Extremes, mean and rms of outputs over windows of a run, over continuous time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from linkages.engines.compiled.entry_points import solve
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.replay import Steps, remember, replay
from linkages.integrate.stepper import Stepper, copy
from linkages.kernel import Array, Records, kernel
from linkages.kernel.by_reference import reference
from linkages.outputs.values import DRIVE, JOINT, LINKAGE, LOAD, View, output_value, point_value
from linkages.planar.dynamics import inertial_load
from linkages.planar.ideal import Ideal, ideal_state
from linkages.planar.loads import load_outputs
from linkages.planar.reactions import joint_forces
from linkages.results.parabola import parabola_top

#: What is filled for each window and output. To add one: its name here, at the end, and its formula in `_averages`.
STATISTICS = ("minimum", "maximum", "time_of_minimum", "time_of_maximum", "mean", "rms")
_EXTREMES = 4  # of them

_CANDIDATES = 3  # local extremes that are refined
_ROUNDS = 8  # of parabolas
_INSIDE = 0.02  # of a bracket's half: a new point keeps so far from the old ones
_FLAT = 1e-10  # relative change of an extreme at which it is known


@kernel
def _needs(outputs: Records) -> tuple[bool, bool, bool]:
    """Whether outputs need the ideal linkage's state, the forces in joints, what the loads do."""
    ideal, forces, loads = False, False, False
    for k in range(len(outputs)):
        kind = outputs[k].kind
        ideal = ideal or outputs[k].jitter != 0
        forces = forces or kind in (JOINT, DRIVE)
        loads = loads or kind in (LOAD, LINKAGE)
    return ideal, forces, loads


@kernel
def _look(
    equations: Equations, ideal: Ideal, needs: tuple[bool, bool, bool], outputs: Records, t: float, out: Array
) -> bool:
    """Fill ``out`` (no,) with the outputs of the solved state; returns False if the ideal linkage does not close."""
    model, work = equations.model, equations.work
    w = work.dynamics
    if needs[0] and not ideal_state(model, w, ideal):
        return False
    if needs[2] and len(model.loads):
        load_outputs((model.loads, model.load_t, model.load_c, model.load_n), t, w.pose, w.vel, work.applied)
    if needs[1]:
        inertial_load(model.bodies, w.pose, w.vel, w.acc, model.gravity, w.wrench, w.load)
        joint_forces(
            model, w.pose, work.contacts, w.tau, w.reaction, w.load, work.forces, work.efforts,
        )  # fmt: skip
    view = View(
        model.bodies, model.ends, model.gravity, w.q, w.v, w.pose, w.vel, w.acc,
        work.contacts, work.forces, work.efforts, work.applied,
    )  # fmt: skip
    seen = reference(view)
    for k in range(len(outputs)):
        out[k] = output_value(outputs[k], seen)
        if outputs[k].jitter:
            out[k] -= point_value(outputs[k], ideal.pose, ideal.vel, ideal.acc)
    return True


@kernel
def _refine(
    equations: Equations,
    ideal: Ideal,
    needs: tuple[bool, bool, bool],
    outputs: Records,
    k: int,
    sign: float,
    s: Stepper,
    tolerance: Array,
    steps: Steps,
    bracket: Array,
    y: Array,
    row: Array,
) -> tuple[float, float]:
    """Largest sign * output k within a bracket: times and signed values of three points, the middle one highest."""
    a, b, c = bracket[0], bracket[1], bracket[2]
    fa, fb, fc = bracket[3], bracket[4], bracket[5]
    for _ in range(_ROUNDS):
        t, _ = parabola_top(a, b, c, fa, fb, fc)
        t = min(max(t, a + _INSIDE * (b - a)), c - _INSIDE * (c - b))
        if abs(t - b) < 1e-5 * (c - a):
            break
        replay(equations, s, tolerance, steps, t, y)
        if not _look(equations, ideal, needs, outputs, t, row):
            break
        f = sign * row[k]
        gain = abs(f - fb)
        if f > fb:
            if t < b:
                c, fc = b, fb
            else:
                a, fa = b, fb
            b, fb = t, f
        elif t < b:
            a, fa = t, f
        else:
            c, fc = t, f
        if gain <= _FLAT * abs(fb):
            break
    return b, fb


@kernel
def summarise(
    equations: Equations,
    stepper: Stepper,
    ideal: Ideal,
    outputs: Records,
    tolerance: Array,
    steps: Steps,
    windows: Array,
    out: Array,
) -> bool:
    """Fill `STATISTICS` (nw, no, ns) of a run; returns False if the ideal linkage does not close.

    Parameters
    ----------
    tolerance : (ny,) array
        Tolerance of each entry of the state, for the steps between the run's own.
    windows : (nw, 2) array
        Times [s].
    """
    p, s, beside, past = reference(equations), reference(stepper), reference(ideal), reference(steps)
    grid, states = past.times, past.states
    nt, n, no = len(grid), states.shape[1], len(outputs)
    y, row, bracket = np.empty(n), np.empty(no), np.empty(6)
    needs = _needs(outputs)
    table = np.empty((nt, no))
    for i in range(nt):
        remember(p, past, i)
        solve(p, grid[i], states[i])
        if not _look(p, beside, needs, outputs, grid[i], table[i]):
            return False
    for m in range(len(windows)):
        t0, t1 = windows[m, 0], windows[m, 1]
        first, last = np.searchsorted(grid, t0), np.searchsorted(grid, t1, side="right")
        size = last - first + 4
        times, values = np.empty(size), np.empty((size, no))
        count = 0
        if first == last or grid[first] > t0:
            replay(p, s, tolerance, past, t0, y)
            if not _look(p, beside, needs, outputs, t0, values[0]):
                return False
            times[0] = t0
            count = 1
        for i in range(first, last):
            if count and grid[i] == times[count - 1]:  # an event without a step: what follows it counts
                count -= 1
            times[count] = grid[i]
            copy(table[i], values[count])
            count += 1
        if times[count - 1] < t1:
            replay(p, s, tolerance, past, t1, y)
            if not _look(p, beside, needs, outputs, t1, values[count]):
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
                replay(p, s, tolerance, past, times[place], y)
                if not _look(p, beside, needs, outputs, times[place], values[place]):
                    return False
        for k in range(no):
            for side in range(2):
                sign = -1.0 if side == 0 else 1.0
                best, when = -np.inf, t0
                for i in range(count):
                    if sign * values[i, k] > best:
                        best, when = sign * values[i, k], times[i]
                floor = best
                tried = np.zeros(count, np.bool_)
                for _ in range(_CANDIDATES):
                    i = _candidate(times[:count], values[:count, k], tried, sign, floor)
                    if i < 0:
                        break
                    left = min(max(i - 1, 0), count - 3)
                    for j in range(3):
                        bracket[j] = times[left + j]
                        bracket[3 + j] = sign * values[left + j, k]
                    if i in (0, count - 1):
                        tried[i] = True
                        if not _turn(
                            p, beside, needs, outputs, k, sign, s, tolerance, past, bracket, y, row
                        ):  # fmt: skip
                            continue
                    t, f = _refine(
                        p, beside, needs, outputs, k, sign, s, tolerance, past, bracket, y,
                        row,
                    )  # fmt: skip
                    if f > best:
                        best, when = f, t
                    if best <= floor and t == times[i]:
                        break
                    floor = max(best, floor)
                    tried[i] = True
                out[m, k, side] = sign * best
                out[m, k, 2 + side] = when
    return True


@kernel
def _turn(
    equations: Equations,
    ideal: Ideal,
    needs: tuple[bool, bool, bool],
    outputs: Records,
    k: int,
    sign: float,
    s: Stepper,
    tolerance: Array,
    steps: Steps,
    bracket: Array,
    y: Array,
    row: Array,
) -> bool:
    """Narrow a bracket whose highest point is at an end to one whose middle is highest; False if there is none."""
    t, _ = parabola_top(bracket[0], bracket[1], bracket[2], bracket[3], bracket[4], bracket[5])
    replay(equations, s, tolerance, steps, t, y)
    if not _look(equations, ideal, needs, outputs, t, row):
        return False
    f = sign * row[k]
    if f <= max(bracket[3], bracket[5]):
        return False
    if t < bracket[1]:
        bracket[2], bracket[5] = bracket[1], bracket[4]
    else:
        bracket[0], bracket[3] = bracket[1], bracket[4]
    bracket[1], bracket[4] = t, f
    return True


@kernel
def _candidate(times: Array, values: Array, tried: NDArray[np.bool_], sign: float, floor: float) -> int:
    """Sample at a local maximum whose parabola rises highest within it, and above the floor; -1 if there is none."""
    which, highest, n = -1, floor, len(times)
    for i in range(n):
        left = min(max(i - 1, 0), n - 3)
        if tried[i] or left < 0:
            continue
        fa, fb, fc = sign * values[left], sign * values[left + 1], sign * values[left + 2]
        if sign * values[i] < max(fa, fb, fc):
            continue
        t, top = parabola_top(times[left], times[left + 1], times[left + 2], fa, fb, fc)
        if top > highest and times[left] < t < times[left + 2]:
            which, highest = i, top
    return which


@kernel
def _averages(times: Array, values: Array, out: Array) -> None:
    """Fill ``out`` with the statistics after the extremes, by parabolas through three neighbouring samples."""
    n = len(times)
    span = times[n - 1] - times[0]
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
