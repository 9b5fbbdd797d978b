"""Displacements under loads over time: quasi-static, the exact step of a mode, generalised-alpha."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from linkages.base.arrays import Array
from linkages.base.errors import InputError

BATCH = 256  # most times whose matrices are in memory
_FREE = 1e-8  # (p t)^2 below which a mode counts as free: the errors of 1 - cos and of the limit are alike there


def quasi_static(k: Array | sparse.csc_matrix, load: Array) -> Array:
    """Solve K u = f, without inertia: (N, size, size) and (N, size) arrays, or a sparse matrix and a (size,) array."""
    return spsolve(k, load) if sparse.issparse(k) else np.linalg.solve(k, load[..., None])[..., 0]


def modal_step(
    square: Array, alpha: float, beta: float, q: Array, dq: Array, force: Array, step: float
) -> tuple[Array, Array]:
    """Exact solution of q'' + (alpha + beta p^2) q' + p^2 q = force after a step [s], for each of n modes of unit mass.

    A mode without stiffness moves as a free mass: with p -> 0, (1 - cos p t)/p^2 -> t^2/2. `square` is p^2 [(rad/s)^2],
    zero, but for rounding, for rigid motion; `alpha` [1/s] and `beta` [s] are Rayleigh's damping coefficients; the
    modal forces are constant. Returns q and q'.
    """
    decay = 0.5 * (alpha + beta * square)
    inner = np.sqrt((square - decay**2).astype(complex))
    inner = np.where(np.abs(inner) < 1e-12, 1e-12, inner)
    first = -decay + 1j * inner  # the faster root of a mode that does not swing
    second = np.where(decay**2 > square, square / np.where(first == 0.0, 1.0, first), -decay - 1j * inner)
    one, other = np.exp(first * step), np.exp(second * step)
    c, s = np.real(one + other) / 2.0, np.real((one - other) / (2j * inner))
    free, x = np.abs(square) * step**2 < _FREE, 2.0 * decay * step
    drift = np.where(x < 1e-4, 0.5 - x / 6.0, (x + np.expm1(-x)) / np.where(x == 0.0, 1.0, x) ** 2) * step**2
    moved = np.where(free, drift, (1.0 - c - decay * s) / np.where(free, 1.0, square))  # by a unit force
    rate = dq * (c - decay * s) + (force - square * q) * s
    return q * (c + decay * s) + dq * s + force * moved, rate


def generalised_alpha(
    matrices: Callable[[Array], tuple[Array, Array, Array, Array]], times: Array, u0: Array, v0: Array, radius: float
) -> Iterator[tuple[Array, Array, Array]]:
    """Integrate M(t) u'' + C(t) u' + K(t) u = f(t), to second order in the step (Chung and Hulbert, 1993).

    `matrices` gives M, C, K (n, size, size) and f (n, size) at any times (n,); the `times` (N,) are equally spaced [s].
    Yields u, u' and u'' (n, size) at the next n of the times: only `BATCH` times are held at once, so that memory does
    not grow with the number of steps. The spectral radius at infinite frequency is in [0, 1]: 1 keeps all energy, 0
    damps the highest modes at once; InputError for others.
    """
    if not 0.0 <= radius <= 1.0:
        raise InputError("generalised-alpha", "radius", f"is {radius:g}; it must lie in [0, 1]")
    am, af = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
    gamma = 0.5 - am + af
    beta = 0.25 * (1.0 - am + af) ** 2
    h = float(times[1] - times[0])
    m, c, k, f = (matrix[0] for matrix in matrices(times[:1]))
    start = np.array([u0, v0, np.linalg.solve(m, f - k @ u0 - c @ v0)])
    yield start[0, None], start[1, None], start[2, None]
    for first in range(0, len(times) - 1, BATCH):
        last = min(first + BATCH, len(times) - 1)
        m, c, k, f = matrices(times[first:last] + (1.0 - af) * h)
        inverse = np.linalg.inv((1 - am) * m + (1 - af) * h * (gamma * c + beta * h * k))
        u, v, a = block = np.empty((3, last - first + 1, len(u0)))
        block[:, 0] = start
        for n in range(last - first):
            drift_u = u[n] + h * v[n] + (0.5 - beta) * h * h * a[n]
            drift_v = v[n] + (1.0 - gamma) * h * a[n]
            held = am * (m[n] @ a[n])
            held += c[n] @ ((1 - af) * drift_v + af * v[n]) + k[n] @ ((1 - af) * drift_u + af * u[n])
            a[n + 1] = inverse[n] @ (f[n] - held)
            u[n + 1] = drift_u + beta * h * h * a[n + 1]
            v[n + 1] = drift_v + gamma * h * a[n + 1]
        yield u[1:], v[1:], a[1:]
        start = block[:, -1]
