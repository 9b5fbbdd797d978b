"""Positions, velocities and accelerations of all bodies, and of the closure rows."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from linkages.kernel import kernel
from linkages.planar.records import ALONG_BODY, ANGLE, PRISMATIC, REVOLUTE

Array = NDArray[np.float64]


@kernel
def body_positions(bodies: NDArray[np.record], q: Array, pose: Array) -> None:
    """Fill ``pose`` (nb, 5) with x, y [m], angle [rad] of each body frame, and the angle's cosine and sine."""
    pose[0, 0] = 0.0
    pose[0, 1] = 0.0
    pose[0, 2] = 0.0
    pose[0, 3] = 1.0
    pose[0, 4] = 0.0
    for i in range(1, len(bodies)):
        body = bodies[i]
        p = body.parent
        c, s = pose[p, 3], pose[p, 4]
        x, y = body.x, body.y
        if body.type == PRISMATIC:
            x += body.ux * q[body.dof]
            y += body.uy * q[body.dof]
        pose[i, 0] = pose[p, 0] + c * x - s * y
        pose[i, 1] = pose[p, 1] + s * x + c * y
        if body.type == REVOLUTE:
            angle = pose[p, 2] + body.sign * q[body.dof]
            pose[i, 2] = angle
            pose[i, 3] = math.cos(angle)
            pose[i, 4] = math.sin(angle)
        else:
            pose[i, 2] = pose[p, 2]
            pose[i, 3] = c
            pose[i, 4] = s


@kernel
def body_velocities(bodies: NDArray[np.record], pose: Array, v: Array, vel: Array) -> None:
    """Fill ``vel`` (nb, 3) with angular velocity [rad/s] and velocity of each frame's origin [m/s]."""
    vel[0, :] = 0.0
    for i in range(1, len(bodies)):
        body = bodies[i]
        p = body.parent
        w = vel[p, 0]
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        vx, vy = vel[p, 1] - w * ry, vel[p, 2] + w * rx
        if body.type == REVOLUTE:
            w += body.sign * v[body.dof]
        elif body.type == PRISMATIC:
            c, s = pose[p, 3], pose[p, 4]
            vx += (c * body.ux - s * body.uy) * v[body.dof]
            vy += (s * body.ux + c * body.uy) * v[body.dof]
        vel[i, 0] = w
        vel[i, 1] = vx
        vel[i, 2] = vy


@kernel
def body_accelerations(
    bodies: NDArray[np.record], pose: Array, vel: Array, v: Array, a: Array, acc: Array
) -> None:
    """Fill ``acc`` (nb, 3) with angular acceleration and acceleration of each frame's origin."""
    acc[0, :] = 0.0
    for i in range(1, len(bodies)):
        body = bodies[i]
        p = body.parent
        w, al = vel[p, 0], acc[p, 0]
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        ax = acc[p, 1] - al * ry - w * w * rx
        ay = acc[p, 2] + al * rx - w * w * ry
        if body.type == REVOLUTE:
            al += body.sign * a[body.dof]
        elif body.type == PRISMATIC:
            c, s = pose[p, 3], pose[p, 4]
            ux, uy = c * body.ux - s * body.uy, s * body.ux + c * body.uy
            rate = 2.0 * w * v[body.dof]
            ax += ux * a[body.dof] - uy * rate
            ay += uy * a[body.dof] + ux * rate
        acc[i, 0] = al
        acc[i, 1] = ax
        acc[i, 2] = ay


@kernel
def point_offset(pose: Array, body: int, x: float, y: float) -> tuple[float, float]:
    """Vector from the origin of a body frame to a point given in it, in plane axes [m]."""
    c, s = pose[body, 3], pose[body, 4]
    return c * x - s * y, s * x + c * y


@kernel
def row_value(row: np.record, pose: Array) -> float:
    """Closure error of one row [m, rad]; zero when the joint is closed."""
    if row.kind == ANGLE:
        return pose[row.b, 2] - pose[row.a, 2]
    rax, ray = point_offset(pose, row.a, row.ax, row.ay)
    rbx, rby = point_offset(pose, row.b, row.bx, row.by)
    dx = pose[row.b, 0] + rbx - pose[row.a, 0] - rax
    dy = pose[row.b, 1] + rby - pose[row.a, 1] - ray
    ux, uy = row.ux, row.uy
    if row.kind == ALONG_BODY:
        ux, uy = point_offset(pose, row.a, row.ux, row.uy)
    return dx * ux + dy * uy


@kernel
def row_rate(row: np.record, pose: Array, vel: Array) -> float:
    """Time derivative of `row_value`."""
    if row.kind == ANGLE:
        return vel[row.b, 0] - vel[row.a, 0]
    rax, ray = point_offset(pose, row.a, row.ax, row.ay)
    rbx, rby = point_offset(pose, row.b, row.bx, row.by)
    wa, wb = vel[row.a, 0], vel[row.b, 0]
    vx = vel[row.b, 1] - wb * rby - vel[row.a, 1] + wa * ray
    vy = vel[row.b, 2] + wb * rbx - vel[row.a, 2] - wa * rax
    if row.kind != ALONG_BODY:
        return vx * row.ux + vy * row.uy
    ux, uy = point_offset(pose, row.a, row.ux, row.uy)
    dx = pose[row.b, 0] + rbx - pose[row.a, 0] - rax
    dy = pose[row.b, 1] + rby - pose[row.a, 1] - ray
    return vx * ux + vy * uy + wa * (dy * ux - dx * uy)


@kernel
def row_acceleration(row: np.record, pose: Array, vel: Array, acc: Array) -> float:
    """Second time derivative of `row_value`."""
    if row.kind == ANGLE:
        return acc[row.b, 0] - acc[row.a, 0]
    rax, ray = point_offset(pose, row.a, row.ax, row.ay)
    rbx, rby = point_offset(pose, row.b, row.bx, row.by)
    wa, wb = vel[row.a, 0], vel[row.b, 0]
    ala, alb = acc[row.a, 0], acc[row.b, 0]
    ax = acc[row.b, 1] - alb * rby - wb * wb * rbx - acc[row.a, 1] + ala * ray + wa * wa * rax
    ay = acc[row.b, 2] + alb * rbx - wb * wb * rby - acc[row.a, 2] - ala * rax + wa * wa * ray
    if row.kind != ALONG_BODY:
        return ax * row.ux + ay * row.uy
    ux, uy = point_offset(pose, row.a, row.ux, row.uy)
    dx = pose[row.b, 0] + rbx - pose[row.a, 0] - rax
    dy = pose[row.b, 1] + rby - pose[row.a, 1] - ray
    vx = vel[row.b, 1] - wb * rby - vel[row.a, 1] + wa * ray
    vy = vel[row.b, 2] + wb * rbx - vel[row.a, 2] - wa * rax
    turn = ala * (dy * ux - dx * uy) - wa * wa * (dx * ux + dy * uy)
    return ax * ux + ay * uy + 2.0 * wa * (vy * ux - vx * uy) + turn


@kernel
def add_row_wrench(row: np.record, pose: Array, size: float, wrench: Array) -> None:
    """Add the wrench of a row's reaction of this size: on body b, and the opposite on body a."""
    if row.kind == ANGLE:
        wrench[row.b, 0] += size
        wrench[row.a, 0] -= size
        return
    rbx, rby = point_offset(pose, row.b, row.bx, row.by)
    ux, uy = row.ux, row.uy
    rax, ray = point_offset(pose, row.a, row.ax, row.ay)
    if row.kind == ALONG_BODY:  # acts on body a at point b, where it touches
        ux, uy = point_offset(pose, row.a, row.ux, row.uy)
        rax = pose[row.b, 0] + rbx - pose[row.a, 0]
        ray = pose[row.b, 1] + rby - pose[row.a, 1]
    fx, fy = size * ux, size * uy
    add_force(wrench, row.b, rbx, rby, fx, fy)
    add_force(wrench, row.a, rax, ray, -fx, -fy)


@kernel
def add_force(wrench: Array, body: int, rx: float, ry: float, fx: float, fy: float) -> None:
    """Add a force at (rx, ry) from the body frame's origin to the body's wrench."""
    wrench[body, 0] += rx * fy - ry * fx
    wrench[body, 1] += fx
    wrench[body, 2] += fy


@kernel
def spread(
    bodies: NDArray[np.record], q: Array, v: Array, a: Array, pose: Array, vel: Array, acc: Array
) -> None:
    """Body poses (nt, nb, 5), velocities and accelerations (nt, nb, 3) for a table of coordinates (nt, n)."""
    for k in range(len(q)):
        body_positions(bodies, q[k], pose[k])
        body_velocities(bodies, pose[k], v[k], vel[k])
        body_accelerations(bodies, pose[k], vel[k], v[k], a[k], acc[k])
