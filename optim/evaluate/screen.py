"""`Screened`: designs that formulas show to be infeasible, or without a value, are not run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from optim.evaluate.evaluations import INFEASIBLE, NO_VALUE, OK, Evaluations
from optim.evaluate.limits import FEASIBLE, limits
from optim.problem.study import Array, Study


class Screened:
    """Evaluates designs of a study, but runs only designs that satisfy its constraints as far as formulas tell.

    By the rules of feasibility an infeasible design is judged by its violation alone, and runs of linkages that cannot
    turn are slow. The nominal design is run in any case: others are measured by it. `evaluate` returns evaluations of
    designs (m, n), by runs.

    The step of an algorithm's differences, relative to the bounds, reaches beyond the constraints. So designs one or
    two steps along a variable from one that satisfies them are run too, but not beyond a hard constraint.
    """

    def __init__(self, study: Study, evaluate: Callable[[Array], Evaluations], step: float | None = None) -> None:
        self.study, self.evaluate = study, evaluate
        spans = np.diag(study.upper - study.lower)
        self._steps = [] if step is None else [k * step * span for k in (-2, -1, 1, 2) for span in spans]
        self._names = [name for _, name, _ in study.quantities]
        self._scales = {
            name: study.formulas[name](study.named(study.nominal)) if quantity.relative else 1.0
            for _, name, quantity in study.quantities
            if name in study.formulas
        }

    def __call__(self, designs: Array) -> Evaluations:
        """Evaluate designs (m, n)."""
        if not self._scales:
            return self.evaluate(designs)
        table = np.full((len(designs), len(self._names)), np.nan)
        verdicts = [self._verdict(design, row) for design, row in zip(designs, table, strict=True)]
        split = len(self.study.file.objectives)
        objectives, constraints = np.full((len(designs), split), np.nan), table[:, split:]
        rows = [i for i, (status, _) in enumerate(verdicts) if status == OK]
        if rows:
            found = self.evaluate(designs[rows])
            objectives[rows], constraints[rows] = found.objectives, found.constraints
            for i, state, why in zip(rows, found.status, found.reason, strict=True):
                verdicts[i] = state, why
        status, reason = zip(*verdicts, strict=True)
        return Evaluations(objectives, constraints, status, reason)

    def _verdict(self, design: Array, row: Array) -> tuple[str, str]:
        """Status and reason of a design, `OK` if it should be run; its constraints by formula go into `row`."""
        if np.array_equal(design, self.study.nominal):
            return OK, ""
        values = self._values(design)
        for name, value in values.items():
            if not np.isfinite(value):
                return NO_VALUE, f"{name} has no finite value"
        row[:] = [values.get(name, np.nan) for name in self._names]
        violated = self._violated(values)
        if not violated or self._near(design, violated):
            return OK, ""
        return INFEASIBLE, f"violates {violated[0]}"

    def _near(self, design: Array, violated: list[str]) -> bool:
        """Whether a difference step from a feasible design may reach a design that violates these limits."""
        hard = any(self.study.file.constraints[key.rpartition(".")[0]].hard for key in violated)
        return not hard and any(not self._violated(self._values(design + step)) for step in self._steps)

    def _values(self, design: Array) -> dict[str, float]:
        """Objectives and constraints by formula."""
        named = self.study.named(design)
        return {name: self.study.formulas[name](named) for name in self._scales}

    def _violated(self, values: dict[str, float]) -> list[str]:
        """Names of the limits that are violated, or not known to hold."""
        found = []
        for limit in limits(self.study):
            if limit.name in values and self._scales[limit.name] != 0.0:
                excess = limit.excess(values[limit.name] / self._scales[limit.name])
                if not (abs(excess) if limit.equality else excess) <= FEASIBLE:
                    found.append(limit.key)
        return found
