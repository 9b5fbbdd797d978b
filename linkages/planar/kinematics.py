"""Positions, velocities and accelerations of all bodies, and of the closure rows."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.kernel import Array, inlined_kernel, kernel
from linkages.planar.bending import add_to_modes, bend, deform, modal_motion, shortening
from linkages.planar.bodies import POSE, Bodies
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
from linkages.planar.record_types import ALONG_BODY, ANGLE, PRISMATIC, REVOLUTE, SECTION


@kernel
def body_positions(bodies: Bodies, q: Array, pose: Array) -> None:
    """Fill ``pose`` (nb, 5) with x, y [m], angle [rad] of each body frame, and the angle's cosine and sine.

    Of bodies that bend there is more, see `linkages.planar.bodies.POSE`.
    """
    pose[0, 0], pose[0, 1], pose[0, 2], pose[0, 3], pose[0, 4] = 0.0, 0.0, 0.0, 1.0, 0.0
    for i in range(1, len(bodies.records)):
        _body_position(bodies, i, q, pose)


@kernel
def body_velocities(bodies: Bodies, pose: Array, v: Array, vel: Array) -> None:
    """Fill ``vel`` (nb, 3) with angular velocity [rad/s] and velocity of each frame's origin [m/s]."""
    vel[0, 0], vel[0, 1], vel[0, 2] = 0.0, 0.0, 0.0
    for i in range(1, len(bodies.records)):
        _body_velocity(bodies, i, pose, v, vel)


@kernel
def body_states(bodies: Bodies, q: Array, v: Array, pose: Array, vel: Array) -> None:
    """Fill ``pose`` and ``vel`` as `body_positions` and `body_velocities`, body by body."""
    pose[0, 0], pose[0, 1], pose[0, 2], pose[0, 3], pose[0, 4] = 0.0, 0.0, 0.0, 1.0, 0.0
    vel[0, 0], vel[0, 1], vel[0, 2] = 0.0, 0.0, 0.0
    for i in range(1, len(bodies.records)):
        _body_position(bodies, i, q, pose)
        _body_velocity(bodies, i, pose, v, vel)


@kernel
def body_accelerations(bodies: Bodies, pose: Array, vel: Array, v: Array, a: Array, acc: Array) -> None:
    """Fill ``acc`` (nb, 3) with angular acceleration and acceleration of each frame's origin."""
    acc[0, 0], acc[0, 1], acc[0, 2] = 0.0, 0.0, 0.0
    for i in range(1, len(bodies.records)):
        body_acceleration(bodies, i, pose, vel, v, a, acc)


@inlined_kernel
def _body_position(bodies: Bodies, i: int, q: Array, pose: Array) -> None:
    """Fill the line of body i; its parent's is known."""
    body = bodies.records[i]
    p = body.mount.body
    if body.type == SECTION:
        if body.apart:  # else its beam has filled it
            bend(bodies, i, pose)
        return
    rx, ry = arm(pose, body.mount)
    x, y = pose[p, 0] + rx, pose[p, 1] + ry
    angle, cosine, sine = pose[p, 2], pose[p, 3], pose[p, 4]
    if body.type == REVOLUTE:
        angle += body.sign * q[body.dof]
        cosine, sine = math.cos(angle), math.sin(angle)
    elif body.type == PRISMATIC:
        ux, uy = turned(pose, p, body.ux, body.uy)
        x += ux * q[body.dof]
        y += uy * q[body.dof]
    pose[i, 0], pose[i, 1] = x, y
    pose[i, 2], pose[i, 3], pose[i, 4] = angle, cosine, sine
    if body.modes > 0:
        for k in range(body.modes):
            pose[i, POSE + k] = q[body.eta + k]
        deform(bodies, i, pose)


@inlined_kernel
def _body_velocity(bodies: Bodies, i: int, pose: Array, v: Array, vel: Array) -> None:
    """Fill the line of body i; its parent's is known."""
    body = bodies.records[i]
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
    elif body.type == SECTION:
        turn, dx, dy = modal_motion(bodies, i, pose, vel)
        w, vx, vy = w + turn, vx + dx, vy + dy
    vel[i, 0], vel[i, 1], vel[i, 2] = w, vx, vy
    for k in range(body.modes):
        vel[i, 3 + k] = v[body.eta + k]


@inlined_kernel
def body_acceleration(bodies: Bodies, i: int, pose: Array, vel: Array, v: Array, a: Array, acc: Array) -> None:
    """Fill the line of body i in ``acc``; its parent's is known."""
    body = bodies.records[i]
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
    elif body.type == SECTION:
        ux, uy = turned(pose, p, body.ux, body.uy)
        _, dx, dy = modal_motion(bodies, i, pose, vel)
        turn, ddx, ddy = modal_motion(bodies, i, pose, acc)
        bent = shortening(bodies, i, vel, vel)
        al, ax, ay = al + turn, ax + ddx - 2.0 * w * dy - bent * ux, ay + ddy + 2.0 * w * dx - bent * uy
    acc[i, 0], acc[i, 1], acc[i, 2] = al, ax, ay
    for k in range(body.modes):
        acc[i, 3 + k] = a[body.eta + k]


@kernel
def term_value(term: np.record, pose: Array) -> float:
    """Value of a term [m, rad]."""
    if term.kind == ANGLE:
        return pose[term.b.body, 2] - pose[term.a.body, 2]
    dx, dy, _ = gap(pose, term.a, term.b)
    ux, uy = term_direction(term, pose)
    return dx * ux + dy * uy


@inlined_kernel
def term_direction(term: np.record, pose: Array) -> tuple[float, float]:
    """Direction of a term in plane axes."""
    if term.kind == ALONG_BODY:
        return turned(pose, term.a.body, term.ux, term.uy)
    return term.ux, term.uy


@kernel
def term_rate(term: np.record, pose: Array, vel: Array) -> float:
    """Time derivative of `term_value`."""
    if term.kind == ANGLE:
        return vel[term.b.body, 0] - vel[term.a.body, 0]
    dx, dy, arms = gap(pose, term.a, term.b)
    vx, vy = gap_rate(vel, term.a, term.b, arms)
    ux, uy = term_direction(term, pose)
    rate = vx * ux + vy * uy
    if term.kind == ALONG_BODY:
        rate += vel[term.a.body, 0] * (dy * ux - dx * uy)
    return rate


@kernel
def term_acceleration(term: np.record, pose: Array, vel: Array, acc: Array) -> float:
    """Second time derivative of `term_value`."""
    if term.kind == ANGLE:
        return acc[term.b.body, 0] - acc[term.a.body, 0]
    dx, dy, arms = gap(pose, term.a, term.b)
    ax, ay = gap_acceleration(vel, acc, term.a, term.b, arms)
    ux, uy = term_direction(term, pose)
    second = ax * ux + ay * uy
    if term.kind == ALONG_BODY:
        w, al = vel[term.a.body, 0], acc[term.a.body, 0]
        vx, vy = gap_rate(vel, term.a, term.b, arms)
        turn = al * (dy * ux - dx * uy) - w * w * (dx * ux + dy * uy)
        second += 2.0 * w * (vy * ux - vx * uy) + turn
    return second


@kernel
def add_term_wrench(term: np.record, pose: Array, size: float, wrench: Array) -> None:
    """Add the wrench of a term's reaction of this size: on body b, and the opposite on body a."""
    if term.kind == ANGLE:
        wrench[term.b.body, 0] += size
        wrench[term.a.body, 0] -= size
        return
    dx, dy, arms = gap(pose, term.a, term.b)
    ux, uy = term_direction(term, pose)
    if term.kind == ALONG_BODY:  # acts on body a at point b, where it touches
        arms = both_at_b(arms, dx, dy)
    add_pair(wrench, term.a, term.b, arms, size * ux, size * uy)


@kernel
def row_value(row: np.record, pose: Array) -> float:
    """Closure error of one row [m, rad]; zero when the joint is closed."""
    value = term_value(row.term, pose)
    return value if row.ratio == 0.0 else value - row.ratio * term_value(row.other, pose) - row.offset


@kernel
def row_rate(row: np.record, pose: Array, vel: Array) -> float:
    """Time derivative of `row_value`."""
    rate = term_rate(row.term, pose, vel)
    return rate if row.ratio == 0.0 else rate - row.ratio * term_rate(row.other, pose, vel)


@kernel
def row_acceleration(row: np.record, pose: Array, vel: Array, acc: Array) -> float:
    """Second time derivative of `row_value`."""
    second = term_acceleration(row.term, pose, vel, acc)
    return second if row.ratio == 0.0 else second - row.ratio * term_acceleration(row.other, pose, vel, acc)


@kernel
def add_row_wrench(row: np.record, pose: Array, size: float, wrench: Array) -> None:
    """Add the wrench of a row's reaction of this size."""
    if row.ratio != 0.0:
        add_term_wrench(row.other, pose, -row.ratio * size, wrench)
    add_term_wrench(row.term, pose, size, wrench)


@inlined_kernel
def along(body: np.record, pose: Array, wrench: Any) -> float:
    """Part of a wrench (3,), or a tuple, on a body along the coordinate of its joint."""
    if body.type == REVOLUTE:
        return body.sign * wrench[0]
    ux, uy = turned(pose, body.mount.body, body.ux, body.uy)
    return ux * wrench[1] + uy * wrench[2]


@inlined_kernel
def add_to_parent(bodies: Bodies, pose: Array, i: int, wrench: Array) -> None:
    """Add the wrench of body i to its parent's."""
    p = bodies.records[i].mount.body
    rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
    wrench[p, 0] += wrench[i, 0] + rx * wrench[i, 2] - ry * wrench[i, 1]
    wrench[p, 1] += wrench[i, 1]
    wrench[p, 2] += wrench[i, 2]
    if bodies.records[i].type == SECTION:
        add_to_modes(bodies, i, pose, wrench[i, 0], wrench[i, 1], wrench[i, 2], wrench)


@kernel
def spread(bodies: Bodies, q: Array, v: Array, a: Array, pose: Array, vel: Array, acc: Array) -> None:
    """Body poses (nt, nb, 5), velocities and accelerations (nt, nb, 3) for a table of coordinates (nt, n)."""
    for k in range(len(q)):
        body_states(bodies, q[k], v[k], pose[k], vel[k])
        body_accelerations(bodies, pose[k], vel[k], v[k], a[k], acc[k])
