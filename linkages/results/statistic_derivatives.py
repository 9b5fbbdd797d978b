"""Derivatives of statistics of outputs over windows of a run: extremes, means, integrals, last values.

The derivative of an extreme is the derivative of its output at the time of the extreme (envelope theorem): the output
is stationary there, so that the change of the time does not matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from linkages.arrays import Array
from linkages.results.extremes import Extremes, extremes, integral
from linkages.results.trajectory import Trajectory

_EXTREMES = ("minimum", "maximum", "peak", "range")  # peak: largest magnitude; range: maximum less minimum


class Wanted(NamedTuple):
    """A statistic of an output between two times of a run [s]."""

    output: str
    statistic: str
    start: float
    end: float


class Found(NamedTuple):
    """A statistic, its derivatives with respect to np values, and its time.

    Attributes
    ----------
    number : float
    rates : (np,) array
        NaN where there is no derivative.
    time : float
        Time of an extreme [s], of the larger one for ``peak`` and ``range``; NaN for other statistics.
    sign : float
        -1 for a peak that is a minimum, otherwise 1.
    """

    number: float
    rates: Array
    time: float = np.nan
    sign: float = 1.0


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
    parts = {window: _part(run, *window) for window in windows}
    tops: dict[tuple[str, float, float], Extremes] = {}
    for window, part in parts.items():
        names = [one.output for one in wanted if one.statistic in _EXTREMES and (one.start, one.end) == window]
        names = list(dict.fromkeys(names))
        tops |= {(name, *window): top for name, top in extremes(part, names).items()}
    times = np.unique([t for top in tops.values() for t in (top.time_min, top.time_max)])
    columns = list(run.sensitivity.evaluate(times).values()) if len(times) else []

    def at(output: str, time: float) -> Array:
        return np.array([column[output][np.searchsorted(times, time)] for column in columns])

    found = []
    for output, statistic, start, end in wanted:
        if statistic not in _EXTREMES:
            found.append(_average(parts[start, end], output, statistic))
            continue
        top = tops[output, start, end]
        low, high = at(output, top.time_min), at(output, top.time_max)
        sign = 1.0 if top.max >= -top.min else -1.0
        found.append(
            {
                "minimum": Found(top.min, low, top.time_min),
                "maximum": Found(top.max, high, top.time_max),
                "peak": Found(top.peak, high if sign > 0.0 else -low, top.time, sign),
                "range": Found(top.max - top.min, high - low, top.time),
            }[statistic]
        )
    return found


def _part(run: Trajectory, start: float, end: float) -> Trajectory:
    """Return the run between two times, with its sensitivities."""
    end = min(end, float(run.time[-1]))
    if start <= run.time[0] and end >= run.time[-1]:
        return run
    assert run.evaluate is not None
    times = np.union1d(run.time[(run.time >= start) & (run.time <= end)], [start, end])
    columns = {"time": times, **run.evaluate(times)}
    rates = replace(run.sensitivity, columns=run.sensitivity.evaluate(times))
    return Trajectory(times, columns, run.status, {}, run.evaluate, sensitivity=rates)


def _average(part: Trajectory, output: str, statistic: str) -> Found:
    """Compute the mean, integral, root mean square or last value of an output, and its derivatives."""
    span, column = float(np.ptp(part.time)), part[output]
    rates = [columns[output] for columns in part.sensitivity.values()]
    if statistic == "last":
        return Found(float(column[-1]), np.array([rate[-1] for rate in rates]))
    if statistic == "rms":
        rms = float(np.sqrt(max(integral(part, column**2) / span, 0.0)))
        slopes = [integral(part, column * rate) / (span * rms) if rms > 0.0 else np.nan for rate in rates]
        return Found(rms, np.array(slopes))
    share = 1.0 / span if statistic == "mean" else 1.0
    return Found(share * integral(part, column), np.array([share * integral(part, rate) for rate in rates]))
