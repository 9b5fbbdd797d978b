"""Forces of clearance joints, loads, drives and loops for a plant, which orders its coordinates otherwise.

All arguments that do not change are in one reference: each array that Python hands over costs time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.kernel import Array, Indices, kernel
from linkages.kernel.by_reference import packed
from linkages.planar.arrays import Arrays
from linkages.planar.bodies import new_motion, new_pose
from linkages.planar.contacts import WIDTH, clearance_wrenches
from linkages.planar.driven import constrained_dynamics
from linkages.planar.kinematics import body_states
from linkages.planar.loads import load_wrenches
from linkages.planar.motion import evaluate_motions
from linkages.planar.newton_euler import generalised_force
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
    return packed(Placed(packed(system.arrays), q, v, f, size, system.experiment.solver.stabilisation))


@kernel
def joint_forces(place: Placed, memory: Array, state: Array) -> Array:
    """Compute the generalised forces of all clearance joints.

    Parameters
    ----------
    memory : (nc, 2) array
        See `linkages.planar.contacts.APPROACH`.
    state : (nx,) array
        Of the plant.

    Returns
    -------
    (size + WIDTH nc,) array
        Generalised forces, then `linkages.planar.contacts.CLEARANCE_OUTPUTS` of each contact.
    """
    model, bodies, nc = place.model, place.model.bodies, len(place.model.ends)
    pose, vel, wrench, tau = new_pose(bodies), new_motion(bodies), new_motion(bodies), np.zeros(len(place.into))
    body_states(bodies, state[place.positions], state[place.rates], pose, vel)
    result = np.zeros(place.size + WIDTH * nc)
    outputs = result[place.size :].reshape(nc, WIDTH)
    clearance_wrenches(model.ends, model.laws, model.tables, memory, pose, vel, wrench, outputs)
    generalised_force(bodies, pose, wrench, tau)
    result[place.into] = tau
    return result


@kernel
def drive_forces(place: Placed, t: float, state: Array, applied: Array) -> tuple[Array, Array]:
    """Compute the forces of applied loads, drives and loops at a state, added to the forces already applied.

    Parameters
    ----------
    t : float
        Time [s].
    state : (nx,) array
        Of the plant.
    applied : (nv,) or longer array
        All other generalised forces, and any entries after them.

    Returns
    -------
    total : (nv,) array
        `applied` plus the forces of loads, drives and loops.
    drive : (nd,) array
        Torque or force of each drive, prescribed ones first.
    """
    model, bodies, stabilisation = place.model, place.model.bodies, place.stabilisation
    nd, powered, n = len(model.driven), len(model.powered), len(place.into)
    q, v, tau = state[place.positions], state[place.rates], applied[place.into]
    pose, vel, wrench = new_pose(bodies), new_motion(bodies), new_motion(bodies)
    body_states(bodies, q, v, pose, vel)
    loads = (model.loads, model.signals, model.load_t, model.load_c, model.load_n)
    load_wrenches(loads, t, pose, vel, wrench)
    generalised_force(bodies, pose, wrench, tau)
    most = max(nd, powered)
    drive, value, one, two = np.empty(nd + powered), np.empty(nd), np.empty(most), np.empty(most)
    evaluate_motions((model.torque, model.torque_c, model.torque_n), t, drive[nd:], one, two)
    for k in range(powered):
        tau[model.powered[k]] += drive[nd + k]
    evaluate_motions((model.motion, model.motion_c, model.motion_n), t, value, one, two)
    acceleration, needed, reaction, loop = np.zeros(n), tau.copy(), np.empty(len(model.rows)), np.empty(n)
    wrench[:] = 0.0
    for k in range(nd):
        d = model.driven[k]
        lag = 2.0 * (one[k] - v[d]) + stabilisation * (value[k] - q[d])
        acceleration[d] = two[k] + stabilisation * lag
    rows, rank, gravity = model.rows, model.rank, model.gravity
    constrained_dynamics(
        bodies, rows, rank, model.size, stabilisation, gravity, q, v, wrench, needed, acceleration, reaction, loop
    )
    for k in range(nd):
        drive[k] = needed[model.driven[k]] - tau[model.driven[k]]
    total = applied[: place.size].copy()
    total[place.into] = needed + loop
    return total, drive
