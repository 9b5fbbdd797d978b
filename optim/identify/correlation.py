"""Correlation of neighbouring residuals, and the covariance of their sums."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter
from scipy.stats import norm

from linkages.base.arrays import Array

DOUBT = 1e-3  # probability below which a test warns
FEWEST = 20  # samples for tests


class Correlation(NamedTuple):
    """Correlation of neighbouring residuals: a process of first order, driven by residuals that correlate shortly.

    Attributes
    ----------
    first : float
        Coefficient of the process; zero for residuals that do not correlate.
    rest : array
        Covariances of what drives it, by lag, for residuals of variance 1.
    time : float
        Number of residuals that count as one; 1 for independent ones, at most all of them.
    """

    first: float
    rest: Array
    time: float


INDEPENDENT = Correlation(0.0, np.ones(1), 1.0)


def correlation_of(residual: Array) -> Correlation:
    """Estimate the correlation of residuals, as Andrews and Monahan (1992) for variances: whiten, count, colour again.

    The coefficient is Kendall's (1954), without bias; covariances of the rest count in pairs up to the first
    negative one (Geyer 1992). Residuals are independent unless neighbours correlate significantly.
    """
    n = len(residual)
    if n < FEWEST or not np.any(residual):
        return INDEPENDENT
    first = float(residual[:-1] @ residual[1:] / (residual[:-1] @ residual[:-1]))
    certain = norm.ppf(1.0 - DOUBT / 2.0) / math.sqrt(n)
    if abs(first) < certain:
        return INDEPENDENT
    first = float(np.clip(first + (1.0 + 3.0 * first) / n, 1.0 / n - 1.0, 1.0 - 1.0 / n))
    drive = residual[1:] - first * residual[:-1]
    power = np.abs(np.fft.rfft(drive, _length(n))) ** 2
    rest = np.fft.irfft(power)[: n // 2]
    pairs = rest[: len(rest) // 2 * 2].reshape(-1, 2).sum(axis=1)
    negative = np.flatnonzero(pairs <= 0.0)
    rest = rest[: 2 * negative[0] if len(negative) else len(rest)] if abs(rest[1]) > certain * rest[0] else rest[:1]
    rest = rest * (1.0 - first**2) / (2.0 * np.sum(rest * first ** np.arange(len(rest))) - rest[0])
    time = (2.0 * float(rest.sum()) - float(rest[0])) / (1.0 - first) ** 2
    return Correlation(first, rest, min(max(time, 1.0), float(n)))


def _length(n: int) -> int:
    """Return a length of transforms in which n numbers do not meet their repetition."""
    return int(2 ** math.ceil(math.log2(2 * n)))


def coloured(rows: Array, correlation: Correlation) -> Array:
    """Return the covariance (k, k) of sums of correlated residuals (n,) of variance 1 with weights (n, k)."""
    if correlation is INDEPENDENT:
        return np.asarray(rows.T @ rows, np.float64)
    first, rest, _ = correlation
    sums = lfilter([1.0], [1.0, -first], rows[::-1], axis=0)[::-1].copy()
    sums[0] /= math.sqrt(1.0 - first**2)
    size = _length(len(sums))
    kernel = np.zeros(size)
    kernel[: len(rest)], kernel[size - len(rest) + 1 :] = rest, rest[:0:-1]
    spread = np.fft.irfft(np.fft.rfft(sums, size, axis=0) * np.fft.rfft(kernel)[:, None], size, axis=0)[: len(sums)]
    return np.asarray(0.5 * (sums.T @ spread + spread.T @ sums), np.float64)
