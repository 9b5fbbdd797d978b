"""Least squares from several starts, over windows that grow from the beginning of the run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from linkages.base.arrays import Array
from linkages.engines.threads import in_threads
from optim.identify.batches import SumsOfSquares
from optim.identify.residuals import Evaluated, Residuals

_FIRST = 20  # fewest samples of the first window, and samples for each value
_GROWTH = 2.0  # ratio of two windows
_CANDIDATES = 8  # points of which one becomes a start
_ENOUGH = 1e-8  # relative change of the sum of squares, or of the values, at which a fit ends
_ROUNDS = 2  # fits with deviations that follow from residuals, after the first
_MOST = 60  # runs in a window
_WORTH = 1.02  # least ratio of two windows, at the horizon


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


class Search:
    """The residuals as two functions of `least_squares`, with one run for both.

    `reduced` (k,) marks the values that move; the others stay as in `z`.
    """

    def __init__(self, residuals: Residuals, z: Array, horizon: float, moving: Array | None = None) -> None:
        self.residuals, self.horizon, self.runs = residuals, horizon, 0
        self.z, self.moving = z.copy(), np.ones(len(z), bool) if moving is None else moving
        self._latest: tuple[bytes, Evaluated] | None = None

    def at(self, x: Array) -> Evaluated:
        """Evaluate the residuals, once for equal values."""
        if self._latest is None or self._latest[0] != x.tobytes():
            z = self.z.copy()
            z[self.moving] = x
            self._latest = x.tobytes(), self.residuals(z, self.horizon)
            self.runs += 1
        return self._latest[1]

    def solve(self, most: int = _MOST) -> tuple[Array, Evaluated]:
        """Minimise the sum of squares; return all values, and the residuals there."""
        moving, residuals = self.moving, self.residuals
        room = 1e-9 * np.where(np.isfinite(residuals.upper), residuals.upper - residuals.lower, 1.0)
        x = np.clip(self.z, residuals.lower + room, residuals.upper - room)[moving]
        if not len(x) or self.at(x).reason:
            return self.z, self.at(x)
        with np.errstate(all="ignore"):  # a value may act on no sample of a short window
            found = least_squares(
            lambda x: self.at(x).residual, x, lambda x: self.at(x).jacobian[:, moving], x_scale="jac",
            bounds=(residuals.lower[moving], residuals.upper[moving]), ftol=_ENOUGH, xtol=_ENOUGH,
                gtol=None, max_nfev=most,
        )  # fmt: skip
        z = self.z.copy()
        z[moving] = found.x
        return z, self.at(found.x)


def first_window(residuals: Residuals, last: float, grows: bool) -> float:
    """Return the end of the first window [s]: the last one, or that of the shortest useful window."""
    horizon, first = last, residuals.span()[0]
    fewest = max(_FIRST, 4 * len(residuals.start))
    while grows:
        shorter = first + (horizon - first) / _GROWTH
        if sum(part.stop - part.start for _, part in residuals.groups(shorter)) < fewest:
            break
        horizon = shorter
    return horizon


def fit_from(
    residuals: Residuals, z: Array, last: float, grows: bool, show: Callable[[str], None] = lambda text: None
) -> Fitted:
    """Fit from a start (k,), over windows that end before the horizon, from where on derivatives are not known."""
    found: Fitted | None = None
    runs, history, first = 0, [], residuals.span()[0]
    horizon = first_window(residuals, last, grows)
    if (
        not grows and residuals(z, horizon).reason
    ):  # a shorter beginning may run, and lead to values that run to the end
        return fit_from(residuals, z, last, True, show)
    while True:
        search = Search(residuals, z, horizon)
        z, evaluated = search.solve()
        runs += search.runs
        if evaluated.reason:
            return found or Fitted(z, evaluated, horizon, runs, ())
        history.append((float(runs), horizon, float(np.mean(evaluated.residual**2))))
        show(f"up to {horizon:.4g} s: chi-square of a sample {history[-1][2]:.4g}, {runs} runs")
        found = Fitted(z, evaluated, horizon, runs, tuple(history))
        longer = min(first + _GROWTH * (horizon - first), last)
        if longer > horizon:
            longer = min(longer, _reach(residuals, z, longer))
        if longer - first <= _WORTH * (horizon - first):
            return found
        horizon = longer


def _reach(residuals: Residuals, z: Array, horizon: float) -> float:
    """Return the time up to which a longer window has derivatives."""
    evaluated = residuals(z, horizon)
    return 0.0 if evaluated.reason else max(evaluated.until, 0.0) * (1.0 + 1e-9)


def starts(residuals: Residuals, count: int, seed: int, first: float) -> Array:
    """Return the starts (count, k): the given one, and the best of some points spread between the limits."""
    n = len(residuals.active)
    if count == 1:
        return residuals.start[None]
    sobol = qmc.Sobol(n, rng=np.random.default_rng(seed)).random(2 ** math.ceil(math.log2(_CANDIDATES * count)))
    points = np.tile(residuals.start, (len(sobol), 1))
    points[:, :n] = residuals.lower[:n] + sobol * (residuals.upper - residuals.lower)[:n]
    order = np.argsort(SumsOfSquares(residuals, first, residuals.start, 0.0 * residuals.start)(points), kind="stable")
    return np.vstack([residuals.start, points[order[: count - 1]]])


def _silent(text: str) -> None:
    """Show nothing: another process works."""


def fit_start(
    residuals: Residuals, last: float, grows: bool, show: Callable[[str], None], job: tuple[int, int, Array]
) -> Fitted:
    """Fit from one of some starts: its number, their number, and the start."""
    k, count, z = job
    return fit_from(residuals, z, last, grows, lambda text: show(f"start {k + 1} of {count}, {text}"))


def fit_all(
    residuals: Residuals, points: Array, last: float, grows: bool, threads: int | None, executor: Executor | None,
    known: Mapping[int, Mapping[str, Any]], done: Callable[[int, Fitted], None], show: Callable[[str], None],
) -> list[Fitted]:  # fmt: skip
    """Fit from all starts, in threads or by an executor; those in `known` are taken from an interrupted search."""
    jobs = [(k, len(points), z) for k, z in enumerate(points)]
    found: dict[int, Fitted] = {}
    for k, row in known.items():
        z, history = np.array(row["z"]), tuple(tuple(line) for line in row["history"])
        found[k] = Fitted(z, residuals(z, row["horizon"]), row["horizon"], row["runs"], history)
    left = [job for job in jobs if job[0] not in found]
    if executor is not None:
        for (k, *_), one in zip(
            left, executor.map(partial(fit_start, residuals, last, grows, _silent), left), strict=True
        ):
            found[k] = one
            done(k, one)
        return [found[k] for k in range(len(jobs))]

    def work(i: int) -> None:
        k = left[i][0]
        found[k] = fit_start(residuals, last, grows, show, left[i])
        done(k, found[k])

    in_threads(work, len(left), threads)
    return [found[k] for k in range(len(jobs))]


def best_of(found: list[Fitted]) -> Fitted:
    """Return the fit with the longest window, and of these the least chi-square."""
    longest = max((one.horizon for one in found if not one.evaluated.reason), default=0.0)
    return min(found, key=lambda one: (one.horizon < 0.99 * longest, one.cost))


def refine(residuals: Residuals, found: Fitted) -> Fitted:
    """Repeat a fit with the deviations of the residuals, where the file leaves deviations open."""
    for _ in range(_ROUNDS):
        changed = False
        for m, one in enumerate(residuals.task.measurements):
            for c, channel in enumerate(one.channels):
                if math.isnan(channel.deviation):
                    rows = next(rows for other, rows in residuals.groups(found.horizon) if other is channel)
                    left = found.evaluated.residual[rows]
                    freedom = max(len(left) - len(found.z) * len(left) / len(found.evaluated.residual), 1.0)
                    residuals.deviations[m][c] *= max(math.sqrt(float(np.sum(left**2)) / freedom), 1e-9)
                    changed = True
        if not changed:
            return found
        search = Search(residuals, found.z, found.horizon)
        z, evaluated = search.solve()
        found = Fitted(z, evaluated, found.horizon, found.runs + search.runs, found.history)
    return found
