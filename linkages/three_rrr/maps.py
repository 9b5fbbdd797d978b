"""Number of assemblies and nearness to singularities over two drive angles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.arguments import Count, validated
from linkages.arrays import Array
from linkages.three_rrr.direct import candidates, distinct
from linkages.three_rrr.geometry import Geometry
from linkages.three_rrr.kinematics import determinants

_BATCH = 4096


@dataclass(frozen=True)
class DriveMap:
    """Values over phi_1 (columns) and phi_2 (rows) at one phi_3."""

    angles: Array  # (n,) grid of both angles [rad]
    phi3: float
    count: NDArray[np.int64]  # (n, n) number of assemblies
    # (n, n) least |det Jx| (dimensionless, see `kinematics.determinants`) over the assemblies: zero at a
    # type-2 singularity; NaN without an assembly
    fold: Array
    reach: Array  # (n, n) least |sine| between crank and coupler over assemblies and legs: zero at a type-1 singularity


@validated
def drive_map(
    geometry: Geometry, phi3: float, points: Count = 121, progress: Callable[[float], None] | None = None
) -> DriveMap:
    """Solve the direct kinematics on a grid of `points` by `points` drive angles over a full turn of each."""
    angles = np.linspace(-np.pi, np.pi, points)
    first, second = np.meshgrid(angles, angles)
    phi = np.column_stack([first.ravel(), second.ravel(), np.full(first.size, phi3)])
    number = np.zeros(len(phi), dtype=np.int64)
    fold, reach = np.full((2, len(phi)), np.nan)
    for start in range(0, len(phi), _BATCH):
        part = slice(start, start + _BATCH)
        x = candidates(geometry, phi[part])
        found = np.isfinite(x[..., 0])
        where, _ = np.nonzero(found)
        two, one = determinants(geometry, phi[part][where], x[found])
        np.fmin.at(fold[part], where, np.abs(two))
        np.fmin.at(reach[part], where, np.min(np.abs(one), axis=1))
        number[part] = np.count_nonzero(distinct(x, geometry.size), axis=1)
        if progress is not None:
            progress(min(start + _BATCH, len(phi)) / len(phi))
    shape = first.shape
    return DriveMap(angles, phi3, number.reshape(shape), fold.reshape(shape), reach.reshape(shape))
