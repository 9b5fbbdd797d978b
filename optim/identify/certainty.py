"""How certain identified values are: deviations, intervals, identifiable values, tests of the residuals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, normaltest, t

from linkages.base.arrays import Array
from optim.identify.algebra import inverse
from optim.identify.correlation import DOUBT, FEWEST, INDEPENDENT, Correlation, coloured, correlation_of
from optim.identify.fit import Fitted, hopeless
from optim.identify.numerics import (
    CERTAINTY_FAR,
    CERTAINTY_KNOWN,
    CERTAINTY_LAGS,
    CERTAINTY_LEAST,
    CERTAINTY_LEAST_FREEDOM,
    TINY,
)
from optim.identify.residuals import Residuals
from optim.identify.schema import Deviations

LEVEL = 0.95
TIED = 0.9  # correlation from which on two values are known together only
AT_LIMIT = 1e-4  # distance from a limit, relative to the distance of the limits


@dataclass(frozen=True, eq=False)
class Certainty:
    """Certainty of k scaled values, n of them unknowns.

    Attributes
    ----------
    covariance : (k, k) array
        Of the scaled values, with the error of the runs; NaN where the data do not tell it.
    inflation : (k,) array
        Ratio of the variances to the ones of independent residuals with the stated deviation.
    singular : (n,) array
        Of the derivatives of the residuals with respect to the scaled unknowns, decreasing; sensors are eliminated.
    mixtures : (n, n) array
        Its rows are the mixtures of unknowns that the singular values belong to.
    told : (n,) array of bool
        Unknowns of which the data tell more than their limits do.
    identifiable : (n,) array of bool
    lost : bool
        Whether the values do not explain the data: no deviation says how far they are from the true ones.
    freedom : float
        Independent residuals less values, at least 3.
    times : list of float
        Autocorrelation time of each column, in samples.
    tests : dict of list
        ``chi_square`` (for each independent sample), ``chi_square_probability``, ``whiteness``, ``normality`` (their
        probabilities), ``model_error`` (of a sample, in deviations; None if no test sees one), by column.
    """

    covariance: Array
    inflation: Array
    singular: Array
    mixtures: Array
    told: NDArray[np.bool_]
    identifiable: NDArray[np.bool_]
    lost: bool
    freedom: float
    times: list[float]
    tests: dict[str, list[float | None]]

    @property
    def deviations(self) -> Array:
        """Standard deviations of the scaled values (k,)."""
        return np.sqrt(np.diag(self.covariance))


def certainty(
    residuals: Residuals, found: Fitted, deviations: Deviations, shift: Array | None = None, unsure: bool = False
) -> Certainty:
    """Judge the values of a fit, which the error of the runs shifts (k,).

    `unsure` says that they may be no minimum, or not the least one: one start of several has found them, or the limit
    of time has ended the search. If they explain a column badly, too, their derivatives tell nothing.
    """
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
    stated = (p is not None for p in tests["chi_square_probability"])
    far = any(known and (x or 0.0) > CERTAINTY_FAR for known, x in zip(stated, tests["chi_square"], strict=True))
    lost = hopeless(residuals, found) or (unsure and far)
    inside = np.minimum(found.z[:n] - residuals.lower[:n], residuals.upper[:n] - found.z[:n]) > AT_LIMIT * room
    covariance, singular, mixtures, told, known = judge(residuals, jacobian, inside & (not lost))
    inflation = np.diag(covariance) / np.diag(alone)
    idle[:n] |= ~told
    idle |= lost | _tied(covariance, idle)
    if shift is not None:
        covariance += np.nan_to_num(np.outer(shift, shift))
    covariance[idle], covariance[:, idle] = np.nan, np.nan
    told, known = told & ~idle[:n], known & ~idle[:n]
    freedom = max(freedom, CERTAINTY_LEAST_FREEDOM)
    return Certainty(covariance, inflation, singular, mixtures, told, known, lost, freedom, times, tests)


def _independent(jacobian: Array, groups: list[tuple[Any, slice]], correlations: list[Correlation]) -> Array:
    """Return the derivatives (k, k) of independent residuals that would leave the same covariance.

    The values come from least squares, with White's (1980) covariance for correlated residuals.
    """
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), TINY)
    basis, singular, rows = np.linalg.svd(jacobian / scale, full_matrices=False)
    middle = np.zeros((len(singular), len(singular)))
    last = 0
    for (_, part), correlation in zip(groups, correlations, strict=True):
        middle, last = middle + coloured(basis[part], correlation), part.stop
    middle += basis[last:].T @ basis[last:]  # priors
    size, sides = np.linalg.eigh(middle)
    inverse = sides / np.sqrt(np.maximum(size, CERTAINTY_LEAST))
    return np.asarray(inverse.T @ (singular[:, None] * rows) * scale, np.float64)


def _covariance(jacobian: Array) -> Array:
    """Return the covariance (k, k) of values; directions on which no residual depends are very uncertain."""
    root = inverse(jacobian)[1]
    return np.asarray(root @ root.T, np.float64)


class Judgement(NamedTuple):
    """Covariance (k, k), singular values (n,) and mixtures (n, n), and which unknowns are told and identifiable."""

    covariance: Array
    singular: Array
    mixtures: Array
    told: NDArray[np.bool_]
    identifiable: NDArray[np.bool_]


def judge(residuals: Residuals, jacobian: Array, inside: NDArray[np.bool_]) -> Judgement:
    """Judge the unknowns, of those `inside`, by derivatives.

    The data tell an unknown whose deviation is less than the one of a uniform value between its limits, and that does
    not correlate with one that they do not tell.
    """
    n, allowed = len(residuals.active), largest_deviations(residuals)
    singular, mixtures = mixtures_of(jacobian, allowed)
    covariance = _covariance(jacobian)
    scale = np.sqrt(np.diag(covariance))[:n]
    told = inside & (scale <= (residuals.upper - residuals.lower)[:n] / math.sqrt(12.0))
    told &= ~_tied(covariance[:n, :n], ~told)
    return Judgement(covariance, singular, mixtures, told, told & (scale <= allowed))


def _tied(covariance: Array, unknown: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return marks of the values (k,) that an unknown value may take with it."""
    scale = np.sqrt(np.diag(covariance))
    correlation = np.abs(covariance / np.outer(scale, scale))
    return np.asarray(np.any(correlation[:, unknown] > TIED, axis=1), np.bool_)


def mixtures_of(jacobian: Array, allowed: Array) -> tuple[Array, Array]:
    """Return the singular values (n,) of mixtures (n, n) of unknowns in allowed deviations; sensors are eliminated."""
    n = len(allowed)
    own, sensors = jacobian[:, :n], jacobian[:, n:]
    sides, size, _ = np.linalg.svd(sensors / np.maximum(np.linalg.norm(sensors, axis=0), TINY), full_matrices=False)
    basis = sides[:, size > CERTAINTY_LEAST]
    own = own - basis @ (basis.T @ own)
    _, singular, mixtures = np.linalg.svd(own * allowed, full_matrices=len(own) < n)
    return np.pad(singular, (0, n - len(singular))), mixtures


def largest_deviations(residuals: Residuals) -> Array:
    """Return the deviation of each scaled unknown (n,) up to which it is known.

    Half of that of a value anywhere between the limits, and at most half of a positive value itself.
    """
    n = len(residuals.active)
    uniform = CERTAINTY_KNOWN * (residuals.upper[:n] - residuals.lower[:n]) / math.sqrt(12.0)
    return np.where(residuals.log, np.minimum(uniform, CERTAINTY_KNOWN), uniform)


def _tests(
    residuals: Residuals, groups: list[tuple[Any, slice]], residual: Array, times: list[float], count: int
) -> dict[str, list[float | None]]:
    """Test the residuals of each column: their size, whiteness (Ljung and Box), normality (D'Agostino and Pearson)."""
    found: dict[str, list[float | None]] = {
        key: [] for key in ("chi_square", "chi_square_probability", "whiteness", "normality", "model_error")
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
        enough = n >= FEWEST and bool(np.any(left))
        found["whiteness"].append(_ljung_box(left) if enough else None)
        thin = left[:: max(1, round(time))]
        found["normality"].append(float(normaltest(thin).pvalue) if enough and len(thin) >= FEWEST else None)
        size, white = found["chi_square_probability"][-1], found["whiteness"][-1]
        found["model_error"].append(_model_error(left, mean, size, white, channel.sections is None))
    return found


def _model_error(
    residual: Array, mean: float | None, size: float | None, white: float | None, unfiltered: bool
) -> float | None:
    """Return the error of the model in deviations of a sample: the excess of the residuals, or their common part.

    `size` and `white` are the probabilities of the tests that see it; a filter makes neighbours alike, too.
    """
    seen = []
    if size is not None and size < DOUBT and mean is not None:
        seen.append(mean - 1.0)
    if white is not None and white < DOUBT and unfiltered:
        seen.append(float(np.mean(residual[1:] * residual[:-1])))
    return math.sqrt(max(seen)) if seen and max(seen) > 0.0 else None


def _ljung_box(residual: Array) -> float:
    n, most = len(residual), min(CERTAINTY_LAGS, len(residual) // 4)
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
