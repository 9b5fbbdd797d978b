"""The maximum of a parabola, for the search of extremes between samples."""

from __future__ import annotations

from linkages.base.kernel import kernel


@kernel
def parabola_top(a: float, b: float, c: float, fa: float, fb: float, fc: float) -> tuple[float, float]:
    """Compute place and height of the maximum of the parabola through three ordered points; else the middle point."""
    left, right = (fb - fa) / (b - a), (fc - fb) / (c - b)
    curvature = (right - left) / (c - a)
    if not curvature < 0.0:
        return b, fb
    slope = left + curvature * (b - a)  # at b
    shift = -0.5 * slope / curvature
    return b + shift, fb + 0.5 * slope * shift
