"""Contacts at a state, and how their results change with values of the system and along columns.

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
from linkages.laws.parameters import MODELS
from linkages.planar.contact_partials import (
    CHANGES,
    DELTA,
    DEPTH_FROM,
    DEPTH_TO,
    FRICTION_SPEED,
    LEAST,
    MOTION,
    OUTPUTS,
    RESULT_PLACES,
    RESULTS,
    SLIDING,
    SLIDING_FROM,
    SLIDING_TO,
    inside,
    is_bounded,
)
from linkages.planar.contacts import APPROACH, BRISTLE, contact_action, contact_motion

_DRY = MODELS["dry"]

_STEP = 1e-6  # of central differences of a law, in parts of a value
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
    moved: Array  # changes of the motion along values at fixed coordinates, (np, nc, MOTION)
    driven: Array  # changes of prescribed coordinates, rates and accelerations along values, (np, 3, nd)
    response: Array  # change of the residual with the force, (nc, OUTPUTS, k)
    along: Array  # changes of motion, bristles and approach speed along columns, (m, nc, CHANGES)
    found: Array  # to work in, (RESULTS,)
    change: Array  # (k,)
    row: Array  # (k,)
    spare: Array  # (nc, MOTION)


def make_contacts(nc: int, np_: int, k: int, nd: int, m: int) -> Contacts:
    """Make the arrays for nc contacts, np values, k entries of the residual, nd driven coordinates, m columns."""
    shapes = (
        (nc, MOTION), (nc, RESULTS), (np_, nc, RESULTS), (np_, nc, MOTION), (np_, 3, nd),
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


@kernel
def law_change(equations: Equations, variation: Variation, p: int, k: int, room: float, s: Contacts) -> None:
    """Fill ``found`` with the change of contact k's results at its motion with value p.

    The step changes the gap by a small part of ``room`` at most. Near a kink the change is extrapolated from two
    distances: kinks move with values.
    """
    moved, memory, bounds = variation.equations.model, equations.work.memory[k], equations.work.scratch.bounds[k]
    end, law, table = moved.ends[k], moved.laws[k], moved.tables[k]
    approach, bristle, a = memory[APPROACH], memory[BRISTLE], s.motion[k]
    motion = a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7]
    h, slow, pushing = _STEP * variation.unit[p], _SLOW, _INSIDE
    if variation.gaps[p, k] > 0.0:
        spin, slide = abs(motion[4]) + abs(motion[5]) + _SLOW, _SHIFT * _friction_scale(bounds)
        h = min(h, min(_GAP * room, slide / spin) / variation.gaps[p, k])
        slow, pushing = 2.0 * slide, _PUSHING
    clear(s.found)
    for times, weight in ((1.0, 2.0), (2.0, -1.0)):
        shifted = motion
        if is_bounded(bounds):
            margins = times * _INSIDE, times * slow, times * pushing
            shifted = inside(end, law, table, approach, bristle, motion, bounds, margins)
        near = shifted != motion
        for side in (1.0, -1.0):
            move(variation, p, side * h)
            result = contact_action(end, law, table, approach, bristle, shifted)
            for i in range(RESULTS):
                s.found[i] += side * (weight if near else 1.0) * result[i] / (2.0 * h)
        move(variation, p, 0.0)
        if not near:
            break


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
    """Fill ``laws`` of the contacts that have a force, at the motions that are noted."""
    for k in range(len(s.force)):
        acts, room = has_force(equations, k, s), room_of(equations, k, s)
        for p in range(len(variation.unit)):
            clear(s.laws[p, k])
            if acts and variation.laws[p, k]:
                law_change(equations, variation, p, k, room, s)
                for i in range(RESULTS):
                    s.laws[p, k, i] = s.found[i]


@kernel
def gap_laws(equations: Equations, variation: Variation, s: Contacts) -> None:
    """Fill ``laws`` of the gaps of contacts that can touch, and their rates, with all digits, touching or not."""
    for k in range(len(s.force)):
        for p in range(len(variation.unit)):
            if equations.model.touching[k] and variation.laws[p, k]:
                law_change(equations, variation, p, k, equations.model.laws[k].clearance, s)
                for i in range(DELTA, SLIDING + 1):
                    s.laws[p, k, i] = s.found[i]


@inlined_kernel
def result_change(equations: Equations, s: Contacts, p: int, j: int, k: int, result: int) -> float:
    """Return the change of a result of contact k along column j, and with value p unless it is -1."""
    total = s.laws[p, k, result] if p >= 0 else 0.0
    for i in range(CHANGES):
        total += equations.work.scratch.partials[k, result, i] * s.along[j, k, i]
    return total
