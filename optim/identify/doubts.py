"""Notes on the numbers of a result: warnings, mixtures of unknowns, and the validity of intervals."""

from __future__ import annotations

import math

import numpy as np

from linkages.base.arrays import Array
from optim.identify.certainty import AT_LIMIT, TIED, Certainty, largest_deviations
from optim.identify.correlation import DOUBT
from optim.identify.fit import Fitted
from optim.identify.residuals import Residuals
from optim.identify.result import Pair

#: What all intervals assume.
ASSUMED = "the intervals hold only if the laws of the model are those of the machine"
_PART = 0.1  # least share of an unknown in an unknown mixture


def doubts(residuals: Residuals, found: Fitted, judged: Certainty) -> list[str]:
    """Return the warnings that follow from a fit, one sentence each."""
    names = [f"{m.name}.{c.name}" for m in residuals.task.measurements for c in m.channels]
    result = []
    if judged.lost:
        result.append(
            "these values do not explain the data, so no deviation is stated: the search has ended at a wrong minimum,"
            " or the model lacks something; give fit.starts, nearer starts, other laws, or with contacts fit.windows ="
            ' "statistics", which compares means and peaks of long records'
        )
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
            alike = f" (every {judged.times[k]:.3g} samples count as one)" if judged.times[k] > 1.0 else ""
            result.append(
                f"{name}: the residuals are not independent{alike}: something that the model lacks acts, or the noise"
                " of the sensor is coloured"
            )
        normal = judged.tests["normality"][k]
        if normal is not None and normal < DOUBT:
            result.append(f"{name}: the residuals are not normally distributed: look for outliers")
    at = found.z[: len(residuals.active)]
    room = residuals.upper[: len(at)] - residuals.lower[: len(at)]
    for k in range(len(at)):
        for side, limit in (("lower", residuals.lower[k]), ("upper", residuals.upper[k])):
            if abs(at[k] - limit) <= AT_LIMIT * room[k]:
                result.append(f"{residuals.names[k]} is at its {side} limit: widen it, or fix the value")
    return result


def mixture_text(residuals: Residuals, mixture: Array, least: float = _PART) -> str:
    """Describe a mixture of unknowns: a product of powers, or a sum."""
    n, largest = len(mixture), float(np.abs(mixture).max())
    power = mixture * largest_deviations(residuals)
    power /= power[np.abs(power).argmax()]
    parts = [(residuals.names[k], power[k]) for k in range(n) if mixture[k] ** 2 > least * largest**2]
    return " together with ".join(f"{name} ({value:+.2g})" for name, value in parts)


def correlated(residuals: Residuals, judged: Certainty) -> list[Pair]:
    """Return pairs of unknowns that the data determine together, but not separately.

    Each has ``unknowns``, ``correlation``, ``together``: the powers, or sums, by which they change together, and
    ``apart``: the deviation of each where the other is given, relative to its own deviation.
    """
    found, scale = [], judged.deviations
    told = np.flatnonzero(judged.told)
    for i, k in ((i, k) for i in told for k in told if i < k):
        correlation = float(judged.covariance[i, k] / (scale[i] * scale[k]))
        if abs(correlation) > TIED:
            mixture = np.zeros(len(judged.told))
            mixture[i], mixture[k] = scale[i], math.copysign(scale[k], correlation)
            mixture /= largest_deviations(residuals)
            found.append(Pair(
                unknowns=[residuals.names[i], residuals.names[k]], correlation=correlation,
                together=mixture_text(residuals, mixture / np.abs(mixture).max(), 0.0),
                apart=math.sqrt(max(1.0 - correlation**2, 0.0)),
            ))  # fmt: skip
    return found
