"""Interpolation between samples by Akima's cubics (importing SciPy's takes as long as a run)."""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array
from linkages.results import numerics


def interpolated(times: Array, samples: Array, at: Array) -> Array:
    """Interpolate samples (nt, n) by Hermite cubics with slopes from secants, nearly without overshoot at jumps.

    The times (nt,) increase, at least two; the result (m, n) is at times within them. Source: Akima, A new method of
    interpolation and smooth curve fitting based on local procedures, J. ACM 17 (1970) 589-602, with modified weights
    ("makima").
    """
    if not samples.shape[1]:
        return np.zeros((len(at), 0))
    h = np.diff(times)[:, None]
    secants = np.zeros((len(times) + 3, samples.shape[1]))
    secants[2:-2] = np.diff(samples, axis=0) / h
    inner = secants[2:-2]
    secants[1] = 2.0 * inner[0] - inner[min(1, len(inner) - 1)]
    secants[0] = 2.0 * secants[1] - inner[0]
    secants[-2] = 2.0 * inner[-1] - inner[max(-2, -len(inner))]
    secants[-1] = 2.0 * secants[-2] - inner[-1]
    bends = np.abs(np.diff(secants, axis=0)) + 0.5 * np.abs(secants[1:] + secants[:-1])
    left, right = bends[2:], bends[:-2]
    total = left + right
    slopes = 0.5 * (secants[3:] + secants[:-3])
    known = total > numerics.ROUNDED * total.max(initial=0.0)
    slopes[known] = ((left * secants[1:-2] + right * secants[2:-1])[known]) / total[known]
    k = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(h) - 1)
    step = h[k]
    x = (at - times[k])[:, None] / step
    rise = samples[k + 1] - samples[k]
    c2 = 3.0 * rise - step * (2.0 * slopes[k] + slopes[k + 1])
    c3 = -2.0 * rise + step * (slopes[k] + slopes[k + 1])
    result: Array = samples[k] + x * (step * slopes[k] + x * (c2 + x * c3))
    return result
