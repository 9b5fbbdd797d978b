"""Residuals of an identification: measured less computed samples, and their derivatives, from one run each."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from linkages import AssemblyError, InputError, RunError
from linkages.base.arrays import Array
from optim.identify.algebra import regression
from optim.identify.budget import Budget
from optim.identify.curves import Curves
from optim.identify.load import SHIFT, Channel, Identification, Measurement
from optim.identify.numerics import RESIDUALS_UNKNOWN


class SensorValue(NamedTuple):
    """The place of a value of the sensors: ``shift`` of a measurement, ``factor`` or ``bias`` of a column."""

    kind: str
    measurement: int
    channel: int


@dataclass(frozen=True, eq=False)
class Evaluated:
    """Residuals at one set of values.

    Attributes
    ----------
    residual : (r,) array
        Measured less computed samples, in deviations; then those of the priors. Infinite if the design does not run.
    jacobian : (r, k) array
        Their derivatives with respect to the scaled values; zero where there is none.
    until : float
        Time up to which derivatives are known [s].
    reason : str
        Why the design does not run; empty if it does.
    z : (k,) array
        The scaled values, with the regressed values of the sensors.
    """

    residual: Array
    jacobian: Array
    until: float
    reason: str
    z: Array


class Residuals:
    """Residuals as a function of the scaled values z (k,): n unknowns, then values of the sensors.

    A positive unknown is scaled by its logarithm, another one by its limits. A reading of a sensor is its factor times
    the output plus its bias: 1 / gain and -offset / gain of the file.

    Attributes
    ----------
    lower, upper, start : (k,) arrays
        Limits and start of z.
    deviations : list of lists of float
        Of a sample, by measurement and column; those that the file leaves open may be set.
    budget : Budget
        When searches end with their best values; the residuals of other windows and accuracies share it.
    """

    def __init__(self, task: Identification, active: tuple[str, ...] | None = None) -> None:
        self.task = task
        self.active = [k for k, name in enumerate(task.names) if active is None or name in active]
        self.log = np.array([task.lower[k] > 0.0 for k in self.active])
        self._low, self._high = task.lower[self.active], task.upper[self.active]
        self.places: list[SensorValue] = []
        for m, one in enumerate(task.measurements):
            self.places += [SensorValue("shift", m, -1)] * math.isnan(one.shift)
            for c, channel in enumerate(one.channels):
                self.places += [SensorValue("factor", m, c)] * math.isnan(channel.gain)
                self.places += [SensorValue("bias", m, c)] * math.isnan(channel.offset)
        spans = [max(float(np.ptp(c.times)) for c in one.channels) for one in task.measurements]
        ends = [SHIFT * spans[p.measurement] if p.kind == "shift" else np.inf for p in self.places]
        self.lower = np.concatenate([self.scaled(self._low), -np.array(ends)])
        self.upper = np.concatenate([self.scaled(self._high), np.array(ends)])
        usual = [1.0 if p.kind == "factor" else 0.0 for p in self.places]
        self.start = np.concatenate([self.scaled(task.start[self.active]), usual])
        self.deviations = [
            [
                RESIDUALS_UNKNOWN * float(np.std(c.values)) if math.isnan(c.deviation) else c.deviation
                for c in one.channels
            ]
            for one in task.measurements
        ]
        self.budget = Budget()

    @property
    def linear(self) -> NDArray[np.bool_]:
        """Marks of the values (k,) in which the residuals are linear: factors and biases."""
        return np.array([False] * len(self.active) + [place.kind != "shift" for place in self.places])

    def of_kind(self, kind: str) -> NDArray[np.bool_]:
        """Return marks of the values (k,) of the sensors of a kind."""
        return np.array([False] * len(self.active) + [place.kind == kind for place in self.places])

    def accuracy(self) -> float:
        """Return the coarsest accuracy of the machines' runs."""
        return max(one.system.settings.accuracy for one in self.task.measurements)

    def at_accuracy(self, accuracy: float) -> Self:
        """Return the same residuals from runs that are at least as accurate."""
        other = copy.copy(self)
        other.task = replace(self.task, measurements=tuple(_accurate(m, accuracy) for m in self.task.measurements))
        return other

    @property
    def names(self) -> list[str]:
        """Names of all values: the unknowns, then those of the sensors."""
        found = [self.task.names[k] for k in self.active]
        for kind, m, c in self.places:
            one = self.task.measurements[m]
            found.append(f"{one.name}.{kind}" if kind == "shift" else f"{one.name}.{one.channels[c].name}.{kind}")
        return found

    def scaled(self, values: Array) -> Array:
        """Scale values of the active unknowns (n,)."""
        linear = (values - self._low) / (self._high - self._low)
        return np.where(self.log, np.log(np.where(self.log, values, 1.0)), linear)

    def values(self, z: Array) -> Array:
        """Return the unknowns (n,) of scaled values."""
        n = len(self.active)
        with np.errstate(over="ignore"):
            found = np.where(
                self.log, np.exp(np.where(self.log, z[:n], 0.0)), self._low + z[:n] * (self._high - self._low)
            )
        return np.clip(found, self._low, self._high)

    def slopes(self, z: Array) -> Array:
        """Return the derivatives (n,) of the unknowns with respect to their scaled values."""
        return np.where(self.log, self.values(z), self._high - self._low)

    def span(self) -> tuple[float, float]:
        """Return the first and the last time of all samples [s]."""
        times = [c.times for one in self.task.measurements for c in one.channels]
        return min(float(t[0]) for t in times), max(float(t[-1]) for t in times)

    def used(self, channel: Channel, horizon: float) -> slice:
        """Return the samples of a column up to a time."""
        return slice(0, int(np.searchsorted(channel.times, horizon, "right")))

    def count(self, channel: Channel, horizon: float) -> int:
        """Return the number of residuals of a column up to a time."""
        return self.used(channel, horizon).stop

    def stated(self, channel: Channel) -> bool:
        """Check whether the deviation of a residual is known."""
        return not math.isnan(channel.deviation)

    def groups(self, horizon: float) -> list[tuple[Channel, slice]]:
        """Return each column and its rows among the residuals up to a time."""
        found, first = [], 0
        for one in self.task.measurements:
            for channel in one.channels:
                count = self.count(channel, horizon)
                found.append((channel, slice(first, first + count)))
                first += count
        return found

    def sensor(self, z: Array, kind: str, m: int, c: int = -1) -> float:
        """Return the shift of a measurement, or the factor or bias of a column, fitted or given."""
        for k, place in enumerate(self.places):
            if place == (kind, m, c):
                return float(z[len(self.active) + k])
        one = self.task.measurements[m]
        if kind == "shift":
            return one.shift
        gain, offset = one.channels[c].gain, one.channels[c].offset
        factor = self.sensor(z, "factor", m, c) if math.isnan(gain) else 1.0 / gain
        return factor if kind == "factor" else -offset * factor

    def __call__(
        self, z: Array, horizon: float = math.inf, regressed: NDArray[np.bool_] | None = None, derivatives: bool = True
    ) -> Evaluated:
        """Evaluate the residuals of the samples up to a time.

        `regressed` (k,) marks factors and biases that a linear regression replaces by the best ones of this design.
        Without derivatives the Jacobian is zero.
        """
        z, parts, until = z.copy(), [], math.inf
        free = np.zeros(len(z), bool) if regressed is None else regressed
        for m, one in enumerate(self.task.measurements):
            try:
                found = self._measurement(m, one, z, horizon, free, derivatives)
            except (InputError, AssemblyError, RunError) as problem:
                return self._failed(z, horizon, str(problem))
            parts.append(found[:2])
            until = min(until, found[2])
        parts.append(self.priors(z))
        residual, jacobian = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
        if not np.isfinite(residual).all():
            return self._failed(z, horizon, "the residuals are not finite")
        return Evaluated(residual, jacobian, until, "", z)

    def _failed(self, z: Array, horizon: float, reason: str) -> Evaluated:
        count = sum(rows.stop - rows.start for _, rows in self.groups(horizon)) + len(self.priors(z)[0])
        return Evaluated(np.full(count, np.inf), np.zeros((count, len(z))), math.inf, reason, z)

    def priors(self, z: Array) -> tuple[Array, Array]:
        """Return the residuals of the priors, and their derivatives."""
        values, slopes, rows = self.values(z), self.slopes(z), []
        for k, j in enumerate(self.active):
            mean, deviation = self.task.priors[j]
            if not math.isnan(mean):
                line = np.zeros(len(z))
                line[k] = -slopes[k] / deviation
                rows.append(((mean - values[k]) / deviation, line))
        return np.array([r for r, _ in rows]), np.array([line for _, line in rows]).reshape(len(rows), len(z))

    def _measurement(
        self, m: int, one: Measurement, z: Array, horizon: float, free: NDArray[np.bool_], derivatives: bool
    ) -> tuple[Array, Array, float]:
        """Run one machine; residuals and derivatives of its columns, and the time with derivatives.

        Free factors and biases of its columns are set in z.
        """
        shift = self.sensor(z, "shift", m)
        used = [self.used(c, horizon) for c in one.channels]
        if not any(part.stop for part in used):
            return np.zeros(0), np.zeros((0, len(z))), math.inf
        mine = self.owned(one)
        paths, values = [self.task.paths[self.active[k]] for k in mine], self.values(z)[mine]
        end = max(float(c.times[part][-1]) for c, part in zip(one.channels, used, strict=True) if part.stop) + shift
        system = one.system.replaced({"duration": max(end, 1e-9)} | dict(zip(paths, map(float, values), strict=True)))
        moved = any(p.kind == "shift" and p.measurement == m for p in self.places)
        times = [c.times[part] + shift for c, part in zip(one.channels, used, strict=True)]
        wanted = [(c.output, at) for c, at in zip(one.channels, times, strict=True)]
        curves = Curves(system, paths, values, wanted, moved, derivatives)
        slopes, rows, lines = self.slopes(z)[mine], [], []
        for c, (channel, part) in enumerate(zip(one.channels, used, strict=True)):
            computed, rates, rate = curves(channel.output, times[c])
            left, basis = self.left(m, c, part, computed[:, None], z[None], free)
            factor = self.sensor(z, "factor", m, c)
            line = np.zeros((len(computed), len(z)))
            if derivatives:
                for j, k in enumerate(mine):  # one after the other: a million samples take little memory
                    line[:, k] = channel.filtered(np.nan_to_num(factor * rates[:, j] * slopes[j]))
                for k, place in enumerate(self.places, len(self.active)):
                    if place == ("shift", m, -1):
                        line[:, k] = channel.filtered(factor * rate)
                for k, column in basis.items():
                    line[:, k] = column[:, 0]
            row, line = self.compared(channel, part, left[:, 0], line, self.deviations[m][c])
            rows.append(row)
            lines.append(line)
        return np.concatenate(rows), np.concatenate(lines), curves.until

    def owned(self, one: Measurement) -> list[int]:
        """Return the active unknowns that a measurement has."""
        return [k for k, j in enumerate(self.active) if self.task.owners[j] in (None, one.name)]

    def left(
        self, m: int, c: int, part: slice, computed: Array, points: Array, free: NDArray[np.bool_]
    ) -> tuple[Array, dict[int, Array]]:
        """Return measured less computed samples (nt, np) of a column for runs with their values (np, k).

        `computed` (nt, np) are the outputs of the runs. Free factors and biases of the column are set in `points`.
        The dictionary has the derivatives (nt, np) of the filtered readings with respect to factor and bias.
        """
        channel, basis = self.task.measurements[m].channels[c], {}
        factor, bias = (np.array([self.sensor(z, kind, m, c) for z in points]) for kind in ("factor", "bias"))
        left = channel.filtered(channel.raw[part, None] - (factor * computed + bias))
        for k, place in enumerate(self.places, len(self.active)):
            if place == ("factor", m, c):
                basis[k] = channel.filtered(computed - (0.0 if math.isnan(channel.offset) else channel.offset))
            elif place == ("bias", m, c):
                basis[k] = channel.filtered(np.ones_like(computed))
        wanted = [k for k in basis if free[k]]
        for i in range(len(points) if wanted else 0):
            columns = np.column_stack([basis[k][:, i] for k in wanted])
            points[i, wanted] += regression(columns, left[:, i])
        if wanted:
            return self.left(m, c, part, computed, points, np.zeros_like(free))
        return left, basis

    def compared(
        self, channel: Channel, part: slice, left: Array, lines: Array, deviation: float
    ) -> tuple[Array, Array]:
        """Return residuals and their derivatives of a column, from its samples and the readings' derivatives.

        `left` are measured less computed samples. The derivatives may take the place of the given ones.
        """
        return left / deviation, np.divide(lines, -deviation, out=lines)


def _accurate(one: Measurement, accuracy: float) -> Measurement:
    if one.system.settings.accuracy <= accuracy:
        return one
    return replace(one, system=one.system.replaced({"solver.accuracy": accuracy}))
