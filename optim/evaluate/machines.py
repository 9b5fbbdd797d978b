"""`Machines`: the machines of each design, which scatter, and the combination of their quantities."""

from __future__ import annotations

import math

import numpy as np

from optim.evaluate.evaluations import OK, Evaluations
from optim.problem.schema import OverScatter, Share
from optim.problem.study import Array, Study


class Machines:
    """The same points of the scatter for all designs of a search.

    Parameters
    ----------
    study : Study
        With `scatter`; its designs have the variables alone.
    """

    def __init__(self, study: Study) -> None:
        assert study.scatter is not None
        self.study, scatter = study, study.scatter
        self.means = scatter.means
        self.away = scatter.values(scatter.points(study.file.machines, study.file.seed)) - self.means
        columns = {f"scatter.{name}.factor": k for k, name in enumerate(scatter.names)}
        self._factors = [(k, columns[path]) for k, path in enumerate(study.paths) if path in columns]

    def rows(self, designs: Array) -> Array:
        """Return the machines of designs (m, n), one design after the other: (m k, n + ns)."""
        k = len(self.away)
        scale = np.ones((len(designs), 1, len(self.means)))
        for variable, value in self._factors:
            scale[:, 0, value] = designs[:, variable]
        values = (self.means + scale * self.away).reshape(-1, len(self.means))
        return np.hstack([np.repeat(designs, k, axis=0), values])

    def combined(self, found: Evaluations) -> Evaluations:
        """Combine the quantities of the machines of each design; a design fails with its first machine that fails."""
        k = len(self.away)
        table = np.hstack([found.objectives, found.constraints]).reshape(-1, k, len(self.study.quantities))
        hows = [quantity.over_scatter for _, _, quantity in self.study.quantities]
        columns = [[_combined(how, machines) for machines in table[:, :, q]] for q, how in enumerate(hows)]
        values = np.column_stack(columns)
        first = [next((i for i in range(k * d, k * d + k) if found.status[i] != OK), k * d) for d in range(len(table))]
        status, reason = (tuple(told[i] for i in first) for told in (found.status, found.reason))
        split = len(self.study.file.objectives)
        return Evaluations(values[:, :split], values[:, split:], status, reason)


def _combined(how: OverScatter | None, values: Array) -> float:
    """Combine a quantity of machines (k,); NaN if one has no value."""
    if not np.isfinite(values).all():
        return math.nan
    if isinstance(how, Share):
        return float(np.mean((how.at_least <= values) & (values <= how.at_most)))
    if isinstance(how, float):
        return float(np.quantile(values, how))
    if how == "deviation":
        return float(values.std(ddof=1))
    return {"max": float(values.max()), "min": float(values.min())}.get(how or "mean", math.fsum(values) / len(values))
