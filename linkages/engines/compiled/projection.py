"""Projection onto the closure of ideal loops."""

from __future__ import annotations

from linkages.engines.compiled.model import Equations, Work
from linkages.kernel import Array, kernel
from linkages.planar.arrays import Arrays
from linkages.planar.dynamics import articulate, loop_responses, solve_semidefinite
from linkages.planar.kinematics import body_positions, body_velocities, row_rate, row_value

_CLOSED = 1e-14  # closure error that is left, in parts of the linkage's length
_ROUNDS = 4


@kernel
def project_state(equations: Equations, y: Array) -> bool:
    """Move coordinates and rates, in y and in the work, to where the loops are closed; False if they were already.

    The move is the smallest in the metric of the mass matrix: what unit reactions would cause, so that no motion along
    the constraints comes with it.
    """
    model, work = equations.model, equations.work
    w, n, nr = work.dynamics, len(model.free), len(model.rows)
    goal = _CLOSED * model.size
    moved = False
    for _ in range(_ROUNDS):
        worst = 0.0
        for k in range(nr):
            w.error[k] = -row_value(model.rows[k], w.pose)
            worst = max(worst, abs(w.error[k]))
        if worst <= goal:
            break
        _move(model, work, w.q)
        body_positions(model.bodies, w.q, w.pose)
        moved = True
    if moved:
        body_velocities(model.bodies, w.pose, w.v, w.vel)
    worst, speed = 0.0, 0.0
    for i in range(len(model.bodies)):
        speed = max(speed, abs(w.vel[i, 0]) * model.size)
    for k in range(nr):
        w.error[k] = -row_rate(model.rows[k], w.pose, w.vel)
        worst = max(worst, abs(w.error[k]))
    if worst > _CLOSED * speed:
        _move(model, work, w.v)
        body_velocities(model.bodies, w.pose, w.v, w.vel)
        moved = True
    if moved:
        for i in range(n):
            y[i] = w.q[model.free[i]]
            y[n + i] = w.v[model.free[i]]
    return moved


@kernel
def _move(model: Arrays, work: Work, x: Array) -> None:
    """Add to x what takes the rows by the work's errors."""
    w = work.dynamics
    articulate(model.bodies, w.pose, w.inertia, w.axis)
    loop_responses(model.bodies, model.rows, w)
    solve_semidefinite(w.response, w.error, w.reaction)
    for k in range(len(model.rows)):
        for i in range(len(x)):
            x[i] += w.reaction[k] * w.row_a[k, i]
