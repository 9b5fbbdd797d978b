"""Linear algebra of small matrices: LU factorisation, singular values."""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel
from linkages.base.kernel.simd import LaneArray as Lanes

_ORTHOGONAL = 2.2e-16  # rounding error of the cosine between orthogonal vectors, per entry
_SWEEPS = 30  # largest number of sweeps; six are usual


@kernel
def factorise(matrix: Array, pivots: Indices) -> bool:
    """Overwrite a matrix (n, n) by its LU factors with row interchanges; False if it is singular.

    The diagonal holds the reciprocals of the pivots.
    """
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
            for j in range(k, n):  # the factors to the left are applied before this interchange
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        inverse = 1.0 / matrix[k, k]
        matrix[k, k] = inverse
        for i in range(k + 1, n):
            factor = matrix[i, k] * inverse
            matrix[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
    return True


@kernel
def back_substitute(factors: Array, pivots: Indices, x: Array | Lanes) -> None:
    """Solve for a right-hand side x (n,), or for those in its lanes, in place."""
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
        x[k] = value * factors[k, k]


@kernel(makes_arrays=True)
def decompose(matrix: Array, u: Array, s: Array, vt: Array) -> None:
    """Set the singular value decomposition U (m, k), s (k,), V^T (k, n) of a matrix (m, n), k the smaller of m and n.

    The largest value is first.

    One-sided Jacobi rotations (Golub and Van Loan, Matrix Computations, section 8.6.3) make the rows or the columns,
    whichever are fewer, orthogonal. Small values are as exact as large ones, and LAPACK is not loaded. A zero value has
    zero vectors.
    """
    m, n = matrix.shape
    wide = m < n
    few, many = (m, n) if wide else (n, m)
    rows, turned = np.empty((few, many)), np.empty((few, few))
    for i in range(few):
        for j in range(many):
            rows[i, j] = matrix[i, j] if wide else matrix[j, i]
        for j in range(few):
            turned[i, j] = 1.0 if i == j else 0.0
    for _ in range(_SWEEPS):
        done = True
        for i in range(few):
            for j in range(i + 1, few):
                if _turn(rows[i], rows[j], turned[i], turned[j]):
                    done = False
        if done:
            break
    for i in range(few):
        s[i] = math.sqrt(_product(rows[i], rows[i]))
    for k in range(few):
        i = k
        for j in range(k + 1, few):
            i = j if s[j] > s[i] else i
        s[k], s[i] = s[i], s[k]
        for x in (rows, turned):
            for j in range(x.shape[1]):
                x[k, j], x[i, j] = x[i, j], x[k, j]
        for j in range(many):
            rows[k, j] = rows[k, j] / s[k] if s[k] > 0.0 else 0.0
    left, right = (turned, rows) if wide else (rows, turned)
    for k in range(few):
        for i in range(m):
            u[i, k] = left[k, i]
        for j in range(n):
            vt[k, j] = right[k, j]


@inlined_kernel
def _product(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@kernel
def _turn(a: Array, b: Array, first: Array, second: Array) -> bool:
    """Make two vectors orthogonal by a rotation, and apply it to two others; False if they were orthogonal."""
    aa, bb, ab = _product(a, a), _product(b, b), _product(a, b)
    if not abs(ab) > len(a) * _ORTHOGONAL * math.sqrt(aa) * math.sqrt(bb):
        return False
    half = 0.5 * (bb - aa) / ab
    tangent = math.copysign(1.0, half) / (abs(half) + math.hypot(1.0, half))
    cosine = 1.0 / math.hypot(1.0, tangent)
    sine = tangent * cosine
    for x, y in ((a, b), (first, second)):
        for i in range(len(x)):
            x[i], y[i] = cosine * x[i] - sine * y[i], sine * x[i] + cosine * y[i]
    return True
