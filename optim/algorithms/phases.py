"""The two phases of the reduced gradient method: violations are minimised first, then the objective."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from optim.algorithms.nlp import Array
from optim.algorithms.standard_form import Slopes, StandardForm


class Phase(NamedTuple):
    """The task at a point.

    Attributes
    ----------
    first : bool
        Phase I: some slack violates its bounds by more than the tolerance.
    gradient : (n + m,) array
        Gradient of the merit: in phase I of the sum of the violations, then of the objective.
    low, high : (n + m,) arrays
        Bounds of the step's model: a slack that violates a bound goes as far as that bound.
    keep_low, keep_high : (n + m,) arrays
        Bounds of the search: there it may pass.
    """

    first: bool
    gradient: Array
    low: Array
    high: Array
    keep_low: Array
    keep_high: Array


def phase_at(form: StandardForm, y: Array, slopes: Slopes, tolerance: float) -> Phase:
    """Return the task at a point: whether it is feasible decides the phase."""
    low, high = form.lower.copy(), form.upper.copy()
    excess = np.append(np.zeros(form.n), form.violation(y[form.n :]))
    if np.abs(excess).max() <= tolerance:
        return Phase(False, slopes.f, low, high, low, high)
    under, over = excess < 0.0, excess > 0.0
    equal = (under | over) & (low == high)
    keep_low = np.where(under | equal, -np.inf, low)
    keep_high = np.where(over | equal, np.inf, high)
    model_low = np.where(over, high, np.where(under, -np.inf, low))
    model_high = np.where(under, low, np.where(over, np.inf, high))
    return Phase(True, np.sign(excess), model_low, model_high, keep_low, keep_high)


def merit(form: StandardForm, phase: Phase, y: Array, f: float) -> float:
    """Return the value that is minimised: the objective, in phase I the sum of the scaled violations."""
    return float(np.abs(form.violation(y[form.n :])).sum()) if phase.first else f
