"""Statistics of a sample of machines: intervals, capability, shares of the variance, yields of narrower tolerances."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta, binom

from linkages.base.arrays import Array
from optim.problem.scatter import Scatter

_GROUPS = 10  # of the jackknife
_EACH = 4  # machines for each coefficient of the regression, at least
#: Probabilities of the quantiles in a report: median, 90 % and the 6 deviations of a normal quantity.
LEVELS = (0.00135, 0.05, 0.5, 0.95, 0.99865)


def clopper_pearson(count: int, total: int, confidence: float) -> tuple[float, float]:
    """Return the interval of a probability, of which `count` of `total` trials came true.

    C. J. Clopper, E. S. Pearson, The use of confidence or fiducial limits illustrated in the case of the binomial,
    Biometrika 26 (1934) 404-413.
    """
    tail = 0.5 * (1.0 - confidence)
    lower = float(beta.ppf(tail, count, total - count + 1)) if count else 0.0
    upper = float(beta.ppf(1.0 - tail, count + 1, total - count)) if count < total else 1.0
    return lower, upper


def quantile(ordered: Array, share: float, confidence: float) -> tuple[float, float | None, float | None]:
    """Return a quantile of ordered values, and the order statistics that enclose it; None where the sample is short."""
    n, tail = len(ordered), 0.5 * (1.0 - confidence)
    first, last = int(binom.ppf(tail, n, share)), int(binom.ppf(1.0 - tail, n, share)) + 1  # counted from 1
    ends = [float(ordered[k - 1]) if 1 <= k <= n else None for k in (first, last)]
    return float(np.quantile(ordered, share)), ends[0], ends[1]


def moments(values: Array) -> dict[str, float]:
    """Return mean and standard deviation with their standard errors."""
    n, mean, deviation = len(values), float(values.mean()), float(values.std(ddof=1))
    fourth = float(np.mean((values - mean) ** 4))
    error = math.sqrt(max(fourth - deviation**4, 0.0) / n) / (2.0 * deviation) if deviation > 0.0 else 0.0
    return {"mean": mean, "mean_error": deviation / math.sqrt(n), "deviation": deviation, "deviation_error": error}


def capability(mean: float, deviation: float, at_least: float | None, at_most: float | None) -> float | None:
    """Return the capability index: the nearer limit's distance from the mean over three deviations."""
    room = min(math.inf if at_most is None else at_most - mean, math.inf if at_least is None else mean - at_least)
    return room / (3.0 * deviation) if math.isfinite(room) and deviation > 0.0 else None


class Shares(NamedTuple):
    """Shares of the variance by value, (n,) each, with standard errors, and the share that no term explains."""

    first: Array
    first_error: Array
    total: Array
    total_error: Array
    unexplained: float


def variance_shares(normal: Array, values: Array) -> Shares | None:
    """Split the variance of a quantity (m,) among scattering values by regression on normal numbers z (m, n).

    The terms are Hermite polynomials to the third degree of each value, and products of two values; a share is the
    covariance of its terms with the quantity over the variance. These are Sobol's indices for independent values. G. Li
    et al., Global sensitivity analysis for systems with independent and/or correlated inputs, Journal of Physical
    Chemistry A 114 (2010) 6022-6032. Errors by the jackknife. None if the quantity does not vary, or the sample is
    short.
    """
    m, n = normal.shape
    pairs = [(i, j) for i in range(n) for j in range(i)]
    alone = np.stack([normal, normal**2 - 1.0, normal**3 - 3.0 * normal], axis=2)
    if m < _EACH * (3 * n + len(pairs) + 1):
        alone, pairs = alone[:, :, :1], []
    if m < _EACH * (n + 1) or np.ptp(values) <= 1e-12 * np.abs(values).max():
        return None
    terms = np.column_stack([alone.reshape(m, -1), *(normal[:, i] * normal[:, j] for i, j in pairs)])
    owners = np.zeros((n, terms.shape[1]), dtype=bool)
    owners[:, : n * alone.shape[2]] = np.repeat(np.eye(n, dtype=bool), alone.shape[2], axis=1)
    together = owners.copy()
    for k, pair in enumerate(pairs, n * alone.shape[2]):
        together[list(pair), k] = True

    def estimate(rows: NDArray[np.bool_]) -> tuple[Array, float]:
        centred = terms[rows] - terms[rows].mean(axis=0)
        y = values[rows] - values[rows].mean()
        factors, *_ = np.linalg.lstsq(centred, y, rcond=None)
        each = factors * (centred.T @ y) / (y @ y)
        return np.stack([owners @ each, together @ each]), float(1.0 - each.sum())

    shares, rest = estimate(np.ones(m, dtype=bool))
    group = np.arange(m) % _GROUPS
    partial = np.array([estimate(group != k)[0] for k in range(_GROUPS)])
    errors = np.sqrt((_GROUPS - 1) * partial.var(axis=0))
    return Shares(shares[0], errors[0], shares[1], errors[1], rest)


def yield_of(scatter: Scatter, other: Scatter, designs: Array, good: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the yield of another scatter, with its standard error, from machines (m, n) of this one, without runs.

    Importance sampling: each machine counts with the ratio of the densities. The other scatter must be narrower.
    """
    with np.errstate(invalid="ignore"):
        weights = np.exp(other.log_density(designs) - scatter.log_density(designs))
    weights[~np.isfinite(weights)] = 0.0
    share = float(weights @ good / weights.sum())
    error = math.sqrt(float(np.sum((weights * (good - share)) ** 2))) / float(weights.sum())
    return share, error


class FirstOrder(NamedTuple):
    """Deviation of a quantity to first order, and shares of its variance (n,)."""

    deviation: float
    shares: Array


def first_order(rates: Array, scatter: Scatter) -> FirstOrder:
    """Return the scatter of a quantity from its derivatives (n,) at the means: propagation of errors."""
    each = rates * scatter.deviations
    parts = each * (scatter.correlation @ each)
    variance = float(parts.sum())
    return FirstOrder(math.sqrt(max(variance, 0.0)), parts / variance if variance > 0.0 else np.zeros(len(each)))


class DesignPoint(NamedTuple):
    """The most probable machine at a limit, (n,) independent normal numbers, at the distance `beta` from the means."""

    beta: float
    normal: Array
    iterations: int
    converged: bool


def design_point(
    excess: Callable[[Array], float], slopes: Callable[[Array], Array], size: int, most: int = 40
) -> DesignPoint | None:
    """Find the nearest point to the origin where an excess (positive: beyond the limit) is zero.

    R. Rackwitz, B. Fiessler, Structural reliability under combined random load sequences, Computers and Structures 9
    (1978) 489-494 (HL-RF). Functions of independent normal numbers (n,). None where the excess has no value or slope.
    """
    at = np.zeros(size)
    first = value = excess(at)
    for iteration in range(1, most + 1):
        slope = slopes(at)
        square = float(slope @ slope)
        if not (math.isfinite(value) and math.isfinite(square)) or square == 0.0:
            return None
        new = (float(slope @ at) - value) / square * slope
        step = 1.0
        while not math.isfinite(found := excess(at + step * (new - at))) and step > 0.1:
            step *= 0.5
        moved = float(np.linalg.norm(new - at))
        at, value = at + step * (new - at), found
        if step == 1.0 and moved < 1e-3 * max(1.0, float(np.linalg.norm(at))) and abs(value) < 1e-3 * abs(first):
            return DesignPoint(math.copysign(float(np.linalg.norm(at)), -first), at, iteration, True)
    return DesignPoint(math.copysign(float(np.linalg.norm(at)), -first), at, most, False)


def importance_check(exceeds: Callable[[Array], NDArray[np.bool_]], centre: Array, count: int, seed: int) -> Any:
    """Estimate the probability beyond a limit with its standard error, by points about the design point (n,)."""
    away = np.random.default_rng(seed).standard_normal((count, len(centre)))
    weights = np.exp(-away @ centre - 0.5 * centre @ centre)
    terms = np.where(exceeds(centre + away), weights, 0.0)
    return float(terms.mean()), float(terms.std(ddof=1)) / math.sqrt(count)
