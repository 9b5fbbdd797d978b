"""Film with history: the film content is part of the state, along a given orbit or with the motion of a loaded journal.

A step of time is one solution of the film: the oil that a cell gains over the step is what flows in (implicit Euler),
and pressure and missing content exclude each other. So each step conserves the volume of oil to round-off, and may be
long compared with the time constants of the film. The error is of first order in the step.

The frame is the bearing's; speeds of the journal are relative to the bearing. Units: time 1/omega, mass
mu*R^4/(c^3*omega), others as in `linkages.laws.film.surface.surface_film`; omega is any reference angular velocity.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array
from linkages.laws.film.surface.balance import Thickness, cell_volumes
from linkages.laws.film.surface.equilibrium import balanced
from linkages.laws.film.surface.surface_film import FilmSurface, SurfaceFilm, oil_volumes, solve_film

InPlane = tuple[float, float]


class Moment(NamedTuple):
    """State of film and journal at a time; made by `at_rest`, `follow` and `move`.

    Attributes
    ----------
    time : float
        In units of 1/omega.
    place : (float, float)
        Eccentricity along x and y, in units of the clearance.
    velocity : (float, float)
        Velocity of the journal's centre, in units of clearance times omega.
    oil : (n, m) array
        Volume of oil in the cells.
    film : SurfaceFilm or None
        None at the start, where the pressure is not computed.
    """

    time: float
    place: InPlane
    velocity: InPlane
    oil: Array
    film: SurfaceFilm | None = None

    @property
    def force(self) -> InPlane:
        """Force of the film on the journal; zero at the start."""
        return (0.0, 0.0) if self.film is None else self.film.force


class Journal(NamedTuple):
    """A rigid journal that a load moves.

    Attributes
    ----------
    mass : float
        Not negative; a journal without mass follows the balance of load and film.
    load : callable
        Time -> force on the journal along x and y.
    speed : callable
        Time -> angular velocity of the journal relative to the bearing.
    """

    mass: float
    load: Callable[[float], InPlane]
    speed: Callable[[float], float]


def at_rest(bearing: FilmSurface, place: InPlane, content: float | Array = 1.0) -> Moment:
    """Start from a given film content, a number or an (n, m) array in [0, 1]."""
    volumes = cell_volumes(bearing.mesh, Thickness(*place))
    return Moment(0.0, place, (0.0, 0.0), np.where(bearing.mesh.groove < 0, content, 1.0) * volumes)


def follow(bearing: FilmSurface, start: Moment, orbit: Iterable[tuple[float, InPlane, float]]) -> Iterator[Moment]:
    """Solve the film along a given orbit.

    Parameters
    ----------
    bearing : FilmSurface
    start : Moment
        From `at_rest`, or the last one of another motion.
    orbit : iterable of (float, (float, float), float)
        Times after the start, places of the journal, and its speeds in units of omega.

    Yields
    ------
    Moment
        At each time of the orbit.

    Raises
    ------
    ValueError
        If the journal touches the bearing, or the times do not increase.

    Examples
    --------
    >>> import math
    >>> from linkages.laws.film.surface import FilmSurface, Groove, at_rest, follow, surface_mesh
    >>> grooves = (Groove(math.pi, 0.35, 0.8),)
    >>> bearing = FilmSurface(surface_mesh(1.0, grooves, around=36, along=4), grooves)
    >>> orbit = [(0.1 * k, (0.5 * math.cos(0.02 * k), 0.5 * math.sin(0.02 * k)), 1.0) for k in range(1, 101)]
    >>> forces = [moment.force for moment in follow(bearing, at_rest(bearing, (0.5, 0.0)), orbit)]
    """
    state = start
    for time, place, speed in orbit:
        state = _step(bearing, state, time, place, speed)
        yield state


def move(bearing: FilmSurface, start: Moment, journal: Journal, times: Iterable[float]) -> Iterator[Moment]:
    """Integrate the motion of a loaded journal together with its film (implicit Euler).

    Parameters
    ----------
    bearing, start
        As for `follow`; the start gives place and velocity.
    journal : Journal
    times : iterable of float
        Ends of the steps.

    Yields
    ------
    Moment

    Raises
    ------
    ValueError
        If the times do not increase.
    ArithmeticError
        If a step does not converge: shorten it.
    """
    state, slope = start, None
    for time in times:
        state, slope = _moved(bearing, state, journal, time, slope)
        yield state


def filling_time(film: SurfaceFilm) -> float:
    """Time in which the inflow from the grooves would fill the cavity of a steady film, in units of 1/omega.

    Infinite where no oil flows in. A motion that hardly changes over this time has the content of a steady film.
    """
    missing = cell_volumes(film.mesh, film.thickness) - oil_volumes(film)
    inflow = sum(flow for flow in film.groove_flow if flow > 0.0)
    sides = 2.0 if film.mesh.half else 1.0
    return sides * float(missing.sum()) / inflow if inflow > 0.0 else float("inf")


def _step(bearing: FilmSurface, before: Moment, time: float, place: InPlane, speed: float) -> Moment:
    """Solve the film at a place of the journal after `before`."""
    past = time - before.time
    if not past > 0.0:
        raise ValueError(f"time {time:g}: must be above the one before, {before.time:g}")
    guess = None if before.film is None else before.film.solution
    film = solve_film(bearing, Thickness(*place), speed=0.5 * speed, guess=guess, history=(before.oil, past))
    velocity = (place[0] - before.place[0]) / past, (place[1] - before.place[1]) / past
    return Moment(time, place, velocity, oil_volumes(film), film)


def _moved(
    bearing: FilmSurface, before: Moment, journal: Journal, time: float, slope: Array | None
) -> tuple[Moment, Array]:
    """Solve one step for the place, from a guess of the Jacobian."""
    past, load, speed = time - before.time, np.array(journal.load(time)), journal.speed(time)
    found = before

    def residual(x: float, y: float) -> Array:
        nonlocal found
        found = _step(bearing, before, time, (x, y), speed)
        return load + found.force - journal.mass * (np.array(found.velocity) - before.velocity) / past

    try:
        _, slope = balanced(residual, lambda x, y: 1.0 - math.hypot(x, y), before.place, slope)
    except ArithmeticError:
        raise ArithmeticError(f"film: the step to time {time:g} did not converge; shorten it") from None
    return found, slope
