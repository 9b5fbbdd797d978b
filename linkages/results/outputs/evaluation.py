"""Outputs at states, in compiled code."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Array, Records, inlined_kernel, kernel
from linkages.base.kernel.by_reference import packed
from linkages.base.kernel.dual import dual_array, number, seeded, slope
from linkages.base.kernel.dual_copy import DualCopy
from linkages.elements.machine import add_elements, count, tell_elements
from linkages.mechanics.integrate.stepper import copy
from linkages.mechanics.planar.arrays import Arrays, functions_of, loads_of
from linkages.mechanics.planar.closure_rows import add_row_wrench
from linkages.mechanics.planar.contacts import WIDTH
from linkages.mechanics.planar.kinematics import body_accelerations, body_states
from linkages.mechanics.planar.loads import LOAD_OUTPUTS, load_outputs
from linkages.mechanics.planar.motion import evaluate_motions
from linkages.mechanics.planar.newton_euler import generalised_force, inertial_forces
from linkages.mechanics.planar.reactions import add_known_contacts, joint_forces, row_reactions
from linkages.mechanics.planar.reactive_loads import add_applied, make_reactive_loads
from linkages.mechanics.planar.workspace import make_workspace
from linkages.results.outputs.quantity import OutputFormula, Snapshot
from linkages.results.outputs.registry import FORMULAS


def _chosen(formulas: Iterable[OutputFormula]) -> Callable[[np.record, Snapshot], float]:
    """Make the kernel ``(output, seen) -> value`` that calls the formula with the number in an output's record."""
    names: dict[str, Any] = {f"formula_{k}": formula.kernel for k, formula in enumerate(formulas)}
    lines = [f"    if output.formula == {k}: return {name}(output, seen)" for k, name in enumerate(names)]
    names["__name__"] = __name__
    exec("\n".join(["def output_value(output, seen) -> float:", *lines, "    return 0.0"]), names)
    return kernel(names["output_value"])


#: Value of an output at a state, without subtracting the ideal value for jitter.
output_value = _chosen(FORMULAS)


@kernel(makes_arrays=True)
def tabulate(
    outputs: Records,
    with_forces: bool,
    seen: Snapshot,
    times: Array,
    q: Array,
    v: Array,
    a: Array,
    contacts: Array,
    out: Array,
) -> None:
    """Fill ``out`` (no, nt) with outputs over time, from coordinates, rates, accelerations (nt, n) and contacts.

    `with_forces`: whether any output needs the forces in joints or the efforts of drives; `seen`: see `make_snapshot`.
    """
    powered = np.zeros((3, len(seen.model.powered_bodies)))
    for i in range(len(times)):
        _take(seen, q[i], v[i], a[i], contacts[i])
        _complete(seen, with_forces, times[i], powered)
        for k in range(len(outputs)):
            out[k, i] = output_value(outputs[k], seen)


class DualTable(NamedTuple):
    """Outputs of a model of duals, see `slopes`; the numbers are the memory of the snapshot's arrays."""

    outputs: Records
    seen: Snapshot
    powered: Array  # torques and forces of drives, to work in, (3, np)
    q: Array  # numbers of the snapshot's coordinates, (n, 1 + DIRECTIONS)
    v: Array
    a: Array
    contacts: Array  # (nc, WIDTH, 1 + DIRECTIONS)
    reaction: Array  # (nr, 1 + DIRECTIONS)


@kernel(makes_arrays=True)
def slopes(
    table: DualTable, with_forces: bool, seen: Snapshot, times: Array, q: Array, v: Array, a: Array, contacts: Array,
    dq: Array, dv: Array, da: Array, dcontacts: Array, first: int, values: Array, out: Array,
) -> None:  # fmt: skip
    """Fill ``values`` (no, nt) with the outputs of `tabulate`, and ``out`` (np, no, nt) with their slopes.

    They are slopes along np values, at most `DIRECTIONS`.

    Parameters
    ----------
    table : DualTable
        Its model has the slopes along the values.
    seen : Snapshot
        Of the model of floats.
    dq, dv, da, dcontacts : (nt, ..., n) arrays
        Slopes of coordinates and contacts along n values.
    first : int
        First of the np values.
    """
    w, powered = seen.state, np.zeros((3, len(seen.model.powered_bodies)))
    for i in range(len(times)):
        if with_forces and len(seen.model.rows):
            _take(seen, q[i], v[i], a[i], contacts[i])
            _move(seen, with_forces, times[i], powered)
            row_reactions(seen.model, w)
        for k in range(q.shape[1]):
            table.q[k, 0], table.v[k, 0], table.a[k, 0] = q[i, k], v[i, k], a[i, k]
            for p in range(len(out)):
                table.q[k, 1 + p], table.v[k, 1 + p] = dq[i, k, first + p], dv[i, k, first + p]
                table.a[k, 1 + p] = da[i, k, first + p]
        for k in range(contacts.shape[1]):
            for j in range(WIDTH):
                table.contacts[k, j, 0] = contacts[i, k, j]
                for p in range(len(out)):
                    table.contacts[k, j, 1 + p] = dcontacts[i, k, j, first + p]
        _move(table.seen, with_forces, seeded(times[i], -1), table.powered)
        if with_forces:
            if len(seen.model.rows):
                _set_reactions(table, seen, len(out))
            _set_forces(table.seen)
        for k in range(len(table.outputs)):
            found = output_value(table.outputs[k], table.seen)
            values[k, i] = number(found)
            for p in range(len(out)):
                out[p, k, i] = slope(found, p)


@kernel
def _set_reactions(table: DualTable, seen: Snapshot, count: int) -> None:
    """Fill the dual reactions of the closure rows: slopes of the residual at fixed reactions need further ones."""
    model, w, at = table.seen.model, table.seen.state, seen.state
    used, needed = w.response, w.shape_response
    for i in range(len(needed)):
        needed[i] = w.shape_bias[i]
    for i in range(len(used)):
        for k in range(3):
            used[i, k] = w.bias[i, k]
    table.reaction[:] = 0.0
    for k in range(len(model.rows)):
        table.reaction[k, 0] = at.reaction[k]
        add_row_wrench(model.rows[k], w.pose, -w.reaction[k], used)
    generalised_force(model.bodies, w.pose, used, needed)
    at.bias[:] = 0.0
    at.shape_bias[:] = 0.0
    for p in range(count):
        for i in range(len(needed)):
            at.tau[i] = slope(w.tau[i], p) - slope(needed[i], p)
        row_reactions(seen.model, at)
        for k in range(len(model.rows)):
            table.reaction[k, 1 + p] = at.reaction[k]
    at.tau[:] = 0.0  # torques of powered coordinates are set again


@inlined_kernel
def _take(seen: Snapshot, q: Array, v: Array, a: Array, contacts: Array) -> None:
    """Give a snapshot coordinates, rates, accelerations (n,) and contacts (nc, WIDTH)."""
    copy(q, seen.state.q)
    copy(v, seen.state.v)
    copy(a, seen.state.a)
    for k in range(len(contacts)):
        copy(contacts[k], seen.contacts[k])


@kernel
def _complete(seen: Snapshot, with_forces: bool, t: float, powered: Array) -> None:
    """Fill bodies, loads and forces of a snapshot with coordinates and contacts; ``powered`` (3, np) is to work in."""
    _move(seen, with_forces, t, powered)
    if with_forces:
        if len(seen.model.rows):
            row_reactions(seen.model, seen.state)
        _set_forces(seen)


@inlined_kernel
def _move(seen: Snapshot, with_forces: bool, t: float, powered: Array) -> None:
    """Fill bodies and loads, and if wanted the forces that the bodies need; see `_complete`."""
    model, w = seen.model, seen.state
    bodies = model.bodies
    body_states(bodies, w.q, w.v, w.pose, w.vel)
    body_accelerations(bodies, w.pose, w.vel, w.v, w.a, w.acc)
    if with_forces or len(seen.reactive.efforts):
        w.wrench[:] = 0.0
        add_known_contacts(model.ends, seen.contacts, w.pose, w.wrench)
        evaluate_motions((model.torque, model.torque_c, model.torque_n), t, powered[0], powered[1], powered[2])
        add_elements(model.elements, functions_of(model), t, w.v, w.pose, w.vel, w.wrench)
        if len(model.loads):
            add_applied(model, t, powered[0], w, seen.reactive)
    if len(model.loads):
        load_outputs(loads_of(model), seen.reactive.efforts, t, w.v, w.pose, w.vel, seen.loads)
    tell_elements(model.elements, functions_of(model), t, w.v, len(model.loads), w.pose, w.vel, seen.loads)
    if with_forces:
        for k in range(powered.shape[1]):
            w.tau[bodies.records[model.powered_bodies[k]].dof] = powered[0, k]
        inertial_forces(bodies, w, model.gravity, w.bias, w.shape_bias)


@inlined_kernel
def _set_forces(seen: Snapshot) -> None:
    joint_forces(seen.model, seen.state, seen.contacts, seen.forces, seen.efforts)


def make_snapshot(model: Arrays, n: int) -> Snapshot:
    """Make a snapshot, with its arrays, of a linkage with n coordinates, for `tabulate`."""
    return packed(_unpacked(model, n))


def _unpacked(model: Arrays, n: int) -> Snapshot:
    work = make_workspace(len(model.bodies.records), n, len(model.rows), model.bodies.shapes.shape[2])
    forces, efforts = np.zeros((len(model.joints), 3)), np.zeros(len(model.driven) + len(model.powered))
    rows = np.zeros((len(model.loads) + count(model.elements), len(LOAD_OUTPUTS)))
    parts = np.zeros((len(model.ends), WIDTH)), forces, efforts, rows
    return Snapshot(packed(model), packed(work), *parts, packed(make_reactive_loads(model, work)))


def make_dual_table(model: Arrays, outputs: Records, n: int) -> tuple[DualTable, Array]:
    """Make a table of outputs of a linkage with n coordinates, and the numbers and slopes of (outputs, model)."""
    given, copy = DualCopy((outputs, model)), DualCopy(_unpacked(model, n)._replace(model=()))  # type: ignore[arg-type]
    seen, slots = copy.value._replace(model=packed(given.value[1])), lambda part: part.view(np.ndarray)
    w = seen.state
    powered = dual_array(3, len(model.powered_bodies))
    numbers = map(slots, (w.q, w.v, w.a, seen.contacts, w.reaction))
    return packed(DualTable(given.value[0], seen, powered, *numbers)), given.memory
