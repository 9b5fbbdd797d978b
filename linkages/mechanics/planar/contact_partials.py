"""Partial derivatives of a contact's force with respect to its motion."""

from __future__ import annotations

import math
from typing import Any, get_args

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.dual import DIRECTIONS, is_known, put_slopes, seeded
from linkages.laws.contact.contact_laws import push, reference_speed
from linkages.laws.journal import ContactResults
from linkages.laws.states import STATES, Remembered, remembered_of
from linkages.mechanics.planar.contacts import (
    FIRST_RATE,
    RESULTS,
    ContactMotion,
    contact_action,
    has_cells,
    remembered_action,
)
from linkages.mechanics.planar.record_types import CORNER, JOURNAL, STOP, WORN

#: Inputs: the motion, that is e (2), its rate (2), angular velocities (2), normal into the wall or worn parts' angles
#: (2); then the states of the contact.
MOTION = len(get_args(ContactMotion))
INPUTS = MOTION + STATES
GAP, SPEED = 0, 2  #: two of them, which scale differences
#: Number of results that act on something: force on the inner body, couple on it, rates of the states.
OUTPUTS = FIRST_RATE + STATES

STEP = 6e-6  #: in parts of an input's scale: the cube root of the rounding error minimises the error of the differences
AWAY = 3.0 * STEP  #: distance of differences from bounds, in parts of the scale of speeds
_FORWARD = 1e-8  # the same for forward differences: the square root of the rounding error
_NEAR = 1e-3  # lower limit of the gap that scales a displacement, in parts of the clearance
CENTRE = 1e-12  #: distance from the centre at which a centred contact is differentiated [m]
_SLOW = 1e-9  # smallest speed that scales a velocity, clearances and lengths of 1 m per second

PARTIALS = 2 * DIRECTIONS  #: columns of partial derivatives: `INPUTS`, and zeros
DELTA, CLOSES, SLIDING = range(OUTPUTS, OUTPUTS + 3)  #: penetration, its rate, sliding speed among the results
#: Bounds within which a contact's force is smooth: ratio of the closing speed to the approach speed, sliding speed,
#: penetration, the law's force before its limit at zero.
RATIO_FROM, RATIO_TO, SLIDING_FROM, SLIDING_TO, DEPTH_FROM, DEPTH_TO, PUSH_FROM, PUSH_TO = range(8)
BOUNDS = 8
LEAST = 1e-11  # smallest penetration with bounds, in parts of the clearance: events are located to 1e-10
_SHARE, _STILL, _PUSHING = 1e-9, 1e-12, 1e-9  # least distances from bounds, above the rounding of speeds: see `inside`


@kernel
def input_scales(end: np.record, law: np.record, motion: ContactMotion, out: Array) -> None:
    """Fill ``out`` (INPUTS,) with the change of each input over which a contact's force changes."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    corner = end.kind == CORNER
    c = law.clearance
    distance = math.hypot(ex, ey)
    open_by = c + end.half - ex * nx - ey * ny if corner else c - distance
    if end.kind == STOP:
        open_by = c + end.half - end.nx * end.lever * ny
    gap = max(abs(open_by), _NEAR * c)
    speed = math.hypot(vx, vy) + c * (abs(wb) + abs(wj)) + _SLOW
    lever = max(law.radius, c)
    spin = abs(wb) + abs(wj) + speed / lever
    turn = gap / (max(distance, gap) if corner else lever)  # by the gap, seen from the corner or on a worn surface
    if end.kind == STOP:
        turn = gap / end.lever
    out[0], out[1], out[2], out[3], out[4], out[5] = gap, gap, speed, speed, spin, spin
    out[6], out[7] = turn, turn
    out[MOTION], out[MOTION + 1], out[MOTION + 2] = law.scale_0, law.scale_1, law.scale_2


@kernel
def _action_along(
    end: np.record, law: np.record, table: Array, memory: Array, motion: ContactMotion, change: Array, h: float
) -> ContactResults:
    """Compute the results of a contact at h times a change (INPUTS,) of its inputs."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    moved = (
        ex + h * change[0],
        ey + h * change[1],
        vx + h * change[2],
        vy + h * change[3],
        wb + h * change[4],
        wj + h * change[5],
        nx + h * change[6],
        ny + h * change[7],
    )
    latched, a, b, c = remembered_of(memory)
    states = a + h * change[MOTION], b + h * change[MOTION + 1], c + h * change[MOTION + 2]
    found, _, _ = remembered_action(end, law, table, memory, (latched, states[0], states[1], states[2]), moved)
    return found


def no_bounds() -> Array:
    """Return the bounds of a contact without any, (BOUNDS,)."""
    bounds = np.full(BOUNDS, np.inf)
    bounds[::2] = -np.inf
    return bounds


@kernel
def is_bounded(bounds: Array) -> bool:
    """Whether any quantity of a contact is bounded."""
    found = False
    for i in range(0, BOUNDS, 2):
        found = found or bounds[i] > -math.inf or bounds[i + 1] < math.inf
    return found


@lazy_kernel
def inside(
    end: np.record, law: np.record, table: Array, remembered: Remembered, motion: ContactMotion, bounds: Array,
    margin: float,
) -> ContactMotion:  # fmt: skip
    """Move a motion a little, to where its penetration and speeds are within the bounds: the law is smooth there.

    Steps end at kinks, and just beyond the start or the end of a contact. The penetration becomes at least `LEAST` in
    magnitude: at zero a force or the rate of a state may jump.

    Parameters
    ----------
    margin : float
        Distance of the speeds from the bounds [m/s], in addition to a share of each, above their rounding.
    """
    found = contact_action(end, law, table, remembered, motion)
    delta, closing, sliding, began = found[DELTA], found[CLOSES], found[SLIDING], reference_speed(remembered)
    depth = _within(delta, bounds, DEPTH_FROM, 0.0, LEAST * law.clearance)
    slide = _within(sliding, bounds, SLIDING_FROM, _SHARE, _STILL + margin)
    close = closing
    if began < math.inf:
        close = began * _within(closing / began, bounds, RATIO_FROM, _SHARE, margin / began)
    if bounds[PUSH_FROM] > -math.inf or bounds[PUSH_TO] < math.inf:
        here, small = push(depth, close, remembered, law), 1e-4 * abs(close)
        rise = push(depth, close + small, remembered, law) - here
        away = margin * abs(rise) / small if small > 0.0 else 0.0
        wanted = _within(here, bounds, PUSH_FROM, 0.0, _PUSHING + away)
        if wanted != here and rise > 0.0:
            close += (wanted - here) / rise * small
    if depth == delta and slide == sliding and close == closing:
        return motion
    return _shifted(end, motion, depth - delta, close - closing, slide - sliding)


@inlined_kernel
def _within(value: float, bounds: Array, first: int, share: float, margin: float) -> float:
    """Limit a value to within two bounds, a share of them and a margin away."""
    low, high = bounds[first], bounds[first + 1]
    if low > -math.inf:
        value = max(value, low + share * abs(low) + margin)
    if high < math.inf:
        value = min(value, high - share * abs(high) - margin)
    return value


@kernel
def deeper(end: np.record, motion: ContactMotion, depth: float) -> ContactMotion:
    """Increase the penetration of a contact by a small depth, in the direction of its normal."""
    return _shifted(end, motion, depth, 0.0, 0.0)


@inlined_kernel
def _shifted(end: np.record, motion: ContactMotion, depth: float, closing: float, sliding: float) -> ContactMotion:
    """Increase penetration, closing and sliding speed of a contact."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if end.kind == STOP:
        along, slide = end.nx / end.lever, sliding / end.arm if end.arm > 0.0 else 0.0
        return ex, ey, vx + slide, vy, wb, wj + along * closing, nx, ny + along * depth
    x, y = nx, ny
    if end.kind != CORNER:
        distance = math.hypot(ex, ey)
        if distance == 0.0:
            return motion
        x, y = ex / distance, ey / distance
    vx, vy = vx + closing * x - sliding * y, vy + closing * y + sliding * x
    return ex + depth * x, ey + depth * y, vx, vy, wb, wj, nx, ny


@inlined_kernel
def _is_journal(end: np.record) -> bool:
    return bool(end.kind != CORNER and end.kind != STOP and end.kind != WORN)


@inlined_kernel
def _fill_own_turn(end: np.record, motion: ContactMotion, out: Array) -> None:
    """Fill the derivatives of a journal's results with respect to its own angular velocity from the others.

    The results are the same for observers who turn at different rates: dF/dw_j = e_y dF/dv_x - e_x dF/dv_y - dF/dw_b.
    """
    if _is_journal(end):
        ex, ey, _, _, _, _, _, _ = motion
        for k in range(RESULTS):
            out[k, 5] = ey * out[k, 2] - ex * out[k, 3] - out[k, 4]


@inlined_kernel
def has_states(law: np.record) -> bool:
    """Whether the laws of a contact have states."""
    return bool(law.contact_states + law.friction_states > 0)


@inlined_kernel
def _counts(end: np.record, law: np.record, i: int) -> bool:
    """Whether differences with respect to input i are needed."""
    if i == 5:
        return not _is_journal(end)
    if i == 6:
        return bool(end.kind != JOURNAL)
    if i == 7:
        return bool(end.kind == CORNER or end.kind == STOP or end.kind == WORN)
    return i < MOTION or has_states(law)


@kernel
def contact_partials(
    end: np.record, law: np.record, table: Array, memory: Array, motion: ContactMotion, bounds: Array, out: Array
) -> None:
    """Fill ``out`` (RESULTS, PARTIALS) with the partial derivatives of `remembered_action`, within the bounds.

    They are exact; differences for a law that remembers, and for one of a user that does not compile for dual numbers.
    """
    remembered, held, known = remembered_of(memory), motion, False
    if not has_cells(end):
        if is_bounded(bounds):
            held = inside(end, law, table, remembered, motion, bounds, 0.0)
        known = _fill_along(end, law, table, remembered, held, 0, out)
        if known and has_states(law):
            known = _fill_along(end, law, table, remembered, held, DIRECTIONS, out)
    if not known:
        difference_partials(end, law, table, memory, motion, bounds, out)


@inlined_kernel
def along(partials: Array, motion: ContactMotion) -> Any:
    """Return the change of a contact's result with its motion as a dual number, from partial derivatives (PARTIALS,).

    The changes with the states are not among it, nor is the result itself.
    """
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    p = partials
    return p[0] * ex + p[1] * ey + p[2] * vx + p[3] * vy + p[4] * wb + p[5] * wj + p[6] * nx + p[7] * ny


@kernel
def _fill_along(
    end: np.record, law: np.record, table: Array, remembered: Remembered, motion: ContactMotion, first: int, out: Array,
) -> bool:  # fmt: skip
    """Fill columns of the exact derivatives: of the motion, or from the states on; False if they are unknown."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if ex == 0.0 and ey == 0.0:
        ex = CENTRE
    along = (
        seeded(ex, -first), seeded(ey, 1 - first), seeded(vx, 2 - first), seeded(vy, 3 - first),
        seeded(wb, 4 - first), seeded(wj, 5 - first), seeded(nx, 6 - first), seeded(ny, 7 - first),
    )  # fmt: skip
    latched, a, b, c = remembered
    place = MOTION - first
    states = seeded(latched, -1), seeded(a, place), seeded(b, place + 1), seeded(c, place + 2)
    found = contact_action(end, law, table, states, along)
    total = 0.0
    for k in range(RESULTS):
        put_slopes(out, k, first, found[k])
        total += found[k]
    return is_known(total)


@lazy_kernel(makes_arrays=True)
def difference_partials(
    end: np.record, law: np.record, table: Array, memory: Array, motion: ContactMotion, bounds: Array, out: Array
) -> None:
    """Fill ``out`` as `contact_partials`, by differences with a step for each input, away from the bounds.

    Central differences are accurate to 1e-7 of the largest change (measured: films 5e-8, contact 6e-8, both together
    1.4e-7). Forward differences take half as many evaluations and are accurate to 1e-6, more than Newton's method
    needs: for laws that remember, which are differentiated for it alone, of journals that cannot touch.
    """
    scales, change, both = np.zeros(INPUTS), np.zeros(INPUTS), not has_cells(end)
    input_scales(end, law, motion, scales)
    if is_bounded(bounds):
        motion = inside(end, law, table, remembered_of(memory), motion, bounds, AWAY * scales[SPEED])
    here = _action_along(end, law, table, memory, motion, change, 0.0)
    out[:] = 0.0
    for i in range(INPUTS):
        h = (STEP if both else _FORWARD) * scales[i]
        if not _counts(end, law, i) or h == 0.0:
            continue
        change[i] = 1.0
        low = _action_along(end, law, table, memory, motion, change, -h) if both else here
        high = _action_along(end, law, table, memory, motion, change, h)
        for k in range(RESULTS):
            out[k, i] = (high[k] - low[k]) / (2.0 * h if both else h)
        change[i] = 0.0
    _fill_own_turn(end, motion, out)
