"""Contacts at a state, and how their results change with values of the system, with approach speeds and along columns.

A law is differentiated at a fixed motion by central differences, within the part in which it is smooth. Changes of the
motion count by the partial derivatives of the force, see `linkages.planar.contact_partials`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.variation import Variation, move
from linkages.kernel import Array, clear, inlined_kernel, kernel
from linkages.laws.contact.contact_forces import GRAZING
from linkages.laws.contact.contact_laws import push
from linkages.laws.parameters import MODELS
from linkages.planar.contact_partials import (
    CHANGES,
    DELTA,
    DEPTH_FROM,
    DEPTH_TO,
    FRICTION_SPEED,
    INPUTS,
    LEAST,
    OUTPUTS,
    PUSH_FROM,
    PUSH_TO,
    RATIO_FROM,
    RATIO_TO,
    RESULT_PLACES,
    RESULTS,
    SLIDING_FROM,
    SLIDING_TO,
    is_bounded,
)
from linkages.planar.contacts import APPROACH, BRISTLE, Motion, contact_action, contact_motion
from linkages.planar.record_types import CORNER, STOP

MOTION = 8  # entries of a contact's motion
_DRY = MODELS["dry"]

_STEP = 1e-6  # of central differences of a law, in parts of a value, of an approach speed
_WIDE = 1e-5  # of central differences of a gap along a motion, in parts of the clearance
_GAP = 1e-4  # greatest change of the gap in a step, in parts of the gap of a film
_DEEP = 10.0  # penetrations count as so many gaps
_NEAR = 1e-3  # lower limit of a film's gap, in parts of the clearance
_INSIDE = 2e-6  # distance from a kink, in parts of its speed: kinks move with values
_SHIFT = 1e-6  # greatest change of the sliding speed in a step, in parts of that over which friction changes
_PUSHING = 2e-3  # distance from the zero of a force, in parts of the force, if lengths change
_SLOW = 1e-10  # least distance from a kink at zero speed [m/s]


class Contacts(NamedTuple):
    """The nc contacts at a state and their changes; forces in the order of `linkages.planar.contact_partials`."""

    motion: Array  # (nc, MOTION)
    force: Array  # and the other results, (nc, RESULTS)
    laws: Array  # changes of the results along values at a fixed motion, (np, nc, RESULTS)
    approaching: Array  # and with the contact's approach speed, (nc, RESULTS)
    moved: Array  # changes of the motion along values at fixed coordinates, (np, nc, MOTION)
    driven: Array  # changes of prescribed coordinates, rates and accelerations along values, (np, 3, nd)
    response: Array  # change of the residual with the force, (nc, OUTPUTS, k)
    along: Array  # changes of the motion and the bristles along columns, (m, nc, CHANGES)
    gap: Array  # changes of penetration, its rate and sliding speed, to work in, (3,)
    found: Array  # (RESULTS,)
    change: Array  # (k,)
    row: Array  # (k,)
    spare: Array  # (nc, MOTION)


def make_contacts(nc: int, np_: int, k: int, nd: int, m: int) -> Contacts:
    """Make the arrays for nc contacts, np values, k entries of the residual, nd driven coordinates, m columns."""
    shapes = (
        (nc, MOTION), (nc, RESULTS), (np_, nc, RESULTS), (nc, RESULTS), (np_, nc, MOTION), (np_, 3, nd),
        (nc, OUTPUTS, k), (max(m, 1), nc, CHANGES), (3,), (RESULTS,), (k,), (k,), (nc, MOTION),
    )  # fmt: skip
    return Contacts(*map(np.zeros, shapes))


@kernel
def note_contacts(equations: Equations, s: Contacts) -> None:
    """Take the contacts' motions and forces from a state that is solved."""
    model, work = equations.model, equations.work
    for k in range(len(model.ends)):
        motion, _ = contact_motion(model.ends[k], work.dynamics.pose, work.dynamics.vel)
        for i in range(MOTION):
            s.motion[k, i] = motion[i]
        for i in range(RESULTS):
            s.force[k, i] = work.contacts[k, RESULT_PLACES[i]]


@inlined_kernel
def _motion_of(a: Array) -> Motion:
    return a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7]


@kernel
def law_change(equations: Equations, variation: Variation, p: int, k: int, room: float, s: Contacts) -> None:
    """Fill ``found`` with the change of contact k's results at its motion with value p, or its approach speed (p = -1).

    The step changes the gap by a small part of ``room`` at most.
    """
    model, moved, memory = equations.model, variation.equations.model, equations.work.memory[k]
    end, law, table, bounds = model.ends[k], model.laws[k], model.tables[k], equations.work.scratch.bounds[k]
    approach, bristle, motion = memory[APPROACH], memory[BRISTLE], _motion_of(s.motion[k])
    h, margins = _STEP * (variation.unit[p] if p >= 0 else approach), (_SLOW, _INSIDE)
    if p >= 0 and variation.gaps[p, k] > 0.0:
        spin, slide = abs(motion[4]) + abs(motion[5]) + _SLOW, _SHIFT * _friction_scale(bounds)
        h = min(h, min(_GAP * room, slide / spin) / variation.gaps[p, k])
        margins = 2.0 * slide, _PUSHING
    clear(s.found)
    for times, weight in ((1.0, 2.0), (2.0, -1.0)):  # extrapolated to the kink
        shifted, near = inside(end, law, table, approach, bristle, motion, bounds, margins, times)
        for side in (1.0, -1.0):
            began = approach
            if p >= 0:
                move(variation, p, side * h)
            else:
                began += side * h
            result = contact_action(moved.ends[k], moved.laws[k], moved.tables[k], began, bristle, shifted)
            for i in range(RESULTS):
                s.found[i] += side * (weight if near else 1.0) * result[i] / (2.0 * h)
        if not near:
            break
    if p >= 0:
        move(variation, p, 0.0)


@inlined_kernel
def _friction_scale(bounds: Array) -> float:
    """Return a sliding speed over which friction changes; infinite without friction."""
    scale = bounds[FRICTION_SPEED]
    for speed in (abs(bounds[SLIDING_FROM]), abs(bounds[SLIDING_TO])):
        if 0.0 < speed < scale:
            scale = speed
    return scale


@kernel
def room_of(equations: Equations, k: int, s: Contacts) -> float:
    """Return the gap or the penetration of contact k, which limits the steps of its differences."""
    law, delta = equations.model.laws[k], abs(s.force[k, DELTA])
    return _DEEP * max(delta, LEAST * law.clearance) if law.model == _DRY else max(delta, _NEAR * law.clearance)


@inlined_kernel
def has_force(equations: Equations, k: int, s: Contacts) -> bool:
    """Whether contact k has a force on its side of the start or end of the contact."""
    law, bounds = equations.model.laws[k], equations.work.scratch.bounds[k]
    touches = s.force[k, DELTA] > 0.0 if bounds[DEPTH_FROM] == -math.inf else True
    return law.model != _DRY or law.bristle_scale > 0.0 or (touches and bounds[DEPTH_TO] == math.inf)


@kernel
def law_changes(equations: Equations, variation: Variation, s: Contacts) -> None:
    """Fill ``laws`` and ``approaching`` of the contacts that have a force, at the motions that are noted."""
    for k in range(len(s.force)):
        acts, room = has_force(equations, k, s), room_of(equations, k, s)
        for p in range(len(variation.unit)):
            clear(s.laws[p, k])
            if acts and variation.laws[p, k]:
                law_change(equations, variation, p, k, room, s)
                for i in range(RESULTS):
                    s.laws[p, k, i] = s.found[i]
        clear(s.approaching[k])
        if acts and s.force[k, DELTA] > 0.0 and GRAZING < equations.work.memory[k, APPROACH] < math.inf:
            law_change(equations, variation, -1, k, room, s)
            for i in range(RESULTS):
                s.approaching[k, i] = s.found[i]


@kernel
def gap_change(
    equations: Equations, variation: Variation, p: int, k: int, change: Array, s: Contacts, out: Array
) -> None:
    """Fill ``out`` (3,) with the change of contact k's penetration, its rate and its sliding speed.

    It is that along a change (CHANGES,) of its motion, and along value p unless it is -1, whether the bodies touch or
    not.
    """
    model, memory, a = equations.model, equations.work.memory[k], s.motion[k]
    end, law, worst = model.ends[k], model.laws[k], 0.0
    for i in range(2):
        worst = max(worst, abs(change[i]) / law.clearance, abs(change[6 + i]))
    if worst == 0.0:  # linear in the rates
        for i in range(2, 6):
            worst = max(worst, abs(change[i]))
    clear(s.found)
    if p >= 0 and variation.laws[p, k]:
        law_change(equations, variation, p, k, law.clearance, s)
    for i in range(3):
        out[i] = s.found[DELTA + i]
    if worst == 0.0:
        return
    h = _WIDE / worst
    for side in (1.0, -1.0):
        for i in range(MOTION):
            s.spare[k, i] = a[i] + side * h * change[i]
        motion = _motion_of(s.spare[k])
        result = contact_action(end, law, model.tables[k], memory[APPROACH], memory[BRISTLE], motion)
        for i in range(3):
            out[i] += side * result[DELTA + i] / (2.0 * h)


@inlined_kernel
def result_change(equations: Equations, s: Contacts, p: int, j: int, k: int, result: int, remembered: float) -> float:
    """Return the change of a result of contact k along column j, with value p and with its approach speed."""
    partials = equations.work.scratch.partials
    total = s.approaching[k, result] * remembered
    if p >= 0:
        total += s.laws[p, k, result]
    for i in range(INPUTS):
        total += partials[k, result, i] * s.along[j, k, i]
    return total


@kernel
def deeper(end: np.record, motion: Motion, depth: float) -> Motion:
    """Increase the penetration of a contact by a small depth, in the direction of its normal."""
    return _shifted(end, motion, depth, 0.0, 0.0)


@inlined_kernel
def _shifted(end: np.record, motion: Motion, depth: float, closing: float, sliding: float) -> Motion:
    """Increase penetration, closing and sliding speed of a contact."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if end.kind == STOP:
        return ex, ey, vx, vy, wb, wj + end.nx * closing, nx, ny + end.nx * depth
    x, y = nx, ny
    if end.kind != CORNER:
        distance = math.hypot(ex, ey)
        if distance == 0.0:
            return motion
        x, y = ex / distance, ey / distance
    vx, vy = vx + closing * x - sliding * y, vy + closing * y + sliding * x
    return ex + depth * x, ey + depth * y, vx, vy, wb, wj, nx, ny


@inlined_kernel
def _within(value: float, low: float, high: float, share: float, margin: float) -> float:
    """Limit a value to within its bounds, a share of them and a margin away."""
    if low > -math.inf:
        value = max(value, low + share * abs(low) + margin)
    if high < math.inf:
        value = min(value, high - share * abs(high) - margin)
    return value


@kernel
def inside(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: Motion, bounds: Array,
    margins: tuple[float, float], times: float,
) -> tuple[Motion, bool]:  # fmt: skip
    """Shift the motion of a contact a little to within the bounds of the smooth part of its law; whether it is shifted.

    Steps end at kinks, and just beyond the start or the end of a contact. Differences along a value would cross them.

    Parameters
    ----------
    margins : tuple of float
        Distances from kinks: of the sliding speed [m/s], of the force in parts of itself.
    times : float
        Factor on all distances.
    """
    if not is_bounded(bounds):
        return motion, False
    share = times * _INSIDE
    found = contact_action(end, law, table, approach, bristle, motion)
    delta, closing, sliding, began = found[DELTA], found[DELTA + 1], found[DELTA + 2], max(approach, GRAZING)
    depth = _within(delta, bounds[DEPTH_FROM], bounds[DEPTH_TO], 0.0, times * LEAST * law.clearance)
    slide = _within(sliding, bounds[SLIDING_FROM], bounds[SLIDING_TO], share, times * margins[0])
    close = closing
    if began < math.inf:
        close = began * _within(closing / began, bounds[RATIO_FROM], bounds[RATIO_TO], share, 0.0)
    if bounds[PUSH_FROM] > -math.inf or bounds[PUSH_TO] < math.inf:
        here, small = push(depth, close, approach, law), 1e-4 * abs(close)
        slope = push(depth, close + small, approach, law) - here
        wanted = _within(here, bounds[PUSH_FROM], bounds[PUSH_TO], 0.0, times * margins[1])
        if wanted != here and slope > 0.0:
            close += (wanted - here) / slope * small
    if depth == delta and slide == sliding and close == closing:
        return motion, False
    return _shifted(end, motion, depth - delta, close - closing, slide - sliding), True
