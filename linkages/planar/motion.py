"""Prescribed motions and torques over time as piecewise polynomials, for compiled evaluation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.kernel import Array, Indices, inlined_kernel, kernel

#: Piecewise polynomials: breaks (n, ns + 1), coefficients (n, ns, order) and number of segments (n,).
Curves = tuple[Array, Array, Indices]


class Pieces(NamedTuple):
    """A piecewise polynomial: the first and last pieces extend to all times."""

    c: Array  # coefficients of powers of the time since each piece's start, highest power first, (order, n)
    x: Array  # breaks between the pieces [s], (n + 1,)


def constant_rate(start: float, speed: float) -> Pieces:
    """Start + speed * t, for all t."""
    return Pieces(np.array([[speed], [start]]), np.array([0.0, 1.0]))


def ramped_rate(start: float, speed: float, ramp: float) -> Pieces:
    """From rest to a constant speed in the time `ramp` [s], twice differentiable in the speed.

    The speed is speed * (10 s^3 - 15 s^4 + 6 s^5) with s = t/ramp; then it is constant.
    """
    smooth = speed * np.array([6 / ramp**5 / 6, -15 / ramp**4 / 5, 10 / ramp**3 / 4, 0.0, 0.0, 0.0, 0.0])
    smooth[-1] = start
    end = start + 0.5 * speed * ramp
    after = np.array([0.0, 0.0, 0.0, 0.0, 0.0, speed, end])
    return Pieces(np.stack([smooth, after], axis=1), np.array([0.0, ramp, 2.0 * ramp]))


def table(times: Sequence[float], values: Sequence[float]) -> Pieces:
    """Cubic spline through a table (a straight line through two points)."""
    if len(times) < 4:
        slopes = np.diff(values) / np.diff(times)
        return Pieces(np.stack([slopes, np.asarray(values[:-1], float)]), np.asarray(times, float))
    from scipy.interpolate import CubicSpline  # half a second; most experiments have no tables

    spline = CubicSpline(times, values)
    return Pieces(spline.c, spline.x)


def monotone_table(times: Sequence[float], values: Sequence[float]) -> Pieces:
    """Monotone cubic through a table (Fritsch and Butland, 1984): between two values it never leaves their range."""
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(times, values)
    return Pieces(curve.c, curve.x)


class Motions:
    """Several piecewise polynomials packed into arrays for `evaluate_motions`."""

    def __init__(self, pieces: Sequence[Pieces]) -> None:
        self.pieces = tuple(pieces)
        n = len(self.pieces)
        longest = max((len(p.x) for p in self.pieces), default=2)
        order = max((len(p.c) for p in self.pieces), default=1)
        self.breaks = np.full((n, longest), np.inf)
        self.coefficients = np.zeros((n, longest - 1, order))
        self.segments = np.zeros(n, dtype=np.int64)
        for i, p in enumerate(self.pieces):
            self.breaks[i, : len(p.x)] = p.x
            self.segments[i] = len(p.x) - 1
            self.coefficients[i, : len(p.x) - 1, order - len(p.c) :] = p.c.T

    @property
    def arrays(self) -> Curves:
        """The curves for compiled code."""
        return self.breaks, self.coefficients, self.segments

    def __call__(self, times: Array) -> tuple[Array, Array, Array]:
        """Values, rates and second derivatives (nt, n) at the given times."""
        shape = (len(times), len(self.pieces))
        out = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        _tabulate(self.arrays, np.asarray(times, dtype=np.float64), *out)
        return out


@kernel
def _tabulate(curves: Curves, times: Array, value: Array, rate: Array, acceleration: Array) -> None:
    """Fill value, rate and acceleration (nt, n) over time."""
    for k in range(len(times)):
        evaluate_motions(curves, times[k], value[k], rate[k], acceleration[k])


@inlined_kernel
def last_start(starts: Array, n: int, t: float) -> int:
    """Last of n rising starts that is not after t; the first if all are."""
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if starts[middle] <= t:
            low = middle
        else:
            high = middle
    return low


@kernel
def motion_value(curves: Curves, i: int, t: float) -> float:
    """Value of polynomial i alone; see `evaluate_motions`."""
    breaks, coefficients, segments = curves
    k = last_start(breaks[i], segments[i], t)
    s = t - breaks[i, k]
    value = 0.0
    for m in range(coefficients.shape[2]):
        value = value * s + coefficients[i, k, m]
    return value


@kernel
def evaluate_motions(curves: Curves, t: float, value: Array, rate: Array, acceleration: Array) -> None:
    """Fill value, rate and acceleration (n,) at time t; the first and last pieces extend to all times."""
    breaks, coefficients, segments = curves
    for i in range(len(segments)):
        k = last_start(breaks[i], segments[i], t)
        s = t - breaks[i, k]
        p0, p1, p2 = 0.0, 0.0, 0.0
        for c in coefficients[i, k]:
            p2 = p2 * s + 2.0 * p1
            p1 = p1 * s + p0
            p0 = p0 * s + c
        value[i], rate[i], acceleration[i] = p0, p1, p2
