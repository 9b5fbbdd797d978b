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
from linkages.laws.parameters import MODELS
from linkages.planar.contact_partials import (
    APPROACHING,
    CHANGES,
    DELTA,
    FRICTION_SPEED,
    LEAST,
    OUTPUTS,
    RESULT_PLACES,
    RESULTS,
    SLIDING_FROM,
    SLIDING_TO,
    inside,
    is_bounded,
)
from linkages.planar.contacts import APPROACH, BRISTLE, Motion, contact_action, contact_motion

MOTION = 8  # entries of a contact's motion
CLOSING, SLIDING = DELTA + 1, DELTA + 2  # results of a contact after its penetration
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
    found: Array  # to work in, (RESULTS,)
    change: Array  # (k,)
    row: Array  # (k,)
    spare: Array  # (nc, MOTION)


def make_contacts(nc: int, np_: int, k: int, nd: int, m: int) -> Contacts:
    """Make the arrays for nc contacts, np values, k entries of the residual, nd driven coordinates, m columns."""
    shapes = (
        (nc, MOTION), (nc, RESULTS), (np_, nc, RESULTS), (nc, RESULTS), (np_, nc, MOTION), (np_, 3, nd),
        (nc, OUTPUTS, k), (max(m, 1), nc, CHANGES), (RESULTS,), (k,), (k,), (nc, MOTION),
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
    """Fill ``found`` with the change of the results of contact k at its motion with value p.

    The step changes the gap by a small part of ``room`` at most.
    """
    model, moved, memory = equations.model, variation.equations.model, equations.work.memory[k]
    end, law, table, bounds = model.ends[k], model.laws[k], model.tables[k], equations.work.scratch.bounds[k]
    approach, bristle, motion = memory[APPROACH], memory[BRISTLE], _motion_of(s.motion[k])
    h, margins = _STEP * variation.unit[p], (_INSIDE, _SLOW, _INSIDE)
    if variation.gaps[p, k] > 0.0:
        spin, slide = abs(motion[4]) + abs(motion[5]) + _SLOW, _SHIFT * _friction_scale(bounds)
        h = min(h, min(_GAP * room, slide / spin) / variation.gaps[p, k])
        margins = _INSIDE, 2.0 * slide, _PUSHING
    if is_bounded(bounds):
        motion = inside(end, law, table, approach, bristle, motion, bounds, margins)
    clear(s.found)
    for side in (1.0, -1.0):
        move(variation, p, side * h)
        result = contact_action(moved.ends[k], moved.laws[k], moved.tables[k], approach, bristle, motion)
        for i in range(RESULTS):
            s.found[i] += side * result[i] / (2.0 * h)
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


@kernel
def law_changes(equations: Equations, variation: Variation, s: Contacts) -> None:
    """Fill ``laws`` and ``approaching`` at the motions and forces that are noted."""
    for k in range(len(s.force)):
        room = room_of(equations, k, s)
        for p in range(len(variation.unit)):
            if variation.laws[p, k]:
                law_change(equations, variation, p, k, room, s)
                for i in range(RESULTS):
                    s.laws[p, k, i] = s.found[i]
        clear(s.approaching[k])
        if s.force[k, DELTA] > 0.0 and GRAZING < equations.work.memory[k, APPROACH] < math.inf:
            for i in range(RESULTS):
                s.approaching[k, i] = equations.work.scratch.partials[k, i, APPROACHING]


@kernel
def gap_change(equations: Equations, k: int, change: Array, s: Contacts) -> None:
    """Fill ``found`` with the change of contact k's results along a change (CHANGES,) of its motion.

    The penetration, its rate and the sliding speed are accurate, whether the bodies touch or not.
    """
    model, memory, a = equations.model, equations.work.memory[k], s.motion[k]
    end, law, worst = model.ends[k], model.laws[k], 0.0
    for i in range(2):
        worst = max(worst, abs(change[i]) / law.clearance, abs(change[6 + i]))
    if worst == 0.0:  # linear in the rates
        for i in range(2, 6):
            worst = max(worst, abs(change[i]))
    clear(s.found)
    if worst == 0.0:
        return
    h = _WIDE / worst
    for side in (1.0, -1.0):
        for i in range(MOTION):
            s.spare[k, i] = a[i] + side * h * change[i]
        motion = _motion_of(s.spare[k])
        result = contact_action(end, law, model.tables[k], memory[APPROACH], memory[BRISTLE], motion)
        for i in range(RESULTS):
            s.found[i] += side * result[i] / (2.0 * h)
