"""Kinematics of all bodies, and the propagation of forces from bodies to their parents.

The steps of one body are functions; `linkages.mechanics.planar.traversal` makes passes over the tree of them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel, lazy_kernel
from linkages.mechanics.planar.bodies import COS, SIN, Bodies, make_motion, make_pose
from linkages.mechanics.planar.deformable_kinematics import (
    add_shape_force,
    deformable_pose,
    detached_node_pose,
    shape_motion,
    shortening,
)
from linkages.mechanics.planar.markers import arm, marker_acceleration, marker_velocity, offset, turned
from linkages.mechanics.planar.record_types import NODE, PRISMATIC, REVOLUTE
from linkages.mechanics.planar.traversal import FREED, MOVED, forward


@kernel
def body_positions(bodies: Bodies, q: Array, pose: Array) -> None:
    """Set the poses (nb, 5) of all bodies: x, y [m] and angle [rad] of the frame, cosine and sine of the angle.

    If any body is deformable, lines are longer; see `linkages.mechanics.planar.bodies.COS`.
    """
    _set_world_pose(pose)
    _positions(bodies, q, pose)


def poses_at(bodies: Bodies, q: Array) -> Array:
    """Return the poses of all bodies at coordinates q (n,), as `body_positions`."""
    pose = make_pose(bodies)
    body_positions(bodies, q, pose)
    return pose


@kernel
def body_velocities(bodies: Bodies, pose: Array, v: Array, vel: Array) -> None:
    """Set the velocities (nb, 3) of all frames: angular velocity [rad/s], velocity of the origin [m/s]."""
    _set_world_motion(vel)
    _velocities(bodies, pose, v, vel)


@kernel
def body_states(bodies: Bodies, q: Array, v: Array, pose: Array, vel: Array) -> None:
    """Set the poses and velocities of all bodies, as `body_positions` and `body_velocities`, in one pass."""
    _set_world_pose(pose)
    _set_world_motion(vel)
    _states(bodies, q, v, pose, vel)


@lazy_kernel
def moved_states(
    bodies: Bodies, moves: Indices, q: Array, v: Array, pose: Array, vel: Array, still_pose: Array, still_vel: Array
) -> None:
    """Set the dual poses and velocities of bodies that move; others return to ``still_pose`` and ``still_vel``.

    See `linkages.mechanics.planar.traversal.mark_moved`.
    """
    _set_world_pose(pose)
    _moved_states(bodies, moves, q, v, pose, vel, still_pose, still_vel)


@lazy_kernel
def moved_velocities(bodies: Bodies, moves: Indices, pose: Array, v: Array, vel: Array, still_vel: Array) -> None:
    """Set the dual velocities of bodies that move, as `moved_states`."""
    _moved_velocities(bodies, moves, pose, v, vel, still_vel)


@kernel(makes_arrays=True)
def body_accelerations(bodies: Bodies, pose: Array, vel: Array, v: Array, a: Array, acc: Array) -> None:
    """Set the accelerations (nb, 3) of all frames: angular acceleration [rad/s2], acceleration of the origin [m/s2]."""
    _set_world_motion(acc)
    _accelerations(bodies, pose, vel, v, a, acc)


@inlined_kernel
def _set_world_pose(pose: Array) -> None:
    pose[0, 0], pose[0, 1], pose[0, 2], pose[0, COS], pose[0, SIN] = 0.0, 0.0, 0.0, 1.0, 0.0


@inlined_kernel
def _set_world_motion(motion: Array) -> None:
    motion[0, 0], motion[0, 1], motion[0, 2] = 0.0, 0.0, 0.0


@inlined_kernel
def _body_position(bodies: Bodies, i: int, q: Array, pose: Array) -> None:
    """Set the pose of body i from its parent's."""
    body = bodies.records[i]
    p = body.mount.body
    if body.type == NODE:
        if body.detached:  # else its beam has set it
            detached_node_pose(bodies, i, q, pose)
        return
    rx, ry = arm(pose, body.mount)
    x, y = pose[p, 0] + rx, pose[p, 1] + ry
    angle, cosine, sine = pose[p, 2], pose[p, COS], pose[p, SIN]
    if body.type == REVOLUTE:
        angle += body.sign * q[body.dof]
        cosine, sine = math.cos(angle), math.sin(angle)
    elif body.type == PRISMATIC:
        ux, uy = turned(pose, p, body.ux, body.uy)
        x += ux * q[body.dof]
        y += uy * q[body.dof]
    pose[i, 0], pose[i, 1] = x, y
    pose[i, 2], pose[i, COS], pose[i, SIN] = angle, cosine, sine
    if body.shapes > 0:
        deformable_pose(bodies, i, q, pose)


@inlined_kernel
def _body_velocity(bodies: Bodies, i: int, pose: Array, v: Array, vel: Array) -> None:
    """Set the velocity of body i from its parent's."""
    body = bodies.records[i]
    p = body.mount.body
    w = vel[p, 0]
    rx, ry = offset(pose, p, i)
    vx, vy = marker_velocity(vel, p, rx, ry)
    if body.type == REVOLUTE:
        w += body.sign * v[body.dof]
    elif body.type == PRISMATIC:
        ux, uy = turned(pose, p, body.ux, body.uy)
        vx += ux * v[body.dof]
        vy += uy * v[body.dof]
    elif body.type == NODE:
        turn, dx, dy = shape_motion(bodies, i, pose, v)
        w, vx, vy = w + turn, vx + dx, vy + dy
    vel[i, 0], vel[i, 1], vel[i, 2] = w, vx, vy


@inlined_kernel
def _body_state(bodies: Bodies, i: int, q: Array, v: Array, pose: Array, vel: Array) -> None:
    """Set the pose and velocity of body i from its parent's."""
    _body_position(bodies, i, q, pose)
    _body_velocity(bodies, i, pose, v, vel)


@inlined_kernel
def body_acceleration(bodies: Bodies, i: int, pose: Array, vel: Array, v: Array, a: Array, acc: Array) -> None:
    """Set the acceleration of body i from its parent's."""
    body = bodies.records[i]
    p = body.mount.body
    w, alpha = vel[p, 0], acc[p, 0]
    rx, ry = offset(pose, p, i)
    ax, ay = marker_acceleration(vel, acc, p, rx, ry)
    if body.type == REVOLUTE:
        alpha += body.sign * a[body.dof]
    elif body.type == PRISMATIC:
        ux, uy = turned(pose, p, body.ux, body.uy)
        rate = 2.0 * w * v[body.dof]
        ax += ux * a[body.dof] - uy * rate
        ay += uy * a[body.dof] + ux * rate
    elif body.type == NODE:
        ux, uy = turned(pose, p, body.ux, body.uy)
        _, dx, dy = shape_motion(bodies, i, pose, v)
        turn, ddx, ddy = shape_motion(bodies, i, pose, a)
        bent = shortening(bodies, i, v)
        alpha, ax, ay = alpha + turn, ax + ddx - 2.0 * w * dy - bent * ux, ay + ddy + 2.0 * w * dx - bent * uy
    acc[i, 0], acc[i, 1], acc[i, 2] = alpha, ax, ay


_positions = forward(_body_position, moving=False)
_velocities = forward(_body_velocity, moving=False)
_states = forward(_body_state, moving=False)
_accelerations = forward(body_acceleration, moving=False)


@inlined_kernel
def _moved_velocity(bodies: Bodies, i: int, moves: Indices, pose: Array, v: Array, vel: Array, still: Array) -> None:
    """Set the dual velocity of body i, if it moves."""
    if moves[i] == MOVED:
        _body_velocity(bodies, i, pose, v, vel)
    elif moves[i] == FREED:
        vel[i, 0], vel[i, 1], vel[i, 2] = still[i, 0], still[i, 1], still[i, 2]


@inlined_kernel
def _moved_state(
    bodies: Bodies, i: int, moves: Indices, q: Array, v: Array, pose: Array, vel: Array, still_pose: Array,
    still_vel: Array,
) -> None:  # fmt: skip
    """Set the dual pose and velocity of body i, if it moves."""
    if moves[i] == MOVED:
        _body_position(bodies, i, q, pose)
    elif moves[i] == FREED:
        for k in range(pose.shape[1]):
            pose[i, k] = still_pose[i, k]
    _moved_velocity(bodies, i, moves, pose, v, vel, still_vel)


_moved_states, _moved_velocities = (forward(step, moving=False) for step in (_moved_state, _moved_velocity))


@inlined_kernel
def joint_force(body: np.record, pose: Array, wrench: Any) -> float:
    """Component S.f of a wrench (3,), or a tuple, on a body along the coordinate of its joint."""
    if body.type == REVOLUTE:
        return body.sign * wrench[0]
    ux, uy = turned(pose, body.mount.body, body.ux, body.uy)
    return ux * wrench[1] + uy * wrench[2]


@inlined_kernel
def add_to_parent(bodies: Bodies, i: int, pose: Array, wrench: Any) -> None:
    """Add the wrench on body i to its parent's."""
    p = bodies.records[i].mount.body
    rx, ry = offset(pose, p, i)
    wrench[p, 0] += wrench[i, 0] + rx * wrench[i, 2] - ry * wrench[i, 1]
    wrench[p, 1] += wrench[i, 1]
    wrench[p, 2] += wrench[i, 2]


@inlined_kernel
def propagate_force(bodies: Bodies, i: int, pose: Array, wrench: Any, tau: Any) -> None:
    """Add the wrench on body i to its parent's; of a node, add the forces on its parent's shapes to ``tau`` (n,)."""
    add_to_parent(bodies, i, pose, wrench)
    if bodies.records[i].type == NODE:
        add_shape_force(bodies, i, pose, wrench[i, 0], wrench[i, 1], wrench[i, 2], tau)


@kernel
def _fill_states(bodies: Bodies, q: Array, v: Array, pose: Array, vel: Array) -> None:
    for k in range(len(q)):
        body_states(bodies, q[k], v[k], pose[k], vel[k])


def state_tables(bodies: Bodies, q: Array, v: Array) -> tuple[Array, Array]:
    """Return poses (nt, nb, 5) and velocities (nt, nb, 3) for tables of coordinates and rates (nt, n)."""
    pose, vel = (np.empty((len(q), *one(bodies).shape)) for one in (make_pose, make_motion))
    _fill_states(bodies, q, v, pose, vel)
    return pose, vel
