"""Inverses of a matrix at a real and at a complex shift, found and applied at once.

A number of the real system, real and imaginary part of one of the complex system are the first three lanes of
`linkages.kernel.lanes`; the fourth is 0. Small matrices are multiplied by their inverse in fewer steps that wait for
each other than it takes to substitute back.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel import Indices, inlined_kernel, kernel
from linkages.kernel.lanes import LaneArray as Lanes
from linkages.kernel.lanes import lane, lanes, with_lane


@inlined_kernel
def swapped(x: Any) -> Any:
    """Real and imaginary part for each other."""
    return with_lane(with_lane(x, 1, lane(x, 2)), 2, lane(x, 1))


@inlined_kernel
def _parts(x: Any) -> tuple[Any, Any]:
    """Lanes by which another number and that number `swapped` are multiplied, so that the sum is the product."""
    return with_lane(x, 2, lane(x, 1)), lanes(0.0, -lane(x, 2), lane(x, 2), 0.0)


@inlined_kernel
def _product(x: Any, y: Any) -> Any:
    direct, cross = _parts(x)
    return direct * y + cross * swapped(y)


@inlined_kernel
def _size(x: Any) -> float:
    """Size by which pivots are compared: large only if neither number is small beside others in its column."""
    return abs(lane(x, 0)) * (abs(lane(x, 1)) + abs(lane(x, 2)))


@kernel
def invert(matrix: Lanes, cross: Lanes, order: Indices) -> bool:
    """Invert a matrix (n, n) in place, by Gauss and Jordan with interchanges of rows; False if it is singular.

    Leaves the `_parts` of the inverse in `matrix` and `cross`.
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
    """Row i of the inverse times a vector x, of which `turned` are the numbers `swapped`."""
    direct, other = 0.0, 0.0
    for j in range(len(x)):
        direct += matrix[i, j] * x[j]
        other += cross[i, j] * turned[j]
    return direct + other
