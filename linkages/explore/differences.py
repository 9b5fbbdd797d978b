"""Finite differences of smooth functions."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from linkages.base.arrays import Array


def extrapolated(f: Callable[[float], Array], step: float) -> tuple[Array, Array]:
    """Differentiate f at 0 by central differences with three steps, extrapolated twice (order 6); and their error."""
    first = [(f(h) - f(-h)) / (2.0 * h) for h in (step, 0.5 * step, 0.25 * step)]
    second = [(4.0 * fine - coarse) / 3.0 for coarse, fine in pairwise(first)]
    third = (16.0 * second[1] - second[0]) / 15.0
    return third, np.abs(third - second[1])
