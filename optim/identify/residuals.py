"""Residuals of an identification: measured less computed samples, and their derivatives, from one run each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from linkages import AssemblyError, InputError, RunError, Status, System, simulate, simulate_batch
from linkages.base.arrays import Array
from linkages.input.model.capabilities import Analysis
from linkages.results.outputs.columns import Columns
from optim.identify.load import SHIFT, Channel, Identification, Measurement

_UNKNOWN = 0.01  # deviation of a sample relative to the spread of its column, before residuals tell it
_STEP = 1e-3  # step of differences with respect to time, relative to the interval of samples
_DIFFERENCE = 1e-5  # step of differences of runs, for models without derivatives, in the unknown's own scale
_HOPELESS = 1e3  # residual of each sample of a design that does not run, in deviations


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
        Measured less computed samples, in deviations; then those of the priors.
    jacobian : (r, k) array
        Their derivatives with respect to the scaled values; zero where there is none.
    until : float
        Time up to which derivatives are known [s].
    reason : str
        Why the design does not run; empty if it does.
    """

    residual: Array
    jacobian: Array
    until: float
    reason: str


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
            [_UNKNOWN * float(np.std(c.values)) if math.isnan(c.deviation) else c.deviation for c in one.channels]
            for one in task.measurements
        ]

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

    def __call__(self, z: Array, horizon: float = math.inf) -> Evaluated:
        """Evaluate the residuals of the samples up to a time."""
        parts, until, reason = [], math.inf, ""
        for m, one in enumerate(self.task.measurements):
            try:
                found = self._measurement(m, one, z, horizon)
            except (InputError, AssemblyError, RunError) as problem:
                found, reason = None, str(problem)
            if found is None:
                count = sum(self.count(c, horizon) for c in one.channels)
                parts.append((np.full(count, _HOPELESS), np.zeros((count, len(z)))))
                continue
            parts.append(found[:2])
            until = min(until, found[2])
        parts.append(self.priors(z))
        residual, jacobian = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
        return Evaluated(residual, jacobian, until, reason)

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

    def _measurement(self, m: int, one: Measurement, z: Array, horizon: float) -> tuple[Array, Array, float]:
        """Run one machine; residuals and derivatives of its columns, and the time with derivatives."""
        shift, n = self.sensor(z, "shift", m), len(self.active)
        used = [self.used(c, horizon) for c in one.channels]
        if not any(part.stop for part in used):
            return np.zeros(0), np.zeros((0, len(z))), math.inf
        mine = [k for k, j in enumerate(self.active) if self.task.owners[j] in (None, one.name)]
        paths, values = [self.task.paths[self.active[k]] for k in mine], self.values(z)[mine]
        end = max(float(c.times[part][-1]) for c, part in zip(one.channels, used, strict=True) if part.stop) + shift
        system = one.system.replaced({"duration": max(end, 1e-9)} | dict(zip(paths, map(float, values), strict=True)))
        moved = any(p.kind == "shift" and p.measurement == m for p in self.places)
        curves = _Curves(system, paths, values, [c.output for c in one.channels])
        slopes, rows, lines = self.slopes(z)[mine], [], []
        for c, (channel, part) in enumerate(zip(one.channels, used, strict=True)):
            times = channel.times[part] + shift
            computed, rates, rate = curves(channel.output, times, moved)
            factor, bias = self.sensor(z, "factor", m, c), self.sensor(z, "bias", m, c)
            line = np.zeros((len(times), len(z)))
            line[:, mine] = factor * rates * slopes
            for k, place in enumerate(self.places, n):
                if place == ("shift", m, -1):
                    line[:, k] = factor * rate
                elif place == ("factor", m, c):
                    fixed = 0.0 if math.isnan(channel.offset) else -channel.offset
                    line[:, k] = computed + fixed
                elif place == ("bias", m, c):
                    line[:, k] = 1.0
            samples = channel.filtered(factor * computed + bias), channel.filtered(np.nan_to_num(line))
            row, line = self.compared(channel, part, *samples, self.deviations[m][c])
            rows.append(row)
            lines.append(line)
        return np.concatenate(rows), np.concatenate(lines), curves.until

    def compared(
        self, channel: Channel, part: slice, computed: Array, lines: Array, deviation: float
    ) -> tuple[Array, Array]:
        """Return residuals and their derivatives of a column from computed samples and their derivatives."""
        return (channel.values[part] - computed) / deviation, -lines / deviation


class _Curves:
    """Outputs of a run and their derivatives at any times; beyond the run's ends they continue in straight lines.

    `until` is the time up to which derivatives are known [s]. RunError if the run does not reach its end.
    """

    def __init__(self, system: System, paths: list[str], values: Array, outputs: list[str]) -> None:
        self.system, self.paths, self.numbers = system, paths, values
        self.outputs = list(dict.fromkeys(outputs))
        try:
            system.check_analysis(Analysis.DERIVATIVES)
            self._exact = True
        except InputError:
            self._exact = False
        self._run = simulate(system, outputs=self.outputs, wrt=paths if self._exact else ())
        self._computed: dict[bytes, Columns] = {}
        self._known: dict[bytes, dict[str, Columns]] = {}
        self.end = float(self._run.time[-1])
        if self._run.status is not Status.OK:
            raise RunError(f"the run ended at t = {self.end:.6g} s: {self._run.status.value}")
        self.until = self._run.sensitivity.until if self._exact else math.inf

    def __call__(self, output: str, times: Array, moved: bool) -> tuple[Array, Array, Array]:
        """Return an output (nt,), its derivatives with respect to the values (nt, np), and to time (nt,)."""
        inside = np.clip(times, 0.0, self.end)
        step = _STEP * float(np.diff(times).mean()) if len(times) > 1 else _STEP * self.end
        computed, rate = self._at(output, inside), np.zeros(len(times))
        if moved or np.any(times != inside):
            after, before = np.minimum(inside + step, self.end), np.maximum(inside - step, 0.0)
            rate = (self._at(output, after) - self._at(output, before)) / (after - before)
        return computed + rate * (times - inside), self._rates(output, inside), rate

    def _at(self, output: str, times: Array) -> Array:
        assert self._run.evaluate is not None
        key = times.tobytes()
        if key not in self._computed:  # columns of a file have the same times
            self._computed[key] = self._run.evaluate(times)
        return np.asarray(self._computed[key][output], np.float64)

    def _rates(self, output: str, times: Array) -> Array:
        if not self.paths:
            return np.zeros((len(times), 0))
        if self._exact:
            key = times.tobytes()
            if key not in self._known:
                self._known[key] = self._run.sensitivity.evaluate(times)
            found = self._known[key]
            return np.column_stack([found[path][output] for path in self.paths])
        return self._differences(output, times)

    def _differences(self, output: str, times: Array) -> Array:
        """Central differences of runs, for models without derivatives."""
        steps = _DIFFERENCE * np.maximum(np.abs(self.numbers), 1e-9)
        table = np.concatenate([self.numbers + sign * np.diag(steps) for sign in (1.0, -1.0)])
        grid, places = np.unique(times, return_inverse=True)
        batch = simulate_batch(self.system, self.paths, table, [output], samples=grid, progress=lambda part: None)
        plus, minus = np.split(batch.samples[:, :, 0], 2)
        return np.asarray(((plus - minus) / (2.0 * steps[:, None])).T[places], np.float64)
