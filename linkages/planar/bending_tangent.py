"""Directional derivatives of what modal coordinates add; see `linkages.planar.tangent`.

Changes of modal coordinates and rates are in the lines of ``dpose`` and ``dvel`` (nb, 3 + nm) behind that of the frame.
What does not depend on the direction is found once, by `prepare`. Directions change few coordinates: sums over modes
pass by those that stay.
"""

from __future__ import annotations

from linkages.kernel import Array, inlined_kernel, lazy_kernel
from linkages.kernel.simd import lane, put_lanes
from linkages.planar.bending import modal_motion, product, two_accelerations, two_points, two_rates
from linkages.planar.bodies import DAMPING, ELASTIC, MATRIX, MOTION, POSE, REST, STIFFNESS, Bodies
from linkages.planar.markers import acceleration_tangent, turned, velocity_tangent
from linkages.planar.record_types import SECTION
from linkages.planar.tangent_workspace import ONCE, Scratch
from linkages.planar.workspace import Workspace


@lazy_kernel
def prepare(bodies: Bodies, gravity: Array, work: Workspace, s: Scratch) -> None:
    """Fill ``bent``; uses up `work`'s load."""
    pose, vel, acc, bent = work.pose, work.vel, work.acc, s.bent
    shapes, nm = bodies.shapes, bodies.shapes.shape[2]
    for i in range(len(bodies.records)):
        body = bodies.records[i]
        if body.modes > 0:
            put_lanes(bent, i, 0, two_accelerations(bodies, i, pose, vel, acc, gravity, work.load))
            put_lanes(bent, i, 4, two_rates(bodies, i, pose, vel))
            for k in range(body.modes):
                of_rates, of_seconds = product(bodies, i, k, vel, 3), product(bodies, i, k, acc, 3)
                line = bent[i, ONCE + k :]
                line[0], line[nm], line[2 * nm] = -lane(of_rates, 0), -lane(of_rates, 2), lane(of_rates, 3)
                line[3 * nm], line[4 * nm] = -lane(of_seconds, 0), -lane(of_seconds, 2)
                line[5 * nm], line[6 * nm] = lane(of_seconds, 3), lane(of_rates, 1)
        elif body.type == SECTION:
            p = body.mount.body
            _, bent[i, 0], bent[i, 1] = modal_motion(bodies, i, pose, vel)
            _, bent[i, 2], bent[i, 3] = modal_motion(bodies, i, pose, acc)
            bent[i, 4] = 0.0
            for k in range(bodies.records[p].modes):
                bent[i, ONCE + k], bent[i, ONCE + nm + k] = 0.0, 0.0
                for m in range(bodies.records[p].modes):
                    h = -lane(shapes[i, MATRIX + k, m], 0)
                    bent[i, ONCE + k] += h * vel[p, 3 + m]
                    bent[i, ONCE + nm + k] += h * acc[p, 3 + m]
                bent[i, 4] += bent[i, ONCE + k] * vel[p, 3 + k]


@inlined_kernel
def _along(bodies: Bodies, i: int, bent: Array, first: int, change: Array) -> float:
    """Product of a section's line of ``bent``, from an entry on, and the change of its beam's coordinates or rates."""
    p, total = bodies.records[i].mount.body, 0.0
    for k in range(bodies.records[p].modes):
        total += bent[i, first + k] * change[p, 3 + k]
    return total


@lazy_kernel
def section_tangent(bodies: Bodies, i: int, work: Workspace, s: Scratch) -> None:
    """Fill section i's changes of pose, velocity and acceleration."""
    pose, vel, acc, bent, dpose, dvel, dacc = work.pose, work.vel, work.acc, s.bent, s.dpose, s.dvel, s.dacc
    body, nm = bodies.records[i], bodies.shapes.shape[2]
    p = body.mount.body
    w, turn, dw = vel[p, 0], dpose[p, 0], dvel[p, 0]
    rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
    ux, uy = turned(pose, p, body.ux, body.uy)
    slope, mx, my = modal_motion(bodies, i, pose, dpose)
    gx, gy, jx, jy, form = bent[i, 0], bent[i, 1], bent[i, 2], bent[i, 3], bent[i, 4]
    less, least = _along(bodies, i, bent, ONCE, dpose), _along(bodies, i, bent, ONCE + nm, dpose)
    drx, dry = mx - turn * ry, my + turn * rx
    # change of the velocity and of the acceleration that the modes give
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
def beam_load_tangent(bodies: Bodies, i: int, gravity: Array, work: Workspace, s: Scratch) -> None:
    """Fill a bending body's line of ``dload`` with the change of `linkages.planar.bending.beam_load`."""
    body, shapes, nm = bodies.records[i], bodies.shapes[i], bodies.shapes.shape[2]
    pose, vel, acc, bent = work.pose, work.vel, work.acc, s.bent
    dpose, dvel, dacc, dload = s.dpose, s.dvel, s.dacc, s.dload
    points, (ux, uy) = two_points(bodies, i, pose), turned(pose, i, body.ex, body.ey)
    x0, y0, x1, y1 = lane(points, 0), lane(points, 1), lane(points, 2), lane(points, 3)
    ax0, ay0, ax1, ay1 = bent[i, 0], bent[i, 1], bent[i, 2], bent[i, 3]
    gx0, gy0, gx1, gy1 = bent[i, 4], bent[i, 5], bent[i, 6], bent[i, 7]
    x, y, dx, dy, turn = acc[i, 1] - gravity[0], acc[i, 2] - gravity[1], dacc[i, 1], dacc[i, 2], dpose[i, 0]
    mass, al, w, dal, dw = body.mass, acc[i, 0], vel[i, 0], dacc[i, 0], dvel[i, 0]
    # changes of the points' places, of their velocities and accelerations in the frame, of the moment of the rest
    dx0, dy0, dx1, dy1, dgx0, dgy0, dgx1, dgy1 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    djx0, djx1, dmoment = 0.0, 0.0, 0.0
    rest, moved = POSE + REST * nm, pose[i, POSE + MOTION * nm :]
    for m in range(body.modes):
        eta, deta, out = pose[i, POSE + m], dpose[i, 3 + m], pose[i, rest + m]
        rate, drate = vel[i, 3 + m], dvel[i, 3 + m]
        dmoment += dal * (eta * out) + dw * (2.0 * rate * out)
        if s.changed[body.eta + m] == 0.0:
            continue
        psi0, b0, psi1, b1 = moved[4 * m], moved[4 * m + 1], moved[4 * m + 2], moved[4 * m + 3]
        line = bent[i, ONCE + m :]
        dx0, dy0, dx1, dy1 = dx0 + psi0 * deta, dy0 + b0 * deta, dx1 + psi1 * deta, dy1 + b1 * deta
        dgx0, dgy0 = dgx0 + psi0 * drate - line[0] * deta, dgy0 + b0 * drate
        dgx1, dgy1 = dgx1 + psi1 * drate - line[nm] * deta, dgy1 + b1 * drate
        djx0 -= line[3 * nm] * deta + 2.0 * line[0] * drate
        djx1 -= line[4 * nm] * deta + 2.0 * line[nm] * drate
        dmoment += (2.0 * al * out - line[5 * nm] + 2.0 * w * line[6 * nm]) * deta + 2.0 * w * out * drate
    dax0 = dx * ux + dy * uy + turn * (y * ux - x * uy) - dal * y0 - al * dy0 + djx0
    dax0 -= 2.0 * dw * (w * x0 + gy0) + w * (w * dx0 + 2.0 * dgy0)
    day0 = dy * ux - dx * uy - turn * (x * ux + y * uy) + dal * x0 + al * dx0
    day0 -= 2.0 * dw * (w * y0 - gx0) + w * (w * dy0 - 2.0 * dgx0)
    dax1 = -dal * y1 - al * dy1 + djx1 - 2.0 * dw * (w * x1 + gy1) - w * (w * dx1 + 2.0 * dgy1)
    day1 = dal * x1 + al * dx1 - 2.0 * dw * (w * y1 - gx1) - w * (w * dy1 - 2.0 * dgx1)
    moment = dx0 * ay0 + x0 * day0 - dy0 * ax0 - y0 * dax0 + dx1 * ay1 + x1 * day1 - dy1 * ax1 - y1 * dax1
    dload[i, 0] = dmoment + mass * moment
    dload[i, 1] = mass * (dax0 * ux - day0 * uy - turn * (ax0 * uy + ay0 * ux))
    dload[i, 2] = mass * (dax0 * uy + day0 * ux + turn * (ax0 * ux - ay0 * uy))
    for k in range(body.modes):
        psi0, b0, psi1, b1 = moved[4 * k], moved[4 * k + 1], moved[4 * k + 2], moved[4 * k + 3]
        own = mass * (psi0 * dax0 + b0 * day0 + psi1 * dax1 + b1 * day1)
        own += dal * pose[i, rest + nm + k] + 2.0 * dw * (bent[i, ONCE + 2 * nm + k] - w * pose[i, rest + k])
        stiffness, damping = lane(shapes[ELASTIC, k], STIFFNESS), lane(shapes[ELASTIC, k], DAMPING)
        dload[i, 3 + k] = own + stiffness * dpose[i, 3 + k] + damping * dvel[i, 3 + k]
    for m in range(body.modes):
        deta, drate = dpose[i, 3 + m], dvel[i, 3 + m]
        if s.changed[body.eta + m] == 0.0:
            continue
        pull0, pull1, twist = mass * ax0 * deta, mass * ax1 * deta, al * deta + 2.0 * w * drate
        for k in range(body.modes):
            entry = shapes[MATRIX + k, m]
            own = lane(entry, 3) * twist - w * w * lane(entry, 1) * deta
            dload[i, 3 + k] += own + (lane(entry, 0) * pull0 + lane(entry, 2) * pull1)


@lazy_kernel
def add_turned_modes(bodies: Bodies, i: int, work: Workspace, s: Scratch) -> None:
    """Add to a beam's line of ``dload`` what the force on section i does as the modes' directions change."""
    body, nm, pose, dpose, dload = bodies.records[i], bodies.shapes.shape[2], work.pose, s.dpose, s.dload
    p = body.mount.body
    nf, turn, (ux, uy) = bodies.records[p].modes, dpose[p, 0], turned(pose, p, body.ux, body.uy)
    fx, fy = s.force[i, 1], s.force[i, 2]
    along = ux * fx + uy * fy
    for k in range(nf):
        across = pose[i, POSE + nm + k] * fy - pose[i, POSE + 2 * nm + k] * fx
        dload[p, 3 + k] += turn * across
    for m in range(nf):
        if s.changed[bodies.records[p].eta + m] > 0.0:
            for k in range(nf):
                dload[p, 3 + k] += lane(bodies.shapes[i, MATRIX + k, m], 0) * dpose[p, 3 + m] * along
