"""Solve the film on a bearing's surface and integrate: forces, moments, flows, shear torque, mass balance.

Units: length of the film c, place R, angular velocity omega, pressure mu*omega*(R/c)^2, force mu*omega*R^4/c^2, volume
flow c*R^2*omega, torque mu*omega*R^4/c, moment of the pressure about the bearing's middle mu*omega*R^5/c^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.kernel import Array
from linkages.laws.film.surface.balance import Balance, Thickness, cell_volumes, make_balance, with_history
from linkages.laws.film.surface.complementarity import Boundary, State, solve
from linkages.laws.film.surface.grooves import Groove
from linkages.laws.film.surface.surface_mesh import SurfaceMesh

#: Rules of cavitation of the solver.
RULES = ("guembel", "reynolds", "mass-conserving")


class Pressures(NamedTuple):
    """Gauge pressures: of the cavity (at most ambient, 0), and the unit in which the solver counts [Pa]."""

    cavity: float = 0.0
    unit: float = 1.0


class NoLoadError(ValueError):
    """A film that conserves mass, has no groove and a cavity at ambient pressure: nothing feeds it."""

    def __init__(self, cavity_is_ambient: bool = False) -> None:
        other = "" if cavity_is_ambient else "set a cavity pressure below 0, "
        super().__init__(
            "with mass conservation, without a groove and with the cavity at ambient pressure nothing feeds the film "
            f"and it carries no load; add a groove, {other}or choose cavitation guembel or reynolds"
        )


#: Cavity at ambient pressure, and pressures counted in Pa.
AMBIENT = Pressures()


class SurfaceFilm(NamedTuple):
    """A solved film."""

    mesh: SurfaceMesh
    thickness: Thickness
    pressure: Array  # gauge, (n, m)
    content: Array  # film content in [0, 1], (n, m)
    force: tuple[float, float]  # on the journal
    moment: tuple[float, float]  # of the pressure on the journal about the bearing's middle
    end_flow: float  # out of both ends
    groove_flow: tuple[float, ...]  # net, out of each groove into the film
    storage: float  # volume that the film takes up: integral of content times dh/dt, or its growth since `history`
    shear: float  # integral of content/h: torque of a relative speed of 1, without the pressure's part
    imbalance: float  # largest volume that a cell gains, over the largest flow through a face
    state: State  # guess for a neighbouring film


def solve_film(
    mesh: SurfaceMesh,
    thickness: Thickness,
    grooves: tuple[Groove, ...] = (),
    *,
    rule: str = "mass-conserving",
    velocity: tuple[float, float] = (0.0, 0.0),
    speed: float = 0.5,
    pressures: Pressures = AMBIENT,
    guess: State | None = None,
    history: tuple[Array, float] | None = None,
) -> SurfaceFilm:
    """Solve Reynolds' equation on the surface.

    Parameters
    ----------
    mesh : SurfaceMesh
        Of these grooves.
    thickness : Thickness
    grooves : tuple of Groove
        With their supply pressures [Pa].
    rule : str
        One of `RULES`.
    velocity, speed
        As for `make_balance`.
    pressures : Pressures
    guess : State, optional
    history : ((n, m) array, float), optional
        Oil in the cells (`oil_volumes`) a time before, and this time in units of 1/omega: the film content follows from
        it, for mass-conserving cavitation. Default: the content of a steady state.

    Raises
    ------
    ValueError
        If the rule is unknown or the journal touches the bearing; a `NoLoadError` if nothing feeds the film.
    ArithmeticError
        If the solver does not converge.
    """
    if rule not in RULES:
        raise ValueError(f"cavitation {rule!r}: must be one of {', '.join(RULES)}")
    if rule == "mass-conserving" and not grooves and pressures.cavity == 0.0 and history is None:
        raise NoLoadError
    if not thickness.least(mesh.slenderness) > 0.0:
        raise ValueError("the journal touches the bearing")
    balance = make_balance(mesh, thickness, velocity, speed)
    if history is not None:
        balance = with_history(balance, cell_volumes(mesh, thickness), *history)
    cavity = pressures.cavity / pressures.unit
    known = np.array([*(groove.pressure / pressures.unit for groove in grooves), 0.0]) - cavity
    boundary = Boundary(-cavity, np.where(balance.free, 0.0, known[mesh.groove]))
    state = solve(balance, boundary, rule=rule, guess=guess)
    p = state.p
    content = np.maximum(1.0 - state.deficit, 0.0) if rule == "mass-conserving" else np.ones_like(p)
    p = np.maximum(p, 0.0)  # guembel drops what lies below the cavity's pressure
    flows = _flows(balance, boundary, p, content)
    return _integrate(mesh, thickness, balance, state, p + cavity, content, flows, len(grooves), rule)


class _Flows(NamedTuple):
    """Volume flow through faces: after each cell around and along, and through the end at zeta < 0."""

    around: Array
    along: Array
    start: Array


def _flows(balance: Balance, boundary: Boundary, p: Array, content: Array) -> _Flows:
    upstream = np.where(balance.carried >= 0.0, content, np.roll(content, -1, axis=0))
    around = balance.carried * upstream - balance.around * (np.roll(p, -1, axis=0) - p)
    following = np.concatenate([p[:, 1:], np.full((len(p), 1), boundary.end)], axis=1)
    return _Flows(around, balance.along * (p - following), balance.start * (boundary.end - p[:, 0]))


def _integrate(
    mesh: SurfaceMesh,
    thickness: Thickness,
    balance: Balance,
    state: State,
    pressure: Array,
    content: Array,
    flows: _Flows,
    grooves: int,
    rule: str,
) -> SurfaceFilm:
    sides = 2.0 if mesh.half else 1.0
    sines, cosines = np.diff(np.sin(mesh.faces)), -np.diff(np.cos(mesh.faces))
    weights = sides * mesh.height
    fx, fy = float(sines @ pressure @ weights), float(cosines @ pressure @ weights)
    # the pressure pushes the journal from its surface inwards: -n(theta) p
    moment = (0.0, 0.0)
    if not mesh.half:
        arms = weights * mesh.zeta
        moment = float(cosines @ pressure @ arms), -float(sines @ pressure @ arms)
    out = flows.around - np.roll(flows.around, 1, axis=0) + flows.along
    out[:, 1:] -= flows.along[:, :-1]
    out[:, 0] -= flows.start
    stored = balance.squeeze - (1.0 - content) * balance.missing
    gain = np.where(balance.free, out + stored, 0.0)
    if rule == "reynolds":  # volume appears where the film cavitates
        gain = np.where(state.deficit > 0.0, 0.0, gain)
    largest = max(float(np.abs(flows.around).max()), float(np.abs(flows.along).max()), 1e-300)
    theta, zeta = mesh.theta[:, None], mesh.zeta
    inverse = content_at_centres(balance, content) / thickness.at(theta, zeta)
    return SurfaceFilm(
        mesh,
        thickness,
        pressure,
        content,
        (-fx, -fy),
        moment,
        sides * float(flows.along[:, -1].sum() - flows.start.sum()),
        tuple(sides * float(out[mesh.groove == k].sum()) for k in range(grooves)),
        sides * float(stored[balance.free].sum()),
        float(mesh.width @ inverse @ weights),
        float(np.abs(gain).max()) / largest,
        state,
    )


def oil_volumes(film: SurfaceFilm) -> Array:
    """Volume of oil in each cell, (n, m)."""
    return film.content * cell_volumes(film.mesh, film.thickness)


def content_at_centres(balance: Balance, content: Array) -> Array:
    """Content at the centres of cells: a cell's own number is the one at its face downstream."""
    upstream = np.where(balance.carried >= 0.0, content, np.roll(content, -1, axis=0))
    carried, full = balance.carried * upstream, balance.carried
    total = full + np.roll(full, 1, axis=0)
    mean = (carried + np.roll(carried, 1, axis=0)) / np.where(total == 0.0, 1.0, total)
    return np.where(balance.free & (content < 1.0) & (total != 0.0), np.clip(mean, 0.0, 1.0), content)


def largest_pressure(film: SurfaceFilm) -> float:
    """Largest pressure, of parabolas through the highest cell and its neighbours around and along."""
    mesh, p = film.mesh, film.pressure
    i, j = np.unravel_index(int(np.argmax(p)), p.shape)
    n, m = p.shape
    top = float(p[i, j])
    if mesh.groove[i, j] >= 0:
        return top
    around = np.array([mesh.theta[i - 1], mesh.theta[i], mesh.theta[(i + 1) % n]])
    around[0] -= 2.0 * math.pi * (i == 0)
    around[2] += 2.0 * math.pi * (i == n - 1)
    rise = _summit(around, p[[i - 1, i, (i + 1) % n], j]) - top
    if j == 0 and mesh.half:  # symmetric about the middle
        along, values = np.array([-mesh.zeta[0], *mesh.zeta[:2]]), np.array([p[i, 0], *p[i, :2]])
    elif 0 < j < m - 1:
        along, values = mesh.zeta[j - 1 : j + 2], p[i, j - 1 : j + 2]
    else:
        return top + rise
    return top + rise + _summit(along, values) - top


def _summit(x: Array, y: Array) -> float:
    """Top of the parabola through three points; the largest of them if it opens upwards."""
    bend, slope, level = np.polyfit(x - x[1], y, 2)
    return float(level - slope**2 / (4.0 * bend)) if bend < 0.0 else float(y.max())


def friction_torque(film: SurfaceFilm, relative: float = 1.0) -> float:
    """Torque on the journal against a relative angular velocity (in units of omega).

    The shear of the sliding surfaces is that of `content`/h; the pressure's part, the integral of h/2 dp/dtheta, is
    (e x F)/2 where h does not depend on z.
    """
    thickness, (fx, fy) = film.thickness, film.force
    pressed = 0.5 * (thickness.x * fy - thickness.y * fx)
    if thickness.tilt_x or thickness.tilt_y:
        mesh = film.mesh
        weights = (2.0 if mesh.half else 1.0) * mesh.height * mesh.zeta
        sines, cosines = np.diff(np.sin(mesh.faces)), -np.diff(np.cos(mesh.faces))
        px, py = float(sines @ film.pressure @ weights), float(cosines @ film.pressure @ weights)
        pressed += 0.5 * (thickness.tilt_y * px - thickness.tilt_x * py)
    return film.shear * relative + pressed


def attitude(film: SurfaceFilm) -> float:
    """Angle from the load to the eccentricity, positive in the sense of rotation [rad]."""
    load = math.atan2(-film.force[1], -film.force[0])
    angle = math.atan2(film.thickness.y, film.thickness.x) - load
    return math.remainder(angle, 2.0 * math.pi)
