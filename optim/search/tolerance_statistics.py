"""Statistics of a sample of machines: intervals, capability, shares of the variance, yields of narrower tolerances."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta, binom

from linkages.base.arrays import Array
from optim.problem.scatter import Scatter
from optim.search import numerics

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
    """Return mean and standard deviation with their standard errors.

    A. M. Mood, F. A. Graybill, D. C. Boes, Introduction to the Theory of Statistics, 3rd ed. 1974, ch. VI: the variance
    of a sample's variance is (mu_4 - (n - 3)/(n - 1) sigma^4)/n.
    """
    n, size = len(values), _size(values)
    scaled = values / size
    mean, deviation = float(scaled.mean()), 0.0 if _constant(values) else float(scaled.std(ddof=1))
    fourth = float(np.mean(((scaled - mean) / deviation) ** 4)) if deviation > 0.0 else 0.0
    error = 0.5 * deviation * math.sqrt(max(fourth - (n - 3) / (n - 1), 0.0) / n)
    names = ("mean", "mean_error", "deviation", "deviation_error")
    return dict(zip(names, (size * x for x in (mean, deviation / math.sqrt(n), deviation, error)), strict=True))


def histogram(values: Array) -> tuple[NDArray[np.int64], Array]:
    """Return counts and edges of a histogram; one bin if the values differ by rounding alone."""
    if _constant(values):
        middle, half = float(values[0]), 1e-9 * _size(values)
        return np.array([len(values)]), np.array([middle - half, middle + half])
    return np.histogram(values, bins=min(40, max(8, math.isqrt(len(values)))))


def root_mean_square(values: Array) -> float:
    """Return the root of the mean of the squares, which may be too large for numbers."""
    size = _size(values)
    return size * math.sqrt(float(np.mean((values / size) ** 2)))


def _size(values: Array) -> float:
    """Return the largest magnitude of values, 1 if they are zero: their ratios to it can be squared."""
    return float(np.abs(values).max()) or 1.0


def _constant(values: Array) -> bool:
    """Tell whether values differ by rounding alone."""
    return bool(np.ptp(values / _size(values)) <= numerics.TOLERANCE_STATISTICS_ROUNDING)


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
    Chemistry A 114 (2010) 6022-6032. Errors by the jackknife. None if the quantity varies in too few
    machines, or the sample is short.
    """
    m, n = normal.shape
    if m < numerics.TOLERANCE_STATISTICS_EACH * (n + 1):
        return None
    pairs = [(i, j) for i in range(n) for j in range(i)]
    degree = 3
    if m < numerics.TOLERANCE_STATISTICS_EACH * (3 * n + len(pairs) + 1):
        degree, pairs = 1, []
    values, group = values / _size(values), np.arange(m) % numerics.TOLERANCE_STATISTICS_GROUPS
    if any(
        _constant(values[group != k]) for k in range(numerics.TOLERANCE_STATISTICS_GROUPS)
    ):  # few machines make all of the variance
        return None
    factors = [
        _triangular(
            normal[k :: numerics.TOLERANCE_STATISTICS_GROUPS],
            values[k :: numerics.TOLERANCE_STATISTICS_GROUPS],
            degree,
            pairs,
        )
        for k in range(numerics.TOLERANCE_STATISTICS_GROUPS)
    ]
    owners = np.zeros((n, degree * n + len(pairs)), dtype=bool)
    owners[:, : degree * n] = np.repeat(np.eye(n, dtype=bool), degree, axis=1)
    together = owners.copy()
    for k, pair in enumerate(pairs, degree * n):
        together[list(pair), k] = True

    def estimate(groups: Iterable[int]) -> tuple[Array, float]:
        """Return first and total shares of the machines of these groups, (2, n), and what no term explains."""
        centred = np.asarray(np.linalg.qr(np.vstack([factors[k] for k in groups]), mode="r"))[
            1:, 1:
        ]  # without the mean
        terms, y = centred[:, :-1], centred[:, -1]
        solution, *_ = np.linalg.lstsq(terms, y, rcond=m * np.finfo(float).eps)
        each = solution * (terms.T @ y) / (y @ y)
        return np.stack([owners @ each, together @ each]), float(1.0 - each.sum())

    shares, rest = estimate(range(numerics.TOLERANCE_STATISTICS_GROUPS))
    partial = np.array(
        [
            estimate(j for j in range(numerics.TOLERANCE_STATISTICS_GROUPS) if j != k)[0]
            for k in range(numerics.TOLERANCE_STATISTICS_GROUPS)
        ]
    )
    errors = np.sqrt((numerics.TOLERANCE_STATISTICS_GROUPS - 1) * partial.var(axis=0))
    return Shares(shares[0], errors[0], shares[1], errors[1], rest)


def _triangular(normal: Array, values: Array, degree: int, pairs: Sequence[tuple[int, int]]) -> Array:
    """Return the triangular factor of 1, the terms and the values of some machines: all that a regression needs."""
    alone = np.stack([normal, normal**2 - 1.0, normal**3 - 3.0 * normal], axis=2)[:, :, :degree]
    products = [normal[:, i] * normal[:, j] for i, j in pairs]
    columns = [np.ones(len(values)), alone.reshape(len(values), -1), *products, values]
    return np.asarray(np.linalg.qr(np.column_stack(columns), mode="r"))


def yield_of(
    scatter: Scatter, other: Scatter, designs: Array, good: NDArray[np.bool_]
) -> tuple[float | None, float | None]:
    """Return the yield of another scatter, with its standard error, from machines (m, n) of this one, without runs.

    Importance sampling: each machine counts with the ratio of the densities. The other scatter must be narrower. No
    error is smaller than that of the next machine. None if no machine counts, or one has no density: a measured value
    that occurs twice.
    """
    now = _log_densities(scatter, designs)
    if np.isposinf(now).any():
        return None, None
    with np.errstate(invalid="ignore"):
        weights = np.exp(_log_densities(other, designs) - now)
    weights[~np.isfinite(weights)] = 0.0
    if not (total := float(weights.sum())) > 0.0:
        return None, None
    weights /= total
    share = float(weights @ good)
    error = math.sqrt(float(np.sum((weights * (good - share)) ** 2)))
    return share, max(error, 1.0 / (1.0 / float(weights @ weights) + 2.0))


def _log_densities(scatter: Scatter, designs: Array) -> Array:
    """Return the logarithms of the densities of machines (m, n), in blocks: a million needs little memory."""
    starts = range(0, max(len(designs), 1), numerics.TOLERANCE_STATISTICS_BLOCK)
    return np.concatenate(
        [scatter.log_density(designs[first : first + numerics.TOLERANCE_STATISTICS_BLOCK]) for first in starts]
    )


class FirstOrder(NamedTuple):
    """Deviation of a quantity to first order, and shares of its variance (n,)."""

    deviation: float
    shares: Array


def first_order(rates: Array, scatter: Scatter) -> FirstOrder:
    """Return the scatter of a quantity from its derivatives (n,) at the means: propagation of errors; NaN without."""
    with np.errstate(over="ignore", invalid="ignore"):
        each = rates * scatter.deviations
    if not np.isfinite(each).all():
        return FirstOrder(math.nan, np.full(len(each), math.nan))
    size = _size(each)
    parts = each / size * (scatter.correlation @ (each / size))
    variance = float(parts.sum())
    shares = parts / variance if variance > 0.0 else np.zeros(len(each))
    return FirstOrder(size * math.sqrt(max(variance, 0.0)), shares)
