"""A problem as the reduced gradient method sees it: scaled, every constraint an equation with a slack; two phases.

Violations are minimised first (phase I), then the objective.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.base.arguments import shaped
from linkages.base.arrays import Indices
from optim.algorithms.archive import Archive
from optim.algorithms.derivatives import jacobian
from optim.algorithms.nlp import Array, Problem

#: A basis is kept while no exchange makes a weighted pivot so many times larger.
GAIN = 10.0

#: First-order change of a constraint, over its value, below which it does not change at the start.
FLAT = 1e-6
#: Step, relative to the scales, off a stationary point: it may be a saddle.
PUSH = 1e-2


class ScaledSlopes(NamedTuple):
    """First derivatives at a point, scaled.

    The gradient `f` of the objective with respect to variables and slacks (zero there), (n + m,), and the Jacobian
    ``A = [J I]`` of the equations ``c(x) + s = 0``, (m, n + m).
    """

    f: Array
    A: Array


class Phase(NamedTuple):
    """The task at a point; arrays are (n + m,)."""

    first: bool  # phase I: some slack violates its bounds by more than the tolerance
    gradient: Array  # of the merit: in phase I of the sum of the violations, then of the objective
    low: Array  # bounds of the step's model: a slack that violates a bound goes as far as that bound
    high: Array
    keep_low: Array  # bounds of the search: there it may pass
    keep_high: Array


class StandardForm:
    """Minimise f(x) subject to ``c(x) + s = 0`` and ``lower <= (x, s) <= upper``, with n variables and m constraints.

    The slack of an inequality lies in [0, inf), the slack of an equality in [0, 0]. A variable is measured by the
    distance of its bounds (by its own start where they are infinite), the objective and each constraint by their
    largest change over such a distance, to first order at the start (n,): where the objective is not known there, since
    constraints are violated, at the first feasible point (`measure`). A constraint that does not change to first order
    is measured by its value. `lower` and `upper` (n + m,) are the scaled bounds, `width` (n,) the scales of the
    variables, `slacks` the partition with the slacks as basis. The step of the differences is relative to the scales.
    """

    def __init__(self, problem: Problem, archive: Archive, start: Array, step: float) -> None:
        self.problem, self.archive, self._step = problem, archive, step
        self.n = problem.size
        self.m = len(problem.inequalities) + len(problem.equalities)
        self.slacks = Partition(np.arange(self.n, self.n + self.m), np.arange(self.n))
        width = problem.upper - problem.lower
        known = np.isfinite(width) & (width > 0.0)
        self.width = np.where(known, width, np.maximum(1.0, np.abs(start)))
        self._size, self._objective_size, self.measured = np.ones(self.m), 1.0, False
        slack_upper = np.where(np.arange(self.m) < len(problem.inequalities), np.inf, 0.0)
        self.lower = np.concatenate([problem.lower / self.width, np.zeros(self.m)])
        self.upper = np.concatenate([problem.upper / self.width, slack_upper])
        slopes = self.slopes(start / self.width)
        if slopes is not None:
            largest, values = (
                np.abs(slopes.A[:, : self.n]).max(axis=1, initial=0.0),
                self.evaluate(start / self.width)[1],
            )
            sizes = np.where(largest > FLAT * np.abs(values), largest, np.abs(values))
            self._size = np.where(sizes > 0.0, sizes, 1.0)
            self.measure(slopes)

    def measure(self, slopes: ScaledSlopes) -> ScaledSlopes:
        """Measure the objective by its slopes, if it has no measure yet; return the slopes in its measure."""
        size = float(np.abs(slopes.f).max())
        if self.measured or size == 0.0:
            return slopes
        self._objective_size, self.measured = size, True
        return slopes._replace(f=slopes.f / size)

    def design(self, x: Array) -> Array:
        """Unscaled design (n,) of scaled variables; scaling does not move it off its bounds."""
        design = np.where(x <= self.lower[: self.n], self.problem.lower, x * self.width)
        return np.where(x >= self.upper[: self.n], self.problem.upper, design)

    def evaluate(self, x: Array) -> tuple[float, Array]:
        """Scaled objective and constraints (m,) of scaled variables.

        Both are infinite where the evaluation failed, the objective alone where it was not evaluated: constraints
        are violated.
        """
        values = self.archive(self.design(x)[None, :])
        if values.failed[0]:
            return np.inf, np.full(self.m, np.inf)
        constraints = np.concatenate([values.inequalities[0], values.equalities[0]])
        return float(values.objectives[0, 0]) / self._objective_size, constraints / self._size

    @property
    def explicit(self) -> bool:
        """Whether the constraints are known without an evaluation."""
        return self.m == 0 or self.problem.constraints is not None

    def evaluate_all(self, points: Sequence[Array]) -> None:
        """Evaluate several points of scaled variables in one call, for `evaluate`."""
        if points:
            self.archive(np.array([self.design(x) for x in points]))

    def constraints(self, x: Array) -> Array:
        """Scaled constraints (m,) of scaled variables, as `evaluate`, which is not called if they are known without."""
        if not self.explicit:
            return self.evaluate(x)[1]
        if self.problem.constraints is None:
            return np.empty(0)
        found = shaped(self.problem.constraints(self.design(x)), (self.m,), "constraints", "numbers")
        return np.where(np.isfinite(found), found, np.inf) / self._size

    def slopes(self, x: Array) -> ScaledSlopes | None:
        """Differentiate at scaled variables; None where there are no values."""
        J = jacobian(self.problem, self.archive, self.design(x), self.width, self._step)
        if J is None or not np.all(np.isfinite(J)):
            return None
        J = J * self.width
        f = np.concatenate([J[0] / self._objective_size, np.zeros(self.m)])
        return ScaledSlopes(f, np.hstack([J[len(self.problem.objectives) :] / self._size[:, None], np.eye(self.m)]))

    def phase(self, y: Array, slopes: ScaledSlopes, tolerance: float) -> Phase:
        """Return the task at a point: whether it is feasible decides the phase."""
        low, high = self.lower, self.upper
        excess = np.append(np.zeros(self.n), self._violation(y))
        if np.abs(excess).max() <= tolerance:
            return Phase(False, slopes.f, low, high, low, high)
        under, over = excess < 0.0, excess > 0.0
        equal = (under | over) & (low == high)
        keep_low = np.where(under | equal, -np.inf, low)
        keep_high = np.where(over | equal, np.inf, high)
        model_low = np.where(over, high, np.where(under, -np.inf, low))
        model_high = np.where(under, low, np.where(over, np.inf, high))
        return Phase(True, np.sign(excess), model_low, model_high, keep_low, keep_high)

    def merit(self, phase: Phase, y: Array, f: float) -> float:
        """Return the value that is minimised: the objective, in phase I the sum of the scaled violations."""
        return float(np.abs(self._violation(y)).sum()) if phase.first else f

    def _violation(self, y: Array) -> Array:
        """By how much the slacks violate their bounds: negative below, positive above, (m,)."""
        s, low, high = y[self.n :], self.lower[self.n :], self.upper[self.n :]
        return np.minimum(s - low, 0.0) + np.maximum(s - high, 0.0)


def pushed(x: Array, lower: Array, upper: Array) -> Array:
    """Move scaled variables (n,) off a stationary point, by unequal steps away from the nearer bounds."""
    inward = np.where(upper - x >= x - lower, 1.0, -1.0)
    return np.clip(x + PUSH * (1.0 + np.arange(len(x)) / len(x)) * inward, lower, upper)


class Partition(NamedTuple):
    """Indices of the basic variables, which the equations determine, (m,), and of the others, (n,)."""

    basic: Indices
    nonbasic: Indices

    def exchange(self, row: int, column: int) -> Partition:
        """Swap the basic variable of a row with the nonbasic one of a column."""
        basic, nonbasic = self.basic.copy(), self.nonbasic.copy()
        basic[row], nonbasic[column] = nonbasic[column], basic[row]
        return Partition(basic, nonbasic)

    def improved(self, A: Array, room: Array) -> Partition:
        """Choose basic variables that are independent and far from their bounds.

        Columns of the Jacobian A (m, n + m), which has a regular basis, are weighted by the room (n + m,) of their
        variables: the scaled distance to the nearer bound. As long as there is an exchange that makes the weighted
        determinant of the basis more than ten times larger, the largest one is made; so the partition stays while it is
        good, and there is an end to it.
        """
        current, weights = self, np.clip(room, 1e-8, 1.0)
        while len(current.basic):
            pivots = np.abs(current.tangents(A)[current.basic])
            gains = pivots * weights[current.nonbasic] / weights[current.basic, None]
            row, column = np.unravel_index(np.argmax(gains), gains.shape)
            if not gains[row, column] > GAIN:
                break
            current = current.exchange(int(row), int(column))
        return current

    def tangents(self, A: Array) -> Array:
        """Directions that keep the equations to first order, (n + m, n): unity in the nonbasic variables."""
        Z = np.zeros((A.shape[1], len(self.nonbasic)))
        Z[self.nonbasic, np.arange(len(self.nonbasic))] = 1.0
        Z[self.basic] = -np.linalg.solve(A[:, self.basic], A[:, self.nonbasic])
        return Z
