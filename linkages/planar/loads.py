"""Applied loads: forces, torques, springs and torsion springs with dampers, from body states to wrenches.

Loads are packed as ``(records, breaks, coefficients, segments)``: an array of `LOAD`, and `Motions.arrays` with the
values over time of forces and torques; see `linkages.system.loads.pack_loads`.

A spring from point a to point b, d = p_b - p_a, length l = |d|, u = d/l, pulls with the tension
T = k (l - l_0) + c dl/dt: T u on a, -T u on b. A torsion spring between bodies a and b at the angle phi (zero in the
drawn pose) resists with the torque M = k (phi - phi_0) + c dphi/dt: -M along phi on b, M on a.

Where a spring's length is exactly zero its direction is that of the relative velocity, and the force is the mean of
those just before and just after: c times the relative velocity. A free length above zero makes the force jump there.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from linkages.kernel import kernel
from linkages.planar.kinematics import add_force, point_offset
from linkages.planar.motion import motion_value
from linkages.planar.records import FORCE, SPRING, TORQUE

Array = NDArray[np.float64]
Loads = tuple[NDArray[np.record], Array, Array, NDArray[np.int64]]

#: What is known of each load at a state. Force: fx, fy in plane axes [N]; torque: its value [N m] and 0; spring:
#: tension [N] and length [m]; torsion spring: resisting torque [N m] and angle [rad]. Then for each the power that it
#: delivers to the bodies [W], and the energy that it stores [J].
LOAD_OUTPUTS = ("value", "second", "power", "energy")


@kernel
def load_wrenches(loads: Loads, t: float, pose: Array, vel: Array, wrench: Array) -> None:
    """Add the wrenches of all loads to the bodies' wrenches.

    Parameters
    ----------
    loads : tuple
        From `linkages.system.loads.pack_loads`.
    t : float
        Time [s].
    pose, vel : (nb, 5), (nb, 3) arrays
        From `body_positions` and `body_velocities`.
    wrench : (nb, 3) array
        Added to.
    """
    records, breaks, coefficients, segments = loads
    for k in range(len(records)):
        load = records[k]
        a, b = load.a, load.b
        if load.kind == TORQUE:
            wrench[a, 0] += motion_value(breaks, coefficients, segments, load.motion, t)
        elif load.kind == FORCE:
            fx, fy = _force(load, breaks, coefficients, segments, t, pose)
            rx, ry = point_offset(pose, a, load.ax, load.ay)
            add_force(wrench, a, rx, ry, fx, fy)
        elif load.kind == SPRING:
            tension, ux, uy, _, _ = _spring(load, pose, vel)
            fx, fy = tension * ux, tension * uy
            rx, ry = point_offset(pose, a, load.ax, load.ay)
            add_force(wrench, a, rx, ry, fx, fy)
            rx, ry = point_offset(pose, b, load.bx, load.by)
            add_force(wrench, b, rx, ry, -fx, -fy)
        else:
            torque, _, _ = _torsion(load, pose, vel)
            wrench[a, 0] += load.sign * torque
            wrench[b, 0] -= load.sign * torque


@kernel
def load_outputs(loads: Loads, t: float, pose: Array, vel: Array, outputs: Array) -> None:
    """Fill ``outputs`` (nl, 4) with `LOAD_OUTPUTS` of each load."""
    records, breaks, coefficients, segments = loads
    for k in range(len(records)):
        load = records[k]
        a = load.a
        second, energy = 0.0, 0.0
        if load.kind == TORQUE:
            value = motion_value(breaks, coefficients, segments, load.motion, t)
            power = value * vel[a, 0]
        elif load.kind == FORCE:
            value, second = _force(load, breaks, coefficients, segments, t, pose)
            rx, ry = point_offset(pose, a, load.ax, load.ay)
            power = value * (vel[a, 1] - vel[a, 0] * ry) + second * (vel[a, 2] + vel[a, 0] * rx)
        else:
            if load.kind == SPRING:
                value, _, _, second, rate = _spring(load, pose, vel)
            else:
                value, second, rate = _torsion(load, pose, vel)
            power = -value * rate
            energy = 0.5 * load.stiffness * (second - load.free) ** 2
        outputs[k, 0] = value
        outputs[k, 1] = second
        outputs[k, 2] = power
        outputs[k, 3] = energy


@kernel
def load_history(loads: Loads, times: Array, pose: Array, vel: Array, wrench: Array, outputs: Array) -> None:
    """Wrenches (nt, nb, 3), added to, and `LOAD_OUTPUTS` (nt, nl, 4), filled, over time."""
    for i in range(len(times)):
        load_wrenches(loads, times[i], pose[i], vel[i], wrench[i])
        load_outputs(loads, times[i], pose[i], vel[i], outputs[i])


@kernel
def _force(
    load: np.record, breaks: Array, coefficients: Array, segments: NDArray[np.int64], t: float, pose: Array
) -> tuple[float, float]:
    """Components of a force in plane axes."""
    fx = motion_value(breaks, coefficients, segments, load.motion, t)
    fy = motion_value(breaks, coefficients, segments, load.motion + 1, t)
    if load.turns:
        fx, fy = point_offset(pose, load.a, fx, fy)
    return fx, fy


@kernel
def _spring(load: np.record, pose: Array, vel: Array) -> tuple[float, float, float, float, float]:
    """Tension, its direction, length and rate of length of a spring."""
    a, b = load.a, load.b
    rax, ray = point_offset(pose, a, load.ax, load.ay)
    rbx, rby = point_offset(pose, b, load.bx, load.by)
    dx, dy = pose[b, 0] + rbx - pose[a, 0] - rax, pose[b, 1] + rby - pose[a, 1] - ray
    vx = vel[b, 1] - vel[b, 0] * rby - vel[a, 1] + vel[a, 0] * ray
    vy = vel[b, 2] + vel[b, 0] * rbx - vel[a, 2] - vel[a, 0] * rax
    length = math.sqrt(dx * dx + dy * dy)
    if length > 0.0:
        ux, uy = dx / length, dy / length
        rate = vx * ux + vy * uy
        return load.stiffness * (length - load.free) + load.damping * rate, ux, uy, length, rate
    rate = math.sqrt(vx * vx + vy * vy)
    if rate > 0.0:
        return load.damping * rate, vx / rate, vy / rate, length, rate
    return 0.0, 0.0, 0.0, length, rate


@kernel
def _torsion(load: np.record, pose: Array, vel: Array) -> tuple[float, float, float]:
    """Resisting torque, angle and its rate of a torsion spring."""
    angle = load.sign * (pose[load.b, 2] - pose[load.a, 2])
    rate = load.sign * (vel[load.b, 0] - vel[load.a, 0])
    return load.stiffness * (angle - load.free) + load.damping * rate, angle, rate


@kernel
def load_wrenches_tangent(
    loads: Loads, t: float, pose: Array, vel: Array, dpose: Array, dvel: Array, dwrench: Array
) -> None:
    """Add the directional derivative of `load_wrenches` at a fixed time.

    Parameters
    ----------
    loads, t, pose, vel
        As for `load_wrenches`.
    dpose, dvel : (nb, 5), (nb, 3) arrays
        Directional derivatives of ``pose`` (x, y, angle, cosine, sine) and ``vel``; zero for the world.
    dwrench : (nb, 3) array
        Added to.
    """
    records, breaks, coefficients, segments = loads
    for k in range(len(records)):
        load = records[k]
        a, b = load.a, load.b
        if load.kind == TORQUE:
            continue
        if load.kind == FORCE:
            fx, fy = _force(load, breaks, coefficients, segments, t, pose)
            dfx, dfy = 0.0, 0.0
            if load.turns:
                dfx, dfy = _force(load, breaks, coefficients, segments, t, dpose)
            _add_force_tangent(dwrench, pose, dpose, a, load.ax, load.ay, fx, fy, dfx, dfy)
        elif load.kind == SPRING:
            _spring_tangent(load, pose, vel, dpose, dvel, dwrench)
        else:
            torque = load.stiffness * (dpose[b, 2] - dpose[a, 2]) + load.damping * (dvel[b, 0] - dvel[a, 0])
            dwrench[a, 0] += torque
            dwrench[b, 0] -= torque


@kernel
def _spring_tangent(
    load: np.record, pose: Array, vel: Array, dpose: Array, dvel: Array, dwrench: Array
) -> None:
    """Add the derivative of a spring's wrenches; at zero length, of the part that has one."""
    a, b = load.a, load.b
    rax, ray = point_offset(pose, a, load.ax, load.ay)
    rbx, rby = point_offset(pose, b, load.bx, load.by)
    sax, say = point_offset(dpose, a, load.ax, load.ay)
    sbx, sby = point_offset(dpose, b, load.bx, load.by)
    wa, wb, dwa, dwb = vel[a, 0], vel[b, 0], dvel[a, 0], dvel[b, 0]
    dx, dy = pose[b, 0] + rbx - pose[a, 0] - rax, pose[b, 1] + rby - pose[a, 1] - ray
    vx, vy = vel[b, 1] - wb * rby - vel[a, 1] + wa * ray, vel[b, 2] + wb * rbx - vel[a, 2] - wa * rax
    ex, ey = dpose[b, 0] + sbx - dpose[a, 0] - sax, dpose[b, 1] + sby - dpose[a, 1] - say
    gx = dvel[b, 1] - dwb * rby - wb * sby - dvel[a, 1] + dwa * ray + wa * say
    gy = dvel[b, 2] + dwb * rbx + wb * sbx - dvel[a, 2] - dwa * rax - wa * sax
    length = math.sqrt(dx * dx + dy * dy)
    stiffness, damping = load.stiffness, load.damping
    if length > 0.0:
        ux, uy = dx / length, dy / length
        stretching = ex * ux + ey * uy
        turnx, turny = (ex - stretching * ux) / length, (ey - stretching * uy) / length
        tension = stiffness * (length - load.free) + damping * (vx * ux + vy * uy)
        rise = stiffness * stretching + damping * (gx * ux + gy * uy + vx * turnx + vy * turny)
        fx, fy = tension * ux, tension * uy
        dfx, dfy = rise * ux + tension * turnx, rise * uy + tension * turny
    else:
        fx, fy = damping * vx, damping * vy
        dfx, dfy = stiffness * ex + damping * gx, stiffness * ey + damping * gy
    _add_force_tangent(dwrench, pose, dpose, a, load.ax, load.ay, fx, fy, dfx, dfy)
    _add_force_tangent(dwrench, pose, dpose, b, load.bx, load.by, -fx, -fy, -dfx, -dfy)


@kernel
def _add_force_tangent(
    dwrench: Array,
    pose: Array,
    dpose: Array,
    body: int,
    x: float,
    y: float,
    fx: float,
    fy: float,
    dfx: float,
    dfy: float,
) -> None:
    """Add the derivative of the wrench of a force at a point of a body."""
    rx, ry = point_offset(pose, body, x, y)
    sx, sy = point_offset(dpose, body, x, y)
    dwrench[body, 0] += sx * fy - sy * fx + rx * dfy - ry * dfx
    dwrench[body, 1] += dfx
    dwrench[body, 2] += dfy
