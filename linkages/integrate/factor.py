"""LU factorisation of small matrices, real or complex."""

from __future__ import annotations

from typing import Any

from linkages.kernel import kernel


@kernel
def factorise(matrix: Any, pivots: Any) -> bool:
    """Overwrite a matrix (n, n) by its LU factors with row interchanges; False if it is singular."""
    n = len(matrix)
    for k in range(n):
        best, size = k, abs(matrix[k, k])
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > size:
                best, size = i, abs(matrix[i, k])
        pivots[k] = best
        if not size > 0.0:
            return False
        if best != k:
            for j in range(k, n):  # the factors to the left stay: they are applied before this interchange
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            factor = matrix[i, k] * inverse
            matrix[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
    return True


@kernel
def back_substitute(factors: Any, pivots: Any, x: Any) -> None:
    """Solve for a right-hand side x (n,), in place."""
    n = len(x)
    for k in range(n):
        other = pivots[k]
        if other != k:
            x[k], x[other] = x[other], x[k]
        value = x[k]
        for i in range(k + 1, n):
            x[i] -= factors[i, k] * value
    for k in range(n - 1, -1, -1):
        value = x[k]
        for j in range(k + 1, n):
            value -= factors[k, j] * x[j]
        x[k] = value / factors[k, k]
