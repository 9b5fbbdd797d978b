"""Samples of the posterior by emcee: how certain unknowns are where linear intervals do not describe it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from linkages import RunError
from linkages.base.arrays import Array
from optim.identify.batches import SumsOfSquares
from optim.identify.certainty import LEVEL, Certainty
from optim.identify.fit import Fitted
from optim.identify.numerics import (
    POSTERIOR_BEGINNING,
    POSTERIOR_ENOUGH,
    POSTERIOR_KEPT,
    POSTERIOR_LOOK,
    POSTERIOR_REACH,
    POSTERIOR_WALKERS,
)
from optim.identify.residuals import Residuals
from optim.identify.result import Interval, Posterior, Sampled


def posterior(
    residuals: Residuals,
    found: Fitted,
    judged: Certainty,
    threads: int | None = None,
    show: Callable[[str], None] = lambda text: None,
    store: Path | None = None,
) -> Posterior:
    """Sample all values, by walkers that start from the linear covariance (Foreman-Mackey and others 2013).

    The residuals are normal; their sum of squares is divided by the mean inflation of the linear variances. An unknown
    without prior is uniform between its limits, a positive one in its logarithm. A file `store` keeps the sums of
    squares; a repetition reads them, so an interrupted chain continues with the same numbers.

    Returns ``parameters``: by name ``median``, ``deviation`` and ``interval`` of 95 %; ``samples`` (ns, n) of the
    unknowns, at most 2000; ``walkers``, ``runs``, ``acceptance``; ``autocorrelation_times``: length of the chain, and
    ``enough``: whether that is 50. RunError if no walker moves.
    """
    import emcee

    fit = residuals.task.file.fit
    inflation = math.exp(float(np.mean(np.log(judged.inflation))))
    covariance = _covariance(residuals, found.evaluated.jacobian / math.sqrt(inflation))
    reach = POSTERIOR_REACH * np.sqrt(np.diag(covariance))
    lower, upper = residuals.lower.copy(), residuals.upper.copy()
    for k, place in enumerate(residuals.places, len(residuals.active)):
        if place.kind == "shift":
            lower[k], upper[k] = max(lower[k], found.z[k] - reach[k]), min(upper[k], found.z[k] + reach[k])
    sums = _Stored(SumsOfSquares(residuals, found.horizon, found.z, reach), store, found)

    def logarithm(points: Array) -> Array:
        inside = np.all((points >= lower) & (points <= upper), axis=1)
        result = np.full(len(points), -math.inf)
        result[inside] = -0.5 / inflation * sums(points[inside], threads) if inside.any() else 0.0
        return result

    count = max(POSTERIOR_WALKERS, 2 * math.ceil(1.5 * len(found.z)))
    first = np.random.default_rng(fit.seed).multivariate_normal(found.z, covariance, count, method="eigh")
    first = np.where(first < lower, 2.0 * lower - first, np.where(first > upper, 2.0 * upper - first, first))
    moves = [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)]
    sampler = emcee.EnsembleSampler(count, len(found.z), logarithm, moves=moves, vectorize=True)
    sampler.log_prob_fn = logarithm  # emcee's wrapper prints a trace where a user interrupts
    sampler.random_state = np.random.RandomState(fit.seed).get_state()
    time, most = math.inf, max(fit.posterior_runs // count, 2 * POSTERIOR_LOOK)
    for _ in sampler.sample(np.clip(first, lower, upper), iterations=most, skip_initial_state_check=True):
        if sampler.iteration % POSTERIOR_LOOK == 0:
            with np.errstate(all="ignore"):  # a walker that stands still has no autocorrelation
                time = float(np.max(sampler.get_autocorr_time(tol=0)))
            show(f"posterior, {sampler.iteration * count} runs: {sampler.iteration / time:.3g} autocorrelation times")
            if sampler.iteration >= POSTERIOR_ENOUGH * time:
                break
    if not time < math.inf:
        raise RunError("the walkers of the posterior do not move: narrow the limits of the unknowns")
    chain = sampler.get_chain(discard=min(math.ceil(POSTERIOR_BEGINNING * time), sampler.iteration // 2))
    values = np.array([[residuals.values(z) for z in line] for line in chain])
    return Posterior(
        parameters=_parameters(residuals, values),
        samples=np.concatenate(values[:: math.ceil(values.shape[0] * values.shape[1] / POSTERIOR_KEPT)]).tolist(),
        walkers=count,
        runs=sampler.iteration * count,
        acceptance=float(sampler.acceptance_fraction.mean()),
        autocorrelation_times=sampler.iteration / time,
        enough=bool(sampler.iteration >= POSTERIOR_ENOUGH * time),
    )


class _Stored:
    """Sums of squares that a file keeps, in rows of a point and its sum; the first row belongs to the fit."""

    def __init__(self, sums: SumsOfSquares, path: Path | None, found: Fitted) -> None:
        self._sums, self._path, self._known = sums, path, dict[bytes, float]()
        if path is None:
            return
        first = np.append(found.z, np.sum(found.evaluated.residual**2))
        numbers = np.fromfile(path) if path.exists() else np.empty(0)
        rows = numbers[: len(numbers) // len(first) * len(first)].reshape(-1, len(first))
        if not np.array_equal(rows[:1], first[None]):
            rows = first[None]
            rows.tofile(path)
        os.truncate(path, rows.nbytes)  # the last row may have no end
        self._known = {row[:-1].tobytes(): float(row[-1]) for row in rows[1:]}

    def __call__(self, points: Array, threads: int | None) -> Array:
        new = np.array([z.tobytes() not in self._known for z in points])
        if new.any():
            rows = np.column_stack([points, self._sums(points, threads)])[new]  # all: a part may differ by rounding
            self._known |= {row[:-1].tobytes(): float(row[-1]) for row in rows}
            if self._path is not None:
                with self._path.open("ab") as file:
                    rows.tofile(file)
        return np.array([self._known[z.tobytes()] for z in points])


def _covariance(residuals: Residuals, jacobian: Array) -> Array:
    """Return the linear covariance (k, k) of all values, with the limits as if they were normal priors."""
    information = jacobian.T @ jacobian + np.diag(12.0 / (residuals.upper - residuals.lower) ** 2)
    scale = np.sqrt(np.diag(information))
    return np.asarray(np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale), np.float64)


def _parameters(residuals: Residuals, values: Array) -> dict[str, Sampled]:
    """Summarise a chain (steps, walkers, n) of the unknowns."""
    ends = np.quantile(values, [0.5, 0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0], axis=(0, 1)).T.tolist()
    spread = values.std(axis=(0, 1)).tolist()
    return {
        name: Sampled(median=middle, deviation=deviation, interval=Interval(low, high))
        for name, (middle, low, high), deviation in zip(residuals.names, ends, spread, strict=False)
    }
