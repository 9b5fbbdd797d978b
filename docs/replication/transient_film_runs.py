"""Runs of ``docs/make_transient_film.py``: films with history beside the quasi-static maps, of a bearing and of the press."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import make_press_films as press
import numpy as np

import linkages
from linkages.laws.film.film_map import MapCase, load_map
from linkages.laws.film.map_table import mapped_film
from linkages.laws.film.surface import Groove
from linkages.laws.film.surface.balance import Thickness
from linkages.laws.film.surface.surface_film import FilmSurface, solve_film
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.laws.film.surface.transient import at_rest, filling_time, follow
from linkages.laws.viscosity import iso_vg_viscosity

CELLS = (48, 4)  # around, and along half the length
FREQUENCIES = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0)  # over the angular velocity of the journal
SWING_STEPS = 80  # at least, in a period of an oscillation
STEPS, TURNS = 160, 12  # of the press: points in a turn of the crank, and turns
STROKES = 1.0  # of the press, in a second
PRESSURES = (0.0, 2e4)  # of the supply of joint A [Pa]
ACCURACIES = (1e-2, 1e-3)  # of the film step, beside the default
ALONG_STEP = 1.25e-3  # constant film step of the run whose orbit `follow` repeats [s]
MESHES = ((72, 6), (96, 8))  # beside CELLS
#: Joint A: radial clearance and radius [m], viscosity [Pa s].
CLEARANCE, RADIUS, VISCOSITY = 0.3e-3, 0.015, iso_vg_viscosity(460, press.SUPPLY)


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
    film = FilmSurface(surface_mesh(case.slenderness, case.feed, around=CELLS[0], along=CELLS[1]), case.feed)
    period = 2.0 * math.pi / frequency
    steps, periods = max(SWING_STEPS, int(period / 0.5)), max(2, math.ceil(40.0 / period))
    times = period / steps * np.arange(1, steps * periods + 1)
    orbit = ((time, case.place(frequency * time), 1.0) for time in times)
    found = [(m.time, m.place, m.force) for m in follow(film, at_rest(film, case.place(0.0)), orbit)][-steps:]
    groove = case.feed[0].angle
    quasi = [mapped_force(table, at, case.velocity(frequency * t, frequency), 1.0, groove) for t, at, _ in found]
    real = np.array([force for *_, force in found])
    steady = solve_film(film, Thickness(*case.place(0.0)))
    return {
        "frequency": frequency,
        "number": frequency * filling_time(steady),
        "error": float(np.hypot(*(real - quasi).T).max() / np.hypot(*real.T).max()),
    }


class JointMotion(NamedTuple):
    """Motion of the journal of joint A in the frame of its bearing, in the units of the film."""

    time: Any  # in units of 1/speed, from 0
    place: Any  # (2, n), units of the clearance
    force: Any  # (2, n), of the film on the journal
    speed: Any  # of the journal relative to the bearing


def seen_from_crank(run: linkages.Trajectory, time: Any) -> JointMotion:
    """Turn the motion in A over these times into the frame of the crank, which carries the bearing."""
    rate = 2.0 * math.pi * STROKES
    assert run.evaluate is not None
    columns = run.evaluate(time)
    cos, sin = np.cos(rate * time), np.sin(rate * time)

    def seen(x: Any, y: Any) -> Any:
        return np.array([cos * x + sin * y, cos * y - sin * x])

    unit = VISCOSITY * rate * RADIUS**4 / CLEARANCE**2
    return JointMotion(
        rate * (time - time[0]),
        seen(columns["A.ex"], columns["A.ey"]) / CLEARANCE,
        seen(columns["A.fx"], columns["A.fy"]) / unit,
        columns["link2.omega"] / rate - 1.0,
    )


def press_film(pressure: float) -> FilmSurface:
    """Return the film of A with a supply pressure [Pa]."""
    unit = VISCOSITY * 2.0 * math.pi * STROKES * (RADIUS / CLEARANCE) ** 2
    groove = Groove(0.0, math.radians(20.0), 0.8, pressure / unit)
    return FilmSurface(surface_mesh(4.0 / 3.0, (groove,), around=CELLS[0], along=CELLS[1]), (groove,))


def press_run(turns: int, pressure: float = 0.0, history: dict[str, Any] | None = None) -> linkages.Trajectory:
    """Run the press with the groove in A and B; A has a history, or the map if none is given."""
    values: dict[str, Any] = {"joints.A.groove.pressure": pressure}
    if history is not None:
        values["joints.A.history"] = history
    system = press.system("groove, mass-conserving", STROKES).replaced(values | {"duration": turns / STROKES})
    names = ["A.ex", "A.ey", "A.fx", "A.fy", "A.force", "A.eccentricity_ratio", "link2.omega"]
    return linkages.simulate(system, outputs=[*names, "A.film_content"] if history is not None else names)


def each_turn(run: linkages.Trajectory, name: str, turns: int) -> list[float]:
    """Largest value of an output in each turn of the crank."""
    parts = (run.within(k / STROKES, (k + 1) / STROKES) for k in range(turns))
    return [float(linkages.extremes(part, [name])[name].peak) for part in parts]


def press_row(pressure: float, history: dict[str, Any]) -> dict[str, Any]:
    """Compute one run with history: numbers of each turn, content at its end, the journal in the last one."""
    run = press_run(TURNS, pressure, history)
    assert run.status is linkages.Status.OK
    assert run.evaluate is not None
    content = run.evaluate(np.arange(TURNS + 1) / STROKES)["A.film_content"]
    motion = seen_from_crank(run, (TURNS - 1 + np.arange(STEPS + 1) / STEPS) / STROKES)
    return {
        "ratio": each_turn(run, "A.eccentricity_ratio", TURNS),
        "force": each_turn(run, "A.force", TURNS),
        "content": content.tolist(),
        "place": motion.place.T.tolist(),
    }


def along_the_orbit(run: linkages.Trajectory, pressure: float, turns: int, steps: int) -> dict[str, float]:
    """Compare the force of a run with the one of `follow` along its orbit, by steps of the crank; the first is left out."""
    film, times = press_film(pressure), np.arange(steps * turns + 1) / (steps * STROKES)
    motion = seen_from_crank(run, times)
    orbit = ((motion.time[k], tuple(motion.place[:, k]), float(motion.speed[k])) for k in range(1, len(times)))
    found = np.array([moment.force for moment in follow(film, at_rest(film, tuple(motion.place[:, 0])), orbit)])
    apart = np.hypot(*(found - motion.force[:, 1:].T)[steps // 10 :].T)
    largest = np.hypot(*motion.force[:, steps // 10 :]).max()
    return {"largest": float(apart.max() / largest), "rms": float(np.sqrt(np.mean(apart**2)) / largest)}


def press_joint() -> dict[str, Any]:
    """Run the press with the map, and with the history of the film in A for supply pressures, accuracies of the film step and meshes."""
    times = (TURNS - 1 + np.arange(STEPS + 1) / STEPS) / STROKES
    maps = {pressure: seen_from_crank(press_run(TURNS, pressure), times).place for pressure in PRESSURES}
    usual = {"cells": list(CELLS)}
    first = press_run(2, 0.0, usual | {"step": ALONG_STEP})
    found = {
        "maps": {f"{pressure:g}": place.T.tolist() for pressure, place in maps.items()},
        "filling": [_filling_time(press_film(0.0), tuple(maps[0.0][:, k])) for k in range(0, STEPS, STEPS // 10)],
        "runs": {f"{pressure:g}": press_row(pressure, usual) for pressure in PRESSURES},
        "accuracies": {f"{value:g}": press_row(0.0, usual | {"accuracy": value}) for value in ACCURACIES},
        "meshes": {f"{around} x {along}": press_row(0.0, {"cells": [around, along]}) for around, along in MESHES},
        "along": along_the_orbit(first, 0.0, 1, 1600),
    }
    return _rounded(found)


def _rounded(values: Any) -> Any:
    if isinstance(values, dict):
        return {key: _rounded(value) for key, value in values.items() if key != "place"} | (
            {"place": np.round(values["place"], 5).tolist()} if "place" in values else {}
        )
    return np.round(values, 6).tolist()


def _filling_time(film: FilmSurface, place: tuple[float, float]) -> float:
    """Return the filling time of a steady film: the journal turns backwards in the crank, which carries the bearing."""
    return filling_time(solve_film(film, Thickness(*place), speed=-0.5))


def compute() -> dict[str, Any]:
    """Compute all orbits."""
    swings = {}
    for case in SWINGS:
        print(case.name, flush=True)
        table = load_map(MapCase(case.slenderness, "mass-conserving", case.feed))
        swings[case.name] = [swing(case, frequency, table) for frequency in FREQUENCIES]
    return {"swings": swings, "press": press_joint()}
