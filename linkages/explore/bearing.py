"""A journal bearing under a static load: equilibrium, flow, friction, dynamic coefficients, stability.

The load acts along x, the journal turns counter-clockwise; angles are measured from the load and positive in the sense
of rotation. Pressures are gauge.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np

from linkages.base.arguments import validated, whole
from linkages.base.arrays import Array
from linkages.base.errors import InputError, RunError, nearest
from linkages.explore.numerics import BEARING_SMOOTH, BEARING_THINNEST
from linkages.input.files.writing import finite
from linkages.laws.film.closed_form import EPS_MAX
from linkages.laws.film.films import FILMS
from linkages.laws.film.surface.balance import Thickness
from linkages.laws.film.surface.cavity import RULES
from linkages.laws.film.surface.equilibrium import DIFFERENCE, Coefficients, coefficients, equilibrium, stability
from linkages.laws.film.surface.grooves import Groove, check_grooves, no_load
from linkages.laws.film.surface.surface_film import (
    FilmSurface,
    Pressures,
    SurfaceFilm,
    friction_torque,
    largest_pressure,
    solve_film,
)
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.laws.film.surface.transient import filling_time

#: Standard acceleration of free fall [m/s2]: the mass of a load.
GRAVITY = 9.80665
#: Cells around and along half the length of the mesh, and of the one on which the search starts.
CELLS, COARSE = (240, 20), (72, 6)
_CHART = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)  # eccentricity ratios of a chart


@dataclass(frozen=True)
class BearingCase:
    """A bearing, its oil and its load, in SI units.

    Attributes
    ----------
    diameter, length, clearance : float
        Of the bearing; radial clearance [m].
    viscosity : float
        Dynamic viscosity [Pa s].
    speed : float
        Angular velocity of the journal [rad/s].
    load : float
        On the journal [N].
    film : str
        A film of `linkages.laws.FILMS` without parameters.
    cavitation : str or None
        Rule of the finite film: guembel, reynolds, mass-conserving. None: mass-conserving with grooves or with a
        cavity pressure below ambient, else guembel.
    grooves : tuple of Groove
        Angles from the load.
    cavity_pressure : float
        Gauge, at most 0 [Pa].
    tilt : (float, float)
        Slope of the journal's axis: displacement along the load and at a right angle to it, per length [1].
    mass : float or None
        Of the journal, for the threshold speed [kg]; None: the load over the acceleration of free fall.
    """

    diameter: float
    length: float
    clearance: float
    viscosity: float
    speed: float
    load: float
    film: str = "finite"
    cavitation: str | None = None
    grooves: tuple[Groove, ...] = ()
    cavity_pressure: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)
    mass: float | None = None

    @property
    def rule(self) -> str:
        """Rule of cavitation that acts."""
        fed = bool(self.grooves) or self.cavity_pressure < 0.0
        return self.cavitation or ("mass-conserving" if fed else "guembel")

    @property
    def radius(self) -> float:
        """Radius of the bearing [m]."""
        return 0.5 * self.diameter

    @property
    def pressure_unit(self) -> float:
        """Unit of pressure mu omega (R/c)^2 [Pa]."""
        return self.viscosity * self.speed * (self.radius / self.clearance) ** 2

    @property
    def force_unit(self) -> float:
        """Unit of force mu omega R^4/c^2 [N]."""
        return self.pressure_unit * self.radius**2

    @property
    def slenderness(self) -> float:
        """L/D [1]."""
        return self.length / self.diameter

    def thickness(self, x: float, y: float) -> Thickness:
        """Film with the journal at a place, in units of the clearance."""
        slope = self.radius / self.clearance
        return Thickness(x, y, self.tilt[0] * slope, self.tilt[1] * slope)

    def sommerfeld(self, load: float) -> float:
        """Sommerfeld number mu N D L/W (R/c)^2 of a load [1]."""
        return self.pressure_unit * self.diameter * self.length / (2.0 * math.pi * load)


@dataclass(frozen=True, eq=False)
class BearingPoint:
    """A bearing at its operating point; `content` is what ``bearing.json`` holds.

    Attributes
    ----------
    case : BearingCase
    x, y : float
        Place of the journal's centre over the clearance, x along the load [1].
    film : SurfaceFilm or None
        The solved film; None of films in closed form.
    torque : float
        Friction torque on the journal [N m].
    coefficients : Coefficients
        Stiffness [N/m] and damping [N s/m].
    critical_mass : float
        Mass of a rigid journal that begins to whirl at this operating point [kg]; infinite if none does.
    whirl_ratio : float
        Angular frequency of that whirl over the speed [1]; nan without whirl.
    """

    case: BearingCase
    x: float
    y: float
    film: SurfaceFilm | None
    torque: float
    coefficients: Coefficients
    critical_mass: float
    whirl_ratio: float

    @property
    def eccentricity_ratio(self) -> float:
        """Eccentricity over the clearance [1]."""
        return math.hypot(self.x, self.y)

    @property
    def attitude(self) -> float:
        """Angle from the load to the eccentricity [rad]."""
        return math.atan2(self.y, self.x)

    @property
    def sommerfeld(self) -> float:
        """Sommerfeld number mu N D L/W (R/c)^2 [1]."""
        return self.case.sommerfeld(self.case.load)

    @property
    def threshold_speed(self) -> float:
        """Speed above which the rigid journal whirls, at this Sommerfeld number [rad/s]; infinite if it never does."""
        mass = self.case.load / GRAVITY if self.case.mass is None else self.case.mass
        return self.case.speed * math.sqrt(self.critical_mass / mass)

    @property
    def content(self) -> dict[str, Any]:
        """Numbers of ``bearing.json``, SI units; null where the film or the case has none."""
        case, film = self.case, self.film
        volume = case.clearance * case.radius**2 * case.speed
        moment, conserved = case.force_unit * case.radius, case.rule == "mass-conserving"
        return {
            "eccentricity_ratio": self.eccentricity_ratio,
            "attitude": self.attitude,
            "sommerfeld": self.sommerfeld,
            "flow": None if film is None else volume * film.end_flow,
            "groove_flow": None if film is None else [volume * flow for flow in film.groove_flow],
            "friction_torque": self.torque,
            "power": self.torque * case.speed,
            "largest_pressure": None if film is None else case.pressure_unit * largest_pressure(film),
            "least_film": case.clearance * case.thickness(self.x, self.y).least(case.slenderness),
            "moment": None if film is None else [moment * value for value in film.moment],
            "stiffness": self.coefficients.stiffness.tolist(),
            "damping": self.coefficients.damping.tolist(),
            "threshold_speed": finite(self.threshold_speed),
            "critical_mass": finite(self.critical_mass),
            "whirl_ratio": finite(self.whirl_ratio),
            "film": case.film,
            "cavitation": case.rule if film is not None else None,
            "filling_time": finite(filling_time(film) / case.speed) if film and conserved else None,
            "mass_imbalance": film.imbalance if film and case.rule != "guembel" else None,
            "status": "ok",
        }


@validated
def bearing(
    diameter: float,
    length: float,
    clearance: float,
    viscosity: float,
    speed: float,
    load: float,
    *,
    film: str = "finite",
    cavitation: str | None = None,
    grooves: Sequence[Groove] = (),
    cavity_pressure: float = 0.0,
    tilt: tuple[float, float] = (0.0, 0.0),
    mass: float | None = None,
    cells: tuple[Annotated[int, partial(whole, least=8)], Annotated[int, partial(whole, least=2)]] = CELLS,
) -> BearingPoint:
    """Find the operating point of a journal bearing under a static load.

    Parameters
    ----------
    diameter, length, clearance, viscosity, speed, load, film, cavitation, grooves, cavity_pressure, tilt, mass
        As in `BearingCase`.
    cells : (int, int)
        Cells of the mesh around the film and along half its length.

    Raises
    ------
    InputError
        If a value is out of range, or nothing feeds the film.
    RunError
        If no equilibrium is found: the load is too large for a film of a thousandth of the clearance.

    Examples
    --------
    >>> import linkages
    >>> point = linkages.bearing(0.1, 0.05, 1e-4, viscosity=0.03, speed=100.0, load=1000.0, cells=(72, 6))
    >>> round(point.eccentricity_ratio, 2)
    0.48
    """
    case = checked(
        BearingCase(
            diameter, length, clearance, viscosity, speed, load, film, cavitation, tuple(grooves), cavity_pressure,
            tilt, mass,
        )
    )  # fmt: skip
    try:
        return _operating(case, cells)
    except ArithmeticError as problem:
        raise RunError(
            f"bearing: {problem}: the film would be thinner than {BEARING_THINNEST:g} of the clearance, or its groove "
            "lies where the load presses; lower the load, raise speed, viscosity or length, or move the groove"
        ) from None


def _operating(case: BearingCase, cells: tuple[int, int]) -> BearingPoint:
    """Find the operating point of a case; ArithmeticError if there is none."""
    target, film, step = case.load / case.force_unit, None, BEARING_SMOOTH

    def least(x: float, y: float) -> float:
        return case.thickness(x, y).least(case.slenderness) - BEARING_THINNEST

    if FILMS[case.film].force is not None:
        force = _closed_form(case)
        x, y = equilibrium(force, target, least)
        torque = _shear(case, x, y)
    else:
        place = equilibrium(_Solver(case, (0.0, 0.0), COARSE).force, target, least)
        solver, step = _Solver(case, place, cells), DIFFERENCE
        x, y = equilibrium(solver.force, target, least, place)
        force, film = solver.force, solver.film(x, y)
        torque = case.force_unit * case.clearance * friction_torque(film)
    found = coefficients(force, x, y, step * case.thickness(x, y).least(case.slenderness))
    unit, scale = case.force_unit / case.clearance, case.force_unit / case.load
    whirl = stability(found.stiffness * scale, found.damping * scale)
    scaled = Coefficients(unit * found.stiffness, unit / case.speed * found.damping)
    mass = whirl.critical_mass * case.load / (case.clearance * case.speed**2)
    return BearingPoint(case, x, y, film, torque, scaled, mass, whirl.whirl_ratio)


def checked(case: BearingCase) -> BearingCase:
    """Check the values of a case; return it. InputError with the value, the reason and the allowed range."""
    fault = partial(InputError, "bearing")
    for name in ("diameter", "length", "clearance", "viscosity", "speed", "load", "mass"):
        value = getattr(case, name)
        if value is not None and not value > 0.0:
            raise fault(name, f"{value:g}: must be positive")
    if case.clearance >= case.radius:
        raise fault("clearance", f"{case.clearance:g} m: must be below the radius of the bearing, {case.radius:g} m")
    if case.film not in FILMS or FILMS[case.film].parameters:
        raise fault("film", f'"{case.film}": {nearest(case.film, [n for n, f in FILMS.items() if not f.parameters])}')
    if case.cavitation is not None and case.cavitation not in RULES:
        raise fault("cavitation", f'"{case.cavitation}": {nearest(case.cavitation, RULES)}')
    own = FILMS[case.film].force is None
    if not own and (case.grooves or case.cavitation or case.cavity_pressure or any(case.tilt)):
        raise fault("film", f'"{case.film}" has no groove, tilt or rule of cavitation: choose film finite')
    try:
        check_grooves(case.grooves, case.cavity_pressure)
    except ValueError as problem:
        raise fault("", str(problem)) from None
    if math.hypot(*case.tilt) * 0.5 * case.length >= case.clearance * (1.0 - 2.0 * BEARING_THINNEST):
        most = 2.0 * case.clearance / case.length
        raise fault(
            "tilt", f"{math.hypot(*case.tilt):g}: the journal touches the bearing at {most:g} (2 c/L) and above"
        )
    if own and case.rule == "mass-conserving" and not case.grooves and case.cavity_pressure == 0.0:
        raise fault("", no_load("set a cavity pressure below 0, "))
    return case


def chart(case: BearingCase, progress: Callable[[float], object] | None = None) -> dict[str, Array]:
    """Compute the usual chart of a bearing with a finite film: operating points at given eccentricity ratios.

    Return the (n,) arrays ``eccentricity_ratio``, ``sommerfeld``, ``attitude`` [rad], ``flow`` over c R^2 omega,
    ``friction``: torque over load, radius and c/R. The load of the case does not matter. `progress` is called with the
    part that is done.
    """
    rows: list[tuple[float, ...]] = []
    for k, eps in enumerate(_CHART):
        angle = rows[-1][2] if rows else 1.2
        if case.thickness(eps, 0.0).least(case.slenderness) <= BEARING_THINNEST:
            break
        solver = _Solver(case, (eps * math.cos(angle), eps * math.sin(angle)), COARSE)
        for _ in range(25):  # turn the place until the force is opposite to x
            film = solver.film(eps * math.cos(angle), eps * math.sin(angle))
            turn = math.atan2(film.force[1], -film.force[0])
            angle += 0.7 * turn
            if abs(turn) < 1e-4:
                break
        else:
            continue
        film = solver.film(eps * math.cos(angle), eps * math.sin(angle))
        load = math.hypot(*film.force)
        rows.append((eps, case.sommerfeld(load * case.force_unit), angle, film.end_flow, friction_torque(film) / load))
        if progress is not None:
            progress((k + 1) / len(_CHART))
    names = ("eccentricity_ratio", "sommerfeld", "attitude", "flow", "friction")
    return dict(zip(names, np.transpose(rows), strict=True))


class _Solver:
    """The film of a case on one mesh; each solution is the next one's guess."""

    def __init__(self, case: BearingCase, place: tuple[float, float], cells: tuple[int, int]) -> None:
        half = False if any(case.tilt) else None
        mesh = surface_mesh(case.slenderness, case.grooves, place, *cells, half=half)
        self.case = case
        self.surface = FilmSurface(mesh, case.grooves, Pressures(case.cavity_pressure, case.pressure_unit))
        self.guess: Array | None = None

    def film(self, x: float, y: float, vx: float = 0.0, vy: float = 0.0) -> SurfaceFilm:
        """Solve the film at a place and velocity of the journal."""
        thickness, rule = self.case.thickness(x, y), self.case.rule
        found = solve_film(self.surface, thickness, rule=rule, velocity=(vx, vy), guess=self.guess)
        self.guess = found.solution
        return found

    def force(self, x: float, y: float, vx: float, vy: float) -> tuple[float, float]:
        """Force on the journal over the unit of force."""
        return self.film(x, y, vx, vy).force


def _closed_form(case: BearingCase) -> Callable[[float, float, float, float], tuple[float, float]]:
    """Force of a film in closed form over the unit of force."""
    law, slenderness = FILMS[case.film].force, case.slenderness
    assert law is not None

    def force(x: float, y: float, vx: float, vy: float) -> tuple[float, float]:
        e = math.hypot(x, y)
        nx, ny = (x / e, y / e) if e > 0.0 else (1.0, 0.0)
        f_n, f_t, _ = law(min(e, EPS_MAX), vx * nx + vy * ny, e - 2.0 * (vy * nx - vx * ny), slenderness)
        scale = 2.0 * slenderness  # L/R
        return scale * (f_n * nx - f_t * ny), scale * (f_n * ny + f_t * nx)

    return force


def _shear(case: BearingCase, x: float, y: float) -> float:
    """Friction torque of a full film [N m]: Sommerfeld's shear, and the couple of force and eccentricity."""
    petroff = 2.0 * math.pi / math.sqrt(1.0 - x * x - y * y) * case.viscosity * case.speed
    pressed = 0.5 * case.load * case.clearance * y
    return petroff * case.radius**3 * case.length / case.clearance + pressed
