"""Statistics of many turns as residuals, for dry runs beyond the horizon of their predictability.

Samples beyond the horizon change with every digit of a value, their statistics do not. Runs at points about the values
tell, by a regression, the statistics there, their derivatives, and how much they scatter.
"""

from __future__ import annotations

import copy
import math
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.stats import qmc

from linkages import InputError, RunError
from linkages.base.arrays import Array
from linkages.engines.compiled.batch.batch import run_batch
from optim.identify.load import Channel, Identification, Measurement
from optim.identify.numerics import STATISTICS_KNOWN, STATISTICS_PARTS, STATISTICS_POINTS
from optim.identify.residuals import Residuals

NAMES = ("mean", "deviation", "highest", "lowest")  # of a column; the last two are means over parts of the run
WIDTHS = (0.3, 0.15, 0.1)  # distance of the points from the values, in scaled values, in each stage of a fit


class Statistics(Residuals):
    """Residuals of the statistics of each column, independent and of variance 1, instead of its samples."""

    def __init__(self, task: Identification, active: tuple[str, ...] | None = None, width: float = WIDTHS[-1]) -> None:
        super().__init__(task, active)
        self.width = width
        self.deviations = [[1.0 for _ in one.channels] for one in task.measurements]
        self._roots: dict[int, Array] = {}
        for one in task.measurements:
            for c in one.channels:
                if len(c.times) < STATISTICS_PARTS**2:
                    where, count = f"data.{one.name}.columns.{c.name}", len(c.times)
                    raise InputError(
                        task.source, where, f"has {count} samples; statistics need at least {STATISTICS_PARTS**2}"
                    )

    def of_width(self, width: float) -> Self:
        """Return the statistics of points at another distance from the values, with a scatter of their own."""
        other = copy.copy(self)
        other.width, other._roots = width, {}
        return other

    @property
    def linear(self) -> NDArray[np.bool_]:
        """No value: the scatter of the statistics is the one of the first factors."""
        return np.zeros(len(self.start), bool)

    @property
    def size(self) -> int:
        """Number of runs of an evaluation."""
        return int(2 ** math.ceil(math.log2(STATISTICS_POINTS * (len(self.active) + 1))))

    def count(self, channel: Channel, horizon: float) -> int:
        """Return the number of residuals of a column."""
        return len(NAMES)

    def stated(self, channel: Channel) -> bool:
        """Check whether the deviation of a residual is known: the runs tell it."""
        return True

    def _measurement(
        self, m: int, one: Measurement, z: Array, horizon: float, free: NDArray[np.bool_], derivatives: bool
    ) -> tuple[Array, Array, float]:
        """Return residuals and derivatives from runs at points about the values; the first one tells the scatter."""
        mine = self.owned(one)
        cloud = 2.0 * qmc.Sobol(len(self.active), rng=np.random.default_rng(m)).random(self.size) - 1.0
        points = np.tile(z, (self.size, 1))
        points[:, mine] = np.clip(z[mine] + self.width * cloud[:, mine], self.lower[mine], self.upper[mine])
        found = self._of_runs(m, one, points, mine, horizon)
        away = points[:, mine] - z[mine]
        terms = np.column_stack([np.ones(self.size), away, away**2])
        good = np.isfinite(found).all(axis=1)
        if good.sum() < 2 * terms.shape[1]:
            raise RunError(
                f"{self.size - int(good.sum())} of {self.size} runs about these values do not reach their end"
            )
        fitted: Array = np.linalg.lstsq(terms[good], found[good], rcond=None)[0].astype(np.float64)
        if m not in self._roots:
            left = found[good] - terms[good] @ fitted
            middle = float(np.linalg.pinv(terms[good].T @ terms[good])[0, 0])
            scatter = left.T @ left * (1.0 + middle) / (good.sum() - terms.shape[1])
            least = np.repeat([STATISTICS_KNOWN * float(np.std(c.values)) for c in one.channels], len(NAMES))
            self._roots[m] = np.linalg.cholesky(scatter + np.diag(least**2))
        lines = np.zeros((found.shape[1], len(z)))
        lines[:, mine] = fitted[1 : len(mine) + 1].T
        for k, (_, measurement, c) in enumerate(self.places, len(self.active)):
            if measurement == m:
                rows = slice(len(NAMES) * c, len(NAMES) * (c + 1))
                lines[rows, k] = self._of_sensor(z, k, m, c, fitted[0, rows])
        measured = np.concatenate([numbers(c.values[self.used(c, horizon), None])[:, 0] for c in one.channels])
        root = self._roots[m]
        return (
            solve_triangular(root, measured - fitted[0], lower=True),
            -solve_triangular(root, lines, lower=True),
            math.inf,
        )

    def _of_sensor(self, z: Array, k: int, m: int, c: int, found: Array) -> Array:
        """Return the derivatives of a column's statistics with respect to its factor or bias, value k."""
        moved = np.array([1.0, 0.0, 1.0, 1.0])
        if self.places[k - len(self.active)].kind == "bias":
            return moved
        free = math.isnan(self.task.measurements[m].channels[c].offset)
        factor, bias = self.sensor(z, "factor", m, c), self.sensor(z, "bias", m, c) if free else 0.0
        return (found - bias * moved) / factor

    def _of_runs(self, m: int, one: Measurement, points: Array, mine: list[int], horizon: float) -> Array:
        """Return the statistics of the columns (np, 4 nc) of runs with noise of the stated deviations."""
        paths = [self.task.paths[self.active[k]] for k in mine]
        used = [c.times[self.used(c, horizon)] + one.shift for c in one.channels]
        grid = np.unique(np.maximum(np.concatenate(used), 0.0))
        outputs = list(dict.fromkeys(c.output for c in one.channels))
        system = one.system.replaced({"duration": float(grid[-1])})
        table = np.array([self.values(z)[mine] for z in points])
        batch: Any = run_batch(system, paths, table, outputs, samples=grid, progress=lambda part: None)
        noise, found = np.random.default_rng(m), []
        for c, (channel, times) in enumerate(zip(one.channels, used, strict=True)):
            places = np.searchsorted(grid, np.maximum(times, 0.0))
            computed = batch.samples[:, places, outputs.index(channel.output)].T
            factor, bias = (self.sensor(points[0], kind, m, c) for kind in ("factor", "bias"))
            spread = np.nan_to_num(channel.deviation) * noise.standard_normal(computed.shape)
            found.append(numbers(channel.filtered(factor * computed + bias) + spread))
        return np.concatenate(found).T

    def compared_numbers(self, z: Array) -> dict[str, dict[str, list[float]]]:
        """Return the statistics by column: ``measured``, and ``computed`` by one run at the values."""
        found = {}
        for m, one in enumerate(self.task.measurements):
            mine = self.owned(one)
            computed = self._of_runs(m, one, z[None], mine, math.inf)[0].reshape(-1, len(NAMES))
            for channel, row in zip(one.channels, computed, strict=True):
                measured = numbers(channel.values[:, None])[:, 0]
                found[f"{one.name}.{channel.name}"] = {"measured": measured.tolist(), "computed": row.tolist()}
        return found


def numbers(values: Array) -> Array:
    """Return mean, standard deviation, and means of highest and lowest samples over parts (4, m) of samples (n, m)."""
    parts = np.array_split(values, STATISTICS_PARTS)
    highest, lowest = (np.mean([f(part, axis=0) for part in parts], axis=0) for f in (np.max, np.min))
    return np.stack([values.mean(axis=0), values.std(axis=0), highest, lowest])
