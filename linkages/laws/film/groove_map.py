"""The quasi-static film of a bearing with a groove as a map of three parameters, evaluated by a spline.

With the groove, the cavity and the ends at ambient pressure the film is homogeneous in the motion, so that the force
depends, but for a factor, on eps, on the direction of (deps, ew) and on the angle alpha from the groove to the
eccentricity. The map holds f_n/|f_long|, f_t/|f_long| and extent*sqrt(1 - eps^2) on a uniform grid of

    x = -ln(1 - eps),  y = atan2((1 - eps^2)^(1/4)*ew/2, deps) in [0, 2 pi),  alpha in [0, 2 pi),

interpolated by cubic splines, periodic in y and alpha: the force is twice continuously differentiable. A power that
the interpolation would deliver is taken away smoothly: the film is passive everywhere. The mirror
image (y, alpha) -> (-y, -alpha) halves the work.

With mass conservation the content of the cavity is stationary seen from the eccentricity, which is exact for a steady
whirl. It is transported with u = eps*(ew/2)/(eps^2 + 0.2^2), which is ew/(2 eps) away from the centre and regular
there; a cavity that closes is taken as full. A map cannot hold the history of the content: after a sudden change of
motion the cavity of a real film fills over a turn or so.

The layout: `HEAD` numbers, then the coefficients by x, y, alpha and quantity, the last two directions padded.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from linkages.arrays import Array
from linkages.kernel import kernel, lazy_kernel
from linkages.laws.film.closed_form import half_film_long
from linkages.laws.film.film_map import basis, collocation
from linkages.laws.film.surface.balance import Thickness
from linkages.laws.film.surface.complementarity import State
from linkages.laws.film.surface.grooves import Groove
from linkages.laws.film.surface.surface_film import SurfaceFilm, solve_film
from linkages.laws.film.surface.surface_mesh import SurfaceMesh, surface_mesh

#: Raised whenever the solver or the layout changes.
VERSION = 1
#: Rules of cavitation of such maps, and their codes: above those of maps without a groove.
RULES = {"reynolds": 2, "mass-conserving": 3}
#: Numbers before the coefficients: version, L/D, code, nodes in x, in y, largest x, nodes in alpha, extent and length.
HEAD = 9
#: Largest eccentricity ratio, nodes in x, y and alpha, cells of the mesh.
EPS_LIMIT, NODES, CELLS = 0.99, (17, 32, 20), (80, 6)
_CHANNELS = 3
_SMOOTH = 1e-3  # width of the smooth positive part of the power, in parts of |f_long| times the motion
_CENTRE = 0.2  # eccentricity ratio below which transport of the content fades


@kernel
def is_grooved(table: Array) -> bool:
    """Whether a map is one of these."""
    return len(table) > HEAD and table[2] >= 2.0


@lazy_kernel
def grooved_film(eps: float, deps: float, ew: float, alpha: float, table: Array) -> tuple[float, float, float]:
    """Force and extent of the film from its map.

    Parameters
    ----------
    eps, deps, ew : float
        As in `linkages.laws.film`; eps is clipped to the map's.
    alpha : float
        Angle from the groove to the eccentricity [rad].
    table : array of float
        From `build_groove_map`.
    """
    limit, steps_x = table[5], table[3] - 1.0
    ny, na = int(table[4]), int(table[6])
    x = -math.log(1.0 - eps) if eps < 1.0 else limit
    if x >= limit:
        x = limit
        eps = 1.0 - math.exp(-limit)
    f_n, f_t, _ = half_film_long(eps, deps, ew, 0.0)
    scale = math.sqrt(f_n * f_n + f_t * f_t)
    root_q = math.sqrt(1.0 - eps * eps)
    turn = 2.0 * math.pi
    y = math.atan2(math.sqrt(root_q) * 0.5 * ew, deps) / turn
    a = alpha / turn
    s, t, r = x * (steps_x / limit), (y - math.floor(y)) * ny, (a - math.floor(a)) * na
    i, j, k = min(int(s), int(steps_x) - 1), min(int(t), ny - 1), min(int(r), na - 1)
    x0, x1, x2, x3 = basis(s - i)
    y0, y1, y2, y3 = basis(t - j)
    a0, a1, a2, a3 = basis(r - k)
    line = _CHANNELS * (na + 3)
    g_n, g_t, g_e = 0.0, 0.0, 0.0
    plane = HEAD + line * (i * (ny + 3) + j) + _CHANNELS * k
    for weight_x in (x0, x1, x2, x3):
        row = plane
        for weight_y in (y0, y1, y2, y3):
            weight = weight_x * weight_y
            b, c, d, e = weight * a0, weight * a1, weight * a2, weight * a3
            g_n += b * table[row] + c * table[row + 3] + d * table[row + 6] + e * table[row + 9]
            g_t += b * table[row + 1] + c * table[row + 4] + d * table[row + 7] + e * table[row + 10]
            g_e += b * table[row + 2] + c * table[row + 5] + d * table[row + 8] + e * table[row + 11]
            row += line
        plane += line * (ny + 3)
    f_n, f_t = scale * g_n, scale * g_t
    half = 0.5 * ew
    motion = deps * deps + half * half
    if motion > 0.0:
        # where a starved film carries next to nothing the spline's error must not feed energy in: a smooth positive
        # part of the power is taken away
        power, width = f_n * deps - f_t * half, _SMOOTH * scale * math.sqrt(motion)
        excess = 0.5 * (power + math.sqrt(power * power + width * width)) / motion
        f_n -= excess * deps
        f_t += excess * half
    return f_n, f_t, g_e / root_q


def solve_grooved(
    eps: float, slenderness: float, groove: Groove, rule: str, alpha: float, angles: Array, cells: tuple[int, int]
) -> Array:
    """Solve the film at one place of the journal for directions y = ``angles`` of its motion, (ny,).

    Returns
    -------
    (ny, 3) array
        The mapped quantities.
    """
    placed = (groove._replace(angle=-alpha, pressure=0.0),)  # seen from the eccentricity, which points along x
    mesh = surface_mesh(slenderness, placed, (eps, 0.0), *cells)
    root_q = math.sqrt(1.0 - eps * eps)
    out, guess = np.empty((len(angles), _CHANNELS)), None
    for row, y in zip(out, angles, strict=True):
        deps, half_ew = math.cos(y), math.sin(y) / math.sqrt(root_q)
        film = quasi_static_film(mesh, eps, placed, rule, deps, half_ew, guess)
        guess = film.state
        f_n, f_t, _ = half_film_long(eps, deps, 2.0 * half_ew, slenderness)
        scale = 2.0 * slenderness * math.hypot(f_n, f_t)
        row[:] = film.force[0] / scale, film.force[1] / scale, film.shear / (2.0 * slenderness) * root_q
    return out


def quasi_static_film(
    mesh: SurfaceMesh,
    eps: float,
    grooves: tuple[Groove, ...],
    rule: str,
    deps: float,
    half_ew: float,
    guess: State | None = None,
) -> SurfaceFilm:
    """Solve the film whose content is stationary seen from the eccentricity, which points along x.

    Parameters
    ----------
    mesh : SurfaceMesh
        Of these grooves.
    eps, deps, half_ew : float
        Eccentricity ratio, its rate and half the wedge rate [1/s].
    grooves : tuple of Groove
        Angles from the eccentricity.
    rule : str
        Of cavitation.
    guess : State, optional
        Of a neighbouring film on this mesh.
    """
    speed = half_ew * eps / (eps * eps + _CENTRE**2) if rule == "mass-conserving" else 0.0
    return solve_film(
        mesh,
        Thickness(eps, 0.0),
        grooves,
        rule=rule,
        velocity=(deps, eps * speed - half_ew),
        speed=speed,
        full_when_closing=True,
        guess=guess,
    )


def build_groove_map(
    slenderness: float,
    groove: Groove,
    rule: str,
    progress: Callable[[float], object] | None = None,
    nodes: tuple[int, int, int] = NODES,
    cells: tuple[int, int] = CELLS,
) -> Array:
    """Solve the film on the grid of a map and fit its spline.

    Parameters
    ----------
    slenderness : float
        L/D.
    groove : Groove
        Its angle and pressure do not matter.
    rule : str
        A name in `RULES`.
    progress : callable, optional
        Called with the part that is done: a map takes up to half a minute to build.
    nodes, cells
        Nodes in x, y and alpha, even in the last two; cells of the mesh.
    """
    nx, ny, na = nodes
    limit = -math.log1p(-EPS_LIMIT)
    eps = -np.expm1(-np.linspace(0.0, limit, nx))
    angles = np.asarray(np.arange(ny) * (2.0 * math.pi / ny), dtype=np.float64)
    values = np.empty((nx, ny, na, _CHANNELS))
    mirror = -np.arange(ny) % ny
    for i, e in enumerate(eps):
        for k in range(na // 2 + 1):
            found = solve_grooved(float(e), slenderness, groove, rule, k * 2.0 * math.pi / na, angles, cells)
            values[i, :, -k % na] = found[mirror] * (1.0, -1.0, 1.0)
            values[i, :, k] = found
        if progress is not None:
            progress((i + 1) / nx)
    along_x = np.tensordot(np.linalg.inv(collocation(nx, 0)), np.pad(values, ((1, 1), (0, 0), (0, 0), (0, 0))), (1, 0))
    for axis in (1, 2):
        along_x = _periodic(along_x, axis)
    return np.concatenate((map_head(slenderness, groove, rule, nodes), along_x.ravel()))


def map_head(slenderness: float, groove: Groove, rule: str, nodes: tuple[int, int, int] = NODES) -> list[float]:
    """Numbers that a map begins with."""
    nx, ny, na = nodes
    limit = -math.log1p(-EPS_LIMIT)
    return [VERSION, slenderness, RULES[rule], nx, ny, limit, na, groove.extent, groove.length]


def _periodic(values: Array, axis: int) -> Array:
    """Coefficients of a periodic cubic spline along an axis, padded: the interval from node j begins at j."""
    count = values.shape[axis]
    factor = (4.0 + 2.0 * np.cos(2.0 * math.pi * np.fft.rfftfreq(count))) / 6.0
    shape = [1] * values.ndim
    shape[axis] = factor.size
    found = np.fft.irfft(np.fft.rfft(values, axis=axis) / factor.reshape(shape), count, axis=axis)
    return np.take(found, np.arange(-1, count + 2) % count, axis=axis)
