"""`Archive`: every design that an algorithm evaluated in one run, none twice; the order by feasibility."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from optim.algorithms.nlp import Array, Problem, Values


class Archive:
    """Evaluate populations of a problem, and remember them.

    Values that are not finite count as failed evaluations: infinite objectives and inequalities. Only a design that
    violates constraints may have infinite objectives: they were not evaluated.

    Parameters
    ----------
    problem : Problem
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._rows: dict[bytes, int] = {}
        self._designs: list[Array] = []
        self._values: list[Values] = []

    def __call__(self, designs: Array) -> Values:
        """Values of designs (m, n): new ones are evaluated in one call, each once."""
        designs = np.atleast_2d(np.asarray(designs, dtype=float)) + 0.0  # + 0.0: -0.0 and 0.0 are one design
        names = [design.tobytes() for design in designs]
        new = {name: i for i, name in enumerate(names) if name not in self._rows}
        if new:
            rows = sorted(new.values())
            values = _finite_or_failed(self.problem.evaluate(designs[rows]))
            for row in rows:
                self._rows[names[row]] = len(self._rows)
            self._designs.append(designs[rows])
            self._values.append(values)
        if len(self._values) > 1:
            self._designs = [np.concatenate(self._designs)]
            self._values = [Values.join(self._values)]
        return self._values[0].take([self._rows[name] for name in names])

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def designs(self) -> Array:
        """All designs in the order in which they were evaluated, (k, n)."""
        return self._designs[0] if self._designs else np.empty((0, self.problem.size))

    @property
    def values(self) -> Values:
        """Their values."""
        return self._values[0]

    def best(self, tolerance: float = 0.0) -> int:
        """Row of the best design by the first objective and the rules of feasibility."""
        return int(by_feasibility(self.values, tolerance)[0])


def by_feasibility(values: Values, tolerance: float = 0.0) -> NDArray[np.intp]:
    """Sort designs: feasible ones by the first objective, then infeasible ones by their violation, then failed ones.

    Parameters
    ----------
    values : Values
    tolerance : float
        Violation up to which a constraint counts as satisfied.

    Returns
    -------
    (m,) array of int
        Rows, the best first; equal ones in their order.

    Notes
    -----
    K. Deb, An efficient constraint handling method for genetic algorithms, Computer Methods in Applied
    Mechanics and Engineering 186 (2000) 311-338.
    """
    feasible = values.feasible(tolerance)
    key = np.where(feasible, values.objectives[:, 0], values.violation)
    return np.lexsort((key, ~feasible))


def _finite_or_failed(values: Values) -> Values:
    """Mark rows that hold anything not finite as failed."""
    failed = values.failed.copy()
    for part in (values.inequalities, values.equalities):
        failed |= ~np.isfinite(part).all(axis=1)
    unasked = np.isposinf(values.objectives) & (values.violation > 0.0)[:, None]
    failed |= ~(np.isfinite(values.objectives) | unasked).all(axis=1)
    return Values(
        np.where(failed[:, None], np.inf, values.objectives),
        np.where(failed[:, None], np.inf, values.inequalities),
        np.where(failed[:, None], np.inf, values.equalities),
        failed,
    )
