"""The sum of squares of many values at once: runs in a batch, in threads, without derivatives."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.engines.compiled.batch.batch import run_batch
from optim.identify.curves import step_in_time
from optim.identify.load import Channel
from optim.identify.residuals import Residuals

_NODES = 5  # shifts of a clock between which samples are interpolated


class SumsOfSquares:
    """The sum of squares of the residuals up to a time, as a function of many scaled values (m, k).

    Parameters
    ----------
    residuals : Residuals
    horizon : float
        Time up to which samples count [s].
    centre, reach : (k,) arrays
        Values around which fitted shifts of clocks lie, and their largest distances from them [s]; other values are
        not limited.
    regressed : (k,) array of bool, optional
        Factors and biases that a linear regression replaces by the best ones of each design; default: none.
    """

    def __init__(
        self,
        residuals: Residuals,
        horizon: float,
        centre: Array,
        reach: Array,
        regressed: NDArray[np.bool_] | None = None,
    ) -> None:
        self._residuals = residuals
        self._free = np.zeros(len(centre), bool) if regressed is None else regressed
        measurements = range(len(residuals.task.measurements))
        self._batches = [_Batch(residuals, m, horizon, centre, reach) for m in measurements]

    def __call__(self, points: Array, threads: int | None = None) -> Array:
        """Return the sums (m,), with the residuals of the priors; infinite where a run fails."""
        total = np.array([np.sum(self._residuals.priors(z)[0] ** 2) for z in points])
        for batch in self._batches:
            total += batch.squares(points.copy(), self._free, threads)
        return np.where(np.isfinite(total), total, math.inf)


class _Batch:
    """Runs of the machine of measurement m.

    They have common times of samples. If a shift is fitted, each sample is taken at some shifts within the run, and a
    polynomial interpolates it; before the beginning of a run it continues in a straight line, as in a single run.
    """

    def __init__(self, residuals: Residuals, m: int, horizon: float, centre: Array, reach: Array) -> None:
        self._residuals, self._m, task = residuals, m, residuals.task
        self._one = one = task.measurements[m]
        self._mine = residuals.owned(one)
        ends = (residuals.lower, residuals.upper)
        self._limits = np.array([residuals.values(end)[self._mine] for end in ends])
        place = ("shift", m, -1)
        room = sum(reach[k] for k, one in enumerate(residuals.places, len(residuals.active)) if one == place)
        middle = residuals.sensor(centre, "shift", m)
        self._low, self._high = middle - room, middle + room
        self._parts = [residuals.used(c, horizon) for c in one.channels]
        times = [self._nodes(c, part) for c, part in zip(one.channels, self._parts, strict=True)]
        self._times = np.unique(np.concatenate([at.ravel() for at in times]))
        self._places = [np.searchsorted(self._times, at) for at in times]
        self._system = one.system.replaced({"duration": float(self._times[-1])}) if len(self._times) else one.system

    def _nodes(self, channel: Channel, part: slice) -> Array:
        """Return the times (n, _NODES + 2) of a column: the nodes of each sample, and both of the run's beginning."""
        times = channel.times[part, None]
        first, last = np.maximum(times + self._low, 0.0), np.maximum(times + self._high, 0.0)
        beginning = np.zeros((len(times), 2))
        if np.any(times + self._low < 0.0):
            beginning[:, 1] = step_in_time(channel.times[part], float(last[-1, 0]))
        return np.hstack([first + (last - first) * _UNIT, beginning])

    def squares(self, points: Array, free: NDArray[np.bool_], threads: int | None) -> Array:
        """Return the sums of squares (m,) of all columns; NaN where a run fails."""
        residuals, m, channels = self._residuals, self._m, self._one.channels
        paths = [residuals.task.paths[residuals.active[k]] for k in self._mine]
        values = np.array([residuals.values(z)[self._mine] for z in points])
        outputs = list(dict.fromkeys(c.output for c in channels))
        found = run_batch(
            self._system, paths, values, outputs, None, threads, lambda part: None, limits=self._limits,
            samples=self._times,
        ).samples  # fmt: skip
        shifts, result = np.array([residuals.sensor(z, "shift", m) for z in points]), np.zeros(len(points))
        for c, channel in enumerate(channels):
            curves = found[:, :, outputs.index(channel.output)]
            left, _ = residuals.left(m, c, self._parts[c], self._shifted(c, curves, shifts), points, free)
            result += np.sum((left / residuals.deviations[m][c]) ** 2, axis=0)
        return result

    def _shifted(self, c: int, curves: Array, shifts: Array) -> Array:
        """Return the samples (n, m) of a column at the shifts of m runs, from their curves (m, nt)."""
        places, times = self._places[c], self._one.channels[c].times[self._parts[c]]
        early = int(np.searchsorted(times, -self._low))  # their nodes are not those of the others
        result = np.empty((len(times), len(shifts)))
        room = self._high - self._low
        weights = _weights((shifts - self._low) / room if room else 0.0 * shifts)
        result[early:] = np.einsum("mtn,mn->tm", curves[:, places[early:, :_NODES]], weights)
        for i in range(early):
            first, last = self._times[places[i, [0, _NODES - 1]]]
            at = times[i] + shifts
            weights = _weights((np.maximum(at, 0.0) - first) / (last - first) if last > first else 0.0 * at)
            start, next_one = places[i, _NODES:]
            rate = (curves[:, next_one] - curves[:, start]) / (self._times[next_one] - self._times[start])
            result[i] = np.sum(curves[:, places[i, :_NODES]] * weights, axis=1) + rate * np.minimum(at, 0.0)
        return result


#: Nodes of the interpolation between 0 and 1, with both ends.
_UNIT = 0.5 - 0.5 * np.cos(np.pi * np.arange(_NODES) / (_NODES - 1))


def _weights(at: Array) -> Array:
    """Return the weights (m, _NODES) of values at the nodes in the values of their polynomial at m places."""
    return np.asarray(np.vander(at - 0.5, _NODES) @ np.linalg.inv(np.vander(_UNIT - 0.5)), np.float64)
