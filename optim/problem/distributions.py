"""Distributions of scattering values: a fit, a shape of SciPy, or measured values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from linkages import Fit, InputError
from linkages.base.arrays import Array

_SIGMAS = 3.0  # limits of a value without limits, in deviations
_ROUNDING = 1e-12  # relative difference of measured values that counts as none
_HALVINGS = 60  # of an interval, for a quantile


class Marginal(NamedTuple):
    """Distribution of one value.

    Attributes
    ----------
    law : object
        With the methods ``ppf``, ``cdf``, ``pdf``, ``mean`` and ``std`` of a frozen distribution of SciPy.
    lower, upper : float
        Limits of the tolerance.
    """

    law: Any
    lower: float
    upper: float

    def moved(self, offset: float) -> Marginal:
        """Return the distribution of the value plus an offset."""
        return Marginal(Scaled(self.law, 1.0, offset), self.lower + offset, self.upper + offset)

    def narrowed(self, factor: float) -> Marginal:
        """Return the distribution with deviation and limits times a factor, about the same mean."""
        mean = float(self.law.mean())
        lower, upper = (mean + factor * (end - mean) for end in (self.lower, self.upper))
        return Marginal(Scaled(self.law, factor, (1.0 - factor) * mean), lower, upper)


@dataclass(frozen=True)
class Scaled:
    """Distribution of ``factor * X + offset``, the factor positive."""

    law: Any
    factor: float
    offset: float

    def ppf(self, share: Array) -> Array:
        """Return quantiles."""
        return np.asarray(self.offset + self.factor * self.law.ppf(share))

    def cdf(self, x: Array) -> Array:
        """Return the probability of values below x."""
        return np.asarray(self.law.cdf((x - self.offset) / self.factor))

    def pdf(self, x: Array) -> Array:
        """Return the density at x."""
        return np.asarray(self.law.pdf((x - self.offset) / self.factor) / self.factor)

    def mean(self) -> float:
        """Return the mean."""
        return float(self.offset + self.factor * self.law.mean())

    def std(self) -> float:
        """Return the standard deviation."""
        return float(self.factor * self.law.std())


class UniformSum:
    """Distribution of a sum of independent uniform values, about its middle.

    W. Feller, An Introduction to Probability Theory and Its Applications, vol. 2, 2nd ed. 1971, I.9: truncated powers.
    """

    def __init__(self, middle: float, widths: Sequence[float]) -> None:
        self.middle, self.widths, self.half = middle, np.array(widths), 0.5 * math.fsum(widths)
        corners = np.array(list(product((0, 1), repeat=len(widths))))
        self._steps, self._signs = corners @ self.widths, (-1.0) ** corners.sum(axis=1)

    def cdf(self, x: Array) -> Array:
        """Return the probability of values below x."""
        away = np.asarray(x, dtype=float) - self.middle
        tail = self._power(self.half - np.abs(away), len(self.widths))
        return np.asarray(np.where(away < 0.0, tail, 1.0 - tail))

    def pdf(self, x: Array) -> Array:
        """Return the density at x."""
        return self._power(self.half - np.abs(np.asarray(x, dtype=float) - self.middle), len(self.widths) - 1)

    def ppf(self, share: Array) -> Array:
        """Return quantiles, by bisection."""
        share = np.asarray(share, dtype=float)
        lower, upper = np.full((2, *share.shape), self.middle) + self.half * np.array([-1.0, 1.0]).reshape(
            2, *[1] * share.ndim
        )
        for _ in range(_HALVINGS):
            middle = 0.5 * (lower + upper)
            below = self.cdf(middle) < share
            lower, upper = np.where(below, middle, lower), np.where(below, upper, middle)
        return np.asarray(0.5 * (lower + upper))

    def mean(self) -> float:
        """Return the mean."""
        return self.middle

    def std(self) -> float:
        """Return the standard deviation."""
        return math.sqrt(float(np.sum(self.widths**2)) / 12.0)

    def _power(self, from_end: Array, degree: int) -> Array:
        """Sum truncated powers of the distance from the lower end."""
        powers = np.maximum(from_end[..., None] - self._steps, 0.0) ** degree * (from_end[..., None] > self._steps)
        return np.asarray(powers @ self._signs / (math.factorial(degree) * np.prod(self.widths)))


class Empirical:
    """Distribution of measured values: their quantiles, linear between them."""

    def __init__(self, values: Array) -> None:
        self.values = np.sort(values)
        self._shares = np.linspace(0.0, 1.0, len(values))

    def ppf(self, share: Array) -> Array:
        """Return quantiles."""
        return np.interp(share, self._shares, self.values)

    def cdf(self, x: Array) -> Array:
        """Return the probability of values below x."""
        return np.interp(x, self.values, self._shares)

    def pdf(self, x: Array) -> Array:
        """Return the density at x, infinite at a value that occurs twice."""
        part = np.clip(np.searchsorted(self.values, x, side="right") - 1, 0, len(self.values) - 2)
        inside = (self.values[0] <= x) & (x <= self.values[-1])
        with np.errstate(divide="ignore"):
            density = np.where(inside, (self._shares[1] / np.diff(self.values))[part], 0.0)
        twice = self.values[1:][np.diff(self.values) == 0.0]
        rounding = _ROUNDING * float(np.abs(self.values).max())
        at_one = np.any(np.abs(np.asarray(x)[..., None] - twice) <= rounding, axis=-1)
        return np.asarray(np.where(at_one, np.inf, density))

    def mean(self) -> float:
        """Return the mean of the piecewise linear quantiles."""
        return float(np.mean(0.5 * (self.values[1:] + self.values[:-1])))

    def std(self) -> float:
        """Return the standard deviation of the piecewise linear quantiles."""
        a, b = self.values[:-1], self.values[1:]
        return math.sqrt(max(float(np.mean((a * a + a * b + b * b) / 3.0)) - self.mean() ** 2, 0.0))


def of_fit(limits: Fit, parts: str) -> Marginal:
    """Return the distribution of the radial clearance of a fit whose hole and shaft are independent.

    The tolerances of the `parts` are "normal", with limits at three deviations, "uniform" or "triangular".
    """
    lower, upper = (0.5 * end for end in limits.clearance)
    widths = [0.5 * (high - low) for low, high in (limits.hole, limits.shaft)]
    middle = 0.5 * (lower + upper)
    if parts == "normal":
        from scipy.stats import norm

        return Marginal(norm(middle, math.hypot(*widths) / (2.0 * _SIGMAS)), lower, upper)
    if parts == "triangular":
        widths = [0.5 * width for width in widths for _ in range(2)]
    return Marginal(UniformSum(middle, widths), lower, upper)


def of_shape(kind: str, numbers: Sequence[float]) -> Marginal:
    """Return a distribution by its kind and parameters; ValueError with one sentence if they are not valid."""
    from scipy import stats

    def ordered(low: float, high: float) -> None:
        if not low < high:
            raise ValueError(f"has the limits {low:g} and {high:g}; the lower one must come first")

    def positive(deviation: float) -> None:
        if not deviation > 0.0:
            raise ValueError(f"has the deviation {deviation:g}; it must be positive")

    if kind == "uniform":
        low, high = numbers
        ordered(low, high)
        return Marginal(stats.uniform(low, high - low), low, high)
    if kind == "triangular":
        low, mode, high = numbers
        ordered(low, high)
        if not low <= mode <= high:
            raise ValueError(f"has the mode {mode:g}; it must lie between {low:g} and {high:g}")
        return Marginal(stats.triang((mode - low) / (high - low), low, high - low), low, high)
    if kind == "beta":
        a, b, low, high = numbers
        ordered(low, high)
        if not min(a, b) > 0.0:
            raise ValueError(f"has the exponents {a:g} and {b:g}; they must be positive")
        return Marginal(stats.beta(a, b, low, high - low), low, high)
    mean, deviation, *limits = numbers
    positive(deviation)
    if kind == "truncated":
        low, high = limits
        ordered(low, high)
        law = stats.truncnorm((low - mean) / deviation, (high - mean) / deviation, mean, deviation)
        return Marginal(law, low, high)
    if kind == "lognormal":
        if not mean > 0.0:
            raise ValueError(f"has the mean {mean:g}; it must be positive")
        spread = math.sqrt(math.log1p((deviation / mean) ** 2))
        law = stats.lognorm(spread, scale=mean * math.exp(-0.5 * spread**2))
    else:
        law = stats.norm(mean, deviation)
    return Marginal(law, *map(float, law.ppf(stats.norm.cdf([-_SIGMAS, _SIGMAS]))))


def of_file(path: Path) -> Marginal:
    """Return the distribution of the numbers in a text file, one a line; InputError if it has fewer than two."""
    try:
        values = np.array([float(line) for line in path.read_text(encoding="utf-8").split()])
    except (OSError, ValueError) as problem:
        raise InputError(path, "", f"cannot be read as numbers, one a line ({problem})") from None
    if len(values) < 2 or not np.isfinite(values).all() or np.ptp(values) == 0.0:
        raise InputError(path, "", "needs at least two different finite numbers")
    return Marginal(Empirical(values), float(values.min()), float(values.max()))
