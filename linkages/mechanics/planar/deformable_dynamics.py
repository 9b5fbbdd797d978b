"""Dynamics of deformable bodies: inertias, elimination of the shapes, inertial and elastic forces, energy.

The beam is described in `linkages.mechanics.planar.bodies`, the symbols in `linkages.mechanics.planar.workspace`.
"""

from __future__ import annotations

from typing import Any

from linkages.base.kernel import Array, inlined_kernel, lazy_kernel
from linkages.base.kernel.simd import lane, lanes
from linkages.mechanics.planar.bodies import (
    DAMPING,
    ELASTIC,
    LOCK,
    MATRIX,
    STIFFNESS,
    Bodies,
    node_motion,
    point_motion,
    points,
    remainder,
)
from linkages.mechanics.planar.deformable_kinematics import matrix_product, point_rates, shape_entries
from linkages.mechanics.planar.markers import turned
from linkages.mechanics.planar.workspace import Workspace


@inlined_kernel
def _quarter_turn(x: Any) -> Any:
    """Two vectors in lanes, turned by a quarter counter-clockwise."""
    return lanes(lane(x, 1), lane(x, 0), lane(x, 3), lane(x, 2)) * lanes(-1.0, 1.0, -1.0, 1.0)


@inlined_kernel
def _sum(x: Any) -> float:
    """Sum of lanes."""
    return (lane(x, 0) + lane(x, 1)) + (lane(x, 2) + lane(x, 3))


@lazy_kernel
def deformable_inertia(bodies: Bodies, i: int, work: Workspace) -> None:
    """Set the inertias of deformable body i: of its frame, of its shapes, and their coupling."""
    pose, inertia, coupling, own = work.pose, work.inertia[i], work.shape.coupling[i], work.shape.inertia[i]
    body, shapes = bodies.records[i], bodies.shapes[i]
    places, (ux, uy) = points(pose, i), turned(pose, i, body.ex, body.ey)
    mass = body.mass
    turning, moment = _quarter_turn(places) * mass, mass * _sum(places * places)
    along, across = mass * lane(places, 0), mass * lane(places, 1)
    for k in range(body.shapes):
        motion, (m_eta, t_eta) = point_motion(pose, i, k), remainder(pose, i, k)
        psi, b = mass * lane(motion, 0), mass * lane(motion, 1)
        moment += m_eta * work.q[body.eta + k]
        coupling[k].I_t = _sum(turning * motion) + t_eta
        coupling[k].I_x = psi * ux - b * uy
        coupling[k].I_y = psi * uy + b * ux
        for m in range(k + 1):
            own[k, m] = mass * _sum(motion * point_motion(pose, i, m)) + lane(shapes[MATRIX + k, m], 1)
        own[k, k] += lane(shapes[ELASTIC, k], LOCK)
    inertia.tt, inertia.tx, inertia.ty = moment, -(along * uy + across * ux), along * ux - across * uy
    inertia.xx, inertia.xy, inertia.yy = mass, 0.0, mass


@lazy_kernel
def add_node_inertia(bodies: Bodies, i: int, work: Workspace) -> None:
    """Add the inertia that node i carries to the inertia of its parent's shapes and to their coupling."""
    pose, inertia = work.pose, work.inertia[i]
    if inertia.tt == 0.0 and inertia.xx == 0.0 and inertia.yy == 0.0:
        return
    p = bodies.records[i].mount.body
    coupling, own = work.shape.coupling[p], work.shape.inertia[p]
    rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
    for k in range(bodies.records[p].shapes):
        turn, x, y = node_motion(pose, i, k)
        moment = inertia.tt * turn + inertia.tx * x + inertia.ty * y
        fx = inertia.tx * turn + inertia.xx * x + inertia.xy * y
        fy = inertia.ty * turn + inertia.xy * x + inertia.yy * y
        coupling[k].I_t += moment + rx * fy - ry * fx
        coupling[k].I_x += fx
        coupling[k].I_y += fy
        for m in range(k + 1):
            turn, x, y = node_motion(pose, i, m)
            own[k, m] += turn * moment + x * fx + y * fy


@lazy_kernel
def eliminate_shapes(bodies: Bodies, i: int, work: Workspace) -> None:
    """Eliminate the shapes of body i from its articulated inertia.

    Factorises I_ee = L D L^T in place, with L below the diagonal and 1/D on it, and sets W = I_ee^-1 I_er.
    """
    nf, inertia, coupling, own = (
        bodies.records[i].shapes,
        work.inertia[i],
        work.shape.coupling[i],
        work.shape.inertia[i],
    )
    tt, tx, ty, xx, xy, yy = inertia.tt, inertia.tx, inertia.ty, inertia.xx, inertia.xy, inertia.yy
    for k in range(nf):
        mode = coupling[k]
        mode.W_t, mode.W_x, mode.W_y = mode.I_t, mode.I_x, mode.I_y
    for k in range(nf):
        mode = coupling[k]
        t, x, y = mode.W_t, mode.W_x, mode.W_y
        inverse = 1.0 / own[k, k]
        for j in range(nf - 1, k, -1):
            factor = own[j, k] * inverse
            for m in range(k + 1, j + 1):
                own[j, m] -= factor * own[m, k]
            own[j, k] = factor
            coupling[j].W_t -= factor * t
            coupling[j].W_x -= factor * x
            coupling[j].W_y -= factor * y
        own[k, k] = inverse
        wt, wx, wy = t * inverse, x * inverse, y * inverse
        mode.W_t, mode.W_x, mode.W_y = wt, wx, wy
        tt, tx, ty = tt - t * wt, tx - t * wx, ty - t * wy
        xx, xy, yy = xx - x * wx, xy - x * wy, yy - y * wy
    inertia.tt, inertia.tx, inertia.ty, inertia.xx, inertia.xy, inertia.yy = tt, tx, ty, xx, xy, yy
    for k in range(nf - 2, -1, -1):
        mode = coupling[k]
        for m in range(k + 1, nf):
            mode.W_t -= own[m, k] * coupling[m].W_t
            mode.W_x -= own[m, k] * coupling[m].W_x
            mode.W_y -= own[m, k] * coupling[m].W_y


@lazy_kernel
def shape_backward_pass(bodies: Bodies, i: int, work: Workspace, bias: Array, shape_bias: Array, tau: Array) -> None:
    """Set z of deformable body i from the forces on its shapes, and add their reaction I_re z to its frame's bias."""
    body, coupling, own, push = bodies.records[i], work.shape.coupling[i], work.shape.inertia[i], work.shape.push
    first, loaded = body.eta, False
    for k in range(body.shapes):
        force = tau[first + k] - shape_bias[first + k]
        for m in range(k):
            force -= own[k, m] * push[first + m]
        push[first + k] = force
        loaded = loaded or force != 0.0
    if not loaded:
        return
    moment, fx, fy = bias[i, 0], bias[i, 1], bias[i, 2]
    for k in range(body.shapes - 1, -1, -1):
        z = push[first + k] * own[k, k]
        for m in range(k + 1, body.shapes):
            z -= own[m, k] * push[first + m]
        push[first + k] = z
        moment += coupling[k].I_t * z
        fx += coupling[k].I_x * z
        fy += coupling[k].I_y * z
    bias[i, 0], bias[i, 1], bias[i, 2] = moment, fx, fy


@lazy_kernel
def shape_forward_pass(bodies: Bodies, i: int, work: Workspace, a: Array) -> None:
    """Set the responses of deformable body i's shapes from its frame's, and add them to the accelerations ``a``."""
    body, coupling, push, response = bodies.records[i], work.shape.coupling[i], work.shape.push, work.response
    turn, x, y = response[i, 0], response[i, 1], response[i, 2]
    for k in range(body.shapes):
        mode, place = coupling[k], body.eta + k
        second = push[place] - mode.W_t * turn - mode.W_x * x - mode.W_y * y
        a[place] += second
        work.shape_response[place] = second


@lazy_kernel
def deformable_inertial_force(
    bodies: Bodies, i: int, work: Workspace, gravity: Array, bias: Array, shape_bias: Array
) -> None:
    """Set the bias forces of deformable body i: rate of momentum less weight; on shapes also elastic forces."""
    body, shapes = bodies.records[i], bodies.shapes[i]
    pose, v = work.pose, work.v
    places, (ux, uy) = points(pose, i), turned(pose, i, body.ex, body.ey)
    force = point_accelerations(bodies, i, work, gravity, shape_bias) * body.mass
    fx, fy, alpha, w = lane(force, 0), lane(force, 1), work.acc[i, 0], work.vel[i, 0]
    moment = _sum(_quarter_turn(places) * force)
    for k in range(body.shapes):
        place, elastic, (m_eta, t_eta) = body.eta + k, shapes[ELASTIC, k], remainder(pose, i, k)
        eta, rate = work.q[place], v[place]
        moment += (alpha * eta + 2.0 * w * rate) * m_eta + t_eta * work.a[place]
        own = _sum(point_motion(pose, i, k) * force) + (shape_bias[place] + (alpha * t_eta - w * w * m_eta))
        shape_bias[place] = own + (lane(elastic, STIFFNESS) * eta + lane(elastic, DAMPING) * rate)
    bias[i, 0], bias[i, 1], bias[i, 2] = moment, fx * ux - fy * uy, fx * uy + fy * ux


@inlined_kernel
def point_accelerations(bodies: Bodies, i: int, work: Workspace, gravity: Array, shape_bias: Array) -> Any:
    """Accelerations of the two points of deformable body i less gravity, along and across the beam, in lanes.

    Sets the entries of ``shape_bias`` to the inertial forces of the remainders of the shapes.
    """
    body, shapes, pose = bodies.records[i], bodies.shapes[i], work.pose
    places, (ux, uy) = points(pose, i), turned(pose, i, body.ex, body.ey)
    x, y, alpha, w = work.acc[i, 1] - gravity[0], work.acc[i, 2] - gravity[1], work.acc[i, 0], work.vel[i, 0]
    own_v, own_a = shape_entries(bodies, i, work.v), shape_entries(bodies, i, work.a)
    rates, seconds, curvature = 0.0, 0.0, 0.0
    for k in range(body.shapes):
        motion, rate, second = point_motion(pose, i, k), own_v[k], own_a[k]
        of_rates, m_second = 0.0, 0.0
        for m in range(body.shapes):
            entry = shapes[MATRIX + k, m]
            of_rates += entry * own_v[m]
            m_second += lane(entry, 1) * own_a[m]
        rates += motion * rate
        seconds += motion * second
        curvature += of_rates * rate
        shape_bias[body.eta + k] = m_second + 2.0 * w * lane(of_rates, 3)
    frame = lanes(x * ux + y * uy, y * ux - x * uy, 0.0, 0.0) - places * (w * w)
    return frame + _quarter_turn(places * alpha + rates * (2.0 * w)) + (seconds + curvature * lanes(1.0, 0.0, 1.0, 0.0))


@lazy_kernel
def deformable_energy(bodies: Bodies, i: int, work: Workspace, gravity: Array) -> tuple[float, float, float, float]:
    """Kinetic, potential and strain energy of deformable body i [J], and the power that its damping dissipates [W]."""
    body, shapes, pose, vel = bodies.records[i], bodies.shapes[i], work.pose, work.vel
    places, (ux, uy) = points(pose, i), turned(pose, i, body.ex, body.ey)
    x, y, w, vx, vy = lane(places, 0), lane(places, 1), vel[i, 0], vel[i, 1], vel[i, 2]
    frame = lanes(vx * ux + vy * uy, vy * ux - vx * uy, 0.0, 0.0)
    rates = frame + point_rates(bodies, i, pose, work.v) + _quarter_turn(places) * w
    kinetic, strain, dissipated = 0.5 * body.mass * _sum(rates * rates), 0.0, 0.0
    px, py = pose[i, 0] + x * ux - y * uy, pose[i, 1] + x * uy + y * ux
    potential = -body.mass * (gravity[0] * px + gravity[1] * py)
    own = shape_entries(bodies, i, work.v)
    for k in range(body.shapes):
        eta, rate, (m_eta, t_eta) = work.q[body.eta + k], own[k], remainder(pose, i, k)
        kinetic += (0.5 * w * eta * m_eta + rate * t_eta) * w
        kinetic += 0.5 * rate * lane(matrix_product(shapes, k, own), 1)
        strain += 0.5 * lane(shapes[ELASTIC, k], STIFFNESS) * eta * eta
        dissipated += lane(shapes[ELASTIC, k], DAMPING) * rate * rate
    return kinetic, potential, strain, dissipated
