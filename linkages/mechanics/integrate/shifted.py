"""A real and a complex system of linear equations side by side, as in the iterations of an implicit method.

The first three lanes of `linkages.base.kernel.simd` hold an entry of the real matrix, and the real and imaginary part
of the entry of the complex matrix; the fourth lane is 0. Both matrices have zeros at the same places.

Small matrices are inverted: the product with the inverse is faster than substitution, because fewer operations depend
on each other. Larger ones are factorised, A = L U with a unit diagonal of U, within the envelope of each row: from its
first entry in L to its last in U. The matrix of a chain of links on films has a band along its diagonal only.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Indices, inlined_kernel, kernel
from linkages.base.kernel.simd import LaneArray as Lanes
from linkages.base.kernel.simd import lane, lane_array, lanes, with_lane

SMALL = 14  #: equations of which the matrices are inverted, at most; measured: there both ways take the same time


class Shifted(NamedTuple):
    """Arrays of two systems of k equations."""

    matrix: Lanes  # both matrices; then the `_parts` of the inverses, or of L (its diagonal inverted) and U, (k, k)
    cross: Lanes  # the other parts
    order: Indices  # rows that were exchanged with each row, (k,)
    first: Indices  # first entry of each row of L, (k,)
    last: Indices  # last entry of each row of U, and one, (k,)
    given: Lanes  # right-hand sides, (k,)
    turned: Lanes  # `swapped` numbers of these or of the solution, (k,)
    found: Lanes  # solution, (k,)


def make_shifted(k: int) -> Shifted:
    """Make the arrays for k equations, all zero."""
    order, first, last = (np.zeros(k, np.int64) for _ in range(3))
    return Shifted(lane_array(k, k), lane_array(k, k), order, first, last, lane_array(k), lane_array(k), lane_array(k))


@inlined_kernel
def _swapped(x: Any) -> Any:
    """Exchange the real and the imaginary part."""
    return with_lane(with_lane(x, 1, lane(x, 2)), 2, lane(x, 1))


@inlined_kernel
def _parts(x: Any) -> tuple[Any, Any]:
    """Prepare a product: the lanes that multiply the other number, and the other number `_swapped`."""
    return with_lane(x, 2, lane(x, 1)), lanes(0.0, -lane(x, 2), lane(x, 2), 0.0)


@inlined_kernel
def _product(x: Any, y: Any) -> Any:
    direct, cross = _parts(x)
    return direct * y + cross * _swapped(y)


@inlined_kernel
def _size(x: Any) -> float:
    """Compute the size for the comparison of pivots: the product of both magnitudes."""
    return abs(lane(x, 0)) * (abs(lane(x, 1)) + abs(lane(x, 2)))


@inlined_kernel
def _is_zero(x: Any) -> bool:
    return lane(x, 0) == 0.0 and lane(x, 1) == 0.0 and lane(x, 2) == 0.0


@kernel
def factorise_both(s: Shifted) -> bool:
    """Prepare `solve_both`, by elimination with row interchanges; False if a matrix is singular."""
    n, matrix, cross = len(s.order), s.matrix, s.cross
    whole = n <= SMALL
    for k in range(n):
        s.first[k], s.last[k] = 0, n
        while not whole and s.first[k] < k and _is_zero(matrix[k, s.first[k]]):
            s.first[k] += 1
    for k in range(n):
        if not _find_pivot(s, k):
            return False
        pivot = matrix[k, k]
        first, re, im = 1.0 / lane(pivot, 0), lane(pivot, 1), lane(pivot, 2)
        square = 1.0 / (re * re + im * im)
        inverse = lanes(first, re * square, -im * square, 0.0)
        while not whole and s.last[k] > k + 1 and _is_zero(matrix[k, s.last[k] - 1]):
            s.last[k] -= 1
        start, end = 0 if whole else k + 1, s.last[k]
        matrix[k, k] = lanes(1.0, 1.0, 0.0, 0.0)
        row, turned = matrix[k, start:end], cross[k, start:end]  # indices from 0 are not tested for their signs
        for j in range(len(row)):
            row[j] = _product(inverse, row[j])
            turned[j] = _swapped(row[j])
        for i in range(start, n):
            if i != k and s.first[i] <= k:
                along, across = _parts(matrix[i, k])
                if whole:
                    matrix[i, k] = 0.0
                other = matrix[i, start:end]
                for j in range(len(row)):
                    other[j] -= along * row[j] + across * turned[j]
        if not whole:
            matrix[k, k] = inverse
    for k in range(n - 1 if whole else -1, -1, -1):
        best = s.order[k]
        if best != k:
            for i in range(n):
                matrix[i, k], matrix[i, best] = matrix[i, best], matrix[i, k]
    for i in range(n):
        for j in range(s.first[i], s.last[i]):
            matrix[i, j], cross[i, j] = _parts(matrix[i, j])
    return True


@inlined_kernel
def _find_pivot(s: Shifted, k: int) -> bool:
    """Exchange row k with the one below that has the largest entry in column k; False if there is none."""
    n, matrix = len(s.order), s.matrix
    best, size = k, _size(matrix[k, k])
    for i in range(k + 1, n):
        if s.first[i] <= k and _size(matrix[i, k]) > size:
            best, size = i, _size(matrix[i, k])
    s.order[k] = best
    if best != k:
        s.first[k], s.first[best] = s.first[best], s.first[k]
        for j in range(n):
            matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
    return size > 0.0


@inlined_kernel
def solve_both(s: Shifted) -> None:
    """Solve for the right-hand sides."""
    if len(s.order) > SMALL:
        _substitute(s)
        return
    for i in range(len(s.order)):
        s.turned[i] = _swapped(s.given[i])
    for i in range(len(s.order)):
        s.found[i] = _row_times(s.matrix[i], s.cross[i], s.given, s.turned)


@kernel
def _substitute(s: Shifted) -> None:
    n, matrix, found, turned = len(s.order), s.matrix, s.found, s.turned
    for i in range(n):
        found[i] = s.given[i]
    for k in range(n):
        best = s.order[k]
        found[k], found[best] = found[best], found[k]
    for k in range(n):
        value = found[k] - _row_part(s, k, s.first[k], k)
        found[k] = matrix[k, k] * value + s.cross[k, k] * _swapped(value)
        turned[k] = _swapped(found[k])
    for k in range(n - 1, -1, -1):
        found[k] -= _row_part(s, k, k + 1, s.last[k])
        turned[k] = _swapped(found[k])


@inlined_kernel
def _row_part(s: Shifted, k: int, first: int, last: int) -> Any:
    """Multiply entries of row k by entries of the solution."""
    return _row_times(s.matrix[k, first:last], s.cross[k, first:last], s.found[first:last], s.turned[first:last])


@inlined_kernel
def _row_times(row: Any, cross: Any, x: Any, turned: Any) -> Any:
    """Multiply the parts of a row by a vector, and by this one `_swapped`."""
    direct, other = 0.0, 0.0
    for j in range(len(row)):
        direct += row[j] * x[j]
        other += cross[j] * turned[j]
    return direct + other
