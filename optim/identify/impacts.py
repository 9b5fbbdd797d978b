"""Times and peaks of first impacts as residuals: they lead from a distant start to where samples can be compared."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from linkages.base.arrays import Array
from optim.identify.load import Channel
from optim.identify.residuals import Residuals

_HEIGHT = 0.2  # least prominence of an impact, relative to the range of its column
_CERTAIN = 6.0  # the same, in deviations of a sample
_PEAK = 0.1  # deviation of a peak, relative: few samples show an impact
_TIME = 0.5  # deviation of its time, in intervals of samples
_BEYOND = 1.5  # end of the run, relative to the time of the last of these impacts


class Impacts(Residuals):
    """Residuals of the times and peaks of the first impacts in each column, instead of its samples."""

    def __init__(self, residuals: Residuals, most: int) -> None:
        self.__dict__.update(residuals.__dict__)
        self.most = most

    @property
    def linear(self) -> NDArray[np.bool_]:
        """No value: another factor moves other samples above the height of an impact."""
        return np.zeros(len(self.start), bool)

    def horizon(self, last: float) -> float:
        """Return the end of a run [s] that should show these impacts; the first sample's time if there are none."""
        first, ends = self.span()[0], [self.span()[0]]
        for m, one in enumerate(self.task.measurements):
            for c, channel in enumerate(one.channels):
                part = self.used(channel, last)
                at = _peaks(channel.values[part], self._height(channel, part, self.deviations[m][c]))[: self.most]
                ends += channel.times[at].tolist()
        return min(first + _BEYOND * (max(ends) - first), last)

    def _height(self, channel: Channel, part: slice, deviation: float) -> float:
        return max(_HEIGHT * float(np.ptp(channel.values[part])), _CERTAIN * deviation)

    def compared(
        self, channel: Channel, part: slice, left: Array, lines: Array, deviation: float
    ) -> tuple[Array, Array]:
        """Compare the first impacts; one that the run lacks has the run's end as time, and no peak."""
        measured, height = channel.filtered(channel.raw[part]), self._height(channel, part, deviation)
        computed = measured - left
        wanted, found = (_peaks(values, height)[: self.most] for values in (measured, computed))
        residual, rows = np.zeros((2, len(wanted))), np.zeros((2, len(wanted), lines.shape[1]))
        for k, i in enumerate(wanted):
            time, peak, _, _ = _parabola(measured, i)
            at, top, size = float(len(measured)), 0.0, max(_PEAK * abs(peak), deviation)
            if k < len(found):
                at, top, slope_at, slope_top = _parabola(computed, found[k])
                near = lines[found[k] - 1 : found[k] + 2]
                rows[:, k] = -(slope_at @ near) / _TIME, -(slope_top @ near) / size
            residual[:, k] = (time - at) / _TIME, (peak - top) / size
        return residual.ravel(), rows.reshape(-1, lines.shape[1])


def _peaks(values: Array, height: float) -> NDArray[np.intp]:
    """Return the samples at peaks of either sign that rise by a height above their surroundings."""
    return np.asarray(find_peaks(np.abs(values - np.median(values)), prominence=height)[0])


def _parabola(values: Array, i: int) -> tuple[float, float, Array, Array]:
    """Return place, in samples, and value of the peak of the parabola about sample i, and their derivatives (3,)."""
    before, middle, after = values[i - 1 : i + 2]
    bend, rise = before - 2.0 * middle + after, np.array([-0.5, 0.0, 0.5])
    if bend == 0.0:  # the middle of a plateau, as of a sensor at its limit
        return float(i), float(middle), np.zeros(3), np.array([0.0, 1.0, 0.0])
    ratio = 0.5 * (after - before) / bend
    curve = np.array([1.0, -2.0, 1.0])
    place, peak = i - ratio, middle - 0.5 * ratio**2 * bend
    slope = (ratio * curve - rise) / bend
    return float(place), float(peak), slope, np.array([0.0, 1.0, 0.0]) - ratio * rise + 0.5 * ratio**2 * curve
