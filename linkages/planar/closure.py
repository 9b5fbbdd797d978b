"""Newton's method on the closure rows: assembly, consistent rates and accelerations."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from linkages.planar.kinematics import (
    body_accelerations,
    body_positions,
    body_velocities,
    row_acceleration,
    row_rate,
    row_value,
)

Array = NDArray[np.float64]

#: Largest closure error of an assembled linkage, relative to its size.
TOLERANCE = 1e-13
_ITERATIONS = 50


@njit(cache=True)
def closure_error(
    bodies: NDArray[np.record], rows: NDArray[np.record], offset: Array, q: Array, pose: Array
) -> Array:
    """Closure errors (nr,) at q less the wanted offsets; fills `pose`."""
    body_positions(bodies, q, pose)
    error = np.empty(len(rows))
    for k in range(len(rows)):
        error[k] = row_value(rows[k], pose) - offset[k]
    return error


@njit(cache=True)
def closure_jacobian(bodies: NDArray[np.record], rows: NDArray[np.record], pose: Array, n: int) -> Array:
    """Exact Jacobian (nr, n) of the closure rows: column i is the rows' rate when only coordinate i moves."""
    jacobian = np.empty((len(rows), n))
    unit, vel = np.zeros(n), np.empty((len(bodies), 3))
    for i in range(n):
        unit[i] = 1.0
        body_velocities(bodies, pose, unit, vel)
        unit[i] = 0.0
        for k in range(len(rows)):
            jacobian[k, i] = row_rate(rows[k], pose, vel)
    return jacobian


@njit(cache=True)
def least_squares(matrix: Array, rhs: Array) -> Array:
    """Solve matrix @ x = rhs; redundant but consistent rows do no harm."""
    m, n = matrix.shape
    if n == 0 or m == 0:
        return np.zeros(n)
    return np.linalg.lstsq(matrix, rhs, 1e-11)[0]  # type: ignore[return-value]


@njit(cache=True)
def close(
    bodies: NDArray[np.record],
    rows: NDArray[np.record],
    offset: Array,
    free: NDArray[np.int64],
    size: float,
    q: Array,
) -> bool:
    """Move the free coordinates of ``q`` (in place) until the rows are closed.

    Newton's method with step halving on the sum of squares. Returns False if it does not converge.

    Parameters
    ----------
    offset : (nr,) array
        Wanted row values [m, rad]; zero closes the joints.
    free : (nf,) array of int
        Coordinates that may move.
    size : float
        Length of the linkage [m], which scales the tolerance.
    """
    pose = np.empty((len(bodies), 5))
    error = closure_error(bodies, rows, offset, q, pose)
    merit = np.sum(error * error)
    for _ in range(_ITERATIONS):
        if np.sqrt(merit) <= TOLERANCE * size:
            return True
        jacobian = closure_jacobian(bodies, rows, pose, len(q))[:, free]
        step = least_squares(jacobian, -error)
        trial = q.copy()
        fraction = 1.0
        improved = False
        while fraction > 1e-4:
            for i in range(len(free)):
                trial[free[i]] = q[free[i]] + fraction * step[i]
            error = closure_error(bodies, rows, offset, trial, pose)
            new = np.sum(error * error)
            if new < merit:
                improved = True
                break
            fraction *= 0.5
        if not improved:  # at round-off, or stuck
            break
        q[:] = trial
        merit = new
    return np.sqrt(merit) <= 1e3 * TOLERANCE * size


@njit(cache=True)
def consistent_rates(
    bodies: NDArray[np.record],
    rows: NDArray[np.record],
    free: NDArray[np.int64],
    q: Array,
    v: Array,
    a: Array,
) -> float:
    """Fill the free entries of rates v and accelerations a so that the rows stay closed.

    Prescribed entries are given. Returns the ratio of the smallest to the largest singular value of the free
    columns of the Jacobian: it is zero where the linkage is singular or has a free motion left.
    """
    nb, n = len(bodies), len(q)
    pose, vel, acc = np.empty((nb, 5)), np.empty((nb, 3)), np.empty((nb, 3))
    body_positions(bodies, q, pose)
    jacobian = closure_jacobian(bodies, rows, pose, n)
    inner = np.ascontiguousarray(jacobian[:, free])
    held_v, held_a = v.copy(), a.copy()
    held_v[free] = 0.0
    held_a[free] = 0.0
    v[free] = least_squares(inner, -(jacobian @ held_v))
    body_velocities(bodies, pose, v, vel)
    body_accelerations(bodies, pose, vel, v, held_a, acc)
    bias = np.empty(len(rows))
    for k in range(len(rows)):
        bias[k] = row_acceleration(rows[k], pose, vel, acc)
    a[free] = least_squares(inner, -bias)
    if len(free) == 0 or len(rows) == 0:
        return 1.0
    if len(rows) < len(free):
        return 0.0
    values = np.linalg.svd(inner)[1]
    return values[-1] / values[0] if values[0] > 0.0 else 0.0


@njit(cache=True)
def follow(
    bodies: NDArray[np.record],
    rows: NDArray[np.record],
    offset: Array,
    free: NDArray[np.int64],
    size: float,
    q: Array,
    v: Array,
    a: Array,
    quality: Array,
) -> int:
    """Close the rows for a table of prescribed motions, starting from the guess in each line of q.

    Parameters
    ----------
    offset : (nt, nr) array
    q, v, a : (nt, n) arrays
        Prescribed entries given, free entries guessed in q; on return all of them.
    quality : (nt,) array
        Filled with the ratio of `consistent_rates`.

    Returns
    -------
    int
        Number of lines solved; less than nt where the closure failed.
    """
    for k in range(len(q)):
        if not close(bodies, rows, offset[k], free, size, q[k]):
            return k
        quality[k] = consistent_rates(bodies, rows, free, q[k], v[k], a[k])
    return len(q)
