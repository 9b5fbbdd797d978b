"""Directional derivatives of flexible bodies' kinematics and forces; see `linkages.planar.tangent`.

Quantities that do not depend on the direction are found once, by `prepare_flexible`. A direction changes few
coordinates: sums over modes skip those that stay.
"""

from __future__ import annotations

from linkages.kernel import Array, lazy_kernel
from linkages.kernel.simd import lane
from linkages.planar.bodies import (
    DAMPING,
    ELASTIC,
    MATRIX,
    STIFFNESS,
    Bodies,
    point_motion,
    points,
    remainder,
    section_motion,
)
from linkages.planar.flexible_dynamics import point_accelerations
from linkages.planar.flexible_kinematics import matrix_product, modal_motion, point_rates
from linkages.planar.markers import acceleration_tangent, offset, turned, velocity_tangent
from linkages.planar.record_types import SECTION
from linkages.planar.tangent_workspace import Scratch
from linkages.planar.workspace import Workspace


@lazy_kernel
def prepare_flexible(bodies: Bodies, gravity: Array, work: Workspace, s: Scratch) -> None:
    """Set the sections, products, point_acc and point_vel of the scratch; uses up `work`'s modal_bias."""
    pose, v, a, shapes = work.pose, work.v, work.a, bodies.shapes
    for i in range(len(bodies.records)):
        body = bodies.records[i]
        if body.modes > 0:
            s.point_acc[i] = point_accelerations(bodies, i, work, gravity, work.modal_bias)
            s.point_vel[i] = point_rates(bodies, i, pose, v)
            for k in range(body.modes):
                product, rates, seconds = (
                    s.products[i, k],
                    matrix_product(bodies, i, k, v),
                    matrix_product(bodies, i, k, a),
                )
                product.h0_rates, product.m_rates = -lane(rates, 0), lane(rates, 1)
                product.h1_rates, product.t_rates = -lane(rates, 2), lane(rates, 3)
                product.h0_seconds, product.h1_seconds = -lane(seconds, 0), -lane(seconds, 2)
                product.t_seconds = lane(seconds, 3)
        elif body.type == SECTION:
            beam, section = bodies.records[body.mount.body], s.sections[i]
            _, section.vx, section.vy = modal_motion(bodies, i, pose, v)
            _, section.ax, section.ay = modal_motion(bodies, i, pose, a)
            shortening = 0.0
            for k in range(beam.modes):
                h_rates, h_seconds = 0.0, 0.0
                for m in range(beam.modes):
                    h = -lane(shapes[i, MATRIX + k, m], 0)
                    h_rates += h * v[beam.eta + m]
                    h_seconds += h * a[beam.eta + m]
                s.products[i, k].h0_rates, s.products[i, k].h0_seconds = h_rates, h_seconds
                shortening += h_rates * v[beam.eta + k]
            section.shortening = shortening


@lazy_kernel
def section_tangent(bodies: Bodies, i: int, work: Workspace, s: Scratch) -> None:
    """Set the changes of section i's pose, velocity and acceleration with the coordinates."""
    pose, vel, acc, dpose, dvel, dacc, rates = work.pose, work.vel, work.acc, s.dpose, s.dvel, s.dacc, s.sections[i]
    body, p = bodies.records[i], bodies.records[i].mount.body
    beam = bodies.records[p]
    w, turn, dw = vel[p, 0], dpose[p, 0], dvel[p, 0]
    rx, ry = offset(pose, p, i)
    ux, uy = turned(pose, p, body.ux, body.uy)
    slope, mx, my = modal_motion(bodies, i, pose, s.dq)
    gx, gy, jx, jy, form = rates.vx, rates.vy, rates.ax, rates.ay, rates.shortening
    less, least = 0.0, 0.0
    for k in range(beam.modes):
        less += s.products[i, k].h0_rates * s.dq[beam.eta + k]
        least += s.products[i, k].h0_seconds * s.dq[beam.eta + k]
    drx, dry = mx - turn * ry, my + turn * rx
    # changes of the velocity and of the acceleration relative to the frame
    dgx, dgy = -turn * gy - ux * less, turn * gx - uy * less
    djx, djy = -turn * jy - ux * least, turn * jx - uy * least
    dvx, dvy = velocity_tangent(vel, dvel, p, rx, ry, drx, dry)
    dax, day = acceleration_tangent(vel, acc, dvel, dacc, p, rx, ry, drx, dry)
    dpose[i, 0], dpose[i, 1], dpose[i, 2] = turn + slope, dpose[p, 1] + drx, dpose[p, 2] + dry
    dvel[i, 0], dvel[i, 1], dvel[i, 2] = dw, dvx + dgx, dvy + dgy
    dacc[i, 0] = dacc[p, 0]
    dacc[i, 1] = dax + djx - 2.0 * (dw * gy + w * dgy) + turn * uy * form
    dacc[i, 2] = day + djy + 2.0 * (dw * gx + w * dgx) - turn * ux * form


@lazy_kernel
def flexible_force_tangent(bodies: Bodies, i: int, gravity: Array, work: Workspace, s: Scratch) -> None:
    """Set the changes of flexible body i's bias forces, see `linkages.planar.flexible_dynamics`."""
    body, shapes, first = bodies.records[i], bodies.shapes[i], bodies.records[i].eta
    pose, vel, acc, dpose, dvel, dacc, products = work.pose, work.vel, work.acc, s.dpose, s.dvel, s.dacc, s.products[i]
    places, (ux, uy) = points(pose, i), turned(pose, i, body.ex, body.ey)
    x0, y0, x1, y1 = lane(places, 0), lane(places, 1), lane(places, 2), lane(places, 3)
    a, g = s.point_acc[i], s.point_vel[i]
    ax0, ay0, ax1, ay1 = lane(a, 0), lane(a, 1), lane(a, 2), lane(a, 3)
    gx0, gy0, gx1, gy1 = lane(g, 0), lane(g, 1), lane(g, 2), lane(g, 3)
    x, y, dx, dy, turn = acc[i, 1] - gravity[0], acc[i, 2] - gravity[1], dacc[i, 1], dacc[i, 2], dpose[i, 0]
    mass, al, w, dal, dw = body.mass, acc[i, 0], vel[i, 0], dacc[i, 0], dvel[i, 0]
    # changes of the points' places, velocities and accelerations in the frame, and of the moment of the remainders
    dx0, dy0, dx1, dy1, dgx0, dgy0, dgx1, dgy1 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    djx0, djx1, dmoment = 0.0, 0.0, 0.0
    for m in range(body.modes):
        eta, rate, deta, drate = work.q[first + m], work.v[first + m], s.deta[first + m], s.drate[first + m]
        m_eta, _ = remainder(pose, i, m)
        dmoment += dal * (eta * m_eta) + dw * (2.0 * rate * m_eta)
        if s.changed[first + m] == 0.0:
            continue
        motion, product = point_motion(pose, i, m), products[m]
        psi0, b0, psi1, b1 = lane(motion, 0), lane(motion, 1), lane(motion, 2), lane(motion, 3)
        dx0, dy0, dx1, dy1 = dx0 + psi0 * deta, dy0 + b0 * deta, dx1 + psi1 * deta, dy1 + b1 * deta
        dgx0, dgy0 = dgx0 + psi0 * drate - product.h0_rates * deta, dgy0 + b0 * drate
        dgx1, dgy1 = dgx1 + psi1 * drate - product.h1_rates * deta, dgy1 + b1 * drate
        djx0 -= product.h0_seconds * deta + 2.0 * product.h0_rates * drate
        djx1 -= product.h1_seconds * deta + 2.0 * product.h1_rates * drate
        dmoment += (2.0 * al * m_eta - product.t_seconds + 2.0 * w * product.m_rates) * deta + 2.0 * w * m_eta * drate
    dax0 = dx * ux + dy * uy + turn * (y * ux - x * uy) - dal * y0 - al * dy0 + djx0
    dax0 -= 2.0 * dw * (w * x0 + gy0) + w * (w * dx0 + 2.0 * dgy0)
    day0 = dy * ux - dx * uy - turn * (x * ux + y * uy) + dal * x0 + al * dx0
    day0 -= 2.0 * dw * (w * y0 - gx0) + w * (w * dy0 - 2.0 * dgx0)
    dax1 = -dal * y1 - al * dy1 + djx1 - 2.0 * dw * (w * x1 + gy1) - w * (w * dx1 + 2.0 * dgy1)
    day1 = dal * x1 + al * dx1 - 2.0 * dw * (w * y1 - gx1) - w * (w * dy1 - 2.0 * dgx1)
    moment = dx0 * ay0 + x0 * day0 - dy0 * ax0 - y0 * dax0 + dx1 * ay1 + x1 * day1 - dy1 * ax1 - y1 * dax1
    s.dbias[i, 0] = dmoment + mass * moment
    s.dbias[i, 1] = mass * (dax0 * ux - day0 * uy - turn * (ax0 * uy + ay0 * ux))
    s.dbias[i, 2] = mass * (dax0 * uy + day0 * ux + turn * (ax0 * ux - ay0 * uy))
    for k in range(body.modes):
        motion, (m_eta, t_eta) = point_motion(pose, i, k), remainder(pose, i, k)
        psi0, b0, psi1, b1 = lane(motion, 0), lane(motion, 1), lane(motion, 2), lane(motion, 3)
        own = mass * (psi0 * dax0 + b0 * day0 + psi1 * dax1 + b1 * day1)
        own += dal * t_eta + 2.0 * dw * (products[k].t_rates - w * m_eta)
        stiffness, damping = lane(shapes[ELASTIC, k], STIFFNESS), lane(shapes[ELASTIC, k], DAMPING)
        s.dtau[first + k] = own + stiffness * s.deta[first + k] + damping * s.drate[first + k]
    for m in range(body.modes):
        deta, drate = s.deta[first + m], s.drate[first + m]
        if s.changed[first + m] == 0.0:
            continue
        pull0, pull1, twist = mass * ax0 * deta, mass * ax1 * deta, al * deta + 2.0 * w * drate
        for k in range(body.modes):
            entry = shapes[MATRIX + k, m]
            own = lane(entry, 3) * twist - w * w * lane(entry, 1) * deta
            s.dtau[first + k] += own + (lane(entry, 0) * pull0 + lane(entry, 2) * pull1)


@lazy_kernel
def add_modal_force_tangent(bodies: Bodies, i: int, work: Workspace, s: Scratch) -> None:
    """Add the changes of the forces of section i's wrench on its beam's modes as the directions of modes change."""
    body, p, pose = bodies.records[i], bodies.records[i].mount.body, work.pose
    beam, turn, (ux, uy) = bodies.records[p], s.dpose[p, 0], turned(pose, p, body.ux, body.uy)
    fx, fy = s.force[i, 1], s.force[i, 2]
    along = ux * fx + uy * fy
    for k in range(beam.modes):
        _, x, y = section_motion(pose, i, k)
        s.dtau[beam.eta + k] += turn * (x * fy - y * fx)
    for m in range(beam.modes):
        if s.changed[beam.eta + m] > 0.0:
            for k in range(beam.modes):
                s.dtau[beam.eta + k] += lane(bodies.shapes[i, MATRIX + k, m], 0) * s.deta[beam.eta + m] * along
