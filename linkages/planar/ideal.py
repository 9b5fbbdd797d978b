"""State of the linkage with every joint ideal, at the time and near the state of a run."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.integrate.factor import back_substitute, factorise
from linkages.kernel import kernel
from linkages.planar.closure import closure_jacobian, decompose, free_columns, least_squares
from linkages.planar.kinematics import (
    body_accelerations,
    body_positions,
    body_velocities,
    row_acceleration,
    row_value,
)

Array = NDArray[np.float64]

_ROUNDS = 8
_CLOSED = 1e-13  # of the linkage's length


class Ideal(NamedTuple):
    """Arrays of the ideal linkage: closure rows of all cut joints, and what `ideal_state` fills."""

    rows: NDArray[np.record]
    q: Array
    v: Array
    a: Array
    pose: Array
    vel: Array
    acc: Array


def make_ideal(rows: NDArray[np.record], nb: int, n: int) -> Ideal:
    """Make the arrays for nb bodies and n coordinates."""
    shape = (nb, 3)
    return Ideal(
        rows, np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((nb, 5)), np.zeros(shape), np.zeros(shape)
    )


@kernel
def ideal_state(model: Any, dynamics: Any, ideal: Any) -> bool:
    """Fill the ideal linkage's state at the driven coordinates of the run's state, which is the first guess.

    Returns False if the loops do not close there.
    """
    rows, free, n = ideal.rows, model.free, len(ideal.q)
    nf, nr = len(free), len(rows)
    for i in range(n):
        ideal.q[i] = dynamics.q[i]
        ideal.v[i] = dynamics.v[i]
        ideal.a[i] = dynamics.a[i]
    for i in range(nf):
        ideal.v[free[i]] = 0.0
        ideal.a[free[i]] = 0.0
    error = np.empty(nr)
    closed = False
    body_positions(model.bodies, ideal.q, ideal.pose)
    inner = closure_jacobian(model.bodies, rows, ideal.pose, n)
    for _ in range(_ROUNDS):
        worst = 0.0
        for k in range(nr):
            error[k] = -row_value(rows[k], ideal.pose)
            worst = max(worst, abs(error[k]))
        if worst <= _CLOSED * model.size:
            closed = True
            break
        step = _solve(inner, free, error)
        for i in range(nf):
            ideal.q[free[i]] += step[i]
        body_positions(model.bodies, ideal.q, ideal.pose)
        inner = closure_jacobian(model.bodies, rows, ideal.pose, n)
    if not closed:
        return False
    for k in range(nr):
        error[k] = 0.0
        for i in range(n):
            error[k] -= inner[k, i] * ideal.v[i]
    rates = _solve(inner, free, error)
    for i in range(nf):
        ideal.v[free[i]] = rates[i]
    body_velocities(model.bodies, ideal.pose, ideal.v, ideal.vel)
    body_accelerations(model.bodies, ideal.pose, ideal.vel, ideal.v, ideal.a, ideal.acc)
    for k in range(nr):
        error[k] = -row_acceleration(rows[k], ideal.pose, ideal.vel, ideal.acc)
    seconds = _solve(inner, free, error)
    for i in range(nf):
        ideal.a[free[i]] = seconds[i]
    body_accelerations(model.bodies, ideal.pose, ideal.vel, ideal.v, ideal.a, ideal.acc)
    return True


@kernel
def _solve(jacobian: Array, free: NDArray[np.int64], rhs: Array) -> Array:
    """Solve for the free coordinates: by LU if there are as many rows, else by least squares."""
    nr, nf = len(rhs), len(free)
    if nr == nf:
        matrix, x = free_columns(jacobian, free), rhs.copy()
        pivots = np.empty(nf, np.int64)
        if factorise(matrix, pivots):
            back_substitute(matrix, pivots, x)
            return x
    return least_squares(decompose(free_columns(jacobian, free)), rhs)
