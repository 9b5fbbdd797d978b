"""Derivatives of the equations of motion with respect to values of the system and to what contacts remember.

The residual R(y, y') of `linkages.engines.compiled.run.equations.residual` has the derivative M df/dx with respect to
any value x, at a state with the derivatives y' = f(y). It is the central difference of R along the value at fixed y'
and at fixed forces of the contacts, plus the response of R to the changes of these forces: by their partial derivatives
with the changes of the contacts' motions, and by the changes of their laws. So no step closes a thin film.

Example: a journal of mass m in a film, m a = m g + F(e, c). Along the clearance c the difference vanishes, and dF/dc of
the law remains; along the position x of the bearing, e = q - x, so that dF = -F' dx; along m it is g - a.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, kernel
from linkages.engines.compiled.derivatives.contact_changes import Contacts, has_force, law_changes
from linkages.engines.compiled.derivatives.neighbours import PAIRS
from linkages.engines.compiled.derivatives.variation import ANY, INERTIAL, QUADRATIC, STILL, Variation, move
from linkages.engines.compiled.run.equations import rate_residuals, set_drive_forces, set_state
from linkages.engines.compiled.run.model import Equations
from linkages.mechanics.planar.contact_partials import APPROACHING, MOTION, OUTPUTS
from linkages.mechanics.planar.contacts import add_contact, contact_motion
from linkages.mechanics.planar.loads import load_wrenches
from linkages.mechanics.planar.newton_euler import generalised_force

_STEP = 1e-3  # of central differences, in parts of a value, or of 1 rad of a drive
#: Places of central differences; weights of the second order, exact for polynomials of that order; of the fourth one.
_PLACES = np.array(PAIRS[0])
_WEIGHTS = np.zeros((ANY + 1, 4))
_WEIGHTS[QUADRATIC], _WEIGHTS[ANY] = (-1 / 2, 1 / 2, 0.0, 0.0), PAIRS[1]


@kernel
def add_forcing(
    equations: Equations, variation: Variation, t: float, y: Array, dy: Array, s: Contacts, remembered: Array,
    out: Array,
) -> None:  # fmt: skip
    """Add the derivatives of the residual with respect to approach speeds and values to ``out`` (k, m).

    The equations are solved at (t, y) with the derivatives ``dy`` of rates and other entries, `note_contacts` and
    `exact_jacobian` have been called there. Columns of the values are the last ones of ``out`` and of the changes of
    the approach speeds, ``remembered`` (nc, m).
    """
    partials, m, count = equations.work.scratch.partials, out.shape[1], len(variation.unit)
    law_changes(equations, variation, s)
    _set_responses(equations, variation, t, y, dy, s)
    is_set = False
    for k in range(len(s.force)):
        for i in range(OUTPUTS):
            force = partials[k, i, APPROACHING]
            if force != 0.0:
                for row in range(len(out)):
                    for j in range(m):
                        out[row, j] += s.response[k, i, row] * force * remembered[k, j]
    for p in range(count):
        s.change[:] = 0.0
        if variation.effect[p] == INERTIAL:
            _set_inertial(variation, p, is_set, t, y, dy, s)
            is_set = True
        elif variation.effect[p] != STILL:
            _set_differences(equations, variation, p, t, y, dy, s)
            is_set = False
        for k in range(len(s.force)):
            for i in range(OUTPUTS):
                force = s.laws[p, k, i]
                for j in range(MOTION):
                    force += partials[k, i, j] * s.moved[p, k, j]
                if force != 0.0:
                    for row in range(len(out)):
                        s.change[row] += force * s.response[k, i, row]
        for row in range(len(out)):
            out[row, m - count + p] += s.change[row]


@kernel
def _set_differences(
    equations: Equations, variation: Variation, p: int, t: float, y: Array, dy: Array, s: Contacts
) -> None:
    """Fill ``change``, and the changes of motions and prescribed coordinates, with differences along value p."""
    model, work = variation.equations.model, variation.equations.work
    effect, w, far = variation.effect[p], work.dynamics, 1.0
    moved, driven = s.moved[p], s.driven[p]
    if effect == ANY:  # changes of a drive's speed grow with time
        for k in range(len(model.driven)):
            far = max(far, abs(equations.work.dynamics.q[model.driven[k]]))
    h = _STEP * variation.unit[p] / far
    moved[:] = 0.0
    driven[:] = 0.0
    for point in range(len(_PLACES)):
        weight = _WEIGHTS[effect, point] / h
        if weight == 0.0:
            continue
        move(variation, p, _PLACES[point] * h)
        _add_residual(variation, t, y, dy, s, weight, moved, s.change)
        for k in range(len(model.driven)):
            d = model.driven[k]
            driven[0, k] += weight * w.q[d]
            driven[1, k] += weight * w.v[d]
            driven[2, k] += weight * w.a[d]
    move(variation, p, 0.0)


@kernel
def _set_inertial(variation: Variation, p: int, is_set: bool, t: float, y: Array, dy: Array, s: Contacts) -> None:
    """Fill ``change`` with differences along value p, which moves nothing: the state may be set already."""
    model, work = variation.equations.model, variation.equations.work
    h = _STEP * variation.unit[p]
    if not is_set:
        _add_residual(variation, t, y, dy, s, 0.0, s.spare, s.change)
    for side in (1.0, -1.0):
        move(variation, p, side * h)
        work.dynamics.tau[:] = 0.0
        set_drive_forces(model, work, t)
        rate_residuals(model, work.dynamics, dy, s.row)
        for i in range(len(model.free)):
            s.change[i] += side * s.row[i] / (2.0 * h)
    move(variation, p, 0.0)


@kernel
def _add_residual(
    variation: Variation, t: float, y: Array, dy: Array, s: Contacts, weight: float, moved: Array, out: Array
) -> None:
    """Add the moved model's residual, with the forces of the contacts that are noted, times a weight to ``out``.

    Likewise the motions of the contacts to ``moved``.
    """
    model, work = variation.equations.model, variation.equations.work
    w, n = work.dynamics, len(model.free)
    set_state(model, work, t, y)
    w.wrench[:] = 0.0
    for k in range(len(model.ends)):
        motion, arms = contact_motion(model.ends[k], w.pose, w.vel)
        for i in range(MOTION):
            moved[k, i] += weight * motion[i]
        f = s.force[k]
        add_contact(w.wrench, model.ends[k], motion[0], motion[1], arms, f[0], f[1], f[2])
    if len(model.loads):
        tables = (model.loads, model.signals, model.load_t, model.load_c, model.load_n)
        load_wrenches(tables, t, w.pose, w.vel, w.wrench)
    rate_residuals(model, w, dy, s.row)
    for i in range(n):
        out[i] += weight * s.row[i]


@kernel
def _set_responses(equations: Equations, variation: Variation, t: float, y: Array, dy: Array, s: Contacts) -> None:
    """Fill ``response``: in a tree with generalised forces, else with the accelerations that a force gives."""
    model, work = variation.equations.model, variation.equations.work
    w, n, at = work.dynamics, len(model.free), equations.work.dynamics
    s.response[:] = 0.0
    for m in range(len(model.bristles)):
        s.response[model.bristles[m], OUTPUTS - 1, n + m] = 1.0
    for k in range(len(model.ends)):
        if not has_force(equations, k, s):
            continue
        _, arms = contact_motion(model.ends[k], at.pose, at.vel)
        for i in range(OUTPUTS - 1):
            if len(model.rows):  # linear in the force
                force, size = s.force[k, i], max(abs(s.force[k, i]), 1.0)
                for side in (1.0, -1.0):
                    s.force[k, i] = force + side * size
                    _add_residual(variation, t, y, dy, s, side / (2.0 * size), s.spare, s.response[k, i])
                s.force[k, i] = force
                continue
            w.wrench[:] = 0.0
            w.tau[:] = 0.0
            fx, fy, couple = 1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0
            add_contact(w.wrench, model.ends[k], s.motion[k, 0], s.motion[k, 1], arms, fx, fy, couple)
            generalised_force(model.bodies, at.pose, w.wrench, w.tau)
            for row in range(n):
                s.response[k, i, row] = w.tau[model.free[row]]
