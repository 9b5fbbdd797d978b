"""Numbers from trajectories: extremes over continuous time, integrals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.results.parabola import parabola_top
from linkages.results.trajectory import Trajectory

Array = NDArray[np.float64]

_CANDIDATES = 3  # neighbouring samples within this many of the best local extremes are refined
_ROUNDS = 6  # of refinement; all but the first halve a bracket at least
_KEPT = (
    1e-7  # of the column's magnitude: a parabola whose top is as high as it promised has found the maximum
)


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
    brackets: list[Bracket] = []
    for name in names:
        scale = float(np.abs(trajectory[name]).max())
        for sign in (1.0, -1.0):
            y = sign * trajectory[name]
            for i in _local_maxima(y):
                window = slice(max(i - 1, 0), i + 2)
                brackets.append(Bracket(name, sign, trajectory.time[window], y[window], scale))
    best: dict[tuple[str, float], tuple[float, float]] = {}
    for bracket, (when, value) in zip(brackets, refine(trajectory, brackets), strict=True):
        key = bracket.name, bracket.sign
        if key not in best or value > best[key][1]:
            best[key] = when, value
    result = {}
    for name in names:
        (t_max, high), (t_min, low) = best[name, 1.0], best[name, -1.0]
        result[name] = Extremes(-low, high, t_max if high >= low else t_min)
    return result


def refine(trajectory: Trajectory, brackets: Sequence[Bracket]) -> list[tuple[float, float]]:
    """Time and value of the maximum in each bracket, over continuous time.

    The top of the parabola through a bracket's samples is evaluated. Where it is not as high as promised (at a kink, or
    between coarse steps) the middles between the samples are evaluated beside the next top, a few times over. Without
    `Trajectory.evaluate` (a loaded trajectory) the parabola alone refines the samples.
    """
    if trajectory.evaluate is None or len(trajectory.time) < 2:
        return [_parabola(bracket.times, bracket.values) for bracket in brackets]
    found = list(brackets)
    unsettled = list(range(len(found)))
    for number in range(_ROUNDS):
        asked = {k: _to_sample(found[k], with_middles=number > 0) for k in unsettled}
        if not asked:
            break
        times = np.unique(np.concatenate(list(asked.values())))
        columns = trajectory.evaluate(times)
        for k, new in asked.items():
            promised = _parabola(found[k].times, found[k].values)[1]
            values = found[k].sign * columns[found[k].name][np.searchsorted(times, new)]
            has_top = _has_top(found[k])
            found[k] = _narrowed(found[k], new, values)
            if has_top and abs(values[0] - promised) <= _KEPT * found[k].scale:
                unsettled.remove(k)
    highest = [int(np.argmax(bracket.values)) for bracket in found]
    return [
        (float(bracket.times[i]), float(bracket.values[i])) for bracket, i in zip(found, highest, strict=True)
    ]


def integral(trajectory: Trajectory, values: Array) -> float:
    """Integral over time of values given at the trajectory's samples.

    Parameters
    ----------
    trajectory : Trajectory
    values : (nt,) array

    Returns
    -------
    float
        [unit of the values times s]

    Examples
    --------
    >>> import linkages
    >>> motion = linkages.ideal(linkages.load(linkages.find_file("seven_bar.toml")))
    >>> work = linkages.integral(motion, motion["O1.power"] + motion["O4.power"])
    >>> abs(work) < 1e-6  # J: over two periods without friction
    True
    """
    from scipy.integrate import simpson  # takes half a second to import

    return float(simpson(values, x=trajectory.time)) if len(values) > 2 else 0.0


def _local_maxima(y: Array) -> list[int]:
    """Find the largest local maxima, ends included."""
    padded = np.concatenate([[-np.inf], y, [-np.inf]])
    found = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]))
    near = found[y[found] >= y.max() - 0.01 * np.ptp(y)]
    return [int(i) for i in near[np.argsort(-y[near], kind="stable")][:_CANDIDATES]]


def _has_top(bracket: Bracket) -> bool:
    """Whether the best sample has a neighbour on both sides."""
    return len(bracket.times) == 3 and int(np.argmax(bracket.values)) == 1


def _to_sample(bracket: Bracket, with_middles: bool) -> Array:
    """Return the times at which to evaluate a bracket: the parabola's top first, if there is one, then the middles."""
    t = bracket.times
    top = [_parabola(t, bracket.values)[0]] if _has_top(bracket) else []
    return np.array([*top, *(0.5 * (t[1:] + t[:-1]) if with_middles or not top else ())])


def _narrowed(bracket: Bracket, times: Array, values: Array) -> Bracket:
    """Add samples to a bracket and narrow it to the best one and its neighbours."""
    t, first = np.unique(np.concatenate([bracket.times, times]), return_index=True)
    y = np.concatenate([bracket.values, values])[first]
    best = int(np.argmax(y))
    window = slice(max(best - 1, 0), best + 2)
    return bracket._replace(times=t[window], values=y[window])


def _parabola(t: Array, y: Array) -> tuple[float, float]:
    """Vertex of the parabola through three samples, if it lies between them; else the best sample."""
    best = int(np.argmax(y))
    if len(t) < 3 or best != 1:
        return float(t[best]), float(y[best])
    top, height = parabola_top(*map(float, t), *map(float, y))
    return top, height
