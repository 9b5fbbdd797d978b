"""The quadratic model of a step of the reduced gradient method: minimum within bounds, update of the Hessian."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

from optim.algorithms.nlp import Array


def bounded_minimum(H: Array, r: Array, Z: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Minimise ``r.v + v.H.v / 2`` subject to ``low <= Z v <= high``.

    H (k, k) is symmetric and positive definite, r (k,), Z (rows, k); ``low <= 0 <= high`` (rows,), infinite where there
    is no bound. Written in ``z = L^T v + L^-1 r`` with ``H = L L^T`` this is a least-distance problem, which is one of
    nonnegative least squares (C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, SIAM 1995, ch. 23).

    Returns v (k,), and multipliers (rows,): positive where `low` holds the step back, negative where `high` does.
    """
    if len(r) == 0 or not np.any(r):
        return np.zeros(len(r)), np.zeros(len(Z))
    L = np.linalg.cholesky(H)
    free = solve_triangular(L, r, lower=True)  # z of v = 0: the farthest that the solution can be
    size = float(np.linalg.norm(free))
    below, above = np.flatnonzero(np.isfinite(low)), np.flatnonzero(np.isfinite(high))
    E = solve_triangular(L, np.vstack([Z[below], -Z[above]]).T, lower=True)
    gaps = np.concatenate([low[below], -high[above]])
    M = np.vstack([E, (gaps + E.T @ free)[None, :] / size])
    norms = np.linalg.norm(M, axis=0)
    norms[norms == 0.0] = 1.0
    target = np.append(np.zeros(len(E)), 1.0)
    weights = np.zeros(M.shape[1])
    if M.shape[1]:
        weights, _ = nnls(M / norms, target, maxiter=100 * M.shape[1])
    residual = target - (M / norms) @ weights
    u = weights / norms / residual[-1] * size
    # E u = z at the solution; its rounding grows as H shrinks, so the active bounds and v are solved for once more
    held = np.flatnonzero(u > 0.0)
    rows = np.vstack([Z[below], -Z[above]])[held]
    v, u[held] = _held_minimum(H, r, rows, gaps[held])
    multipliers = np.zeros(len(Z))
    np.add.at(multipliers, below, u[: len(below)])
    np.subtract.at(multipliers, above, u[len(below) :])
    return v, multipliers


def _held_minimum(H: Array, r: Array, rows: Array, gaps: Array) -> tuple[Array, Array]:
    """Minimise ``r.v + v.H.v / 2`` subject to ``rows v = gaps``: v (k,), and the multipliers of the rows."""
    k, size = len(r), float(max(np.abs(H).max(), np.abs(r).max()))
    K = np.block([[H / size, -rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    found = np.linalg.lstsq(K, np.concatenate([-r / size, gaps]))[0]
    return found[:k], size * found[k:]


def damped_bfgs(H: Array, s: Array, y: Array) -> Array:
    """Update the Hessian by the step `s` and the change `y` of the gradient; it stays positive definite.

    Damped where the curvature along the step is not positive enough: M. J. D. Powell, A fast algorithm for
    nonlinearly constrained optimization calculations, Lecture Notes in Mathematics 630 (1978) 144-157.
    """
    Hs = H @ s
    sHs = float(s @ Hs)
    if sHs <= 0.0:
        return H
    curvature = float(s @ y)
    if curvature < 0.2 * sHs:
        theta = 0.8 * sHs / (sHs - curvature)
        y = theta * y + (1.0 - theta) * Hs
        curvature = float(s @ y)
    H = H - np.outer(Hs, Hs) / sHs + np.outer(y, y) / curvature
    return (H + H.T) / 2.0
