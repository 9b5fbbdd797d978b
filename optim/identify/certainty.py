"""How certain identified values are: deviations, intervals, what is identifiable, tests of the residuals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.stats import chi2, norm, normaltest, t

from linkages.base.arrays import Array
from optim.identify.fit import Fitted
from optim.identify.residuals import Residuals
from optim.identify.schema import Deviations

LEVEL = 0.95
_KNOWN = 0.5  # largest deviation of a known value: relative, or in deviations of a uniform one between its limits
_PART = 0.1  # least share of an unknown in an unknown mixture
_TIED = 0.9  # correlation with an unknown value from which on a value is unknown too
_LEAST = 1e-9  # smallest singular value, relative
_TINY = 1e-120  # stands for zero in denominators: its square is a number, too
_AT_LIMIT = 1e-4  # distance from a limit, relative to the distance of the limits
DOUBT = 1e-3  # probability below which a test warns
_LAGS = 20  # of the test of whiteness
_FEWEST = 20  # samples for tests
_LEAST_FREEDOM = 3.0


@dataclass(frozen=True, eq=False)
class Certainty:
    """Certainty of k scaled values, n of them unknowns.

    Attributes
    ----------
    covariance : (k, k) array
        Of the scaled values, NaN where it is not known.
    inflation : (k,) array
        Ratio of the variances to the ones of independent residuals with the stated deviation.
    singular : (n,) array
        Of the derivatives of the residuals with respect to the scaled unknowns, decreasing; sensors are eliminated.
    mixtures : (n, n) array
        Its rows are the mixtures of unknowns that the singular values belong to.
    identifiable : (n,) array of bool
    freedom : float
        Independent residuals less values, at least 3.
    times : list of float
        Autocorrelation time of each column, in samples.
    tests : dict of list
        ``chi_square`` (for each independent sample), ``chi_square_probability``, ``whiteness``, ``normality`` (their
        probabilities), by column.
    """

    covariance: Array
    inflation: Array
    singular: Array
    mixtures: Array
    identifiable: NDArray[np.bool_]
    freedom: float
    times: list[float]
    tests: dict[str, list[float | None]]

    @property
    def deviations(self) -> Array:
        """Standard deviations of the scaled values (k,)."""
        return np.sqrt(np.diag(self.covariance))


class Correlation(NamedTuple):
    """Correlation of neighbouring residuals: a process of first order, driven by residuals that correlate shortly.

    Attributes
    ----------
    first : float
        Coefficient of the process; zero for residuals that do not correlate.
    rest : array
        Covariances of what drives it, by lag, for residuals of variance 1.
    time : float
        Number of residuals that count as one; 1 for independent ones.
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
    if n < _FEWEST or not np.any(residual):
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
    return Correlation(first, rest, max((2.0 * float(rest.sum()) - float(rest[0])) / (1.0 - first) ** 2, 1.0))


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


def certainty(residuals: Residuals, found: Fitted, deviations: Deviations) -> Certainty:
    """Judge the values of a fit."""
    n, residual, jacobian = len(residuals.active), found.evaluated.residual, found.evaluated.jacobian
    groups = residuals.groups(found.horizon)
    correlations = [INDEPENDENT if deviations == "white" else correlation_of(residual[rows]) for _, rows in groups]
    times = [one.time for one in correlations]
    freedom = sum(
        (1.0 - len(found.z) / len(residual)) * (rows.stop - rows.start) / time
        for (_, rows), time in zip(groups, times, strict=True)
    )
    tests = _tests(residuals, groups, residual, times, len(found.z))
    worst = [p for p in tests["chi_square_probability"] if p is not None]
    factor = 1.0
    if worst and min(worst) < DOUBT:  # the model does not explain the samples: their own spread counts
        weighted = sum(float(np.sum(residual[rows] ** 2)) / time for (_, rows), time in zip(groups, times, strict=True))
        factor = max(1.0, weighted / max(freedom, 1.0))
    alone, idle = _covariance(jacobian), np.linalg.norm(jacobian, axis=0) == 0.0
    jacobian = _independent(jacobian, groups, correlations) / math.sqrt(factor)
    room = residuals.upper[:n] - residuals.lower[:n]
    inside = np.minimum(found.z[:n] - residuals.lower[:n], residuals.upper[:n] - found.z[:n]) > _AT_LIMIT * room
    covariance, singular, mixtures, known = judge(residuals, jacobian, inside)
    inflation = np.diag(covariance) / np.diag(alone)
    idle[:n] |= ~known
    covariance[idle], covariance[:, idle] = np.nan, np.nan
    return Certainty(covariance, inflation, singular, mixtures, known, max(freedom, _LEAST_FREEDOM), times, tests)


def _independent(jacobian: Array, groups: list[tuple[Any, slice]], correlations: list[Correlation]) -> Array:
    """Return the derivatives (k, k) of independent residuals that would leave the same covariance.

    The values are those of least squares, with White's (1980) covariance for correlated residuals.
    """
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), _TINY)
    basis, singular, rows = np.linalg.svd(jacobian / scale, full_matrices=False)
    middle = np.zeros((len(singular), len(singular)))
    last = 0
    for (_, part), correlation in zip(groups, correlations, strict=True):
        middle, last = middle + coloured(basis[part], correlation), part.stop
    middle += basis[last:].T @ basis[last:]  # priors
    size, sides = np.linalg.eigh(middle)
    return np.asarray((sides / np.sqrt(np.maximum(size, _LEAST))).T @ (singular[:, None] * rows) * scale, np.float64)


def _covariance(jacobian: Array) -> Array:
    """Return the covariance (k, k) of values; directions on which no residual depends are very uncertain."""
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), _TINY)
    _, singular, rows = np.linalg.svd(jacobian / scale, full_matrices=False)
    inverse = rows / np.maximum(singular, _LEAST)[:, None]
    return np.asarray(inverse.T @ inverse / np.outer(scale, scale), np.float64)


def judge(
    residuals: Residuals, jacobian: Array, inside: NDArray[np.bool_]
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Return the covariance, singular values and mixtures, and which unknowns, of those `inside`, are identifiable."""
    n, allowed, known = len(residuals.active), largest_deviations(residuals), inside.copy()
    singular, mixtures = mixtures_of(jacobian, allowed)
    for value, mixture in zip(singular, mixtures, strict=True):
        if value < 1.0:
            known &= mixture**2 < _PART
    covariance = _covariance(jacobian)
    scale = np.sqrt(np.diag(covariance))
    known &= scale[:n] <= allowed
    correlation = np.abs(covariance / np.outer(scale, scale))[:n, :n]
    known &= ~np.any(correlation[:, ~known] > _TIED, axis=1)  # what an unknown value may take with it
    return covariance, singular, mixtures, known


def mixtures_of(jacobian: Array, allowed: Array) -> tuple[Array, Array]:
    """Return the singular values (n,) of mixtures (n, n) of unknowns in allowed deviations; sensors are eliminated."""
    n = len(allowed)
    own, sensors = jacobian[:, :n], jacobian[:, n:]
    sides, size, _ = np.linalg.svd(sensors / np.maximum(np.linalg.norm(sensors, axis=0), _TINY), full_matrices=False)
    basis = sides[:, size > _LEAST]
    own = own - basis @ (basis.T @ own)
    _, singular, mixtures = np.linalg.svd(own * allowed, full_matrices=len(own) < n)
    return np.pad(singular, (0, n - len(singular))), mixtures


def largest_deviations(residuals: Residuals) -> Array:
    """Return the deviation of each scaled unknown (n,) up to which it is known.

    Half of that of a value anywhere between the limits, and at most half of a positive value itself.
    """
    n = len(residuals.active)
    uniform = _KNOWN * (residuals.upper[:n] - residuals.lower[:n]) / math.sqrt(12.0)
    return np.where(residuals.log, np.minimum(uniform, _KNOWN), uniform)


def _tests(
    residuals: Residuals, groups: list[tuple[Any, slice]], residual: Array, times: list[float], count: int
) -> dict[str, list[float | None]]:
    """Test the residuals of each column: their size, whiteness (Ljung and Box), normality (D'Agostino and Pearson)."""
    found: dict[str, list[float | None]] = {
        key: [] for key in ("chi_square", "chi_square_probability", "whiteness", "normality")
    }
    for (channel, rows), time in zip(groups, times, strict=True):
        left = residual[rows]
        n = len(left)
        given = residuals.stated(channel)
        share = count * n / max(len(residual), 1)
        mean = float(np.sum(left**2)) / max(n - share, 1.0) if n else None
        found["chi_square"].append(mean)
        freedom = max(n / time - share, 1.0)
        found["chi_square_probability"].append(float(chi2.sf(mean * freedom, freedom)) if given and mean else None)
        enough = n >= _FEWEST and bool(np.any(left))
        found["whiteness"].append(_ljung_box(left) if enough else None)
        thin = left[:: max(1, round(time))]
        found["normality"].append(float(normaltest(thin).pvalue) if enough and len(thin) >= _FEWEST else None)
    return found


def _ljung_box(residual: Array) -> float:
    n, most = len(residual), min(_LAGS, len(residual) // 4)
    centred = residual - residual.mean()
    lags = np.arange(1, most + 1)
    correlation = np.array([centred[k:] @ centred[:-k] for k in lags]) / (centred @ centred)
    return float(chi2.sf(n * (n + 2) * np.sum(correlation**2 / (n - lags)), most))


def interval(residuals: Residuals, z: Array, k: int, deviation: float, freedom: float) -> tuple[float, float]:
    """Return the ends of the interval of an unknown k, within its limits."""
    reach = float(t.ppf(0.5 + LEVEL / 2.0, freedom)) * deviation
    ends = []
    for sign in (-1.0, 1.0):
        moved = z.copy()
        moved[k] = np.clip(z[k] + sign * reach, residuals.lower[k], residuals.upper[k])
        ends.append(float(residuals.values(moved)[k]))
    return ends[0], ends[1]


def doubts(residuals: Residuals, found: Fitted, judged: Certainty) -> list[str]:
    """Return the warnings that follow from a fit, one sentence each."""
    names = [f"{m.name}.{c.name}" for m in residuals.task.measurements for c in m.channels]
    result = []
    for k, name in enumerate(names):
        probability = judged.tests["chi_square_probability"][k]
        mean = judged.tests["chi_square"][k]
        if probability is not None and probability < DOUBT and mean is not None and mean > 1.0:
            result.append(
                f"{name}: the residuals are {math.sqrt(mean):.2g} times the stated deviation: the model does not"
                " explain this column; the intervals are widened, but may miss the true values"
            )
        white = judged.tests["whiteness"][k]
        if white is not None and white < DOUBT:
            result.append(
                f"{name}: the residuals are not independent (every {judged.times[k]:.3g} samples count as one):"
                " something that the model lacks acts, or the noise of the sensor is coloured"
            )
        normal = judged.tests["normality"][k]
        if normal is not None and normal < DOUBT:
            result.append(f"{name}: the residuals are not normally distributed: look for outliers")
    at = found.z[: len(residuals.active)]
    room = residuals.upper[: len(at)] - residuals.lower[: len(at)]
    for k in range(len(at)):
        for side, limit in (("lower", residuals.lower[k]), ("upper", residuals.upper[k])):
            if abs(at[k] - limit) <= _AT_LIMIT * room[k]:
                result.append(f"{residuals.names[k]} is at its {side} limit: widen it, or fix the value")
    return result


def mixture_text(residuals: Residuals, mixture: Array) -> str:
    """Describe a mixture of unknowns: a product of powers, or a sum."""
    n, largest = len(mixture), float(np.abs(mixture).max())
    power = mixture * largest_deviations(residuals)
    power /= power[np.abs(power).argmax()]
    parts = [(residuals.names[k], power[k]) for k in range(n) if mixture[k] ** 2 >= _PART * largest**2]
    return " together with ".join(f"{name} ({value:+.2g})" for name, value in parts)
