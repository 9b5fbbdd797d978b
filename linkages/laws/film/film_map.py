"""The film of a bearing of finite length as a map of two parameters, evaluated by a spline.

Reynolds' equation is linear in (deps, ew) and the rules of cavitation are homogeneous, so at one L/D the
force depends, but for a factor, on eps and on the direction of (deps, ew) alone. The map holds

    f_n/|f_long|, f_t/|f_long| and extent*sqrt(1 - eps^2), for ew >= 0 (f_t is odd in ew),

|f_long| the force of `linkages.laws.film.closed_form.half_film_long` in the same state, on a uniform grid of

    x = -ln(1 - eps) in [0, -ln(1 - EPS_LIMIT)],  y = atan2((1 - eps^2)^(1/4)*ew/2, deps) in [0, pi],

interpolated by a bicubic spline whose ends in y keep the parity of each quantity. A map is one flat array
of floats: a head of `HEAD` numbers, then the spline's coefficients, and compiled code reads
it as it is. **A map is never extrapolated**: eps is clipped to `table_limit(table)`; where a run exceeds it
the caller should report that.

Maps are kept on disk by `linkages.laws.film.map_cache`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from linkages.kernel import Array, kernel, lazy_kernel
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.reynolds import full_film, guembel, make_mesh, reynolds

#: Raised whenever the solver or the layout of the map changes: maps of other versions are not read.
VERSION = 2
#: Largest eccentricity ratio of a map.
EPS_LIMIT = 0.999
#: Nodes of a map in x and in y.
NODES = 49
#: Numbers before the coefficients: version, L/D, cavitation, nodes in x, nodes in y, largest x.
HEAD = 6
_CHANNELS = 3


class Cavitation(NamedTuple):
    """A rule of cavitation by name: its code in the head of a map, and what it means."""

    code: int
    formula: str
    valid: str
    source: str
    around: int  # mesh lines around the film and along its half length, for a map
    along: int


#: The rules of cavitation of a finite film.
CAVITATIONS = {
    "guembel": Cavitation(
        0, "2D Reynolds equation on the whole film, max(p, 0)",
        "any L/D, eps <= 0.999", "Guembel's half-Sommerfeld condition", around=480, along=32,
    ),
    "reynolds": Cavitation(
        1, "2D Reynolds equation with p >= 0 as complementarity",
        "any L/D, eps <= 0.999", "Swift-Stieber condition; Butenschoen 1976", around=240, along=20,
    ),
}  # fmt: skip


@kernel
def table_limit(table: Array) -> float:
    """Largest eccentricity ratio that this map covers."""
    return 1.0 - math.exp(-table[5])


@lazy_kernel
def finite_film(eps: float, deps: float, ew: float, table: Array) -> tuple[float, float, float]:
    """Force and extent of a finite film from its map.

    Parameters
    ----------
    eps, deps, ew : float
        As in `linkages.laws.film`; eps is clipped to `table_limit(table)`.
    table : array of float
        From `linkages.laws.film.map_cache.load_map` or `build_map`.

    Returns
    -------
    f_n, f_t, extent : float
        Units of mu*L*R^3/c^2, and the integral of dtheta/h over the film that carries pressure.
    """
    limit = table[5]
    nodes_y = int(table[4])
    x = -math.log(1.0 - eps) if eps < 1.0 else limit
    if x >= limit:
        x = limit
        eps = 1.0 - math.exp(-limit)
    f_n, f_t, _ = half_film_long(eps, deps, ew, 0.0)
    scale = math.sqrt(f_n * f_n + f_t * f_t)
    root_q = math.sqrt(1.0 - eps * eps)
    y = math.atan2(math.sqrt(root_q) * abs(0.5 * ew), deps)
    steps_x = table[3] - 1.0
    s = x * (steps_x / limit)
    t = y * ((nodes_y - 1) / math.pi)
    i = min(int(s), int(steps_x) - 1)
    j = min(int(t), nodes_y - 2)
    s -= i
    t -= j
    x0, x1, x2, x3 = basis(s)
    y0, y1, y2, y3 = basis(t)
    row = HEAD + _CHANNELS * (i * (nodes_y + 2) + j)
    stride = _CHANNELS * (nodes_y + 2)
    g_n, g_t, g_e = 0.0, 0.0, 0.0
    for weight in (x0, x1, x2, x3):
        a, b, c, d = weight * y0, weight * y1, weight * y2, weight * y3
        g_n += a * table[row] + b * table[row + 3] + c * table[row + 6] + d * table[row + 9]
        g_t += a * table[row + 1] + b * table[row + 4] + c * table[row + 7] + d * table[row + 10]
        g_e += a * table[row + 2] + b * table[row + 5] + c * table[row + 8] + d * table[row + 11]
        row += stride
    return scale * g_n, scale * g_t if ew >= 0.0 else -scale * g_t, g_e / root_q


@kernel
def basis(s: float) -> tuple[float, float, float, float]:
    """Cubic B-splines on a uniform grid, at s in [0, 1] of an interval."""
    r = 1.0 - s
    b1, b2 = 4.0 - 6.0 * s * s + 3.0 * s * s * s, 4.0 - 6.0 * r * r + 3.0 * r * r * r
    return r * r * r / 6.0, b1 / 6.0, b2 / 6.0, s * s * s / 6.0


def solve_scaled(eps: float, slenderness: float, cavitation: str, angles: Array) -> Array:
    """Solve the film at one eps for directions y = ``angles`` of the motion, (ny,).

    Returns
    -------
    (ny, 3) array
        The mapped quantities: normal and tangential force, extent.
    """
    rule = CAVITATIONS[cavitation]
    mesh = make_mesh(eps, slenderness, rule.around, rule.along)
    films = full_film(mesh) if rule.code == 0 else None
    q = 1.0 - eps * eps
    out = np.empty((len(angles), _CHANNELS))
    guess = None
    for row, y in zip(out, angles, strict=True):
        deps, half_ew = math.cos(y), math.sin(y) / q**0.25
        if films is not None:
            film = guembel(mesh, films, deps, half_ew)
        else:
            film = reynolds(mesh, deps, half_ew, guess=guess)
            guess = film.p
        f_n, f_t, _ = half_film_long(eps, deps, 2.0 * half_ew, slenderness)
        scale = math.hypot(f_n, f_t)
        row[:] = film.f_n / scale, film.f_t / scale, film.extent * math.sqrt(q)
    return out


def build_map(
    slenderness: float,
    cavitation: str = "guembel",
    nodes: int = NODES,
    progress: Callable[[float], object] | None = None,
) -> Array:
    """Solve Reynolds' equation on the grid of a map and fit its spline.

    Parameters
    ----------
    slenderness : float
        L/D > 0.
    cavitation : str
        A name in `CAVITATIONS`.
    nodes : int
        Nodes in each direction, at least 5.
    progress : callable, optional
        Called with the part that is done, in (0, 1]: a map takes seconds to build.

    Returns
    -------
    table : array of float
        For `finite_film`.

    Raises
    ------
    ValueError
        If the rule of cavitation is unknown, or L/D or the number of nodes out of range.
    """
    if cavitation not in CAVITATIONS:
        raise ValueError(f"cavitation {cavitation!r}: must be one of {', '.join(CAVITATIONS)}")
    if nodes < 5:
        raise ValueError(f"{nodes} nodes: a map needs at least 5")
    limit = -math.log1p(-EPS_LIMIT)
    angles = np.linspace(0.0, math.pi, nodes)
    eps = -np.expm1(-np.linspace(0.0, limit, nodes))
    values = np.empty((nodes, nodes, _CHANNELS))
    for i, e in enumerate(eps):
        values[i] = solve_scaled(float(e), slenderness, cavitation, angles)
        if progress is not None:
            progress((i + 1) / nodes)
    values[:, [0, -1], 1] = 0.0  # odd about both ends
    free = np.linalg.inv(collocation(nodes, 0))
    even, odd = np.linalg.inv(collocation(nodes, 1)), np.linalg.inv(collocation(nodes, -1))
    padded = np.pad(values, ((1, 1), (1, 1), (0, 0)))  # end conditions have zero on the right
    along_x = np.tensordot(free, padded, axes=(1, 0))
    coefficients = np.empty_like(padded)
    for channel, inverse in enumerate((even, odd, even)):
        coefficients[..., channel] = along_x[..., channel] @ inverse.T
    return np.concatenate((map_head(slenderness, cavitation, nodes), coefficients.ravel()))


def map_head(slenderness: float, cavitation: str, nodes: int) -> list[float]:
    """Numbers that a map begins with."""
    return [VERSION, slenderness, CAVITATIONS[cavitation].code, nodes, nodes, -math.log1p(-EPS_LIMIT)]


def collocation(nodes: int, parity: int) -> Array:
    """Matrix of B-spline coefficients -> end condition, values at the nodes, end condition.

    The ends are mirrors (parity 1), odd (parity -1) or not-a-knot (parity 0).
    """
    matrix = np.zeros((nodes + 2, nodes + 2))
    for i in range(nodes):
        matrix[i + 1, i : i + 3] = 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0
    end = {0: [1.0, -4.0, 6.0, -4.0, 1.0], 1: [1.0, 0.0, -1.0], -1: [1.0, 0.0, 1.0]}[parity]
    matrix[0, : len(end)] = end
    matrix[-1, -len(end) :] = end[::-1]
    return matrix
