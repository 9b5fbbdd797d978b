"""`Evaluations`: the objectives and constraints of designs, or why they have none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages import Status
from linkages.base.brief import Brief, counted
from optim.problem.study import Array

OK = Status.OK.value
NO_VALUE = "no-value"  # a quantity has no finite value
INFEASIBLE = "infeasible"  # not run: a constraint that needs no run is violated


@dataclass(frozen=True, repr=False)
class Evaluations(Brief):
    """Objectives and constraints of m designs; made by `optim.Evaluator`.

    Attributes
    ----------
    objectives, constraints : (m, no), (m, nc) arrays
        Values in the units of the study file; NaN where there is none.
    status : tuple of str
        "ok", or why a design has no values: a `linkages.base.errors.Status`, `NO_VALUE`, or `INFEASIBLE`; such a design
        has the values of the constraints that need no run.
    reason : tuple of str
        One line for each design; empty if ok.
    """

    objectives: Array
    constraints: Array
    status: tuple[str, ...]
    reason: tuple[str, ...]

    def _facts(self) -> tuple[str, dict[str, str]]:
        rows = {f"designs: {one}": f"{self.status.count(one):,}" for one in dict.fromkeys(self.status)}
        parts = counted(self.objectives.shape[1], "objective"), counted(self.constraints.shape[1], "constraint")
        return f"{counted(len(self), 'design')}, {', '.join(parts)}; {int(self.failed.sum()):,} failed", rows

    def __len__(self) -> int:
        return len(self.objectives)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Tell where a run, or a formula, gave no value, (m,)."""
        return np.array([status not in (OK, INFEASIBLE) for status in self.status], dtype=bool)

    @property
    def unrun(self) -> NDArray[np.bool_]:
        """Tell where a design was not run because it is infeasible, (m,)."""
        return np.array([status == INFEASIBLE for status in self.status], dtype=bool)
