"""Search along a step for a better point on the constraints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from optim.algorithms.nlp import Array
from optim.algorithms.restoration import Restored, restore
from optim.algorithms.standard_form import Partition, Phase, StandardForm

#: Sufficient decrease (Armijo) and trials.
DECREASE, TRIALS = 1e-4, 30
#: A step is lengthened while the merit falls by this part of what its slope promises.
NEARLY_STRAIGHT, LONGEST = 0.8, 1e6


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

    Parameters
    ----------
    form : StandardForm
    A : (m, n + m) array
        Jacobian of the equations at the point.
    at : Restored
        The point, with the partition of its reduced gradient.
    partition : Partition
        Used by the search.
    direction : (n + m,) array
        Step, tangential to the equations.
    slope : float
        Slope of the merit along it, negative.
    phase : Phase
    tolerance : float
        Tolerance of the equations.

    Returns
    -------
    Restored, int
        The better point, and how many trials it took; None if there is none.
    """
    # remaining residuals of the equations spoil small differences of the objective: to first order by the
    # multipliers times the residual
    basic = at.partition.basic
    multipliers = np.zeros(form.m) if phase.first else np.linalg.solve(A[:, basic].T, phase.gradient[basic])
    value = form.merit(phase, at.y, at.f) - float(multipliers @ at.residual)

    def trial(length: float) -> tuple[Restored | None, float]:
        target = at.y + length * direction
        y = np.clip(target, phase.keep_low, phase.keep_high)
        y[partition.basic] = target[partition.basic]  # the restoration brings these back
        point = restore(form, A, y, partition, phase.keep_low, phase.keep_high, tolerance)
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
