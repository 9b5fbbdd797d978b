"""Articulated-body dynamics of a planar tree with prescribed joints, and the reactions of cut ideal joints.

The recursion is Featherstone's articulated-body algorithm (Rigid Body Dynamics Algorithms, 2008, ch. 7) in
its hybrid form (ch. 9): a joint whose acceleration is prescribed passes its load on and returns the
generalised force that the drive needs. Vectors are (moment, fx, fy) and (alpha, ax, ay) in plane axes at the
origin of each body's own frame. Symmetric 3x3 inertias are stored as (I00, I01, I02, I11, I12, I22). Cost is
linear in the number of bodies.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from linkages.planar.kinematics import (
    add_row_wrench,
    body_accelerations,
    body_positions,
    body_velocities,
    point_offset,
    row_acceleration,
    row_rate,
    row_value,
)
from linkages.planar.motion import evaluate_motions
from linkages.planar.records import FIXED, PRISMATIC, REVOLUTE

Array = NDArray[np.float64]


@njit(cache=True)
def generalized_force(bodies: NDArray[np.record], pose: Array, wrench: Array, tau: Array) -> None:
    """Add J^T w of the bodies' wrenches to ``tau`` (n,); `wrench` is used up."""
    for i in range(len(bodies) - 1, 0, -1):
        body = bodies[i]
        p = body.parent
        if body.type == REVOLUTE:
            tau[body.dof] += body.sign * wrench[i, 0]
        elif body.type == PRISMATIC:
            ux, uy = point_offset(pose, p, body.ux, body.uy)
            tau[body.dof] += ux * wrench[i, 1] + uy * wrench[i, 2]
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        wrench[p, 0] += wrench[i, 0] + rx * wrench[i, 2] - ry * wrench[i, 1]
        wrench[p, 1] += wrench[i, 1]
        wrench[p, 2] += wrench[i, 2]


@njit(cache=True)
def articulate(bodies: NDArray[np.record], pose: Array, inertia: Array, axis: Array) -> None:
    """Articulated inertias of a configuration.

    Fills ``inertia`` (nb, 6) and, for each free joint, ``axis`` (nb, 7) with its motion S, U = I S and S.U.
    """
    for i in range(len(bodies)):
        body = bodies[i]
        cx, cy = point_offset(pose, i, body.cx, body.cy)
        m = body.mass
        inertia[i, 0] = body.inertia + m * (cx * cx + cy * cy)
        inertia[i, 1] = -m * cy
        inertia[i, 2] = m * cx
        inertia[i, 3] = m
        inertia[i, 4] = 0.0
        inertia[i, 5] = m
    for i in range(len(bodies) - 1, 0, -1):
        body = bodies[i]
        p = body.parent
        i0, i1, i2, i3, i4, i5 = inertia[i]
        s0, s1, s2 = 0.0, 0.0, 0.0
        if body.type == REVOLUTE:
            s0 = body.sign
        elif body.type == PRISMATIC:
            s1, s2 = point_offset(pose, p, body.ux, body.uy)
        axis[i, 0] = s0
        axis[i, 1] = s1
        axis[i, 2] = s2
        if body.type != FIXED and body.driven < 0:
            u0 = i0 * s0 + i1 * s1 + i2 * s2
            u1 = i1 * s0 + i3 * s1 + i4 * s2
            u2 = i2 * s0 + i4 * s1 + i5 * s2
            d = s0 * u0 + s1 * u1 + s2 * u2
            axis[i, 3] = u0
            axis[i, 4] = u1
            axis[i, 5] = u2
            axis[i, 6] = d
            i0 -= u0 * u0 / d
            i1 -= u0 * u1 / d
            i2 -= u0 * u2 / d
            i3 -= u1 * u1 / d
            i4 -= u1 * u2 / d
            i5 -= u2 * u2 / d
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        b0 = i0 - ry * i1 + rx * i2
        b1 = i1 - ry * i3 + rx * i4
        b2 = i2 - ry * i4 + rx * i5
        inertia[p, 0] += b0 - ry * b1 + rx * b2
        inertia[p, 1] += b1
        inertia[p, 2] += b2
        inertia[p, 3] += i3
        inertia[p, 4] += i4
        inertia[p, 5] += i5


@njit(cache=True)
def inertial_load(
    bodies: NDArray[np.record], pose: Array, vel: Array, gravity: Array, wrench: Array, load: Array
) -> None:
    """Fill ``load`` (nb, 3): centrifugal terms minus gravity minus the applied wrenches."""
    for i in range(len(bodies)):
        body = bodies[i]
        cx, cy = point_offset(pose, i, body.cx, body.cy)
        m, w2 = body.mass, vel[i, 0] * vel[i, 0]
        load[i, 0] = -m * (cx * gravity[1] - cy * gravity[0]) - wrench[i, 0]
        load[i, 1] = -m * (w2 * cx + gravity[0]) - wrench[i, 1]
        load[i, 2] = -m * (w2 * cy + gravity[1]) - wrench[i, 2]


@njit(cache=True)
def solve_tree(
    bodies: NDArray[np.record],
    pose: Array,
    vel: Array,
    rates: Array,
    inertia: Array,
    axis: Array,
    load: Array,
    tau: Array,
    acceleration: Array,
    acc: Array,
) -> None:
    """Accelerations for given loads, and the forces that prescribed joints need.

    Parameters
    ----------
    pose, vel, rates
        Body poses, body velocities and coordinate rates.
    inertia, axis
        From `articulate`.
    load : (nb, 3) array
        From `inertial_load`; used up.
    tau : (n,) array
        Applied generalised forces of free joints; on return, of prescribed joints, the force they need.
    acceleration : (n,) array
        Prescribed accelerations; on return all of them.
    acc : (nb, 3) array
        Filled with the body accelerations.
    """
    n = len(bodies)
    for i in range(n - 1, 0, -1):
        body = bodies[i]
        p = body.parent
        i0, i1, i2, i3, i4, i5 = inertia[i]
        f0, f1, f2 = load[i, 0], load[i, 1], load[i, 2]
        z0, z1, z2 = _bias(body, pose, vel, rates, axis, i)
        if body.type == FIXED or body.driven >= 0:
            if body.driven >= 0:
                a = acceleration[body.dof]
                z0 += axis[i, 0] * a
                z1 += axis[i, 1] * a
                z2 += axis[i, 2] * a
            f0 += i0 * z0 + i1 * z1 + i2 * z2
            f1 += i1 * z0 + i3 * z1 + i4 * z2
            f2 += i2 * z0 + i4 * z1 + i5 * z2
        else:
            u0, u1, u2 = axis[i, 3], axis[i, 4], axis[i, 5]
            push = tau[body.dof] - (axis[i, 0] * f0 + axis[i, 1] * f1 + axis[i, 2] * f2)
            push -= u0 * z0 + u1 * z1 + u2 * z2
            push /= axis[i, 6]
            f0 += i0 * z0 + i1 * z1 + i2 * z2 + u0 * push
            f1 += i1 * z0 + i3 * z1 + i4 * z2 + u1 * push
            f2 += i2 * z0 + i4 * z1 + i5 * z2 + u2 * push
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        load[p, 0] += f0 + rx * f2 - ry * f1
        load[p, 1] += f1
        load[p, 2] += f2
    acc[0, :] = 0.0
    for i in range(1, n):
        body = bodies[i]
        p = body.parent
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        z0, z1, z2 = _bias(body, pose, vel, rates, axis, i)
        a0 = acc[p, 0] + z0
        a1 = acc[p, 1] - acc[p, 0] * ry + z1
        a2 = acc[p, 2] + acc[p, 0] * rx + z2
        f0, f1, f2 = load[i, 0], load[i, 1], load[i, 2]
        s0, s1, s2 = axis[i, 0], axis[i, 1], axis[i, 2]
        if body.type != FIXED:
            if body.driven < 0:
                push = tau[body.dof] - (s0 * f0 + s1 * f1 + s2 * f2)
                push -= axis[i, 3] * a0 + axis[i, 4] * a1 + axis[i, 5] * a2
                acceleration[body.dof] = push / axis[i, 6]
            qdd = acceleration[body.dof]
            a0 += s0 * qdd
            a1 += s1 * qdd
            a2 += s2 * qdd
            if body.driven >= 0:
                i0, i1, i2, i3, i4, i5 = inertia[i]
                f0 += i0 * a0 + i1 * a1 + i2 * a2
                f1 += i1 * a0 + i3 * a1 + i4 * a2
                f2 += i2 * a0 + i4 * a1 + i5 * a2
                tau[body.dof] = s0 * f0 + s1 * f1 + s2 * f2
        acc[i, 0] = a0
        acc[i, 1] = a1
        acc[i, 2] = a2


@njit(cache=True)
def _bias(
    body: np.record, pose: Array, vel: Array, rates: Array, axis: Array, i: int
) -> tuple[float, float, float]:
    """Acceleration of a body frame's origin that comes from velocities alone."""
    p = body.parent
    w = vel[p, 0]
    bx = -w * w * (pose[i, 0] - pose[p, 0])
    by = -w * w * (pose[i, 1] - pose[p, 1])
    if body.type == PRISMATIC:
        rate = 2.0 * w * rates[body.dof]
        bx -= axis[i, 2] * rate
        by += axis[i, 1] * rate
    return 0.0, bx, by


@njit(cache=True)
def constrained_dynamics(
    bodies: NDArray[np.record],
    rows: NDArray[np.record],
    stabilisation: float,
    gravity: Array,
    q: Array,
    v: Array,
    wrench: Array,
    tau: Array,
    acceleration: Array,
    reaction: Array,
) -> None:
    """Accelerations, drive forces and loop reactions of a tree whose cut ideal joints are closed by multipliers.

    Parameters
    ----------
    rows : array of ROW
        Closure rows of the cut ideal joints; may be empty. Redundant rows are found and dropped.
    stabilisation : float
        Rate [1/s] at which closure errors decay (Baumgarte with both roots at this rate); 0 switches it off.
    gravity : (2,) array
        In plane axes [m/s^2].
    wrench : (nb, 3) array
        Applied wrenches on the bodies.
    tau : (n,) array
        Applied generalised forces of free joints; on return, of prescribed joints, the force they need.
    acceleration : (n,) array
        Prescribed accelerations; on return all of them.
    reaction : (nr,) array
        Filled with the size of each row's reaction.
    """
    nb, nr, n = len(bodies), len(rows), len(q)
    pose, vel = np.empty((nb, 5)), np.empty((nb, 3))
    inertia, axis = np.empty((nb, 6)), np.empty((nb, 7))
    load, acc = np.empty((nb, 3)), np.empty((nb, 3))
    body_positions(bodies, q, pose)
    body_velocities(bodies, pose, v, vel)
    articulate(bodies, pose, inertia, axis)
    inertial_load(bodies, pose, vel, gravity, wrench, load)
    solve_tree(bodies, pose, vel, v, inertia, axis, load, tau, acceleration, acc)
    if nr == 0:
        return
    error = np.empty(nr)
    for k in range(nr):
        error[k] = -row_acceleration(rows[k], pose, vel, acc)
        error[k] -= stabilisation * (
            2.0 * row_rate(rows[k], pose, vel) + stabilisation * row_value(rows[k], pose)
        )
    response = np.empty((nr, nr))
    accelerations, forces = np.zeros((nr, n)), np.zeros((nr, n))
    still, rest = np.zeros((nb, 3)), np.zeros(n)
    for k in range(nr):
        load[:] = 0.0
        add_row_wrench(rows[k], pose, -1.0, load)
        solve_tree(bodies, pose, still, rest, inertia, axis, load, forces[k], accelerations[k], acc)
        for m in range(nr):
            response[m, k] = row_acceleration(rows[m], pose, still, acc)
    solve_semidefinite(response, error, reaction)
    for k in range(nr):
        for d in range(n):
            acceleration[d] += reaction[k] * accelerations[k, d]
            tau[d] += reaction[k] * forces[k, d]


@njit(cache=True)
def driven_forces(
    bodies: NDArray[np.record],
    rows: NDArray[np.record],
    stabilisation: float,
    gravity: Array,
    driven: NDArray[np.int64],
    motion: tuple[Array, Array, NDArray[np.int64]],
    powered: NDArray[np.int64],
    torque: tuple[Array, Array, NDArray[np.int64]],
    t: float,
    state: Array,
    positions: NDArray[np.int64],
    rates: NDArray[np.int64],
    applied: Array,
    into: NDArray[np.int64],
    size: int,
) -> tuple[Array, Array]:
    """Compute forces of drives and loops at a state, added to those already applied.

    Parameters
    ----------
    stabilisation : float
        Rate [1/s] at which deviations of drives and loops decay.
    driven, powered : arrays of int
        Coordinates of the prescribed joints, and of those with an applied torque.
    motion, torque
        Their motions and torques over time, as `Motions.arrays`.
    state, positions, rates, into
        As for `linkages.planar.clearance.clearance_forces`.
    applied : (nv,) or longer array
        All other generalised forces, and whatever comes after them.
    size : int
        nv.

    Returns
    -------
    total : (nv,) array
        `applied` plus the forces of drives and loops.
    drive : (nd,) array
        Torque or force of each drive, prescribed ones first.
    """
    nd, np_, n = len(driven), len(powered), len(into)
    q, v, tau = state[positions], state[rates], applied[into]
    drive, one, two = np.empty(nd + np_), np.empty(max(nd, np_)), np.empty(max(nd, np_))
    evaluate_motions(torque[0], torque[1], torque[2], t, drive[nd:], one, two)
    for k in range(np_):
        tau[powered[k]] += drive[nd + k]
    value = np.empty(nd)
    evaluate_motions(motion[0], motion[1], motion[2], t, value, one, two)
    acceleration, needed, reaction = np.zeros(n), tau.copy(), np.empty(len(rows))
    for k in range(nd):
        d = driven[k]
        lag = 2.0 * (one[k] - v[d]) + stabilisation * (value[k] - q[d])
        acceleration[d] = two[k] + stabilisation * lag
    constrained_dynamics(
        bodies, rows, stabilisation, gravity, q, v, np.zeros((len(bodies), 3)), needed, acceleration, reaction
    )
    for k in range(nd):
        drive[k] = needed[driven[k]] - tau[driven[k]]
        tau[driven[k]] = needed[driven[k]]
    if len(rows):
        add_loop_forces(bodies, rows, q, reaction, tau)
    total = applied[:size].copy()
    total[into] = tau
    return total, drive


@njit(cache=True)
def add_loop_forces(
    bodies: NDArray[np.record], rows: NDArray[np.record], q: Array, reaction: Array, force: Array
) -> None:
    """Add J^T lambda of the loop reactions to ``force`` (n,)."""
    pose, wrench = np.empty((len(bodies), 5)), np.zeros((len(bodies), 3))
    body_positions(bodies, q, pose)
    for k in range(len(rows)):
        add_row_wrench(rows[k], pose, reaction[k], wrench)
    generalized_force(bodies, pose, wrench, force)


@njit(cache=True)
def solve_semidefinite(matrix: Array, rhs: Array, x: Array) -> None:
    """Solve a symmetric positive semi-definite system by pivoted Cholesky; dependent rows get x = 0.

    `matrix` and `rhs` are used up.
    """
    n = len(rhs)
    order = np.arange(n)
    rank = n
    scale = 0.0
    for k in range(n):
        scale = max(scale, matrix[k, k])
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if matrix[order[i], order[i]] > matrix[order[best], order[best]]:
                best = i
        order[k], order[best] = order[best], order[k]
        p = order[k]
        if matrix[p, p] <= 1e-12 * scale:
            rank = k
            break
        for i in range(k + 1, n):
            r = order[i]
            factor = matrix[r, p] / matrix[p, p]
            rhs[r] -= factor * rhs[p]
            for j in range(k + 1, n):
                matrix[r, order[j]] -= factor * matrix[p, order[j]]
    x[:] = 0.0
    for k in range(rank - 1, -1, -1):
        p = order[k]
        total = rhs[p]
        for j in range(k + 1, rank):
            total -= matrix[p, order[j]] * x[order[j]]
        x[p] = total / matrix[p, p]


@njit(cache=True)
def spread(
    bodies: NDArray[np.record], q: Array, v: Array, a: Array, pose: Array, vel: Array, acc: Array
) -> None:
    """Body poses (nt, nb, 5), velocities and accelerations (nt, nb, 3) for a table of coordinates (nt, n)."""
    for k in range(len(q)):
        body_positions(bodies, q[k], pose[k])
        body_velocities(bodies, pose[k], v[k], vel[k])
        body_accelerations(bodies, pose[k], vel[k], v[k], a[k], acc[k])
