"""The steps of a finished run, differentiated: columns of derivatives of the state, and of what contacts remember.

Each step is repeated from the recorded state, to a smaller residual, and its equations are differentiated at the stages
(`linkages.integrate.sensitivity`). The sizes of the steps are fixed. The time of an event depends on
the values, and what the contact remembers depends on that time.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.equations import derivatives, set_state, solve_state
from linkages.engines.compiled.forcing import (
    ContactState,
    approach_forcing,
    force_response,
    law_change,
    make_contact_state,
    note_contacts,
    note_partials,
    value_forcing,
    value_motions,
)
from linkages.engines.compiled.jacobian import contact_inputs, exact_jacobian
from linkages.engines.compiled.kinks import Kinked, make_kinked, set_bounds, set_sides, shortened
from linkages.engines.compiled.methods import attempt
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.replay import Steps, around, remember
from linkages.engines.compiled.variation import Variation, move
from linkages.integrate.factor import back_substitute, factorise
from linkages.integrate.implicit import set_last_step
from linkages.integrate.sensitivity import collocation_sensitivity, explicit_sensitivity
from linkages.integrate.stepper import Stepper, copy, restart
from linkages.integrate.tableau import DORMAND_PRINCE_5_4, RADAU_IIA_5
from linkages.kernel import Array, Indices, clear, kernel
from linkages.kernel.simd import lane
from linkages.laws.contact.contact_forces import GRAZING
from linkages.planar.closure_rows import row_rate, row_value
from linkages.planar.contact_partials import CHANGES, INPUTS, OUTPUTS
from linkages.planar.contacts import APPROACH, BRISTLE, CLOSING, PENETRATION, contact_action
from linkages.planar.projection import correct
from linkages.planar.record_types import CORNER, STOP
from linkages.planar.tangent import body_tangents, rate_tangents

_MOST = 1000  # attempts within one step
_MILD = 1e-5  # step of central differences of closure rows [rad, or parts of the linkage's length]
#: Indices of the results of a contact, see `linkages.planar.contacts.contact_action`.
_DELTA, _CLOSING = 4, 5
#: Status of the columns after a step: known; not known, because a step was singular or Newton's method failed; not
#: known, because a contact began without speed.
KNOWN, SINGULAR, GRAZED = 0, 1, 2

_collocation = collocation_sensitivity(RADAU_IIA_5)
_explicit = explicit_sensitivity(DORMAND_PRINCE_5_4)
_RADAU_C = RADAU_IIA_5.c
_PAIR_A, _PAIR_C = DORMAND_PRINCE_5_4.a, DORMAND_PRINCE_5_4.c


class Column(NamedTuple):
    """Arrays of a differentiated run: ny entries of the state, nc contacts, m columns, the last np along values."""

    before: Array  # columns at the start of a step, (ny, m)
    after: Array  # at its end
    remembered: Array  # derivatives of the contacts' approach speeds, (nc, m)
    mass: Array  # at the stages, (s, k, k)
    jacobian: Array  # (s, k, ny)
    forcing: Array  # (s, k, m)
    full: Array  # Jacobian of all entries, (ny, ny)
    y: Array  # state at a stage, (ny,)
    dy: Array
    own: Array  # (k,)
    direction: Array  # changes of the contacts' motions along a column, (nc, CHANGES)
    contacts: ContactState
    kinked: Kinked


def make_column(ny: int, k: int, nc: int, m: int, implicit: bool) -> Column:
    """Make the arrays for ny entries of the state, k of them rates and others, nc contacts and m columns."""
    stages = 3 if implicit else 6
    return Column(
        np.zeros((ny, m)), np.zeros((ny, m)), np.zeros((nc, m)), np.zeros((stages, k, k)), np.zeros((stages, k, ny)),
        np.zeros((stages, k, m)), np.zeros((ny, ny)), np.zeros(ny), np.zeros(ny), np.zeros(k), np.zeros((nc, CHANGES)),
        make_contact_state(nc, k), make_kinked(nc),
    )  # fmt: skip


@kernel
def _linearise(equations: Equations, variation: Variation, t: float, c: Column, stage: int) -> None:
    """Fill mass, Jacobian and forcing of a stage, at the state ``y`` at time t."""
    np_, m, k = len(variation.unit), c.before.shape[1], c.mass.shape[1]
    n = len(c.y)
    derivatives(equations, t, c.y, c.dy)
    note_contacts(equations, c.contacts)
    exact_jacobian(equations, t, c.y, c.mass[stage], c.full)
    note_partials(equations, c.contacts)
    rates, forcing = c.dy[n - k :], c.forcing[stage]
    for i in range(k):
        for j in range(n):
            c.jacobian[stage, i, j] = c.full[n - k + i, j]
        for j in range(m):
            forcing[i, j] = 0.0
    for contact in range(c.remembered.shape[0]):
        if approach_forcing(equations, variation, contact, t, c.y, rates, c.contacts, c.own):
            for j in range(m):
                for i in range(k):
                    forcing[i, j] += c.own[i] * c.remembered[contact, j]
    for p in range(np_):
        value_forcing(equations, variation, p, t, c.y, rates, c.contacts, c.own)
        for i in range(k):
            forcing[i, m - np_ + p] += c.own[i]


@kernel
def _attempted(equations: Equations, variation: Variation, s: Stepper, t: float, h: float, y: Array, c: Column) -> bool:
    """Differentiate the step that has been attempted from (t, y); fill ``after``."""
    n = len(y)
    if equations.implicit:
        for stage in range(3):
            for i in range(n):
                c.y[i] = y[i] + lane(s.z[i], stage)
            _linearise(equations, variation, t + _RADAU_C[stage] * h, c, stage)
        return _collocation(h, c.mass, c.jacobian, c.forcing, c.before, c.after)
    for stage in range(len(_PAIR_C)):
        for i in range(n):
            total = 0.0
            for j in range(stage):
                total += _PAIR_A[stage, j] * s.stages[j, i]
            c.y[i] = y[i] + h * total
        _linearise(equations, variation, t + _PAIR_C[stage] * h, c, stage)
    return _explicit(h, c.mass, c.jacobian, c.forcing, c.before, c.after)


@kernel
def advance(
    equations: Equations, variation: Variation, s: Stepper, tolerance: Array, steps: Steps, k: int, t: float,
    limits: Array, c: Column,
) -> bool:  # fmt: skip
    """Take the columns ``before`` from the start of step k to time t within it; False if they cannot be had.

    The step is divided at kinks.
    """
    start = steps.times[k]
    remember(equations, steps, k)
    if not t > start:
        return True
    points, y = around(steps.times, k), steps.states[k].copy()
    copy(tolerance, s.scale)
    restart(s)
    now, h, attempts = start, t - start, 0
    while now + h > now and attempts < _MOST:
        attempts += 1
        derivatives(equations, now, y, s.f0)
        set_last_step(s, now, steps.times[k + 1] - start, steps.times, steps.states, points)
        error, _ = attempt(equations, s, now, h, y, True)
        if not error <= 1.0:  # Newton's method did not converge over so long a step
            h *= 0.5
            continue
        if len(limits):
            set_sides(equations, s, now, h, y, limits, c.kinked)
            set_bounds(limits, c.kinked, equations.work.scratch.bounds)
            h = shortened(equations, s, now, h, y, limits, c.kinked)
            if h < 0.0:
                return False
        if not _attempted(equations, variation, s, now, h, y, c):
            return False
        for i in range(len(y)):
            copy(c.after[i], c.before[i])
        copy(s.new, y)
        now = now + h if h < t - now else t
        h = t - now
        if h > 0.0:
            restart(s)
    return not now < t


@kernel
def _difference_step(equations: Equations, variation: Variation, p: int, c: Column, j: int) -> float:
    """Step of central differences along column j, and value p unless it is -1."""
    model = equations.model
    worst = 1.0 / variation.unit[p] if p >= 0 else 0.0
    for i in range(len(model.free)):
        worst = max(worst, abs(c.before[i, j]) / min(1.0, model.size))
    return _MILD / worst if worst > 0.0 else 1.0


@kernel
def _close_columns(equations: Equations, variation: Variation, t: float, y: Array, c: Column) -> None:
    """Project the columns ``before`` of a closed state onto the linearised closure, as the run projects states."""
    model, w = equations.model, equations.work.dynamics
    n, m, nr = len(model.free), c.before.shape[1], len(model.rows)
    moved, at = variation.equations.model, variation.equations.work.dynamics
    x = np.zeros(len(w.q))
    for j in range(m):
        p = j - (m - len(variation.unit))
        h = _difference_step(equations, variation, p, c, j)
        for rates in range(2):
            clear(w.row_error)
            for side in (-1.0, 1.0):
                if p >= 0:
                    move(variation, p, side * h)
                for i in range(len(y)):
                    c.y[i] = y[i] + side * h * c.before[i, j]
                set_state(moved, variation.equations.work, t, c.y)
                for r in range(nr):
                    row = moved.rows[r]
                    value = row_rate(row, at.pose, at.vel) if rates else row_value(row, at.pose)
                    w.row_error[r] -= side * value / (2.0 * h)
            clear(x)
            correct(model.stiff, model.rows, model.rank, w, x)
            for i in range(n):
                c.before[i + rates * n, j] += x[model.free[i]]
        if p >= 0:
            move(variation, p, 0.0)
    equations.work.solved[0] = math.nan


@kernel
def motions_along(
    equations: Equations, variation: Variation, p: int, t: float, y: Array, column: Array, out: Array
) -> None:
    """Fill ``out`` (nc, CHANGES) with the changes of the contacts' motions along a column, and value p unless it is -1.

    The equations are solved at (t, y).
    """
    model, w, s, n = equations.model, equations.work.dynamics, equations.work.scratch, len(equations.model.free)
    clear(out)
    if p >= 0:
        value_motions(variation, p, t, y, out)
    for rates in range(2):
        for i in range(n):
            s.changed[model.free[i]], s.dq[model.free[i]] = 1.0, column[i + rates * n]
        body_tangents(model.bodies, w, s)
        if rates:
            rate_tangents(model.bodies, s)
        for k in range(len(model.ends)):
            inputs = contact_inputs(model, w, s, k)
            for i in range(INPUTS - 1):
                out[k, i] += lane(inputs[i], 0)
    for i in range(n):
        s.changed[model.free[i]], s.dq[model.free[i]] = 0.0, 0.0
    for m in range(len(model.bristles)):
        out[model.bristles[m], INPUTS - 1] += column[2 * n + m]


@kernel
def _motions_over_time(equations: Equations, t: float, y: Array, c: Column, rate: float) -> None:
    """Fill ``direction`` with the rates of the contacts' motions at a state with the derivatives ``dy``."""
    model, work = equations.model, equations.work
    fastest = rate
    for i in range(len(work.dynamics.vel)):
        fastest = max(fastest, abs(work.dynamics.vel[i, 0]))
    h = _MILD / fastest
    clear(c.direction)
    for side in (-1.0, 1.0):
        for i in range(len(y)):
            c.y[i] = y[i] + side * h * c.dy[i]
        set_state(model, work, t + side * h, c.y)
        note_contacts(equations, c.contacts)
        for k in range(len(model.ends)):
            for i in range(INPUTS - 1):
                c.direction[k, i] += side * c.contacts.motion[k, i] / (2.0 * h)


@kernel
def _begin_or_end(
    equations: Equations, variation: Variation, t: float, y: Array, k: int, begins: bool, approach: float, rate: float,
    gap: float, c: Column, times: Array,
) -> bool:  # fmt: skip
    """Take the columns through the start or end of contact k; fill the derivatives of its time.

    The contact still remembers what held before. A new contact remembers the approach speed at its start. Where its
    force jumps, the columns jump by the difference of the derivatives times the change of the time. Returns False
    where a contact begins without speed: its existence then depends on the values.
    """
    work, m, s = equations.work, c.before.shape[1], c.contacts
    n = len(y)
    derivatives(equations, t, y, c.dy)
    closing = work.contacts[k, CLOSING]
    if begins and closing <= GRAZING:
        return False
    _motions_over_time(equations, t, y, c, rate)
    solve_state(equations, t, y)
    note_contacts(equations, s)
    clear(s.change)
    for i in range(INPUTS - 1):
        s.change[i] = c.direction[k, i]
    law_change(equations, variation, -1, k, s)
    accelerating = s.found[_CLOSING]
    for j in range(m):
        p = j - (m - len(variation.unit))
        motions_along(equations, variation, p, t, y, c.before[:, j].copy(), c.direction)
        for i in range(CHANGES):
            s.change[i] = c.direction[k, i]
        law_change(equations, variation, p, k, s)
        times[j] = -s.found[_DELTA] / closing
        if begins:
            c.remembered[k, j] = s.found[_CLOSING] + accelerating * times[j]
    if begins:
        work.memory[k, APPROACH] = approach
        clear(s.direct)
        _jump(equations, k, gap, s)
        force_response(equations, variation, t, y, c.dy[n - c.mass.shape[1] :], s, c.own)
        exact_jacobian(equations, t, y, c.mass[0], c.full)
        if not _add_jump(c, times):
            return False
        equations.work.solved[0] = math.nan
    return True


@kernel
def _jump(equations: Equations, k: int, gap: float, s: ContactState) -> None:
    """Fill ``direct`` with the force of contact k at its start less the force just outside."""
    model, work = equations.model, equations.work
    end = model.ends[k]
    own, law, table = work.memory[k], model.laws[k], model.tables[k]
    a, deep = s.motion[k], work.contacts[k, PENETRATION] + gap
    inside = contact_action(
        end, law, table, own[APPROACH], own[BRISTLE], (a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7])
    )
    if end.kind == CORNER:
        dx, dy, turn = a[6] * deep, a[7] * deep, 0.0
    elif end.kind == STOP:
        dx, dy, turn = 0.0, 0.0, end.nx * deep
    else:
        distance = math.hypot(a[0], a[1])
        dx, dy, turn = a[0] / distance * deep, a[1] / distance * deep, 0.0
    outside = contact_action(
        end, law, table, own[APPROACH], own[BRISTLE], (a[0] - dx, a[1] - dy, a[2], a[3], a[4], a[5], a[6], a[7] - turn)
    )
    for i in range(OUTPUTS):
        s.direct[k, i] = inside[i] - outside[i]


@kernel
def _add_jump(c: Column, times: Array) -> bool:
    """Subtract the jump of the derivatives, with the residual ``own``, times the changes of its time."""
    k, n = len(c.own), len(c.y)
    pivots = np.empty(k, np.int64)
    if not factorise(c.mass[0], pivots):
        return False
    back_substitute(c.mass[0], pivots, c.own)
    for j in range(len(times)):
        for i in range(k):
            c.before[n - k + i, j] -= c.own[i] * times[j]
    return True


@kernel
def differentiate_run(
    equations: Equations,
    variation: Variation,
    s: Stepper,
    tolerance: Array,
    steps: Steps,
    landing: Array,
    rate: float,
    limits: Array,
    c: Column,
    states: Array,
    memory: Array,
    event: Indices,
    times: Array,
) -> tuple[int, int]:
    """Differentiate a run.

    Parameters
    ----------
    landing : (nc,) array
        See `linkages.planar.contacts.landing`.
    rate : float
        Rate of the motion [rad/s].
    limits : (nc, KINKS) array
        See `linkages.engines.compiled.kinks.kinks`.
    c : Column
        With the columns at the start in ``before`` and ``remembered``.
    states, memory : (nt, ny, m), (nt, nc, m) arrays
        Filled with the columns after each step.
    event : (nt,) array of int
        Filled with the contact that begins (k + 1) or ends (-k - 1) at each time; 0 without.
    times : (nt, m) array
        Filled with the derivatives of the events' times.

    Returns
    -------
    status : int
    count : int
        Number of times at which the columns are known.
    """
    nt, nc, model, work = len(steps.times), steps.memory.shape[1], equations.model, equations.work
    deep = np.zeros(nc)
    for k in range(nt):
        t, y = steps.times[k], steps.states[k]
        remember(equations, steps, max(k - 1, 0))
        if k > 0 and not advance(equations, variation, s, tolerance, steps, k - 1, t, limits, c):
            return SINGULAR, k
        if k > 0 and len(model.rows):
            solve_state(equations, t, y)
            if not work.dynamics.interpolated[0] > 0.0:
                _close_columns(equations, variation, t, y, c)
        if nc:
            solve_state(equations, t, y)
        for i in range(nc):
            now = work.contacts[i, PENETRATION] if model.touching[i] else -1.0
            begins = now > 0.0 and (deep[i] <= 0.0 or steps.memory[k, i] != steps.memory[max(k - 1, 0), i])
            if k > 0 and (begins or (now < 0.0 < deep[i])):
                fine = _begin_or_end(
                    equations, variation, t, y, i, begins, steps.memory[k, i], rate, 2.0 * landing[i], c, times[k]
                )
                if not fine:
                    return GRAZED, k
                event[k] = i + 1 if begins else -i - 1
                solve_state(equations, t, y)
            deep[i] = now
        for i in range(len(c.before)):
            copy(c.before[i], states[k, i])
        for i in range(nc):
            copy(c.remembered[i], memory[k, i])
    return KNOWN, nt
