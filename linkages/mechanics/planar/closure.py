"""Newton's method on the closure rows: assembly, consistent rates and accelerations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.base.kernel import Array, Indices, Records, inlined_kernel, kernel
from linkages.mechanics.integrate.factor import back_substitute, decompose, factorise
from linkages.mechanics.integrate.stepper import copy
from linkages.mechanics.planar.bodies import Bodies, new_motion, new_pose
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_acceleration, row_rate, row_value
from linkages.mechanics.planar.kinematics import (
    body_accelerations,
    body_positions,
    body_states,
    body_velocities,
    joint_force,
    poses_at,
    propagate_force,
)

#: Largest closure error of an assembled linkage, relative to its size.
TOLERANCE = 1e-13
#: Largest loop error of a valid run, relative to the linkage's size.
LOOSE = 1e-6
_ITERATIONS = 50
#: Conditioning below which rates and accelerations are inaccurate.
BLURRED = 1e-3
_CURVED = 0.5  # largest contribution of the acceleration to a prediction [rad, or linkage lengths]
_PIVOT = 1e-8  # smallest pivot of a regular system, in parts of the largest
_DEPENDENT = 1e-11  # singular values of dependent rows, in parts of the largest, are below


@kernel
def closure_error(bodies: Bodies, rows: Records, offset: Array, q: Array, pose: Array, error: Array) -> None:
    """Set the closure errors (nr,) at q, less the required offsets, and the poses."""
    body_positions(bodies, q, pose)
    for k in range(len(rows)):
        error[k] = row_value(rows[k], pose) - offset[k]


@kernel
def loop_error(rows: Records, pose: Array) -> float:
    """Return the largest magnitude of the closure rows at a pose [m, rad]; zero without rows."""
    worst = 0.0
    for k in range(len(rows)):
        worst = max(worst, abs(row_value(rows[k], pose)))
    return worst


@kernel(makes_arrays=True)
def loop_errors(bodies: Bodies, rows: Records, q: Array) -> Array:
    """Compute `loop_error` (nt,) at each line of coordinates q (nt, n)."""
    pose, errors = new_pose(bodies), np.empty(len(q))
    for i in range(len(q)):
        body_positions(bodies, q[i], pose)
        errors[i] = loop_error(rows, pose)
    return errors


@kernel(makes_arrays=True)
def closure_jacobian(bodies: Bodies, rows: Records, pose: Array, jacobian: Array) -> None:
    """Set the Jacobian (nr, n) of the closure rows; row k is the generalised force of a unit reaction of that row.

    It is exact for closed loops; coordinates that carry both ends of a row are omitted: action and reaction balance.
    """
    wrench = new_motion(bodies)
    jacobian[:] = 0.0
    for k in range(len(rows)):
        add_row_wrench(rows[k], pose, 1.0, wrench)
        i, j = rows[k].term.a.body, rows[k].term.b.body
        if rows[k].ratio != 0.0:  # two pairs of branches: all bodies
            for outer in range(len(bodies.records) - 1, 0, -1):
                _pass_on(bodies, pose, outer, wrench, jacobian[k])
            i, j = 0, 0
        while i != j:  # at their common parent action and reaction balance
            outer = max(i, j)
            _pass_on(bodies, pose, outer, wrench, jacobian[k])
            i, j = min(i, j), bodies.records[outer].mount.body
        wrench[i, 0], wrench[i, 1], wrench[i, 2] = 0.0, 0.0, 0.0


def jacobian_at(bodies: Bodies, rows: Records, q: Array) -> Array:
    """Return the Jacobian (nr, n) of the closure rows at coordinates q (n,), as `closure_jacobian`."""
    jacobian = np.empty((len(rows), len(q)))
    closure_jacobian(bodies, rows, poses_at(bodies, q), jacobian)
    return jacobian


@kernel(makes_arrays=True)
def free_jacobian(bodies: Bodies, rows: Records, pose: Array, n: int, free: Indices, jacobian: Array) -> None:
    """Set the columns (nr, nf) of the free ones of n coordinates in `closure_jacobian`."""
    whole = np.empty((len(rows), n))
    closure_jacobian(bodies, rows, pose, whole)
    for k in range(len(rows)):
        for i in range(len(free)):
            jacobian[k, i] = whole[k, free[i]]


@inlined_kernel
def _pass_on(bodies: Bodies, pose: Array, outer: int, wrench: Array, line: Array) -> None:
    """Move a body's wrench to its parent, and set its components along the coordinates between both."""
    body = bodies.records[outer]
    if body.dof >= 0:
        line[body.dof] = joint_force(body, pose, wrench[outer])
    propagate_force(bodies, outer, pose, wrench, line)
    wrench[outer, 0], wrench[outer, 1], wrench[outer, 2] = 0.0, 0.0, 0.0


@kernel(makes_arrays=True)
def least_squares(matrix: Array, rhs: Array, x: Array) -> None:
    """Set x to the smallest least-squares solution of matrix @ x = rhs; the matrix (m, n) may be singular."""
    m, n = matrix.shape
    u, s, vt = np.empty((m, min(m, n))), np.empty(min(m, n)), np.empty((min(m, n), n))
    decompose(matrix, u, s, vt)
    x[:] = 0.0
    for k in range(len(s)):
        if s[k] <= _DEPENDENT * s[0]:
            break
        total = 0.0
        for i in range(m):
            total += u[i, k] * rhs[i]
        for j in range(n):
            x[j] += vt[k, j] * total / s[k]


@kernel(makes_arrays=True)
def solve_columns(matrix: Array, rhs: Array, x: Array) -> None:
    """Set x to the solution of matrix @ x = rhs: by LU if it is square and its pivots allow, else `least_squares`."""
    n = len(rhs)
    if matrix.shape[1] == n:
        factors, pivots = np.empty((n, n)), np.empty(n, np.int64)
        for i in range(n):
            x[i] = rhs[i]
            for j in range(n):
                factors[i, j] = matrix[i, j]
        if factorise(factors, pivots):
            largest, smallest = 0.0, np.inf
            for i in range(n):
                largest = max(largest, abs(factors[i, i]))
                smallest = min(smallest, abs(factors[i, i]))
            if smallest > _PIVOT * largest:
                back_substitute(factors, pivots, x)
                return
    least_squares(matrix, rhs, x)


@kernel
def sum_of_squares(x: Array) -> float:
    """Sum of the squares of a vector's entries."""
    total = 0.0
    for value in x:
        total += value * value
    return total


@kernel(makes_arrays=True)
def close(bodies: Bodies, rows: Records, offset: Array, free: Indices, size: float, q: Array) -> bool:
    """Move the free coordinates of ``q`` (in place) until the rows are closed; False if this does not converge.

    Newton's method with step halving on the sum of squares.
    """
    n, nr, nf = len(q), len(rows), len(free)
    pose, inner, error, step, trial = new_pose(bodies), np.empty((nr, nf)), np.empty(nr), np.empty(nf), np.empty(n)
    closure_error(bodies, rows, offset, q, pose, error)
    merit = sum_of_squares(error)
    for _ in range(_ITERATIONS):
        if math.sqrt(merit) <= TOLERANCE * size:
            return True
        free_jacobian(bodies, rows, pose, n, free, inner)
        solve_columns(inner, error, step)
        copy(q, trial)
        fraction = 1.0
        improved = False
        while fraction > 1e-4:
            for i in range(nf):
                trial[free[i]] = q[free[i]] - fraction * step[i]
            closure_error(bodies, rows, offset, trial, pose, error)
            new = sum_of_squares(error)
            if new < merit:
                improved = True
                break
            fraction *= 0.5
        if not improved:  # at round-off, or stuck
            break
        for i in range(nf):
            q[free[i]] = trial[free[i]]
        merit = new
    return math.sqrt(merit) <= 1e3 * TOLERANCE * size


@kernel(makes_arrays=True)
def approach(
    bodies: Bodies, rows: Records, free: Indices, size: float, held: Indices, places: Array, steps: int, q: Array
) -> bool:
    """Move held coordinates of a closed linkage from zero to places in equal steps, and close its rows after each.

    Returns False at a step that does not close, where the held coordinates stay.
    """
    none = np.zeros(len(rows))
    for k in range(1, steps + 1):
        fraction = 1.0 if k == steps else k * (1.0 / steps)
        for i in range(len(held)):
            q[held[i]] = fraction * places[i]
        if not close(bodies, rows, none, free, size, q):
            return False
    return True


@kernel(makes_arrays=True)
def consistent_rates(bodies: Bodies, rows: Records, free: Indices, q: Array, v: Array, a: Array) -> None:
    """Set the free entries of rates v and accelerations a so that the rows stay closed; the others are given."""
    nr, nf = len(rows), len(free)
    pose, vel, acc = new_pose(bodies), new_motion(bodies), new_motion(bodies)
    inner, error, found = np.empty((nr, nf)), np.empty(nr), np.empty(nf)
    body_positions(bodies, q, pose)
    free_jacobian(bodies, rows, pose, len(q), free, inner)
    for i in range(nf):
        v[free[i]] = 0.0
        a[free[i]] = 0.0
    body_velocities(bodies, pose, v, vel)
    for k in range(len(rows)):
        error[k] = -row_rate(rows[k], pose, vel)
    solve_columns(inner, error, found)
    for i in range(nf):
        v[free[i]] = found[i]
    body_velocities(bodies, pose, v, vel)
    body_accelerations(bodies, pose, vel, v, a, acc)
    for k in range(len(rows)):
        error[k] = -row_acceleration(rows[k], pose, vel, acc)
    solve_columns(inner, error, found)
    for i in range(nf):
        a[free[i]] = found[i]


@kernel(makes_arrays=True)
def closure_quality(bodies: Bodies, rows: Records, free: Indices, q: Array) -> float:
    """Return the conditioning of the closure: smallest over largest singular value of the Jacobian's free columns.

    It is zero where the linkage is singular or underdetermined.
    """
    nr, nf = len(rows), len(free)
    if nf == 0 or nr == 0:
        return 1.0
    if nr < nf:
        return 0.0
    pose, inner = new_pose(bodies), np.empty((nr, nf))
    body_positions(bodies, q, pose)
    free_jacobian(bodies, rows, pose, len(q), free, inner)
    values = np.empty(nf)
    decompose(inner, np.empty((nr, nf)), values, np.empty((nf, nf)))
    return values[-1] / values[0] if values[0] > 0.0 else 0.0


@kernel
def follow(
    bodies: Bodies,
    rows: Records,
    offset: Array,
    free: Indices,
    size: float,
    q: Array,
    v: Array,
    a: Array,
    quality: Array,
) -> int:
    """Close the rows for a table of prescribed motions, starting from the guess in each line of q (nt, n).

    ``offset`` has a line for each, (nt, nr). Free entries of q, v and a are set, and ``quality`` (nt,), the
    `closure_quality`. Returns the number of lines solved; less than nt where the closure failed.
    """
    for k in range(len(q)):
        if not close(bodies, rows, offset[k], free, size, q[k]):
            return k
        consistent_rates(bodies, rows, free, q[k], v[k], a[k])
        quality[k] = closure_quality(bodies, rows, free, q[k])
    return len(q)


@kernel
def is_straight(step: float, scale: Array, v: Array, a: Array, quality: float) -> bool:
    """Whether a step [s] is short enough for a prediction by rates and accelerations (n,) from a state.

    ``scale`` (n,) are the units of the coordinates. Rates change quickly near a singular position.
    """
    bend, way = 0.0, 0.0
    for i in range(len(v)):
        bend, way = max(bend, abs(a[i] / scale[i])), max(way, abs(v[i] / scale[i]))
    bend, way = 0.5 * step * step * bend, step * way
    return bend <= (_CURVED if quality > BLURRED else min(_CURVED, 0.5 * way))


@kernel(makes_arrays=True)
def follow_branch(
    bodies: Bodies,
    rows: Records,
    free: Indices,
    size: float,
    scale: Array,
    first: int,
    times: Array,
    q: Array,
    v: Array,
    a: Array,
    quality: Array,
) -> int:
    """Close the rows at times (nt,) from line `first` on, each line predicted from the last one of good quality.

    Line ``first - 1`` is known. As `follow`, with the prescribed motions in q, v and a (nt, n). Returns the number of
    lines that are solved; less than nt before a line that is not straight ahead (`is_straight`), or does not close.
    """
    start, offset = first - 1, np.zeros(len(rows))
    for k in range(first, len(times)):
        step = times[k] - times[start]
        if not is_straight(step, scale, v[start], a[start], quality[start]):
            return k
        for i in range(len(free)):
            j = free[i]
            q[k, j] = q[start, j] + step * (v[start, j] + 0.5 * step * a[start, j])
        if not close(bodies, rows, offset, free, size, q[k]):
            return k
        consistent_rates(bodies, rows, free, q[k], v[k], a[k])
        quality[k] = closure_quality(bodies, rows, free, q[k])
        if quality[k] > BLURRED:
            start = k
    return len(times)


@kernel(makes_arrays=True)
def ideal_state(model: Any, dynamics: Any, rows: Records, closing: Indices, ideal: Any) -> bool:
    """Fill the state of the linkage with every joint ideal, at the time and near the state of a run.

    The driven coordinates are the run's, and its state is the first guess. The links are rigid: shape coordinates are
    zero. Takes the closure rows of all cut joints and the coordinates of joints that no drive prescribes; fills q, v,
    a, pose, vel and acc of the workspace ``ideal``. Returns False if the loops do not close there.
    """
    bodies = model.bodies
    copy(dynamics.q, ideal.q)
    copy(dynamics.v, ideal.v)
    copy(dynamics.a, ideal.a)
    for i in range(len(bodies.records)):
        for k in range(bodies.records[i].shapes):
            d = bodies.records[i].eta + k
            ideal.q[d], ideal.v[d], ideal.a[d] = 0.0, 0.0, 0.0
    if not close(bodies, rows, np.zeros(len(rows)), closing, model.size, ideal.q):
        return False
    consistent_rates(bodies, rows, closing, ideal.q, ideal.v, ideal.a)
    body_states(bodies, ideal.q, ideal.v, ideal.pose, ideal.vel)
    body_accelerations(bodies, ideal.pose, ideal.vel, ideal.v, ideal.a, ideal.acc)
    return True
