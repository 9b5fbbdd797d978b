"""Shares of points beyond a limit that few points exceed: subset simulation, importance sampling, FORM.

All functions see independent standard normal numbers and an excess, positive beyond the limit; no machine.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from linkages.base.arrays import Array
from optim.search import numerics

#: Chains of subset simulation. Their stated errors of ln(share) held in 93 to 99 % of runs on closed forms.
CHAINS = 20
_BATCH, _MOST = 256, 1024  # points of importance sampling

#: From independent normal numbers (m, n) to the excess (m,): infinite where a machine failed, never NaN.
Excess = Callable[[Array], Array]


class Climb(NamedTuple):
    """Result of a subset simulation.

    Attributes
    ----------
    share : float
        Of the points beyond the limit; of those beyond the last level, if the limit is not reached.
    error : float
        Standard error of ln(share).
    points : (m, n) array, optional
        Points beyond the limit, distributed as all such points are; None if it is not reached.
    stuck : bool
        Whether the climb ended at many points of equal excess.
    """

    share: float
    error: float
    points: Array | None
    stuck: bool = False


def subset_simulation(excess: Excess, points: Array, values: Array, rng: np.random.Generator) -> Climb:
    """Climb from points (m, n) with excess (m,), m at least `CHAINS`, over levels of the excess to the limit, zero.

    S.-K. Au, J. L. Beck, Estimation of small failure probabilities in high dimensions by subset simulation,
    Probabilistic Engineering Mechanics 16 (2001) 263-277. The share is the product of those of the levels. A level's
    error is the scatter of its chains.
    """
    share, variance, chains = 1.0, 0.0, len(points)
    while True:
        order = np.argsort(-values, kind="stable")
        level = float(values[order[CHAINS - 1]])
        beyond = values > 0.0 if level > 0.0 else values >= level
        part = float(beyond.mean())
        means = beyond.reshape(-1, chains).mean(axis=0)
        share *= part
        variance += float(means.var(ddof=1)) / chains / part**2
        if part > numerics.RARE_SHARES_STUCK:
            return Climb(share, math.sqrt(variance), points[beyond] if level > 0.0 else None, level <= 0.0)
        if level <= 0.0 and share < numerics.RARE_SHARES_LEAST:
            return Climb(share, math.sqrt(variance), None)
        seeds = rng.choice(np.flatnonzero(beyond), CHAINS, replace=False) if level > 0.0 else order[:CHAINS]
        points, values = _chains(excess, points[seeds], values[seeds], level, rng)
        chains = CHAINS
        if level > 0.0:
            return Climb(share, math.sqrt(variance), points)


def _chains(excess: Excess, at: Array, values: Array, level: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Move points (k, n) at random beyond a level; return all points, step by step, (k * length, n), and their excess.

    I. Papaioannou et al., MCMC algorithms for subset simulation, Probabilistic Engineering Mechanics 41 (2015) 89-103:
    conditional sampling, whose width follows the part of accepted candidates.
    """
    points, found, width = [at], [values], 0.6
    for step in range(1, numerics.RARE_SHARES_LENGTH):
        moved = math.sqrt(1.0 - width**2) * at + width * rng.standard_normal(at.shape)
        new = excess(moved)
        accepted = new > 0.0 if level > 0.0 else new >= level
        at, values = np.where(accepted[:, None], moved, at), np.where(accepted, new, values)
        points.append(at)
        found.append(values)
        width = min(
            1.0, max(0.05, width * math.exp((accepted.mean() - numerics.RARE_SHARES_ACCEPTED) / math.sqrt(step)))
        )
    return np.concatenate(points), np.concatenate(found)


class Sampled(NamedTuple):
    """Result of importance sampling: share beyond the limit, its standard error, and the part of it that failed."""

    share: float
    error: float
    failed: float


def importance_sampling(excess: Excess, centres: Array, point: Array | None, rng: np.random.Generator) -> Sampled:
    """Estimate a share by points around points beyond the limit (k, n), and around the design point (n,), if known.

    A part of the points has a wide normal density about the origin: it bounds the weights of points that are far from
    all centres, so that the standard error does not miss them. T. Hesterberg, Weighted average importance sampling and
    defensive mixture distributions, Technometrics 37 (1995) 185-194.
    """
    size = centres.shape[1]
    spread = math.sqrt(max(float(np.sum(centres**2, axis=1).min()) / size, 1.0))
    near = 0.0 if point is None else 0.5 * (1.0 - numerics.RARE_SHARES_WIDE)
    parts = np.array([numerics.RARE_SHARES_WIDE, near, 1.0 - numerics.RARE_SHARES_WIDE - near])
    middle = np.zeros(size) if point is None else point
    terms, failed = np.empty(0), np.empty(0)
    while len(terms) < _MOST:
        kind = rng.choice(3, _BATCH, p=parts)
        away = rng.standard_normal((_BATCH, size))
        around = centres[rng.integers(len(centres), size=_BATCH)]
        places = np.choose(kind[:, None], [spread * away, middle + away, around + away])
        found = excess(places)
        weights = np.exp(-_log_density(places, centres, middle, spread, parts))
        terms = np.append(terms, np.where(found > 0.0, weights, 0.0))
        failed = np.append(failed, np.where(np.isposinf(found), weights, 0.0))
        share, error = float(terms.mean()), float(terms.std(ddof=1)) / math.sqrt(len(terms))
        if len(terms) > _BATCH and 0.0 < error < numerics.RARE_SHARES_ENOUGH * share:
            break
    return Sampled(share, error, float(failed.mean()) / share if share > 0.0 else 0.0)


def _log_density(places: Array, centres: Array, middle: Array, spread: float, parts: Array) -> Array:
    """Return the logarithm of the mixture's density over the normal density at places (m, n), (m,)."""
    wide = 0.5 * np.sum(places**2, axis=1) * (1.0 - spread**-2) - places.shape[1] * math.log(spread)
    near = places @ middle - 0.5 * middle @ middle
    around = logsumexp(places @ centres.T - 0.5 * np.sum(centres**2, axis=1), axis=1) - math.log(len(centres))
    return np.asarray(logsumexp(np.stack([wide, near, around]), axis=0, b=parts[:, None]))


class DesignPoint(NamedTuple):
    """The most probable machine at a limit, (n,) independent normal numbers, at the distance `beta` from the means."""

    beta: float
    normal: Array
    iterations: int
    converged: bool


def design_point(
    excess: Callable[[Array], float], slopes: Callable[[Array], Array], start: Array, most: int = 40
) -> DesignPoint | None:
    """Find the nearest point to the origin where an excess (positive: beyond the limit) is zero, from a start (n,).

    R. Rackwitz, B. Fiessler, Structural reliability under combined random load sequences, Computers and Structures 9
    (1978) 489-494 (HL-RF). Functions of independent normal numbers (n,). None where the excess has no value or slope.
    """
    at, first, value = start, excess(np.zeros(len(start))), excess(start)
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
