"""Runs of ``docs/make_transient_film.py``: films with history beside the quasi-static maps, of a bearing and of the press."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import make_press_films as press
import numpy as np
from scipy.interpolate import CubicSpline

import linkages
from linkages.laws.film.film_map import MapCase
from linkages.laws.film.map_cache import load_map
from linkages.laws.film.map_table import mapped_film
from linkages.laws.film.surface import Groove
from linkages.laws.film.surface.balance import Thickness
from linkages.laws.film.surface.surface_film import solve_film
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.laws.film.surface.transient import Bearing, Journal, Moment, at_rest, filling_time, follow, move
from linkages.laws.viscosity import iso_vg_viscosity
from linkages.results.steady_state import common_period

CELLS = (48, 4)  # around, and along half the length
FREQUENCIES = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0)  # over the angular velocity of the journal
SWING_STEPS = 80  # at least, in a period of an oscillation
STEPS, TURNS = 160, 12  # of the press, in a turn of the crank
STROKES = 1.0  # of the press, in a second
#: Joint A: radial clearance and radius [m], viscosity [Pa s], mass that moves with the journal [kg], link 2.
CLEARANCE, RADIUS, VISCOSITY, MASS = 0.3e-3, 0.015, iso_vg_viscosity(460, press.SUPPLY), 0.219


class Swing(NamedTuple):
    """A bearing whose journal oscillates about a place, along the eccentricity or around the bearing."""

    name: str
    slenderness: float
    grooves: tuple[float, ...]  # angles [deg]; the load acts at 0
    ratio: float  # eccentricity ratio of the place
    attitude: float  # [rad]
    radial: float  # amplitudes: eccentricity ratio, and attitude [rad]
    around: float

    @property
    def feed(self) -> tuple[Groove, ...]:
        """Grooves of 20 degrees and 80 % of the length."""
        return tuple(Groove(math.radians(angle), math.radians(20.0), 0.8) for angle in self.grooves)

    def place(self, phase: float) -> tuple[float, float]:
        """Place of the journal."""
        ratio, angle = (self.ratio + self.radial * math.sin(phase)), self.attitude + self.around * math.sin(phase)
        return ratio * math.cos(angle), ratio * math.sin(angle)

    def velocity(self, phase: float, frequency: float) -> tuple[float, float]:
        """Velocity of the journal's centre."""
        ratio, angle = (self.ratio + self.radial * math.sin(phase)), self.attitude + self.around * math.sin(phase)
        out, across = (frequency * math.cos(phase) * part for part in (self.radial, ratio * self.around))
        return out * math.cos(angle) - across * math.sin(angle), out * math.sin(angle) + across * math.cos(angle)


SWINGS = (
    Swing("L/D 1, groove opposite the load, e/c 0.5 ± 0.1", 1.0, (180.0,), 0.5, 0.9, 0.1, 0.0),
    Swing("the same, attitude ± 17 degrees", 1.0, (180.0,), 0.5, 0.9, 0.0, 0.3),
    Swing("L/D 0.5, groove opposite the load, e/c 0.7 ± 0.1", 0.5, (180.0,), 0.7, 0.6, 0.1, 0.0),
    Swing("L/D 1, groove at -90 degrees, e/c 0.4 ± 0.1", 1.0, (-90.0,), 0.4, 1.0, 0.1, 0.0),
    Swing("L/D 1, grooves at ± 90 degrees, e/c 0.5 ± 0.1", 1.0, (90.0, -90.0), 0.5, 0.9, 0.1, 0.0),
)


def mapped_force(
    table: Any, place: tuple[float, float], velocity: tuple[float, float], speed: float, groove: float
) -> tuple[float, float]:
    """Force on the journal of the map, in units of the film on the surface."""
    ratio, angle = math.hypot(*place), math.atan2(place[1], place[0])
    x, y = math.cos(angle), math.sin(angle)
    out, across = velocity[0] * x + velocity[1] * y, velocity[1] * x - velocity[0] * y
    f_n, f_t, _ = mapped_film(ratio, out, ratio * speed - 2.0 * across, angle - groove, table, False)
    unit = 2.0 * table[1]
    return unit * (f_n * x - f_t * y), unit * (f_n * y + f_t * x)


def swing(case: Swing, frequency: float, table: Any) -> dict[str, float]:
    """Compare the forces over the last period of an oscillation."""
    film = Bearing(surface_mesh(case.slenderness, case.feed, around=CELLS[0], along=CELLS[1]), case.feed)
    period = 2.0 * math.pi / frequency
    steps, periods = max(SWING_STEPS, int(period / 0.5)), max(2, math.ceil(40.0 / period))
    times = period / steps * np.arange(1, steps * periods + 1)
    orbit = ((time, case.place(frequency * time), 1.0) for time in times)
    found = [(m.time, m.place, m.force) for m in follow(film, at_rest(film, case.place(0.0)), orbit)][-steps:]
    groove = case.feed[0].angle
    quasi = [mapped_force(table, at, case.velocity(frequency * t, frequency), 1.0, groove) for t, at, _ in found]
    real = np.array([force for *_, force in found])
    steady = solve_film(film.mesh, Thickness(*case.place(0.0)), case.feed)
    return {
        "frequency": frequency,
        "number": frequency * filling_time(steady),
        "error": float(np.hypot(*(real - quasi).T).max() / np.hypot(*real.T).max()),
    }


class JointMotion(NamedTuple):
    """Motion of the journal of joint A in the frame of its bearing over the last period, in the units of the film."""

    time: Any  # in units of 1/speed, from 0 to 2 pi
    place: Any  # (2, n), units of the clearance
    force: Any  # (2, n), of the film on the journal
    speed: Any  # of the journal relative to the bearing


def joint_motion(strokes: float) -> JointMotion:
    """Run the press with the map, and turn the motion in A into the frame of the crank, which carries the bearing."""
    rate = 2.0 * math.pi * strokes
    found = press.study("groove, mass-conserving", strokes)
    system, period = found.system, common_period(found.system)
    names = ["A.ex", "A.ey", "A.fx", "A.fy", "link2.x", "link2.y", "link2_C.x", "link2_C.y"]
    run = linkages.simulate(system, outputs=names)
    assert period is not None
    assert run.evaluate is not None
    time = np.linspace(float(run.time[-1]) - period, float(run.time[-1]), 721)
    columns = run.evaluate(time)
    angle = np.unwrap(np.arctan2(columns["link2_C.y"] - columns["link2.y"], columns["link2_C.x"] - columns["link2.x"]))
    cos, sin = np.cos(rate * time), np.sin(rate * time)

    def seen(x: Any, y: Any) -> Any:
        return np.array([cos * x + sin * y, cos * y - sin * x])

    unit = VISCOSITY * rate * RADIUS**4 / CLEARANCE**2
    return JointMotion(
        rate * (time - time[0]),
        seen(columns["A.ex"], columns["A.ey"]) / CLEARANCE,
        seen(columns["A.fx"], columns["A.fy"]) / unit,
        CubicSpline(time, angle)(time, 1) / rate - 1.0,
    )


def press_joint(strokes: float) -> dict[str, Any]:
    """Move the journal of A with its history under the film force of the run."""
    motion = joint_motion(strokes)
    groove = Groove(0.0, math.radians(20.0), 0.8)
    film = Bearing(surface_mesh(4.0 / 3.0, (groove,), around=CELLS[0], along=CELLS[1]), (groove,))
    turn = 2.0 * math.pi

    def curve(values: Any) -> Any:
        return CubicSpline(
            motion.time, np.concatenate([values[..., :-1], values[..., :1]], axis=-1), axis=-1, bc_type="periodic"
        )

    place, force, speed = (curve(values) for values in (motion.place, motion.force, motion.speed))
    times = turn / STEPS * np.arange(1, STEPS * TURNS + 1)
    start = at_rest(film, tuple(place(0.0)))
    along = [m.force for m in follow(film, start, ((t, tuple(place(t % turn)), float(speed(t % turn))) for t in times))]
    mass = MASS * CLEARANCE**3 * 2.0 * math.pi * strokes / (VISCOSITY * RADIUS**4)
    load = curve(mass * place(motion.time, 2) - motion.force)
    journal = Journal(mass, lambda t: tuple(load(t % turn)), lambda t: float(speed(t % turn)))
    every = list(move(film, start, journal, times))
    moved = every[-STEPS:]
    largest = [max(math.hypot(*m.place) for m in every[k * STEPS : (k + 1) * STEPS]) for k in range(TURNS)]
    found = {
        "map": place(times[-STEPS:] % turn).T,
        "history": [m.place for m in moved],
        "force": force(times[-STEPS:] % turn).T,
        "force_along": along[-STEPS:],
        "turns": largest,
        "content": [_mean_content(film, m) for m in moved],
        "filling": [_filling_time(film, tuple(place(t))) for t in times[: STEPS : STEPS // 10]],
    }
    return {key: np.round(values, 6).tolist() for key, values in found.items()}


def _filling_time(film: Bearing, place: tuple[float, float]) -> float:
    """Return the filling time of a steady film: the journal turns backwards in the crank, which carries the bearing."""
    return filling_time(solve_film(film.mesh, Thickness(*place), film.grooves, speed=-0.5))


def _mean_content(film: Bearing, moment: Moment) -> float:
    assert moment.film is not None
    free = film.mesh.groove < 0
    return float(moment.film.content[free].mean())


def measure() -> dict[str, Any]:
    """Measure all orbits."""
    swings = {}
    for case in SWINGS:
        print(case.name, flush=True)
        table = load_map(MapCase(case.slenderness, "mass-conserving", case.feed))
        swings[case.name] = [swing(case, frequency, table) for frequency in FREQUENCIES]
    print("press", flush=True)
    return {"swings": swings, "press": press_joint(STROKES)}
