"""Element matrices in plane axes, as functions of the element's angle.

An element's displacements come as pairs along x and y, which rotate with it, and as rotations of cross-sections, which
do not. The matrix T from plane to element axes is thus I_0 + I_1 cos + J sin of the angle, and T' K T a sum of constant
matrices times 1, cos, sin, cos^2 and cos sin.
"""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array

BEAM = (0, 3)  # indices of the x components in a beam element's six displacements
TRIANGLE = (0, 2, 4)  # in a triangle's displacements


def rotation_parts(pairs: tuple[int, ...]) -> tuple[Array, Array, Array]:
    """I_0, I_1 and J (6, 6) with T = I_0 + I_1 cos + J sin for the displacement pairs that begin at `pairs`."""
    fixed, cosine, sine = np.eye(6), np.zeros((6, 6)), np.zeros((6, 6))
    for i in pairs:
        fixed[i, i] = fixed[i + 1, i + 1] = 0.0
        cosine[i, i] = cosine[i + 1, i + 1] = 1.0
        sine[i, i + 1], sine[i + 1, i] = 1.0, -1.0
    return fixed, cosine, sine


def rotations(angle: Array, pairs: tuple[int, ...] = BEAM) -> Array:
    """Matrices T (N, 6, 6) from plane to element axes at the angles (N,) [rad]."""
    fixed, cosine, sine = rotation_parts(pairs)
    return fixed + np.cos(angle)[:, None, None] * cosine + np.sin(angle)[:, None, None] * sine


def rotated(matrix: Array, pairs: tuple[int, ...]) -> Array:
    """Coefficients (5, 6, 6) of 1, cos, sin, cos^2 and cos sin in T' matrix T, for a symmetric `matrix` (6, 6)."""
    fixed, cosine, sine = rotation_parts(pairs)
    square = sine.T @ matrix @ sine
    return np.stack(
        [
            fixed @ matrix @ fixed + square,
            fixed @ matrix @ cosine + cosine @ matrix @ fixed,
            fixed @ matrix @ sine + sine.T @ matrix @ fixed,
            cosine @ matrix @ cosine - square,
            cosine @ matrix @ sine + sine.T @ matrix @ cosine,
        ]
    )


def functions(angle: Array) -> Array:
    """1, and cos, sin, cos^2, cos sin of each angle: (N, 1 + 4 k) for angles (N, k) [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.concatenate([np.ones((len(angle), 1)), c, s, c * c, c * s], axis=1)
