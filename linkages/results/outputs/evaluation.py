"""Outputs at states, in compiled code."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from linkages.base.kernel import Array, Records, kernel
from linkages.base.kernel.by_reference import packed
from linkages.mechanics.integrate.stepper import copy
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.contacts import WIDTH
from linkages.mechanics.planar.kinematics import body_accelerations, body_states
from linkages.mechanics.planar.loads import LOAD_OUTPUTS, load_outputs, load_wrenches
from linkages.mechanics.planar.motion import evaluate_motions
from linkages.mechanics.planar.newton_euler import inertial_forces
from linkages.mechanics.planar.reactions import add_known_contacts, joint_forces, row_reactions
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


@kernel
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
    w, powered = seen.state, np.zeros((3, len(seen.model.powered_bodies)))
    for i in range(len(times)):
        copy(q[i], w.q)
        copy(v[i], w.v)
        copy(a[i], w.a)
        for k in range(contacts.shape[1]):
            copy(contacts[i, k], seen.contacts[k])
        _complete(seen, with_forces, times[i], powered)
        for k in range(len(outputs)):
            out[k, i] = output_value(outputs[k], seen)


@kernel
def add_moved(
    outputs: Records, with_forces: bool, seen: Snapshot, times: Array, q: Array, v: Array, a: Array, contacts: Array,
    dq: Array, dv: Array, da: Array, dcontacts: Array, h: float, weight: float, out: Array,
) -> None:  # fmt: skip
    """Add the outputs of `tabulate`, at h times a change of coordinates and contacts, times a weight, to ``out``."""
    w, powered = seen.state, np.zeros((3, len(seen.model.powered_bodies)))
    for i in range(len(times)):
        for k in range(len(w.q)):
            w.q[k], w.v[k], w.a[k] = q[i, k] + h * dq[i, k], v[i, k] + h * dv[i, k], a[i, k] + h * da[i, k]
        for k in range(contacts.shape[1]):
            for j in range(WIDTH):
                seen.contacts[k, j] = contacts[i, k, j] + h * dcontacts[i, k, j]
        _complete(seen, with_forces, times[i], powered)
        for k in range(len(outputs)):
            out[k, i] += weight * output_value(outputs[k], seen)


@kernel
def _complete(seen: Snapshot, with_forces: bool, t: float, powered: Array) -> None:
    """Fill bodies, loads and forces of a snapshot with coordinates and contacts; ``powered`` (3, np) is to work in."""
    model, w = seen.model, seen.state
    bodies = model.bodies
    body_states(bodies, w.q, w.v, w.pose, w.vel)
    body_accelerations(bodies, w.pose, w.vel, w.v, w.a, w.acc)
    loads = (model.loads, model.signals, model.load_t, model.load_c, model.load_n)
    if len(loads[0]):
        load_outputs(loads, t, w.pose, w.vel, seen.loads)
    if with_forces:
        w.wrench[:] = 0.0
        add_known_contacts(model.ends, seen.contacts, w.pose, w.wrench)
        if len(loads[0]):
            load_wrenches(loads, t, w.pose, w.vel, w.wrench)
        evaluate_motions((model.torque, model.torque_c, model.torque_n), t, powered[0], powered[1], powered[2])
        for k in range(powered.shape[1]):
            w.tau[bodies.records[model.powered_bodies[k]].dof] = powered[0, k]
        inertial_forces(bodies, w, model.gravity, w.bias, w.modal_bias)
        if len(model.rows):
            row_reactions(model, w)
        joint_forces(model, w, seen.contacts, seen.forces, seen.efforts)


def make_snapshot(model: Arrays, n: int) -> Snapshot:
    """Make a snapshot, with its arrays, of a linkage with n coordinates, for `tabulate`."""
    work = make_workspace(len(model.bodies.records), n, len(model.rows), model.bodies.shapes.shape[2])
    forces, efforts = np.zeros((len(model.joints), 3)), np.zeros(len(model.driven) + len(model.powered))
    parts = np.zeros((len(model.ends), WIDTH)), forces, efforts, np.zeros((len(model.loads), len(LOAD_OUTPUTS)))
    return packed(Snapshot(packed(model), packed(work), *parts))
