"""Body angles, and matrices that turn with them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.three_rrr.kinematics import Motion

Array = NDArray[np.floating]


def angles(state: Motion) -> Array:
    """Return the seven body angles (N, 7) [rad]."""
    pairs = np.stack([state.phi, state.psi], axis=-1).reshape(len(state), 6)
    return np.concatenate([pairs, state.x[:, :1]], axis=1)


def functions(angle: Array) -> Array:
    """1, cos, sin, cos^2 and cos sin of each angle: (N, 1 + 4 k) for angles (N, k)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.concatenate([np.ones((len(angle), 1)), c, s, c * c, c * s], axis=1)


def expand_rotation(matrix: Array, turning: NDArray[np.bool_]) -> Array:
    """Coefficients (5, m, m) of 1, cos, sin, cos^2, cos sin in T' matrix T, eq. (9).

    T turns pairs of displacements from plane into element axes, and leaves those marked in `turning` (m,)
    alone.
    """
    size = len(matrix)
    fixed, cosine, sine = (
        np.diag(turning.astype(float)),
        np.diag((~turning).astype(float)),
        np.zeros((size, size)),
    )
    first = [i for i in range(size - 1) if not turning[i] and not turning[i + 1]]
    for i in first if size == 6 and turning.any() else range(0, size, 2):
        sine[i, i + 1], sine[i + 1, i] = 1.0, -1.0
    once = fixed @ matrix @ cosine
    half = fixed @ matrix @ sine
    square = sine.T @ matrix @ sine
    return np.stack(
        [
            fixed @ matrix @ fixed + square,
            once + cosine @ matrix @ fixed,
            half + sine.T @ matrix @ fixed,
            cosine @ matrix @ cosine - square,
            cosine @ matrix @ sine + sine.T @ matrix @ cosine,
        ]
    )


def element_rotations(angle: Array) -> Array:
    """Matrices (N, 6, 6) from plane to element axes, the paper's L of eq. (9)."""
    c, s = np.cos(angle), np.sin(angle)
    result = np.zeros((len(angle), 6, 6))
    for i in (0, 3):
        result[:, i, i], result[:, i, i + 1] = c, s
        result[:, i + 1, i], result[:, i + 1, i + 1] = -s, c
        result[:, i + 2, i + 2] = 1.0
    return result
