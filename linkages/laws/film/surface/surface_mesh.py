"""Finite volumes on the developed surface of a bearing: faces on the edges of grooves, graded towards the thin film.

The surface is theta in [0, 2 pi) (positive in the sense of rotation) times zeta = z/R in [-L/D, L/D], or its half
[0, L/D] where everything is symmetric. Lengths of the film are in units of the radial clearance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.kernel import Array
from linkages.laws.film.surface.grooves import Groove, check_areas

#: Gauss points of a cell around, three in each half; columns of `SurfaceMesh.lines`.
NODES = 6
LINE = 3 + 2 * NODES

_ROOT = math.sqrt(0.6)
_TURN = 2.0 * math.pi
_SAMPLES = 4096  # of the density of lines
_LEAST = 3  # cells of a segment between two edges
_CROWD = 3.0  # density of lines at an edge over the even one
_REACH = 0.12  # width of that crowd [rad; share of the length]


class SurfaceMesh(NamedTuple):
    """Cells of the developed surface, n around and m along; made by the function `surface_mesh`.

    Attributes
    ----------
    slenderness : float
        Length of the bearing over its diameter, L/D [1].
    half : bool
        Whether the mesh has zeta >= 0 only.
    faces : (n + 1,) array
        theta of the faces over one turn [rad].
    ends : (m + 1,) array
        zeta of the faces.
    theta, zeta : (n,), (m,) arrays
        Centres of the cells.
    groove : (n, m) array of int
        Number of the groove that covers a cell; -1 without one.
    lines : (n, LINE) array
        Width, integrals of cos and sin, cosines and sines at the Gauss points of each line.
    """

    slenderness: float
    half: bool
    faces: Array
    ends: Array
    theta: Array
    zeta: Array
    groove: NDArray[np.int64]
    lines: Array

    @property
    def width(self) -> Array:
        """Widths of the cells around [rad], (n,)."""
        return np.diff(self.faces)

    @property
    def height(self) -> Array:
        """Lengths of the cells along, (m,)."""
        return np.diff(self.ends)

    @property
    def geometry(self) -> tuple[Array, Array, Array]:
        """Return the arrays of the kernels."""
        return self.lines, self.ends, self.zeta

    def pressures(self, grooves: Array) -> Array:
        """Pressures of the cells in grooves, of those of all grooves; -1 elsewhere, (n, m)."""
        return np.append(grooves, -1.0)[self.groove]


def surface_mesh(
    slenderness: float,
    grooves: Sequence[Groove] = (),
    eccentricity: tuple[float, float] = (0.0, 0.0),
    around: int = 240,
    along: int = 20,
    *,
    half: bool | None = None,
) -> SurfaceMesh:
    """Lay out the cells.

    Parameters
    ----------
    slenderness : float
        L/D.
    grooves : sequence of Groove
    eccentricity : (float, float)
        The film that the mesh is graded for, in units of the clearance.
    around, along : int
        Cells around, and along the half length; edges of grooves add some.
    half : bool, optional
        Whether half the length is enough. Default: where no groove is off the middle.

    Raises
    ------
    ValueError
        If L/D, the numbers of cells, or extent or length of a groove are out of range.
    """
    if not (slenderness > 0.0 and math.isfinite(slenderness)):
        raise ValueError(f"slenderness L/D {slenderness!r}: must be positive")
    if around < 8 or along < 2:
        raise ValueError(f"mesh {around} x {along}: needs at least 8 cells around and 2 along")
    check_areas(grooves)
    if half is None:
        half = all(groove.position == 0.0 for groove in grooves)
    eps, psi = min(math.hypot(*eccentricity), 0.999), math.atan2(eccentricity[1], eccentricity[0])
    partial = [groove for groove in grooves if groove.extent < _TURN * (1.0 - 1e-12)]
    sides = sorted({round(side % _TURN, 13) for groove in partial for side in groove.span})
    start = sides[0] if sides else (psi + math.pi) % _TURN
    edges = [*sides, start + _TURN] if sides else [start, start + _TURN]

    def dense(theta: Array) -> Array:
        film = 1.0 - eps * np.cos(theta - psi)
        graded = 0.5 + 0.5 * math.sqrt(1.0 - eps * eps) / film
        near = [np.exp(-np.abs(np.remainder(theta - side + math.pi, _TURN) - math.pi) / _REACH) for side in sides]
        return graded + _CROWD * sum(near, np.zeros_like(theta)) * graded

    faces, _ = _placed(edges, dense, around)
    theta = 0.5 * (faces[1:] + faces[:-1])
    shares = {-0.5, 0.5} | {share for groove in grooves for share in groove.reach}
    marks = sorted({round(share, 13) for share in shares})
    if half:
        marks = [0.0, *(mark for mark in marks if mark > 0.0)]

    def crowded(share: Array) -> Array:
        near = [np.exp(-np.abs(share - mark) / _REACH * 2.0) for mark in marks if mark != 0.0 or not half]
        return 1.0 + _CROWD * sum(near, np.zeros_like(share))

    ends, zeta = (2.0 * slenderness * places for places in _placed(marks, crowded, along if half else 2 * along))
    inner = ~np.isin(ends, 2.0 * slenderness * np.array(marks))
    ends[inner] = (0.5 * (zeta[1:] + zeta[:-1]))[inner[1:-1]]  # midway: a parabola is exact at the centres
    number = np.full((theta.size, zeta.size), -1, dtype=np.int64)
    for k, groove in enumerate(grooves):
        number[groove.covers(theta[:, None], zeta / (2.0 * slenderness))] = k
    return SurfaceMesh(slenderness, half, faces, ends, theta, zeta, number, _lines(faces))


def _lines(faces: Array) -> Array:
    """Return the numbers of each line of cells that the kernels read, see `SurfaceMesh`."""
    width, inner = np.diff(faces), np.array([-_ROOT, 0.0, _ROOT])
    places = 0.25 * np.concatenate([inner - 1.0, inner + 1.0])  # from the middle, in widths
    nodes = 0.5 * (faces[1:] + faces[:-1])[:, None] + width[:, None] * places
    return np.column_stack([width, np.diff(np.sin(faces)), -np.diff(np.cos(faces)), np.cos(nodes), np.sin(nodes)])


def _placed(edges: Sequence[float], dense: Callable[[Array], Array], count: int) -> tuple[Array, Array]:
    """Place faces on all edges and, by a density, `count` cells or a few more between them; their centres by it too."""
    fine = np.unique(np.concatenate([np.linspace(edges[0], edges[-1], _SAMPLES), edges]))
    middle = 0.5 * (fine[1:] + fine[:-1])
    total = np.concatenate(([0.0], np.cumsum(dense(middle) * np.diff(fine))))
    parts = []
    for low, high in pairwise(np.interp(edges, fine, total)):
        cells = max(_LEAST, round(count * (high - low) / total[-1]))
        parts.append(np.interp(np.linspace(low, high, 2 * cells + 1)[:-1], total, fine))
    places = np.concatenate(parts)
    return np.append(places[0::2], edges[-1]), places[1::2]
