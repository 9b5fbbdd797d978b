"""The table of a film map: one mechanism for all films that are given by a map, evaluated by splines.

With the cavity, the ends and the grooves at ambient pressure a film is homogeneous in the motion: at one geometry its
force depends, but for a factor, on eps, on the direction of (deps, ew) and on the angle alpha from the first groove to
the eccentricity. A table holds

    f_n/|f_long|, f_t/|f_long|, extent*sqrt(1 - eps^2), flow/speed,  speed^2 = deps^2 + sqrt(1 - eps^2)*(ew/2)^2,

|f_long| the force of `linkages.laws.film.closed_form.half_film_long` in the same state and `flow` what leaves at the
ends, on a uniform grid of

    x = ln((1 + eps/STRETCH)/(1 - eps)),  y = atan2((1 - eps^2)^(1/4)*ew/2, deps) in [0, 2 pi),  alpha in [0, 2 pi),

interpolated by cubic splines, periodic in y and alpha: away from rest the force is twice continuously differentiable. A
film that does not depend on alpha has one node there. A supply pressure adds a static part in proportion to it: force
and flow over x and alpha.

The layout: the numbers of `MapHead`, then by quantity and x a row of coefficients over y and alpha; the coefficients of
a static part end the row. An evaluation reads only the quantities that are wanted. **A map is never extrapolated**: eps
is clipped to `table_limit(table)`; where a run exceeds it the caller should report that. `linkages.laws.film.film_map`
solves the films at the nodes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.dual import number
from linkages.laws.film.closed_form import half_film_long

#: Quantities of a node: normal and tangential force, extent (not of the static part), flow.
CHANNELS = 4
FORCE_N, FORCE_T, EXTENT, FLOW = range(CHANNELS)
#: Eccentricity ratio up to which the nodes are about evenly spaced.
STRETCH = 0.2

_SMOOTH = 1e-3  # width of the smooth positive part of the power, in parts of |f_long| times the motion


class MapHead(NamedTuple):
    """Numbers that a table begins with."""

    identity: float  # stands for all inputs of the map
    slenderness: float  # L/D
    reach: float  # largest x
    nx: int  # nodes
    ny: int
    na: int
    grooved: bool  # whether the film has a groove; its extent is then that of the whole film, weighted by the content
    supplied: bool  # whether it has a static part
    row: int  # coefficients of a quantity at one x


#: Numbers before the coefficients.
HEAD = len(MapHead._fields)


@inlined_kernel
def head_of(table: Array) -> MapHead:
    """Read the numbers that a table begins with; no groove and no static part where there is no map."""
    if len(table) <= HEAD:
        return MapHead(0.0, 0.0, 0.0, 0, 0, 0, False, False, 0)
    nx, ny, na = int(table[3]), int(table[4]), int(table[5])
    identity, slenderness, reach = number(table[0]), number(table[1]), number(table[2])  # constants of the splines
    return MapHead(identity, slenderness, reach, nx, ny, na, table[6] > 0.0, table[7] > 0.0, int(table[8]))


def place(eps: float | Array) -> float | Array:
    """Coordinate x of an eccentricity ratio."""
    return np.log1p(np.asarray(eps) / STRETCH) - np.log1p(-np.asarray(eps))


def ratios(head: MapHead) -> Array:
    """Eccentricity ratios of a map's nodes."""
    growth = np.exp(np.linspace(0.0, head.reach, head.nx))
    return np.asarray((growth - 1.0) / (growth + 1.0 / STRETCH))


@kernel
def table_limit(table: Array) -> float:
    """Largest eccentricity ratio that this map covers."""
    growth = math.exp(head_of(table).reach)
    return (growth - 1.0) / (growth + 1.0 / STRETCH)


@kernel
def is_grooved(table: Array) -> bool:
    """Whether the film has a groove."""
    return head_of(table).grooved


@inlined_kernel
def basis(s: float) -> tuple[float, float, float, float]:
    """Cubic B-splines on a uniform grid, at s in [0, 1] of an interval."""
    r = 1.0 - s
    b1, b2 = 4.0 - 6.0 * s * s + 3.0 * s * s * s, 4.0 - 6.0 * r * r + 3.0 * r * r * r
    return r * r * r / 6.0, b1 / 6.0, b2 / 6.0, s * s * s / 6.0


@inlined_kernel
def _interval(place: float, last: int) -> tuple[int, float]:
    """Interval of a uniform grid and the place in it."""
    i = min(int(place), last)
    return i, place - i


@inlined_kernel
def _around(angle: float, nodes: int) -> tuple[int, float]:
    """Interval of a periodic grid and the place in it."""
    part = angle / (2.0 * math.pi)
    return _interval((part - math.floor(part)) * nodes, nodes - 1)


@inlined_kernel
def _plane(table: Array, at: int, row: int, s: float, t: float) -> float:
    """Interpolate over four rows from `at`, and four neighbours in each; the four sums run over these."""
    b, c, d, e = 0.0, 0.0, 0.0, 0.0
    for weight in basis(s):
        b += weight * table[at]
        c += weight * table[at + 1]
        d += weight * table[at + 2]
        e += weight * table[at + 3]
        at += row
    b0, b1, b2, b3 = basis(t)
    return b0 * b + b1 * c + b2 * d + b3 * e


@inlined_kernel
def _start(head: MapHead, x: float, which: int) -> tuple[int, float]:
    """Return the place in the table where a quantity's interval in x begins, and the place in the interval."""
    i, s = _interval(x * ((head.nx - 1) / head.reach), head.nx - 2)
    return HEAD + head.row * (which * (head.nx + 2) + i), s


@inlined_kernel
def _quantity(table: Array, x: float, y: float, alpha: float, which: int) -> float:
    """Interpolate a quantity of the nodes."""
    head = head_of(table)
    at, s = _start(head, x, which)
    j, t = _around(y, head.ny)
    if head.na == 1:
        return _plane(table, at + j, head.row, s, t)
    k, r = _around(alpha, head.na)
    line, total = head.na + 3, 0.0
    at += line * j + k
    for weight in basis(t):
        total += weight * _plane(table, at, head.row, s, r)
        at += line
    return total


@inlined_kernel
def _static(table: Array, x: float, alpha: float, which: int) -> float:
    """Interpolate a quantity of the static part."""
    head = head_of(table)
    at, s = _start(head, x, which)
    k, r = _around(alpha, head.na)
    return _plane(table, at + head.row - (head.na + 3) + k, head.row, s, r)


@lazy_kernel
def mapped_film(
    eps: float, deps: float, ew: float, alpha: float, table: Array, sheared: bool
) -> tuple[float, float, float]:
    """Evaluate a film from its map (`linkages.laws.film.film_map.load_map`), see `linkages.laws.film.films.film_force`.

    alpha is the angle from the first groove to the eccentricity [rad]; eps is clipped to `table_limit(table)`; the
    extent is 0 if not `sheared`.

    Where a film with a groove carries next to nothing the error of the spline must not feed energy in: a smooth
    positive part of the power is taken away, so that the film is passive.
    """
    eps, x = _clipped(eps, table)
    f_n, f_t, _ = half_film_long(eps, deps, ew, 0.0)
    scale = math.sqrt(f_n * f_n + f_t * f_t)
    across, side = _across(eps, ew, table)
    y = math.atan2(across, deps)
    f_n, f_t = scale * _quantity(table, x, y, alpha, FORCE_N), side * scale * _quantity(table, x, y, alpha, FORCE_T)
    half = 0.5 * ew
    motion = deps * deps + half * half
    if motion > 0.0 and is_grooved(table):
        power, width = f_n * deps - f_t * half, _SMOOTH * scale * math.sqrt(motion)
        excess = 0.5 * (power + math.sqrt(power * power + width * width)) / motion
        f_n -= excess * deps
        f_t += excess * half
    extent = _quantity(table, x, y, alpha, EXTENT) / math.sqrt(1.0 - eps * eps) if sheared else 0.0
    return f_n, f_t, extent


@lazy_kernel
def mapped_flow(eps: float, deps: float, ew: float, alpha: float, table: Array) -> float:
    """Evaluate the volume flow out of the ends of a film from its map, in units of c*R^2; see `mapped_film`."""
    eps, x = _clipped(eps, table)
    across, _ = _across(eps, ew, table)
    flow = _quantity(table, x, math.atan2(across, deps), alpha, FLOW)
    return flow * math.sqrt(deps * deps + across * across)


@inlined_kernel
def _across(eps: float, ew: float, table: Array) -> tuple[float, float]:
    """Scaled wedge rate (1 - eps^2)^(1/4)*ew/2, and the side of its mirror image: 1, or -1."""
    across = math.sqrt(math.sqrt(1.0 - eps * eps)) * 0.5 * ew
    if head_of(table).na > 1:
        return across, 1.0
    return abs(across), math.copysign(1.0, ew) if ew != 0.0 else 0.0  # its own mirror image, to round-off too


@inlined_kernel
def _clipped(eps: float, table: Array) -> tuple[float, float]:
    """Eccentricity ratio within the map, and its x."""
    limit = head_of(table).reach
    x = math.log((1.0 + eps * (1.0 / STRETCH)) / (1.0 - eps)) if eps < 1.0 else limit
    return (eps, x) if x < limit else (table_limit(table), limit)


@lazy_kernel
def static_film(eps: float, alpha: float, table: Array) -> tuple[float, float, float]:
    """Evaluate the static part of a film: force over p*R*L and flow over p*c^3/mu at a supply pressure p; 0 without."""
    if not head_of(table).supplied:
        return 0.0, 0.0, 0.0
    _, x = _clipped(eps, table)
    return _static(table, x, alpha, FORCE_N), _static(table, x, alpha, FORCE_T), _static(table, x, alpha, FLOW)


def fit(head: MapHead, values: Array) -> Array:
    """Fit the splines of a table to the values (nx, ny, na, 4) at the nodes; in y a static part may follow."""
    padded = np.pad(values, ((1, 1), *((0, 0),) * 3))  # the end conditions have zero on the right
    found = np.tensordot(np.linalg.inv(_collocation(head.nx)), padded, (1, 0))
    moving, static = found[:, : head.ny], _periodic(found[:, head.ny :], 2)
    moving = _periodic(moving if head.na == 1 else _periodic(moving, 2), 1)
    rows = np.concatenate([part.reshape(head.nx + 2, -1, CHANNELS) for part in (moving, static)], axis=1)
    return np.concatenate([np.array(head), np.moveaxis(rows, -1, 0).ravel()])


def _collocation(nodes: int) -> Array:
    """Matrix of B-spline coefficients -> end condition (not-a-knot), values at the nodes, end condition."""
    matrix = np.zeros((nodes + 2, nodes + 2))
    for i in range(nodes):
        matrix[i + 1, i : i + 3] = 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0
    matrix[0, :5] = matrix[-1, -5:] = 1.0, -4.0, 6.0, -4.0, 1.0
    return matrix


def _periodic(values: Array, axis: int) -> Array:
    """Coefficients of a periodic spline along an axis, padded: the interval from node j begins at j."""
    count = values.shape[axis]
    factor = (4.0 + 2.0 * np.cos(2.0 * math.pi * np.fft.rfftfreq(count))) / 6.0
    shape = [1] * values.ndim
    shape[axis] = factor.size
    found = np.fft.irfft(np.fft.rfft(values, axis=axis) / factor.reshape(shape), count, axis=axis)
    return np.asarray(np.take(found, np.arange(-1, count + 2) % count, axis=axis))
