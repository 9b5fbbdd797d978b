"""Reynolds' condition in compiled code: p >= 0, and -div(h^3 grad p) = source where p > 0.

A primal-dual active set (Hintermueller, Ito and Kunisch 2003): solve on the wet cells, dry cells of negative pressure,
wet cells that would gain volume. The matrix is an M-matrix, for which the iteration is monotonic. Lines of cells around
the film follow each other from a dry one. Without a dry line the ring is folded, line i next to line -1 - i.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.arrays import Array, Indices
from linkages.kernel import lazy_kernel

Flags = NDArray[np.bool_]

_ROUND_OFF = 1e-14  # of the largest flow through a face: such a flow wets no cell


def obstacle(
    around: Array, along: Array, start: Array, source: Array, free: NDArray[np.bool_], wet: NDArray[np.bool_]
) -> Array:
    """Find the pressure under Reynolds' condition.

    Parameters
    ----------
    around, along : (n, m) arrays
        Conductance from each cell to the next one around and along; the last along leads to ambient pressure, 0.
    start : (n,) array
        Conductance from the first cell of a line to ambient pressure; zero of a mirror.
    source : (n, m) array
        Volume that appears in each cell.
    free : (n, m) array of bool
        Cells that are not held at p = 0.
    wet : (n, m) array of bool
        Cells with p > 0 of a neighbouring state. Overwritten by the cells of the solution.

    Returns
    -------
    p : (n, m) array

    Raises
    ------
    ArithmeticError
        If the active set does not settle (none is known to fail).
    """
    p = np.zeros_like(source)
    wet &= free
    steps = _settle(around, along, start, source, free, wet, p)
    if steps < 0:
        raise ArithmeticError(f"film: the active set did not settle in {sum(source.shape)} steps")
    return p


@lazy_kernel
def _settle(around: Array, along: Array, start: Array, source: Array, free: Flags, wet: Flags, p: Array) -> int:
    """Iterate; return the number of steps, or -1."""
    n, m = source.shape
    place, band, right = np.zeros(n, np.int64), np.empty((n * m, 2 * m + 1)), np.empty(n * m)
    for step in range(n + m):
        _solve(around, along, start, source, wet, p, place, band, right)
        changed, largest = False, 0.0
        for i in range(n):
            for j in range(m):
                largest = max(largest, (around[i, j] + along[i, j]) * p[i, j])
        for i in range(n):
            for j in range(m):
                if wet[i, j]:
                    keep = p[i, j] > 0.0
                else:
                    keep = free[i, j] and _gain(around, along, source, p, i, j) > _ROUND_OFF * largest
                changed = changed or keep != wet[i, j]
                right[i * m + j] = 1.0 if keep else 0.0
        if not changed:
            return step + 1
        for i in range(n):
            for j in range(m):
                wet[i, j] = right[i * m + j] > 0.0
    return -1


@lazy_kernel
def _gain(around: Array, along: Array, source: Array, p: Array, i: int, j: int) -> float:
    """Volume that a dry cell would gain."""
    n, m = source.shape
    flow = around[i, j] * p[(i + 1) % n, j] + around[i - 1, j] * p[i - 1, j]
    if j > 0:
        flow += along[i, j - 1] * p[i, j - 1]
    if j + 1 < m:
        flow += along[i, j] * p[i, j + 1]
    return source[i, j] + flow


@lazy_kernel
def _solve(
    around: Array,
    along: Array,
    start: Array,
    source: Array,
    wet: Flags,
    p: Array,
    place: Indices,
    band: Array,
    right: Array,
) -> None:
    """Solve on the wet cells by Cholesky's method (L D L^T); `place`, `band` and `right` are scratch."""
    n, m = source.shape
    first = -1  # a dry line
    for i in range(n):
        some = False
        for j in range(m):
            some = some or wet[i, j]
        if not some:
            first = i
    lines = n
    if first < 0:
        for i in range(n):
            place[i] = 2 * i if i < (n + 1) // 2 else 2 * (n - 1 - i) + 1
    else:
        lines = 0
        for k in range(1, n + 1):
            i = (first + k) % n
            some = False
            for j in range(m):
                some = some or wet[i, j]
            place[i] = -1
            if some:
                place[i] = lines
                lines += 1
    width = 2 * m if first < 0 else m
    for row in range(lines * m):
        right[row] = 0.0
        for d in range(width + 1):
            band[row, d] = 0.0
    for i in range(n):
        if place[i] < 0:
            continue
        after = (i + 1) % n
        for j in range(m):
            row = place[i] * m + j
            if not wet[i, j]:
                band[row, 0] = 1.0
                continue
            total = around[i, j] + around[i - 1, j] + along[i, j] + (along[i, j - 1] if j > 0 else start[i])
            band[row, 0], right[row] = total, source[i, j]
            if j + 1 < m and wet[i, j + 1]:
                band[row, 1] -= along[i, j]
            if place[after] >= 0 and wet[after, j]:
                other = place[after] * m + j
                band[min(row, other), abs(other - row)] -= around[i, j]
    _factorise(band, right, lines * m, width)
    for i in range(n):
        for j in range(m):
            p[i, j] = right[place[i] * m + j] if place[i] >= 0 and wet[i, j] else 0.0


@lazy_kernel
def _factorise(band: Array, right: Array, count: int, width: int) -> None:
    """Solve a symmetric banded system in place; entry [k, d] of `band` is that of row k + d, column k."""
    for k in range(count):
        last = min(width, count - 1 - k)
        pivot = 1.0 / band[k, 0]
        for i in range(1, last + 1):
            factor = band[k, i] * pivot
            if factor == 0.0:
                continue
            for d in range(last + 1 - i):
                band[k + i, d] -= factor * band[k, i + d]
            right[k + i] -= factor * right[k]
        right[k] *= pivot
        for i in range(1, last + 1):
            band[k, i] *= pivot
    for k in range(count - 1, -1, -1):
        total = right[k]
        for i in range(1, min(width, count - 1 - k) + 1):
            total -= band[k, i] * right[k + i]
        right[k] = total
