"""Profile likelihood: the interval of one unknown, with all others fitted again at each of its values."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from linkages.base.arrays import Array
from optim.identify.certainty import LEVEL, Certainty
from optim.identify.fit import Fitted
from optim.identify.numerics import PROFILE_CLOSE, PROFILE_FEW, PROFILE_MOST
from optim.identify.residuals import Residuals
from optim.identify.result import Interval, Rise
from optim.identify.search import Search


class Profile(NamedTuple):
    """Points of a profile, the interval of the unknown, and the number of runs."""

    profile: list[Rise]
    profile_interval: Interval
    profile_runs: int


def profile(residuals: Residuals, found: Fitted, judged: Certainty, k: int) -> Profile:
    """Follow the least chi-square over unknown k, to both sides up to where it has risen by that of the interval.

    A rise counts less where the fit's variance is larger than that of independent residuals.
    """
    wanted = math.sqrt(float(chi2.ppf(LEVEL, 1)))
    least, unit = float(np.sum(found.evaluated.residual**2)), float(judged.inflation[k])
    points, ends, runs = [(float(residuals.values(found.z)[k]), 0.0)], [], 0
    for sign in (-1.0, 1.0):
        at, reached, z = 0.0, 0.0, found.z.copy()
        step = sign * wanted * _linear(judged, k, residuals)
        left = PROFILE_MOST
        while left > 1:
            value = float(np.clip(found.z[k] + step, residuals.lower[k], residuals.upper[k]))
            z, rise, count = _at(residuals, found, z, k, value, least, min(PROFILE_FEW, left - 1))
            runs, left = runs + count, left - count
            at, reached = value - found.z[k], math.sqrt(max(rise, 0.0) / unit)
            z_all = found.z.copy()
            z_all[k] = value
            points.append((float(residuals.values(z_all)[k]), rise / unit))
            limited = value in (residuals.lower[k], residuals.upper[k]) and reached < wanted
            if limited or abs(reached - wanted) < PROFILE_CLOSE * wanted:
                break
            step = at * min(max(wanted / max(reached, 1e-3), 0.3), 3.0)
        moved = found.z.copy()
        moved[k] = np.clip(found.z[k] + at, residuals.lower[k], residuals.upper[k])
        if 0.0 < reached < math.inf and moved[k] not in (residuals.lower[k], residuals.upper[k]):
            moved[k] = np.clip(found.z[k] + at * wanted / reached, residuals.lower[k], residuals.upper[k])
        ends.append(float(residuals.values(moved)[k]))
    return Profile([Rise(*point) for point in sorted(points)], Interval(*ends), runs)


def _linear(judged: Certainty, k: int, residuals: Residuals) -> float:
    """Return the deviation of an unknown with which its profile begins."""
    deviation = float(judged.deviations[k])
    room = float(residuals.upper[k] - residuals.lower[k])
    return deviation if 0.0 < deviation < 0.25 * room else 0.05 * room


def _at(
    residuals: Residuals, found: Fitted, z: Array, k: int, value: float, least: float, most: int
) -> tuple[Array, float, int]:
    """Fit the other values at a value of unknown k; return all, the rise of chi-square, and the number of runs."""
    others = np.ones(len(z), bool)
    others[k] = False
    start = z.copy()
    start[k] = value
    search = Search(residuals, start, found.horizon, others)
    evaluated = search.solve(most)
    if evaluated.reason:
        return evaluated.z, math.inf, search.runs
    return evaluated.z, float(np.sum(evaluated.residual**2)) - least, search.runs
