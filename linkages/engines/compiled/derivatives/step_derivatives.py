"""A step of a finished run, differentiated: columns of derivatives of the state.

The equations of each step are differentiated at its stages (`linkages.mechanics.integrate.sensitivity`). The run has
recorded the stages; otherwise the step is repeated from the recorded state, to a smaller residual. The sizes of the
steps are fixed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, kernel
from linkages.base.kernel.dual import DIRECTIONS, slope
from linkages.base.kernel.simd import LaneArray as Lanes
from linkages.base.kernel.simd import lane, lane_array, lanes
from linkages.engines.compiled.derivatives.variation import Variation, fill_forcing, first_of, set_columns
from linkages.engines.compiled.run.equations import derivatives, found_derivatives, is_solved, solve_state
from linkages.engines.compiled.run.jacobian import jacobian
from linkages.engines.compiled.run.kinks import passed, set_bounds, set_sides, shortened
from linkages.engines.compiled.run.methods import attempt
from linkages.engines.compiled.run.model import Equations
from linkages.engines.compiled.run.replay import STAGES, Steps, around, remember
from linkages.laws.states import LATCHED
from linkages.mechanics.integrate.implicit import set_last_step
from linkages.mechanics.integrate.sensitivity import collocation_sensitivity, explicit_sensitivity
from linkages.mechanics.integrate.stepper import INVERTED, Stepper, copy, restart
from linkages.mechanics.integrate.tableau import DORMAND_PRINCE_5_4, RADAU_IIA_5
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.closure_rows import row_rate, row_value
from linkages.mechanics.planar.contact_memory import recorded
from linkages.mechanics.planar.contacts import PENETRATION
from linkages.mechanics.planar.loop_dynamics import correct

_MOST = 1000  # attempts within one step
_STEEP = 0.3  # ratio of the depths at the ends of a step below which the step is graded
_FINEST = 2.0**-12  # smallest part of a graded step
_TICK = 4e-16  # smallest part of any step, in parts of the time: shorter ones do not change it
_BACK = 4.0  # of the time by which a step has passed a formula's kink: where its last stage is before the kink
_NEAR_END = 3e-9  # depth at the start of its last part, in parts of the clearance: events are located to 1e-10

_collocation, _explicit = collocation_sensitivity(RADAU_IIA_5), explicit_sensitivity(DORMAND_PRINCE_5_4)
_RADAU_C, _PAIR_A, _PAIR_C = RADAU_IIA_5.c, DORMAND_PRINCE_5_4.a, DORMAND_PRINCE_5_4.c


class Run(NamedTuple):
    """A finished run, and what its derivatives need beside the columns."""

    equations: Equations
    variation: Variation
    stepper: Stepper
    tolerance: Array  # of each entry of the state, (ny,)
    steps: Steps
    kinks: Array  # see `linkages.engines.compiled.run.kinks.kinks`, (nc + nf, KINKS)
    start: Array  # state at t = 0, before the first samples, (ny,)
    depths: Array  # penetrations of the contacts that can touch, of others -1; (nt, nc), no rows if none can
    grade: float  # ratio of the depths at the ends of parts of a graded step


class Column(NamedTuple):
    """Arrays of a differentiated run: ny entries of the state, nl latched states, m columns, np along values."""

    before: Array  # columns at the start of a step, (ny, m)
    after: Array  # at its end
    rates: Array  # rates at its end of rates and others, by an implicit method, (k, m)
    remembered: Array  # derivatives of the contacts' latched states, (nl, m)
    mass: Array  # at the stages, (s, k, k)
    jacobian: Array  # (s, k, ny)
    forcing: Array  # (s, k, m)
    full: Array  # Jacobian of all entries, at the last stage, (ny, ny)
    ended: Array  # time of the last differentiated step's end, NaN without, (1,)
    y: Array  # state at a stage, (ny,)
    dy: Array
    own: Array  # (k,)
    pivots: Indices  # (k,)
    start: Lanes  # of some columns, to work in, (ny,)
    solved: Lanes  # (s ny,)


def make_column(ny: int, model: Arrays, m: int, implicit: bool) -> Column:
    """Make the arrays for ny entries of the state of a model and m columns."""
    k, nl, stages = ny - len(model.free), LATCHED * len(model.ends), len(_RADAU_C if implicit else _PAIR_C)
    shapes = (
        (ny, m), (ny, m), (k, m), (nl, m), (stages, k, k), (stages, k, ny), (stages, k, m),
        (ny, ny), (1,), (ny,), (ny,), (k,),
    )  # fmt: skip
    indices, in_lanes = np.zeros(k, np.int64), (lane_array(ny), lane_array(stages * ny))
    made = Column._make([*map(np.zeros, shapes), indices, *in_lanes])
    made.ended[0] = math.nan
    return made


@kernel
def _linearise(equations: Equations, variation: Variation, t: float, c: Column, stage: int) -> None:
    """Fill mass, Jacobian and forcing of a stage, at the state ``y`` at time t."""
    n, k, forcing = len(c.y), c.mass.shape[1], c.forcing[stage]
    if not is_solved(equations.work, t, c.y):
        solve_state(equations, t, c.y)
    found_derivatives(equations, c.y, c.dy)
    jacobian(equations, t, c.y, c.mass[stage], c.full)
    for i in range(k):
        copy(c.full[n - k + i], c.jacobian[stage, i])
    fill_forcing(equations, variation, t, c.y, c.dy[n - k :], c.remembered, forcing)


@kernel
def _attempted(
    equations: Equations, variation: Variation, s: Stepper, t: float, h: float, y: Array, c: Column, back: float
) -> bool:
    """Differentiate the step that has been attempted from (t, y), and take the columns through it.

    Its last stage is linearised a time ``back`` before its end, where this is just beyond a kink.
    """
    n, nodes = len(y), _RADAU_C if equations.implicit else _PAIR_C
    for stage in range(len(c.mass)):
        for i in range(n):
            c.y[i] = y[i]
            if equations.implicit:
                c.y[i] += lane(s.z[i], stage)
            else:
                for j in range(stage):
                    c.y[i] += h * _PAIR_A[stage, j] * s.stages[j, i]
        now = t + nodes[stage] * h
        if back > 0.0 and nodes[stage] == 1.0:
            derivatives(equations, now, c.y, c.dy)
            now -= back
            for i in range(n):
                c.y[i] -= back * c.dy[i]
        _linearise(equations, variation, now, c, stage)
    if equations.implicit:
        known = _collocation(h, c.mass, c.jacobian, c.forcing, c.before, c.after, c.rates, c.start, c.solved)
    else:
        known = _explicit(h, c.mass, c.jacobian, c.forcing, c.before, c.after, c.rates, c.start, c.solved)
    for i in range(n):
        copy(c.after[i], c.before[i])
    return known


@kernel(makes_arrays=True)
def advance(run: Run, c: Column, k: int, t: float, at_hand: bool = False) -> bool:
    """Take the columns ``before`` from the start of step k to time t within it; False if they cannot be had.

    The step is divided at kinks, and graded near the start and the end of a contact. A whole step whose stages were
    recorded is not repeated, nor a step to time t whose stages the stepper has ``at_hand``.
    """
    equations, variation, s, steps, limits = run.equations, run.variation, run.stepper, run.steps, run.kinks
    now = steps.times[k]
    remember(equations, steps, k)
    if not t > now:
        return True
    y = steps.states[k].copy()
    if not at_hand:
        copy(run.tolerance, s.scale)
        restart(s)
    size, points, end = steps.times[k + 1] - now, around(steps.times, k), steps.times[k + 1]
    first, last = _grades(equations, run.depths, k)
    recalled = at_hand or (not len(limits) and _recall(equations, steps, k, t, s))
    if equations.implicit and c.ended[0] == now and not recalled:
        _resume(s, c)
    least = _TICK * end
    h, attempts = t - now, 0
    while now + h > now and attempts < _MOST:
        attempts += 1
        if not recalled:
            h = min(h, max(first * size, (run.grade - 1.0) * (now - steps.times[k]), least))
            if last < 1.0:
                h = min(h, max(last * size, (1.0 - 1.0 / run.grade) * (end - now), least))
            derivatives(equations, now, y, s.f0)
            set_last_step(s, now, size, steps.times, steps.states, points)
            error, _ = attempt(equations, s, now, h, y, True)
            if not error <= 1.0:  # Newton's method did not converge over so long a step
                h *= 0.5
                continue
        recalled, back = False, 0.0
        if len(limits):
            set_sides(equations, s, now, h, y, limits)
            set_bounds(equations, limits)
            whole, sides = h, equations.work.kinked.sides.copy()
            h = shortened(equations, s, now, h, y, limits)
            if h < 0.0:
                return False
            back = _BACK * whole * passed(equations, sides)
        if not _attempted(equations, variation, s, now, h, y, c, back):
            return False
        copy(s.new, y)
        now = now + h if h < t - now else t
        h = t - now
        if h > 0.0:
            restart(s)
    if now < t:
        return False
    c.ended[0] = t
    return True


@kernel
def _recall(equations: Equations, steps: Steps, k: int, t: float, s: Stepper) -> bool:
    """Take the stages and the end of a whole step from the record of the run; False if it has none."""
    first = recorded(equations.work.memory)
    if t != steps.times[k + 1] or steps.memory.shape[1] == first:
        return False
    row = steps.memory[k + 1]
    copy(steps.states[k + 1], s.new)
    for i in range(steps.states.shape[1]):
        at = first + STAGES * i
        s.z[i] = lanes(row[at], row[at + 1], row[at + 2], 0.0)
    return True


@kernel
def _resume(s: Stepper, c: Column) -> None:
    """Use the Jacobian at the end of the step before; Newton's iterations get a new one if they fail."""
    last = len(c.mass) - 1
    for i in range(len(s.mass)):
        copy(c.mass[last, i], s.mass[i])
    for i in range(len(c.full)):
        copy(c.full[i], s.jacobian[i])
    s.memory[INVERTED] = -1.0  # of no step: the matrices are inverted


@kernel
def find_depths(equations: Equations, steps: Steps, out: Array) -> None:
    """Fill the penetrations of a run, see `Run`."""
    out[:] = -1.0
    for k in range(len(out)):
        solve_state(equations, steps.times[k], steps.states[k])
        for i in range(len(equations.model.ends)):
            if equations.model.touching[i]:
                out[k, i] = equations.work.contacts[i, PENETRATION]


@kernel
def _grades(equations: Equations, depths: Array, k: int) -> tuple[float, float]:
    """Return the sizes of the first and the last part of step k, in parts of it.

    The stiffness of a contact grows with a power of its depth, often the root. Parts within which the depth changes by
    no more than a factor of two or three resolve it; the run itself needs them less.
    """
    first, last = 1.0, 1.0
    for i in range(len(equations.model.ends) if len(depths) else 0):
        start, end = depths[k, i], depths[k + 1, i]
        if start > 0.0 and end < _STEEP * start:
            last = min(last, max(_NEAR_END * equations.model.laws[i].clearance / start, _FINEST))
        elif start > 0.0 and start < _STEEP * end:
            first = min(first, max(start / end, _FINEST))
    return first, last


@kernel(makes_arrays=True)
def close_columns(equations: Equations, variation: Variation, t: float, y: Array, c: Column) -> None:
    """Project the columns ``before`` of a closed state onto the linearised closure, as the run projects states."""
    model, w, duals, at = equations.model, equations.work.dynamics, variation.model, variation.work.dynamics
    n, nr, rows = len(model.free), len(model.rows), variation.work.rows
    x = np.zeros(len(w.q))
    for last in range(c.before.shape[1], 0, -DIRECTIONS):
        first = first_of(last)
        for rates in range(2):
            set_columns(equations, variation, t, y, c.before, c.remembered, first, last)
            for r in range(nr):
                rows[r] = row_rate(duals.rows[r], at.pose, at.vel) if rates else row_value(duals.rows[r], at.pose)
            for j in range(first, last):
                for r in range(nr):
                    w.row_error[r] = -slope(rows[r], j - first)
                x[:] = 0.0
                correct(model.stiff, model.rows, model.elimination, w, x)
                for i in range(n):
                    c.before[i + rates * n, j] += x[model.free[i]]
    equations.work.solved[0] = math.nan
