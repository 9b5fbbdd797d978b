"""Forward dynamics with reactions (Lagrange multipliers) of the rows that close cut joints; projection onto rows."""

from __future__ import annotations

from linkages.base.kernel import Array, Indices, Records, inlined_kernel, kernel, lazy_kernel
from linkages.mechanics.integrate.factor import solve_semidefinite
from linkages.mechanics.planar.articulated_body import (
    acceleration_response,
    articulated_inertias,
    is_nonzero,
    tree_dynamics,
)
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_acceleration, row_rate, row_value
from linkages.mechanics.planar.kinematics import body_positions, body_velocities
from linkages.mechanics.planar.workspace import Workspace


@inlined_kernel
def forward_dynamics(bodies: Bodies, rows: Records, rank: int, gravity: Array, work: Workspace) -> float:
    """Find the accelerations of the coordinates and the reactions of the closure rows, redundant ones too.

    Takes and sets of `work` what `tree_dynamics` does, and the reactions. Its acc is without the effect of the
    reactions: with rows, `linkages.mechanics.planar.kinematics.body_accelerations` gives the accelerations of the
    bodies. Returns the conditioning of the rows, see `solve_rows`; 1 without rows.
    """
    tree_dynamics(bodies, gravity, work)
    nr = len(rows)
    if nr == 0:
        return 1.0
    for k in range(nr):
        work.row_error[k] = -row_acceleration(rows[k], work.pose, work.vel, work.acc)
    row_responses(bodies, rows, work)
    conditioning = solve_rows(rows, rank, work.row_matrix, work.row_error, work.pivots, work.reaction)
    for k in range(nr):
        for i in range(len(work.a)):
            work.a[i] += work.reaction[k] * work.row_response[k, i]
    return conditioning


@lazy_kernel
def solve_rows(rows: Records, rank: int, matrix: Array, error: Array, pivots: Indices, reaction: Array) -> float:
    """Solve ``matrix @ reaction = error`` of the rows (nr,), using both up; returns as `solve_semidefinite`.

    Rows are multiplied by their scales first, so that lengths, angles and gears compare.
    """
    for k in range(len(rows)):
        error[k] *= rows[k].scale
        for m in range(len(rows)):
            matrix[k, m] *= rows[k].scale * rows[m].scale
    conditioning = solve_semidefinite(matrix, error, rank, pivots, reaction)
    for k in range(len(rows)):
        reaction[k] *= rows[k].scale
    return conditioning


@lazy_kernel
def row_responses(bodies: Bodies, rows: Records, work: Workspace) -> None:
    """Set the changes of the accelerations, of coordinates and rows, due to a unit reaction of each row.

    Takes `work`'s pose and articulated inertias; sets row_response and row_matrix, uses bias and response.
    """
    response = work.response
    work.row_response[:] = 0.0
    work.bias[:] = 0.0
    work.modal_bias[:] = 0.0
    for k in range(len(rows)):
        add_row_wrench(rows[k], work.pose, -1.0, work.bias)
        acceleration_response(bodies, work, work.bias, work.modal_bias, work.zero_force, work.row_response[k])
        work.bias[:] = 0.0
        work.modal_bias[:] = 0.0
        for m in range(k + 1):
            size, term = 0.0, rows[m].term
            if rows[m].ratio != 0.0 or is_nonzero(response, term.a.body) or is_nonzero(response, term.b.body):
                size = row_acceleration(rows[m], work.pose, work.zero_velocity, response)
            work.row_matrix[m, k], work.row_matrix[k, m] = size, size


_ROUNDS = 6


@kernel
def project(bodies: Bodies, rows: Records, rank: int, goal: float, size: float, work: Workspace) -> bool:
    """Correct `work`'s coordinates and rates until the loops are closed; returns False if they were already.

    The correction is the smallest in the metric of the mass matrix, a combination of the responses to unit reactions:
    it has no component along the constraints. Takes q, v, pose and vel, and leaves them consistent. With
    `Tree.stiff_bodies`, whose stiff modes are heavy, the correction hardly excites these modes. The closure error to
    reach, ``goal``, is in parts of the size and of the largest speed.
    """
    moved = False
    for _ in range(_ROUNDS):
        if value_errors(rows, work) <= goal * size:
            break
        correct(bodies, rows, rank, work, work.q)
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
        correct(bodies, rows, rank, work, work.v)
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
def correct(bodies: Bodies, rows: Records, rank: int, work: Workspace, x: Array) -> float:
    """Change x (coordinates or rates) so that the rows change by `work`'s row_error; returns as `solve_rows`."""
    articulated_inertias(bodies, work)
    row_responses(bodies, rows, work)
    conditioning = solve_rows(rows, rank, work.row_matrix, work.row_error, work.pivots, work.reaction)
    for k in range(len(rows)):
        for i in range(len(x)):
            x[i] += work.reaction[k] * work.row_response[k, i]
    return conditioning
