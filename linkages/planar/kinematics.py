"""Positions, velocities and accelerations of all bodies, and of the closure rows."""

from __future__ import annotations

import math

import numpy as np

from linkages.kernel import Array, Records, inlined_kernel, kernel
from linkages.planar.markers import (
    add_pair,
    arm,
    both_at_b,
    gap,
    gap_acceleration,
    gap_rate,
    marker_acceleration,
    marker_velocity,
    turned,
)
from linkages.planar.record_types import ALONG_BODY, ANGLE, PRISMATIC, REVOLUTE


@kernel
def body_positions(bodies: Records, q: Array, pose: Array) -> None:
    """Fill ``pose`` (nb, 5) with x, y [m], angle [rad] of each body frame, and the angle's cosine and sine."""
    pose[0, 0], pose[0, 1], pose[0, 2], pose[0, 3], pose[0, 4] = 0.0, 0.0, 0.0, 1.0, 0.0
    for i in range(1, len(bodies)):
        body = bodies[i]
        p = body.mount.body
        rx, ry = arm(pose, body.mount)
        x, y = pose[p, 0] + rx, pose[p, 1] + ry
        if body.type == PRISMATIC:
            ux, uy = turned(pose, p, body.ux, body.uy)
            x += ux * q[body.dof]
            y += uy * q[body.dof]
        angle, cosine, sine = pose[p, 2], pose[p, 3], pose[p, 4]
        if body.type == REVOLUTE:
            angle += body.sign * q[body.dof]
            cosine, sine = math.cos(angle), math.sin(angle)
        pose[i, 0], pose[i, 1] = x, y
        pose[i, 2], pose[i, 3], pose[i, 4] = angle, cosine, sine


@kernel
def body_velocities(bodies: Records, pose: Array, v: Array, vel: Array) -> None:
    """Fill ``vel`` (nb, 3) with angular velocity [rad/s] and velocity of each frame's origin [m/s]."""
    vel[0, :] = 0.0
    for i in range(1, len(bodies)):
        body = bodies[i]
        p = body.mount.body
        w = vel[p, 0]
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        vx, vy = marker_velocity(vel, p, rx, ry)
        if body.type == REVOLUTE:
            w += body.sign * v[body.dof]
        elif body.type == PRISMATIC:
            ux, uy = turned(pose, p, body.ux, body.uy)
            vx += ux * v[body.dof]
            vy += uy * v[body.dof]
        vel[i, 0], vel[i, 1], vel[i, 2] = w, vx, vy


@kernel
def body_accelerations(bodies: Records, pose: Array, vel: Array, v: Array, a: Array, acc: Array) -> None:
    """Fill ``acc`` (nb, 3) with angular acceleration and acceleration of each frame's origin."""
    acc[0, :] = 0.0
    for i in range(1, len(bodies)):
        body = bodies[i]
        p = body.mount.body
        w, al = vel[p, 0], acc[p, 0]
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        ax, ay = marker_acceleration(vel, acc, p, rx, ry)
        if body.type == REVOLUTE:
            al += body.sign * a[body.dof]
        elif body.type == PRISMATIC:
            ux, uy = turned(pose, p, body.ux, body.uy)
            rate = 2.0 * w * v[body.dof]
            ax += ux * a[body.dof] - uy * rate
            ay += uy * a[body.dof] + ux * rate
        acc[i, 0], acc[i, 1], acc[i, 2] = al, ax, ay


@kernel
def row_value(row: np.record, pose: Array) -> float:
    """Closure error of one row [m, rad]; zero when the joint is closed."""
    if row.kind == ANGLE:
        return pose[row.b.body, 2] - pose[row.a.body, 2]
    dx, dy, _ = gap(pose, row.a, row.b)
    ux, uy = row_direction(row, pose)
    return dx * ux + dy * uy


@inlined_kernel
def row_direction(row: np.record, pose: Array) -> tuple[float, float]:
    """Direction of a row in plane axes."""
    if row.kind == ALONG_BODY:
        return turned(pose, row.a.body, row.ux, row.uy)
    return row.ux, row.uy


@kernel
def row_rate(row: np.record, pose: Array, vel: Array) -> float:
    """Time derivative of `row_value`."""
    if row.kind == ANGLE:
        return vel[row.b.body, 0] - vel[row.a.body, 0]
    dx, dy, arms = gap(pose, row.a, row.b)
    vx, vy = gap_rate(vel, row.a, row.b, arms)
    ux, uy = row_direction(row, pose)
    rate = vx * ux + vy * uy
    if row.kind == ALONG_BODY:
        rate += vel[row.a.body, 0] * (dy * ux - dx * uy)
    return rate


@kernel
def row_acceleration(row: np.record, pose: Array, vel: Array, acc: Array) -> float:
    """Second time derivative of `row_value`."""
    if row.kind == ANGLE:
        return acc[row.b.body, 0] - acc[row.a.body, 0]
    dx, dy, arms = gap(pose, row.a, row.b)
    ax, ay = gap_acceleration(vel, acc, row.a, row.b, arms)
    ux, uy = row_direction(row, pose)
    second = ax * ux + ay * uy
    if row.kind == ALONG_BODY:
        w, al = vel[row.a.body, 0], acc[row.a.body, 0]
        vx, vy = gap_rate(vel, row.a, row.b, arms)
        turn = al * (dy * ux - dx * uy) - w * w * (dx * ux + dy * uy)
        second += 2.0 * w * (vy * ux - vx * uy) + turn
    return second


@kernel
def add_row_wrench(row: np.record, pose: Array, size: float, wrench: Array) -> None:
    """Add the wrench of a row's reaction of this size: on body b, and the opposite on body a."""
    if row.kind == ANGLE:
        wrench[row.b.body, 0] += size
        wrench[row.a.body, 0] -= size
        return
    dx, dy, arms = gap(pose, row.a, row.b)
    ux, uy = row_direction(row, pose)
    if row.kind == ALONG_BODY:  # acts on body a at point b, where it touches
        arms = both_at_b(arms, dx, dy)
    add_pair(wrench, row.a, row.b, arms, size * ux, size * uy)


@inlined_kernel
def along(body: np.record, pose: Array, wrench: Array) -> float:
    """Part of a wrench (3,) on a body along the coordinate of its joint."""
    if body.type == REVOLUTE:
        return body.sign * wrench[0]
    ux, uy = turned(pose, body.mount.body, body.ux, body.uy)
    return ux * wrench[1] + uy * wrench[2]


@inlined_kernel
def add_to_parent(bodies: Records, pose: Array, i: int, wrench: Array) -> None:
    """Add the wrench of body i to its parent's."""
    p = bodies[i].mount.body
    rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
    wrench[p, 0] += wrench[i, 0] + rx * wrench[i, 2] - ry * wrench[i, 1]
    wrench[p, 1] += wrench[i, 1]
    wrench[p, 2] += wrench[i, 2]


@kernel
def spread(bodies: Records, q: Array, v: Array, a: Array, pose: Array, vel: Array, acc: Array) -> None:
    """Body poses (nt, nb, 5), velocities and accelerations (nt, nb, 3) for a table of coordinates (nt, n)."""
    for k in range(len(q)):
        body_positions(bodies, q[k], pose[k])
        body_velocities(bodies, pose[k], v[k], vel[k])
        body_accelerations(bodies, pose[k], vel[k], v[k], a[k], acc[k])
