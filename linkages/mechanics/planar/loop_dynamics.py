"""Forward dynamics of a tree whose cut ideal joints are closed by reactions of closure rows (Lagrange multipliers)."""

from __future__ import annotations

from linkages.base.kernel import Array, Indices, Records, inlined_kernel, lazy_kernel
from linkages.mechanics.integrate.factor import solve_semidefinite
from linkages.mechanics.planar.articulated_body import acceleration_response, is_nonzero, tree_dynamics
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_acceleration
from linkages.mechanics.planar.workspace import Workspace


@inlined_kernel
def forward_dynamics(bodies: Bodies, rows: Records, rank: int, gravity: Array, work: Workspace) -> float:
    """Find the accelerations of the coordinates and the reactions of the closure rows.

    Parameters
    ----------
    rows : array of ROW
        Closure rows of the cut ideal joints; may be empty. Redundant rows are found and dropped.
    rank : int
        Number of independent rows where the linkage is not singular.
    gravity : (2,) array
        In plane axes [m/s2].
    work : Workspace
        As for `tree_dynamics`; sets the reactions too. Its acc is without the effect of the reactions: with rows,
        `linkages.mechanics.planar.kinematics.body_accelerations` gives the accelerations of the bodies.

    Returns
    -------
    float
        Conditioning of the rows, see `solve_rows`; 1 without rows.
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
