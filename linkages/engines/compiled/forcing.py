"""Derivatives of the equations of motion with respect to values of the system and to what contacts remember.

The residual R(y, y') of `linkages.engines.compiled.equations.residual` has the derivative M df/dx with respect to any
value x, at a state with the derivatives y' = f(y). A value acts in two ways: on the laws of contacts, and on everything
else. Laws, and the motions of contacts at given coordinates, are differentiated by differences of the fourth order. The
rest is differentiated by central differences with forces of contacts that do not follow their motions: a step of a
length would otherwise close a thin film.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.equations import set_state
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.variation import Variation, move
from linkages.kernel import Array, clear, kernel
from linkages.laws.contact.contact_forces import GRAZING
from linkages.planar.arrays import Arrays
from linkages.planar.contact_partials import (
    APPROACHING,
    CHANGES,
    INPUTS,
    OUTPUTS,
    PLACES,
    POINTS,
    RESULTS,
    WEIGHTS,
    add_contact_change,
    bounded_values,
    inside,
    is_bounded,
    place_stencil,
    stencil_step,
)
from linkages.planar.contacts import (
    APPROACH,
    BRISTLE,
    BRISTLE_RATE,
    COUPLE,
    FX,
    FY,
    PENETRATION,
    add_contact,
    contact_motion,
)
from linkages.planar.loads import load_wrenches
from linkages.planar.newton_euler import force_residual, generalised_force
from linkages.planar.singularities import smooth_dynamics
from linkages.planar.workspace import Workspace

_MILD = 1e-5  # step of central differences, in parts of a value's magnitude
_WIDE = 1e-3  # step of differences of the fourth order of kinematics, in the same parts, or of 1 rad of a drive
MOTION = 8  # entries of a contact's motion


class ContactState(NamedTuple):
    """Motions and forces of the contacts at a state; forces in the order of `linkages.planar.contact_partials`."""

    motion: Array  # (nc, MOTION)
    force: Array  # (nc, OUTPUTS)
    partials: Array  # of the force, (nc, OUTPUTS, INPUTS)
    direct: Array  # change of the force along a value, at fixed coordinates, (nc, OUTPUTS)
    moved: Array  # change of the motion along a value, at fixed coordinates, (nc, CHANGES)
    change: Array  # to work in, (CHANGES,)
    room: Array  # (INPUTS,)
    found: Array  # (RESULTS,)
    seen: Array  # (3, 3)
    plus: Array  # residuals, (k,)
    minus: Array


def make_contact_state(nc: int, k: int) -> ContactState:
    """Make the arrays for nc contacts and k entries of the residual."""
    return ContactState(
        np.zeros((nc, MOTION)),
        np.zeros((nc, OUTPUTS)),
        np.zeros((nc, OUTPUTS, INPUTS)),
        np.zeros((nc, OUTPUTS)),
        np.zeros((nc, CHANGES)),
        np.zeros(CHANGES),
        np.zeros(INPUTS),
        np.zeros(RESULTS),
        np.zeros((3, 3)),
        np.zeros(k),
        np.zeros(k),
    )


@kernel
def note_contacts(equations: Equations, s: ContactState) -> None:
    """Take the contacts' motions and forces from a state that is solved."""
    model, work = equations.model, equations.work
    clear(s.motion)
    _add_motions(model, work.dynamics, 1.0, s.motion)
    for k in range(len(model.ends)):
        found = work.contacts[k]
        s.force[k, 0], s.force[k, 1], s.force[k, 2] = found[FX], found[FY], found[COUPLE]
        s.force[k, 3] = found[BRISTLE_RATE]


@kernel
def note_partials(equations: Equations, s: ContactState) -> None:
    """Take the partial derivatives of the contacts' forces from the Jacobian of the same state."""
    partials = equations.work.scratch.partials
    for k in range(partials.shape[0]):
        for i in range(OUTPUTS):
            for j in range(INPUTS):
                s.partials[k, i, j] = partials[k, i, j]


@kernel
def law_change(equations: Equations, variation: Variation, p: int, k: int, s: ContactState) -> None:
    """Fill ``found`` with the change of all results of contact k along ``change``, and along value p unless it is -1.

    The contact is at its motion in ``s``; unit changes of the value are meant.
    """
    model, work, moved = equations.model, equations.work, variation.equations.model
    own = p >= 0 and variation.laws[p, k] == 1
    a = s.motion[k]
    given = (a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7])
    approach, bristle = work.memory[k, APPROACH], work.memory[k, BRISTLE]
    motion = inside(model.ends[k], model.laws[k], model.tables[k], approach, bristle, given, work.scratch.bounds[k])
    clear(s.found)
    value = 1.0 / variation.unit[p] if own else 0.0
    h, kind, bounds = (
        stencil_step(model.ends[k], model.laws[k], approach, motion, s.change, value, s.room),
        0,
        work.scratch.bounds[k],
    )
    if h == 0.0:
        return
    if is_bounded(bounds):
        for i in range(3):
            if own:
                move(variation, p, (i - 1) * h)
            end, law, table = moved.ends[k], moved.laws[k], moved.tables[k]
            bounded_values(end, law, table, approach, bristle, motion, s.change, (i - 1) * h, s.seen[i])
        h, kind = place_stencil(h, bounds, s.seen)
    for point in range(POINTS):
        weight, step = WEIGHTS[kind, point] / h, (PLACES[kind] + point) * h
        if weight != 0.0:
            if own:
                move(variation, p, step)
            end, law, table = moved.ends[k], moved.laws[k], moved.tables[k]
            add_contact_change(end, law, table, approach, bristle, motion, s.change, step, weight, s.found)
    if own:
        move(variation, p, 0.0)


@kernel
def value_motions(variation: Variation, p: int, t: float, y: Array, out: Array) -> None:
    """Fill ``out`` (nc, CHANGES) with the changes of the contacts' motions with value p at a fixed state."""
    clear(out)
    if not variation.kinematics[p]:
        return
    model, work = variation.equations.model, variation.equations.work
    w, far = work.dynamics, 1.0
    set_state(model, work, t, y)
    for k in range(len(model.driven)):
        far = max(far, abs(w.q[model.driven[k]]))
    h = _WIDE * variation.unit[p] / far
    for point in range(POINTS):
        if WEIGHTS[0, point] != 0.0:
            move(variation, p, (PLACES[0] + point) * h)
            set_state(model, work, t, y)
            _add_motions(model, w, WEIGHTS[0, point] / h, out)
    move(variation, p, 0.0)


@kernel
def _add_motions(model: Arrays, w: Workspace, factor: float, out: Array) -> None:
    """Add the contacts' motions times a factor."""
    for k in range(len(model.ends)):
        motion, _ = contact_motion(model.ends[k], w.pose, w.vel)
        for i in range(MOTION):
            out[k, i] += factor * motion[i]


@kernel
def _fixed_residual(
    equations: Equations, t: float, y: Array, dy: Array, s: ContactState, amount: float, out: Array
) -> None:
    """Fill ``out`` as `residual`, with the contacts' forces of ``s`` plus ``amount * direct``."""
    model, work = equations.model, equations.work
    w, n = work.dynamics, len(model.free)
    set_state(model, work, t, y)
    clear(w.wrench)
    for k in range(len(model.ends)):
        motion, arms = contact_motion(model.ends[k], w.pose, w.vel)
        for i in range(OUTPUTS):
            s.found[i] = s.force[k, i] + amount * s.direct[k, i]
        add_contact(w.wrench, model.ends[k], motion[0], motion[1], arms, s.found[0], s.found[1], s.found[2])
        for m in range(len(model.bristles)):
            if model.bristles[m] == k:
                out[n + m] = s.found[3] - dy[n + m]
    if len(model.loads):
        tables = (model.loads, model.signals, model.load_t, model.load_c, model.load_n)
        load_wrenches(tables, t, w.pose, w.vel, w.wrench)
    if len(model.rows):
        smooth_dynamics(model.bodies, model.rows, model.rank, model.size, model.gravity, w)
        for i in range(n):
            out[i] = w.a[model.free[i]] - dy[i]
    else:
        for i in range(n):
            w.a[model.free[i]] = dy[i]
        force_residual(model.bodies, model.gravity, w)
        for i in range(n):
            out[i] = w.tau[model.free[i]]


@kernel
def force_response(
    equations: Equations, variation: Variation, t: float, y: Array, dy: Array, s: ContactState, out: Array
) -> None:
    """Fill ``out`` (k,) with the change of the residual along ``direct``, changes of contacts' forces alone."""
    model, work = variation.equations.model, variation.equations.work
    w, n, at = work.dynamics, len(model.free), equations.work.dynamics
    if len(model.rows):
        _central(variation, -1, t, y, dy, s, 1.0, out)
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
    variation: Variation, p: int, t: float, y: Array, dy: Array, s: ContactState, h: float, out: Array
) -> None:
    """Fill ``out`` with the central difference of `_fixed_residual` along value p and ``direct``."""
    if p >= 0:
        move(variation, p, h)
    _fixed_residual(variation.equations, t, y, dy, s, h, s.plus)
    if p >= 0:
        move(variation, p, -h)
    _fixed_residual(variation.equations, t, y, dy, s, -h, s.minus)
    if p >= 0:
        move(variation, p, 0.0)
    for i in range(len(out)):
        out[i] = (s.plus[i] - s.minus[i]) / (2.0 * h)


@kernel
def value_forcing(
    equations: Equations, variation: Variation, p: int, t: float, y: Array, dy: Array, s: ContactState, out: Array
) -> None:
    """Fill ``out`` (k,) with the derivative of the residual with respect to value p.

    The equations are solved at (t, y) with the derivatives ``dy`` of rates and other entries; ``s`` is filled by
    `note_contacts` and `note_partials`.
    """
    value_motions(variation, p, t, y, s.moved)
    clear(s.direct)
    acts = False
    for k in range(s.direct.shape[0]):
        if variation.laws[p, k]:
            clear(s.change)
            law_change(equations, variation, p, k, s)
            for i in range(OUTPUTS):
                s.direct[k, i] = s.found[i]
        for i in range(OUTPUTS):
            for j in range(MOTION):
                s.direct[k, i] += s.partials[k, i, j] * s.moved[k, j]
            acts = acts or s.direct[k, i] != 0.0
    if variation.mechanics[p]:
        _central(variation, p, t, y, dy, s, _MILD * variation.unit[p], out)
    elif acts:
        force_response(equations, variation, t, y, dy, s, out)
    else:
        clear(out)


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
    acts = False
    for i in range(OUTPUTS):
        s.direct[k, i] = s.found[i]
        acts = acts or s.found[i] != 0.0
    if acts:
        force_response(equations, variation, t, y, dy, s, out)
    return acts
