"""Markers: points fixed to bodies, to which joints, contacts, loads, springs and outputs attach.

A `linkages.mechanics.planar.record_types.MARKER` names a body and a place in its frame. This module alone computes the
position, velocity and acceleration of markers, and the effect of a force at a marker on its body. On a deformable
body a marker is fixed to a node, which is a body of its own.

An *arm* r points from the origin of the body's frame to the marker, in plane axes. A *gap* d = p_b - p_a points from
marker a to marker b.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, inlined_kernel
from linkages.mechanics.planar.bodies import COS, SIN

Two = tuple[float, float]
Arms = tuple[float, float, float, float]


@inlined_kernel
def turned(pose: Array, body: int, x: float, y: float) -> Two:
    """Turn a vector given in a body's frame into plane axes."""
    c, s = pose[body, COS], pose[body, SIN]
    return c * x - s * y, s * x + c * y


@inlined_kernel
def offset(pose: Array, a: int, b: int) -> Two:
    """Vector from the origin of body a's frame to the origin of body b's [m]."""
    return pose[b, 0] - pose[a, 0], pose[b, 1] - pose[a, 1]


@inlined_kernel
def arm(pose: Array, marker: np.record) -> Two:
    """Arm of a marker [m]."""
    return turned(pose, marker.body, marker.x, marker.y)


@inlined_kernel
def marker_velocity(vel: Array, body: int, rx: float, ry: float) -> Two:
    """Velocity of a body's marker with the arm r [m/s]."""
    w = vel[body, 0]
    return vel[body, 1] - w * ry, vel[body, 2] + w * rx


@inlined_kernel
def marker_acceleration(vel: Array, acc: Array, body: int, rx: float, ry: float) -> Two:
    """Acceleration of a body's marker with the arm r [m/s2]."""
    w, al = vel[body, 0], acc[body, 0]
    return acc[body, 1] - al * ry - w * w * rx, acc[body, 2] + al * rx - w * w * ry


@inlined_kernel
def gap(pose: Array, a: np.record, b: np.record) -> tuple[float, float, Arms]:
    """Gap between two markers [m], and the arms of both: dx, dy, (rax, ray, rbx, rby)."""
    rax, ray = arm(pose, a)
    rbx, rby = arm(pose, b)
    dx = pose[b.body, 0] + rbx - pose[a.body, 0] - rax
    dy = pose[b.body, 1] + rby - pose[a.body, 1] - ray
    return dx, dy, (rax, ray, rbx, rby)


@inlined_kernel
def gap_rate(vel: Array, a: np.record, b: np.record, arms: Arms) -> Two:
    """Rate of a gap [m/s]."""
    rax, ray, rbx, rby = arms
    vax, vay = marker_velocity(vel, a.body, rax, ray)
    vbx, vby = marker_velocity(vel, b.body, rbx, rby)
    return vbx - vax, vby - vay


@inlined_kernel
def gap_acceleration(vel: Array, acc: Array, a: np.record, b: np.record, arms: Arms) -> Two:
    """Second rate of a gap [m/s2]."""
    rax, ray, rbx, rby = arms
    aax, aay = marker_acceleration(vel, acc, a.body, rax, ray)
    abx, aby = marker_acceleration(vel, acc, b.body, rbx, rby)
    return abx - aax, aby - aay


@inlined_kernel
def add_force(wrench: Array, body: int, rx: float, ry: float, fx: float, fy: float) -> None:
    """Add a force at the arm r to a body's wrench."""
    wrench[body, 0] += rx * fy - ry * fx
    wrench[body, 1] += fx
    wrench[body, 2] += fy


@inlined_kernel
def both_at_b(arms: Arms, dx: float, dy: float) -> Arms:
    """Arms of a force at marker b and of the opposite one, which acts there too, across the gap."""
    rax, ray, rbx, rby = arms
    return rax + dx, ray + dy, rbx, rby


@inlined_kernel
def add_pair(wrench: Array, a: np.record, b: np.record, arms: Arms, fx: float, fy: float) -> None:
    """Add a force on body b at the one arm and the opposite one on body a at the other."""
    rax, ray, rbx, rby = arms
    add_force(wrench, b.body, rbx, rby, fx, fy)
    add_force(wrench, a.body, rax, ray, -fx, -fy)
