"""Markers: points fixed to bodies, to which joints, contacts, loads, springs and outputs attach.

A `linkages.planar.record_types.MARKER` names a body and a place in its frame. This module alone computes the position,
velocity and acceleration of markers, the effect of a force at a marker on its body, and the derivatives of these. On a
flexible link a marker is fixed to a cross-section, which is a body of its own.

An *arm* r points from the origin of the body's frame to the marker, in plane axes. A *gap* d = p_b - p_a points from
marker a to marker b. The functions named ``..._tangent`` give changes along a direction in which bodies turn and move
by (turn, dx, dy); see `linkages.planar.tangent`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.kernel import Array, inlined_kernel
from linkages.planar.bodies import COS, SIN

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
def arm_tangent(dpose: Array, marker: np.record, rx: float, ry: float) -> Two:
    """Change of a marker's arm r."""
    turn = dpose[marker.body, 0]
    return -turn * ry, turn * rx


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
def velocity_tangent(vel: Array, dvel: Array, body: int, rx: float, ry: float, drx: float, dry: float) -> Two:
    """Change of a marker's velocity; its arm r changes by dr."""
    w, dw = vel[body, 0], dvel[body, 0]
    return dvel[body, 1] - dw * ry - w * dry, dvel[body, 2] + dw * rx + w * drx


@inlined_kernel
def acceleration_tangent(
    vel: Array, acc: Array, dvel: Array, dacc: Array, body: int, rx: float, ry: float, drx: float, dry: float
) -> Two:
    """Change of a marker's acceleration; its arm r changes by dr."""
    w, al, dw, dal = vel[body, 0], acc[body, 0], dvel[body, 0], dacc[body, 0]
    return (
        dacc[body, 1] - dal * ry - al * dry - 2.0 * w * dw * rx - w * w * drx,
        dacc[body, 2] + dal * rx + al * drx - 2.0 * w * dw * ry - w * w * dry,
    )


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
def gap_tangent(dpose: Array, a: np.record, b: np.record, arms: Arms) -> tuple[float, float, Arms]:
    """Change of a gap and of both arms."""
    rax, ray, rbx, rby = arms
    drax, dray = arm_tangent(dpose, a, rax, ray)
    drbx, drby = arm_tangent(dpose, b, rbx, rby)
    dx = dpose[b.body, 1] + drbx - dpose[a.body, 1] - drax
    dy = dpose[b.body, 2] + drby - dpose[a.body, 2] - dray
    return dx, dy, (drax, dray, drbx, drby)


@inlined_kernel
def gap_rate_tangent(vel: Array, dvel: Array, a: np.record, b: np.record, arms: Arms, change: Arms) -> Two:
    """Change of a gap's rate; the arms change as `gap_tangent` says."""
    rax, ray, rbx, rby = arms
    drax, dray, drbx, drby = change
    ax, ay = velocity_tangent(vel, dvel, a.body, rax, ray, drax, dray)
    bx, by = velocity_tangent(vel, dvel, b.body, rbx, rby, drbx, drby)
    return bx - ax, by - ay


@inlined_kernel
def add_force(wrench: Array, body: int, rx: float, ry: float, fx: float, fy: float) -> None:
    """Add a force at the arm r to a body's wrench."""
    wrench[body, 0] += rx * fy - ry * fx
    wrench[body, 1] += fx
    wrench[body, 2] += fy


@inlined_kernel
def add_force_tangent(
    dwrench: Any, body: int, rx: float, ry: float, drx: Any, dry: Any, fx: float, fy: float, dfx: Any, dfy: Any
) -> None:
    """Add the change of a force at the arm r to a body's wrench; the arm changes by dr, the force by df."""
    dwrench[body, 0] += drx * fy - dry * fx + rx * dfy - ry * dfx
    dwrench[body, 1] += dfx
    dwrench[body, 2] += dfy


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


@inlined_kernel
def add_pair_tangent(
    dwrench: Array, a: np.record, b: np.record, arms: Arms, moved: Arms, force: Two, change: Two
) -> None:
    """Add the change of the wrenches of `add_pair`."""
    (rax, ray, rbx, rby), (drax, dray, drbx, drby), (fx, fy), (dfx, dfy) = arms, moved, force, change
    add_force_tangent(dwrench, b.body, rbx, rby, drbx, drby, fx, fy, dfx, dfy)
    add_force_tangent(dwrench, a.body, rax, ray, drax, dray, -fx, -fy, -dfx, -dfy)
