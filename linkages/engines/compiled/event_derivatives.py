"""The start and the end of a contact, differentiated: their times, the contact's memory, jumps of derivatives."""

from __future__ import annotations

import math

from linkages.engines.compiled.contact_changes import ContactState, gap_change, law_change, note_contacts, value_motions
from linkages.engines.compiled.equations import derivatives, set_state, solve_state
from linkages.engines.compiled.forcing import force_response
from linkages.engines.compiled.jacobian import exact_jacobian
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.step_derivatives import Column
from linkages.engines.compiled.variation import Variation
from linkages.integrate.factor import back_substitute, factorise
from linkages.kernel import Array, clear, kernel
from linkages.laws.contact.contact_forces import GRAZING
from linkages.planar.contact_partials import CHANGES, DEPTH_FROM, DEPTH_TO, INPUTS, LEAST, MOTION, OUTPUTS, deeper
from linkages.planar.contacts import APPROACH, BRISTLE, CLOSING, PENETRATION, contact_action

_MILD = 1e-5  # turn of the fastest body between the states that give rates of contacts [rad]
#: Indices of the results of a contact, see `linkages.planar.contacts.contact_action`.
_DELTA, _CLOSING = 4, 5


@kernel
def motions_along(
    equations: Equations, variation: Variation, t: float, y: Array, columns: Array, first: int, out: Array
) -> None:
    """Fill ``out`` (m, nc, CHANGES) with the changes of the contacts' motions along columns from the first one on.

    The last np columns change with a value each. The equations have been linearised at (t, y).
    """
    model, motions, n = equations.model, equations.work.scratch.motions, len(equations.model.free)
    m, np_ = columns.shape[1], len(variation.unit)
    for j in range(first, m):
        clear(out[j])
        if j >= m - np_:
            value_motions(equations, variation, j - (m - np_), t, y, out[j])
        for k in range(len(model.bristles)):
            out[j, model.bristles[k], INPUTS - 1] += columns[2 * n + k, j]
        for k in range(len(model.ends)):
            for i in range(MOTION):
                for row in range(2 * n):
                    out[j, k, i] += motions[k, i, row] * columns[row, j]


@kernel
def _motions_over_time(equations: Equations, t: float, y: Array, c: Column, rate: float) -> None:
    """Fill the first of ``direction`` with the rates of the contacts' motions at a state; ``dy`` is filled."""
    model, work = equations.model, equations.work
    fastest = rate
    for i in range(len(work.dynamics.vel)):
        fastest = max(fastest, abs(work.dynamics.vel[i, 0]))
    h = _MILD / fastest
    along = c.direction[0]
    clear(along)
    for side in (-1.0, 1.0):
        for i in range(len(y)):
            c.y[i] = y[i] + side * h * c.dy[i]
        set_state(model, work, t + side * h, c.y)
        note_contacts(equations, c.contacts)
        for k in range(len(model.ends)):
            for i in range(INPUTS - 1):
                along[k, i] += side * c.contacts.motion[k, i] / (2.0 * h)


@kernel
def begin_or_end(
    equations: Equations, variation: Variation, t: float, y: Array, k: int, begins: bool, approach: float, rate: float,
    c: Column, times: Array,
) -> bool:  # fmt: skip
    """Take the columns through the start or end of contact k; fill the derivatives of its time.

    A new contact remembers the approach speed at its start. Where its force or the rate of its bristles jumps, the
    columns jump by the difference of the derivatives times the change of the time. Returns False where a contact begins
    without speed: its existence then depends on the values.
    """
    work, m, s, n = equations.work, c.before.shape[1], c.contacts, len(y)
    c.ended[0] = math.nan
    rates, bounds = c.dy[n - c.mass.shape[1] :], equations.work.scratch.bounds[k]
    if begins:
        work.memory[k, APPROACH] = approach
        work.solved[0] = math.nan
    derivatives(equations, t, y, c.dy)
    closing, late = work.contacts[k, CLOSING], work.contacts[k, PENETRATION] / work.contacts[k, CLOSING]
    if begins and closing <= GRAZING:
        return False
    if begins:  # the rates before the contact, whose force may jump
        back = late + max(late, LEAST * equations.model.laws[k].clearance / closing)
        for i in range(n):
            c.y[i] = y[i] - back * c.dy[i]
        derivatives(equations, t - back, c.y, c.dy)
    _motions_over_time(equations, t, y, c, rate)
    exact_jacobian(equations, t, y, c.mass[0], c.full)
    solve_state(equations, t, y)
    if not factorise(c.mass[0], c.pivots):
        return False
    note_contacts(equations, s)
    clear(s.change)
    for i in range(INPUTS - 1):
        s.change[i] = c.direction[0, k, i]
    gap_change(equations, variation, -1, k, s)
    accelerating = s.found[_CLOSING]
    motions_along(equations, variation, t, y, c.before, 0, c.direction)
    for j in range(m):
        p = j - (m - len(variation.unit))
        for i in range(CHANGES):
            s.change[i] = c.direction[j, k, i]
        clear(s.direct)
        for new in range(2):  # the state is a little beyond the event: the new forces act for that time already
            bounds[DEPTH_FROM], bounds[DEPTH_TO] = (0.0, math.inf) if begins == (new == 1) else (-math.inf, 0.0)
            law_change(equations, variation, p, k, s)
            for i in range(OUTPUTS):
                s.direct[k, i] += late * (s.found[i] if new else -s.found[i])
        gap_change(equations, variation, p, k, s)
        times[j] = -s.found[_DELTA] / closing
        if begins:
            c.remembered[k, j] = s.found[_CLOSING] + accelerating * times[j]
        _add_response(equations, variation, t, y, rates, c, j)
    clear(s.direct)
    _jump(equations, k, s)
    force_response(equations, variation, t, y, rates, s, c.own)
    back_substitute(c.mass[0], c.pivots, c.own)
    for j in range(m):
        for i in range(len(c.own)):
            c.before[n - len(c.own) + i, j] -= c.own[i] * times[j]
    return True


@kernel
def _add_response(
    equations: Equations, variation: Variation, t: float, y: Array, rates: Array, c: Column, j: int
) -> None:
    """Add the response of the accelerations to the forces ``direct`` to column j."""
    force_response(equations, variation, t, y, rates, c.contacts, c.own)
    back_substitute(c.mass[0], c.pivots, c.own)
    for i in range(len(c.own)):
        c.before[len(y) - len(c.own) + i, j] += c.own[i]


@kernel
def _jump(equations: Equations, k: int, s: ContactState) -> None:
    """Fill ``direct`` with the jump of contact k's action at its start or end, extrapolated to zero penetration."""
    model, work = equations.model, equations.work
    end, law, table, own = model.ends[k], model.laws[k], model.tables[k], work.memory[k]
    a, beyond = s.motion[k], work.contacts[k, PENETRATION]
    depth = math.copysign(max(abs(beyond), LEAST * law.clearance), beyond)
    motion = (a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7])
    for i in range(OUTPUTS):
        s.direct[k, i] = 0.0
    for place, weight in ((1.0, 2.0), (2.0, -1.0), (-1.0, -2.0), (-2.0, 1.0)):
        moved = deeper(end, motion, place * depth - beyond)
        found = contact_action(end, law, table, own[APPROACH], own[BRISTLE], moved)
        for i in range(OUTPUTS):
            s.direct[k, i] += weight * found[i]
