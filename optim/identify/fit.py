"""Least squares from several starts, over windows that grow from the beginning of the run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.stats import qmc

from linkages.base.arrays import Array
from linkages.engines.threads import in_threads
from optim.identify.batches import SumsOfSquares
from optim.identify.integrals import ORDERS, impacts_end, integrated, near_starts
from optim.identify.numerics import (
    FIT_CANDIDATES,
    FIT_FIRST,
    FIT_GROWTH,
    FIT_LED,
    FIT_MOST_BATCHES,
    FIT_ROUNDS,
    FIT_SAME,
    FIT_TOGETHER,
    FIT_WORTH,
    INTEGRALS_TIME,
)
from optim.identify.residuals import Evaluated, Residuals
from optim.identify.schema import Windows
from optim.identify.search import MOST, Search
from optim.identify.statistics import WIDTHS, Statistics

_HOPELESS = 0.2, 25.0  # residuals of a wrong minimum: least part of a column's spread, and chi-square of a sample


@dataclass(frozen=True, eq=False)
class Fitted:
    """The end of a search.

    Attributes
    ----------
    z : (k,) array
        Scaled values.
    evaluated : Evaluated
        At these values.
    horizon : float
        Time up to which samples are fitted [s].
    runs : int
        Runs of the machine.
    history : tuple of (float, float, float)
        Runs so far, end of the window [s] and chi-square for each sample, after each window.
    """

    z: Array
    evaluated: Evaluated
    horizon: float
    runs: int
    history: tuple[tuple[float, float, float], ...]

    @property
    def cost(self) -> float:
        """Chi-square for each residual; infinite if the start does not run."""
        residual = self.evaluated.residual
        return math.inf if self.evaluated.reason else float(np.mean(residual**2))


def first_window(residuals: Residuals, last: float, windows: Windows) -> float:
    """Return the end of the first window [s]: the last one, or that of the shortest useful window."""
    horizon, first = last, residuals.span()[0]
    fewest = max(FIT_FIRST, 4 * len(residuals.start))
    while windows != "all":
        shorter = first + (horizon - first) / FIT_GROWTH
        if sum(part.stop - part.start for _, part in residuals.groups(shorter)) < fewest:
            break
        horizon = shorter
    return horizon


def fit_from(
    residuals: Residuals, z: Array, last: float, windows: Windows, show: Callable[[str], None] = lambda text: None
) -> Fitted:
    """Fit from a start (k,), over windows that end before the horizon, from where on derivatives are not known."""
    if isinstance(residuals, Statistics):
        runs = 0
        for width in WIDTHS:
            search = Search(residuals.of_width(width), z, last)
            z = search.solve(FIT_MOST_BATCHES).z
            runs += search.runs * residuals.size
            show(f"statistics, {runs} runs")
        return Fitted(z, residuals.of_width(WIDTHS[-1])(z, last), last, runs, ())
    if windows == "impacts" and (horizon := impacts_end(residuals, last)) > residuals.span()[0]:
        return _through_impacts(residuals, z, horizon, last, show)
    horizon = first_window(residuals, last, windows)
    if windows != "all":
        return _grown(residuals, z, horizon, last, show)
    known = residuals(z, horizon, residuals.linear)
    if known.reason and not residuals.budget.late:  # a shorter beginning may run, and lead to values that do
        return fit_from(residuals, z, last, "grow", show)
    found = _grown(residuals, z, horizon, last, show, known)
    return replace(found, runs=1 + found.runs)


def _through_impacts(
    residuals: Residuals, z: Array, horizon: float, last: float, show: Callable[[str], None]
) -> Fitted:
    """Fit integrals over the first impacts, then samples over windows that grow, unless they do not fit there."""
    runs = 0
    for order in ORDERS:
        if residuals.budget.late:
            break
        search = Search(integrated(residuals, horizon, order), z, horizon)
        z, runs = search.solve(FIT_LED).z, runs + search.runs
    search = Search(residuals, z, horizon)
    evaluated = search.solve(MOST // 2)
    found = Fitted(evaluated.z, evaluated, horizon, runs + search.runs, ())
    if hopeless(residuals, found):
        show(f"first impacts, {found.runs} runs: they do not fit")
        return found
    grown = _grown(residuals, found.z, horizon, last, show, evaluated)
    return replace(grown, runs=found.runs + grown.runs)


def _grown(
    residuals: Residuals, z: Array, horizon: float, last: float, show: Callable[[str], None],
    known: Evaluated | None = None,
) -> Fitted:  # fmt: skip
    """Fit over a window, and longer ones as far as derivatives are known; `known` are the residuals of the first."""
    found_last: Fitted | None = None
    runs, history, first = 0, [], residuals.span()[0]
    while True:
        search = Search(residuals, z, horizon, known=known)
        evaluated, known = search.solve(), None
        z, runs = evaluated.z, runs + search.runs
        if evaluated.reason:
            return found_last or Fitted(z, evaluated, horizon, runs, ())
        history.append((float(runs), horizon, float(np.mean(evaluated.residual**2))))
        show(f"up to {horizon:.4g} s: chi-square of a sample {history[-1][2]:.4g}, {runs} runs")
        found_last = Fitted(z, evaluated, horizon, runs, tuple(history))
        if residuals.budget.late:
            return found_last
        longer = min(first + FIT_GROWTH * (horizon - first), last)
        if longer > horizon:
            longer = min(longer, _reach(residuals, z, longer))
        if longer - first <= FIT_WORTH * (horizon - first) or residuals.budget.late:
            return found_last
        horizon = longer


def hopeless(residuals: Residuals, found: Fitted) -> bool:
    """Check whether a fit explains little of a column: another minimum may explain it."""
    deviations = [x for one in residuals.deviations for x in one]
    part, most = _HOPELESS
    for (channel, rows), deviation in zip(residuals.groups(found.horizon), deviations, strict=True):
        if rows.start == rows.stop:
            continue
        left = float(np.mean(found.evaluated.residual[rows] ** 2))
        spread = float(np.std(channel.values[residuals.used(channel, found.horizon)]))
        if left > most and math.sqrt(left) * deviation > part * spread:
            return True
    return bool(found.evaluated.reason)


def _reach(residuals: Residuals, z: Array, horizon: float) -> float:
    """Return the time up to which a longer window has derivatives."""
    evaluated = residuals(z, horizon)
    return 0.0 if evaluated.reason else max(evaluated.until, 0.0) * (1.0 + 1e-9)


def starts(residuals: Residuals, count: int, seed: int, last: float, windows: Windows) -> Array:
    """Return the starts (count, k): the given one, and the best of some points spread between the limits."""
    n = len(residuals.active)
    if count == 1:
        return residuals.start[None]
    if windows == "impacts" and (first := impacts_end(residuals, last)) > residuals.span()[0]:
        return np.vstack([residuals.start, near_starts(residuals, count - 1, seed, first)])
    first = first_window(residuals, last, windows)
    sobol = qmc.Sobol(n, rng=np.random.default_rng(seed)).random(2 ** math.ceil(math.log2(FIT_CANDIDATES * count)))
    points = np.tile(residuals.start, (len(sobol), 1))
    points[:, :n] = residuals.lower[:n] + sobol * (residuals.upper - residuals.lower)[:n]
    sums = SumsOfSquares(residuals, first, residuals.start, 0.0 * residuals.start, residuals.linear)
    costs = np.full(len(points), np.inf)
    for k in range(0, len(points), FIT_CANDIDATES):
        costs[k : k + FIT_CANDIDATES] = sums(points[k : k + FIT_CANDIDATES])
        if residuals.budget.used > INTEGRALS_TIME:
            break
    order = np.argsort(costs, kind="stable")
    return np.vstack([residuals.start, points[order[: count - 1]]])


def _silent(text: str) -> None:
    """Show nothing: another process works."""


def fit_start(
    residuals: Residuals, last: float, windows: Windows, show: Callable[[str], None], job: tuple[int, int, Array]
) -> Fitted:
    """Fit from one of some starts: its number, their number, and the start."""
    k, count, z = job
    return fit_from(residuals, z, last, windows, lambda text: show(f"start {k + 1} of {count}, {text}"))


def fit_all(
    residuals: Residuals, points: Array, before: int, last: float, windows: Windows, threads: int | None,
    executor: Executor | None, known: Mapping[int, Mapping[str, Any]], done: Callable[[int, Fitted], None],
    show: Callable[[str], None], enough: bool = False,
) -> list[Fitted]:  # fmt: skip
    """Fit from starts, in threads or by an executor; those in `known` are taken from an interrupted search.

    A search that the limit of time ends is not `done`, and no further one begins then. With `enough`, none begins
    after one that is not hopeless.

    The number of starts `before` counts in their names.
    """
    jobs = [(before + k, before + len(points), z) for k, z in enumerate(points)]
    found: dict[int, Fitted] = {}
    for k, *_ in jobs:
        if k in known:
            row = known[k]
            z, history = np.array(row["z"]), tuple(tuple(line) for line in row["history"])
            found[k] = Fitted(z, residuals(z, row["horizon"]), row["horizon"], row["runs"], history)
    left = [job for job in jobs if job[0] not in found]
    work_there = partial(fit_start, residuals, last, windows, _silent)

    def work(i: int) -> None:
        k = left[i][0]
        if k > 0 and residuals.budget.late:
            return
        found[k] = fit_start(residuals, last, windows, show, left[i])
        if not residuals.budget.late:
            done(k, found[k])

    while left and not (enough and any(not hopeless(residuals, one) for one in found.values())):
        later, left = (left[FIT_TOGETHER:], left[:FIT_TOGETHER]) if enough else ([], left)
        if executor is None:
            in_threads(work, len(left), threads)
        else:
            for (k, *_), one in zip(left, executor.map(work_there, left), strict=True):
                found[k] = one
                if not residuals.budget.late:
                    done(k, one)
        left = later
    return [found[k] for k, *_ in jobs if k in found]


def best_of(residuals: Residuals, found: list[Fitted]) -> Fitted:
    """Return the fit that is not hopeless, has the longest window, and of these the least chi-square."""
    lost = {id(one): hopeless(residuals, one) for one in found}
    longest = max((one.horizon for one in found if not lost[id(one)]), default=0.0)
    return min(found, key=lambda one: (lost[id(one)], one.horizon < 0.99 * longest, one.cost))


def fit_again(residuals: Residuals, found: Fitted) -> Fitted:
    """Continue a fit with changed residuals."""
    search = Search(residuals, found.z, found.horizon)
    evaluated = search.solve()
    return replace(found, z=evaluated.z, evaluated=evaluated, runs=found.runs + search.runs)


def agreeing(all_starts: list[Fitted], best: Fitted) -> int:
    """Return how many starts have ended at the best chi-square of the window of the best one."""
    costs = [one.cost for one in all_starts if one.horizon >= 0.99 * best.horizon]
    return sum(cost <= min(costs) * (1.0 + FIT_SAME) + 1e-9 for cost in costs)


def refine(residuals: Residuals, found: Fitted) -> Fitted:
    """Repeat a fit with the deviations of the residuals, where the file leaves deviations open."""
    for _ in range(FIT_ROUNDS):
        if residuals.budget.late:
            return found
        changed = False
        for m, one in enumerate(residuals.task.measurements):
            for c, channel in enumerate(one.channels):
                if not residuals.stated(channel):
                    rows = next(rows for other, rows in residuals.groups(found.horizon) if other is channel)
                    left = found.evaluated.residual[rows]
                    freedom = max(len(left) - len(found.z) * len(left) / len(found.evaluated.residual), 1.0)
                    residuals.deviations[m][c] *= max(math.sqrt(float(np.sum(left**2)) / freedom), 1e-9)
                    changed = True
        if not changed:
            return found
        found = fit_again(residuals, found)
    return found
