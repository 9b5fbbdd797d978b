"""Return to the constraints: choice of the basic variables, and Newton's method in them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from optim.algorithms.nlp import Array
from optim.algorithms.standard_form import Partition, StandardForm

#: Corrections before a trial point is given up, and the least that two of them must do: they converge fast or not.
NEWTON_STEPS, SLOWEST = 12, 0.5
#: Pivot that counts as zero.
SMALLEST_PIVOT = 1e-9
#: A basis is kept while no exchange makes a weighted pivot so many times larger.
GAIN = 10.0


class Restored(NamedTuple):
    """A point on the constraints.

    Attributes
    ----------
    y : (n + m,) array
        Variables and slacks.
    f : float
        Objective.
    residual : (m,) array
        What the equations lack, within the tolerance.
    partition : Partition
        That it was reached with.
    """

    y: Array
    f: float
    residual: Array
    partition: Partition


def choose_partition(A: Array, room: Array, current: Partition) -> Partition:
    """Choose basic variables that are independent and far from their bounds.

    Columns of the Jacobian are weighted by the room of their variables. As long as there is an exchange that
    makes the weighted determinant of the basis more than ten times larger, the largest one is made; so the
    partition stays while it is good, and there is an end to it.

    Parameters
    ----------
    A : (m, n + m) array
    room : (n + m,) array
        Scaled distance of each variable to the nearer bound.
    current : Partition
        Its basis is regular.
    """
    weights = np.clip(room, 1e-8, 1.0)
    while len(current.basic):
        pivots = np.abs(current.tangents(A)[current.basic])
        gains = pivots * weights[current.nonbasic] / weights[current.basic, None]
        row, column = np.unravel_index(np.argmax(gains), gains.shape)
        if not gains[row, column] > GAIN:
            break
        current = current.exchange(int(row), int(column))
    return current


def restore(
    form: StandardForm, A: Array, y: Array, partition: Partition, low: Array, high: Array, tolerance: float
) -> Restored | None:
    """Correct the basic variables until the equations hold.

    Newton's method with the Jacobian `A` of a point nearby, improved by Broyden's updates from the residuals.
    A basic variable that leaves its bounds is set on the bound and changes places with the nonbasic variable
    that has the largest pivot times room, and the correction goes on.

    Parameters
    ----------
    form : StandardForm
    A : (m, n + m) array
    y : (n + m,) array
        Trial point; its nonbasic variables lie within the bounds.
    partition : Partition
    low, high : (n + m,) arrays
        Bounds that the point must keep.
    tolerance : float
        Tolerance of the scaled equations.

    Returns
    -------
    Restored or None
        None if the correction does not converge, or an evaluation failed.
    """
    y, n = y.copy(), form.n
    settled = _settle(A, y, partition, low, high, tolerance)
    if settled is None:
        return None
    partition, inverse = settled
    f, c = form.evaluate(y[:n])
    residual = c + y[n:]
    sizes = [np.abs(residual).max(initial=0.0)]
    for _ in range(NEWTON_STEPS):
        if not np.isfinite(sizes[-1]):
            return None
        if sizes[-1] <= tolerance:
            # where constraints are violated the objective may be infinite; a failed evaluation leaves a residual
            return Restored(y, f, residual, partition) if np.isfinite(f) or form.m else None
        if len(sizes) > 2 and sizes[-1] > SLOWEST * sizes[-3]:
            return None
        before, basic = y[partition.basic], partition.basic
        y[basic] -= inverse @ residual
        settled = _settle(A, y, partition, low, high, tolerance)
        if settled is None:
            return None
        f, c = form.evaluate(y[:n])
        change, residual = c + y[n:] - residual, c + y[n:]
        sizes.append(np.abs(residual).max())
        if not np.array_equal(settled[0].basic, basic):
            partition, inverse = settled
            sizes = sizes[-1:]
        elif np.isfinite(sizes[-1]):
            inverse = _broyden(inverse, y[basic] - before, change)
    return None


def _settle(
    A: Array, y: Array, partition: Partition, low: Array, high: Array, tolerance: float
) -> tuple[Partition, Array] | None:
    """Bring basic variables within their bounds, in place, by exchanges; the partition and its inverse basis."""
    inverse = _inverse(A, partition)
    for _ in range(len(y)):
        basic, nonbasic = partition
        excess = np.maximum(low[basic] - y[basic], y[basic] - high[basic])
        excess[~np.isfinite(excess)] = 0.0
        if not np.any(excess > tolerance):
            y[basic] = np.clip(y[basic], low[basic], high[basic])
            return partition, inverse
        row = int(np.argmax(excess))
        y[basic[row]] = np.clip(y[basic[row]], low[basic[row]], high[basic[row]])
        room = np.minimum(y[nonbasic] - low[nonbasic], high[nonbasic] - y[nonbasic])
        pivots = np.abs(inverse[row] @ A[:, nonbasic])
        column = int(np.argmax(pivots * np.clip(room, 0.0, 1.0)))
        if pivots[column] * min(room[column], 1.0) < SMALLEST_PIVOT:
            return None
        partition = partition.exchange(row, column)
        inverse = _inverse(A, partition)
    return None


def _inverse(A: Array, partition: Partition) -> Array:
    """Inverse of the basis, (m, m)."""
    return np.asarray(np.linalg.inv(A[:, partition.basic]), dtype=float)


def _broyden(inverse: Array, step: Array, change: Array) -> Array:
    """Update an inverse Jacobian by a step and the change of the residual that it made."""
    predicted = inverse @ change
    denominator = float(step @ predicted)
    if abs(denominator) < 1e-3 * float(step @ step) or not np.isfinite(denominator):
        return inverse
    return inverse + np.outer(step - predicted, step @ inverse) / denominator
