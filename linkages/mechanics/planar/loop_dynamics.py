"""Forward dynamics with reactions (Lagrange multipliers) of the rows that close cut joints; projection onto rows."""

from __future__ import annotations

from linkages.base.kernel import Array, Records, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.dual import number
from linkages.mechanics.planar.articulated_body import articulated_inertias, bias_force, response_pass, tree_dynamics
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_acceleration, row_rate, row_value
from linkages.mechanics.planar.elimination import Elimination, factorise_rows, set_row_matrix, solve_rows
from linkages.mechanics.planar.kinematics import body_positions, body_velocities
from linkages.mechanics.planar.workspace import Workspace


@inlined_kernel
def forward_dynamics(bodies: Bodies, rows: Records, elimination: Elimination, gravity: Array, work: Workspace) -> float:
    """Find the accelerations of the coordinates and the reactions of the closure rows, redundant ones too.

    Takes and sets of `work` what `tree_dynamics` does, and the reactions. Its acc is without the effect of the
    reactions: with rows, `linkages.mechanics.planar.kinematics.body_accelerations` gives the accelerations of the
    bodies. Returns the conditioning of the rows, see `factorise_rows`; 1 without rows.
    """
    tree_dynamics(bodies, gravity, work)
    nr = len(rows)
    if nr == 0:
        return 1.0
    for k in range(nr):
        work.row_error[k] = -row_acceleration(rows[k], work.pose, work.vel, work.acc)
    conditioning = eliminate_rows(bodies, rows, elimination, work)
    add_reactions_response(bodies, rows, elimination, work, work.reaction, work.a)
    return conditioning


@lazy_kernel
def eliminate_rows(bodies: Bodies, rows: Records, elimination: Elimination, work: Workspace) -> float:
    """Set `work`'s row_matrix and pivots; returns the conditioning of the rows, see `factorise_rows`.

    Takes the pose and articulated inertias; uses bias and shape_bias. Reactions are passed on to the bodies that carry
    them alone: each coordinate on the way takes the part u of their force along it, and accelerates alone by u/D. The
    response of a row to the reaction of another is the sum of products of one's forces and the other's accelerations.
    """
    work.bias[:] = 0.0
    work.shape_bias[:] = 0.0
    for k in range(len(rows)):
        add_row_wrench(rows[k], work.pose, -1.0, work.bias)
        _pass_on(bodies, elimination, k, work)
    set_row_matrix(rows, elimination, work.row_force, work.row_push, work.row_matrix, work.pivots)
    return number(factorise_rows(elimination, work.row_matrix, work.pivots))


@inlined_kernel
def _pass_on(bodies: Bodies, elimination: Elimination, k: int, work: Workspace) -> None:
    """Pass the wrenches of row k on to the bodies that carry them, and set its forces and accelerations there."""
    bias, shape_bias, force, push, carriers = (
        work.bias, work.shape_bias, work.row_force[k], work.row_push[k], elimination.carriers,
    )  # fmt: skip
    for place in range(carriers.first[k], carriers.first[k + 1]):
        i = carriers.entries[place]
        body, joint = bodies.records[i], work.joint[i]
        for m in range(body.eta, body.eta + body.shapes):
            force[m] = -shape_bias[m]
        bias_force(bodies, i, work, bias, shape_bias, work.zero_force)
        for m in range(body.eta, body.eta + body.shapes):
            push[m] = work.shape.push[m]
            shape_bias[m] = 0.0
        if body.dof >= 0 and body.driven < 0:
            push[body.dof], force[body.dof] = joint.push, joint.push / joint.D_inverse
        bias[i, 0], bias[i, 1], bias[i, 2] = 0.0, 0.0, 0.0


@lazy_kernel
def add_reactions_response(
    bodies: Bodies, rows: Records, elimination: Elimination, work: Workspace, reaction: Array, x: Array
) -> None:
    """Find the reactions (nr,) that change the rows by `work`'s row_error, and add their effect to coordinates x (n,).

    Takes what `eliminate_rows` takes and sets; sets the response.
    """
    solve_rows(rows, work.row_matrix, work.pivots, work.row_error, reaction)
    coordinates, push = elimination.coordinates, work.shape.push
    push[:] = 0.0
    for k in range(len(rows)):
        for place in range(coordinates.first[k], coordinates.first[k + 1]):
            i = coordinates.entries[place]
            push[i] += reaction[k] * work.row_push[k, i]
    for i in range(len(bodies.records)):
        if bodies.records[i].dof >= 0:
            work.joint[i].push = push[bodies.records[i].dof]
    response_pass(bodies, work, x)


_ROUNDS = 6


@kernel
def project(bodies: Bodies, rows: Records, elimination: Elimination, goal: float, size: float, work: Workspace) -> bool:
    """Correct `work`'s coordinates and rates until the loops are closed; returns False if they were already.

    The correction is the smallest in the metric of the mass matrix, a combination of the responses to unit reactions:
    it has no component along the constraints. Takes q, v, pose and vel, and leaves them consistent. With
    `Tree.stiff_bodies`, whose stiff shapes are heavy, the correction hardly excites these shapes. The closure error to
    reach, ``goal``, is in parts of the size and of the largest speed.
    """
    moved = False
    for _ in range(_ROUNDS):
        if value_errors(rows, work) <= goal * size:
            break
        correct(bodies, rows, elimination, work, work.q)
        body_positions(bodies, work.q, work.pose)
        moved = True
    if moved:
        body_velocities(bodies, work.pose, work.v, work.vel)
    worst, speed = 0.0, 0.0
    for i in range(len(bodies.records)):
        speed = max(speed, abs(work.vel[i, 0]) * size)
    for k in range(len(rows)):
        work.row_error[k] = -row_rate(rows[k], work.pose, work.vel)
        worst = max(worst, abs(work.row_error[k]))
    if worst > goal * speed:
        correct(bodies, rows, elimination, work, work.v)
        body_velocities(bodies, work.pose, work.v, work.vel)
        moved = True
    return moved


@kernel
def value_errors(rows: Records, work: Workspace) -> float:
    """Set `work`'s row_error to the negative values of the rows, and return the largest magnitude."""
    worst = 0.0
    for k in range(len(rows)):
        work.row_error[k] = -row_value(rows[k], work.pose)
        worst = max(worst, abs(work.row_error[k]))
    return worst


@kernel
def correct(bodies: Bodies, rows: Records, elimination: Elimination, work: Workspace, x: Array) -> float:
    """Change x (coordinates or rates) so that the rows change by `work`'s row_error; returns as `eliminate_rows`."""
    articulated_inertias(bodies, work)
    conditioning = eliminate_rows(bodies, rows, elimination, work)
    add_reactions_response(bodies, rows, elimination, work, work.reaction, x)
    return conditioning
