"""Inverses of a real and of a complex matrix of the same size, computed and applied together.

The first three lanes of `linkages.base.kernel.simd` hold an entry of the real matrix, and the real and imaginary part
of the entry of the complex matrix; the fourth lane is 0. For small matrices the product with the inverse is faster
than back substitution, because fewer operations depend on each other.
"""

from __future__ import annotations

from typing import Any

from linkages.base.kernel import Indices, inlined_kernel, kernel
from linkages.base.kernel.simd import LaneArray as Lanes
from linkages.base.kernel.simd import lane, lanes, with_lane


@inlined_kernel
def swapped(x: Any) -> Any:
    """Exchange the real and the imaginary part."""
    return with_lane(with_lane(x, 1, lane(x, 2)), 2, lane(x, 1))


@inlined_kernel
def _parts(x: Any) -> tuple[Any, Any]:
    """Prepare a product: the lanes that multiply the other number, and the other number `swapped`."""
    return with_lane(x, 2, lane(x, 1)), lanes(0.0, -lane(x, 2), lane(x, 2), 0.0)


@inlined_kernel
def _product(x: Any, y: Any) -> Any:
    direct, cross = _parts(x)
    return direct * y + cross * swapped(y)


@inlined_kernel
def _size(x: Any) -> float:
    """Compute the size for the comparison of pivots: the product of both magnitudes."""
    return abs(lane(x, 0)) * (abs(lane(x, 1)) + abs(lane(x, 2)))


@kernel
def invert(matrix: Lanes, cross: Lanes, order: Indices) -> bool:
    """Invert a matrix (n, n) in place by Gauss-Jordan elimination with row interchanges; False if it is singular.

    Fill `matrix` and `cross` with the `_parts` of the inverse.
    """
    n = len(order)
    for k in range(n):
        best, size = k, _size(matrix[k, k])
        for i in range(k + 1, n):
            if _size(matrix[i, k]) > size:
                best, size = i, _size(matrix[i, k])
        order[k] = best
        if not size > 0.0:
            return False
        if best != k:
            for j in range(n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        pivot = matrix[k, k]
        first, re, im = 1.0 / lane(pivot, 0), lane(pivot, 1), lane(pivot, 2)
        square = 1.0 / (re * re + im * im)
        inverse = lanes(first, re * square, -im * square, 0.0)
        matrix[k, k] = lanes(1.0, 1.0, 0.0, 0.0)
        for j in range(n):
            matrix[k, j] = _product(inverse, matrix[k, j])
            cross[k, j] = swapped(matrix[k, j])
        for i in range(n):
            if i != k:
                along, across = _parts(matrix[i, k])
                matrix[i, k] = 0.0
                for j in range(n):
                    matrix[i, j] -= along * matrix[k, j] + across * cross[k, j]
    for k in range(n - 1, -1, -1):
        best = order[k]
        if best != k:
            for i in range(n):
                matrix[i, k], matrix[i, best] = matrix[i, best], matrix[i, k]
    for i in range(n):
        for j in range(n):
            matrix[i, j], cross[i, j] = _parts(matrix[i, j])
    return True


@inlined_kernel
def row_times(matrix: Lanes, cross: Lanes, i: int, x: Lanes, turned: Lanes) -> Any:
    """Multiply row i of the inverse by a vector x; `turned` holds x `swapped`."""
    direct, other = 0.0, 0.0
    for j in range(len(x)):
        direct += matrix[i, j] * x[j]
        other += cross[i, j] * turned[j]
    return direct + other
