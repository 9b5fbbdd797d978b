"""Solve the film on a bearing's surface and integrate: forces, moments, flows, shear torque, mass balance.

Units: length of the film c, place R, angular velocity omega, pressure mu*omega*(R/c)^2, force mu*omega*R^4/c^2, volume
flow c*R^2*omega, torque mu*omega*R^4/c, moment of the pressure about the bearing's middle mu*omega*R^5/c^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, lazy_kernel
from linkages.base.kernel.by_reference import packed
from linkages.laws.film.surface.balance import Balance, Thickness, cell_volumes, fill_contents, make_balance
from linkages.laws.film.surface.cavity import solve
from linkages.laws.film.surface.grooves import Groove
from linkages.laws.film.surface.surface_mesh import SurfaceMesh


class Pressures(NamedTuple):
    """Gauge pressures of a film.

    Attributes
    ----------
    cavity : float
        Pressure of the cavity, at most 0 (ambient) [Pa].
    unit : float
        Unit of pressure of the solver [Pa].
    """

    cavity: float = 0.0
    unit: float = 1.0


class FilmSurface(NamedTuple):
    """The part of a film that does not change during a motion.

    Attributes
    ----------
    mesh : SurfaceMesh
        Mesh with the grooves, for a motion graded for no eccentricity.
    grooves : tuple of Groove
        With their supply pressures [Pa].
    pressures : Pressures
    """

    mesh: SurfaceMesh
    grooves: tuple[Groove, ...] = ()
    pressures: Pressures = Pressures()


class SurfaceFilm(NamedTuple):
    """A solved film; made by `solve_film`.

    Attributes
    ----------
    mesh : SurfaceMesh
    thickness : Thickness
    pressure : (n, m) array
        Gauge pressure.
    content : (n, m) array
        Film content in [0, 1].
    force : (float, float)
        Force on the journal.
    moment : (float, float)
        Moment of the pressure on the journal about the bearing's middle.
    end_flow : float
        Flow out of both ends.
    groove_flow : tuple of float
        Net flow out of each groove into the film.
    shear : float
        Integral of content/h: torque of a relative speed of 1, without the pressure's part.
    imbalance : float
        Largest volume that a cell gains, over the largest flow through a face [1].
    solution : array
        Of `linkages.laws.film.surface.cavity.solve`: guess for a neighbouring film.
    """

    mesh: SurfaceMesh
    thickness: Thickness
    pressure: Array
    content: Array
    force: tuple[float, float]
    moment: tuple[float, float]
    end_flow: float
    groove_flow: tuple[float, ...]
    shear: float
    imbalance: float
    solution: Array


def solve_film(
    surface: FilmSurface,
    thickness: Thickness,
    *,
    rule: str = "mass-conserving",
    velocity: tuple[float, float] = (0.0, 0.0),
    speed: float = 0.5,
    guess: Array | None = None,
    history: tuple[Array, float] | None = None,
) -> SurfaceFilm:
    """Solve Reynolds' equation on the surface.

    A mass-conserving film that neither a groove nor an end feeds carries no load, and its content is not unique:
    `linkages.bearing` and experiments refuse it.

    Parameters
    ----------
    surface : FilmSurface
    thickness : Thickness
    rule : str
        One of `linkages.laws.film.surface.cavity.RULES`.
    velocity, speed
        As for `make_balance`.
    guess : array, optional
        `solution` of a neighbouring film.
    history : ((n, m) array, float), optional
        Oil in the cells (`oil_volumes`) a time before, and this time in units of 1/omega: the film content follows from
        it by an implicit Euler step, for mass-conserving cavitation. Default: the content of a steady state.

    Raises
    ------
    ValueError
        If the journal touches the bearing.
    ArithmeticError
        If the solver does not converge.
    """
    mesh, grooves, pressures = surface
    if not thickness.least(mesh.slenderness) > 0.0:
        raise ValueError("the journal touches the bearing")
    balance = make_balance(mesh, thickness, velocity, speed)
    if history is not None:
        (oil, time), volumes = history, cell_volumes(mesh, thickness)
        balance = balance._replace(gain=(volumes - oil) / time, most=volumes / time)
    end = -pressures.cavity / pressures.unit
    supply = np.array([groove.pressure / pressures.unit + end for groove in grooves])
    balance = balance._replace(known=mesh.pressures(supply))
    solution = solve(balance, end, rule=rule, guess=guess)
    z = solution if rule == "mass-conserving" else np.maximum(solution, 0.0)
    fx, fy, mx, my, shear, flow = integrate_film(*mesh.geometry, packed(balance), end, z)
    p, content = np.maximum(z, 0.0), 1.0 + np.minimum(z, 0.0)
    out, largest = outflows(balance, end, p, content)
    gain = np.where(mesh.groove < 0, out + balance.gain - (1.0 - content) * balance.most, 0.0)
    if rule == "reynolds":  # volume appears where the film cavitates
        gain[solution < 0.0] = 0.0
    sides = 2.0 if mesh.half else 1.0
    fed = tuple(sides * float(out[mesh.groove == k].sum()) for k in range(len(grooves)))
    imbalance = float(np.abs(gain).max()) / largest
    return SurfaceFilm(
        mesh, thickness, p - end, content, (fx, fy), (mx, my), flow, fed, shear, imbalance, solution,
    )  # fmt: skip


def outflows(balance: Balance, end: float, p: Array, content: Array) -> tuple[Array, float]:
    """Volume that leaves each cell by pressure and transport of the content, (n, m); largest flow through a face."""
    upstream = np.where(balance.carried >= 0.0, content, np.roll(content, -1, axis=0))
    around = balance.carried * upstream - balance.around * (np.roll(p, -1, axis=0) - p)
    along = -balance.along * np.diff(p, axis=1, prepend=end, append=end)
    out = around - np.roll(around, 1, axis=0) + np.diff(along, axis=1)
    return out, max(float(np.abs(around).max()), float(np.abs(along).max()), 1e-300)


@lazy_kernel(makes_arrays=True)
def integrate_film(
    lines: Array, ends: Array, zeta: Array, balance: Balance, end: float, z: Array
) -> tuple[float, float, float, float, float, float]:
    """Integrate a solution of `linkages.laws.film.surface.cavity.solve`, without a pressure below the cavity's.

    Return force (2) and moment (2) on the journal, integral of content/h over the surface, and flow out of both ends.
    """
    n, m = z.shape
    content, inverse, along = np.empty((n, m)), balance.inverse, balance.along
    fill_contents(balance, z, content)
    fx, fy, mx, my, shear, flow = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        for j in range(m):
            area, p = ends[j + 1] - ends[j], max(z[i, j], 0.0)
            across, side = p * area * lines[i, 1], p * area * lines[i, 2]
            fx, fy = fx - across, fy - side  # the pressure pushes the journal from its surface inwards
            mx, my = mx + zeta[j] * side, my - zeta[j] * across
            shear += content[i, j] * area * inverse[i, j]
        first, last = max(z[i, 0], 0.0), max(z[i, m - 1], 0.0)
        flow += along[i, m] * (last - end) + along[i, 0] * (first - end)
    if ends[0] == 0.0:  # the mirrored half
        return 2.0 * fx, 2.0 * fy, 0.0, 0.0, 2.0 * shear, 2.0 * flow
    return fx, fy, mx, my, shear, flow


def oil_volumes(film: SurfaceFilm) -> Array:
    """Volume of oil in each cell, (n, m)."""
    return film.content * cell_volumes(film.mesh, film.thickness)


def largest_pressure(film: SurfaceFilm) -> float:
    """Largest pressure, of parabolas through the highest cell and its neighbours around and along."""
    mesh, p = film.mesh, film.pressure
    i, j = np.unravel_index(int(np.argmax(p)), p.shape)
    n, top = len(p), float(p[i, j])
    if mesh.groove[i, j] >= 0:
        return top
    theta = np.concatenate([mesh.theta[-1:] - 2.0 * math.pi, mesh.theta, mesh.theta[:1] + 2.0 * math.pi])
    highest = _summit(theta[i : i + 3], p[[i - 1, i, (i + 1) % n], j])
    zeta, along = mesh.zeta, p[i]
    if mesh.half:  # symmetric about the middle
        zeta, along, j = np.append(-zeta[0], zeta), np.append(along[0], along), j + 1
    if 0 < j < len(zeta) - 1:
        highest += _summit(zeta[j - 1 : j + 2], along[j - 1 : j + 2]) - top
    return highest


def _summit(x: Array, y: Array) -> float:
    """Top of the parabola through three points; the largest of them if it opens upwards."""
    bend, slope, level = np.polyfit(x - x[1], y, 2)
    return float(level - slope**2 / (4.0 * bend)) if bend < 0.0 else float(y.max())


def friction_torque(film: SurfaceFilm, relative: float = 1.0) -> float:
    """Torque on the journal against a relative angular velocity (in units of omega).

    The shear of the sliding surfaces is that of `content`/h; the pressure's part, the integral of h/2 dp/dtheta, is
    (e x F)/2 where h does not depend on z.
    """
    thickness, (fx, fy), (mx, my) = film.thickness, film.force, film.moment
    return film.shear * relative + 0.5 * (
        thickness.x * fy - thickness.y * fx - thickness.tilt_x * mx - thickness.tilt_y * my
    )
