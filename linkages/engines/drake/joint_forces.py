"""Forces of clearance joints, loads, drives and loops for a plant, which orders its coordinates otherwise.

All arguments that do not change are in one reference: each array that Python hands over costs time.
"""

from __future__ import annotations

import threading
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, kernel, lazy_kernel
from linkages.base.kernel.by_reference import packed
from linkages.elements.machine import add_elements
from linkages.mechanics.planar.arrays import Arrays, functions_of, loads_of, size_of
from linkages.mechanics.planar.contact_memory import advance_cells, start_cells
from linkages.mechanics.planar.contacts import WIDTH, clearance_wrenches
from linkages.mechanics.planar.kinematics import body_states
from linkages.mechanics.planar.loads import load_wrenches, sample_states, state_rates
from linkages.mechanics.planar.motion import evaluate_motions
from linkages.mechanics.planar.newton_euler import generalised_force
from linkages.mechanics.planar.reactions import add_known_contacts
from linkages.mechanics.planar.reactive_loads import ReactiveLoads, add_efforts, make_reactive_loads, solve_reactive
from linkages.mechanics.planar.singularities import constrained_dynamics
from linkages.mechanics.planar.workspace import Workspace, make_workspace
from linkages.system import System


class Placed(NamedTuple):
    """A linkage, and the places of its coordinates in a plant's state."""

    model: Arrays
    positions: Indices  # of coordinates in the state, (n,)
    rates: Indices  # of their rates
    into: Indices  # of their generalised forces
    size: int  # number of the plant's generalised forces
    stabilisation: float  # rate at which deviations of drives and loops decay [1/s]


def placed(system: System, positions: Indices, rates: Indices, into: Indices, size: int) -> Placed:
    """Pack a system and its places for `joint_forces` and `drive_forces`."""
    q, v, f = (np.ascontiguousarray(x, dtype=np.int64) for x in (positions, rates, into))
    return packed(Placed(packed(system.arrays), q, v, f, size, system.settings.stabilisation))


class Rooms(threading.local):
    """Workspaces for each thread, as several threads may evaluate one diagram at once."""

    def __init__(self, system: System) -> None:
        model = system.arrays
        nb, nm = len(model.bodies.records), model.bodies.shapes.shape[2]
        self.work = packed(make_workspace(nb, size_of(model), len(model.rows), nm))
        self.reactive = packed(make_reactive_loads(model, self.work))


@kernel
def _enter(place: Placed, work: Workspace, state: Array) -> None:
    """Set q, v, pose and vel of a workspace; clear wrench and tau."""
    for i in range(len(place.into)):
        work.q[i], work.v[i] = state[place.positions[i]], state[place.rates[i]]
    work.wrench[:] = 0.0
    work.tau[:] = 0.0
    body_states(place.model.bodies, work.q, work.v, work.pose, work.vel)


@kernel
def joint_forces(place: Placed, work: Workspace, memory: Array, state: Array, result: Array) -> None:
    """Compute the generalised forces of all clearance joints at a state (nx,) of the plant.

    Uses `work` up. ``memory`` is the one of `linkages.mechanics.planar.contact_memory`. ``result`` (size + WIDTH
    nc,) is filled with generalised forces, then `linkages.mechanics.planar.contacts.CLEARANCE_OUTPUTS` of each contact.
    """
    model, bodies = place.model, place.model.bodies
    _enter(place, work, state)
    result[:] = 0.0
    outputs = result[place.size :].reshape(len(model.ends), WIDTH)
    clearance_wrenches(model.ends, model.laws, model.tables, memory, work.pose, work.vel, work.wrench, outputs)
    generalised_force(bodies, work.pose, work.wrench, work.tau)
    for i in range(len(place.into)):
        result[place.into[i]] = work.tau[i]


@lazy_kernel
def move_cells(place: Placed, work: Workspace, memory: Array, t: float, state: Array, fresh: bool) -> None:
    """Move the content of the cells of contacts to time t and a state (nx,) of the plant, or make it ``fresh``."""
    model = place.model
    _enter(place, work, state)
    if fresh:
        start_cells(model.ends, model.laws, model.tables, memory, t, work.pose, work.vel, True)
    else:
        advance_cells(model.ends, model.laws, model.tables, memory, t, work.pose, work.vel)


@lazy_kernel(makes_arrays=True)
def _add_reactive(
    place: Placed, work: Workspace, reactive: ReactiveLoads, t: float, torques: Array, applied: Array
) -> None:
    """Add the wrenches of loads that depend on joint forces; the contacts' forces count for these."""
    model, loads = place.model, work.wrench.copy()
    contacts = applied[place.size :].reshape(len(model.ends), WIDTH)
    add_known_contacts(model.ends, contacts, work.pose, work.wrench)
    solve_reactive(model, t, torques, work, reactive)
    work.wrench[:] = loads
    add_efforts(model, reactive.efforts, work)


@kernel
def _take_states(place: Placed, work: Workspace, state: Array) -> None:
    """Set the additional states, which follow the plant's state."""
    nz = len(place.model.states)
    for k in range(nz):
        work.v[len(work.v) - nz + k] = state[len(state) - nz + k]


@lazy_kernel
def own_rates(place: Placed, work: Workspace, t: float, state: Array, due: Array, rates: Array) -> None:
    """Fill the rates of the additional states (nz,), or where ``due`` (nz,) has passed their next values.

    The state (nx + nz,) is that of `drive_forces`.
    """
    model, nz = place.model, len(place.model.states)
    _enter(place, work, state)
    _take_states(place, work, state)
    loads = loads_of(model)
    state_rates(loads, t, work.v, work.pose, work.vel, work.a)
    sample_states(loads, due, t, work.v, work.pose, work.vel)
    for k in range(nz):
        last = len(work.v) - nz + k
        rates[k] = work.v[last] if t >= due[k] else work.a[last]


@kernel(makes_arrays=True)
def drive_forces(
    place: Placed,
    work: Workspace,
    reactive: ReactiveLoads,
    t: float,
    state: Array,
    applied: Array,
    added: Array,
    total: Array,
    drive: Array,
) -> None:
    """Compute the forces of loads, drives and loops at a state (nx + nz,) and a time t [s]; uses `work` up.

    The state is the plant's, then the additional states. ``applied`` (nv,), with any entries after them, has all
    other generalised forces; loads that depend on joint forces need the result of `joint_forces` there. ``added``
    is added to the powered drives' torques. ``total`` (nv,) is filled with these and the computed ones, ``drive`` (nd,)
    with the torque or force of each drive, prescribed ones first.
    """
    model, bodies, stabilisation = place.model, place.model.bodies, place.stabilisation
    nd, powered, n = len(model.driven), len(model.powered), len(place.into)
    q, v, tau = work.q, work.v, work.tau
    _enter(place, work, state)
    _take_states(place, work, state)
    for i in range(n):
        tau[i] = applied[place.into[i]]
    add_elements(model.elements, functions_of(model), t, work.v, work.pose, work.vel, work.wrench)
    load_wrenches(loads_of(model), t, work.v, work.pose, work.vel, work.wrench)
    most = max(nd, powered)
    value, one, two, loop, given = np.empty(nd), np.empty(most), np.empty(most), np.empty(n), np.empty(nd)
    evaluate_motions((model.torque, model.torque_c, model.torque_n), t, drive[nd:], one, two)
    for k in range(powered):
        drive[nd + k] += added[k]
    evaluate_motions((model.motion, model.motion_c, model.motion_n), t, value, one, two)
    work.a[:] = 0.0
    for k in range(nd):
        d = model.driven[k]
        lag = 2.0 * (one[k] - v[d]) + stabilisation * (value[k] - q[d])
        work.a[d] = two[k] + stabilisation * lag
    if len(reactive.efforts):
        _add_reactive(place, work, reactive, t, drive[nd:], applied)
    generalised_force(bodies, work.pose, work.wrench, tau)
    work.wrench[:] = 0.0
    for k in range(powered):
        tau[model.powered[k]] += drive[nd + k]
    for k in range(nd):
        given[k] = tau[model.driven[k]]
    constrained_dynamics(bodies, model.rows, model.elimination, model.size, stabilisation, model.gravity, work, loop)
    for k in range(nd):
        drive[k] = tau[model.driven[k]] - given[k]
    for i in range(place.size):
        total[i] = applied[i]
    for i in range(n):
        total[place.into[i]] = tau[i] + loop[i]
