"""Derivatives of statistics of outputs over windows of a run: extremes, means, integrals, last values.

The derivative of an extreme is the derivative of its output at the time of the extreme (envelope theorem): the output
is stationary there, so that the change of the time does not matter. At a kink it is not: there two curves cross, whose
derivatives at a fixed time, weighted by each other's slopes over time, give the derivative of their crossing.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.results import numerics
from linkages.results.extremes import Extremes, averages, extremes, integral
from linkages.results.outputs.columns import Columns
from linkages.results.trajectory import Trajectory

_SHARES_OF_STEP = 0.5, 0.1, 0.01  # distances of the values whose differences give the time of an extreme
_SLOPE, _BEND = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0, np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / 12.0
_SIDES = np.array([-2.0, -1.0, 1.0, 2.0])  # times at which both sides of a kink are differentiated, in the same unit
_CLOSE, _LEAST = 1e-4, 1e-9  # distance from an extreme at which it is tested for a jump: in steps, and in windows
#: Peak: largest magnitude; range: maximum less minimum; fluctuation: range over the magnitude of the mean.
_EXTREMES = ("minimum", "maximum", "peak", "range", "fluctuation")


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
    quadrature: Array | None = None  # (np,), error of the rates of a mean, integral or root mean square, if asked for
    jump: bool = False  # whether an extreme is at a jump, whose time changes with the values: the rates omit that


def differentiate_statistics(run: Trajectory, wanted: Sequence[Wanted], errors: bool = False) -> list[Found]:
    """Compute statistics of a run with their derivatives.

    Parameters
    ----------
    run : Trajectory
        With `Trajectory.sensitivity` of the outputs.
    wanted : sequence of Wanted
        The same outputs give the same numbers, bit for bit; other outputs move the times at which states are evaluated.
    errors : bool
        Whether to compute `Found.quadrature`.

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
    rates = _rates(run, places) if places else {}
    jumping = dict(zip(places, at_jumps(run, places).tolist(), strict=True)) if places else {}
    found = []
    for output, statistic, start, end in wanted:
        if statistic not in _EXTREMES:
            found.append(parts[start, end].average(output, statistic, errors))
            continue
        top = tops[output, start, end]
        low, high = (rates[(output, start, end), time] for time in (top.time_min, top.time_max))
        least, most = (jumping[(output, start, end), time] for time in (top.time_min, top.time_max))
        sign = 1.0 if top.max >= -top.min else -1.0
        each = {
            "minimum": Found(top.min, low, top.time_min, jump=least),
            "maximum": Found(top.max, high, top.time_max, jump=most),
            "peak": Found(top.peak, high if sign > 0.0 else -low, top.time, sign, jump=most if sign > 0.0 else least),
            "range": Found(top.max - top.min, high - low, top.time, jump=least or most),
        }
        if statistic == "fluctuation":
            mean = parts[start, end].average(output, "mean", errors)
            number, size = (top.max - top.min) / abs(mean.number), abs(mean.number)
            rates_of = (high - low) / size - number / mean.number * mean.rates
            each[statistic] = Found(number, rates_of, top.time, jump=least or most)
        found.append(each[statistic])
    return found


_Place = tuple[tuple[str, float, float], float]  # output, start and end of a window; time of an extreme


def _rates(run: Trajectory, places: Sequence[_Place]) -> dict[_Place, Array]:
    """Differentiate extremes: (np,) each."""
    times, _, _, longest = _surroundings(run, places)
    weights = kink_weights(run, places)
    smooth = np.isnan(weights[:, 0])
    asked = times[:, None] + numerics.STATISTIC_DERIVATIVES_BESIDE * longest[:, None] * np.where(
        smooth[:, None], 0.0, _SIDES
    )
    asked[smooth] = _stationary(run, places)[smooth, None]
    weights[smooth] = [1.0, 0.0, 0.0, 0.0]
    slopes = list(run.sensitivity.evaluate(asked.ravel()).values())
    found = {}
    for k, place in enumerate(places):
        each = np.array([column[place[0][0]].reshape(asked.shape)[k] for column in slopes])
        found[place] = each[:, 0] if smooth[k] else each @ weights[k]
    return found


def kink_weights(run: Trajectory, places: Sequence[_Place]) -> Array:
    """Weights (n, 4) of the derivatives at `_SIDES` that give the derivatives of extremes at kinks; NaN at others.

    At a kink the slopes over time of both sides differ as much near it as ten times farther away, and their lines cross
    between the near times; at a jump they do not.
    """
    assert run.evaluate is not None
    times, _, _, longest = _surroundings(run, places)
    asked = times + numerics.STATISTIC_DERIVATIVES_BESIDE * longest * np.concatenate([_SIDES, 10.0 * _SIDES])[:, None]
    columns = run.evaluate(asked.ravel())
    values = np.array([columns[name].reshape(asked.shape)[:, k] for k, ((name, _, _), _) in enumerate(places)])
    before, after, far_before, far_after = (values[:, 1::2] - values[:, ::2]).T / [[1.0], [1.0], [10.0], [10.0]]
    bend, far = (
        after - before,
        far_after - far_before,
    )  # changes over `numerics.STATISTIC_DERIVATIVES_BESIDE`, as all slopes here
    kink = (before * after < 0.0) & (np.abs(bend) > numerics.STATISTIC_DERIVATIVES_VISIBLE * np.abs(values).max(axis=1))
    kink &= np.abs(bend) > 0.5 * np.abs(far)
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = (
            values[:, 1] + before - values[:, 2] + after
        ) / bend  # of both lines, in parts of `numerics.STATISTIC_DERIVATIVES_BESIDE`
        before, after = before + (before - far_before) / 9.0, after + (after - far_after) / 9.0  # at the kink
        left, right = after / (after - before), before / (before - after)
    kink &= np.abs(cross) <= 1.0
    sides = [-(1.0 + cross) * left, (2.0 + cross) * left, (2.0 - cross) * right, -(1.0 - cross) * right]
    return np.where(kink[:, None], np.column_stack(sides), np.nan)


def at_jumps(run: Trajectory, places: Sequence[_Place]) -> NDArray[np.bool_]:
    """Whether extremes are at jumps of their outputs (n,): other values on both sides, or steep beside, and no kink.

    Not at the ends of their windows, and not where a sampled controller acts: these times do not change with values.
    """
    assert run.evaluate is not None
    times, first, last, _ = _surroundings(run, places)
    k = np.clip(np.searchsorted(run.time, times), 1, len(run.time) - 1)
    steps = run.time[k] - run.time[k - 1]
    near = np.maximum(_CLOSE * steps, _LEAST * (last - first))  # steps at the start of a contact are tiny
    asked = np.clip(times + near * np.array([-2.0, -1.0, 1.0, 2.0])[:, None], run.time[0], run.time[-1])
    columns = run.evaluate(asked.ravel())
    values = np.array([columns[name].reshape(asked.shape)[:, j] for j, ((name, _, _), _) in enumerate(places)])
    ranges = np.array([np.ptp(run[name]) or 1.0 for (name, _, _), _ in places])
    apart = np.abs(values[:, 2] - values[:, 1]) > numerics.STATISTIC_DERIVATIVES_STEEP * ranges
    steep = (
        np.abs(values[:, 1::2] - values[:, ::2]).max(axis=1)
        > numerics.STATISTIC_DERIVATIVES_STEEP * ranges * near / steps
    )
    fixed = (times <= first) | (times >= last) | np.isclose(times[:, None], run.jumps, rtol=1e-9, atol=0.0).any(axis=1)
    return np.asarray((apart | steep & np.isnan(kink_weights(run, places)[:, 0])) & ~fixed)


def _surroundings(run: Trajectory, places: Sequence[_Place]) -> tuple[Array, Array, Array, Array]:
    """Return times of extremes, ends of their windows, and the lengths around them to look at [s], (n,) each."""
    times = np.array([time for _, time in places])
    first, last = np.clip(np.array([key[1:] for key, _ in places]).T, run.time[0], run.time[-1])
    after = np.clip(np.searchsorted(run.time, times), 1, len(run.time) - 1)
    longest = np.minimum(run.time[after] - run.time[after - 1], 0.5 * np.minimum(times - first, last - times))
    return times, first, last, longest


def _stationary(run: Trajectory, places: Sequence[_Place]) -> Array:
    """Return the times of extremes, refined: the value of an extreme hardly depends on its time, its derivative does.

    Newton's method with differences of fourth order of five values, ever closer to each other as long as they show the
    bend. Extremes at the ends of windows stay there.
    """
    assert run.evaluate is not None
    times, first, last, longest = _surroundings(run, places)
    for share in _SHARES_OF_STEP:
        h = share * longest
        asked = times + h * np.arange(-2.0, 3.0)[:, None]
        columns = run.evaluate(asked.ravel())
        values = np.array([columns[name].reshape(asked.shape)[:, k] for k, ((name, _, _), _) in enumerate(places)])
        slope, bend = values @ _SLOPE, values @ _BEND
        visible = np.abs(bend) > numerics.STATISTIC_DERIVATIVES_VISIBLE * np.abs(values).max(axis=1)
        shift = -slope / np.where(visible, bend, np.inf)
        times = np.clip(times + np.clip(shift, -1.0, 1.0) * h, first, last)
    return times


_Rule = tuple[Array, Columns, list[Columns]]  # weights (steps, points), columns, and their derivatives by each value


class _Part:
    """A run between two times, with its sensitivities, also within its steps."""

    def __init__(self, run: Trajectory, start: float, end: float) -> None:
        end = min(end, float(run.time[-1]))
        self.run = run.within(start, end) if start > run.time[0] or end < run.time[-1] else run

    def average(self, output: str, statistic: str, errors: bool) -> Found:
        """Compute the mean, integral, root mean square or last value of an output, and its derivatives."""
        run, span = self.run, float(np.ptp(self.run.time))
        if statistic == "last":
            return Found(float(run[output][-1]), np.array([rates[output][-1] for rates in run.sensitivity.values()]))
        mean, rms = averages(run, output)
        number, unit = {
            "mean": (mean, 1.0 / span),
            "rms": (rms, 1.0 / (span * rms) if rms > 0.0 else np.nan),
            "integral": (integral(run, output), 1.0),
        }[statistic]
        each = unit * self._changes(self._gauss, output, statistic == "rms")
        found = Found(number, each.sum(axis=1))
        if not errors:
            return found
        error = each - unit * self._changes(self._finer, output, statistic == "rms")
        return found._replace(quadrature=np.linalg.norm(error, axis=1))

    def _changes(self, rule: _Rule, output: str, squared: bool) -> Array:
        """Change of the integral of an output, or of half its square, over each step by each value (np, steps)."""
        weights, columns, found = rule
        rates = np.array([one[output] for one in found]).reshape(len(found), *weights.shape)
        squares = columns[output].reshape(weights.shape) if squared else 1.0
        return np.asarray((weights * rates * squares).sum(axis=2))

    @cached_property
    def _gauss(self) -> _Rule:
        return self._quadrature(numerics.STATISTIC_DERIVATIVES_POINTS)

    @cached_property
    def _finer(self) -> _Rule:
        return self._quadrature(numerics.STATISTIC_DERIVATIVES_POINTS + 1)

    def _quadrature(self, points: int) -> _Rule:
        """Gauss's quadrature with a number of points within each step.

        The derivatives of forces jump at the ends of steps: quadrature from the ends does not converge.
        """
        assert self.run.evaluate is not None
        roots, shares = np.polynomial.legendre.leggauss(points)
        times, steps = self.run.time[:-1, None], np.diff(self.run.time)[:, None]
        inner = (times + steps * 0.5 * (1.0 + roots)).ravel()
        return 0.5 * steps * shares, self.run.evaluate(inner), list(self.run.sensitivity.evaluate(inner).values())
