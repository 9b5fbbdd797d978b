"""Generalised forces of loads, drives and ideal loops at a state, for a simulator that integrates all coordinates."""

from __future__ import annotations

import numpy as np

from linkages.kernel import Array, Indices, Records, clear, kernel
from linkages.kernel.by_reference import reference
from linkages.planar.bodies import Bodies, new_motion, new_pose
from linkages.planar.dynamics import generalized_force, inertial_load
from linkages.planar.kinematics import add_row_wrench, body_states
from linkages.planar.loads import Loads, load_wrenches
from linkages.planar.motion import Curves, evaluate_motions
from linkages.planar.passage import accelerate_onto
from linkages.planar.workspace import workspace


@kernel
def constrained_dynamics(
    bodies: Bodies,
    rows: Records,
    rank: int,
    size: float,
    stabilisation: float,
    gravity: Array,
    q: Array,
    v: Array,
    wrench: Array,
    tau: Array,
    acceleration: Array,
    reaction: Array,
    loops: Array,
) -> None:
    """Accelerations, drive forces and loop reactions at a state; see `accelerate_onto`.

    Parameters
    ----------
    wrench : (nb, 3) array
        Applied wrenches on the bodies.
    tau : (n,) array
        Applied generalised forces of free joints; on return, of prescribed joints, the force they need.
    acceleration : (n,) array
        Prescribed accelerations; on return all of them.
    reaction : (nr,) array
        Filled with the size of each row's reaction; without a meaning where a singular position is passed.
    loops : (n,) array
        Filled with the generalised forces of the loops, which have one there too.
    """
    arrays = workspace(len(bodies.records), len(q), len(rows), bodies.shapes.shape[2])
    work = reference(arrays)
    work.q[:] = q
    work.v[:] = v
    work.tau[:] = tau
    work.wrench[:] = wrench
    for i in range(len(bodies.records)):
        if bodies.records[i].driven >= 0:
            work.a[bodies.records[i].dof] = acceleration[bodies.records[i].dof]
    body_states(bodies, q, v, work.pose, work.vel)
    accelerate_onto(bodies, rows, rank, size, stabilisation, gravity, work)
    needed = np.zeros(len(q))
    inertial_load(bodies, work, gravity, work.load)
    generalized_force(bodies, work.pose, work.load, needed)
    clear(work.wrench)
    for k in range(len(rows)):
        add_row_wrench(rows[k], work.pose, work.reaction[k], work.wrench)
    loops[:] = 0.0
    generalized_force(bodies, work.pose, work.wrench, loops)
    acceleration[:] = arrays.a
    reaction[:] = arrays.reaction
    for i in range(len(bodies.records)):
        d = bodies.records[i].dof
        if d >= 0 and bodies.records[i].driven >= 0:
            tau[d] = needed[d] - loops[d]
        elif d >= 0 and len(rows):
            loops[d] = needed[d] - tau[d]


@kernel
def driven_forces(
    bodies: Bodies,
    rows: Records,
    rank: int,
    length: float,
    stabilisation: float,
    gravity: Array,
    driven: Indices,
    motion: Curves,
    powered: Indices,
    torque: Curves,
    loads: Loads,
    t: float,
    state: Array,
    positions: Indices,
    rates: Indices,
    applied: Array,
    into: Indices,
    size: int,
) -> tuple[Array, Array]:
    """Compute forces of applied loads, drives and loops at a state, added to those already applied.

    Parameters
    ----------
    rank : int
        How many rows are independent, but in singular positions.
    length : float
        Of the linkage [m].
    stabilisation : float
        Rate [1/s] at which deviations of drives and loops decay.
    driven, powered : arrays of int
        Coordinates of the prescribed joints, and of those with an applied torque.
    motion, torque
        Their motions and torques over time, as `Motions.arrays`.
    loads : tuple
        Applied loads; see `linkages.planar.loads`.
    state, positions, rates, into
        As for `linkages.planar.contacts.clearance_forces`.
    applied : (nv,) or longer array
        All other generalised forces, and whatever comes after them.
    size : int
        nv.

    Returns
    -------
    total : (nv,) array
        `applied` plus the forces of loads, drives and loops.
    drive : (nd,) array
        Torque or force of each drive, prescribed ones first.
    """
    nd, np_, n = len(driven), len(powered), len(into)
    q, v, tau = state[positions], state[rates], applied[into]
    pose, vel, wrench = new_pose(bodies), new_motion(bodies), new_motion(bodies)
    body_states(bodies, q, v, pose, vel)
    load_wrenches(loads, t, pose, vel, wrench)
    generalized_force(bodies, pose, wrench, tau)
    drive, one, two = np.empty(nd + np_), np.empty(max(nd, np_)), np.empty(max(nd, np_))
    evaluate_motions(torque, t, drive[nd:], one, two)
    for k in range(np_):
        tau[powered[k]] += drive[nd + k]
    value = np.empty(nd)
    evaluate_motions(motion, t, value, one, two)
    acceleration, needed, reaction, loop = np.zeros(n), tau.copy(), np.empty(len(rows)), np.empty(n)
    wrench[:] = 0.0
    for k in range(nd):
        d = driven[k]
        lag = 2.0 * (one[k] - v[d]) + stabilisation * (value[k] - q[d])
        acceleration[d] = two[k] + stabilisation * lag
    constrained_dynamics(
        bodies, rows, rank, length, stabilisation, gravity, q, v, wrench, needed, acceleration, reaction, loop
    )
    for k in range(nd):
        drive[k] = needed[driven[k]] - tau[driven[k]]
    total = applied[:size].copy()
    total[into] = needed + loop
    return total, drive
