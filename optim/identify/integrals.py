"""Integrals of the samples over first impacts: they lead from a distant start to where samples can be compared.

An impact is a peak in forces and accelerations, which says nothing unless a computed one overlaps it. Its integral is a
step, and the integral of that a bend: computed ones come closer without a jump.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks
from scipy.stats import qmc

from linkages.base.arrays import Array
from linkages.engines.compiled.batch.batch import run_batch
from optim.identify.filters import filtered
from optim.identify.load import Channel, Measurement
from optim.identify.numerics import (
    INTEGRALS_BEYOND,
    INTEGRALS_CERTAIN,
    INTEGRALS_DEVIATION,
    INTEGRALS_HEIGHT,
    INTEGRALS_IMPACTS,
    INTEGRALS_PART,
    INTEGRALS_SAMPLES,
    INTEGRALS_SHIFT,
    INTEGRALS_SHIFTS,
    INTEGRALS_TIME,
)
from optim.identify.residuals import Residuals

ORDERS = (2, 1)  # of the integrals that lead a search, in turn
_POINTS = 6, 10  # binary logarithm of the number of designs: with each unknown one more, up to the second


@dataclass(frozen=True, eq=False)
class Integrated(Channel):
    """A column whose samples are integrated: sums from the first one on, again and again."""

    order: int

    def filtered(self, rows: Array) -> Array:
        """Filter and integrate samples (n, ...)."""
        return _sums(filtered(rows, self.sections), self.order)


def _sums(rows: Array, order: int) -> Array:
    for _ in range(order):
        rows = np.cumsum(rows, axis=0)
    return rows


def integrated(residuals: Residuals, horizon: float, order: int) -> Residuals:
    """Return the residuals of the integrals of all columns up to a time."""
    other, deviations, measurements = copy.copy(residuals), [], []
    for one in residuals.task.measurements:
        channels = [Integrated(**vars(c), order=order) for c in one.channels]
        measurements.append(replace(one, channels=tuple(channels)))
        parts = [c.raw[residuals.used(c, horizon)] for c in channels]
        spreads = (
            float(np.std(c.filtered(part - part.mean()))) if len(part) else 0.0
            for c, part in zip(channels, parts, strict=True)
        )
        deviations.append([INTEGRALS_DEVIATION * x or 1.0 for x in spreads])
    other.task, other.deviations = replace(residuals.task, measurements=tuple(measurements)), deviations
    return other


def impacts_end(residuals: Residuals, last: float) -> float:
    """Return the end of a window [s] with the first impacts of each column; the first sample's time without impacts."""
    first, ends = residuals.span()[0], [residuals.span()[0]]
    for m, one in enumerate(residuals.task.measurements):
        for c, channel in enumerate(one.channels):
            values = channel.values[residuals.used(channel, last)]
            if not len(values):
                continue
            height = max(INTEGRALS_HEIGHT * float(np.ptp(values)), INTEGRALS_CERTAIN * residuals.deviations[m][c])
            at = find_peaks(np.abs(values - np.median(values)), prominence=height)[0][:INTEGRALS_IMPACTS]
            ends += channel.times[at].tolist()
    return min(first + INTEGRALS_BEYOND * (max(ends) - first), last)


def near_starts(residuals: Residuals, count: int, seed: int, horizon: float) -> Array:
    """Return the starts (count, k) whose double integrals come closest, of designs spread between the limits.

    Each design has its best factors, biases and shifts of clocks. No further designs are tried after a part of the
    limit of time.
    """
    n = len(residuals.active)
    size = 2 ** min(_POINTS[0] + n, _POINTS[1])
    points = np.tile(residuals.start, (size, 1))
    spread = qmc.Sobol(n, rng=np.random.default_rng(seed)).random(size)
    points[:, :n] = residuals.lower[:n] + spread * (residuals.upper - residuals.lower)[:n]
    of_integrals, costs = integrated(residuals, horizon, ORDERS[0]), np.full(size, np.inf)
    for first in range(0, size, INTEGRALS_PART):
        part = slice(first, first + INTEGRALS_PART)
        costs[part] = _costs(of_integrals, points[part], horizon)
        if residuals.budget.used > INTEGRALS_TIME:
            break
    return points[np.argsort(costs, kind="stable")[:count]]


def _costs(residuals: Residuals, points: Array, horizon: float) -> Array:
    """Return the sums of squares of designs (m,); sets their shifts."""
    costs = np.array([np.sum(residuals.priors(z)[0] ** 2) for z in points])
    for m, one in enumerate(residuals.task.measurements):
        if any(residuals.used(c, horizon).stop for c in one.channels):
            costs += _costs_of(residuals, m, one, points, horizon)
    return np.where(np.isfinite(costs), costs, np.inf)


def _costs_of(residuals: Residuals, m: int, one: Measurement, points: Array, horizon: float) -> Array:
    times = one.channels[0].times[residuals.used(one.channels[0], horizon)]  # one clock for all columns of a file
    interval = max(float(np.median(np.diff(times))), float(np.ptp(times)) / INTEGRALS_SAMPLES)
    places = [k for k, place in enumerate(residuals.places, len(residuals.active)) if place == ("shift", m, -1)]
    moves = np.zeros(1, np.intp)
    if places:
        most = int(min(residuals.upper[places[0]], INTEGRALS_SHIFT * float(np.ptp(times))) / interval)
        moves = np.arange(-most, most + 1, max(1, 2 * most // INTEGRALS_SHIFTS))
    count = int(np.ptp(times) / interval) + 1
    first = round((float(times[0]) + (0.0 if places else one.shift)) / interval)
    grid: Array = interval * np.arange(max(first + count + int(moves.max()), 2), dtype=np.float64)
    mine, outputs = residuals.owned(one), list(dict.fromkeys(c.output for c in one.channels))
    batch: Any = run_batch(
        one.system.replaced({"duration": float(grid[-1])}), [residuals.task.paths[residuals.active[k]] for k in mine],
        np.array([residuals.values(z)[mine] for z in points]), outputs, samples=grid, progress=lambda part: None,
    )  # fmt: skip
    total = np.zeros((len(moves), len(points)))
    for c, channel in enumerate(one.channels):
        measured = np.interp(times[0] + interval * np.arange(count), channel.times, channel.values)
        deviation, curves = residuals.deviations[m][c], batch.samples[:, :, outputs.index(channel.output)].T
        free = [math.isnan(channel.gain), math.isnan(channel.offset)]
        compare = partial(_least, measured, free=free, channel=channel)
        scale = (len(times) / count) ** ORDERS[0] / deviation  # sums of fewer samples are less
        for i, move in enumerate(moves):
            total[i] += scale**2 * compare(curves[np.clip(first + move + np.arange(count), 0, None)])
    if places:
        points[:, places[0]] = interval * moves[np.argmin(np.nan_to_num(total, nan=np.inf), axis=0)]
    return np.asarray(total.min(axis=0), np.float64)


def _least(measured: Array, computed: Array, free: list[bool], channel: Channel) -> Array:
    """Return the sums of squares (m,) of integrals of measured (n,) less computed samples (n, m), with free sensors."""
    order, offset = ORDERS[0], 0.0 if free[1] else channel.offset
    columns = [_sums(computed - offset, order)] if free[0] else []
    columns += [np.broadcast_to(_sums(np.ones((len(measured), 1)), order), computed.shape)] if free[1] else []
    known = 0.0 if free[0] else (computed - offset) / channel.gain
    left = _sums(np.broadcast_to(measured[:, None] - known, computed.shape), order)
    for k, column in enumerate(columns):  # Gram and Schmidt
        for other in columns[:k]:
            column = column - other * (np.sum(other * column, axis=0) / _size(other))
        columns[k] = column
        left = left - column * (np.sum(column * left, axis=0) / _size(column))
    return np.asarray(np.sum(left**2, axis=0), np.float64)


def _size(column: Array) -> NDArray[np.float64]:
    return np.asarray(np.maximum(np.sum(column**2, axis=0), np.finfo(float).tiny), np.float64)
