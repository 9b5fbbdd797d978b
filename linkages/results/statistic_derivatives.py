"""Derivatives of statistics of outputs over windows of a run: extremes, means, integrals, last values.

The derivative of an extreme is the derivative of its output at the time of the extreme (envelope theorem): the output
is stationary there, so that the change of the time does not matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.results.extremes import Extremes, averages, extremes, integral
from linkages.results.outputs.columns import Columns
from linkages.results.trajectory import Trajectory

_ROOTS, _SHARES = np.polynomial.legendre.leggauss(3)
_ABSCISSAS, _WEIGHTS = 0.5 * (1.0 + _ROOTS), 0.5 * _SHARES  # on [0, 1]
_SHARES_OF_STEP = 0.1, 0.01, 1e-3  # distances of the values whose parabola gives the time of an extreme
_VISIBLE = 1e-9  # bend of the parabola in parts of the values, above their rounding
_EXTREMES = ("minimum", "maximum", "peak", "range")  # peak: largest magnitude; range: maximum less minimum


class Wanted(NamedTuple):
    """A statistic of an output between two times of a run [s]."""

    output: str
    statistic: str
    start: float
    end: float


class Found(NamedTuple):
    """A statistic, its derivatives with respect to np values, and its time."""

    number: float
    rates: Array  # (np,); NaN where there is no derivative
    time: float = np.nan  # of an extreme [s], of the larger one for ``peak`` and ``range``
    sign: float = 1.0  # -1 for a peak that is a minimum


def differentiate_statistics(run: Trajectory, wanted: Sequence[Wanted]) -> list[Found]:
    """Compute statistics of a run with their derivatives.

    Parameters
    ----------
    run : Trajectory
        With `Trajectory.sensitivity` of the outputs.
    wanted : sequence of Wanted
        The same outputs give the same numbers, bit for bit; other outputs move the times at which states are evaluated.

    Returns
    -------
    list of Found
        In the order of `wanted`, in units of the output (per unit of the value).

    Examples
    --------
    >>> import linkages
    >>> from linkages.results.statistic_derivatives import Wanted, differentiate_statistics
    >>> system = linkages.load(linkages.find_file("seven_bar.toml"), {"duration": 0.01})
    >>> run = linkages.simulate(system, outputs=["slider7.x"], wrt=["sdf.frames.link6_D.pose.x"])
    >>> (found,) = differentiate_statistics(run, [Wanted("slider7.x", "mean", 0.0, 0.01)])
    >>> found.rates.round(4).tolist()  # m/m
    [1.0]
    """
    windows = dict.fromkeys((one.start, one.end) for one in wanted)
    parts = {window: _Part(run, *window) for window in windows}
    tops: dict[tuple[str, float, float], Extremes] = {}
    for window, part in parts.items():
        names = {one.output: None for one in wanted if one.statistic in _EXTREMES and (one.start, one.end) == window}
        tops |= {(name, *window): top for name, top in extremes(part.run, list(names)).items()}
    places = [(key, time) for key, top in tops.items() for time in (top.time_min, top.time_max)]
    slopes = list(run.sensitivity.evaluate(_stationary(run, places)).values()) if places else []
    rates = {place: np.array([column[place[0][0]][k] for column in slopes]) for k, place in enumerate(places)}
    found = []
    for output, statistic, start, end in wanted:
        if statistic not in _EXTREMES:
            found.append(parts[start, end].average(output, statistic))
            continue
        top = tops[output, start, end]
        low, high = (rates[(output, start, end), time] for time in (top.time_min, top.time_max))
        sign = 1.0 if top.max >= -top.min else -1.0
        each = {
            "minimum": Found(top.min, low, top.time_min),
            "maximum": Found(top.max, high, top.time_max),
            "peak": Found(top.peak, high if sign > 0.0 else -low, top.time, sign),
            "range": Found(top.max - top.min, high - low, top.time),
        }
        found.append(each[statistic])
    return found


_Place = tuple[tuple[str, float, float], float]  # output, start and end of a window; time of an extreme


def _stationary(run: Trajectory, places: Sequence[_Place]) -> Array:
    """Return the times of extremes, refined: the value of an extreme hardly depends on its time, its derivative does.

    Vertices of parabolas through three values, ever closer to each other. Extremes at the ends of windows stay there.
    """
    assert run.evaluate is not None
    times = np.array([time for _, time in places])
    first, last = np.clip(np.array([key[1:] for key, _ in places]).T, run.time[0], run.time[-1])
    after = np.clip(np.searchsorted(run.time, times), 1, len(run.time) - 1)
    longest = np.minimum(run.time[after] - run.time[after - 1], np.minimum(times - first, last - times))
    for share in _SHARES_OF_STEP:
        h = share * longest
        asked = np.stack([times - h, times, times + h])
        columns = run.evaluate(asked.ravel())
        values = np.array([columns[name].reshape(asked.shape)[:, k] for k, ((name, _, _), _) in enumerate(places)])
        slope, bend = values[:, 2] - values[:, 0], values[:, 2] - 2.0 * values[:, 1] + values[:, 0]
        visible = np.abs(bend) > _VISIBLE * np.abs(values).max(axis=1)
        shift = -0.5 * slope / np.where(visible, bend, np.inf)
        times = np.clip(times + np.clip(shift, -1.0, 1.0) * h, first, last)
    return times


class _Part:
    """A run between two times, with its sensitivities, also within its steps."""

    def __init__(self, run: Trajectory, start: float, end: float) -> None:
        end = min(end, float(run.time[-1]))
        self.run = run.within(start, end) if start > run.time[0] or end < run.time[-1] else run

    @cached_property
    def _within(self) -> tuple[Array, Columns, list[Columns]]:
        """Weights, columns and their derivatives of Gauss's quadrature within the steps.

        The derivatives of forces jump at the ends of steps: quadrature from the ends does not converge.
        """
        assert self.run.evaluate is not None
        times, steps = self.run.time, np.diff(self.run.time)[:, None]
        inner = (times[:-1, None] + steps * _ABSCISSAS).ravel()
        rates = self.run.sensitivity.evaluate(inner)
        return (steps * _WEIGHTS).ravel(), self.run.evaluate(inner), list(rates.values())

    def average(self, output: str, statistic: str) -> Found:
        """Compute the mean, integral, root mean square or last value of an output, and its derivatives."""
        run, span = self.run, float(np.ptp(self.run.time))
        if statistic == "last":
            return Found(float(run[output][-1]), np.array([rates[output][-1] for rates in run.sensitivity.values()]))
        weights, columns, found = self._within
        rates = np.array([one[output] for one in found])
        mean, rms = averages(run, output)
        if statistic == "rms":
            slopes = rates @ (weights * columns[output]) / (span * rms) if rms > 0.0 else np.full(len(rates), np.nan)
            return Found(rms, slopes)
        if statistic == "mean":
            return Found(mean, rates @ weights / span)
        return Found(integral(run, run[output]), rates @ weights)
