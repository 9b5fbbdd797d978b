"""Equations of the closure rows' reactions: which rows influence each other, elimination, solution.

The matrix of the equations is A M^-1 A^T, with the Jacobian A of the rows and the mass matrix M. The entry of two rows
is zero if no free coordinate carries ends of both: of loops in series on the ground, each meets its two neighbours; of
loops on top of each other, all meet. Rows are eliminated in an order that couples few others, which is found once for a
linkage, and kernels visit no zeros.

The matrix is positive semi-definite, singular where rows are redundant. A row whose pivot has cancelled waits until the
others are eliminated; such rows, and all rows of linkages with few, are then pivoted by size.
"""

from __future__ import annotations

import math
from functools import cache, reduce
from itertools import accumulate
from operator import or_
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, Records, inlined_kernel, lazy_kernel
from linkages.base.kernel.by_reference import packed
from linkages.mechanics.planar.bodies import Bodies

_FEW = 8  # most rows that are all pivoted by size: an order saves no time
_DEPENDENT = 1e-12  # largest pivot of a dependent row, in parts of the largest entry
_CANCELLED = 1e-3  # a pivot below this part of the row's own entry waits: its rounding errors stay below the former


class Lists(NamedTuple):
    """Lists of indices: list k has the entries ``first[k]`` to ``first[k + 1]``."""

    entries: Indices
    first: Indices


class Elimination(NamedTuple):
    """Structure of the equations of nr closure rows; `elimination_of` makes it."""

    rank: int  # number of independent rows outside singular positions
    carriers: Lists  # bodies that carry the ends of each row and are moved by free coordinates, outer ones first
    coordinates: Lists  # their free coordinates
    later: Lists  # rows after each row in the order that its elimination, or those before, couple with it
    order: Indices  # rows in the order of elimination, (nr,); empty if all rows are pivoted by size


class Pivots(NamedTuple):
    """State of an elimination of nr rows."""

    order: Indices  # rows with a pivot, as eliminated, (nr,)
    near: Indices  # rows from which each of these is eliminated, (nr, nr)
    nears: Indices  # their number, (nr,)
    inverse: Array  # reciprocals of the pivots, (nr,)
    diagonal: Array  # entries of the rows before the elimination, (nr,)
    waiting: Indices  # rows that wait; at the end those with a pivot come first, (nr,)
    waits: Indices  # 1 for rows that wait, (nr,)
    counts: Indices  # numbers of pivots, of rows that wait, (2,)


_PIVOTS, _WAITING = range(2)


def make_pivots(nr: int) -> Pivots:
    """Make the arrays for nr rows, all zero."""
    order, nears, waiting, waits = (
        np.zeros(nr, np.int64),
        np.zeros(nr, np.int64),
        np.zeros(nr, np.int64),
        np.zeros(nr, np.int64),
    )
    counts = np.zeros(2, np.int64)
    return Pivots(order, np.zeros((nr, nr), np.int64), nears, np.zeros(nr), np.zeros(nr), waiting, waits, counts)


# -- structure ---------------------------------------------------------------------------------------------------------


def elimination_of(bodies: Bodies, rows: Records, rank: int, free: Indices) -> Elimination:
    """Find which rows influence each other, and the order of their elimination, by the minimum degree.

    Parameters
    ----------
    bodies : Bodies
        The tree.
    rows : (nr,) array of records
        Closure rows.
    rank : int
        Number of independent rows.
    free : (nf,) array of int
        Coordinates that may move.
    """
    if not len(rows):
        return _no_rows()
    carriers, own = _carriers(bodies, rows), _coordinates(bodies, set(free.tolist()))
    coordinates = [[c for body in bodies_of_row for c in own[body]] for bodies_of_row in carriers]
    order, later = list[int](), [[*range(k + 1, len(rows))] for k in range(len(rows))]
    if len(rows) > _FEW:
        order, later = _minimum_degree(_coupled(coordinates))
    lists = _lists(carriers), _lists(coordinates), _lists(later)
    return packed(Elimination(rank, *lists, np.array(order, np.int64)))


@cache
def _no_rows() -> Elimination:
    none = _lists([])
    return packed(Elimination(0, none, none, none, none.entries))


def _carriers(bodies: Bodies, rows: Records) -> list[list[int]]:
    """Return the moving bodies that carry the ends of each row, outer ones first."""
    parent, moving = bodies.records["mount"]["body"].tolist(), bodies.records["moving"].tolist()
    terms = [rows[name][end]["body"].tolist() for name in ("term", "other") for end in ("a", "b")]
    found = []
    for ends in zip(*terms, strict=True):  # a row without another term has the world there
        carriers = set()
        for body in ends:
            while moving[body] and body not in carriers:
                carriers.add(body)
                body = parent[body]
        found.append(sorted(carriers, reverse=True))
    return found


def _coordinates(bodies: Bodies, free: set[int]) -> list[list[int]]:
    """Return the free coordinates of each body: that of its joint, its shapes."""
    columns = (bodies.records[name].tolist() for name in ("dof", "eta", "shapes"))
    return [
        [c for c in (dof, *range(eta, eta + shapes)) if c in free] for dof, eta, shapes in zip(*columns, strict=True)
    ]


def _coupled(coordinates: list[list[int]]) -> list[int]:
    """Return the other rows, as bits, that share coordinates with each row."""
    met: dict[int, int] = {}
    for k, own in enumerate(coordinates):
        for c in own:
            met[c] = met.get(c, 0) | 1 << k
    return [reduce(or_, [met[c] for c in own], 0) & ~(1 << k) for k, own in enumerate(coordinates)]


def _minimum_degree(beside: list[int]) -> tuple[list[int], list[list[int]]]:
    """Eliminate the row that meets the fewest others, again and again; return the order and the rows it meets then."""
    beside, left, order, later = beside.copy(), set(range(len(beside))), list[int](), [[0]] * len(beside)
    while left:
        row = min(left, key=lambda k: (beside[k].bit_count(), k))
        left.remove(row)
        order.append(row)
        later[row] = [k for k in left if beside[row] >> k & 1]
        for k in later[row]:
            beside[k] = (beside[k] | beside[row]) & ~(1 << k | 1 << row)
    return order, later


def _lists(lists: list[list[int]]) -> Lists:
    first = accumulate((len(entries) for entries in lists), initial=0)
    return Lists(np.array([entry for entries in lists for entry in entries], np.int64), np.array([*first], np.int64))


# -- equations ---------------------------------------------------------------------------------------------------------


@lazy_kernel
def set_row_matrix(
    rows: Records, elimination: Elimination, forces: Array, pushes: Array, matrix: Array, pivots: Pivots
) -> None:
    """Set the matrix (nr, nr) of rows multiplied by their scales: products of ``forces`` and ``pushes`` (nr, n).

    Entries are set where ``elimination`` couples rows; the others are zero, unless rows have waited before.
    """
    coordinates, later = elimination.coordinates, elimination.later
    if len(elimination.order) and pivots.counts[_WAITING] > 0:
        matrix[:] = 0.0
    for k in range(len(rows)):
        matrix[k, k] = rows[k].scale * rows[k].scale * _product(coordinates, k, forces[k], pushes[k])
        for place in range(later.first[k], later.first[k + 1]):
            m = later.entries[place]
            size = rows[k].scale * rows[m].scale * _product(coordinates, k, forces[k], pushes[m])
            matrix[k, m], matrix[m, k] = size, size


@inlined_kernel
def _product(coordinates: Lists, k: int, force: Array, push: Array) -> float:
    """Sum the products of entries in the coordinates of row k."""
    total = 0.0
    for place in range(coordinates.first[k], coordinates.first[k + 1]):
        i = coordinates.entries[place]
        total += force[i] * push[i]
    return total


@lazy_kernel
def factorise_rows(elimination: Elimination, matrix: Array, pivots: Pivots) -> float:
    """Eliminate the rows in place; returns their conditioning.

    It is the square root of the smallest of so many pivots as the rank, relative to the largest diagonal entry.
    """
    counts, waiting, scale, smallest = pivots.counts, pivots.waiting, 0.0, math.inf
    for k in range(len(matrix)):
        pivots.diagonal[k], pivots.waits[k] = matrix[k, k], 0
        scale = max(scale, matrix[k, k])
    counts[_PIVOTS], counts[_WAITING] = 0, 0
    for k in range(len(elimination.order)):
        p = elimination.order[k]
        size = matrix[p, p]
        if _DEPENDENT * scale < size < _CANCELLED * pivots.diagonal[p]:
            _wait(pivots, p)
        elif size > _DEPENDENT * scale:
            smallest = min(smallest, size)
            _eliminate(elimination.later, matrix, pivots, p, 0)
    if not len(elimination.order):
        for p in range(len(matrix)):
            _wait(pivots, p)
    for k in range(counts[_WAITING]):
        best = k
        for i in range(k + 1, counts[_WAITING]):
            if matrix[waiting[i], waiting[i]] > matrix[waiting[best], waiting[best]]:
                best = i
        waiting[k], waiting[best] = waiting[best], waiting[k]
        size = matrix[waiting[k], waiting[k]]
        if size <= _DEPENDENT * scale:
            break
        if counts[_PIVOTS] < elimination.rank:
            smallest = min(smallest, size)
        _eliminate(elimination.later, matrix, pivots, waiting[k], k + 1)
    if counts[_PIVOTS] < elimination.rank:
        return 0.0
    return math.sqrt(smallest / scale) if elimination.rank else 1.0


@inlined_kernel
def _wait(pivots: Pivots, p: int) -> None:
    pivots.waiting[pivots.counts[_WAITING]], pivots.waits[p] = p, 1
    pivots.counts[_WAITING] += 1


@lazy_kernel
def _eliminate(later: Lists, matrix: Array, pivots: Pivots, p: int, start: int) -> None:
    """Eliminate row p from the rows after it, and from the waiting rows from place ``start`` on."""
    k, count = pivots.counts[_PIVOTS], 0
    near, inverse = pivots.near[k], 1.0 / matrix[p, p]
    if not pivots.waits[p]:
        for place in range(later.first[p], later.first[p + 1]):
            r = later.entries[place]
            if matrix[p, r] != 0.0 and not pivots.waits[r]:
                near[count] = r
                count += 1
    for i in range(start, pivots.counts[_WAITING]):
        r = pivots.waiting[i]
        if matrix[p, r] != 0.0:
            near[count] = r
            count += 1
    for i in range(count):
        r = near[i]
        factor = matrix[p, r] * inverse
        for j in range(count):
            matrix[r, near[j]] -= factor * matrix[p, near[j]]
    pivots.order[k], pivots.nears[k], pivots.inverse[k] = p, count, inverse
    pivots.counts[_PIVOTS] += 1


@lazy_kernel
def solve_rows(rows: Records, matrix: Array, pivots: Pivots, error: Array, reaction: Array) -> None:
    """Find the reactions (nr,) that change the rows by ``error`` (nr,), which is used up; dependent rows get none.

    Takes the matrix and the pivots from `factorise_rows`.
    """
    for k in range(len(rows)):
        error[k] *= rows[k].scale
        reaction[k] = 0.0
    for k in range(pivots.counts[_PIVOTS]):
        p, near = pivots.order[k], pivots.near[k]
        part = error[p] * pivots.inverse[k]
        for i in range(pivots.nears[k]):
            error[near[i]] -= matrix[p, near[i]] * part
    for k in range(pivots.counts[_PIVOTS] - 1, -1, -1):
        p, near = pivots.order[k], pivots.near[k]
        total = error[p]
        for i in range(pivots.nears[k]):
            total -= matrix[p, near[i]] * reaction[near[i]]
        reaction[p] = total * pivots.inverse[k]
    for k in range(len(rows)):
        reaction[k] *= rows[k].scale
