"""The start and the end of a contact, differentiated: their times, what the contact remembers, jumps of derivatives."""

from __future__ import annotations

import math

import numpy as np

from linkages.engines.compiled.equations import derivatives, set_state, solve_state
from linkages.engines.compiled.forcing import ContactState, force_response, law_change, note_contacts, value_motions
from linkages.engines.compiled.jacobian import contact_inputs, exact_jacobian
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.step_derivatives import Column
from linkages.engines.compiled.variation import Variation
from linkages.integrate.factor import back_substitute, factorise
from linkages.kernel import Array, clear, kernel
from linkages.kernel.simd import lane
from linkages.laws.contact.contact_forces import GRAZING
from linkages.planar.contact_partials import CHANGES, INPUTS, OUTPUTS
from linkages.planar.contacts import APPROACH, BRISTLE, CLOSING, PENETRATION, contact_action
from linkages.planar.record_types import CORNER, STOP
from linkages.planar.tangent import body_tangents, rate_tangents

_MILD = 1e-5  # turn of the fastest body between the states that give rates of contacts [rad]
#: Indices of the results of a contact, see `linkages.planar.contacts.contact_action`.
_DELTA, _CLOSING = 4, 5


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
def begin_or_end(
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
