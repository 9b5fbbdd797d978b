"""Natural frequencies and mode shapes, and modes followed by the modal assurance criterion (MAC)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array

if TYPE_CHECKING:  # scipy is slow to import
    from scipy import sparse

_LEAST_MAC, _HALVINGS = 0.9, 10  # MAC below which a step is halved, and most halvings
_SHIFT = -((2.0 * np.pi * 5.0) ** 2)  # (rad/s)^2, below the spectrum: a mechanism's zero modes do not disturb


def dense_modes(k: Array, m: Array, count: int, vectors: bool = True) -> tuple[Array, Array]:
    """Solve K a = p^2 M a for the lowest modes of N systems, (N, size, size); M is positive definite.

    Returns eigenvalues p^2 (N, count) [(rad/s)^2], rising, and shapes (N, size, count) of unit modal mass, which are
    empty without `vectors`.
    """
    inverse = np.linalg.inv(np.linalg.cholesky(m))
    transposed = np.swapaxes(inverse, 1, 2)
    standard = inverse @ k @ transposed
    if not vectors:
        return np.asarray(np.linalg.eigvalsh(standard)[:, :count], float), np.empty((0, 0, 0))
    values, found = np.linalg.eigh(standard)
    return values[:, :count], transposed @ found[:, :, :count]


def sparse_modes(k: sparse.csc_matrix, m: sparse.csc_matrix, count: int) -> tuple[Array, Array]:
    """Solve K a = p^2 M a for the lowest modes of one sparse system, by shift and invert; returns as `dense_modes`."""
    from scipy.sparse.linalg import eigsh

    values, found = eigsh(k, count, m, sigma=_SHIFT, v0=np.ones(k.shape[0]))  # repeatable: a fixed start
    order = np.argsort(values)
    return values[order], found[:, order]


def eigenvalues(m: Array, c: Array, k: Array) -> NDArray[np.complexfloating]:
    """Eigenvalues s (2 size,) of M s^2 + C s + K [rad/s], for any (size, size) matrices with a regular M."""
    from scipy.linalg import eigvals

    zero, one = np.zeros_like(m), np.eye(len(m))
    return eigvals(np.block([[zero, one], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]]))


def mac(first: Array, second: Array, mass: Array) -> Array:
    """Modal assurance criterion (n, m) of shapes (size, n) and (size, m), weighted with the mass matrix."""
    cross = first.T @ mass @ second
    own = np.einsum("sn,st,tn->n", first, mass, first), np.einsum("sn,st,tn->n", second, mass, second)
    return cross**2 / np.outer(*own)


@dataclass(frozen=True)
class ModesAt:
    """Modes of a system that changes with a parameter, at one of its values."""

    parameter: float  # for instance time [s]
    values: Array  # frequencies, or other values of the shapes, (n,)
    shapes: Array  # in the same order, (size, n)
    mass: Array  # mass matrix, (size, size)


def continued(shapes: Array, target: Array, mass: Array, together: int = 0) -> tuple[NDArray[np.int64], Array, Array]:
    """Select the target's modes that continue the given ones (size, n): largest sum of MAC, equal signs.

    The target's modes (size, m) are in any order and with any signs; m >= n. The mass matrix is the target's. The first
    modes `together` have a common frequency, such as the zero modes of a mechanism, and a common space instead of
    individual shapes: the basis of it that is nearest to the given one continues it (orthogonal Procrustes problem).
    Returns indices, shapes, and MAC of the selected modes.
    """
    from scipy.optimize import linear_sum_assignment

    if together:
        left, _, right = np.linalg.svd(target[:, :together].T @ mass @ shapes[:, :together])
        target = np.hstack([target[:, :together] @ left @ right, target[:, together:]])
    table = mac(shapes, target, mass)
    _, order = linear_sum_assignment(-table)
    found = target[:, order]
    signs = np.where(np.einsum("sn,st,tn->n", shapes, mass, found) < 0.0, -1.0, 1.0)
    return order, found * signs, table[np.arange(len(order)), order]


def track(points: Iterable[ModesAt], between: Callable[[float], ModesAt], count: int) -> tuple[Array, Array, Array]:
    """Follow the first `count` modes along a parameter.

    Each point's modes are assigned to the previous point's so that the sum of their MAC is largest, and signs are
    chosen alike; each of the N points has a few more modes than `count`, for crossings. Where a MAC falls below 0.9
    (modes that veer or cross) the step is halved, up to ten times, by the modes `between` two points. Returns values
    (N, count) and shapes (N, size, count) of each mode, and the least MAC within each step (N - 1, count).
    """
    points = iter(points)
    last = next(points)
    found: list[tuple[Array, Array, Array]] = [(last.values[:count], last.shapes[:, :count], np.ones(count))]
    for point in points:
        found.append(_advance(between, found[-1][1], last.parameter, point, _HALVINGS))
        last = point
    values, shapes, quality = (np.array(column) for column in zip(*found, strict=True))
    return values, shapes, quality[1:]


def _advance(
    between: Callable[[float], ModesAt], shapes: Array, start: float, target: ModesAt, halvings: int
) -> tuple[Array, Array, Array]:
    """Carry modes with `shapes` (size, count) from a parameter to the target; the least MAC comes last."""
    order, found, quality = continued(shapes, target.shapes, target.mass)
    if halvings and np.min(quality) < _LEAST_MAC:
        middle = between(0.5 * (start + target.parameter))
        _, shapes, first = _advance(between, shapes, start, middle, halvings - 1)
        values, shapes, second = _advance(between, shapes, middle.parameter, target, halvings - 1)
        return values, shapes, np.minimum(first, second)
    return target.values[order], found, quality
