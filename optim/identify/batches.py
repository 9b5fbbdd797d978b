"""The sum of squares of many values at once: runs in a batch, in threads, without derivatives."""

from __future__ import annotations

import math

import numpy as np

from linkages import simulate_batch
from linkages.base.arrays import Array
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
    """

    def __init__(self, residuals: Residuals, horizon: float, centre: Array, reach: Array) -> None:
        self._residuals = residuals
        measurements = range(len(residuals.task.measurements))
        self._batches = [_Batch(residuals, m, horizon, centre, reach) for m in measurements]

    def __call__(self, points: Array, threads: int | None = None) -> Array:
        """Return the sums (m,), with the residuals of the priors; infinite where a run fails."""
        total = np.array([np.sum(self._residuals.priors(z)[0] ** 2) for z in points])
        for batch in self._batches:
            total += batch.squares(points, threads)
        return np.where(np.isfinite(total), total, math.inf)


class _Batch:
    """Runs of the machine of measurement m.

    They have common times of samples. If a shift is fitted, each sample is taken at some shifts, and a polynomial
    interpolates it; samples before the beginning of a run are left out.
    """

    def __init__(self, residuals: Residuals, m: int, horizon: float, centre: Array, reach: Array) -> None:
        self._residuals, self._m, task = residuals, m, residuals.task
        self._one = one = task.measurements[m]
        self._mine = [k for k, j in enumerate(residuals.active) if task.owners[j] in (None, one.name)]
        ends = (residuals.lower, residuals.upper)
        self._limits = np.array([residuals.values(end)[self._mine] for end in ends])
        place = ("shift", m, -1)
        room = sum(reach[k] for k, one in enumerate(residuals.places, len(residuals.active)) if one == place)
        nodes = room * np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES) if room else np.zeros(1)
        self._nodes = nodes + residuals.sensor(centre, "shift", m)
        self._parts = [
            slice(int(np.searchsorted(c.times, -self._nodes.min())), residuals.used(c, horizon).stop)
            for c in one.channels
        ]
        times = [c.times[part, None] + self._nodes for c, part in zip(one.channels, self._parts, strict=True)]
        self._times = np.unique(np.concatenate([at.ravel() for at in times]))
        self._places = [np.searchsorted(self._times, at) for at in times]
        self._system = one.system.replaced({"duration": float(self._times[-1])}) if len(self._times) else one.system

    def squares(self, points: Array, threads: int | None) -> Array:
        """Return the sums of squares (m,) of all columns; NaN where a run fails."""
        residuals, m, channels = self._residuals, self._m, self._one.channels
        paths = [residuals.task.paths[residuals.active[k]] for k in self._mine]
        values = np.array([residuals.values(z)[self._mine] for z in points])
        outputs = list(dict.fromkeys(c.output for c in channels))
        found = simulate_batch(
            self._system, paths, values, outputs, None, threads, lambda part: None, limits=self._limits,
            samples=self._times,
        ).samples  # fmt: skip
        blend = _interpolation(self._nodes, np.array([residuals.sensor(z, "shift", m) for z in points]))
        result = np.zeros(len(points))
        for c, channel in enumerate(channels):
            factor, bias = np.array([[residuals.sensor(z, kind, m, c) for z in points] for kind in ("factor", "bias")])
            curves = found[:, self._places[c], outputs.index(channel.output)]
            computed = channel.filtered(factor * np.einsum("mtn,mn->tm", curves, blend) + bias)
            left = channel.values[self._parts[c], None] - computed
            result += np.sum((left / residuals.deviations[m][c]) ** 2, axis=0)
        return result


def _interpolation(nodes: Array, at: Array) -> Array:
    """Return the weights (m, nn) of values at nodes (nn,) in the values of a polynomial at m places."""
    scale = float(np.ptp(nodes)) or 1.0
    powers = np.vander((nodes - nodes.mean()) / scale)
    return np.asarray(np.vander((at - nodes.mean()) / scale, len(nodes)) @ np.linalg.inv(powers), np.float64)
