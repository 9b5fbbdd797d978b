"""Numbers from trajectories: extremes over continuous time, integrals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import simpson

from linkages.trajectory import Trajectory

Array = NDArray[np.float64]

#: A maximum to be refined: column, sign that makes it one, times (at most 3) around it, signed values there.
Bracket = tuple[str, float, Array, Array]

_CANDIDATES = 3  # neighbouring samples within this many of the best local extremes are refined
_POINTS = 7  # samples across a bracket in each round of refinement
_ROUNDS = (
    3  # each narrows a bracket three times: the parabola errs by (bracket/54)^4 of the fourth derivative
)


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

    The best samples are bracketed by their neighbours; each bracket is sampled anew through
    `Trajectory.evaluate`, a few times over, and ends with a parabola through the best three. Without `evaluate`
    (a loaded trajectory) the parabola alone refines the samples.
    """
    brackets: list[Bracket] = []
    for name in names:
        for sign in (1.0, -1.0):
            y = sign * trajectory[name]
            for i in _local_maxima(y):
                window = slice(max(i - 1, 0), i + 2)
                brackets.append((name, sign, trajectory.time[window], y[window]))
    best: dict[tuple[str, float], tuple[float, float]] = {}
    for (name, sign, _, _), (when, value) in zip(brackets, refine(trajectory, brackets), strict=True):
        if (name, sign) not in best or value > best[name, sign][1]:
            best[name, sign] = when, value
    result = {}
    for name in names:
        (t_max, high), (t_min, low) = best[name, 1.0], best[name, -1.0]
        result[name] = Extremes(-low, high, t_max if high >= low else t_min)
    return result


def refine(trajectory: Trajectory, brackets: list[Bracket]) -> list[tuple[float, float]]:
    """Time and value of the maximum in each bracket, over continuous time."""
    if trajectory.evaluate is not None and len(trajectory.time) > 1 and brackets:
        for _ in range(_ROUNDS):
            brackets = _zoom(trajectory, brackets)
    return [_parabola(t, y) for _, _, t, y in brackets]


def integral(trajectory: Trajectory, values: Array) -> float:
    """Integral over time of values given at the trajectory's samples."""
    return float(simpson(values, x=trajectory.time)) if len(values) > 2 else 0.0


def _local_maxima(y: Array) -> list[int]:
    """Find the largest local maxima, ends included."""
    padded = np.concatenate([[-np.inf], y, [-np.inf]])
    found = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]))
    near = found[y[found] >= y.max() - 0.01 * np.ptp(y)]
    return [int(i) for i in near[np.argsort(-y[near], kind="stable")][:_CANDIDATES]]


def _zoom(trajectory: Trajectory, brackets: list[Bracket]) -> list[Bracket]:
    """Sample every bracket again and narrow it to the neighbours of its best sample."""
    times = [np.linspace(t[0], t[-1], _POINTS) for _, _, t, _ in brackets]
    unique, inverse = np.unique(np.concatenate(times), return_inverse=True)
    columns = trajectory.evaluate(unique)  # type: ignore[misc]
    narrowed = []
    for k, (name, sign, _, _) in enumerate(brackets):
        rows = inverse[k * _POINTS : (k + 1) * _POINTS]
        y = sign * columns[name][rows]
        best = int(np.argmax(y))
        window = slice(max(best - 1, 0), best + 2)
        narrowed.append((name, sign, times[k][window], y[window]))
    return narrowed


def _parabola(t: Array, y: Array) -> tuple[float, float]:
    """Vertex of the parabola through three samples, if it lies between them; else the best sample."""
    best = int(np.argmax(y))
    if len(t) < 3 or best != 1:
        return float(t[best]), float(y[best])
    left, right = (y[1] - y[0]) / (t[1] - t[0]), (y[2] - y[1]) / (t[2] - t[1])
    curvature = (right - left) / (t[2] - t[0])
    if not curvature < 0.0:
        return float(t[1]), float(y[1])
    slope = left + curvature * (t[1] - t[0])  # at t[1]
    shift = -0.5 * slope / curvature
    return float(t[1] + shift), float(y[1] + 0.5 * slope * shift)
