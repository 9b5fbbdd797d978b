"""Filters of measured and computed samples."""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, sosfiltfilt

from linkages.base.arrays import Array
from optim.identify.numerics import FILTERS_UNEVEN
from optim.identify.schema import Filter


def sections_of(chosen: Filter, times: Array) -> Array:
    """Return the second-order sections of a filter; ValueError, in one sentence, if the times do not suit it."""
    steps = np.diff(times)
    if np.abs(steps - steps.mean()).max() > FILTERS_UNEVEN * steps.mean():
        raise ValueError("a filter needs equal intervals between the samples")
    rate = 1.0 / steps.mean()
    if chosen.cutoff >= 0.5 * rate:
        raise ValueError(
            f"filter.cutoff, {chosen.cutoff:g} Hz, must be below half the sampling rate, {0.5 * rate:g} Hz"
        )
    if chosen.cutoff < 1.0 / float(np.ptp(times)):
        raise ValueError(
            f"filter.cutoff, {chosen.cutoff:g} Hz, must be at least {1.0 / float(np.ptp(times)):.3g} Hz, one period in"
            " the time of the samples"
        )
    return np.asarray(butter(chosen.order, chosen.cutoff, fs=rate, output="sos"), np.float64)


def filtered(rows: Array, sections: Array | None) -> Array:
    """Filter samples (n, ...) forwards and backwards."""
    if sections is None:
        return rows
    most = 3 * (2 * len(sections) + 1)
    return np.asarray(sosfiltfilt(sections, rows, axis=0, padlen=min(most, len(rows) - 1)), np.float64)
