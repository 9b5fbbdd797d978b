"""Search along a step for a better point, with Newton's method back to the constraints at each trial."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from optim.algorithms.nlp import Array
from optim.algorithms.standard_form import Partition, Phase, StandardForm

#: Sufficient decrease (Armijo) and trials.
DECREASE, TRIALS = 1e-4, 30
#: A step is lengthened while the merit falls by this part of what its slope promises.
NEARLY_STRAIGHT, LONGEST = 0.8, 1e6
#: Corrections before a trial point is given up, and the least that two of them must do: they converge fast or not.
NEWTON_STEPS, SLOWEST = 12, 0.5
#: Pivot that counts as zero.
SMALLEST_PIVOT = 1e-9


class Restored(NamedTuple):
    """A point on the constraints.

    Its variables and slacks (n + m,), the objective, the residual of the equations, within the tolerance, (m,), and the
    partition that it was reached with.
    """

    y: Array
    f: float
    residual: Array
    partition: Partition


class Corrected(NamedTuple):
    """A point on the constraints that is not evaluated yet, as `Restored`."""

    y: Array
    residual: Array
    partition: Partition


#: The point on the constraints at a part of the step, if there is one, and its merit.
Trial = Callable[[float], tuple[Restored | None, float]]


def search(
    form: StandardForm,
    A: Array,
    at: Restored,
    partition: Partition,
    direction: Array,
    slope: float,
    phase: Phase,
    tolerance: float,
) -> tuple[Restored, int] | None:
    """Take the whole step, or shorten it by quadratic interpolation until the merit falls enough.

    The search goes from the point `at`, which has the partition of its reduced gradient, along a direction (n + m,)
    tangential to the equations, whose Jacobian is A (m, n + m), with a negative slope of the merit, in `partition`.
    Returns the better point, and how many trials it took; None if there is none.
    """
    # remaining residuals of the equations spoil small differences of the objective: to first order by the
    # multipliers times the residual
    basic = at.partition.basic
    multipliers = np.zeros(form.m) if phase.first else np.linalg.solve(A[:, basic].T, phase.gradient[basic])
    value = form.merit(phase, at.y, at.f) - float(multipliers @ at.residual)

    corrected: dict[float, Corrected | None] = {}

    def correct(length: float) -> Corrected | None:
        target = at.y + length * direction
        y = np.clip(target, phase.keep_low, phase.keep_high)
        y[partition.basic] = target[partition.basic]  # the correction brings these back
        return on_constraints(form, A, y, partition, phase.keep_low, phase.keep_high, tolerance)

    def trial(length: float) -> tuple[Restored | None, float]:
        if length not in corrected:
            doubled = (2.0 * length,) if length >= 1.0 and form.explicit else ()  # a batch of both takes no longer
            corrected.update({one: correct(one) for one in (length, *doubled)})
            form.evaluate_all([found.y[: form.n] for found in corrected.values() if found is not None])
        point = evaluated(form, corrected[length])
        if point is None:
            return None, np.inf
        return point, form.merit(phase, point.y, point.f) - float(multipliers @ point.residual)

    length = 1.0
    for i in range(TRIALS):
        point, new = trial(length)
        if point is not None and new <= value + DECREASE * length * slope:
            return (_extend(trial, point, new, value, slope) if i == 0 else point), i + 1
        if point is None:
            length *= 0.3
        else:
            bend = new - value - length * slope
            length = float(np.clip(-slope * length**2 / (2.0 * bend), 0.1 * length, 0.5 * length))
    return None


def _extend(trial: Trial, point: Restored, new: float, value: float, slope: float) -> Restored:
    """Go farther while the merit falls almost as steeply as at first: the model's curvature is too large."""
    length = 1.0
    while new < value + NEARLY_STRAIGHT * length * slope and length < LONGEST:
        farther, lower = trial(2.0 * length)
        if farther is None or lower >= new:
            break
        point, new, length = farther, lower, 2.0 * length
    return point


def evaluated(form: StandardForm, found: Corrected | None) -> Restored | None:
    """Evaluate a point on the constraints; None if that fails, or there is no point."""
    if found is None:
        return None
    f, c = form.evaluate(found.y[: form.n])  # where constraints are violated the objective may be infinite
    failed = not np.isfinite(c if form.m else f).all()
    return None if failed else Restored(found.y, f, found.residual, found.partition)


def on_constraints(
    form: StandardForm, A: Array, y: Array, partition: Partition, low: Array, high: Array, tolerance: float
) -> Corrected | None:
    """Correct the basic variables of a trial point y (n + m,) until the scaled equations hold within the tolerance.

    Its nonbasic variables lie within the bounds low and high (n + m,), which the point must keep. Newton's method with
    the Jacobian A (m, n + m) of a point nearby, improved by Broyden's updates from the residuals. A basic variable that
    leaves its bounds is set on the bound and changes places with the nonbasic variable that has the largest pivot times
    room, and the correction goes on. None if it does not converge.
    """
    y, n = y.copy(), form.n
    settled = _settle(A, y, partition, low, high, tolerance)
    if settled is None:
        return None
    partition, inverse = settled
    residual = form.constraints(y[:n]) + y[n:]
    sizes = [np.abs(residual).max(initial=0.0)]
    for _ in range(NEWTON_STEPS):
        if not np.isfinite(sizes[-1]):
            return None
        if sizes[-1] <= tolerance:
            return Corrected(y, residual, partition)
        if len(sizes) > 2 and sizes[-1] > SLOWEST * sizes[-3]:
            return None
        before, basic = y[partition.basic], partition.basic
        y[basic] -= inverse @ residual
        settled = _settle(A, y, partition, low, high, tolerance)
        if settled is None:
            return None
        last, residual = residual, form.constraints(y[:n]) + y[n:]
        sizes.append(np.abs(residual).max())
        if not np.array_equal(settled[0].basic, basic):
            partition, inverse = settled
            sizes = sizes[-1:]
        elif np.isfinite(sizes[-1]):
            inverse = _broyden(inverse, y[basic] - before, residual - last)
    return None


def _settle(
    A: Array, y: Array, partition: Partition, low: Array, high: Array, tolerance: float
) -> tuple[Partition, Array] | None:
    """Bring basic variables within their bounds, in place, by exchanges; the partition and its inverse basis."""
    for _ in range(len(y)):
        inverse = np.asarray(np.linalg.inv(A[:, partition.basic]), dtype=float)
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
    return None


def _broyden(inverse: Array, step: Array, change: Array) -> Array:
    """Update an inverse Jacobian by a step and the change of the residual that it made."""
    predicted = inverse @ change
    denominator = float(step @ predicted)
    if abs(denominator) < 1e-3 * float(step @ step) or not np.isfinite(denominator):
        return inverse
    return inverse + np.outer(step - predicted, step @ inverse) / denominator
