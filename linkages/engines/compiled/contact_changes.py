"""Motions and forces of contacts, and their changes with motions and with values of the system.

Laws, and the motions of contacts at given coordinates, are differentiated by differences: of the fourth order, or of
the second one where errors of 1e-7 do not matter, see `linkages.planar.contact_partials.FINE`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.equations import set_state
from linkages.engines.compiled.model import RATIOS, SPEEDS, Equations
from linkages.engines.compiled.variation import Variation, changes_law, move
from linkages.integrate.stepper import copy
from linkages.kernel import Array, clear, inlined_kernel, kernel
from linkages.planar.arrays import Arrays
from linkages.planar.contact_partials import (
    BOUNDED,
    CHANGES,
    DELTA,
    FINE,
    FOURTH,
    FRICTION_SPEED,
    INPUTS,
    OUTPUTS,
    PLACES,
    POINTS,
    RATIO_FROM,
    RESULT_PLACES,
    RESULTS,
    SECOND,
    SLIDING_FROM,
    WEIGHTS,
    add_contact_change,
    bounded_values,
    film_step,
    gap_step,
    inside,
    is_bounded,
    is_film,
    place_stencil,
    stencil_step,
)
from linkages.planar.contacts import APPROACH, BRISTLE, Motion, contact_action, contact_motion
from linkages.planar.workspace import Workspace

MILD = 1e-5  # step of central differences, in parts of a value's magnitude
_NARROW = 0.06  # step of differences of the second order of a law, in parts of the fourth order's
_WIDE = 1e-3  # step of differences of the fourth order of kinematics, in parts of a value, or of 1 rad of a drive
MOTION = 8  # entries of a contact's motion


class ContactState(NamedTuple):
    """Motions and forces of the contacts at a state; forces in the order of `linkages.planar.contact_partials`."""

    motion: Array  # (nc, MOTION)
    force: Array  # and the other results, (nc, RESULTS)
    laws: Array  # changes of the results along values that change the law, at fixed motion, (np, nc, RESULTS)
    direct: Array  # change of the force along a value, at fixed coordinates, (nc, OUTPUTS)
    moved: Array  # change of the motion along a value, at fixed coordinates, (nc, CHANGES)
    change: Array  # to work in, (CHANGES,)
    room: Array  # (INPUTS,)
    found: Array  # (RESULTS,)
    seen: Array  # (3, BOUNDED)
    moving: Array  # (FRICTION_SPEED,)
    plus: Array  # residuals, to work in: of `linkages.engines.compiled.forcing.value_forcing` alone, (k,)
    minus: Array
    forced: Array  # result of `value_forcing` for one value, (k,)
    drive: Array  # changes of prescribed coordinates, rates and accelerations, (3, nd)


def make_contact_state(nc: int, np_: int, ny: int, k: int, nd: int) -> ContactState:
    """Make the arrays for nc contacts, np values, ny entries of the state, k of the residual, nd driven coordinates."""
    return ContactState(
        np.zeros((nc, MOTION)),
        np.zeros((nc, RESULTS)),
        np.zeros((np_, nc, RESULTS)),
        np.zeros((nc, OUTPUTS)),
        np.zeros((nc, CHANGES)),
        np.zeros(CHANGES),
        np.zeros(INPUTS),
        np.zeros(RESULTS),
        np.zeros((3, BOUNDED)),
        np.zeros(FRICTION_SPEED),
        np.zeros(k),
        np.zeros(k),
        np.zeros(k),
        np.zeros((3, nd)),
    )


@kernel
def note_contacts(equations: Equations, s: ContactState) -> None:
    """Take the contacts' motions and forces from a state that is solved."""
    model, work = equations.model, equations.work
    clear(s.motion)
    add_motions(model, work.dynamics, 1.0, s.motion)
    for k in range(len(model.ends)):
        for i in range(RESULTS):
            s.force[k, i] = work.contacts[k, RESULT_PLACES[i]]


@kernel
def is_fine(equations: Equations) -> bool:
    """Whether `is_fine_contact` holds for any contact."""
    found = False
    for k in range(len(equations.model.ends)):
        found = found or is_fine_contact(equations, k)
    return found


@inlined_kernel
def is_fine_contact(equations: Equations, k: int) -> bool:
    """Whether contact k is differentiated to more digits than differences of the second order have."""
    bounds = equations.work.scratch.bounds[k]
    return bool(bounds[FINE] > 0.0 or is_bounded(bounds))


@kernel
def law_change(equations: Equations, variation: Variation, p: int, k: int, s: ContactState) -> None:
    """Fill ``found`` with the change of all results of contact k along ``change``, and along value p unless it is -1.

    The contact is at its motion in ``s``; unit changes of the value are meant.
    """
    model, work, moved = equations.model, equations.work, variation.equations.model
    own = p >= 0 and changes_law(variation, p, k)
    a = s.motion[k]
    motion = (a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7])
    approach, bristle = work.memory[k, APPROACH], work.memory[k, BRISTLE]
    bounds, end, law, table = work.scratch.bounds[k], model.ends[k], model.laws[k], model.tables[k]
    bounded, value, gap = is_bounded(bounds), 0.0, 0.0
    if own:
        value, gap = variation.laws[p, k], variation.gaps[p, k]
    clear(s.found)
    if not bounded and bounds[FINE] == 0.0:
        h = _NARROW * stencil_step(end, law, approach, motion, s.change, value, gap, s.room)
        if h > 0.0:
            _add_pair(variation, p if own else -1, k, end, law, table, approach, bristle, motion, h, s)
        return
    motion = inside(end, law, table, approach, bristle, motion, bounds)
    h, kind, start = stencil_step(end, law, approach, motion, s.change, value, gap, s.room), FOURTH, 0.0
    if h == 0.0:
        return
    if bounded:
        _move_bounds(variation, p if own else -1, k, bounds, s.moving)
        for i in range(3):
            if own:
                move(variation, p, (i - 1) * h)
            end, law, table = moved.ends[k], moved.laws[k], moved.tables[k]
            bounded_values(end, law, table, approach, bristle, motion, s.change, (i - 1) * h, bounds, s.seen[i])
        h, kind, start = place_stencil(h, bounds, s.moving, s.seen)
    _add_differences(equations, variation, p if own else -1, k, motion, h, kind, start, s)


@kernel
def _move_bounds(variation: Variation, p: int, k: int, bounds: Array, out: Array) -> None:
    """Fill ``out`` with the changes of the bounds of contact k along value p, if it is not -1: kinks that it moves."""
    clear(out)
    if p < 0:
        return
    for first, last, place in ((0, RATIOS, RATIO_FROM), (RATIOS, SPEEDS, SLIDING_FROM)):
        for i in range(place, place + 2):
            for j in range(first, last):
                if bounds[i] == variation.kinks[k, j]:
                    out[i] = variation.kink_rates[p, k, j]


@kernel
def _add_pair(
    variation: Variation, p: int, k: int, end: np.record, law: np.record, table: Array, approach: float, bristle: float,
    motion: Motion, h: float, s: ContactState,
) -> None:  # fmt: skip
    """Add differences of the second order to ``found``; the law is that of value p unless it is -1."""
    moved, weight = variation.equations.model, 0.5 / h
    for side in (1.0, -1.0):
        if p >= 0:
            move(variation, p, side * h)
            add_contact_change(
                moved.ends[k], moved.laws[k], moved.tables[k], approach, bristle, motion, s.change, side * h,
                side * weight, s.found,
            )  # fmt: skip
        else:
            add_contact_change(end, law, table, approach, bristle, motion, s.change, side * h, side * weight, s.found)
    if p >= 0:
        move(variation, p, 0.0)


@kernel
def own_change(equations: Equations, variation: Variation, p: int, k: int, s: ContactState) -> None:
    """Fill ``found``, and keep it in ``laws``, with the change of all results of contact k along value p alone."""
    if is_film(equations.model.laws[k]) and not is_fine_contact(equations, k):
        _film_change(equations, variation, p, k, s)
    else:
        clear(s.change)
        law_change(equations, variation, p, k, s)
    copy(s.found, s.laws[p, k])


@kernel
def _film_change(equations: Equations, variation: Variation, p: int, k: int, s: ContactState) -> None:
    """Fill ``found`` with central differences of the results of a film along value p."""
    moved, own, a = variation.equations.model, equations.work.memory[k], s.motion[k]
    motion = (a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7])
    h = variation.unit[p] * film_step(equations.model.laws[k], s.force[k, DELTA])
    clear(s.found)
    for side in (1.0, -1.0):
        move(variation, p, side * h)
        found = contact_action(moved.ends[k], moved.laws[k], moved.tables[k], own[APPROACH], own[BRISTLE], motion)
        for i in range(RESULTS):
            s.found[i] += side * found[i] / (2.0 * h)
    move(variation, p, 0.0)


@kernel
def gap_change(equations: Equations, variation: Variation, p: int, k: int, s: ContactState) -> None:
    """Fill ``found`` as `law_change`, with penetration and speeds accurate where a contact starts or ends."""
    model, a = equations.model, s.motion[k]
    motion = (a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7])
    own = p >= 0 and changes_law(variation, p, k)
    clear(s.found)
    h = gap_step(model.ends[k], model.laws[k], motion, s.change, variation.gaps[p, k] if own else 0.0, s.room)
    if h > 0.0:
        _add_differences(equations, variation, p if own else -1, k, motion, h, FOURTH, 0.0, s)


@kernel
def _add_differences(
    equations: Equations, variation: Variation, p: int, k: int, motion: Motion, h: float, kind: int, start: float,
    s: ContactState,
) -> None:  # fmt: skip
    """Add differences of the results of contact k to ``found``, with steps h along ``change``, and along value p."""
    moved, own = variation.equations.model, equations.work.memory[k]
    for point in range(POINTS):
        weight, step = WEIGHTS[kind, point] / h, start + (PLACES[kind] + point) * h
        if weight != 0.0:
            if p >= 0:
                move(variation, p, step)
            end, law, table = moved.ends[k], moved.laws[k], moved.tables[k]
            add_contact_change(end, law, table, own[APPROACH], own[BRISTLE], motion, s.change, step, weight, s.found)
    if p >= 0:
        move(variation, p, 0.0)


@kernel
def value_motions(equations: Equations, variation: Variation, p: int, t: float, y: Array, out: Array) -> None:
    """Fill ``out`` (nc, CHANGES) with the changes of the contacts' motions with value p at a solved state."""
    clear(out)
    if not variation.kinematics[p]:
        return
    model, work = variation.equations.model, variation.equations.work
    kind, step = (FOURTH, _WIDE) if is_fine(equations) else (SECOND, MILD)
    h = step * variation.unit[p] / far(model, equations.work.dynamics)
    for point in range(POINTS):
        if WEIGHTS[kind, point] != 0.0:
            move(variation, p, (PLACES[kind] + point) * h)
            set_state(model, work, t, y)
            add_motions(model, work.dynamics, WEIGHTS[kind, point] / h, out)
    move(variation, p, 0.0)


@kernel
def far(model: Arrays, w: Workspace) -> float:
    """Largest prescribed coordinate, at least 1: changes of a drive's speed grow with time."""
    far = 1.0
    for k in range(len(model.driven)):
        far = max(far, abs(w.q[model.driven[k]]))
    return far


@kernel
def add_motions(model: Arrays, w: Workspace, factor: float, out: Array) -> None:
    """Add the contacts' motions times a factor."""
    for k in range(len(model.ends)):
        motion, _ = contact_motion(model.ends[k], w.pose, w.vel)
        for i in range(MOTION):
            out[k, i] += factor * motion[i]
