"""Derivatives of the equations of motion with respect to values of the system and to what contacts remember.

The residual R(y, y') of `linkages.engines.compiled.equations.residual` has the derivative M df/dx with respect to any
value x, at a state with the derivatives y' = f(y). A value acts in two ways: on the laws of contacts
(`linkages.engines.compiled.contact_changes`), and on everything else, which is differentiated by central differences
with forces of contacts that do not follow their motions: a step of a length would otherwise close a thin film.
"""

from __future__ import annotations

import math

from linkages.engines.compiled.contact_changes import (
    MILD,
    MOTION,
    ContactState,
    far,
    is_fine,
    law_change,
    own_change,
    value_motions,
)
from linkages.engines.compiled.equations import rate_residuals, set_drive_forces, set_state
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.variation import Variation, changes_law, move
from linkages.integrate.stepper import copy
from linkages.kernel import Array, clear, kernel
from linkages.laws.contact.contact_forces import GRAZING
from linkages.planar.contact_partials import APPROACHING, FOURTH, OUTPUTS, PLACES, POINTS, SECOND, WEIGHTS
from linkages.planar.contacts import APPROACH, PENETRATION, add_contact, contact_motion
from linkages.planar.loads import load_wrenches
from linkages.planar.motion import evaluate_motions
from linkages.planar.newton_euler import generalised_force

_SHORT = 1e-5  # step of differences of drives, in parts of a value: phases grow with time


@kernel
def _copy_state(source: Equations, target: Equations, t: float) -> None:
    """Fill what `set_state` fills from equations that are solved at the state; forces of drives are the target's."""
    model, at, w = target.model, source.work.dynamics, target.work.dynamics
    target.work.solved[0] = math.nan
    copy(at.q, w.q)
    copy(at.v, w.v)
    copy(at.a, w.a)
    clear(w.tau)
    for i in range(len(at.pose)):
        copy(at.pose[i], w.pose[i])
        copy(at.vel[i], w.vel[i])
    set_drive_forces(model, target.work, t)


@kernel
def _fixed_residual(
    equations: Equations, t: float, y: Array, dy: Array, s: ContactState, amount: float, weight: float, out: Array
) -> None:
    """Fill ``out`` as `residual`, with the contacts' forces of ``s`` plus ``amount * direct``.

    The state is set. The contacts' motions are added to ``moved``, times a weight that is not zero.
    """
    model, work = equations.model, equations.work
    w, n = work.dynamics, len(model.free)
    clear(w.wrench)
    for k in range(len(model.ends)):
        motion, arms = contact_motion(model.ends[k], w.pose, w.vel)
        if weight != 0.0:
            for i in range(MOTION):
                s.moved[k, i] += weight * motion[i]
        for i in range(OUTPUTS):
            s.found[i] = s.force[k, i] + amount * s.direct[k, i]
        add_contact(w.wrench, model.ends[k], motion[0], motion[1], arms, s.found[0], s.found[1], s.found[2])
        for m in range(len(model.bristles)):
            if model.bristles[m] == k:
                out[n + m] = s.found[3] - dy[n + m]
    if len(model.loads):
        tables = (model.loads, model.signals, model.load_t, model.load_c, model.load_n)
        load_wrenches(tables, t, w.pose, w.vel, w.wrench)
    rate_residuals(model, w, dy, out)


@kernel
def force_response(
    equations: Equations, variation: Variation, t: float, y: Array, dy: Array, s: ContactState, out: Array
) -> None:
    """Fill ``out`` (k,) with the change of the residual along ``direct``, changes of contacts' forces alone."""
    model, work = variation.equations.model, variation.equations.work
    w, n, at = work.dynamics, len(model.free), equations.work.dynamics
    if len(model.rows):
        _central(equations, variation, -1, t, y, dy, s, 1.0, False, out)
        return
    clear(w.wrench)
    clear(w.tau)
    for k in range(len(model.ends)):
        _, arms = contact_motion(model.ends[k], at.pose, at.vel)
        f = s.direct[k]
        add_contact(w.wrench, model.ends[k], s.motion[k, 0], s.motion[k, 1], arms, f[0], f[1], f[2])
    generalised_force(model.bodies, at.pose, w.wrench, w.tau)
    for i in range(n):
        out[i] = w.tau[model.free[i]]
    for m in range(len(model.bristles)):
        out[n + m] = s.direct[model.bristles[m], 3]


@kernel
def _central(
    equations: Equations, variation: Variation, p: int, t: float, y: Array, dy: Array, s: ContactState, h: float,
    with_motions: bool, out: Array,
) -> None:  # fmt: skip
    """Fill ``out`` with the central difference of `_fixed_residual` along value p and ``direct``.

    With motions: add the same of the contacts' motions to ``moved``.
    """
    moved, weight = variation.equations, 0.5 / h if with_motions else 0.0
    still = p >= 0 and not variation.kinematics[p] and not len(moved.model.rows) and not _interpolated(equations)
    for side in (1.0, -1.0):
        if p >= 0:
            move(variation, p, side * h)
        if still:
            _copy_state(equations, moved, t)
        else:
            set_state(moved.model, moved.work, t, y)
        _fixed_residual(moved, t, y, dy, s, side * h, side * weight, s.plus if side > 0.0 else s.minus)
    if p >= 0:
        move(variation, p, 0.0)
    for i in range(len(out)):
        out[i] = (s.plus[i] - s.minus[i]) / (2.0 * h)


@kernel
def _interpolated(equations: Equations) -> bool:
    """Whether the accelerations are interpolated near a singularity: the work does not belong to the state then."""
    return equations.work.dynamics.interpolated[0] > 0.0


@kernel
def add_forcing(
    equations: Equations, variation: Variation, t: float, y: Array, dy: Array, s: ContactState, first: int, out: Array
) -> None:
    """Add the derivatives of the residual with respect to all values to the columns of ``out`` from the first one on.

    Arguments as of `value_forcing`; `exact_jacobian` has been called at the state. ``out`` is (k, m).
    """
    for p in range(len(variation.unit)):
        value_forcing(equations, variation, p, t, y, dy, s, s.forced)
        for i in range(len(out)):
            out[i, first + p] += s.forced[i]


@kernel
def drive_changes(variation: Variation, p: int, t: float, out: Array) -> None:
    """Fill ``out`` (3, nd) with the changes of prescribed coordinates, rates and accelerations with value p.

    Piecewise polynomials are linear in most values, formulas are not.
    """
    model, work, h = variation.equations.model, variation.equations.work, _SHORT * variation.unit[p]
    kind = FOURTH if model.motion_n.min() < 0 else SECOND
    clear(out)
    for point in range(POINTS):
        weight = WEIGHTS[kind, point] / h
        if weight != 0.0:
            move(variation, p, (PLACES[kind] + point) * h)
            evaluate_motions((model.motion, model.motion_c, model.motion_n), t, work.value, work.rate, work.second)
            for i in range(len(model.driven)):
                out[0, i] += weight * work.value[i]
                out[1, i] += weight * work.rate[i]
                out[2, i] += weight * work.second[i]
    move(variation, p, 0.0)


@kernel
def value_forcing(
    equations: Equations, variation: Variation, p: int, t: float, y: Array, dy: Array, s: ContactState, out: Array
) -> None:
    """Fill ``out`` (k,) with the derivative of the residual with respect to value p.

    The equations are solved at (t, y) with the derivatives ``dy`` of rates and other entries; ``s`` is filled by
    `note_contacts`, and `exact_jacobian` has been called at the state.
    """
    clear(s.direct)
    once = variation.kinematics[p] and not len(equations.model.rows) and not is_fine(equations)
    if once:
        clear(s.moved)
    elif variation.kinematics[p]:
        value_motions(equations, variation, p, t, y, s.moved)
        _add_moved(equations, s)
    for k in range(s.direct.shape[0]):
        if changes_law(variation, p, k):
            own_change(equations, variation, p, k, s)
            for i in range(OUTPUTS):
                s.direct[k, i] += s.found[i]
    if variation.mechanics[p]:
        h = MILD * variation.unit[p] / far(equations.model, equations.work.dynamics)
        _central(equations, variation, p, t, y, dy, s, h, once, out)
        if once:
            clear(s.direct)
            _add_moved(equations, s)
            force_response(equations, variation, t, y, dy, s, s.plus)
            for i in range(len(out)):
                out[i] += s.plus[i]
    elif _acts(s):
        force_response(equations, variation, t, y, dy, s, out)
    else:
        clear(out)


@kernel
def _add_moved(equations: Equations, s: ContactState) -> None:
    """Add the changes of the contacts' forces due to their motions to ``direct``."""
    partials = equations.work.scratch.partials
    for k in range(s.direct.shape[0]):
        for i in range(OUTPUTS):
            for j in range(MOTION):
                s.direct[k, i] += partials[k, i, j] * s.moved[k, j]


@kernel
def _acts(s: ContactState) -> bool:
    """Whether any contact's force changes."""
    found = False
    for k in range(s.direct.shape[0]):
        for i in range(OUTPUTS):
            found = found or s.direct[k, i] != 0.0
    return found


@kernel
def approach_forcing(
    equations: Equations, variation: Variation, k: int, t: float, y: Array, dy: Array, s: ContactState, out: Array
) -> bool:
    """Fill ``out`` (k,) with the derivative of the residual with respect to contact k's approach speed.

    Returns False, and fills nothing, if it is zero.
    """
    approach = equations.work.memory[k, APPROACH]
    if not (GRAZING < approach < math.inf and equations.work.contacts[k, PENETRATION] > 0.0):
        return False
    clear(s.change)
    clear(s.direct)
    s.change[APPROACHING] = 1.0
    law_change(equations, variation, -1, k, s)
    for i in range(OUTPUTS):
        s.direct[k, i] = s.found[i]
    acts = _acts(s)
    if acts:
        force_response(equations, variation, t, y, dy, s, out)
    return acts
