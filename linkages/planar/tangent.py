"""Exact directional derivatives of the tree's kinematics and of the force residual.

A direction changes the coordinates by dq, the rates by dq, or the bristles alone. If it changes the coordinates, the
change of the poses is a velocity field with the rates dq: (turn, dx, dy) of each body, and a vector fixed to a body
changes by turn x vector. If it changes the rates, the velocities change by this field. Accelerations of the coordinates
are constant. A direction along a value changes numbers of rigid bodies, contacts and gravity, and the prescribed
motions. Several directions are treated at once, in lanes (`linkages.kernel.simd`).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.kernel import Array, Records, inlined_kernel, kernel, lazy_kernel
from linkages.kernel.simd import LaneArray as Lanes
from linkages.planar.bodies import Bodies
from linkages.planar.closure_rows import term_direction
from linkages.planar.flexible_tangent import add_modal_force_tangent, flexible_force_tangent, section_tangent
from linkages.planar.kinematics import propagate_force
from linkages.planar.markers import (
    acceleration_tangent,
    add_pair_tangent,
    both_at_b,
    gap,
    gap_acceleration,
    gap_rate,
    gap_rate_tangent,
    gap_tangent,
    offset,
    turned,
    velocity_tangent,
)
from linkages.planar.record_types import ALONG_BODY, ANGLE, PRISMATIC, REVOLUTE, SECTION
from linkages.planar.tangent_workspace import Scratch
from linkages.planar.traversal import backward, forward
from linkages.planar.workspace import Workspace


@kernel
def body_tangents(bodies: Bodies, work: Workspace, s: Scratch) -> None:
    """Set the changes of poses, velocities and accelerations with the coordinates; zero for bodies that stay."""
    _kinematics(bodies, work, s)


@kernel
def value_tangents(bodies: Bodies, work: Workspace, s: Scratch) -> None:
    """Set the changes of poses, velocities and accelerations of rigid bodies with numbers and prescribed motions."""
    _all_kinematics(bodies, work, s)


@inlined_kernel
def _body_tangent(bodies: Bodies, i: int, work: Workspace, s: Scratch) -> None:
    """Set the changes of body i from its parent's."""
    pose, vel, acc, v, a = work.pose, work.vel, work.acc, work.v, work.a
    dq, changed, dpose, dvel, dacc = s.dq, s.changed, s.dpose, s.dvel, s.dacc
    body = bodies.records[i]
    p = body.mount.body
    moves = s.moves[0] > 0.0
    touched = moves or s.touched[p] > 0.0 or (body.dof >= 0 and changed[body.dof] > 0.0)
    for k in range(body.eta, body.eta + body.modes):
        s.deta[k], s.drate[k] = dq[k], 0.0
        touched = touched or changed[k] > 0.0
    s.touched[i] = 1.0 if touched else 0.0
    if not touched:
        for k in range(3):
            dpose[i, k], dvel[i, k], dacc[i, k] = 0.0, 0.0, 0.0
        return
    if body.type == SECTION:
        section_tangent(bodies, i, work, s)
        return
    w, turn, dw = vel[p, 0], dpose[p, 0], dvel[p, 0]
    rx, ry = offset(pose, p, i)
    drx, dry = -turn * ry, turn * rx
    if moves:
        mx, my = turned(pose, p, s.dbody[i, 0], s.dbody[i, 1])
        drx, dry = drx + mx, dry + my
    if body.type == PRISMATIC:
        ux, uy = turned(pose, p, body.ux, body.uy)
        drx, dry = drx + ux * dq[body.dof], dry + uy * dq[body.dof]
    dvx, dvy = velocity_tangent(vel, dvel, p, rx, ry, drx, dry)
    dax, day = acceleration_tangent(vel, acc, dvel, dacc, p, rx, ry, drx, dry)
    if body.type == PRISMATIC:
        ux, uy = turned(pose, p, body.ux, body.uy)
        rate, second = v[body.dof], a[body.dof]
        dux, duy = -turn * uy, turn * ux
        twist, dtwist = 2.0 * w * rate, 2.0 * rate * dw
        dvx, dvy = dvx + dux * rate, dvy + duy * rate
        dax, day = dax + (dux * second - dtwist * uy - twist * duy), day + (duy * second + dtwist * ux + twist * dux)
    dalpha = dacc[p, 0]
    if moves and body.dof >= 0:
        faster, sooner = s.ddrive[body.dof, 0], s.ddrive[body.dof, 1]
        if body.type == REVOLUTE:
            dw, dalpha = dw + body.sign * faster, dalpha + body.sign * sooner
        else:
            ux, uy = turned(pose, p, body.ux, body.uy)
            dvx, dvy = dvx + ux * faster, dvy + uy * faster
            dax, day = dax + ux * sooner - 2.0 * w * uy * faster, day + uy * sooner + 2.0 * w * ux * faster
    if body.type == REVOLUTE:
        turn = turn + body.sign * dq[body.dof]
    dpose[i, 0], dpose[i, 1], dpose[i, 2] = turn, dpose[p, 1] + drx, dpose[p, 2] + dry
    dvel[i, 0], dvel[i, 1], dvel[i, 2] = dw, dvx, dvy
    dacc[i, 0], dacc[i, 1], dacc[i, 2] = dalpha, dax, day


_kinematics, _all_kinematics = forward(_body_tangent), forward(_body_tangent, moving=False)


@kernel
def rate_tangents(bodies: Bodies, s: Scratch) -> None:
    """Turn the changes of `body_tangents` into the changes with the rates.

    Velocities change with rates as positions do with coordinates, accelerations twice as much as velocities do: rates
    change x' = J q' and x'' = J q'' + q'.H q' by J dq and 2 q'.H dq, coordinates x by J dq and x' by q'.H dq.
    """
    for i in range(len(s.dpose)):
        if s.touched[i] > 0.0:
            for k in range(3):
                s.dacc[i, k] = 2.0 * s.dvel[i, k]
                s.dvel[i, k] = s.dpose[i, k]
                s.dpose[i, k] = 0.0
            for k in range(bodies.records[i].eta, bodies.records[i].eta + bodies.records[i].modes):
                s.deta[k], s.drate[k] = 0.0, s.dq[k]


@kernel
def inertial_tangents(bodies: Bodies, gravity: Array, work: Workspace, s: Scratch) -> None:
    """Set ``dbias``, and the modal entries of ``dtau``, to the changes of the rate of momentum less weight."""
    pose, vel, acc, dpose, dvel, dacc, dbias = work.pose, work.vel, work.acc, s.dpose, s.dvel, s.dacc, s.dbias
    for i in range(len(bodies.records)):
        body = bodies.records[i]
        if s.touched[i] == 0.0:
            for k in range(3):
                dbias[i, k] = 0.0
            for k in range(body.eta, body.eta + body.modes):
                s.dtau[k] = 0.0
            continue
        if body.modes > 0:
            flexible_force_tangent(bodies, i, gravity, work, s)
            continue
        cx, cy = turned(pose, i, body.cx, body.cy)
        m, w, alpha, turn = body.mass, vel[i, 0], acc[i, 0], dpose[i, 0]
        dw, dalpha = dvel[i, 0], dacc[i, 0]
        dcx, dcy = -turn * cy, turn * cx
        if s.moves[0] > 0.0:
            mx, my = turned(pose, i, s.dbody[i, 3], s.dbody[i, 4])
            dcx, dcy = dcx + mx, dcy + my
        ax, ay = acc[i, 1] - alpha * cy - w * w * cx - gravity[0], acc[i, 2] + alpha * cx - w * w * cy - gravity[1]
        fx, fy = m * ax, m * ay
        dfx = m * (dacc[i, 1] - dalpha * cy - alpha * dcy - 2.0 * w * dw * cx - w * w * dcx)
        dfy = m * (dacc[i, 2] + dalpha * cx + alpha * dcx - 2.0 * w * dw * cy - w * w * dcy)
        dbias[i, 0] = body.inertia * dalpha + dcx * fy - dcy * fx
        if s.moves[0] > 0.0:
            dfx, dfy = dfx + s.dbody[i, 2] * ax - m * s.dgravity[0], dfy + s.dbody[i, 2] * ay - m * s.dgravity[1]
            dbias[i, 0] += s.dbody[i, 5] * alpha
        dbias[i, 0] += cx * dfy - cy * dfx
        dbias[i, 1], dbias[i, 2] = dfx, dfy


@kernel
def residual_tangents(bodies: Bodies, work: Workspace, s: Scratch) -> None:
    """Set the free entries of ``dtau`` to the changes of the free joints' generalised forces; uses up ``dbias``."""
    _project(bodies, work, s)


@inlined_kernel
def _project_tangent(bodies: Bodies, i: int, work: Workspace, s: Scratch) -> None:
    """Set the change of the force along body i's joint, and pass the change of its wrench on to the parent."""
    body, pose, force, dpose, dbias = bodies.records[i], work.pose, s.force, s.dpose, s.dbias
    p = body.mount.body
    if body.dof >= 0 and body.driven < 0:
        if body.type == REVOLUTE:
            s.dtau[body.dof] = body.sign * dbias[i, 0]
        else:
            ux, uy = turned(pose, p, body.ux, body.uy)
            turn = dpose[p, 0]
            own = ux * dbias[i, 1] + uy * dbias[i, 2]
            s.dtau[body.dof] = own + turn * (ux * force[i, 2] - uy * force[i, 1])
    drx, dry = dpose[i, 1] - dpose[p, 1], dpose[i, 2] - dpose[p, 2]
    propagate_force(bodies, i, pose, dbias, s.dtau)
    dbias[p, 0] += drx * force[i, 2] - dry * force[i, 1]
    if body.type == SECTION:
        add_modal_force_tangent(bodies, i, work, s)


_project = backward(_project_tangent)


@lazy_kernel
def add_term_tangent(term: np.record, pose: Array, size: float, dpose: Array | Lanes, dwrench: Array | Lanes) -> None:
    """Add the change of a term's reaction wrench, of fixed size, to the bodies' wrenches."""
    if term.kind == ANGLE:
        return
    dx, dy, arms = gap(pose, term.a, term.b)
    ex, ey, moved = gap_tangent(dpose, term.a, term.b, arms)
    ux, uy = term_direction(term, pose)
    dux, duy = 0.0, 0.0
    if term.kind == ALONG_BODY:
        turn = dpose[term.a.body, 0]
        dux, duy = -turn * uy, turn * ux
        arms, moved = both_at_b(arms, dx, dy), both_at_b(moved, ex, ey)
    force, change = (size * ux, size * uy), (size * dux, size * duy)
    add_pair_tangent(dwrench, term.a, term.b, arms, moved, force, change)


@kernel
def term_rate_tangent(term: np.record, pose: Array, vel: Array, dpose: Array, dvel: Array) -> float:
    """Change of `term_rate`."""
    if term.kind == ANGLE:
        return dvel[term.b.body, 0] - dvel[term.a.body, 0]
    dx, dy, arms = gap(pose, term.a, term.b)
    ex, ey, moved = gap_tangent(dpose, term.a, term.b, arms)
    gx, gy = gap_rate_tangent(vel, dvel, term.a, term.b, arms, moved)
    ux, uy = term_direction(term, pose)
    change = gx * ux + gy * uy
    if term.kind == ALONG_BODY:
        vx, vy = gap_rate(vel, term.a, term.b, arms)
        w, turn, dw = vel[term.a.body, 0], dpose[term.a.body, 0], dvel[term.a.body, 0]
        change += turn * (vy * ux - vx * uy) + dw * (dy * ux - dx * uy)
        change += w * (ey * ux - ex * uy) - w * turn * (dx * ux + dy * uy)
    return change


@kernel
def _term_tangent(term: np.record, work: Workspace, dpose: Lanes, dvel: Lanes, dacc: Lanes) -> Any:
    """Change of `term_acceleration`."""
    if term.kind == ANGLE:
        return dacc[term.b.body, 0] - dacc[term.a.body, 0]
    pose, vel, acc = work.pose, work.vel, work.acc
    px, py, arms = gap(pose, term.a, term.b)
    dpx, dpy, moved = gap_tangent(dpose, term.a, term.b, arms)
    (rax, ray, rbx, rby), (drax, dray, drbx, drby) = arms, moved
    aax, aay = acceleration_tangent(vel, acc, dvel, dacc, term.a.body, rax, ray, drax, dray)
    abx, aby = acceleration_tangent(vel, acc, dvel, dacc, term.b.body, rbx, rby, drbx, drby)
    dax, day = abx - aax, aby - aay
    if term.kind != ALONG_BODY:
        return dax * term.ux + day * term.uy
    vx, vy = gap_rate(vel, term.a, term.b, arms)
    ax, ay = gap_acceleration(vel, acc, term.a, term.b, arms)
    dvx, dvy = gap_rate_tangent(vel, dvel, term.a, term.b, arms, moved)
    ux, uy = term_direction(term, pose)
    w, alpha = vel[term.a.body, 0], acc[term.a.body, 0]
    turn, dw, dalpha = dpose[term.a.body, 0], dvel[term.a.body, 0], dacc[term.a.body, 0]
    u1x, u1y = -w * uy, w * ux  # rate of u, second rate of u, and their changes
    u2x, u2y = -alpha * uy - w * w * ux, alpha * ux - w * w * uy
    dux, duy = -turn * uy, turn * ux
    du1x, du1y = -dw * uy - w * duy, dw * ux + w * dux
    du2x = -dalpha * uy - alpha * duy - 2.0 * w * dw * ux - w * w * dux
    du2y = dalpha * ux + alpha * dux - 2.0 * w * dw * uy - w * w * duy
    change = dax * ux + day * uy + ax * dux + ay * duy
    change += 2.0 * (dvx * u1x + dvy * u1y + vx * du1x + vy * du1y)
    return change + dpx * u2x + dpy * u2y + px * du2x + py * du2y


@kernel
def _add_row_tangent(row: np.record, pose: Array, size: float, dpose: Lanes, dwrench: Lanes) -> None:
    """Add the change of a row's reaction wrench, of fixed size, to the bodies' wrenches."""
    if row.ratio != 0.0:
        add_term_tangent(row.other, pose, -row.ratio * size, dpose, dwrench)
    add_term_tangent(row.term, pose, size, dpose, dwrench)


@lazy_kernel
def row_tangents(rows: Records, work: Workspace, s: Scratch) -> None:
    """Set ``drows`` to the changes of the rows' accelerations; add the changes of their reactions to ``dwrench``."""
    for k in range(len(rows)):
        row = rows[k]
        _add_row_tangent(row, work.pose, work.reaction[k], s.dpose, s.dwrench)
        s.drows[k] = _term_tangent(row.term, work, s.dpose, s.dvel, s.dacc)
        if row.ratio != 0.0:
            s.drows[k] -= row.ratio * _term_tangent(row.other, work, s.dpose, s.dvel, s.dacc)
