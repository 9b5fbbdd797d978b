"""Derivatives of objectives and constraints by differences, one population for a whole Jacobian."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from optim.algorithms.nlp import Array, Problem, Values

#: Where derivatives of a study come from.
Source = Literal["differences", "sensitivities"]
DIFFERENCES: Source = "differences"
#: Sum of violations from which on a design may lack the objectives around it.
VIOLATED = 1e-6
SOURCES = '"differences" of designs, or "sensitivities" of runs (differences where there are none)'


def stack(values: Values) -> Array:
    """Objectives, inequalities and equalities side by side, (m, no + ni + ne)."""
    return np.hstack([values.objectives, values.inequalities, values.equalities])


def jacobian(
    problem: Problem, evaluate: Callable[[Array], Values], x: Array, scale: Array, step: float
) -> Array | None:
    """Differentiate the objectives, inequalities and equalities at a design x (n,): (no + ni + ne, n).

    The problem's own where it has them and they are finite; else differences of second order from two further designs
    for each variable, a step times its scale (n,) away: central ones inside, one-sided ones where a bound is nearer. Of
    first order where there is a value on one side only: an evaluation failed, or was not made beyond a constraint.
    Where there is a value on neither side, as in a corner between constraints, the difference is taken beside the
    design: at one of those that were evaluated for the other variables. `evaluate` is called once with 2 n designs, in
    a corner once more.

    None where there is no value on either side, nor beside. At a design that violates constraints, objectives that were
    not evaluated there, or nowhere around, have the derivative zero.
    """
    own = problem.derivatives(x)
    if own is not None and np.isfinite(own).all():
        return own
    offsets = _offsets(x, problem.lower, problem.upper, step * scale)
    moving = np.flatnonzero(offsets[0] != offsets[1])
    rows = np.arange(len(moving))
    moved = np.tile(x, (2, len(moving), 1))
    moved[:, rows, moving] += offsets[:, moving]
    offsets = moved[:, rows, moving] - x[moving]  # after rounding
    designs = np.vstack([x, *moved])
    values = evaluate(designs)
    if values.failed[0]:
        return None
    table = stack(values)
    table[~np.isfinite(table)] = np.nan
    centre, (at_near, at_far) = table[0], np.split(table[1:], 2)
    with np.errstate(invalid="ignore"):
        a, b = offsets[:, :, None]
        slopes = (at_near * b**2 - at_far * a**2 - centre * (b**2 - a**2)) / (a * b * (b - a))
        slopes = np.where(np.isnan(at_near), (at_far - centre) / b, slopes)
        slopes = np.where(np.isnan(at_far), (at_near - centre) / a, slopes)
    slopes[:, np.isnan(centre)] = 0.0
    objectives = values.objectives.shape[1]
    alone = bool(values.violation[0] > VIOLATED and np.isnan(table[1:, :objectives]).all())
    alone = alone and bool(np.isfinite(slopes[:, objectives:]).all())
    for k in np.flatnonzero(~np.isfinite(slopes).all(axis=1)):
        beside = _beside(evaluate, designs[1:], table[1:], int(moving[k]), offsets[:, k])
        if beside is None and alone:
            beside = np.zeros(table.shape[1])
        if beside is None:
            return None
        slopes[k] = np.where(np.isfinite(slopes[k]), slopes[k], beside)
    result = np.zeros((table.shape[1], len(x)))
    result[:, moving] = slopes.T
    return result


def _beside(
    evaluate: Callable[[Array], Values], designs: Array, table: Array, variable: int, offsets: Array
) -> Array | None:
    """Slopes (no + ni + ne,) of a variable by either offset (2,) from the first of the designs that has them."""
    known = np.flatnonzero(np.isfinite(table).all(axis=1))
    if len(known) == 0:
        return None
    moved = np.repeat(designs[known], 2, axis=0)
    moved[:, variable] += np.tile(offsets, len(known))
    steps = moved[:, variable] - np.repeat(designs[known, variable], 2)
    slopes = (stack(evaluate(moved)) - np.repeat(table[known], 2, axis=0)) / steps[:, None]
    good = np.flatnonzero(np.isfinite(slopes).all(axis=1))
    return np.asarray(slopes[good[0]]) if len(good) else None


def _offsets(x: Array, lower: Array, upper: Array, step: Array) -> Array:
    """Two offsets of each variable that stay within its bounds, (2, n); equal ones where it is fixed."""
    step = np.minimum(step, (upper - lower) / 4.0)  # so that two steps fit on one side
    near, far = -step, step.copy()
    at_lower, at_upper = x - step < lower, x + step > upper
    near[at_lower], far[at_lower] = step[at_lower], 2.0 * step[at_lower]
    near[at_upper], far[at_upper] = -step[at_upper], -2.0 * step[at_upper]
    fixed = upper <= lower
    near[fixed] = far[fixed] = 0.0
    return np.array([near, far])
