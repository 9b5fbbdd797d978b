"""Partial derivatives of a contact's force with respect to its motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.kernel import Array, clear, inlined_kernel, kernel
from linkages.kernel.dual import DIRECTIONS, is_known, number, put_slopes, seeded, slope
from linkages.laws.contact.contact_forces import GRAZING
from linkages.laws.contact.contact_laws import push
from linkages.laws.film.films import MAPPED
from linkages.laws.parameters import MODELS
from linkages.planar import contacts
from linkages.planar.contacts import APPROACH, BRISTLE, Motion, contact_action, remembered_action
from linkages.planar.record_types import CORNER, HISTORY, JOURNAL, ORIENTED, STOP, WORN

#: Inputs: the motion, that is e (2), its rate (2), angular velocities (2), normal into the wall or worn parts' angles
#: (2); bristle state.
INPUTS, MOTION = 9, 8
#: Outputs: force on the inner body, couple on it, rate of the bristles.
FORCE_X, FORCE_Y, COUPLE, BRISTLE_RATE = range(4)
OUTPUTS = 4

_STEP = 6e-6  # in parts of an input's scale: the cube root of the rounding error minimises the error of the differences
_FORWARD = 1e-8  # the same for forward differences: the square root of the rounding error
_NEAR = 1e-3  # lower limit of the gap that scales a displacement, in parts of the clearance
_CENTRE = 1e-12  # distance from the centre at which a centred contact is differentiated [m]
_INSIDE, _ASIDE = 1e-9, 1e-12  # margins within the bounds: of ratios; of the sliding speed, above its rounding [m/s]
_SLOW = 1e-9  # smallest speed that scales a velocity, clearances and lengths of 1 m per second


#: Changes of the inputs of a contact of `stencil_step`: the entries of `Motion`, the bristle state, and the approach
#: speed.
APPROACHING = INPUTS
CHANGES = INPUTS + 1
PARTIALS = 2 * DIRECTIONS  #: columns of partial derivatives: `CHANGES`, and zeros
#: Results of `contact_action`: the outputs, penetration, its rate, sliding speed, load.
RESULTS = 8
DELTA, _CLOSING, _SLIDING, _LOAD = 4, 5, 6, 7
#: Their places in `linkages.planar.contacts.CLEARANCE_OUTPUTS`.
RESULT_PLACES = (
    contacts.FX, contacts.FY, contacts.COUPLE, contacts.BRISTLE_RATE,
    contacts.PENETRATION, contacts.CLOSING, contacts.SLIDING, contacts.LOAD,
)  # fmt: skip
#: Bounds within which a contact's force is smooth: ratio of the closing speed to the approach speed, sliding speed,
#: penetration, the law's force before its limit at zero; the smallest sliding speed over which friction changes
#: smoothly; and whether differences of the fourth order are taken without any of these bounds too.
RATIO_FROM, RATIO_TO, SLIDING_FROM, SLIDING_TO, DEPTH_FROM, DEPTH_TO, PUSH_FROM, PUSH_TO, FRICTION_SPEED, FINE = range(
    10
)
BOUNDS = 10
#: Quantities that are bounded.
BOUNDED = FRICTION_SPEED // 2
_SHARE = 0.01  # of that speed in a step
#: Weights of differences of the fourth order, at -2 to 2 steps, 0 to 4, and -4 to 0, and of central ones of the second
#: order; the first place of each.
WEIGHTS = np.array(
    [
        [1 / 12, -2 / 3, 0.0, 2 / 3, -1 / 12],
        [-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4],
        [1 / 4, -4 / 3, 3.0, -4.0, 25 / 12],
        [0.0, -1 / 2, 0.0, 1 / 2, 0.0],
    ]
)
PLACES = (-2, 0, -4, -2)
POINTS = 5
FOURTH, SECOND = 0, 3  # kinds of central differences: lines of `WEIGHTS`
# Step of differences of the fourth order, in parts of the smallest scale over its change: with a film; with a film that
# a map gives, whose third derivatives jump at the nodes, so that the error is proportional to the step; and of dry
# contacts, where it is longer and follows the penetration closely, because the penetration, a small difference of
# lengths, has few digits.
_WIDE, _WIDE_MAPPED, _WIDE_DRY = 1e-4, 1e-5, 1e-3
_DEEP = 2.0  # factor of the penetration as a scale of dry contacts; with 3, differences cross kinks of friction
_NEAR_DRY = 1e-9  # lower limit of the penetration as a scale of dry contacts, in parts of the clearance
LEAST = 1e-11  # smallest penetration with bounds, in parts of the clearance: events are located to 1e-10
_DRY, _LUBRICATED = MODELS["dry"], MODELS["lubricated"]
_EMPTY = 1e-9  # smallest room between bounds, in steps
_BEYOND = 1e-3  # greatest distance of a state beyond a bound that is corrected, in steps
_ROOM = 0.9  # part of the room that differences use: its bounds are extrapolated linearly


@kernel
def input_scales(end: np.record, law: np.record, motion: Motion, near: float, out: Array) -> None:
    """Fill ``out`` (INPUTS,) with the change of each input over which a contact's force changes.

    The gap counts as ``near`` times the clearance, at least.
    """
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    corner = end.kind == CORNER
    c = law.clearance
    distance = math.hypot(ex, ey)
    open_by = c + end.half - ex * nx - ey * ny if corner else c - distance
    if end.kind == STOP:
        open_by = c + end.half - end.nx * (ny - nx)
    gap = max(abs(open_by), near * c)
    speed = math.hypot(vx, vy) + c * (abs(wb) + abs(wj)) + _SLOW
    lever = max(law.radius, c)
    spin = abs(wb) + abs(wj) + speed / lever
    turn = gap / (max(distance, gap) if corner else lever)  # by the gap, seen from the corner or on a worn surface
    if end.kind == STOP:
        turn = gap
    out[0], out[1], out[2], out[3], out[4], out[5] = gap, gap, speed, speed, spin, spin
    out[6], out[7], out[8] = turn, turn, law.bristle_scale


@inlined_kernel
def _moved(motion: Motion, change: Array, h: float) -> Motion:
    """Move the motion of a contact by h times a change."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    return (
        ex + h * change[0],
        ey + h * change[1],
        vx + h * change[2],
        vy + h * change[3],
        wb + h * change[4],
        wj + h * change[5],
        nx + h * change[6],
        ny + h * change[7],
    )


@kernel
def stencil_step(
    end: np.record,
    law: np.record,
    approach: float,
    motion: Motion,
    change: Array,
    value: float,
    gap: float,
    room: Array,
) -> float:
    """Choose the step of differences along a direction, in parts of the changes; zero if nothing changes.

    Parameters
    ----------
    change : (CHANGES,) array
        Of the arguments along the direction.
    value : float
        Change of a law's parameters along the direction, in parts of their magnitudes.
    gap : float
        Change of the gap along the direction by numbers other than the motion, such as the clearance.
    room : (INPUTS,) array
        To work in.
    """
    dry = law.model == _DRY
    input_scales(end, law, motion, _NEAR_DRY if dry else _NEAR, room)
    if dry:
        room[0], room[1] = _DEEP * room[0], _DEEP * room[1]
    step = _WIDE_DRY if dry else (_WIDE_MAPPED if law.film == MAPPED else _WIDE)
    return step * _reach(approach, change, value, gap, room)


@kernel
def gap_step(end: np.record, law: np.record, motion: Motion, change: Array, gap: float, room: Array) -> float:
    """Choose the step of differences of penetration and speeds, which are smooth whether the bodies touch or not.

    Arguments as of `stencil_step`.
    """
    input_scales(end, law, motion, 1.0, room)
    return _WIDE_DRY * _reach(math.inf, change, 0.0, gap, room)


@inlined_kernel
def film_step(law: np.record, delta: float) -> float:
    """Choose the step of central differences of a film with a penetration along a value, in parts of the value."""
    return _STEP * min(1.0, max(_NEAR, -delta / law.clearance))


@inlined_kernel
def is_film(law: np.record) -> bool:
    """Whether a contact is a film alone, whose force is a smooth function."""
    return bool(law.model == _LUBRICATED)


@kernel
def _reach(approach: float, change: Array, value: float, gap: float, scales: Array) -> float:
    """Smallest of the scales of the inputs over their changes; zero if nothing changes."""
    worst = max(value, gap / scales[0])
    for i in range(INPUTS):
        if change[i] != 0.0 and scales[i] > 0.0:
            worst = max(worst, abs(change[i]) / scales[i])
    if 0.0 < approach < math.inf:
        worst = max(worst, abs(change[APPROACHING]) / approach)
    return 1.0 / worst if worst > 0.0 else 0.0


@inlined_kernel
def _note_bounded(found: Any, law: np.record, approach: float, bounds: Array, out: Array) -> None:
    """Fill ``out`` (BOUNDED,) with the quantities that the bounds limit, from the results of `contact_action`."""
    out[0], out[1], out[2], out[3] = found[_CLOSING] / approach, found[_SLIDING], found[DELTA], 0.0
    if bounds[PUSH_FROM] > -math.inf or bounds[PUSH_TO] < math.inf:
        out[3] = push(found[DELTA], found[_CLOSING], approach, law)


@kernel
def bounded_values(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: Motion, change: Array,
    s: float, bounds: Array, out: Array,
) -> None:  # fmt: skip
    """Fill ``out`` (BOUNDED,) with the quantities that the bounds limit, at s times a change."""
    z, began = bristle + s * change[INPUTS - 1], approach + s * change[APPROACHING]
    _note_bounded(contact_action(end, law, table, began, z, _moved(motion, change, s)), law, began, bounds, out)


def no_bounds() -> Array:
    """Return the bounds of a contact without any, (BOUNDS,); differences are of the second order."""
    bounds = np.full(BOUNDS, np.inf)
    bounds[:FRICTION_SPEED:2], bounds[FINE] = -np.inf, 0.0
    return bounds


@kernel
def is_bounded(bounds: Array) -> bool:
    """Whether any quantity of a contact is bounded."""
    found = False
    for i in range(0, FRICTION_SPEED, 2):
        found = found or bounds[i] > -math.inf or bounds[i + 1] < math.inf
    return found or bounds[FRICTION_SPEED] < math.inf


@kernel
def place_stencil(h: float, bounds: Array, moving: Array, seen: Array) -> tuple[float, int, float]:
    """Place differences with the step h so that they stay within the bounds.

    A stage of a step that ends at a kink may lie a little beyond it: the differences then begin at the bound.

    Parameters
    ----------
    moving : (FRICTION_SPEED,) array
        Changes of the bounds along the direction.
    seen : (3, BOUNDED) array
        `bounded_values` at -1, 0 and 1 steps.

    Returns
    -------
    step : float
        At most h.
    kind : int
        Line of `WEIGHTS`.
    start : float
        Place of the differences along the direction; 0 within the bounds.
    """
    low, high, given = -math.inf, math.inf, h
    sliding = abs(seen[2, 1] - seen[0, 1]) / (2.0 * h)
    if sliding * h > _SHARE * bounds[FRICTION_SPEED]:
        h = _SHARE * bounds[FRICTION_SPEED] / sliding
    for i in range(FRICTION_SPEED):
        rate, here = (seen[2, i // 2] - seen[0, i // 2]) / (2.0 * given) - moving[i], seen[1, i // 2]
        if rate != 0.0 and abs(rate) * given > 1e-14 * abs(here):
            place = (bounds[i] - here) / rate
            if (i % 2 == 0) == (rate > 0.0):  # a lower bound from which the quantity recedes, or an upper one
                low = max(low, place)
            else:
                high = min(high, place)
    start = low if low > 0.0 else min(high, 0.0)
    if abs(start) > _BEYOND * given:  # the direction hardly changes the quantity
        start = 0.0
    low, high = _ROOM * (low - start), _ROOM * (high - start)
    if low <= -2.0 * h and high >= 2.0 * h:
        return h, 0, 0.0
    if max(high, -low) < _EMPTY * given:  # no room between two bounds: of several kinds, at one state
        return h, 0, 0.0
    if high >= -low:
        return min(h, 0.25 * high), 1, start
    return min(h, -0.25 * low), 2, start


@kernel
def deeper(end: np.record, motion: Motion, depth: float) -> Motion:
    """Increase the penetration of a contact by a small depth, in the direction of its normal."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if end.kind == STOP:
        return ex, ey, vx, vy, wb, wj, nx, ny + end.nx * depth
    if end.kind == CORNER:
        return ex + nx * depth, ey + ny * depth, vx, vy, wb, wj, nx, ny
    distance = math.hypot(ex, ey)
    if distance == 0.0:
        return motion
    factor = 1.0 + depth / distance
    return factor * ex, factor * ey, vx, vy, wb, wj, nx, ny


@kernel
def inside(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: Motion, bounds: Array
) -> Motion:
    """Move a motion to where its penetration and speeds are within the bounds: a stage of a step lies a little beyond.

    The penetration becomes at least `LEAST` in magnitude: at zero a force or the rate of the bristles may jump.
    """
    found = contact_action(end, law, table, approach, bristle, motion)
    delta, closing, sliding = found[DELTA], found[_CLOSING], found[_SLIDING]
    depth = _within(delta, bounds, DEPTH_FROM, LEAST * law.clearance)
    aside = _within(sliding, bounds, SLIDING_FROM, _ASIDE)
    faster, began = closing, max(approach, GRAZING)
    if began < math.inf:
        faster = began * _within(closing / began, bounds, RATIO_FROM, _INSIDE)
        pushed = push(depth, seeded(faster, 0), began, law)
        less = _within(number(pushed), bounds, PUSH_FROM, _INSIDE) - number(pushed)
        if less != 0.0 and slope(pushed, 0) != 0.0:
            faster += less / slope(pushed, 0)
    return _shifted(end, motion, depth - delta, faster - closing, aside - sliding)


@inlined_kernel
def _within(x: float, bounds: Array, first: int, margin: float) -> float:
    """Move a quantity to within its bounds, by a margin."""
    low, high = bounds[first], bounds[first + 1]
    return max(min(x, high - margin), low + margin)


@inlined_kernel
def _shifted(end: np.record, motion: Motion, depth: float, faster: float, aside: float) -> Motion:
    """Change the penetration of a contact, its rate and the sliding speed."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if end.kind == STOP:
        return ex, ey, vx, vy, wb, wj + end.nx * faster, nx, ny + end.nx * depth
    ux, uy = nx, ny
    if end.kind != CORNER:
        distance = math.hypot(ex, ey)
        ux, uy = (ex / distance, ey / distance) if distance > 0.0 else (1.0, 0.0)
    vx, vy = vx + faster * ux - aside * uy, vy + faster * uy + aside * ux
    return ex + depth * ux, ey + depth * uy, vx, vy, wb, wj, nx, ny


@kernel
def add_contact_change(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: Motion, change: Array,
    s: float, weight: float, out: Array,
) -> None:  # fmt: skip
    """Add the results of `contact_action` at s times a change, times a weight, to ``out`` (RESULTS,)."""
    z = bristle + s * change[INPUTS - 1]
    found = contact_action(end, law, table, approach + s * change[APPROACHING], z, _moved(motion, change, s))
    for i in range(RESULTS):
        out[i] += weight * found[i]


@kernel
def _fill_differences(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: Motion, change: Array,
    h: float, kind: int, start: float, out: Array,
) -> None:  # fmt: skip
    """Fill ``out`` (RESULTS,) with differences of a kind along a change, from a place on."""
    clear(out)
    for point in range(POINTS):
        weight = WEIGHTS[kind, point]
        if weight != 0.0:
            s = start + (PLACES[kind] + point) * h
            add_contact_change(end, law, table, approach, bristle, motion, change, s, weight / h, out)


@inlined_kernel
def _is_journal(end: np.record) -> bool:
    return bool(end.kind == JOURNAL or end.kind == ORIENTED or end.kind == HISTORY)


@inlined_kernel
def _fill_own_turn(end: np.record, motion: Motion, out: Array) -> None:
    """Fill the derivatives of a journal's results with respect to its own angular velocity from the others.

    The results are the same for observers who turn at different rates: dF/dw_j = e_y dF/dv_x - e_x dF/dv_y - dF/dw_b.
    """
    if _is_journal(end):
        ex, ey, _, _, _, _, _, _ = motion
        for k in range(RESULTS):
            out[k, 5] = ey * out[k, 2] - ex * out[k, 3] - out[k, 4]


@inlined_kernel
def _counts(end: np.record, law: np.record, i: int) -> bool:
    """Whether differences with respect to input i are needed."""
    if i == 5:
        return not _is_journal(end)
    if i == 6:
        return bool(end.kind != JOURNAL)
    if i == 7:
        return bool(end.kind == CORNER or end.kind == STOP or end.kind == WORN)
    return i != 8 or law.bristle_scale != 0.0


@kernel
def contact_partials(
    end: np.record, law: np.record, table: Array, memory: Array, motion: Motion, bounds: Array, exact: bool, out: Array
) -> None:
    """Fill ``out`` (RESULTS, PARTIALS) with the partial derivatives of `remembered_action`, within the bounds.

    They are exact; differences for a film with history, and for a law of a user that does not compile for dual numbers.

    Parameters
    ----------
    exact : bool
        Whether the derivatives with respect to the approach speed are wanted, and differences with more digits.
    """
    approach, bristle, known = memory[APPROACH], memory[BRISTLE], False
    if end.kind != HISTORY:
        if is_bounded(bounds):
            motion = inside(end, law, table, approach, bristle, motion, bounds)
        known = _fill_along(end, law, table, approach, bristle, motion, 0, out)
        if known and (exact or law.bristle_scale != 0.0):
            known = _fill_along(end, law, table, approach, bristle, motion, DIRECTIONS, out)
    if not known:
        _difference_partials(end, law, table, memory, motion, exact, out)


@kernel
def _fill_along(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: Motion, first: int,
    out: Array,
) -> bool:  # fmt: skip
    """Fill columns of the exact derivatives: of the motion, or from the bristle state on; False if they are unknown."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if ex == 0.0 and ey == 0.0:
        ex = _CENTRE
    along = (
        seeded(ex, -first), seeded(ey, 1 - first), seeded(vx, 2 - first), seeded(vy, 3 - first),
        seeded(wb, 4 - first), seeded(wj, 5 - first), seeded(nx, 6 - first), seeded(ny, 7 - first),
    )  # fmt: skip
    z, began = seeded(bristle, INPUTS - 1 - first), seeded(approach, APPROACHING - first)
    found = contact_action(end, law, table, began, z, along)
    total = 0.0
    for k in range(RESULTS):
        put_slopes(out, k, first, found[k])
        total += found[k]
    return is_known(total)


@kernel
def _difference_partials(
    end: np.record, law: np.record, table: Array, memory: Array, motion: Motion, exact: bool, out: Array
) -> None:
    """Fill ``out`` as `contact_partials`, by differences with a step for each input, without bounds.

    Central differences are accurate to 1e-7 of the largest change (measured: films 5e-8, contact 6e-8, both together
    1.4e-7). Forward differences take half as many evaluations and are accurate to 1e-6 for films, more than Newton's
    method needs. Where bodies can touch, differences are central: the penetration, a small difference of lengths, has
    too few digits.
    """
    scales, z = np.empty(INPUTS), memory[BRISTLE]
    input_scales(end, law, motion, _NEAR, scales)
    here = remembered_action(end, law, table, memory, z, motion)
    both = exact or not is_film(law)
    clear(out)
    change = np.zeros(CHANGES)
    for i in range(INPUTS):
        h = (_STEP if both else _FORWARD) * scales[i]
        if not _counts(end, law, i) or h == 0.0:
            continue
        change[i] = 1.0
        low = here
        if both:
            low = remembered_action(end, law, table, memory, z - h * change[INPUTS - 1], _moved(motion, change, -h))
        high = remembered_action(end, law, table, memory, z + h * change[INPUTS - 1], _moved(motion, change, h))
        for k in range(RESULTS):
            out[k, i] = (high[k] - low[k]) / (2.0 * h if both else h)
        change[i] = 0.0
    _fill_own_turn(end, motion, out)
