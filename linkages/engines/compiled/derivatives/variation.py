"""The equations of a model whose numbers are duals: their derivatives along columns of derivatives of the state.

A column is a derivative of the state with respect to anything; the last np columns belong to values of the system. The
numbers of the model have slopes along the values, which neighbouring systems give
(`linkages.engines.compiled.derivatives.neighbours`): lengths through the assembly, a contact's stiffness through its
material. So one evaluation of the equations with duals gives their derivatives along `DIRECTIONS` columns.

Example: a journal of mass m in a film, in a bearing at x, R = F(q - x, c) + m g - m a. Along the clearance c the slope
of R is dF/dc, by the law's own arithmetic; along x it is -F'; along m it is g - a.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, cast

import numpy as np

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.block import Block
from linkages.base.kernel.by_reference import packed
from linkages.base.kernel.dual import DIRECTIONS, dual_array, is_known, number, seeded, slope, with_number
from linkages.base.kernel.dual_copy import DualCopy
from linkages.elements.machine import add_elements
from linkages.engines.compiled.derivatives.neighbours import Neighbours, unscaled
from linkages.engines.compiled.derivatives.start_derivatives import start_derivatives
from linkages.engines.compiled.run.equations import set_residuals, set_state
from linkages.engines.compiled.run.jacobian import fill_solved, fill_states, put
from linkages.engines.compiled.run.job import Given, model_of
from linkages.engines.compiled.run.model import Equations
from linkages.laws.states import FIRST_STATE, LATCHED, REMEMBERED, STATES, Remembered, remembered_of
from linkages.mechanics.planar.arrays import Arrays, functions_of, size_of
from linkages.mechanics.planar.contact_partials import (
    AWAY,
    CENTRE,
    GAP,
    INPUTS,
    MOTION,
    OUTPUTS,
    PARTIALS,
    SPEED,
    STEP,
    along,
    difference_partials,
    input_scales,
    inside,
    is_bounded,
)
from linkages.mechanics.planar.contacts import (
    EX,
    EY,
    RATES,
    RESULT_PLACES,
    RESULTS,
    WIDTH,
    ContactMotion,
    add_contact,
    contact_action,
    contact_motion,
)
from linkages.mechanics.planar.reactive_loads import ReactiveLoads, add_applied, make_reactive_loads
from linkages.mechanics.planar.workspace import Workspace, make_workspace
from linkages.results.outputs.registry import pack
from linkages.system import System


class DualWork(NamedTuple):
    """Arrays that an evaluation with duals fills; as in `linkages.engines.compiled.run.model.Work`, but of duals.

    The last ones are the memory of three others, which kernels fill slope by slope: a number, then its slopes.
    """

    dynamics: Workspace
    solved: Array  # not used, (1,)
    contacts: Array  # (nc, WIDTH)
    memory: Array  # (nc, REMEMBERED)
    value: Array
    rate: Array
    second: Array
    reactive: ReactiveLoads
    rows: Array  # accelerations or errors of the closure rows, (nr,)
    y: Array  # (ny,)
    results: Array  # of a contact, (RESULTS,)
    push: Array  # change of a contact's action, (OUTPUTS,)
    numbers_y: Array  # (ny, 1 + DIRECTIONS)
    numbers_memory: Array  # (nc, REMEMBERED, 1 + DIRECTIONS)
    numbers_results: Array  # (RESULTS, 1 + DIRECTIONS)
    changes: Array  # of the residual, floats, (k, np + nc): along the values and the latched states
    partials: Array  # of a contact, floats, (RESULTS, PARTIALS)


class Variation(NamedTuple):
    """A model of duals, and what changes with each of np values.

    Attributes
    ----------
    model : Arrays
        Of duals.
    work : DualWork
    slots : (nw, 1 + DIRECTIONS) array
        Memory of the model.
    moved : Arrays
        A model of floats, for laws that do not compile for duals.
    memory : (nw,) array
        Its memory.
    first : (np + 1,) array of int
        First of the changed numbers of each value, in the next three arrays.
    places, spots : arrays of int
        Their indices in the memories of the two models.
    numbers : array
        They themselves.
    rates : array
        Their derivatives with respect to the value.
    unit : (np,) array
        Magnitude of the value.
    chosen : (1,) array of int
        Value of the first direction; may be less than zero.
    """

    model: Arrays
    work: DualWork
    slots: Array
    moved: Arrays
    memory: Array
    first: Indices
    places: Indices
    spots: Indices
    numbers: Array
    rates: Array
    unit: Array
    chosen: Indices


def vary(system: System, nearby: Sequence[Neighbours], given: Given) -> tuple[Variation, Array]:
    """Return the variation of a system with np values, and the derivatives of its start, (ny, np).

    Raises
    ------
    InputError
        If a value has no derivative.
    """
    model, none = given.model, pack(system, ())
    duals, moved = DualCopy(model), Block(model)
    whole = model is system.arrays  # no sections of links are left out

    def reduced(one: System) -> Arrays:
        return unscaled(model_of(one, none))

    changes = [near.arrays if whole else near.rates(reduced) for near in nearby]
    places = np.concatenate([np.zeros(0, np.int64), *(one.places for one in changes)])
    memory, spots = moved.memory.view(np.float64), moved.where[places]
    variation = Variation(
        duals.value,
        _make_work(model, len(nearby)),
        duals.memory,
        cast(Arrays, moved),
        memory,
        np.cumsum([0, *(len(one.places) for one in changes)]),
        places,
        spots,
        memory[spots],
        np.concatenate([np.zeros(0), *(one.rates for one in changes)]),
        np.array([near.magnitude for near in nearby]),
        np.array([len(nearby)]),
    )
    return packed(variation), start_derivatives(system, nearby)


def _make_work(model: Arrays, count: int) -> DualWork:
    """Make the arrays for a model and so many values."""
    nb, nr, nc, nd = len(model.bodies.records), len(model.rows), len(model.ends), len(model.driven)
    n, most = size_of(model), max(nd, len(model.powered))
    state = make_workspace(nb, n, nr, model.bodies.shapes.shape[2])
    dynamics, reactive = DualCopy(state).value, DualCopy(make_reactive_loads(model, state)).value
    ny = 2 * len(model.free) + len(model.law_states) + len(model.states)
    y, memory, results = dual_array(ny), dual_array(nc, REMEMBERED), dual_array(RESULTS)
    motions = (dual_array(most) for _ in range(3))
    own = dual_array(nc, WIDTH), memory, *motions, reactive, dual_array(nr), y, results, dual_array(OUTPUTS)
    floats = np.zeros((len(y) - len(model.free), count + nc * LATCHED)), np.zeros((RESULTS, PARTIALS))
    slots = (one.view(np.ndarray) for one in (y, memory, results))
    return DualWork._make([dynamics, np.zeros(1), *own, *slots, *floats])


@inlined_kernel
def first_of(last: int) -> int:
    """First of the columns before the last one whose slopes are found together."""
    return max(last - DIRECTIONS, 0)


@kernel
def _choose(v: Variation, value: int) -> None:
    """Make the slopes of the model those along `DIRECTIONS` values from this one on; of others there are none."""
    old = v.chosen[0]
    if old == value:
        return
    for p in range(max(old, 0), min(old + DIRECTIONS, len(v.unit))):
        for i in range(v.first[p], v.first[p + 1]):
            v.slots[v.places[i], 1 + p - old] = 0.0
    for p in range(max(value, 0), min(value + DIRECTIONS, len(v.unit))):
        for i in range(v.first[p], v.first[p + 1]):
            v.slots[v.places[i], 1 + p - value] = v.rates[i]
    v.chosen[0] = value


@kernel
def set_columns(
    equations: Equations, v: Variation, t: float, y: Array, columns: Array, remembered: Array, first: int, last: int
) -> None:
    """Set the dual state at (t, y): slopes are those along columns from the first one to before the last one.

    Parameters
    ----------
    columns : (ny, m) array
    remembered : (nl, m) array
        Those of the latched states of the contacts.
    """
    work = v.work
    _choose(v, first - (columns.shape[1] - len(v.unit)))
    _set_numbers(equations, work, y)
    for j in range(first, last):
        for i in range(len(y)):
            work.numbers_y[i, 1 + j - first] = columns[i, j]
        for k in range(len(remembered)):
            work.numbers_memory[k // LATCHED, k % LATCHED, 1 + j - first] = remembered[k, j]
    set_state(v.model, work, seeded(t, -1), work.y)  # type: ignore[arg-type]


@kernel
def set_over_time(equations: Equations, v: Variation, t: float, y: Array, dy: Array) -> None:
    """Set the dual state at (t, y): the first slope is that over time at the rate ``dy`` of the state."""
    _choose(v, len(v.unit))
    _set_numbers(equations, v.work, y)
    for i in range(len(y)):
        v.work.numbers_y[i, 1] = dy[i]
    set_state(v.model, v.work, seeded(t, 0), v.work.y)  # type: ignore[arg-type]


@kernel
def _set_numbers(equations: Equations, work: DualWork, y: Array) -> None:
    """Set the numbers of the dual state and of the dual memory, without slopes."""
    for i in range(len(y)):
        work.numbers_y[i] = 0.0
        work.numbers_y[i, 0] = y[i]
    work.numbers_memory[:] = 0.0
    for k in range(len(work.memory)):
        for i in range(REMEMBERED):
            work.numbers_memory[k, i, 0] = equations.work.memory[k, i]


@kernel
def fill_forcing(
    equations: Equations, v: Variation, t: float, y: Array, dy: Array, remembered: Array, out: Array
) -> None:
    """Fill ``out`` (k, m) with the derivatives of the residual along the columns, at a fixed state.

    They follow the values, of the last columns, and the latched states, whose columns are ``remembered`` (nl, m). The
    mass matrix has been found at (t, y), where ``dy`` are the derivatives of rates and others.
    """
    work, m, count, nl = v.work, out.shape[1], len(v.unit), len(remembered)
    wanted = count
    for k in range(nl):
        if _any(remembered[k]):
            wanted = count + nl
    for first in range(0, wanted, DIRECTIONS):
        _choose(v, first)
        _set_numbers(equations, work, y)
        for k in range(nl):
            if 0 <= count + k - first < DIRECTIONS and _any(remembered[k]):
                work.numbers_memory[k // LATCHED, k % LATCHED, 1 + count + k - first] = 1.0
        set_state(v.model, work, seeded(t, -1), work.y)  # type: ignore[arg-type]
        set_contacts(equations, v)
        fill_residual(equations, v, t, dy, first, min(first + DIRECTIONS, wanted), work.changes)
    for i in range(len(out)):
        for j in range(m):
            out[i, j] = work.changes[i, count - m + j] if j >= m - count else 0.0
            for k in range(wanted - count):
                out[i, j] += work.changes[i, count + k] * remembered[k, j]


@kernel
def _any(values: Array) -> bool:
    """Whether any of the values is not zero."""
    found = False
    for value in values:
        found = found or value != 0.0
    return found


@kernel
def set_contacts(equations: Equations, v: Variation) -> None:
    """Fill the contacts, and the wrenches on the bodies, at a dual state that is set."""
    w, contacts = v.work.dynamics, v.work.contacts
    w.wrench[:] = 0.0
    for k in range(len(v.model.ends)):
        end = v.model.ends[k]
        motion, arms = contact_motion(end, w.pose, w.vel)
        set_results(equations, v, k, motion)
        found = v.work.results
        add_contact(w.wrench, end, w.pose, motion[0], motion[1], arms, found[0], found[1], found[2])
        contacts[k, EX], contacts[k, EY] = motion[0], motion[1]
        for i in range(RESULTS):
            contacts[k, RESULT_PLACES[i]] = found[i]


@kernel
def set_results(equations: Equations, v: Variation, k: int, motion: ContactMotion) -> None:
    """Fill ``results`` of contact k at a dual motion, within the bounds; of differences where its law has no duals."""
    model, bounds, memory, out = equations.model, equations.work.scratch.bounds[k], v.work.memory[k], v.work.results
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    held = (number(ex), number(ey), number(vx), number(vy), number(wb), number(wj), number(nx), number(ny))
    if is_bounded(bounds):
        held = inside(model.ends[k], model.laws[k], model.tables[k], _numbers_of(memory), held, bounds, 0.0)
    if held[0] == 0.0 and held[1] == 0.0:
        held = (CENTRE, held[1], held[2], held[3], held[4], held[5], held[6], held[7])
    moved = (
        with_number(ex, held[0]), with_number(ey, held[1]), with_number(vx, held[2]), with_number(vy, held[3]),
        with_number(wb, held[4]), with_number(wj, held[5]), with_number(nx, held[6]), with_number(ny, held[7]),
    )  # fmt: skip
    end, law, table = v.model.ends[k], v.model.laws[k], v.model.tables[k]
    found = contact_action(end, law, table, remembered_of(memory), moved)
    total = 0.0
    for i in range(RESULTS):
        out[i] = found[i]
        total += found[i]
    if not is_known(total):
        _set_differences(equations, v, k, moved)


@inlined_kernel
def _numbers_of(memory: Array) -> Remembered:
    """Return what a contact remembers, without derivatives."""
    latched, a, b, c = remembered_of(memory)
    return number(latched), number(a), number(b), number(c)


@lazy_kernel(makes_arrays=True)
def _set_differences(equations: Equations, v: Variation, k: int, motion: ContactMotion) -> None:
    """Fill ``results`` of contact k with central differences, along its motion, its memory and the values."""
    model, memory, partials, scales = equations.model, v.work.memory[k], v.work.partials, np.zeros(INPUTS)
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    at = (number(ex), number(ey), number(vx), number(vy), number(wb), number(wj), number(nx), number(ny))
    end, law, table, bounds = model.ends[k], model.laws[k], model.tables[k], equations.work.scratch.bounds[k]
    at_hand = latched, a, b, c = _numbers_of(memory)
    difference_partials(end, law, table, equations.work.memory[k], at, bounds, partials)
    here = contact_action(end, law, table, at_hand, at)
    for i in range(RESULTS):
        total = along(partials[i], motion)
        for j in range(STATES):
            total += partials[i, MOTION + j] * memory[FIRST_STATE + j]
        v.work.results[i] = with_number(total, here[i])
    input_scales(end, law, at, scales)
    if is_bounded(bounds):
        at = inside(end, law, table, at_hand, at, bounds, AWAY * scales[SPEED])
    for j in range(DIRECTIONS):
        p, faster, began = v.chosen[0] + j, slope(memory[0], j), latched
        known, worst = 0 <= p < len(v.unit), abs(faster) / began if began > 0.0 else 0.0
        if known:
            worst = max(
                worst, 1.0 / v.unit[p], abs(slope(v.model.laws[k].clearance, j)) / min(scales[GAP], law.clearance)
            )
        if not 0.0 < worst < math.inf:
            continue
        for side in (1.0, -1.0):
            h = side * STEP / worst
            if known:
                _move(v, p, h)
            changed = latched + h * faster, a, b, c
            found = contact_action(v.moved.ends[k], v.moved.laws[k], v.moved.tables[k], changed, at)
            for i in range(RESULTS):
                v.work.numbers_results[i, 1 + j] += found[i] / (2.0 * h)
        if known:
            _move(v, p, 0.0)


@kernel
def _move(v: Variation, p: int, amount: float) -> None:
    """Move the model of floats by an amount of value p; zero restores it exactly."""
    for i in range(v.first[p], v.first[p + 1]):
        v.memory[v.spots[i]] = v.numbers[i] + amount * v.rates[i]


@kernel
def fill_residual(equations: Equations, v: Variation, t: float, dy: Array, first: int, last: int, out: Array) -> None:
    """Fill columns of ``out`` (k, m) with the slopes of the residual, at a dual state and contacts that are set."""
    model, w, now = v.model, v.work.dynamics, seeded(t, -1)
    add_elements(model.elements, functions_of(model), now, w.v, w.pose, w.vel, w.wrench)
    if len(model.loads):
        add_applied(model, now, v.work.value, w, v.work.reactive)
    for i in range(len(model.free)):
        w.a[model.free[i]] = dy[i]
    set_residuals(model, w, equations.work.dynamics.reaction, v.work.rows)
    fill_solved(equations, w.tau, v.work.rows, first, last, out)
    for k in range(len(model.law_states)):
        put(
            v.work.contacts[model.law_states[k, 0], RATES + model.law_states[k, 1]],
            len(model.free) + k,
            first,
            last,
            out,
        )
    if len(model.states):
        fill_states(model, w, now, w.a, first, last, out)
