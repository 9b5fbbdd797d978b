"""How certain identified values are: deviations, intervals, what is identifiable, tests of the residuals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
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
_AT_LIMIT = 1e-4  # distance from a limit, relative to the distance of the limits
_DOUBT = 1e-3  # probability below which a test warns
_LAGS = 20  # of the test of whiteness
_FEWEST = 20  # samples for tests


@dataclass(frozen=True, eq=False)
class Certainty:
    """Certainty of k scaled values, n of them unknowns.

    Attributes
    ----------
    covariance : (k, k) array
        Of the scaled values, NaN where it is not known.
    singular : (n,) array
        Of the derivatives of the residuals with respect to the scaled unknowns, decreasing; sensors are eliminated.
    mixtures : (n, n) array
        Its rows are the mixtures of unknowns that the singular values belong to.
    identifiable : (n,) array of bool
    freedom : float
        Independent residuals less values.
    times : list of float
        Autocorrelation time of each column, in samples.
    tests : dict of list
        ``chi_square`` (for each independent sample), ``chi_square_probability``, ``whiteness``, ``normality`` (their
        probabilities), by column.
    weights : (r,) array
        Of the squares of the residuals.
    """

    covariance: Array
    singular: Array
    mixtures: Array
    identifiable: NDArray[np.bool_]
    freedom: float
    times: list[float]
    tests: dict[str, list[float | None]]
    weights: Array

    @property
    def deviations(self) -> Array:
        """Standard deviations of the scaled values (k,)."""
        return np.sqrt(np.diag(self.covariance))


def autocorrelation_time(residual: Array) -> float:
    """Return the number of samples that count as one: 1 for independent ones.

    One plus twice the sum of the autocorrelations, in pairs up to the first negative one (Geyer 1992); 1 unless
    neighbours correlate significantly.
    """
    n = len(residual)
    if n < _FEWEST or not np.any(residual):
        return 1.0
    size = 2 ** math.ceil(math.log2(2 * n))
    power = np.abs(np.fft.rfft(residual, size)) ** 2
    correlation = np.fft.irfft(power)[: n // 2]
    correlation /= correlation[0]
    if abs(correlation[1]) < norm.ppf(1.0 - _DOUBT / 2.0) / math.sqrt(n):
        return 1.0
    pairs = correlation[: len(correlation) // 2 * 2].reshape(-1, 2).sum(axis=1)
    negative = np.flatnonzero(pairs <= 0.0)
    return max(1.0, 2.0 * float(pairs[: negative[0] if len(negative) else len(pairs)].sum()) - 1.0)


def certainty(residuals: Residuals, found: Fitted, deviations: Deviations) -> Certainty:
    """Judge the values of a fit."""
    n, residual, jacobian = len(residuals.active), found.evaluated.residual, found.evaluated.jacobian
    groups = residuals.groups(found.horizon)
    white: Literal["white"] = "white"
    times = [1.0 if deviations == white else autocorrelation_time(residual[rows]) for _, rows in groups]
    weight = np.ones(len(residual))
    for (_, rows), time in zip(groups, times, strict=True):
        weight[rows] = 1.0 / time
    tests = _tests(groups, residual, times, len(found.z))
    worst = [p for p in tests["chi_square_probability"] if p is not None]
    factor = 1.0
    if worst and min(worst) < _DOUBT:  # the model does not explain the samples: their own spread counts
        factor = max(1.0, float(np.sum(weight * residual**2) / max(weight.sum() - len(found.z), 1.0)))
    weights = weight / factor
    jacobian = jacobian * np.sqrt(weights)[:, None]
    freedom = max(float(weight.sum()) - len(found.z), 1.0)
    covariance = _covariance(jacobian)
    singular, mixtures, known = _mixtures(residuals, found.z, jacobian)
    scale = np.sqrt(np.diag(covariance))
    known &= scale[:n] <= largest_deviations(residuals)
    correlation = np.abs(covariance / np.outer(scale, scale))[:n, :n]
    known &= ~np.any(correlation[:, ~known] > _TIED, axis=1)  # what an unknown value may take with it
    covariance[:n][~known], covariance[:, :n][:, ~known] = np.nan, np.nan
    return Certainty(covariance, singular, mixtures, known, freedom, times, tests, weights)


def _covariance(jacobian: Array) -> Array:
    """Return the covariance (k, k) of values; directions on which no residual depends are very uncertain."""
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    _, singular, rows = np.linalg.svd(jacobian / scale, full_matrices=False)
    inverse = rows / np.maximum(singular, _LEAST)[:, None]
    return np.asarray(inverse.T @ inverse / np.outer(scale, scale), np.float64)


def _mixtures(residuals: Residuals, z: Array, jacobian: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return singular values, mixtures, and which unknowns are identifiable."""
    n = len(residuals.active)
    own, sensors = jacobian[:, :n], jacobian[:, n:]
    if sensors.shape[1]:
        basis = np.linalg.qr(sensors / np.maximum(np.linalg.norm(sensors, axis=0), 1e-300))[0]
        own = own - basis @ (basis.T @ own)
    allowed = largest_deviations(residuals)
    _, singular, mixtures = np.linalg.svd(own * allowed, full_matrices=False)
    singular, mixtures = np.pad(singular, (0, n - len(singular))), mixtures
    if len(mixtures) < n:
        mixtures = np.linalg.svd(own * allowed, full_matrices=True)[2]
    known = np.ones(n, bool)
    for value, mixture in zip(singular, mixtures, strict=True):
        if value < 1.0:
            known &= mixture**2 < _PART
    room = residuals.upper[:n] - residuals.lower[:n]
    inside = (z[:n] - residuals.lower[:n] > _AT_LIMIT * room) & (residuals.upper[:n] - z[:n] > _AT_LIMIT * room)
    return singular, mixtures, known & inside


def largest_deviations(residuals: Residuals) -> Array:
    """Return the deviation of each scaled unknown (n,) up to which it is known.

    Half of that of a value anywhere between the limits, and at most half of a positive value itself.
    """
    n = len(residuals.active)
    uniform = _KNOWN * (residuals.upper[:n] - residuals.lower[:n]) / math.sqrt(12.0)
    return np.where(residuals.log, np.minimum(uniform, _KNOWN), uniform)


def _tests(
    groups: list[tuple[Any, slice]], residual: Array, times: list[float], count: int
) -> dict[str, list[float | None]]:
    """Test the residuals of each column: their size, whiteness (Ljung and Box), normality (D'Agostino and Pearson)."""
    found: dict[str, list[float | None]] = {
        key: [] for key in ("chi_square", "chi_square_probability", "whiteness", "normality")
    }
    for (channel, rows), time in zip(groups, times, strict=True):
        left = residual[rows]
        n = len(left)
        given = not math.isnan(channel.deviation)
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
        if probability is not None and probability < _DOUBT and mean is not None and mean > 1.0:
            result.append(
                f"{name}: the residuals are {math.sqrt(mean):.2g} times the stated deviation: the model does not"
                " explain this column; the intervals are widened, but may miss the true values"
            )
        white = judged.tests["whiteness"][k]
        if white is not None and white < _DOUBT:
            result.append(
                f"{name}: the residuals are not independent (every {judged.times[k]:.3g} samples count as one):"
                " something that the model lacks acts, or the noise of the sensor is coloured"
            )
        normal = judged.tests["normality"][k]
        if normal is not None and normal < _DOUBT:
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
