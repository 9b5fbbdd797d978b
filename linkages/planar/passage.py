"""Accelerations of closed loops, through singular positions too.

Where the closure rows become dependent, two branches of the motion cross. Accelerations are smooth along each of them,
but what gives them divides by the distance x from the crossing: an error e of the closure moves the state by e/x, its
rate by e/x^2, the acceleration by e/x^3. So within a short way of the crossing they are interpolated, between states
before and behind on the branch that continues the velocity: the state is moved along its own velocity, its
position and velocity are closed there by the smallest change, and its accelerations are found with the same applied
forces. Those states form a smooth curve through the given one, whatever passes between them.
"""

from __future__ import annotations

import numpy as np

from linkages.kernel import Array, Records, kernel, lazy_kernel
from linkages.planar.bodies import Bodies
from linkages.planar.dynamics import accelerate
from linkages.planar.kinematics import body_accelerations, body_positions, body_states
from linkages.planar.projection import correct, project, value_errors
from linkages.planar.record_types import PRISMATIC
from linkages.planar.workspace import Workspace

_NEAR = 0.03  # how far from dependent the rows are where a crossing is looked for
_STEP = 0.04  # way from one state to the next, of the fastest coordinate [rad, or in parts of the linkage's length]
_FAR = 2.0  # so much farther from dependent than the given state must the others be
_CLOSED, _GOAL = 1e-12, 1e-16  # closure errors of the others: largest, wanted
#: Largest closure error in parts of the linkage's length with which their interpolated positions lie on one branch:
#: more, and the two branches pass each other without a crossing.
GAP = 1e-9
#: Of the states at 1, 2, 3 and 4 steps before and behind: exact for polynomials of degree 7.
WEIGHTS = (4 / 5, -2 / 5, 4 / 35, -1 / 70)


@kernel
def accelerate_through(bodies: Bodies, rows: Records, rank: int, size: float, gravity: Array, work: Workspace) -> None:
    """Find accelerations as `linkages.planar.dynamics.accelerate`, of coordinates, through singular positions too.

    Takes also `work`'s q; says in its passing whether accelerations are interpolated. Its reaction, response and what
    belongs to them mean nothing then.
    """
    work.passing[0] = 0.0
    if not len(rows):
        accelerate(bodies, rows, rank, gravity, work)
        return
    for i in range(len(work.a)):
        work.given[i] = work.a[i]
    margin = accelerate(bodies, rows, rank, gravity, work)
    if margin < _NEAR:
        q, v = work.q.copy(), work.v.copy()
        if _interpolate(bodies, rows, rank, size, gravity, margin, work):
            work.passing[0] = 1.0
            _put(bodies, q, v, work)
            return
        for i in range(len(work.a)):
            work.a[i] = work.given[i]
        _put(bodies, q, v, work)
        accelerate(bodies, rows, rank, gravity, work)  # the states beside have left their reactions


@kernel
def accelerate_onto(
    bodies: Bodies, rows: Records, rank: int, size: float, rate: float, gravity: Array, work: Workspace
) -> None:
    """Find the accelerations of the nearest state whose loops are closed, and a feedback that leads there.

    As `accelerate_through`, for a simulator that does not project its states: that one's accelerations err by what the
    state lacks over its distance from a singular position, these do not.

    Parameters
    ----------
    rate : float
        At which deviations from the closed state decay, both roots [1/s].
    """
    if not len(rows):
        accelerate(bodies, rows, rank, gravity, work)
        return
    q, v, given = work.q.copy(), work.v.copy(), work.a.copy()
    margin = accelerate(bodies, rows, rank, gravity, work)
    if not (margin < _NEAR and _interpolate(bodies, rows, rank, size, gravity, margin, work)):
        for i in range(len(q)):
            work.a[i] = given[i]
        project(bodies, rows, rank, _CLOSED, size, work)
        accelerate(bodies, rows, rank, gravity, work)
    for i in range(len(bodies.records)):
        d = bodies.records[i].dof
        if d >= 0 and bodies.records[i].driven < 0:
            work.a[d] -= rate * (2.0 * (v[d] - work.v[d]) + rate * (q[d] - work.q[d]))
    _put(bodies, q, v, work)


@kernel
def _put(bodies: Bodies, q: Array, v: Array, work: Workspace) -> None:
    """Put `work` into a state, with the accelerations that it has."""
    for i in range(len(q)):
        work.q[i], work.v[i] = q[i], v[i]
    body_states(bodies, work.q, work.v, work.pose, work.vel)
    body_accelerations(bodies, work.pose, work.vel, work.v, work.a, work.acc)


@kernel
def beside(bodies: Bodies, rows: Records, rank: int, size: float, gravity: Array, work: Workspace) -> None:
    """Leave `work`, which passes a singular position, solved at a state beside it."""
    _solve_beside(bodies, rows, rank, size, gravity, _time(bodies, size, work), work)
    body_accelerations(bodies, work.pose, work.vel, work.v, work.a, work.acc)


@lazy_kernel
def _interpolate(
    bodies: Bodies, rows: Records, rank: int, size: float, gravity: Array, margin: float, work: Workspace
) -> bool:
    """Put `work` onto the branch, interpolated; False where no crossing is passed: it stays as it is."""
    n, step = len(work.q), _time(bodies, size, work)
    q, v, a = work.q.copy(), work.v.copy(), work.a.copy()
    middle_q, middle_v, middle_a = np.zeros(n), np.zeros(n), np.zeros(n)
    passes = step > 0.0 and _is_least(bodies, rows, rank, margin, step, work)
    for k in range(2 * len(WEIGHTS)):
        if not passes:
            break
        for i in range(n):
            work.q[i], work.v[i] = q[i], v[i]
        away = (k // 2 + 1) * (1.0 if k % 2 else -1.0) * step
        passes = _solve_beside(bodies, rows, rank, size, gravity, away, work) > _FAR * margin
        for i in range(n):
            middle_q[i] += WEIGHTS[k // 2] * work.q[i]
            middle_v[i] += WEIGHTS[k // 2] * work.v[i]
            middle_a[i] += WEIGHTS[k // 2] * work.a[i]
    if passes:
        body_positions(bodies, middle_q, work.pose)
        passes = value_errors(rows, work) <= GAP * size
    for i in range(n):
        work.a[i] = middle_a[i] if passes else a[i]
    if passes:
        _put(bodies, middle_q, middle_v, work)
    else:
        _put(bodies, q, v, work)
    return passes


@kernel
def _is_least(bodies: Bodies, rows: Records, rank: int, margin: float, step: float, work: Workspace) -> bool:
    """Whether the rows are much farther from dependent a step before and behind; leaves `work` elsewhere."""
    q, nowhere = work.q.copy(), np.zeros(len(work.q))
    for side in (-1.0, 1.0):
        for i in range(len(q)):
            work.q[i] = q[i] + side * step * work.v[i]
        body_positions(bodies, work.q, work.pose)
        if correct(bodies, rows, rank, work, nowhere) <= _FAR * margin:
            return False
    return True


@kernel
def _time(bodies: Bodies, size: float, work: Workspace) -> float:
    """Time in which the fastest coordinate goes one step; zero at rest."""
    fastest = 0.0
    for i in range(len(bodies.records)):
        if bodies.records[i].dof >= 0:
            rate = abs(work.v[bodies.records[i].dof])
            fastest = max(fastest, rate / size if bodies.records[i].type == PRISMATIC else rate)
    return _STEP / fastest if fastest > 0.0 else 0.0


@lazy_kernel
def _solve_beside(
    bodies: Bodies, rows: Records, rank: int, size: float, gravity: Array, time: float, work: Workspace
) -> float:
    """Move `work` along its velocity, close it there and find its accelerations.

    Returns how far the rows are from dependent, see `linkages.planar.dynamics.accelerate`; zero if they do not close.
    """
    for i in range(len(work.q)):
        work.q[i] += time * work.v[i]
    for i in range(len(bodies.records)):
        if bodies.records[i].dof >= 0 and bodies.records[i].driven < 0:
            work.a[bodies.records[i].dof] = 0.0
    body_states(bodies, work.q, work.v, work.pose, work.vel)
    project(bodies, rows, rank, _GOAL, size, work)
    margin = accelerate(bodies, rows, rank, gravity, work)
    return margin if value_errors(rows, work) <= _CLOSED * size else 0.0
