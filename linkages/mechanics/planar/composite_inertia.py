"""Mass matrix by the composite rigid body algorithm (Featherstone, 2008, ch. 6)."""

from __future__ import annotations

from linkages.base.kernel import Array, inlined_kernel, kernel
from linkages.mechanics.planar.bodies import Bodies, node_motion
from linkages.mechanics.planar.deformable_dynamics import add_node_inertia, deformable_inertia
from linkages.mechanics.planar.kinematics import joint_force
from linkages.mechanics.planar.markers import offset, turned
from linkages.mechanics.planar.record_types import NODE, REVOLUTE
from linkages.mechanics.planar.traversal import backward, forward
from linkages.mechanics.planar.workspace import Workspace

#: An inertia as a tuple, in the order of `linkages.mechanics.planar.workspace.INERTIA`.
Inertia = tuple[float, float, float, float, float, float]
Wrench = tuple[float, float, float]


@kernel
def mass_matrix(bodies: Bodies, work: Workspace, matrix: Array) -> None:
    """Set the entries of free coordinates in their mass matrix (n, n), at `work`'s pose; uses its inertias."""
    _inertias(bodies, work)
    _rows(bodies, work, matrix)


@inlined_kernel
def body_inertia(bodies: Bodies, i: int, work: Workspace) -> None:
    """Set the inertia of body i about the origin of its frame."""
    body, inertia = bodies.records[i], work.inertia[i]
    if body.shapes > 0:
        deformable_inertia(bodies, i, work)
        return
    cx, cy = turned(work.pose, i, body.cx, body.cy)
    m = body.mass
    inertia.tt = body.inertia + m * (cx * cx + cy * cy)
    inertia.tx, inertia.ty = -m * cy, m * cx
    inertia.xx, inertia.xy, inertia.yy = m, 0.0, m


@inlined_kernel
def propagate_inertia(bodies: Bodies, i: int, work: Workspace, given: Inertia) -> None:
    """Add an inertia about the origin of body i to its parent's, if the parent moves."""
    p = bodies.records[i].mount.body
    if not bodies.records[p].moving:
        return
    tt, tx, ty, xx, xy, yy = given
    inertia = work.inertia[p]
    rx, ry = offset(work.pose, p, i)
    moved_x, moved_y = tx - ry * xx + rx * xy, ty - ry * xy + rx * yy
    inertia.tt += tt - ry * tx + rx * ty - ry * moved_x + rx * moved_y
    inertia.tx += moved_x
    inertia.ty += moved_y
    inertia.xx += xx
    inertia.xy += xy
    inertia.yy += yy


@inlined_kernel
def _rows_of_body(bodies: Bodies, i: int, work: Workspace, matrix: Array) -> None:
    """Set the rows of body i's coordinates: the wrench that a unit acceleration of the coordinate needs, projected."""
    body, coupling, own = bodies.records[i], work.shape.coupling[i], work.shape.inertia[i]
    if body.type == NODE:
        add_node_inertia(bodies, i, work)
    inertia = work.inertia[i]
    tt, tx, ty, xx, xy, yy = inertia.tt, inertia.tx, inertia.ty, inertia.xx, inertia.xy, inertia.yy
    for k in range(body.shapes):
        for m in range(k + 1):
            _set(matrix, body.eta + k, body.eta + m, own[k, m])
        wrench = coupling[k].I_t, coupling[k].I_x, coupling[k].I_y
        _mass_matrix_row(bodies, i, work.pose, body.eta + k, wrench, matrix)
    if body.dof >= 0 and body.driven < 0:
        if body.type == REVOLUTE:
            wrench = body.sign * tt, body.sign * tx, body.sign * ty
        else:
            ux, uy = turned(work.pose, body.mount.body, body.ux, body.uy)
            wrench = tx * ux + ty * uy, xx * ux + xy * uy, xy * ux + yy * uy
        _mass_matrix_row(bodies, i, work.pose, body.dof, wrench, matrix)
    propagate_inertia(bodies, i, work, (tt, tx, ty, xx, xy, yy))


@inlined_kernel
def _set(matrix: Array, i: int, j: int, value: float) -> None:
    """Set an entry of a symmetric matrix."""
    matrix[i, j] = value
    matrix[j, i] = value


@kernel
def _mass_matrix_row(bodies: Bodies, i: int, pose: Array, row: int, wrench: Wrench, matrix: Array) -> None:
    """Set a row of the mass matrix: the forces of a wrench on body i along the free coordinates that move it."""
    while bodies.records[i].moving:
        body = bodies.records[i]
        moment, fx, fy = wrench
        p = body.mount.body
        if body.dof >= 0 and body.driven < 0:
            _set(matrix, row, body.dof, joint_force(body, pose, wrench))
        elif body.type == NODE:
            for k in range(bodies.records[p].shapes):
                turn, x, y = node_motion(pose, i, k)
                _set(matrix, row, bodies.records[p].eta + k, turn * moment + x * fx + y * fy)
        rx, ry = offset(pose, p, i)
        wrench = moment + rx * fy - ry * fx, fx, fy
        i = p


_inertias = forward(body_inertia)
_rows = backward(_rows_of_body)
