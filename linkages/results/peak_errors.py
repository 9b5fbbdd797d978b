"""Errors of peaks from a run at a tighter tolerance.

The change of a peak alone is not sufficient: if the errors of both runs happen to agree, the change is small although
both are wrong. Therefore other maxima of the same column are compared as well.

| where                      | error of a peak                                                                       |
|----------------------------|---------------------------------------------------------------------------------------|
| the two runs stay together | `SAFETY` times the largest change among the peak and up to eight other maxima of its  |
|                            | column that are at least half as high; of heights over continuous time and of values  |
|                            | at equal times, or equally far from both maxima if errors shift them by about a step  |
| they part (chaos)          | the same before they part, but at least the largest difference of the two columns     |
|                            | while they are apart. If this exceeds `FELT` of the peak there is no error: the peak  |
|                            | is a lower bound, since a larger one may follow in an equally accurate run            |
| a film has a history       | instead of other maxima, which are the steps of cells that fill: the root of the mean |
|                            | square of the difference while the column exceeds half of its peak                    |
| everywhere                 | at least `RESOLVED` times the largest peak of its quantity, and the rounding of the   |
|                            | column (`noise`)                                                                      |
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from linkages.base.arrays import Array
from linkages.results import numerics
from linkages.results.extremes import Bracket, refine, vertex
from linkages.results.outputs.registry import unit
from linkages.results.trajectory import Trajectory
from linkages.system import System

#: Safety factor on changes, because the tighter run has errors too.
SAFETY = 1.5
#: Difference of diverged runs over a peak beyond which the peak has no error estimate.
FELT = 0.1
#: Accuracy of `linkages.results.extremes` over the largest peak of a quantity.
RESOLVED = 1e-9

#: Rounding of an output over its natural magnitude: some thousand units in the last place.
ROUNDING = 1e-12

#: Peaks, or their errors, by key; None if meaningless or not known.
Peaks = Mapping[str, float | None]
Span = tuple[float, float]


def errors(
    run: Trajectory,
    tighter: Trajectory,
    peaks: Peaks,
    finer: Peaks,
    parted: Span | None,
    noise: Mapping[str, float],
    jagged: bool = False,
) -> dict[str, float | None]:
    """Estimate the errors of the peaks of a run or a part of it, by key, in the peak's unit; None: no estimate.

    `run` (with dense output) and `tighter` are over the same time; `peaks` and `finer` are their peaks, see
    `linkages.results.shape.peaks_by_key`; `parted` has the times of divergence and of convergence [s], see
    `linkages.results.divergence.apart`; `noise` has the rounding of each column. Columns are `jagged` where a film has
    a history: its force jumps where a cell fills, and the jumps of two meshes have other places.
    """
    start, end = (float(tighter.time[k]) for k in (0, -1))
    if parted is None or parted[0] >= end or parted[1] <= start:
        parted = None
    names = {key: key.removesuffix(".peak") for key in peaks}
    given = {key: name for key, name in names.items() if peaks[key] is not None and finer.get(key) is not None}
    compared = _jagged_changes if jagged else _changes
    changes = compared(run, tighter, set(given.values()), end if parted is None else parted[0])
    differences = {} if parted is None else _differences(run, tighter, parted)
    scales = largest_of_quantities(peaks)
    result: dict[str, float | None] = dict.fromkeys(peaks)
    for key, name in given.items():
        peak, other = peaks[key], finer[key]
        assert peak is not None
        assert other is not None
        apart = float(differences.get(name, 0.0))
        if apart <= FELT * peak:
            change = max(changes[name], 0.0 if parted is not None else abs(peak - other))
            result[key] = max(SAFETY * change, apart, RESOLVED * scales[quantity(key)], noise[name])
    return result


def quantity(key: str) -> str:
    """Return the quantity of a peak's key: ``force`` of ``A.force.peak``."""
    return key.split(".")[-2]


def largest_of_quantities(peaks: Peaks) -> dict[str, float]:
    """Find the largest peak of each quantity, by its name."""
    largest: dict[str, float] = {}
    for key, peak in peaks.items():
        largest[quantity(key)] = max(largest.get(quantity(key), 0.0), peak or 0.0)
    return largest


def _jagged_changes(run: Trajectory, tighter: Trajectory, names: set[str], until: float) -> dict[str, float]:
    """Compute the rms difference of columns, up to a time [s], while they exceed a part of their peaks."""
    steps = np.flatnonzero(tighter.time <= until)
    steps = steps[:: 1 + len(steps) // numerics.COMPARED]
    result = dict.fromkeys(names, 0.0)
    if not run.evaluate or len(steps) < 2:
        return result
    times = tighter.time[steps]
    exact, weights = run.evaluate(times), np.gradient(times)
    for name in names:
        here, there = np.abs(exact[name]), np.abs(tighter[name][steps])
        either = np.maximum(here, there)
        high = either >= numerics.PEAK_ERRORS_HIGH * either.max()
        result[name] = float(np.sqrt(np.average((here - there)[high] ** 2, weights=weights[high])))
    return result


def _changes(run: Trajectory, tighter: Trajectory, names: set[str], until: float) -> dict[str, float]:
    """Compare the highest maxima of columns up to a time [s]: the largest change of each column."""
    windows = [(name, w) for name in names for w in _maxima(np.abs(tighter[name]), tighter.time, until)]
    steps = np.array(sorted({k for _, window in windows for k in range(window.start, window.stop)}), int)
    result = dict.fromkeys(names, 0.0)
    if not run.evaluate or not len(steps):
        return result
    exact = run.evaluate(tighter.time[steps])
    here, there = [], []
    for name, window in windows:
        inside = np.searchsorted(steps, np.arange(window.start, window.stop))
        values = tighter[name][window]
        sign = float(np.sign(values[np.abs(values).argmax()]))
        here.append(Bracket(name, sign, tighter.time[window], sign * exact[name][inside]))
        there.append(Bracket(name, sign, tighter.time[window], sign * values))
    # parabolas through samples at equal times have equal errors: only shifted maxima are refined
    tops, summits = ([vertex(bracket.times, bracket.values) for bracket in brackets] for brackets in (here, there))
    shifted = [k for k, one in enumerate(here) if _is_shifted(one, tops[k][0] - summits[k][0])]
    refined = refine(run, [_uphill(run, here[k]) for k in shifted]), refine(tighter, [there[k] for k in shifted])
    for k, top, summit in zip(shifted, *refined, strict=True):
        tops[k], summits[k] = top, summit
    for one, other, top, summit in zip(here, there, tops, summits, strict=True):
        result[one.name] = max(result[one.name], _change(run, one, other, top, summit))
    return result


def _uphill(run: Trajectory, window: Bracket) -> Bracket:
    """Bracket the maximum of the run that lies in a window or, shifted by the run's errors, close to it."""
    first, last = window.times[[0, -1]]
    reach = numerics.PEAK_ERRORS_REACH * (last - first)
    near = slice(max(np.searchsorted(run.time, first - reach) - 1, 0), np.searchsorted(run.time, last + reach) + 1)
    times, order = np.unique(np.concatenate([window.times, run.time[near]]), return_index=True)
    values = np.concatenate([window.values, window.sign * run[window.name][near]])[order]
    k = int(np.searchsorted(times, window.times[window.values.argmax()]))
    while 0 < k < len(times) - 1:
        if values[k] >= max(values[k - 1], values[k + 1]):
            return window._replace(times=times[k - 1 : k + 2], values=values[k - 1 : k + 2])
        k += 1 if values[k + 1] > values[k - 1] else -1
    return window


def _change(
    run: Trajectory, one: Bracket, other: Bracket, top: tuple[float, float], finer: tuple[float, float]
) -> float:
    """Compare a maximum of the run and of the tighter run: samples, and their tops (time, value)."""
    assert run.evaluate is not None
    shift, change = top[0] - finer[0], abs(top[1] - finer[1])
    if _is_shifted(one, shift):
        # values at equal times lie on the flanks, and parabolas through them overshoot
        values = one.sign * run.evaluate(np.clip(one.times + shift, *run.time[[0, -1]]))[one.name]
    else:
        # in a transient of few steps heights may agree by chance: parabolas contain the neighbouring values
        heights = [vertex(bracket.times, bracket.values)[1] for bracket in (one, other)]
        values, change = one.values, max(change, abs(heights[0] - heights[1]))
    return float(max(change, np.abs(values - other.values).min()))  # a shift in time alone leaves one value


def _is_shifted(window: Bracket, shift: float) -> bool:
    """Check whether maxima are too far apart [s] for a comparison at equal times."""
    return abs(shift) > numerics.PEAK_ERRORS_SHIFTED * float(np.diff(window.times).min(initial=np.inf))


def _maxima(values: Array, times: Array, until: float) -> list[slice]:
    """Find the highest local maxima up to a time [s], ends included, each as the samples around it."""
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    found = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] > padded[2:]) & (times <= until))
    found = found[values[found] >= numerics.PEAK_ERRORS_HIGH * values[found].max(initial=0.0)]
    highest = found[np.argsort(-values[found], kind="stable")][: numerics.PEAK_ERRORS_MAXIMA]
    return [slice(max(int(i) - 1, 0), min(int(i) + 2, len(values))) for i in highest]


def _differences(run: Trajectory, tighter: Trajectory, parted: Span) -> dict[str, float]:
    """Compute the largest difference of each column between diverged runs."""
    steps = np.flatnonzero((tighter.time >= parted[0]) & (tighter.time <= parted[1]))
    steps = steps[:: 1 + len(steps) // numerics.COMPARED]
    if not run.evaluate or not len(steps):
        return {}
    exact = run.evaluate(tighter.time[steps])
    names = exact.keys() & tighter.columns.keys()
    return {name: float(np.abs(exact[name] - tighter[name][steps]).max()) for name in names}


def noise(system: System, names: Iterable[str]) -> dict[str, float]:
    """Estimate the rounding of outputs, in their units.

    The natural magnitude of an output follows from its unit and from the length, mass, rate and weight of the linkage:
    length x rate^2 for an acceleration; mass x length x rate^2, or the weight, for a force. It is zero for outputs with
    another unit.
    """
    length, rate = system.tree.extent, system.motion_rate
    acceleration = length * rate**2 + float(np.linalg.norm(system.gravity))
    force = system.mass * acceleration
    scales = {
        "1": 1.0, "m": length, "rad": 1.0, "m/s": length * rate, "rad/s": rate,
        "m/s2": acceleration, "rad/s2": acceleration / length,
        "N": force, "N m": force * length, "J": force * length, "W": force * length * rate,
    }  # fmt: skip
    return {name: ROUNDING * scales.get(unit(system, name), 0.0) for name in names}
