"""Linear algebra of least squares."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from optim.identify.numerics import ALGEBRA_INDEPENDENT, TINY


def regression(columns: Array, wanted: Array) -> Array:
    """Return the least coefficients with which columns (n, k) come closest to wanted numbers (n,)."""
    if not np.isfinite(columns).all() or not np.isfinite(wanted).all():
        return np.zeros(columns.shape[1])
    scale = np.maximum(np.linalg.norm(columns, axis=0), TINY)
    return np.asarray(np.linalg.lstsq(columns / scale, wanted, rcond=None)[0] / scale, np.float64)


def inverse(jacobian: Array) -> tuple[Array, Array]:
    """Return sides (r, k) and root (k, k): root @ sides.T is the inverse of derivatives (r, k).

    The covariance is root @ root.T; directions on which no residual depends are very uncertain.
    """
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), TINY)
    sides, singular, rows = np.linalg.svd(jacobian / scale, full_matrices=False)
    root = (rows / np.maximum(singular, ALGEBRA_INDEPENDENT)[:, None]).T / scale[:, None]
    return np.asarray(sides, np.float64), np.asarray(root, np.float64)


def complement(columns: Array, rows: Array) -> Array:
    """Return rows (n, ...) without their parts along columns (n, k)."""
    scale = np.maximum(np.linalg.norm(columns, axis=0), TINY)
    sides, size, _ = np.linalg.svd(columns / scale, full_matrices=False)
    basis = sides[:, size > ALGEBRA_INDEPENDENT]
    return np.asarray(rows - basis @ (basis.T @ rows), np.float64)
