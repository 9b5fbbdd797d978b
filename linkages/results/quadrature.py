"""Samples of a column for its mean and integral: also at both sides of jumps, and within steps of a short force."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from linkages.mechanics.integrate import peak_search
from linkages.results.trajectory import Trajectory


def with_middles(trajectory: Trajectory, name: str) -> tuple[Array, Array]:
    """Return times and values of a column, with middles of intervals where the samples are too few.

    Without a function that evaluates the run, as when it is loaded from a file, the samples must do.
    """
    time, values = _with_sides(trajectory, name)
    if not trajectory.evaluate or trajectory.accuracy is None or not len(time):
        return time, values
    marks = np.zeros(len(time) - 1, dtype=np.int64)
    if not peak_search.doubtful(time, values, trajectory.accuracy, marks):
        return time, values
    middles, places = np.full(len(marks), np.nan), np.flatnonzero(marks)
    middles[places] = trajectory.evaluate(0.5 * (time[places] + time[places + 1]))[name]
    more, found = np.empty((2, 4 * len(time)))
    count = peak_search.add_middles(time, values, marks, middles, more, found)
    return more[:count], found[:count]


def _with_sides(trajectory: Trajectory, name: str) -> tuple[Array, Array]:
    """Return times and values of a column, with those just before its jumps, which have the times of the jumps."""
    time, values = trajectory.time, trajectory[name]
    places = np.searchsorted(time / peak_search.BEFORE, trajectory.jumps)
    places = places[(places > 0) & (places < len(time))]
    if not trajectory.evaluate or not len(places):
        return time, values
    before = trajectory.evaluate(peak_search.BEFORE * time[places])[name]
    return np.insert(time, places, time[places]), np.insert(values, places, before)
