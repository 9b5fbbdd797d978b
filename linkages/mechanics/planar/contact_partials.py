"""Partial derivatives of a contact's results with respect to its motion, and then to the states of its laws."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from linkages.base.generated import lazy
from linkages.base.kernel import Array, Records, inlined_kernel, kernel
from linkages.base.kernel.dual import DIRECTIONS, is_known, put_slopes, seeded
from linkages.laws.contact.contact_laws import push, reference_speed
from linkages.laws.journal import ContactResults
from linkages.laws.states import STATES, Remembered, remembered_of
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.contacts import FIRST_RATE, RESULTS, ContactKind
from linkages.mechanics.planar.workspace import Workspace

#: Number of results that act on something: the action, and the rates of the states.
OUTPUTS = FIRST_RATE + STATES

STEP = 6e-6  #: in parts of an input's scale: the cube root of the rounding error minimises the error of the differences
AWAY = 3.0 * STEP  #: distance of differences from bounds, in parts of the scale of speeds
_FORWARD = 1e-8  # the same for forward differences: the square root of the rounding error

PARTIALS = 2 * DIRECTIONS  #: columns of partial derivatives: inputs, states, and zeros
DELTA, CLOSES, SLIDING = range(OUTPUTS, OUTPUTS + 3)  #: penetration, its rate, sliding speed among the results
#: Bounds within which a contact's force is smooth: ratio of the closing speed to the approach speed, sliding speed,
#: penetration, the law's force before its limit at zero.
RATIO_FROM, RATIO_TO, SLIDING_FROM, SLIDING_TO, DEPTH_FROM, DEPTH_TO, PUSH_FROM, PUSH_TO = range(8)
BOUNDS = 8
LEAST = 1e-11  # smallest penetration with bounds, in parts of the clearance: events are located to 1e-10
_SHARE, _STILL, _PUSHING = 1e-9, 1e-12, 1e-9  # least distances from bounds, above the rounding of speeds: see `inside`


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


@inlined_kernel
def _within(value: float, bounds: Array, first: int, share: float, margin: float) -> float:
    """Limit a value to within two bounds, a share of them and a margin away."""
    low, high = bounds[first], bounds[first + 1]
    if low > -math.inf:
        value = max(value, low + share * abs(low) + margin)
    if high < math.inf:
        value = min(value, high - share * abs(high) - margin)
    return value


@inlined_kernel
def has_states(law: np.record) -> bool:
    """Whether the laws of a contact have states."""
    return bool(law.contact_states + law.friction_states > 0)


class Derivatives(NamedTuple):
    """Kernels to differentiate the law of a kind of contact.

    Attributes
    ----------
    called : kernel
        ``called(law, table, remembered, motion)``, the results: an external function.
    inside : kernel
        ``inside(law, table, remembered, motion, bounds, margin)`` moves a motion a little, to where its penetration and
        speeds are within the bounds: the law is smooth there. Steps end at kinks, and just beyond the start or the end
        of a contact. The penetration becomes at least `LEAST` in magnitude: at zero a force or the rate of a state may
        jump. ``margin`` is a distance of the speeds from the bounds [m/s], in addition to a share of each, above their
        rounding.
    differences : kernel
        ``differences(law, table, memory, motion, bounds, out)`` fills ``out`` as `partials`, by differences.
    partials : function
        The loop ``partials(records, model, w, memory, bounds, out)``; see `_partials`.
    """

    called: Any
    inside: Any
    differences: Any
    partials: Callable[..., None]


def derivatives_of(module: str, kind: ContactKind) -> Derivatives:
    """Make the kernels of a kind; a module has the lazy ones."""
    called = _called(kind)
    inside = lazy(module, f"inside_{kind.name}", _inside(kind, called))
    differences = lazy(module, f"differences_{kind.name}", _differences(kind, called, inside), makes_arrays=True)
    return Derivatives(called, inside, differences, _partials(kind, called, inside, differences))


def _called(kind: ContactKind) -> Any:
    """Make an external function of a kind's action."""
    action = kind.action

    @kernel
    def called(law: np.record, table: Array, remembered: Remembered, motion: Any) -> ContactResults:
        return action(law, table, remembered, motion)

    return called


def _inside(kind: ContactKind, called: Any) -> Callable[..., Any]:
    shifted = kind.inputs.shifted

    def inside(law: np.record, table: Array, remembered: Remembered, motion: Any, bounds: Array, margin: float) -> Any:
        found = called(law, table, remembered, motion)
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
        return shifted(motion, depth - delta, close - closing, slide - sliding)

    inside.__annotations__["return"] = kind.inputs.motion
    return inside


def _partials(kind: ContactKind, called: Any, inside: Any, differences: Any) -> Callable[..., None]:
    """Make the loop that fills ``out`` (nc, RESULTS, PARTIALS) with the partial derivatives of results within bounds.

    They are exact; differences for a law that remembers, and for one of a user that does not compile for dual numbers.
    """
    frame_of, motion_of, fill_one = kind.frame, kind.motion, _filling(kind, called, inside, differences)

    def loop(records: Records, model: Arrays, w: Workspace, memory: Array, bounds: Array, out: Array) -> None:
        for i in range(len(records)):
            record = records[i]
            k = record.at
            frame = frame_of(model.ends[k], record, w.pose)
            motion = motion_of(model.ends[k], record, model.laws[k], frame, w.pose, w.vel)
            fill_one(model.laws[k], model.tables[k], memory[k], motion, bounds[k], out[k])

    return loop


def _filling(kind: ContactKind, called: Any, inside: Any, differences: Any) -> Any:
    """Make the kernel that fills the partial derivatives of one contact."""
    if kind.action_of_cells is not None:
        return differences
    fill, both = _fill_along(kind, called), kind.inputs.size + STATES > DIRECTIONS

    @inlined_kernel
    def fill_one(law: np.record, table: Array, memory: Array, motion: Any, bounds: Array, out: Array) -> None:
        remembered, held = remembered_of(memory), motion
        if is_bounded(bounds):
            held = inside(law, table, remembered, motion, bounds, 0.0)
        known = fill(law, table, remembered, held, 0, out)
        if known and both and has_states(law):
            known = fill(law, table, remembered, held, DIRECTIONS, out)
        if not known:
            differences(law, table, memory, motion, bounds, out)

    return fill_one


def _fill_along(kind: ContactKind, called: Any) -> Any:
    off_centre, seeded_along, count = kind.inputs.off_centre, kind.inputs.seeded, kind.inputs.size

    @kernel
    def fill_along(law: np.record, table: Array, remembered: Remembered, motion: Any, first: int, out: Array) -> bool:
        """Fill columns of the exact derivatives, from an input on; False if they are unknown."""
        latched, a, b, c = remembered
        place = count - first
        states = seeded(latched, -1), seeded(a, place), seeded(b, place + 1), seeded(c, place + 2)
        found = called(law, table, states, seeded_along(off_centre(motion), first))
        total = 0.0
        for k in range(RESULTS):
            put_slopes(out, k, first, found[k])
            total += found[k]
        return is_known(total)

    return fill_along


def _differences(kind: ContactKind, called: Any, inside: Any) -> Callable[..., None]:
    """Make the kernel that fills ``out`` by differences with a step for each input, away from the bounds.

    Central differences are accurate to 1e-7 of the largest change (measured: films 5e-8, contact 6e-8, both together
    1.4e-7). Forward differences take half as many evaluations and are accurate to 1e-6, more than Newton's method
    needs: for laws that remember, which are differentiated for it alone, of journals that cannot touch.
    """
    form, at, both, held = kind.inputs, _changed(kind, called), kind.action_of_cells is None, _held(kind, inside)
    fill_scales, complete, count, speed = form.fill_scales, form.complete, form.size, form.speed
    counts, inputs, step = np.array(form.counts), form.size + STATES, STEP if both else _FORWARD

    def differences(law: np.record, table: Array, memory: Array, motion: Any, bounds: Array, out: Array) -> None:
        scales, change = np.zeros(inputs), np.zeros(inputs)
        fill_scales(law, motion, scales)
        scales[count], scales[count + 1], scales[count + 2] = law.scale_0, law.scale_1, law.scale_2
        motion = held(law, table, memory, motion, bounds, AWAY * scales[speed])
        here = at(law, table, memory, motion, change, 0.0)
        out[:] = 0.0
        for i in range(inputs):
            h = step * scales[i]
            needed = counts[i] if i < count else has_states(law)
            if not needed or h == 0.0:
                continue
            change[i] = 1.0
            low = at(law, table, memory, motion, change, -h) if both else here
            high = at(law, table, memory, motion, change, h)
            for k in range(RESULTS):
                out[k, i] = (high[k] - low[k]) / (2.0 * h if both else h)
            change[i] = 0.0
        complete(motion, out)

    return differences


def _held(kind: ContactKind, inside: Any) -> Any:
    """Make the kernel that moves a motion to within the bounds; a kind with cells has none."""

    @inlined_kernel
    def free(law: np.record, table: Array, memory: Array, motion: Any, bounds: Array, margin: float) -> Any:
        return motion

    @inlined_kernel
    def held(law: np.record, table: Array, memory: Array, motion: Any, bounds: Array, margin: float) -> Any:
        return inside(law, table, remembered_of(memory), motion, bounds, margin) if is_bounded(bounds) else motion

    return held if kind.action_of_cells is None else free


def _changed(kind: ContactKind, called: Any) -> Any:
    """Make the kernel of the results at h times a change of the inputs and states."""
    moved, count = kind.inputs.moved, kind.inputs.size
    if kind.action_of_cells is not None:
        of_memory = _of_memory(kind.action_of_cells)

        @inlined_kernel
        def of_cells(
            law: np.record, table: Array, memory: Array, motion: Any, change: Array, h: float
        ) -> ContactResults:
            return of_memory(law, table, memory, moved(motion, change, h))

        return of_cells

    @inlined_kernel
    def of_states(law: np.record, table: Array, memory: Array, motion: Any, change: Array, h: float) -> ContactResults:
        latched, a, b, c = remembered_of(memory)
        states = latched, a + h * change[count], b + h * change[count + 1], c + h * change[count + 2]
        return called(law, table, states, moved(motion, change, h))

    return of_states


def _of_memory(of_cells: Any) -> Any:
    """Make the external function of the results of a kind with cells."""

    @kernel
    def results(law: np.record, table: Array, memory: Array, motion: Any) -> ContactResults:
        found, _, _ = of_cells(law, table, memory, motion)
        return found

    return results
