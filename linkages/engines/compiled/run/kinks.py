"""Kinks: states at which a force is continuous but its slope jumps, other than the start and the end of a contact.

They are kinks of a contact's force, and of formulas, where a switch is zero: see `fill_switches`.

A step across a kink is no solution of smooth equations: its derivative has an error of the order of its size. Steps are
therefore differentiated in parts that end at kinks, and the steps of runs of high accuracy end there too: across a kink
their error can be 24 times the tolerance.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, kernel, lazy_kernel
from linkages.engines.compiled.run.equations import solve_state
from linkages.engines.compiled.run.methods import attempt
from linkages.engines.compiled.run.model import KINKS, RATIOS, SPEEDS, Equations
from linkages.laws import FRICTIONS
from linkages.laws.contact.contact_laws import CONTACTS, push, reference_speed
from linkages.laws.states import remembered_of
from linkages.mechanics.integrate.stepper import Stepper, copy
from linkages.mechanics.planar.arrays import functions_of
from linkages.mechanics.planar.contact_partials import DEPTH_FROM, DEPTH_TO, PUSH_FROM, RATIO_FROM, SLIDING_FROM
from linkages.mechanics.planar.contacts import CLOSING, LOAD, PENETRATION, SLIDING
from linkages.mechanics.planar.functions import given_at
from linkages.mechanics.planar.loads import acting_functions
from linkages.mechanics.planar.motion import fill_switches, switch_counts
from linkages.system import System

_TRIES = 40
_CLOSE = 1e-9  # of a kink's speed, or of the change of a switch in a step: a distance that counts as zero
_NEAR = 1e-7  # a step that starts so near to a kink starts at it
_SLOW = 1e-6  # smallest speed of a kink for that [m/s]


def kinks(system: System) -> Array:
    """Return the kinks of a system, (nc + nf, KINKS); NaN where there are fewer, and no lines without any.

    The first nc lines belong to the contacts: ratios of the speed to the speed at the start, sliding speeds, zero. The
    damping of a contact is limited. The last one is the zero of `push`: no contact pulls, so that the force of a law
    with much damping vanishes before the bodies part. Films have no kinks. The other lines belong to the switches of
    formulas, in the order of `fill_switches`: 0, or NaN if the motion does not depend on the formula.
    """
    switches = _switches(system)
    if not system.can_touch and not np.isfinite(switches).any():
        return np.zeros((0, KINKS))
    result = np.full((len(system.models), KINKS), np.nan)
    for row, model, law in zip(result, system.models, system.laws, strict=True):
        limit, chi = float(law["damping_limit"]), float(law["hysteresis"])
        if model.contact is not None and model.can_touch:
            if chi > 0.0 and math.isfinite(limit):
                row[:RATIOS] = limit, -limit
            if chi * limit > 1.0 or not CONTACTS[model.contact.law].chi:
                row[SPEEDS] = 0.0
        if model.can_touch and model.friction is not None and model.friction.acts:
            speeds = FRICTIONS[model.friction.law].kinks(model.friction.parameters)
            both = sorted({side * speed for speed in speeds for side in (-1.0, 1.0)})
            row[RATIOS : RATIOS + len(both)] = both
    return np.concatenate([result, switches])


def _switches(system: System) -> Array:
    """Return the lines of the switches of formulas, see `kinks`."""
    curves = system.motions.arrays, system.torques.arrays, system.loads[3:]
    drives = (np.ones(len(one[2]), bool) for one in curves[:2])
    told = system.elements.told["function"]
    counts = np.concatenate([switch_counts(*one[1:]) for one in curves])
    acts = np.repeat(np.concatenate([*drives, acting_functions(system.packed.functions, told)]), counts)
    lines = np.full((-(-len(acts) // KINKS), KINKS), np.nan)
    lines.reshape(-1)[: len(acts)][acts] = 0.0
    return lines


@kernel
def kink_values(equations: Equations, t: float, limits: Array, out: Array) -> None:
    """Fill ``out`` (nc + nf, KINKS) with the distances to the kinks at a state that is solved at time t.

    They are parts of the kinks' speeds, or of the change of a switch.
    """
    work, nc = equations.work, len(equations.model.ends)
    if len(limits) > nc:
        _switch_values(equations, t, limits, out)
    for k in range(nc):
        found, remembered = work.contacts[k], remembered_of(work.memory[k])
        began = reference_speed(remembered)
        for j in range(KINKS):
            out[k, j] = math.nan
            if limits[k, j] != limits[k, j]:
                continue
            if j < RATIOS:
                if began < math.inf:
                    out[k, j] = found[CLOSING] / began - limits[k, j]
            elif j == SPEEDS:
                out[k, j] = push(found[PENETRATION], found[CLOSING], remembered, equations.model.laws[k])
            else:
                out[k, j] = (found[SLIDING] - limits[k, j]) / max(abs(limits[k, j]), _SLOW)


@lazy_kernel(makes_arrays=True)
def _switch_values(equations: Equations, t: float, limits: Array, out: Array) -> None:
    """Fill the lines of the switches of formulas in ``out``; see `kink_values`."""
    model, work = equations.model, equations.work
    w, spans, nc = work.dynamics, work.kinked.spans, len(model.ends)
    curves, inputs = given_at(functions_of(model), t, w.v, w.pose, w.vel)
    values = out[nc:].reshape(-1)
    place = fill_switches((model.motion, model.motion_c, model.motion_n), inputs, 0, values)
    place = fill_switches((model.torque, model.torque_c, model.torque_n), inputs, place, values)
    fill_switches(curves, inputs, place, values)
    for k in range(nc, len(limits)):
        for j in range(KINKS):
            out[k, j] = out[k, j] / spans[k, j] if limits[k, j] == 0.0 else math.nan


@kernel
def _set_spans(equations: Equations, limits: Array) -> None:
    """Make the change of each switch in a step the unit of its distances; one that does not change has no side."""
    work = equations.work.kinked
    for k in range(len(equations.model.ends), len(limits)):
        for j in range(KINKS):
            span = abs(work.ends[k, j] - work.starts[k, j])
            work.spans[k, j] = span if span > 0.0 else 1.0
            work.starts[k, j] = work.starts[k, j] / span if span > 0.0 else math.nan
            work.ends[k, j] /= work.spans[k, j]


@kernel
def set_sides(equations: Equations, s: Stepper, t: float, h: float, y: Array, limits: Array) -> None:
    """Fill the sides of the kinks on which an attempted step from (t, y) starts; NaN where a contact does not act.

    A step that starts at a kink is on the side to which it moves, unless the step before has ended there. The equations
    are solved at the end of the step.
    """
    work, found, nc = equations.work.kinked, equations.work.contacts, len(equations.model.ends)
    work.spans[:] = 1.0
    solve_state(equations, t, y)
    kink_values(equations, t, limits, work.starts)
    for k in range(nc):
        work.touching[k] = 1.0 if found[k, PENETRATION] > 0.0 else 0.0
        work.acting[k] = 1.0 if work.touching[k] > 0.0 or found[k, LOAD] > 0.0 else 0.0
    solve_state(equations, t + h, s.new)
    kink_values(equations, t + h, limits, work.ends)
    _set_spans(equations, limits)
    for k in range(len(limits)):
        if k < nc and found[k, LOAD] > 0.0 and not found[k, PENETRATION] > 0.0:
            work.acting[k] = 1.0
        for j in range(KINKS):
            start = work.starts[k, j]
            if (k < nc and work.acting[k] == 0.0) or start != start:
                work.sides[k, j] = math.nan
            elif abs(start) > _NEAR:
                work.sides[k, j] = math.copysign(1.0, start)
            elif work.sides[k, j] != work.sides[k, j]:
                work.sides[k, j] = math.copysign(1.0, work.ends[k, j])


@kernel
def set_sides_here(equations: Equations, t: float, limits: Array) -> None:
    """Fill the sides of the contacts' kinks on which a state is that is solved at time t."""
    work = equations.work.kinked
    kink_values(equations, t, limits, work.starts)
    for k in range(len(equations.model.ends)):
        found = equations.work.contacts[k]
        work.touching[k] = 1.0 if found[PENETRATION] > 0.0 else 0.0
        for j in range(KINKS):
            work.sides[k, j] = math.nan
            if (found[PENETRATION] > 0.0 or found[LOAD] > 0.0) and work.starts[k, j] == work.starts[k, j]:
                work.sides[k, j] = math.copysign(1.0, work.starts[k, j])


@kernel
def shortened(equations: Equations, s: Stepper, t: float, h: float, y: Array, limits: Array) -> float:
    """Shorten an attempted step from (t, y) to end at its first kink, and attempt it; return its size, -1 if it failed.

    Regula falsi, with every third step a bisection. `set_sides` has been called; the side of the kink is changed.
    """
    work, low, high, size = equations.work.kinked, 0.0, h, h
    for trial in range(_TRIES):
        if trial > 0:
            solve_state(equations, t + size, s.new)
            kink_values(equations, t + size, limits, work.ends)
        kink, contact, root, value = -1, 0, math.inf, 0.0
        for k in range(len(limits)):
            for j in range(KINKS):
                start, end = work.starts[k, j] * work.sides[k, j], work.ends[k, j] * work.sides[k, j]
                if end < 0.0:
                    start = max(start, 0.0) + 0.5 * _CLOSE
                    own = low + (size - low) * start / (start - end)
                    if own < root:
                        kink, contact, root, value = j, k, own, end
        if kink < 0:
            if trial == 0:
                return h
            low, root = size, 0.5 * (size + high)
            for k in range(len(limits)):
                copy(work.ends[k], work.starts[k])
        elif value >= -_CLOSE or size - low <= 4e-16 * (t + h):
            work.sides[contact, kink] = -work.sides[contact, kink]
            for k in range(len(limits)):  # those at the same place
                for j in range(KINKS):
                    if -_CLOSE <= work.ends[k, j] * work.sides[k, j] < 0.0 and (k, j) != (contact, kink):
                        work.sides[k, j] = -work.sides[k, j]
            return size
        else:
            high = size
        size = 0.5 * (low + high) if trial % 3 == 2 or not low < root < high else root
        error, _ = attempt(equations, s, t, size, y, True)
        if not error <= 1.0:
            return -1.0
    return size


@kernel
def passed(equations: Equations, sides: Array) -> float:
    """Return by how much a step has passed the kinks of formulas at its end, in parts of the step that was attempted.

    ``sides`` are those before it was shortened.
    """
    work, most = equations.work.kinked, 0.0
    for k in range(len(equations.model.ends), len(sides)):
        for j in range(KINKS):
            if work.sides[k, j] * sides[k, j] < 0.0:
                most = max(most, -work.ends[k, j] * sides[k, j])
    return most


@kernel
def set_bounds(equations: Equations, limits: Array) -> None:
    """Fill the bounds of the contacts' speeds on the sides of the kinks; infinite where none acts."""
    work, bounds = equations.work.kinked, equations.work.scratch.bounds
    for k in range(len(equations.model.ends)):
        for first, last, place in ((0, RATIOS, RATIO_FROM), (RATIOS, SPEEDS, SLIDING_FROM), (SPEEDS, KINKS, PUSH_FROM)):
            low, high = -math.inf, math.inf
            for j in range(first, last):
                if work.sides[k, j] > 0.0:
                    low = max(low, limits[k, j])
                elif work.sides[k, j] < 0.0:
                    high = min(high, limits[k, j])
            bounds[k, place], bounds[k, place + 1] = low, high
        bounds[k, DEPTH_FROM], bounds[k, DEPTH_TO] = -math.inf, math.inf
        if equations.model.touching[k]:
            bounds[k, DEPTH_FROM if work.touching[k] > 0.0 else DEPTH_TO] = 0.0
