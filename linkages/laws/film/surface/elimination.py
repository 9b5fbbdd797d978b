"""Banded systems of equations of films, solved without pivots: their columns are diagonally dominant.

Compiled, in one thread: LAPACK's solver takes up to 20 times as long where BLAS divides its small blocks among threads.
"""

from __future__ import annotations

from linkages.kernel import Array, kernel


@kernel
def eliminate(band: Array, right: Array) -> None:
    """Solve a banded system in place.

    Parameters
    ----------
    band : (n, 2 w + 1) array
        Entry [r, w + c - r] is the one of row r, column c; overwritten.
    right : (n,) array
        Right-hand side; becomes the solution, not finite if the matrix is singular.
    """
    count, width = band.shape[0], band.shape[1] // 2
    for k in range(count):
        last = min(width, count - 1 - k)
        pivot = 1.0 / band[k, width]
        upper = band[k, width + 1 : width + 1 + last]
        for d in range(1, last + 1):
            factor = band[k + d, width - d] * pivot
            if factor != 0.0:
                row = band[k + d, width - d + 1 : width - d + 1 + last]
                for e in range(last):
                    row[e] -= factor * upper[e]
                right[k + d] -= factor * right[k]
    for k in range(count - 1, -1, -1):
        total = right[k]
        for d in range(1, min(width, count - 1 - k) + 1):
            total -= band[k, width + d] * right[k + d]
        right[k] = total / band[k, width]
