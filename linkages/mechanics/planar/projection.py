"""Projection onto the closure of ideal loops."""

from __future__ import annotations

from linkages.base.kernel import Array, Records, kernel
from linkages.mechanics.planar.articulated_body import articulated_inertias
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.closure_rows import row_rate, row_value
from linkages.mechanics.planar.kinematics import body_positions, body_velocities
from linkages.mechanics.planar.loop_dynamics import row_responses, solve_rows
from linkages.mechanics.planar.workspace import Workspace

_ROUNDS = 6


@kernel
def project(bodies: Bodies, rows: Records, rank: int, goal: float, size: float, work: Workspace) -> bool:
    """Correct `work`'s coordinates and rates until the loops are closed; returns False if they were already.

    The correction is the smallest in the metric of the mass matrix, a combination of the responses to unit reactions:
    it has no component along the constraints. Takes q, v, pose and vel, and leaves them consistent. With
    `Tree.stiff_bodies`, whose stiff modes are heavy, the correction hardly excites these modes.

    Parameters
    ----------
    goal : float
        Closure error to reach, in parts of the length `size` [m] and of the largest speed.
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
