"""Numbers from trajectories: extremes over continuous time, integrals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from linkages.arrays import Array
from linkages.errors import InputError
from linkages.integrate.parabola import parabola_top
from linkages.results.trajectory import Trajectory

_CANDIDATES = 3  # neighbouring samples within this many of the best local extremes are refined
_NEAR = 0.01  # of a column's range: how much lower than the best sample another candidate may be
_ROUNDS = 8  # of refinement
_KEPT = 1e-7  # of the column's magnitude: error of a maximum that is refined no further
_NOISE = 2e-4  # of the column's magnitude: a parabola's error that may be the run's own, whose steps join that well
_SHRUNK = 0.6  # of the error before: that of a kink falls with the bracket, that of the run does not
_STALE = 3  # rounds without anything higher, after which nothing is expected there
_DOUBT = 10.0  # times the last parabola's error: how much higher than the next one's top a maximum may be
_APART = 0.05  # of a bracket: distance from its samples at which another one judges the parabola through them


class Bracket(NamedTuple):
    """A maximum to be refined: column, sign that makes it one, samples around it.

    Attributes
    ----------
    times, values : (n,) arrays
        At most 3 samples, values with the sign.
    scale : float
        Magnitude of the column, by which errors are judged.
    """

    name: str
    sign: float
    times: Array
    values: Array
    scale: float


@dataclass(frozen=True)
class Extremes:
    """Smallest and largest value of a column over continuous time, and the time of the largest magnitude [s]."""

    min: float
    max: float
    time: float

    @property
    def peak(self) -> float:
        """Largest magnitude."""
        return max(abs(self.min), abs(self.max))


class Peak(NamedTuple):
    """Largest magnitude of a column over continuous time, and when [s]."""

    value: float
    time: float


def extremes(trajectory: Trajectory, names: Sequence[str]) -> dict[str, Extremes]:
    """Extremes over continuous time of the named columns.

    The best samples are bracketed by their neighbours and refined (`refine`).

    Parameters
    ----------
    trajectory : Trajectory
    names : sequence of str
        Columns of the trajectory.

    Returns
    -------
    dict of str to Extremes
        By name, in the unit of the column; times [s].

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
        result[name] = Extremes(-low, high, t_max if high >= low else t_min)
    return result


def peaks(trajectory: Trajectory, names: Sequence[str]) -> dict[str, Peak]:
    """Largest magnitudes over continuous time of the named columns: `extremes` without what is not largest.

    Parameters
    ----------
    trajectory : Trajectory
    names : sequence of str
        Columns of the trajectory.

    Returns
    -------
    dict of str to Peak
        By name, in the unit of the column; times [s].
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
        for i in _local_maxima(y):
            window = slice(max(i - 1, 0), i + 2)
            brackets.append(Bracket(name, sign, trajectory.time[window], y[window], scale))
    best: dict[tuple[str, float], tuple[float, float]] = {}
    for bracket, (when, value) in zip(brackets, refine(trajectory, brackets, rivals=True), strict=True):
        key = bracket.name, bracket.sign
        if key not in best or value > best[key][1] + _KEPT * bracket.scale:  # the first of equal ones
            best[key] = when, value
    return best


def refine(trajectory: Trajectory, brackets: Sequence[Bracket], rivals: bool = False) -> list[tuple[float, float]]:
    """Time and value of the maximum in each bracket, over continuous time.

    The top of the parabola through a bracket's samples is evaluated, again and again, until what the parabola has
    promised comes true. Where it does not (at a kink, or between coarse steps) the middles between the samples are
    evaluated as well, until rounds find nothing higher and what is missed, as small as the errors that a run's steps
    leave in forces, shrinks no more. Without `Trajectory.evaluate` (a loaded trajectory) the parabola alone refines
    the samples.

    Parameters
    ----------
    trajectory : Trajectory
    brackets : sequence of Bracket
    rivals : bool
        Whether only the highest of the brackets of a column and sign is of interest: the others are then
        refined only while they may still become the highest.

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
    """A bracket on its way to its maximum."""

    def __init__(self, bracket: Bracket) -> None:
        self.bracket = bracket
        self.settled = False
        self.miss = np.inf  # by how much the last parabola was wrong
        self.stale = 0  # rounds without anything higher

    @property
    def best(self) -> float:
        """Value of the highest sample."""
        return float(self.bracket.values.max())

    @property
    def top(self) -> tuple[float, float]:
        """Time and height of the top of the parabola through the samples."""
        return vertex(self.bracket.times, self.bracket.values)

    def times(self) -> Array:
        """Return when to evaluate next: at the parabola's top, from the second time on in the middles too."""
        t, y = self.bracket.times, self.bracket.values
        middles = 0.5 * (t[1:] + t[:-1])
        if _has_top(self.bracket):
            return np.array([self.top[0], *(middles if np.isfinite(self.miss) else ())])
        return middles[:1] if np.argmax(y) == 0 else middles[-1:]

    def take(self, times: Array, values: Array) -> None:
        """Take samples into the bracket, judge its parabola by them, narrow it to the best one and its neighbours."""
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
        # near a smooth top the parabola's top is wrong by miss^2 / (4 drop) only: it is flat there
        small, drop = _KEPT * old.scale, y[best] - y.min()
        # a value beside a known one says little of the parabola
        apart = np.abs(times[:, None] - old.times).min(axis=1).max() > _APART * np.ptp(old.times)
        smooth = apart and (self.miss <= small or self.miss**2 <= 0.01 * small * drop)
        rough = _SHRUNK * before <= self.miss <= _NOISE * old.scale
        self.settled = bool(smooth or (rough and self.stale >= _STALE))


def _drop_lower(searches: Sequence[_Search]) -> None:
    """Settle what cannot become the highest of its column and sign any more."""
    highest: dict[tuple[str, float], float] = {}
    for search in searches:
        key = search.bracket.name, search.bracket.sign
        highest[key] = max(highest.get(key, -np.inf), search.best)
    for search in searches:
        search.settled |= search.top[1] + _DOUBT * search.miss < highest[search.bracket.name, search.bracket.sign]


def integral(trajectory: Trajectory, values: str | Array) -> float:
    """Integrate a column, or values at the trajectory's samples, over time by the parabolas through neighbours.

    Parameters
    ----------
    trajectory : Trajectory
    values : str or (nt,) array_like
        Name of a column, or one value for each sample.

    Returns
    -------
    float
        [unit of the values times s]

    Raises
    ------
    InputError
        If there is no such column, or the values are not one number for each sample.

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
    if len(values) < 3:
        return 0.0
    step = np.diff(trajectory.time)
    bend = np.diff(np.diff(values) / step) / (step[1:] + step[:-1])  # half the second derivative
    at_ends = np.concatenate([bend[:1], bend]) + np.concatenate([bend, bend[-1:]])
    return float((step * (values[1:] + values[:-1]) / 2.0 - step**3 * at_ends / 12.0).sum())


def _sampled(trajectory: Trajectory, values: Array) -> Array:
    """Return values as an array of one number for each sample, or raise InputError."""
    wanted = f"give the name of a column, or an array of {len(trajectory.time)} numbers, one for each sample"
    try:
        found = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("argument", "values", f"are not numbers; {wanted}") from None
    if found.shape != trajectory.time.shape:
        raise InputError("argument", "values", f"have the shape {found.shape}; {wanted}")
    return found


def _local_maxima(y: Array) -> list[int]:
    """Find the largest local maxima, ends included."""
    padded = np.concatenate([[-np.inf], y, [-np.inf]])
    found = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]))
    near = found[y[found] >= y.max() - _NEAR * np.ptp(y)]
    return sorted(int(i) for i in near[np.argsort(-y[near], kind="stable")][:_CANDIDATES])


def _has_top(bracket: Bracket) -> bool:
    """Whether the best sample has a neighbour on both sides."""
    return len(bracket.times) == 3 and int(np.argmax(bracket.values)) == 1


def vertex(t: Array, y: Array) -> tuple[float, float]:
    """Return time and value of the vertex of the parabola through three samples, or of the highest sample.

    The vertex is that of a maximum between the samples. There may also be fewer than three.
    """
    best = int(np.argmax(y))
    if len(t) < 3 or best != 1:
        return float(t[best]), float(y[best])
    top, height = parabola_top(*map(float, t), *map(float, y))
    return top, height


def _through(t: Array, y: Array, x: Array) -> Array:
    """Values at x of the parabola through three samples."""
    (a, b, c), (fa, fb, fc) = t, y
    left, right = (fb - fa) / (b - a), (fc - fb) / (c - b)
    return np.asarray(fa + (x - a) * (left + (x - b) * (right - left) / (c - a)))
