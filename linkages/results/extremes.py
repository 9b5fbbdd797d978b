"""Extremes over continuous time and integrals of columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from linkages.base.arguments import Names, numbers, validated
from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.mechanics.integrate import peak_search
from linkages.results import numerics
from linkages.results.outputs.columns import Columns
from linkages.results.quadrature import with_middles
from linkages.results.trajectory import Trajectory


class Bracket(NamedTuple):
    """A maximum to refine: column, sign (-1 for a minimum), its up to 3 samples, their values times the sign."""

    name: str
    sign: float
    times: Array
    values: Array


@dataclass(frozen=True)
class Extremes:
    """Smallest and largest value of a column over continuous time; made by `extremes`.

    Attributes
    ----------
    min, max : float
        In the column's unit.
    time_min, time_max : float
        Times of these values [s].
    """

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
    neighbours and refined by `refine`. For a run of the compiled engine they equal the statistics of
    `linkages.simulate_batch` with the same outputs. `peaks` gives the largest magnitudes alone and is faster.

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
    (6.962, 0.08713)
    """
    highs = _maxima(trajectory, [(name, sign) for name in names for sign in (1.0, -1.0)])
    result = {}
    for name in names:
        (t_max, high), (t_min, low) = highs[name, 1.0], highs[name, -1.0]
        result[name] = Extremes(-low, high, t_min, t_max)
    return result


def peaks(trajectory: Trajectory, names: Sequence[str]) -> dict[str, Peak]:
    """Compute the largest magnitudes over continuous time of columns, by name (faster than `extremes`)."""
    wanted = []
    for name in names:
        high, low = trajectory[name].max(), trajectory[name].min()
        near = max(high, -low) - numerics.EXTREMES_NEAR * (high - low)
        wanted += [(name, sign) for sign in (1.0, -1.0) if max(sign * high, sign * low) >= near]
    found = _maxima(trajectory, wanted)
    result: dict[str, Peak] = {}
    for (name, _), (time, value) in found.items():
        if name not in result or value > result[name].value:
            result[name] = Peak(value, time)
    return result


class _Maximum:
    """The search for the maximum of sign times a column: time and value of the highest place that is known."""

    def __init__(self, name: str, sign: float, times: Array, values: Array) -> None:
        places, self._tops = np.empty(peak_search.MOST, np.int64), np.empty(peak_search.MOST)
        count = peak_search.candidates(times, values, sign, places, self._tops)
        windows = [slice(first, first + 3) for first in np.clip(places[:count] - 1, 0, len(times) - 3)]
        self.brackets = [Bracket(name, sign, times[window].copy(), sign * values[window]) for window in windows]
        best = int(values.argmax() if sign > 0.0 else values.argmin())
        self.time, self.value = float(times[best]), sign * float(values[best])
        self.floor = -np.inf  # height below which local maxima do not count

    def chosen(self, rivals: bool) -> list[int]:
        """Choose the most promising local maximum, or the others that may be higher."""
        return [k for k in range(len(self.brackets)) if (k > 0) == rivals and self._counts(k)]

    def _counts(self, k: int) -> bool:
        return k < peak_search.FEW or bool(self._tops[k] > self.value)

    def take(self, k: int, time: float, value: float) -> None:
        """Take a refined local maximum, unless an equal or higher one is known."""
        if self._counts(k) and value > (peak_search.above(self.value) if k else self.value):
            self.time, self.value = time, value
        if k == 0:
            self.floor = peak_search.above(self.value)


def _maxima(
    trajectory: Trajectory, wanted: Sequence[tuple[str, float]]
) -> dict[tuple[str, float], tuple[float, float]]:
    """Find time and value of the maximum of sign times column, for each (column, sign)."""
    places, middles = _middles(trajectory, [name for name, _ in wanted])
    times = np.insert(trajectory.time, places, middles["time"])
    found = {
        (name, sign): _Maximum(name, sign, times, np.insert(trajectory[name], places, middles[name]))
        for name, sign in wanted
    }
    for rivals in (False, True):
        asked = [(one, k) for one in found.values() for k in one.chosen(rivals)]
        tops = refine(trajectory, [one.brackets[k] for one, k in asked], [one.floor for one, _ in asked])
        for (one, k), (time, value) in zip(asked, tops, strict=True):
            one.take(k, time, value)
    return {key: (one.time, one.value) for key, one in found.items()}


def _middles(trajectory: Trajectory, names: Sequence[str]) -> tuple[list[int], Columns]:
    """Return columns in the middle of the first and of the last interval, and the places of these among the samples.

    Maxima within these intervals have samples on both sides then.
    """
    if not trajectory.evaluate or len(trajectory.time) < 2:
        return [], dict.fromkeys(["time", *names], np.zeros(0))
    before, after = trajectory.time[[0, -2]], trajectory.time[[1, -1]]
    last = 0.5 * (before[1] + after[1])
    times = np.array([0.5 * (before[0] + min(after[0], last)), last])
    return [1, len(trajectory.time) - 1], trajectory.evaluate(times)


def refine(
    trajectory: Trajectory, brackets: Sequence[Bracket], floors: Sequence[float] | None = None
) -> list[tuple[float, float]]:
    """Compute time and value of the maximum in each bracket, over continuous time.

    See `linkages.mechanics.integrate.peak_search`. Without `Trajectory.evaluate` (a loaded trajectory) the parabola
    alone refines the samples. `floors` are heights of which it is enough to know that the maximum of a bracket is
    lower. The values, as those of the brackets, are times the sign.
    """
    result = [vertex(bracket.times, bracket.values) for bracket in brackets]
    if not trajectory.evaluate:
        return result
    brackets, floors = _of_three(trajectory, brackets), floors or [-np.inf] * len(brackets)
    searches = {k: np.empty((3, 3)) for k, bracket in enumerate(brackets) if len(bracket.times) == 3}
    for k, search in searches.items():
        peak_search.begin(search, brackets[k].times, brackets[k].values, 1.0, 1)
    active = list(searches)
    while asked := [(k, t) for k in active if (t := peak_search.next_time(searches[k], floors[k])) == t]:
        active = [k for k, _ in asked]
        values = _values(trajectory, [(brackets[k], t) for k, t in asked])
        for (k, t), value in zip(asked, values, strict=True):
            peak_search.take(searches[k], t, value)
    for k, search in searches.items():
        result[k] = float(search[peak_search.TIMES, 1]), float(search[peak_search.VALUES, 1])
    return result


def _of_three(trajectory: Trajectory, brackets: Sequence[Bracket]) -> list[Bracket]:
    """Add the sample in the middle to brackets of two."""
    pairs = {k: float(bracket.times.mean()) for k, bracket in enumerate(brackets) if len(bracket.times) == 2}
    values = _values(trajectory, [(brackets[k], t) for k, t in pairs.items()])
    result = list(brackets)
    for (k, t), value in zip(pairs.items(), values, strict=True):
        times, ends = brackets[k].times, brackets[k].values
        result[k] = brackets[k]._replace(times=np.insert(times, 1, t), values=np.insert(ends, 1, value))
    return result


def _values(trajectory: Trajectory, asked: Sequence[tuple[Bracket, float]]) -> list[float]:
    """Evaluate the column of each bracket, with its sign, at a time."""
    if not asked:
        return []
    assert trajectory.evaluate is not None
    times, places = np.unique([t for _, t in asked], return_inverse=True)
    columns = trajectory.evaluate(times)
    return [bracket.sign * float(columns[bracket.name][k]) for (bracket, _), k in zip(asked, places, strict=True)]


def averages(trajectory: Trajectory, name: str) -> tuple[float, float]:
    """Compute mean and root mean square of a column over the time of a trajectory."""
    time, values = with_middles(trajectory, name)
    return peak_search.average(time, values, False), peak_search.average(time, values, True)


@validated
def integral(trajectory: Trajectory, values: str | Array) -> float:
    """Integrate a column, or values at the samples, over time by parabolas through neighbouring samples.

    A column of a run is evaluated between samples too, where they are too few for a short force.

    Parameters
    ----------
    trajectory : Trajectory
    values : str or (nt,) array_like
        Name of a column, or one value for each sample. A column may jump where states are sampled.

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
    time, values = (
        with_middles(trajectory, values) if isinstance(values, str) else (trajectory.time, _sampled(trajectory, values))
    )
    return peak_search.integrate_samples(time, np.ascontiguousarray(values, dtype=np.float64), False)


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


def vertex(t: Array, y: Array) -> tuple[float, float]:
    """Compute time and value of the vertex of the parabola through three samples, or of the highest sample.

    The vertex counts if it is a maximum between the samples. Fewer than three samples are allowed.
    """
    best = int(np.argmax(y))
    if len(t) < 3 or best != 1:
        return float(t[best]), float(y[best])
    return peak_search.parabola_top(*map(float, t), *map(float, y))
