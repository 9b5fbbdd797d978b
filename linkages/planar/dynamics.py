"""Articulated-body dynamics of a planar tree with prescribed joints, and the reactions of cut ideal joints.

The recursion is Featherstone's articulated-body algorithm (Rigid Body Dynamics Algorithms, 2008, ch. 7). It starts from
the accelerations that the bodies would have if no free joint accelerated: velocity terms and prescribed joints are in
them, and what is left is linear. Bodies that no free joint moves take no part. Vectors are (moment, fx, fy) and
(alpha, ax, ay) in plane axes at the origin of each body's own frame. Symmetric 3x3 inertias are stored as
(I00, I01, I02, I11, I12, I22). Cost is linear in the number of bodies.

Of a body that bends the modal coordinates are eliminated before its joint's, as if they were joints of their own
between it and its frame; the inertia of what hangs on its sections is in them. See `linkages.planar.bodies`.
"""

from __future__ import annotations

from linkages.integrate.factor import solve_semidefinite
from linkages.kernel import Array, Indices, Records, clear, inlined_kernel, kernel, lazy_kernel
from linkages.planar.bending import add_to_modes, beam_inertia, beam_load, eliminate, hang, moved_modes, pushed_modes
from linkages.planar.bodies import POSE, Bodies
from linkages.planar.kinematics import (
    add_row_wrench,
    add_to_parent,
    along,
    body_acceleration,
    modal_motion,
    row_acceleration,
)
from linkages.planar.markers import turned
from linkages.planar.record_types import PRISMATIC, REVOLUTE, SECTION
from linkages.planar.workspace import Workspace


@kernel
def generalized_force(bodies: Bodies, pose: Array, wrench: Array, tau: Array) -> None:
    """Add J^T w of the bodies' wrenches to ``tau`` (n,); `wrench` is used up."""
    for i in range(len(bodies.records) - 1, 0, -1):
        body = bodies.records[i]
        if body.dof >= 0:
            tau[body.dof] += along(body, pose, wrench[i])
        for k in range(body.modes):
            tau[body.eta + k] += wrench[i, 3 + k]
        add_to_parent(bodies, pose, i, wrench)


@kernel
def articulate(bodies: Bodies, work: Workspace) -> None:
    """Articulated inertias of `work`'s pose.

    Uses ``inertia`` (nb, 6) and fills, for each moving body, ``axis`` (nb, 8): its joint's motion S (zero if the joint
    is not free), U = I S, 1/(S.U), and room for `respond`. Where bodies bend both are wider, see
    `linkages.planar.bending`.
    """
    for i in range(1, len(bodies.records)):
        if bodies.records[i].moving:
            _own_inertia(bodies, i, work)
    for i in range(len(bodies.records) - 1, 0, -1):
        if bodies.records[i].moving:
            _articulate_body(bodies, i, work)


@inlined_kernel
def _own_inertia(bodies: Bodies, i: int, work: Workspace) -> None:
    """Put the inertia of body i into its line of ``inertia``."""
    body, inertia = bodies.records[i], work.inertia
    if body.modes > 0:
        beam_inertia(bodies, i, work)
        return
    cx, cy = turned(work.pose, i, body.cx, body.cy)
    m = body.mass
    inertia[i, 0] = body.inertia + m * (cx * cx + cy * cy)
    inertia[i, 1] = -m * cy
    inertia[i, 2] = m * cx
    inertia[i, 3] = m
    inertia[i, 4] = 0.0
    inertia[i, 5] = m


@inlined_kernel
def _articulate_body(bodies: Bodies, i: int, work: Workspace) -> None:
    """Eliminate the joint of moving body i from its inertia, and add what is left to its parent's."""
    body, pose, inertia, axis = bodies.records[i], work.pose, work.inertia, work.axis
    p = body.mount.body
    if body.modes > 0:
        eliminate(bodies, i, work)
    elif body.type == SECTION:
        hang(bodies, i, work)
    i0, i1, i2 = inertia[i, 0], inertia[i, 1], inertia[i, 2]
    i3, i4, i5 = inertia[i, 3], inertia[i, 4], inertia[i, 5]
    if body.dof >= 0 and body.driven < 0:
        s0, s1, s2 = 0.0, 0.0, 0.0
        if body.type == REVOLUTE:
            s0 = body.sign
            u0, u1, u2, d = i0 * s0, i1 * s0, i2 * s0, i0
            i0, i1, i2 = 0.0, 0.0, 0.0
        else:
            s1, s2 = turned(pose, p, body.ux, body.uy)
            u0, u1, u2 = i1 * s1 + i2 * s2, i3 * s1 + i4 * s2, i4 * s1 + i5 * s2
            d = s1 * u1 + s2 * u2
        inverse = 1.0 / d
        if body.type == PRISMATIC:
            i0, i1, i2 = i0 - u0 * u0 * inverse, i1 - u0 * u1 * inverse, i2 - u0 * u2 * inverse
        i3, i4, i5 = i3 - u1 * u1 * inverse, i4 - u1 * u2 * inverse, i5 - u2 * u2 * inverse
        axis[i, 0], axis[i, 1], axis[i, 2] = s0, s1, s2
        axis[i, 3], axis[i, 4], axis[i, 5], axis[i, 6] = u0, u1, u2, inverse
    _hand_on(bodies, i, work, (i0, i1, i2, i3, i4, i5))


@inlined_kernel
def _hand_on(bodies: Bodies, i: int, work: Workspace, given: tuple[float, float, float, float, float, float]) -> None:
    """Add an inertia given at body i to its parent's, if that moves."""
    pose, inertia, p = work.pose, work.inertia, bodies.records[i].mount.body
    if not bodies.records[p].moving:
        return
    i0, i1, i2, i3, i4, i5 = given
    rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
    b0 = i0 - ry * i1 + rx * i2
    b1 = i1 - ry * i3 + rx * i4
    b2 = i2 - ry * i4 + rx * i5
    inertia[p, 0] += b0 - ry * b1 + rx * b2
    inertia[p, 1] += b1
    inertia[p, 2] += b2
    inertia[p, 3] += i3
    inertia[p, 4] += i4
    inertia[p, 5] += i5


@kernel
def inertial_load(bodies: Bodies, work: Workspace, gravity: Array, load: Array) -> None:
    """Fill ``load`` (nb, 3): rate of change of momentum minus gravity minus the applied wrenches, `work`'s wrench.

    Where bodies bend lines have modal entries too, without a wrench: what is applied is applied to frames and sections.
    """
    for i in range(len(bodies.records)):
        _own_load(bodies, i, work, gravity, load)


@inlined_kernel
def _own_load(bodies: Bodies, i: int, work: Workspace, gravity: Array, load: Array) -> None:
    """Fill the line of body i in ``load``."""
    body, vel, acc, wrench = bodies.records[i], work.vel, work.acc, work.wrench
    if body.modes > 0:
        beam_load(bodies, i, work, gravity, load)
        for k in range(3):
            load[i, k] -= wrench[i, k]
        return
    if body.type == SECTION:  # without mass
        load[i, 0], load[i, 1], load[i, 2] = -wrench[i, 0], -wrench[i, 1], -wrench[i, 2]
        return
    cx, cy = turned(work.pose, i, body.cx, body.cy)
    m, al, w2 = body.mass, acc[i, 0], vel[i, 0] * vel[i, 0]
    fx = m * (acc[i, 1] - al * cy - w2 * cx - gravity[0])
    fy = m * (acc[i, 2] + al * cx - w2 * cy - gravity[1])
    load[i, 0] = body.inertia * al + cx * fy - cy * fx - wrench[i, 0]
    load[i, 1] = fx - wrench[i, 1]
    load[i, 2] = fy - wrench[i, 2]


@kernel
def respond(bodies: Bodies, work: Workspace, load: Array, tau: Array, a: Array) -> None:
    """Change of the accelerations that given loads cause; branches without loads cost next to nothing.

    Parameters
    ----------
    work : Workspace
        With its inertia and axis from `articulate`; its change (nb, 3) is filled with that of the moving bodies'
        accelerations.
    load : (nb, 3) array
        From `inertial_load`; used up.
    tau : (n,) array
        Applied generalised forces of free joints.
    a : (n,) array
        The change of the free joints' accelerations is added.
    """
    axis, change = work.axis, work.change
    nb = len(bodies.records)
    for i in range(nb - 1, 0, -1):
        body = bodies.records[i]
        if not body.moving:
            continue
        if body.modes > 0:
            pushed_modes(bodies, i, work, load, tau)
        pushed = body.dof >= 0 and body.driven < 0 and tau[body.dof] != 0.0
        axis[i, 7] = 0.0
        if pushed or moves(load, i):
            _push_body(bodies, i, work, load, tau)
    for i in range(1, nb):
        body = bodies.records[i]
        if not body.moving:
            continue
        if axis[i, 7] != 0.0 or body.modes > 0 or body.type == SECTION or moves(change, body.mount.body):
            _move_body(bodies, i, work, a)
        else:
            change[i, 0], change[i, 1], change[i, 2] = 0.0, 0.0, 0.0


@inlined_kernel
def _push_body(bodies: Bodies, i: int, work: Workspace, load: Array, tau: Array) -> None:
    """Find what the loads on moving body i do to its joint, and add what is left to its parent's."""
    body, pose, axis = bodies.records[i], work.pose, work.axis
    f0, f1, f2 = load[i, 0], load[i, 1], load[i, 2]
    if body.dof >= 0 and body.driven < 0:
        push = (tau[body.dof] - (axis[i, 0] * f0 + axis[i, 1] * f1 + axis[i, 2] * f2)) * axis[i, 6]
        axis[i, 7] = push
        f0 = body.sign * tau[body.dof] if body.type == REVOLUTE else f0 + axis[i, 3] * push
        f1, f2 = f1 + axis[i, 4] * push, f2 + axis[i, 5] * push
    p = body.mount.body
    if bodies.records[p].moving:
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        load[p, 0] += f0 + rx * f2 - ry * f1
        load[p, 1] += f1
        load[p, 2] += f2
        if body.type == SECTION:
            add_to_modes(bodies, i, pose, f0, f1, f2, load)


@inlined_kernel
def _move_body(bodies: Bodies, i: int, work: Workspace, a: Array) -> None:
    """Fill the line of moving body i in ``change``; its parent's is known, zero if it does not move."""
    body, pose, axis, change = bodies.records[i], work.pose, work.axis, work.change
    p = body.mount.body
    rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
    a0, a1, a2 = change[p, 0], change[p, 1] - change[p, 0] * ry, change[p, 2] + change[p, 0] * rx
    if body.type == SECTION:
        turn, x, y = modal_motion(bodies, i, pose, change)
        a0, a1, a2 = a0 + turn, a1 + x, a2 + y
    if body.dof >= 0 and body.driven < 0:
        qdd = axis[i, 7] - axis[i, 6] * (axis[i, 3] * a0 + axis[i, 4] * a1 + axis[i, 5] * a2)
        a[body.dof] += qdd
        a0, a1, a2 = a0 + axis[i, 0] * qdd, a1 + axis[i, 1] * qdd, a2 + axis[i, 2] * qdd
    change[i, 0], change[i, 1], change[i, 2] = a0, a1, a2
    if body.modes > 0:
        moved_modes(bodies, i, work, a)


@inlined_kernel
def moves(change: Array, body: int) -> bool:
    """Whether a body's acceleration is changed, or any load is on it."""
    return change[body, 0] != 0.0 or change[body, 1] != 0.0 or change[body, 2] != 0.0


@inlined_kernel
def accelerate(bodies: Bodies, rows: Records, rank: int, gravity: Array, work: Workspace) -> float:
    """Accelerations and loop reactions of a tree whose cut ideal joints are closed by multipliers.

    Takes `work`'s v, pose, vel, wrench, tau, and a with the prescribed accelerations and zero for free joints; fills a,
    reaction, and acc, which is without the reactions: with rows, `body_accelerations` gives that of the bodies.

    Parameters
    ----------
    rows : array of ROW
        Closure rows of the cut ideal joints; may be empty. Redundant rows are found and dropped.
    rank : int
        How many of them are independent where the linkage is not singular.
    gravity : (2,) array
        In plane axes [m/s^2].

    Returns
    -------
    float
        How far the rows are from dependent, see `solve_rows`; 1 without rows.
    """
    pose, vel, acc = work.pose, work.vel, work.acc
    _accelerate_tree(bodies, gravity, work)
    nr = len(rows)
    if nr == 0:
        return 1.0
    for k in range(nr):
        work.error[k] = -row_acceleration(rows[k], pose, vel, acc)
    loop_responses(bodies, rows, work)
    margin = solve_rows(rows, rank, work.response, work.error, work.room, work.reaction)
    for k in range(nr):
        for i in range(len(work.a)):
            work.a[i] += work.reaction[k] * work.row_a[k, i]
    return margin


@kernel
def _accelerate_tree(bodies: Bodies, gravity: Array, work: Workspace) -> None:
    """Find accelerations without the cut joints: `articulate`, `inertial_load` and `respond` at once, body by body."""
    acc = work.acc
    acc[0, 0], acc[0, 1], acc[0, 2] = 0.0, 0.0, 0.0
    for i in range(1, len(bodies.records)):
        body_acceleration(bodies, i, work.pose, work.vel, work.v, work.a, acc)
        if bodies.records[i].moving:
            _own_inertia(bodies, i, work)
            _own_load(bodies, i, work, gravity, work.load)
    for i in range(len(bodies.records) - 1, 0, -1):
        if bodies.records[i].moving:
            _articulate_body(bodies, i, work)
            if bodies.records[i].modes > 0:
                pushed_modes(bodies, i, work, work.load, work.tau)
            _push_body(bodies, i, work, work.load, work.tau)
    for i in range(1, len(bodies.records)):
        if bodies.records[i].moving:
            _move_body(bodies, i, work, work.a)
            for k in range(3 + bodies.records[i].modes):
                acc[i, k] += work.change[i, k]


@kernel
def balance(bodies: Bodies, gravity: Array, work: Workspace) -> None:
    """Subtract from ``tau`` the forces that the accelerations ``a`` of all coordinates take.

    Takes `work`'s v, pose, vel and wrench too; uses acc and load. What is left in the entries of free coordinates is
    their mass times what their accelerations lack.
    """
    acc, load, tau = work.acc, work.load, work.tau
    acc[0, 0], acc[0, 1], acc[0, 2] = 0.0, 0.0, 0.0
    for i in range(1, len(bodies.records)):
        body = bodies.records[i]
        if body.type != SECTION or body.carries:  # sections have no mass
            body_acceleration(bodies, i, work.pose, work.vel, work.v, work.a, acc)
        if body.moving:
            _own_load(bodies, i, work, gravity, load)
    for i in range(len(bodies.records) - 1, 0, -1):
        body = bodies.records[i]
        if not body.moving:
            continue
        if body.dof >= 0:
            tau[body.dof] -= along(body, work.pose, load[i])
        for k in range(body.modes):
            tau[body.eta + k] -= load[i, 3 + k]
        add_to_parent(bodies, work.pose, i, load)


@kernel
def mass_matrix(bodies: Bodies, work: Workspace, matrix: Array) -> None:
    """Fill the entries of free coordinates in their mass matrix (n, n), at `work`'s pose; uses inertia.

    By composite bodies, from the leaves on (Featherstone, ch. 6): what the acceleration of a body's own coordinate
    takes is a wrench on the body, which acts on the coordinates of all that carry it too.
    """
    inertia, nm = work.inertia, bodies.shapes.shape[2]
    for i in range(1, len(bodies.records)):
        if bodies.records[i].moving:
            _own_inertia(bodies, i, work)
    for i in range(len(bodies.records) - 1, 0, -1):
        body = bodies.records[i]
        if not body.moving:
            continue
        if body.type == SECTION:
            hang(bodies, i, work)
        i0, i1, i2 = inertia[i, 0], inertia[i, 1], inertia[i, 2]
        i3, i4, i5 = inertia[i, 3], inertia[i, 4], inertia[i, 5]
        for k in range(body.modes):
            for m in range(k + 1):
                _put(matrix, body.eta + k, body.eta + m, inertia[i, 6 + 3 * nm + k * nm + m])
            wrench = inertia[i, 6 + 3 * k], inertia[i, 7 + 3 * k], inertia[i, 8 + 3 * k]
            _feel(bodies, i, work.pose, body.eta + k, wrench, matrix)
        if body.dof >= 0 and body.driven < 0:
            if body.type == REVOLUTE:
                wrench = body.sign * i0, body.sign * i1, body.sign * i2
            else:
                ux, uy = turned(work.pose, body.mount.body, body.ux, body.uy)
                wrench = i1 * ux + i2 * uy, i3 * ux + i4 * uy, i4 * ux + i5 * uy
            _feel(bodies, i, work.pose, body.dof, wrench, matrix)
        _hand_on(bodies, i, work, (i0, i1, i2, i3, i4, i5))


@inlined_kernel
def _put(matrix: Array, i: int, j: int, value: float) -> None:
    """Put an entry into a symmetric matrix."""
    matrix[i, j] = value
    matrix[j, i] = value


@kernel
def _feel(bodies: Bodies, i: int, pose: Array, row: int, wrench: tuple[float, float, float], matrix: Array) -> None:
    """Fill a row of the mass matrix: what a wrench on body i does to the free coordinates that move it."""
    while bodies.records[i].moving:
        body = bodies.records[i]
        f0, f1, f2 = wrench
        p, nm = body.mount.body, bodies.shapes.shape[2]
        if body.dof >= 0 and body.driven < 0:
            _put(matrix, row, body.dof, along(body, pose, wrench))
        elif body.type == SECTION:
            for k in range(bodies.records[p].modes):
                felt = pose[i, POSE + k] * f0 + pose[i, POSE + nm + k] * f1 + pose[i, POSE + 2 * nm + k] * f2
                _put(matrix, row, bodies.records[p].eta + k, felt)
        rx, ry = pose[i, 0] - pose[p, 0], pose[i, 1] - pose[p, 1]
        wrench = f0 + rx * f2 - ry * f1, f1, f2
        i = p


@lazy_kernel
def solve_rows(rows: Records, rank: int, response: Array, error: Array, room: Indices, reaction: Array) -> float:
    """Solve ``response reaction = error`` (nr,) of the rows, using both up, as `solve_semidefinite`.

    Rows are compared multiplied by their scales: lengths with angles, gears with joints.
    """
    for k in range(len(rows)):
        error[k] *= rows[k].scale
        for m in range(len(rows)):
            response[k, m] *= rows[k].scale * rows[m].scale
    margin = solve_semidefinite(response, error, rank, room, reaction)
    for k in range(len(rows)):
        reaction[k] *= rows[k].scale
    return margin


@kernel
def loop_responses(bodies: Bodies, rows: Records, work: Workspace) -> None:
    """Accelerations that a unit reaction of each row causes: of coordinates and rows.

    Takes `work`'s pose and axis; fills row_a and response.
    """
    change = work.change
    clear(work.row_a)
    clear(work.load)
    for k in range(len(rows)):
        add_row_wrench(rows[k], work.pose, -1.0, work.load)
        respond(bodies, work, work.load, work.rest, work.row_a[k])
        clear(work.load)
        for m in range(k + 1):
            size = 0.0
            term = rows[m].term
            if rows[m].ratio != 0.0 or moves(change, term.a.body) or moves(change, term.b.body):
                size = row_acceleration(rows[m], work.pose, work.still, change)
            work.response[m, k], work.response[k, m] = size, size
