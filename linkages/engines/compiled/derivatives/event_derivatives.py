"""The start and the end of a contact, differentiated: their times, the contact's memory, jumps of derivatives."""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, kernel
from linkages.engines.compiled.derivatives.contact_changes import Contacts, gap_laws, note_contacts, result_change
from linkages.engines.compiled.derivatives.step_derivatives import Column, Run, linearise
from linkages.engines.compiled.derivatives.variation import Variation
from linkages.engines.compiled.run.equations import derivatives, set_state
from linkages.engines.compiled.run.model import Equations
from linkages.laws.contact.contact_forces import GRAZING
from linkages.mechanics.integrate.factor import back_substitute, factorise
from linkages.mechanics.integrate.stepper import copy
from linkages.mechanics.planar.contact_partials import (
    APPROACHING,
    DELTA,
    DEPTH_FROM,
    DEPTH_TO,
    INPUTS,
    LEAST,
    MOTION,
    OUTPUTS,
    deeper,
)
from linkages.mechanics.planar.contact_partials import CLOSING as CLOSES
from linkages.mechanics.planar.contacts import APPROACH, BRISTLE, CLOSING, PENETRATION, contact_action, contact_motion

_MILD = 1e-5  # turn of the fastest body between the states that give rates of contacts [rad]


@kernel
def motions_along(equations: Equations, variation: Variation, c: Column, first: int) -> None:
    """Fill ``along`` with the changes of the contacts' inputs along the columns ``before`` from the first one on.

    The last np columns change with a value each. The equations have been linearised at the state.
    """
    columns, s = c.before, c.contacts
    model, motions, n = equations.model, equations.work.scratch.motions, len(equations.model.free)
    m = columns.shape[1]
    for j in range(first, m):
        p = j - (m - len(variation.unit))
        s.along[j] = 0.0
        for k in range(len(model.ends)):
            for i in range(MOTION):
                total = s.moved[p, k, i] if p >= 0 else 0.0
                for row in range(2 * n):
                    total += motions[k, i, row] * columns[row, j]
                s.along[j, k, i] = total
            s.along[j, k, APPROACHING] = c.remembered[k, j]
        for k in range(len(model.bristles)):
            s.along[j, model.bristles[k], INPUTS - 1] = columns[2 * n + k, j]


@kernel
def _motions_over_time(equations: Equations, t: float, y: Array, rate: float, c: Column, out: Array) -> None:
    """Fill ``out`` (nc, CHANGES) with the rates of the contacts' motions at a state with the derivatives ``dy``."""
    model, work = equations.model, equations.work
    fastest = rate
    for i in range(len(work.dynamics.vel)):
        fastest = max(fastest, abs(work.dynamics.vel[i, 0]))
    h = _MILD / fastest
    out[:] = 0.0
    for side in (-1.0, 1.0):
        for i in range(len(y)):
            c.y[i] = y[i] + side * h * c.dy[i]
        set_state(model, work, t + side * h, c.y)
        for k in range(len(model.ends)):
            motion, _ = contact_motion(model.ends[k], work.dynamics.pose, work.dynamics.vel)
            for i in range(MOTION):
                out[k, i] += side * motion[i] / (2.0 * h)


@kernel
def begin_or_end(run: Run, t: float, y: Array, k: int, begins: bool, approach: float, c: Column, times: Array) -> bool:
    """Take the columns through the start or end of contact k; fill the derivatives of its time.

    A new contact remembers the approach speed at its start. Where its force or the rate of its bristles jumps, the
    columns jump by the difference of the derivatives times the change of the time. Returns False where a contact begins
    without speed: its existence then depends on the values.
    """
    equations, variation, s, n = run.equations, run.variation, c.contacts, len(y)
    work, m, clearance = equations.work, c.before.shape[1], equations.model.laws[k].clearance
    c.ended[0] = math.nan
    if begins:
        work.memory[k, APPROACH] = approach
        work.solved[0] = math.nan
    derivatives(equations, t, y, c.dy)
    note_contacts(equations, s)
    closing, late = work.contacts[k, CLOSING], work.contacts[k, PENETRATION] / work.contacts[k, CLOSING]
    if begins and closing <= GRAZING:
        return False
    if begins:  # the rates before the contact, whose force may jump
        back = late + max(late, LEAST * clearance / closing)
        for i in range(n):
            c.y[i] = y[i] - back * c.dy[i]
        derivatives(equations, t - back, c.y, c.dy)
    _motions_over_time(equations, t, y, run.rate, c, s.along[0])
    copy(y, c.y)
    bounds, forcing, accelerating = work.scratch.bounds[k], np.zeros((len(c.own), m)), 0.0
    for acts in range(2):  # the state is a little beyond the event: the new forces act for that time already
        bounds[DEPTH_FROM], bounds[DEPTH_TO] = (0.0, math.inf) if acts else (-math.inf, 0.0)
        linearise(equations, variation, t, c, 0)
        if not acts:
            accelerating = result_change(equations, s, -1, 0, k, CLOSES)
        motions_along(equations, variation, c, 0)
        weight = late if begins == (acts == 1) else -late
        for j in range(m):
            p = j - (m - len(variation.unit))
            for i in range(OUTPUTS):
                change = weight * result_change(equations, s, p, j, k, i)
                for row in range(len(forcing)):
                    forcing[row, j] += change * s.response[k, i, row]
    if not factorise(c.mass[0], c.pivots):
        return False
    gap_laws(equations, variation, s)
    for j in range(m):
        p = j - (m - len(variation.unit))
        times[j] = -result_change(equations, s, p, j, k, DELTA) / closing
        if begins:
            c.remembered[k, j] = result_change(equations, s, p, j, k, CLOSES) + accelerating * times[j]
    _set_jump(equations, k, s)
    for j in range(m):
        for row in range(len(c.own)):
            c.own[row] = forcing[row, j]
            for i in range(OUTPUTS):
                c.own[row] -= s.found[i] * s.response[k, i, row] * times[j]
        back_substitute(c.mass[0], c.pivots, c.own)
        for i in range(len(c.own)):
            c.before[n - len(c.own) + i, j] += c.own[i]
    return True


@kernel
def _set_jump(equations: Equations, k: int, s: Contacts) -> None:
    """Fill ``found`` with the jump of contact k's action at its start or end, extrapolated to zero penetration."""
    model, work = equations.model, equations.work
    end, law, table, own = model.ends[k], model.laws[k], model.tables[k], work.memory[k]
    a, beyond = s.motion[k], s.force[k, DELTA]
    depth = math.copysign(max(abs(beyond), LEAST * law.clearance), beyond)
    motion = (a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7])
    s.found[:] = 0.0
    for place, weight in ((1.0, 2.0), (2.0, -1.0), (-1.0, -2.0), (-2.0, 1.0)):
        moved = deeper(end, motion, place * depth - beyond)
        found = contact_action(end, law, table, own[APPROACH], own[BRISTLE], moved)
        for i in range(OUTPUTS):
            s.found[i] += weight * found[i]
