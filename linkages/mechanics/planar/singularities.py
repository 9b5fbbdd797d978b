"""Forward dynamics of closed loops near singularities, where two branches of the motion cross.

At a singularity the closure rows are dependent. Accelerations are smooth along each branch, but the equations for them
divide by the distance x from the crossing: a closure error e moves the state by e/x, its rate by e/x^2 and its
acceleration by e/x^3. Near the crossing the accelerations are therefore interpolated between neighbouring states before
and behind it, on the branch that continues the velocity. A neighbouring state is the given state moved along its own
velocity; its position and velocity are closed by the smallest change, and its accelerations follow from the same
applied forces. The neighbouring states lie on a smooth curve through the given state.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, Records, kernel, lazy_kernel
from linkages.mechanics.integrate.stepper import copy
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.closure_rows import add_row_wrench
from linkages.mechanics.planar.elimination import Elimination
from linkages.mechanics.planar.kinematics import body_accelerations, body_positions, body_states
from linkages.mechanics.planar.loop_dynamics import correct, forward_dynamics, project, value_errors
from linkages.mechanics.planar.newton_euler import generalised_force, inertial_forces
from linkages.mechanics.planar.record_types import PRISMATIC
from linkages.mechanics.planar.workspace import Workspace

_NEAR = 0.03  # conditioning of the rows below which a crossing is looked for
_STEP = 0.04  # travel of the fastest coordinate between neighbouring states [rad, or parts of the linkage's length]
_FAR = 2.0  # required ratio of conditioning at neighbouring states to the given state's
_CLOSED, _GOAL = 1e-12, 1e-16  # closure errors of neighbouring states, in parts of the length: largest, wanted
#: Largest closure error of the interpolated position, in parts of the linkage's length, at which two branches count as
#: crossing; with a larger one they pass each other.
GAP = 1e-9
#: Weights of the states 1, 2, 3 and 4 steps before and behind; the interpolation is exact for polynomials of degree 7.
WEIGHTS = (4 / 5, -2 / 5, 4 / 35, -1 / 70)


@kernel(makes_arrays=True)
def smooth_dynamics(
    bodies: Bodies, rows: Records, elimination: Elimination, size: float, gravity: Array, work: Workspace
) -> None:
    """Find the accelerations of the coordinates as `forward_dynamics`, but interpolate them near a singularity.

    Sets `work`'s interpolated; its reactions and row responses are undefined where that is 1.
    """
    work.interpolated[0] = 0.0
    if not len(rows):
        forward_dynamics(bodies, rows, elimination, gravity, work)
        return
    copy(work.a, work.prescribed)
    conditioning = forward_dynamics(bodies, rows, elimination, gravity, work)
    if conditioning < _NEAR:
        q, v = work.q.copy(), work.v.copy()
        if _interpolate(bodies, rows, elimination, size, gravity, conditioning, work):
            work.interpolated[0] = 1.0
            _set_state(bodies, q, v, work)
            return
        copy(work.prescribed, work.a)
        _set_state(bodies, q, v, work)
        forward_dynamics(bodies, rows, elimination, gravity, work)  # the neighbouring states have left their reactions


@kernel(makes_arrays=True)
def stabilised_dynamics(
    bodies: Bodies, rows: Records, elimination: Elimination, size: float, rate: float, gravity: Array, work: Workspace
) -> None:
    """Find the accelerations of the nearest closed state, plus a feedback that leads to it.

    For a simulator that does not project its states: near a singularity the accelerations of `smooth_dynamics` have the
    closure error of the state over its distance from the singularity as an error; these accelerations do not.
    Deviations from the closed state decay with the double root ``rate`` [1/s].
    """
    if not len(rows):
        forward_dynamics(bodies, rows, elimination, gravity, work)
        return
    q, v, given = work.q.copy(), work.v.copy(), work.a.copy()
    conditioning = forward_dynamics(bodies, rows, elimination, gravity, work)
    if not (conditioning < _NEAR and _interpolate(bodies, rows, elimination, size, gravity, conditioning, work)):
        copy(given, work.a)
        project(bodies, rows, elimination, _CLOSED, size, work)
        forward_dynamics(bodies, rows, elimination, gravity, work)
    for i in range(len(bodies.records)):
        d = bodies.records[i].dof
        if d >= 0 and bodies.records[i].driven < 0:
            work.a[d] -= rate * (2.0 * (v[d] - work.v[d]) + rate * (q[d] - work.q[d]))
    _set_state(bodies, q, v, work)


@kernel
def _set_state(bodies: Bodies, q: Array, v: Array, work: Workspace) -> None:
    """Set `work` to a state; its accelerations ``a`` stay."""
    for i in range(len(q)):
        work.q[i], work.v[i] = q[i], v[i]
    body_states(bodies, work.q, work.v, work.pose, work.vel)
    body_accelerations(bodies, work.pose, work.vel, work.v, work.a, work.acc)


@kernel
def solve_neighbour(
    bodies: Bodies, rows: Records, elimination: Elimination, size: float, gravity: Array, work: Workspace
) -> None:
    """Solve `work`, whose accelerations are interpolated, at the first neighbouring state."""
    _solve_at_distance(bodies, rows, elimination, size, gravity, _time(bodies, size, work), work)
    body_accelerations(bodies, work.pose, work.vel, work.v, work.a, work.acc)


@lazy_kernel(makes_arrays=True)
def _interpolate(
    bodies: Bodies,
    rows: Records,
    elimination: Elimination,
    size: float,
    gravity: Array,
    conditioning: float,
    work: Workspace,
) -> bool:
    """Set `work` to the interpolated state; returns False, and changes nothing, if two branches do not cross here."""
    n, step = len(work.q), _time(bodies, size, work)
    q, v, a = work.q.copy(), work.v.copy(), work.a.copy()
    middle_q, middle_v, middle_a = np.zeros(n), np.zeros(n), np.zeros(n)
    passes = step > 0.0 and _is_singular(bodies, rows, elimination, conditioning, step, work)
    for k in range(2 * len(WEIGHTS)):
        if not passes:
            break
        for i in range(n):
            work.q[i], work.v[i] = q[i], v[i]
        away = (k // 2 + 1) * (1.0 if k % 2 else -1.0) * step
        passes = _solve_at_distance(bodies, rows, elimination, size, gravity, away, work) > _FAR * conditioning
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
        _set_state(bodies, middle_q, middle_v, work)
    else:
        _set_state(bodies, q, v, work)
    return passes


@kernel(makes_arrays=True)
def _is_singular(
    bodies: Bodies, rows: Records, elimination: Elimination, conditioning: float, step: float, work: Workspace
) -> bool:
    """Whether the conditioning is much better a step before and behind; leaves `work` at another state."""
    q, nowhere = work.q.copy(), np.zeros(len(work.q))
    for side in (-1.0, 1.0):
        for i in range(len(q)):
            work.q[i] = q[i] + side * step * work.v[i]
        body_positions(bodies, work.q, work.pose)
        if correct(bodies, rows, elimination, work, nowhere) <= _FAR * conditioning:
            return False
    return True


@kernel
def _time(bodies: Bodies, size: float, work: Workspace) -> float:
    """Time in which the fastest coordinate travels one step; zero if no coordinate moves."""
    fastest = 0.0
    for i in range(len(bodies.records)):
        if bodies.records[i].dof >= 0:
            rate = abs(work.v[bodies.records[i].dof])
            fastest = max(fastest, rate / size if bodies.records[i].type == PRISMATIC else rate)
    return _STEP / fastest if fastest > 0.0 else 0.0


@lazy_kernel
def _solve_at_distance(
    bodies: Bodies, rows: Records, elimination: Elimination, size: float, gravity: Array, time: float, work: Workspace
) -> float:
    """Move `work` along its velocity for a time, close its loops there and find its accelerations.

    Returns the conditioning of the rows, see `forward_dynamics`; zero if the loops do not close.
    """
    for i in range(len(work.q)):
        work.q[i] += time * work.v[i]
    for i in range(len(bodies.records)):
        if bodies.records[i].dof >= 0 and bodies.records[i].driven < 0:
            work.a[bodies.records[i].dof] = 0.0
    body_states(bodies, work.q, work.v, work.pose, work.vel)
    project(bodies, rows, elimination, _GOAL, size, work)
    conditioning = forward_dynamics(bodies, rows, elimination, gravity, work)
    return conditioning if value_errors(rows, work) <= _CLOSED * size else 0.0


@kernel
def constrained_dynamics(
    bodies: Bodies,
    rows: Records,
    elimination: Elimination,
    size: float,
    stabilisation: float,
    gravity: Array,
    work: Workspace,
    loops: Array,
) -> None:
    """Find accelerations, drive forces and loop reactions at a state; see `stabilised_dynamics`.

    Takes `work`'s q, v, wrench, tau of the free joints, and a with the prescribed accelerations and zero for free
    joints; sets a, tau of the prescribed joints, and the reactions, which are undefined where accelerations are
    interpolated near a singularity. Uses the other fields. Fills ``loops`` (n,) with the generalised forces of the
    loops, which are defined near a singularity too.
    """
    body_states(bodies, work.q, work.v, work.pose, work.vel)
    stabilised_dynamics(bodies, rows, elimination, size, stabilisation, gravity, work)
    needed = work.shape_response
    needed[:] = 0.0
    inertial_forces(bodies, work, gravity, work.bias, needed)
    generalised_force(bodies, work.pose, work.bias, needed)
    work.wrench[:] = 0.0
    for k in range(len(rows)):
        add_row_wrench(rows[k], work.pose, work.reaction[k], work.wrench)
    loops[:] = 0.0
    generalised_force(bodies, work.pose, work.wrench, loops)
    for i in range(len(bodies.records)):
        d = bodies.records[i].dof
        if d >= 0 and bodies.records[i].driven >= 0:
            work.tau[d] = needed[d] - loops[d]
        elif d >= 0 and len(rows):
            loops[d] = needed[d] - work.tau[d]
