"""Projection onto the closure of ideal loops."""

from __future__ import annotations

from linkages.kernel import Array, Records, kernel
from linkages.planar.bodies import Bodies
from linkages.planar.dynamics import articulate, loop_responses, solve_rows
from linkages.planar.kinematics import body_positions, body_velocities, row_rate, row_value
from linkages.planar.workspace import Workspace

_ROUNDS = 6


@kernel
def project(bodies: Bodies, rows: Records, rank: int, goal: float, size: float, work: Workspace) -> bool:
    """Move `work`'s coordinates and rates to where the loops are closed; False if they were already.

    The move is the smallest in the metric of the mass matrix: what unit reactions would cause, so that no motion along
    the constraints comes with it. Takes and leaves the pose and vel of q and v. Of `Tree.stiff_bodies` it hardly
    strains stiff modes, which are light, so that they do not ring after it.

    Parameters
    ----------
    goal : float
        Closure error that is left, in parts of the length `size` [m] and of the largest speed.
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
        work.error[k] = -row_rate(rows[k], work.pose, work.vel)
        worst = max(worst, abs(work.error[k]))
    if worst > goal * speed:
        correct(bodies, rows, rank, work, work.v)
        body_velocities(bodies, work.pose, work.v, work.vel)
        moved = True
    return moved


@kernel
def value_errors(rows: Records, work: Workspace) -> float:
    """Fill `work`'s error with what the rows lack, and return the largest magnitude."""
    worst = 0.0
    for k in range(len(rows)):
        work.error[k] = -row_value(rows[k], work.pose)
        worst = max(worst, abs(work.error[k]))
    return worst


@kernel
def correct(bodies: Bodies, rows: Records, rank: int, work: Workspace, x: Array) -> float:
    """Add to x (coordinates or rates) what takes the rows by `work`'s errors; returns as `solve_rows`."""
    articulate(bodies, work)
    loop_responses(bodies, rows, work)
    margin = solve_rows(rows, rank, work.response, work.error, work.room, work.reaction)
    for k in range(len(rows)):
        for i in range(len(x)):
            x[i] += work.reaction[k] * work.row_a[k, i]
    return margin
