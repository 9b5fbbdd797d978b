"""Extremes over continuous time and integrals of columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from linkages.arguments import Names, numbers, validated
from linkages.arrays import Array
from linkages.errors import InputError
from linkages.integrate.parabola import parabola_top
from linkages.results.trajectory import Trajectory

_CANDIDATES = 3  # number of the highest local maxima that are refined: by their samples, and by their parabolas
_NEAR = 0.01  # largest deficit of a candidate against the best sample, over the column's range
_ROUNDS = 8  # most rounds of refinement
_KEPT = 1e-7  # tolerance of a maximum over the column's magnitude
_NOISE = 2e-4  # error of a parabola over the column's magnitude that may be the run's error between steps
_SHRUNK = 0.6  # error reduction per round: at a kink the error falls with the bracket, the run's error does not
_STALE = 3  # rounds without a higher value after which the search ends
_DOUBT = 10.0  # safety factor on the interpolation error of the last parabola
_APART = 0.05  # relative distance from a bracket's samples at which a new sample tests its parabola


class Bracket(NamedTuple):
    """A maximum to refine: column, sign (-1 for a minimum), samples around it.

    Attributes
    ----------
    times, values : (n,) arrays
        At most 3 samples, with values times the sign.
    scale : float
        Magnitude of the column, for relative errors.
    """

    name: str
    sign: float
    times: Array
    values: Array
    scale: float


@dataclass(frozen=True)
class Extremes:
    """Smallest and largest value of a column over continuous time, and their times [s]."""

    min: float
    max: float
    time_min: float
    time_max: float

    @property
    def time(self) -> float:
        """Return the time of the largest magnitude [s]."""
        return self.time_max if self.max >= -self.min else self.time_min

    @property
    def peak(self) -> float:
        """Return the largest magnitude."""
        return max(abs(self.min), abs(self.max))


class Peak(NamedTuple):
    """Largest magnitude of a column over continuous time, and its time [s]."""

    value: float
    time: float


@validated
def extremes(trajectory: Trajectory, names: Names) -> dict[str, Extremes]:
    """Compute the extremes over continuous time of columns.

    Use it instead of the samples' extremes, which miss peaks between steps: the best samples are bracketed by their
    neighbours and refined by `refine`. `peaks` gives the largest magnitudes alone and is faster.

    Parameters
    ----------
    trajectory : Trajectory
    names : sequence of str
        Columns of the trajectory.

    Returns
    -------
    dict of str to Extremes
        Extremes by name, in the unit of the column; times [s].

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.1})
    >>> force = linkages.extremes(linkages.simulate(system, "compiled"), ["A.force"])["A.force"]
    >>> round(force.peak, 3), round(force.time, 5)  # N, s
    (3.322, 0.00033)
    """
    highs = _maxima(trajectory, [(name, sign) for name in names for sign in (1.0, -1.0)])
    result = {}
    for name in names:
        (t_max, high), (t_min, low) = highs[name, 1.0], highs[name, -1.0]
        result[name] = Extremes(-low, high, t_min, t_max)
    return result


def peaks(trajectory: Trajectory, names: Sequence[str]) -> dict[str, Peak]:
    """Compute the largest magnitudes over continuous time of columns (faster than `extremes`).

    Parameters
    ----------
    trajectory : Trajectory
    names : sequence of str
        Columns of the trajectory.

    Returns
    -------
    dict of str to Peak
        Peaks by name, in the unit of the column; times [s].
    """
    wanted = []
    for name in names:
        high, low = trajectory[name].max(), trajectory[name].min()
        near = max(high, -low) - _NEAR * (high - low)
        wanted += [(name, sign) for sign in (1.0, -1.0) if max(sign * high, sign * low) >= near]
    found = _maxima(trajectory, wanted)
    result: dict[str, Peak] = {}
    for (name, _), (time, value) in found.items():
        if name not in result or value > result[name].value:
            result[name] = Peak(value, time)
    return result


def _maxima(
    trajectory: Trajectory, wanted: Sequence[tuple[str, float]]
) -> dict[tuple[str, float], tuple[float, float]]:
    """Find time and value of the maximum of sign times column, for each (column, sign)."""
    brackets: list[Bracket] = []
    for name, sign in wanted:
        y = sign * trajectory[name]
        scale = float(np.abs(y).max())
        for i in _local_maxima(trajectory.time, y):
            window = slice(max(i - 1, 0), i + 2)
            brackets.append(Bracket(name, sign, trajectory.time[window], y[window], scale))
    best: dict[tuple[str, float], tuple[float, float]] = {}
    for bracket, (when, value) in zip(brackets, refine(trajectory, brackets, rivals=True), strict=True):
        key = bracket.name, bracket.sign
        if key not in best or value > best[key][1] + _KEPT * bracket.scale:  # the first of equal maxima
            best[key] = when, value
    return best


def refine(trajectory: Trajectory, brackets: Sequence[Bracket], rivals: bool = False) -> list[tuple[float, float]]:
    """Compute time and value of the maximum in each bracket, over continuous time.

    The vertex of the parabola through a bracket's samples is evaluated repeatedly, until the prediction is confirmed.
    If it is not (at a kink, or between coarse steps), the midpoints between the samples are evaluated as well, until
    rounds give no higher value and the remaining error, as small as the errors of forces at a run's steps, no longer
    shrinks. Without `Trajectory.evaluate` (a loaded trajectory) the parabola alone refines the samples.

    Parameters
    ----------
    trajectory : Trajectory
    brackets : sequence of Bracket
    rivals : bool
        Whether only the highest bracket of a column and sign is needed: the others are then refined only as long as
        they can become the highest.

    Returns
    -------
    list of (float, float)
        Times [s] and values, with the brackets' signs.
    """
    if trajectory.evaluate is None or len(trajectory.time) < 2:
        return [vertex(bracket.times, bracket.values) for bracket in brackets]
    searches = [_Search(bracket) for bracket in brackets]
    for _ in range(_ROUNDS):
        if rivals:
            _drop_lower(searches)
        asked = [(search, search.times()) for search in searches if not search.settled]
        if not asked:
            break
        times = np.unique(np.concatenate([new for _, new in asked]))
        columns = trajectory.evaluate(times)
        for search, new in asked:
            bracket = search.bracket
            search.take(new, bracket.sign * columns[bracket.name][np.searchsorted(times, new)])
    return [(search.top[0], search.best) for search in searches]


class _Search:
    """The search for the maximum in a bracket."""

    def __init__(self, bracket: Bracket) -> None:
        self.bracket = bracket
        self.settled = False
        self.miss = np.inf  # error of the last parabola
        self.stale = 0  # rounds without a higher value

    @property
    def best(self) -> float:
        """Return the value of the highest sample."""
        return float(self.bracket.values.max())

    @property
    def top(self) -> tuple[float, float]:
        """Compute time and value of the vertex of the parabola through the samples."""
        return vertex(self.bracket.times, self.bracket.values)

    def times(self) -> Array:
        """Return the next evaluation times: the parabola's vertex, later the midpoints too."""
        t, y = self.bracket.times, self.bracket.values
        middles = 0.5 * (t[1:] + t[:-1])
        if _has_top(self.bracket):
            return np.array([self.top[0], *(middles if np.isfinite(self.miss) else ())])
        return middles[:1] if np.argmax(y) == 0 else middles[-1:]

    def take(self, times: Array, values: Array) -> None:
        """Add samples, test the parabola with them, narrow the bracket to the best sample and its neighbours."""
        old = self.bracket
        t, first = np.unique(np.concatenate([old.times, times]), return_index=True)
        y = np.concatenate([old.values, values])[first]
        best = int(np.argmax(y))
        window = slice(max(best - 1, 0), best + 2)
        self.bracket = old._replace(times=t[window], values=y[window])
        self.stale = 0 if y[best] > old.values.max() + _KEPT * old.scale else self.stale + 1
        if len(old.times) < 3:
            return
        before, self.miss = self.miss, float(np.abs(values - _through(old.times, old.values, times)).max())
        # near a smooth maximum the vertex has an error of only miss^2 / (4 drop), as the curve is flat
        small, drop = _KEPT * old.scale, y[best] - y.min()
        # a value close to a known sample does not test the parabola
        apart = np.abs(times[:, None] - old.times).min(axis=1).max() > _APART * np.ptp(old.times)
        smooth = apart and (self.miss <= small or self.miss**2 <= 0.01 * small * drop)
        rough = _SHRUNK * before <= self.miss <= _NOISE * old.scale
        self.settled = bool(smooth or (rough and self.stale >= _STALE))


def _drop_lower(searches: Sequence[_Search]) -> None:
    """End the searches that can no longer give the highest value of their column and sign."""
    highest: dict[tuple[str, float], float] = {}
    for search in searches:
        key = search.bracket.name, search.bracket.sign
        highest[key] = max(highest.get(key, -np.inf), search.best)
    for search in searches:
        search.settled |= search.top[1] + _DOUBT * search.miss < highest[search.bracket.name, search.bracket.sign]


@validated
def integral(trajectory: Trajectory, values: str | Array) -> float:
    """Integrate a column, or values at the samples, over time by parabolas through neighbouring samples.

    Parameters
    ----------
    trajectory : Trajectory
    values : str or (nt,) array_like
        Name of a column, or one value for each sample.

    Returns
    -------
    float
        Integral in the unit of the values times s.

    Raises
    ------
    InputError
        If the column is unknown, or the values are not one number for each sample.

    Examples
    --------
    >>> import linkages
    >>> motion = linkages.ideal(linkages.load(linkages.find_file("seven_bar.toml")))
    >>> work = linkages.integral(motion, motion["O1.power"] + motion["O4.power"])
    >>> abs(work) < 1e-6  # J: over two periods without friction
    True
    >>> abs(linkages.integral(motion, "O1.power") + linkages.integral(motion, "O4.power") - work) < 1e-12
    True
    """
    values = trajectory[values] if isinstance(values, str) else _sampled(trajectory, values)
    step = np.diff(trajectory.time)
    if len(values) < 3:  # a straight line
        return float((step * (values[1:] + values[:-1]) / 2.0).sum())
    bend = np.diff(np.diff(values) / step) / (step[1:] + step[:-1])  # half the second derivative
    at_ends = np.concatenate([bend[:1], bend]) + np.concatenate([bend, bend[-1:]])
    return float((step * (values[1:] + values[:-1]) / 2.0 - step**3 * at_ends / 12.0).sum())


def _sampled(trajectory: Trajectory, values: Array) -> Array:
    """Return values as an array with one number per sample, or raise InputError."""
    wanted = f"give the name of a column, or an array of {len(trajectory.time)} numbers, one for each sample"
    try:
        found = numbers(values, finite=False)
    except ValueError as problem:
        raise InputError("argument", "values", f"{problem}; {wanted}") from None
    if found.shape != trajectory.time.shape:
        raise InputError("argument", "values", f"have the shape {found.shape}; {wanted}")
    return found


def _local_maxima(t: Array, y: Array) -> list[int]:
    """Find the largest local maxima, ends included: by their samples, and by the parabolas through three samples."""
    padded = np.concatenate([[-np.inf], y, [-np.inf]])
    found = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]))
    result: set[int] = set()
    for heights in (y[found], _heights(t, y)[found]):
        near = heights >= y.max() - _NEAR * np.ptp(y)
        result.update(found[near][np.argsort(-heights[near], kind="stable")][:_CANDIDATES].tolist())
    return sorted(result)


def _heights(t: Array, y: Array) -> Array:
    """Compute the height of the parabola through each local maximum and its neighbours; the sample at both ends."""
    heights, step = y.copy(), np.diff(t)
    slope, width = np.diff(y) / step, t[2:] - t[:-2]
    bend = (slope[1:] - slope[:-1]) / width
    middle = (slope[:-1] * step[1:] + slope[1:] * step[:-1]) / width
    heights[1:-1] -= np.where(bend < 0.0, 0.25 * middle**2 / np.where(bend < 0.0, bend, 1.0), 0.0)
    return heights


def _has_top(bracket: Bracket) -> bool:
    """Check whether the best sample has a neighbour on both sides."""
    return len(bracket.times) == 3 and int(np.argmax(bracket.values)) == 1


def vertex(t: Array, y: Array) -> tuple[float, float]:
    """Compute time and value of the vertex of the parabola through three samples, or of the highest sample.

    The vertex counts if it is a maximum between the samples. Fewer than three samples are allowed.
    """
    best = int(np.argmax(y))
    if len(t) < 3 or best != 1:
        return float(t[best]), float(y[best])
    top, height = parabola_top(*map(float, t), *map(float, y))
    return top, height


def _through(t: Array, y: Array, x: Array) -> Array:
    """Evaluate the parabola through three samples at x."""
    (a, b, c), (fa, fb, fc) = t, y
    left, right = (fb - fa) / (b - a), (fc - fb) / (c - b)
    return np.asarray(fa + (x - a) * (left + (x - b) * (right - left) / (c - a)))
