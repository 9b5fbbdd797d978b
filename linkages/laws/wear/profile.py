"""Worn profiles: periodic cubic B-splines over the angle of a part.

A profile is given by n control depths at the angles 2 pi i/n. B-splines sum to one and are nowhere negative: a profile
has no ripples between its nodes, and wear that is spread by their values keeps its volume.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel
from linkages.laws.film.map_table import basis


@inlined_kernel
def cell_of(n: int, angle: float) -> tuple[int, float]:
    """Cell of an angle [rad] of any size, and the part of the cell that lies before it."""
    x = angle * n / (2.0 * math.pi)
    x -= n * math.floor(x / n)
    i = int(x)
    if i >= n:  # rounding
        i, x = 0, 0.0
    return i, x - i


@inlined_kernel
def depth_in(depths: Array, i: int, t: float) -> tuple[float, float]:
    """Depth [m] of a profile at the part t of cell i, and its derivative [m/rad].

    Parameters
    ----------
    depths : (n,) array
        Control depths [m]; none of a round part.
    """
    n = len(depths)
    if n == 0:
        return 0.0, 0.0
    h = i - 1 if i > 0 else n - 1
    j = i + 1 if i + 1 < n else 0
    k = j + 1 if j + 1 < n else 0
    a, b, c, d = basis(t)
    value = a * depths[h] + b * depths[i] + c * depths[j] + d * depths[k]
    r, t2 = 1.0 - t, t * t
    slope = 0.5 * (t2 * depths[k] - r * r * depths[h])
    slope += (1.5 * t2 - 2.0 * t) * depths[i] + (0.5 + t - 1.5 * t2) * depths[j]
    return value, slope * n / (2.0 * math.pi)


@inlined_kernel
def depth_at(depths: Array, angle: float) -> tuple[float, float]:
    """Depth [m] of a profile at an angle of the part's frame [rad], and its derivative [m/rad]; see `depth_in`."""
    if len(depths) == 0:
        return 0.0, 0.0
    i, t = cell_of(len(depths), angle)
    return depth_in(depths, i, t)


@inlined_kernel
def add_spread(spread: Array, i: int, t: float, amount: float) -> None:
    """Add an amount at the part t of cell i to the nodes around it, by the values of their B-splines."""
    n = len(spread)
    a, b, c, d = basis(t)
    spread[i - 1 if i > 0 else n - 1] += a * amount
    spread[i] += b * amount
    i = i + 1 if i + 1 < n else 0
    spread[i] += c * amount
    spread[i + 1 if i + 1 < n else 0] += d * amount


# Removed material is stored as s = (area per angle)/R, the depth without its square, so that volumes add exactly.


@kernel
def removed_of(depth: Array, radius: float) -> Array:
    """Give the removed area per angle over the radius [m] at a depth [m]; negative radius: of a journal.

    A bearing of radius R worn to R + w has lost R w + w^2/2 per angle, a journal R w - w^2/2.
    """
    return depth * (1.0 + 0.5 * depth / radius)


@kernel
def depth_of(removed: Array, radius: float) -> Array:
    """Inverse of `removed_of`."""
    return 2.0 * removed / (1.0 + np.sqrt(1.0 + 2.0 * removed / radius))


def volume_of(removed: Array, radius: float, length: float) -> float:
    """Add up the volume [m3] of a profile whose nodes have lost an area per angle over the radius `removed` [m].

    Parameters
    ----------
    removed : (n,) array
    radius, length : float
        Of the part [m].
    """
    return float(abs(radius) * length * 2.0 * math.pi * np.mean(removed))


def node_depths(depths: Array) -> Array:
    """Depths of a profile at its nodes [m], (n,), from its control depths."""
    return (np.roll(depths, 1) + 4.0 * depths + np.roll(depths, -1)) / 6.0
