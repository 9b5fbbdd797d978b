"""Natural frequencies and mode shapes over poses, and their tracking by the modal assurance criterion."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse.linalg import eigsh

from linkages.three_rrr.branch import Branch
from linkages.three_rrr.kinematics import Motion
from linkages.three_rrr.model import Model

Array = NDArray[np.floating]

DENSE = 80  # up to this many unknowns the dense, batched solver is the faster one (benchmarks/flexible.py)
_BATCH = 64  # poses solved together by the dense solver
_LEAST_MAC, _HALVINGS = 0.9, 10  # when and how often a step between poses is halved
_SHIFT = -((2.0 * np.pi * 5.0) ** 2)  # (rad/s)^2, below the spectrum: a mechanism's zero modes do not disturb


def frequencies(model: Model, state: Motion, count: int | None = None) -> Array:
    """Natural frequencies (N, count) at each pose, rising [Hz]; all of them without a count."""
    return _solve(model, state, count, vectors=False)[0]


def modes(
    model: Model, state: Motion, count: int | None = None, progress: Callable[[float], None] | None = None
) -> tuple[Array, Array]:
    """Frequencies (N, count) [Hz] and shapes (N, size, count), with unit modal mass."""
    return _solve(model, state, count, True, progress)


def _solve(
    model: Model,
    state: Motion,
    count: int | None,
    vectors: bool,
    progress: Callable[[float], None] | None = None,
) -> tuple[Array, Array]:
    count = model.size if count is None else min(count, model.size)
    sparse_pays = model.size > DENSE and count < model.size // 4
    values = np.empty((len(state), count))
    shapes = np.empty((len(state), model.size, count) if vectors else (0, 0, 0))
    step = 1 if sparse_pays else _BATCH if model.size <= DENSE else 4
    for start in range(0, len(state), step):
        part = slice(start, start + step)
        if sparse_pays:
            values[start], found = _sparse(model, state.part(part), count)
        else:
            values[part], found = dense(*model.matrices(state.part(part)), count, vectors)
        if vectors:
            shapes[part] = found
        if progress is not None:
            progress(min(start + step, len(state)) / len(state))
    return np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi), shapes


def dense(k: Array, m: Array, count: int, vectors: bool = True) -> tuple[Array, Array]:
    """Smallest eigenvalues (N, count) of K a = p^2 M a and vectors (N, size, count), unit mass."""
    inverse = np.linalg.inv(np.linalg.cholesky(m))
    transposed = np.swapaxes(inverse, 1, 2)
    standard = inverse @ k @ transposed
    if not vectors:
        return np.linalg.eigvalsh(standard)[:, :count], np.empty((0, 0, 0))
    values, found = np.linalg.eigh(standard)
    return values[:, :count], transposed @ found[:, :, :count]


def _sparse(model: Model, state: Motion, count: int) -> tuple[Array, Array]:
    k, m = next(iter(model.sparse_matrices(state)))
    start = np.ones(model.size)  # a fixed start makes the result repeatable
    values, found = eigsh(k, count, m, sigma=_SHIFT, v0=start)
    order = np.argsort(values)
    return values[order], found[:, order]


def mac(first: Array, second: Array, mass: Array) -> Array:
    """Modal assurance criterion (n, m) of shapes (size, n) and (size, m), weighted with the mass matrix."""
    cross = first.T @ mass @ second
    own = np.einsum("sn,st,tn->n", first, mass, first), np.einsum("sn,st,tn->n", second, mass, second)
    return cross**2 / np.outer(*own)


def track(
    model: Model, branch: Branch, state: Motion, values: Array, shapes: Array, count: int
) -> tuple[Array, Array, Array]:
    """Follow modes from pose to pose.

    Each pose's modes are assigned to those of the pose before so that the sum of their MAC is largest, and
    their signs are chosen alike. Where a MAC falls below 0.9 (modes that veer or cross) the step is halved,
    up to ten times.

    Parameters
    ----------
    branch : Branch
        Supplies the poses in between.
    values, shapes : (N, n), (N, size, n) arrays
        Rising frequencies and their shapes; n should exceed `count` by a few, for modes that cross.
    count : int
        Number of modes to follow from the first pose.

    Returns
    -------
    (N, count), (N, size, count), (N - 1, count) arrays
        Frequencies and shapes of each mode, and the least MAC within each step.
    """
    tracked, forms, quality = [values[0, :count]], [shapes[0][:, :count]], []
    for n in range(1, len(state)):
        one = state.part(slice(n, n + 1))
        target = one, values[n], shapes[n]
        found, form, least = _advance(model, branch, forms[-1], float(state.time[n - 1]), target, _HALVINGS)
        tracked.append(found)
        forms.append(form)
        quality.append(least)
    return np.array(tracked), np.array(forms), np.array(quality).reshape(-1, count)


def _advance(
    model: Model, branch: Branch, form: Array, time: float, target: tuple[Motion, Array, Array], halvings: int
) -> tuple[Array, Array, Array]:
    """Carry modes `form` (size, count) from a time to the target's; least MAC comes last."""
    state, values, shapes = target
    _, mass = model.matrices(state)
    table = mac(form, shapes, mass[0])
    _, order = linear_sum_assignment(-table)
    quality = table[np.arange(len(order)), order]
    if halvings and np.min(quality) < _LEAST_MAC:
        middle = 0.5 * (time + float(state.time[0]))
        between = branch.motion(np.array([middle]))
        found = modes(model, between, shapes.shape[1])
        _, form, first = _advance(
            model, branch, form, time, (between, found[0][0], found[1][0]), halvings - 1
        )
        frequency, form, second = _advance(model, branch, form, middle, target, halvings - 1)
        return frequency, form, np.minimum(first, second)
    signs = np.where(np.einsum("sn,st,tn->n", form, mass[0], shapes[:, order]) < 0.0, -1.0, 1.0)
    return values[order], shapes[:, order] * signs, quality
