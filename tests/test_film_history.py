"""A film whose content is part of the state of a machine: static film, loaded journal, given orbit, balance, refusals."""

import math

import numpy as np
import pytest
from joint_records import joint as record
from machines import BEARING, joint, model, rotor_in_block, solid

import linkages
from linkages.explore.flow import Flow
from linkages.explore.wear.measure import check_wears
from linkages.laws.film.film_history import (
    MISSING,
    PLACE_X,
    PLACE_Y,
    history_force,
    history_table,
    mean_content,
    memory_of,
    remembered_cells,
    solve_history,
)
from linkages.laws.film.film_steps import advance_film, start_film
from linkages.laws.film.surface import FilmSurface, Groove, Journal, at_rest, follow, move, surface_mesh
from linkages.laws.film.surface.balance import Thickness, make_balance
from linkages.laws.film.surface.surface_film import outflows, solve_film
from linkages.results.peak_errors import errors
from linkages.results.trajectory import sample
from linkages.show.live.session import Session

CELLS = (36, 4)
GROOVES = (Groove(math.pi, math.radians(20.0), 0.8),)


class Film:
    """One film along a motion in its own units, for a journal of speed 1 unless another one is given."""

    def __init__(self, grooves=GROOVES, step=0.1, place=(0.5, 0.0), content=1.0, slenderness=1.0):
        self.supply = max((groove.pressure for groove in grooves), default=0.0)
        self.table = history_table(slenderness, grooves, CELLS, step, content)
        self.oil, self.time = np.zeros(memory_of(self.table)), 0.0
        self.joint = record(clearance=1.0, radius=1.0, viscosity=1.0, supply_pressure=self.supply)
        start_film(self.joint, self.table, self.oil, 0.0, *place, 0.0, True)

    @property
    def cells(self):
        return remembered_cells(len(self.oil))

    @property
    def missing(self):
        return self.oil[MISSING : MISSING + self.cells]

    def go(self, time, place, speed=1.0):
        advance_film(self.joint, self.table, self.oil, time, *place, 0.0, 0.0, 0.0, speed, 0.0)

    def force(self, place, velocity=(0.0, 0.0), speed=1.0):
        return solve_history(self.table, self.oil, *place, *velocity, speed, self.supply)


def swinging(t, frequency=0.5):
    """Place and velocity of a journal that swings about an eccentricity ratio of 0.5."""
    ratio, rate = 0.5 + 0.1 * math.sin(frequency * t), 0.1 * frequency * math.cos(frequency * t)
    x, y = math.cos(0.9), math.sin(0.9)
    return (ratio * x, ratio * y), (rate * x, rate * y)


@pytest.mark.parametrize(
    "grooves",
    [
        GROOVES,
        (Groove(math.pi, 0.35, 0.8, 2.0), Groove(-1.0, 0.3, 0.4, 1.0, 0.2, True)),  # fed; over the full length
        (Groove(-1.6, 0.35), Groove(1.6, 0.35)),
    ],
    ids=["plain", "fed hole", "two"],
)
@pytest.mark.parametrize("place", [(0.3, 0.4), (-0.1, 0.85)])
def test_at_a_place_it_becomes_the_steady_film(grooves, place):
    """The film of `linkages bearing` on the same mesh."""
    film = Film(grooves, step=0.5, place=place)
    for k in range(1, 1200):
        film.go(0.5 * k, place)
    fx, fy, shear, flow = film.force(place)
    mesh = surface_mesh(1.0, grooves, around=CELLS[0], along=CELLS[1])
    steady = solve_film(FilmSurface(mesh, grooves), Thickness(*place))
    assert (fx, fy) == pytest.approx(steady.force, abs=1e-6 * math.hypot(*steady.force))
    assert shear == pytest.approx(steady.shear, rel=1e-5)
    assert flow == pytest.approx(steady.end_flow, rel=1e-5)


def test_along_an_orbit_it_is_the_transient_film_to_first_order():
    """`follow` solves implicit steps; half the film step has half the deviation."""
    grooves = (GROOVES[0]._replace(pressure=2.0),)
    bearing = FilmSurface(surface_mesh(1.0, grooves, around=CELLS[0], along=CELLS[1]), grooves)
    times = np.arange(1, 2401) * 0.0125
    orbit = ((t, swinging(t)[0], 1.0) for t in times)
    exact = [moment.force for moment in follow(bearing, at_rest(bearing, swinging(0.0)[0]), orbit)]
    errors = []
    for step in (0.4, 0.2, 0.1):
        film, found = Film(grooves, step, swinging(0.0)[0]), []
        for t in np.arange(1, round(30.0 / step) + 1) * step:
            film.go(t, swinging(t)[0])
            found.append(film.force(*swinging(t))[:2])
        wanted = np.array(exact)[round(step / 0.0125) - 1 :: round(step / 0.0125)]
        late = len(found) // 2
        errors.append(np.linalg.norm((np.array(found) - wanted)[late:]) / np.linalg.norm(wanted[late:]))
    assert errors[0] < 0.08
    assert errors[1] < 0.65 * errors[0]
    assert errors[2] < 0.65 * errors[1]


def test_oil_is_balanced_and_stays_between_nothing_and_the_gap():
    """The oil in a closed ring changes by the flow out of its ends; random motions, steps and contents."""
    rng = np.random.default_rng(5)
    film = Film(step=0.3, place=(0.2, 0.1), content=0.7)
    mesh = surface_mesh(1.0, GROOVES, around=CELLS[0], along=CELLS[1])
    free = (mesh.groove < 0).ravel()
    place, time = np.array([0.2, 0.1]), 0.0

    def gaps(at):
        sines, cosines = np.diff(np.sin(mesh.faces)), -np.diff(np.cos(mesh.faces))
        return ((mesh.width - at[0] * sines - at[1] * cosines)[:, None] * mesh.height).ravel()

    for _ in range(300):
        oil = gaps(place)[free].sum() - film.missing[free].sum()
        new = place + 0.05 * rng.normal(size=2)
        new *= min(1.0, 0.9 / np.hypot(*new))
        h, speed = 0.3 * rng.random(), rng.normal()
        before = film.oil.copy()
        film.go(time + h, tuple(new), speed)
        place, time = new, time + h
        rate = (new - before[[PLACE_X, PLACE_Y]]) / h
        again, film.oil = film.oil, before  # the same solution gives the flows
        _, _, _, flow = film.force(tuple(new), tuple(rate), speed)
        film.oil = again
        fed = groove_inflow(mesh, film, again, new, speed)
        gained = gaps(new)[free].sum() - film.missing[free].sum() - oil
        assert gained == pytest.approx(h * (fed - 0.5 * flow), abs=1e-11)  # of half the bearing
        assert (film.missing >= 0.0).all()
        assert (film.missing <= gaps(new) * (1.0 + 1e-12)).all()
        assert 0.0 <= mean_content(film.table, film.oil, *new) <= 1.0


def groove_inflow(mesh, film, oil, place, speed):
    """Flow from the grooves into the film of the last solution, by the balance of `linkages.laws.film.surface`."""
    balance = make_balance(mesh, Thickness(*place), speed=0.5 * speed)
    last = oil[MISSING + film.cells :].reshape(mesh.groove.shape)
    out, _ = outflows(balance, 0.0, np.maximum(last, 0.0), 1.0 + np.minimum(last, 0.0))
    return float(out[mesh.groove >= 0].sum())


def test_the_force_is_passive_for_any_content():
    """The power in the frame of the mean surface velocity is not positive without supply pressure."""
    rng = np.random.default_rng(2)
    for _ in range(300):
        angle, ratio = rng.uniform(0.0, 2.0 * math.pi), 0.95 * rng.random()
        x, y = ratio * math.cos(angle), ratio * math.sin(angle)
        film = Film(place=(x, y), content=1.0)
        film.missing[:] *= 0.0
        gap = Film(place=(x, y), content=0.0).missing
        film.missing[:] = gap * rng.random(len(gap)) ** 3 * rng.integers(0, 2, len(gap))
        speed, (vx, vy) = rng.normal(), rng.normal(size=2)
        fx, fy, _, _ = film.force((x, y), (vx, vy), speed)
        power = fx * (vx + 0.5 * speed * y) + fy * (vy - 0.5 * speed * x)
        assert power <= 1e-10 * math.hypot(fx, fy)


def test_no_result_depends_on_the_guess():
    film = Film(place=(0.6, 0.2), content=0.8)
    found = []
    for seed in range(4):
        film.oil[MISSING + film.cells :] = np.random.default_rng(seed).normal(size=film.cells)
        found.append(film.force((0.6, 0.2), (0.3, -1.0)))
    assert found == [found[0]] * 4


SPEED, LOAD, CLEARANCE, VISCOSITY = 200.0, 60.0, 5e-5, 0.03
TOML = f"""duration = 0.3
drives.O = {{speed = {SPEED}}}
forces.F = {{point = "block", force = [0.0, {LOAD}]}}
solver.accuracy = 1e-6
[joints.A]
model = "lubricated"
clearance = {CLEARANCE}
viscosity = {VISCOSITY}
film = "finite"
cavitation = "mass-conserving"
groove = {{angle = "90 deg", extent = "20 deg", length = 0.8}}
history = {{cells = [36, 4]}}
"""
RADIUS = 0.01


@pytest.fixture
def rotor(system_of):
    return lambda overrides=None, **options: system_of(rotor_in_block(**options), TOML, overrides)


def test_the_force_does_not_depend_on_the_observer(rotor):
    """Another angle of the plane turns the force; a frame that turns leaves it as it is."""
    system = rotor()
    law, table = system.laws[0], system.tables[0]
    oil = np.zeros(memory_of(table))
    start_film(law, table, oil, 0.0, 0.3 * CLEARANCE, 0.2 * CLEARANCE, 0.0, True)
    e, v, wb, wj, angle = np.array([1.5e-5, 1e-5]), np.array([2e-3, -3e-3]), 30.0, 200.0, 0.4
    force = np.array(history_force(law, table, oil, *e, *v, wb, wj, angle))
    turn, spin = 1.1, 70.0
    matrix = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    moved = v + spin * np.array([-e[1], e[0]])
    found = history_force(law, table, oil, *(matrix @ e), *(matrix @ moved), wb + spin, wj + spin, angle + turn)
    assert found[:2] == pytest.approx(matrix @ force[:2], rel=1e-9)
    assert found[2:] == pytest.approx(force[2:], rel=1e-9)


def test_a_rotor_reaches_the_place_of_the_static_bearing(rotor):
    """The load on the journal points along -y, so that the axes of the static bearing are (-y, x)."""
    run = linkages.simulate(rotor({"duration": 0.5}))
    assert run.status is linkages.Status.OK
    grooves = (Groove(math.pi, math.radians(20.0), 0.8),)
    point = linkages.bearing(
        0.02, 0.02, CLEARANCE, VISCOSITY, SPEED, LOAD, cavitation="mass-conserving", grooves=grooves, cells=(36, 4)
    )
    place = -run["A.ey"][-1] / CLEARANCE, run["A.ex"][-1] / CLEARANCE
    assert place == pytest.approx((point.x, point.y), abs=5e-3)
    assert run["A.flow"][-1] == pytest.approx(point.content["flow"], rel=0.01)
    assert run["A.friction_torque"][-1] == pytest.approx(-point.content["friction_torque"], rel=0.01)
    assert 0.5 < run["A.film_content"][-1] < run["A.film_content"][0] == 1.0


#: The rotor's drive acts in the bearing itself.
DRIVEN = (
    model("driven", solid("rotor", 0.05, 1e-5) + joint("O", "world", "rotor", inner=BEARING)),
    TOML.replace("joints.A", "joints.O").replace('"block"', '"rotor"').replace(f"{LOAD}]", f"{-LOAD}]"),
)


@pytest.mark.parametrize("case", ["driven", "block", pytest.param("turning", marks=pytest.mark.slow)])
def test_a_rotor_moves_as_the_independent_loaded_journal(rotor, system_of, case):
    """`move` integrates one journal with its film by implicit Euler steps, here extrapolated from two step sizes.

    A bearing on the rotor sees a load that turns, and a journal that turns backwards. The deviation of the run is of
    first order in its film step.
    """
    turning, pin = case == "turning", "O" if case == "driven" else "A"
    ends = {"outer": "rotor", "inner": "block"} if turning else {}
    grooves = (Groove(0.5 * math.pi, math.radians(20.0), 0.8),)
    bearing = FilmSurface(surface_mesh(1.0, grooves, around=24, along=3), grooves)
    size, spin = LOAD / (VISCOSITY * SPEED * RADIUS**4 / CLEARANCE**2), -1.0 if turning else 1.0
    mass = 0.05 * CLEARANCE**3 * SPEED / (VISCOSITY * RADIUS**4)

    def load(t):
        return (size * math.sin(t), size * math.cos(t)) if turning else (0.0, -size)

    def places(count):
        times = np.arange(1, count + 1) * (0.03 * SPEED / count)
        start, journal = at_rest(bearing, (0.0, 0.0)), Journal(mass, load, lambda t: spin)
        return np.array([moment.place for moment in move(bearing, start, journal, times)])

    times = np.arange(1, 151) * (0.03 * SPEED / 150)  # a revolution
    exact = (2.0 * places(300)[1::2] - places(150))[15:]
    errors = []
    for step in (4e-4, 2e-4, 1e-4):
        history = {"cells": [24, 3], "step": step}
        values = {"duration": 0.03, f"joints.{pin}.history": history}
        if case == "driven":
            system = system_of(*DRIVEN, values)
        else:
            system = rotor(values | {"sdf.links.carriage.mass": 1e-6}, **ends)
        found = linkages.simulate(system).evaluate(times / SPEED)
        x, y = found[f"{pin}.ex"] / CLEARANCE, found[f"{pin}.ey"] / CLEARANCE
        if turning:
            c, s = np.cos(times), np.sin(times)
            x, y = c * x + s * y, c * y - s * x
        errors.append(np.hypot(x[15:] - exact[:, 0], y[15:] - exact[:, 1]).max())
    assert errors[0] < 0.014  # of the clearance
    assert errors[1] < 0.65 * errors[0]
    assert errors[2] < 0.65 * errors[1]


TICKS = np.concatenate([-np.geomspace(1e-2, 50.0, 40), np.geomspace(1e-2, 50.0, 40)])  # times around a jump [ns]

#: A journal that crosses a cavity and hits the oil on its other side.
IMPACT = {"duration": 2e-4, "sdf.links.carriage.mass": 1e-6, "joints.A.history": {"content": 0.8, "cells": [24, 3]}}


@pytest.fixture(scope="module")
def impact_force():
    """Compute the peak of this impact by `move`, which integrates one journal by short implicit Euler steps [N]."""
    grooves = (Groove(0.5 * math.pi, math.radians(20.0), 0.8),)
    bearing = FilmSurface(surface_mesh(1.0, grooves, around=24, along=3), grooves)
    unit = VISCOSITY * SPEED * RADIUS**4 / CLEARANCE**2
    journal = Journal(
        0.05 * CLEARANCE**3 * SPEED / (VISCOSITY * RADIUS**4), lambda t: (0.0, -LOAD / unit), lambda t: 1.0
    )
    times = np.concatenate([np.linspace(0.0, 0.0255, 201)[1:], np.linspace(0.0255, 0.0268, 401)[1:]])
    start = at_rest(bearing, (0.0, 0.0), content=0.8)
    return unit * max(math.hypot(*moment.force) for moment in move(bearing, start, journal, times))


@pytest.mark.parametrize("engine", ["compiled", "drake"])
def test_a_journal_that_hits_the_oil_has_the_peak_of_the_independent_loaded_journal(rotor, impact_force, engine):
    """`move` has an error of 0.5 % with these steps, the run at the default accuracy one of 0.3 %."""
    run = linkages.simulate(rotor(IMPACT), engine)
    assert linkages.extremes(run, ["A.force"])["A.force"].peak == pytest.approx(impact_force, rel=0.01)


@pytest.mark.parametrize("step", [1.6e-4, 2e-5, 2e-6])
def test_the_stated_error_of_a_constant_film_step_contains_an_impact_that_it_misses(rotor, impact_force, step):
    """Half of each film step errs nearly as much: the longest one gives a twelfth of the force, its half a ninth."""
    assessment = linkages.assess(rotor(IMPACT | {"joints.A.history.step": step}))
    found = linkages.summarize(assessment)
    error, peak = found["error"]["A.force.peak"], found["joints"]["A"]["force"]["peak"]
    assert error is None or error >= abs(peak - impact_force) > 0.05 * impact_force
    (warning,) = [one for one in found["warnings"] if one["kind"] == "rough"]
    assert warning["remedy"].startswith("shorten joints.A.history.step, or leave it out")


def test_jumps_that_shift_in_time_are_no_error_of_a_peak():
    """A force of 100 N jumps by 10 N at each of 20 cells; in the other run 1 ns later, and 0.1 N higher."""
    times = np.unique(np.concatenate([np.linspace(0.0, 2e-5, 2001), *(1e-6 * (k + 1e-3 * TICKS) for k in range(20))]))

    def run(late, more):
        def evaluate(t):
            teeth = np.exp(-((t - late) % 1e-6) / 5e-7)
            return {"time": t, "A.force": (100.0 + more + 10.0 * teeth) * np.sin(np.pi * t / 2e-5)}

        return sample(times, evaluate, linkages.Status.OK, {})

    one, other = run(0.0, 0.0), run(1e-9, 0.1)
    peaks = [{"A.force.peak": float(each["A.force"].max())} for each in (one, other)]
    (stated,) = errors(one, other, *peaks, None, {"A.force": 0.0}, jagged=True).values()
    assert 0.1 < stated < 0.5


@pytest.mark.slow
def test_the_stated_error_contains_the_one_of_the_cells(rotor):
    """The same impact on four times as many cells in each direction, whose peak is 5 % off."""
    found = linkages.summarize(linkages.assess(rotor(IMPACT)))
    fine = linkages.simulate(rotor(IMPACT | {"joints.A.history": {"content": 0.8, "cells": [96, 12]}}))
    change = abs(found["joints"]["A"]["force"]["peak"] - linkages.extremes(fine, ["A.force"])["A.force"].peak)
    assert 0.02 * found["joints"]["A"]["force"]["peak"] < change <= found["error"]["A.force.peak"]


def test_a_warning_about_chosen_film_steps_names_their_accuracy(rotor):
    found = linkages.summarize(linkages.assess(rotor(IMPACT | {"joints.A.history.accuracy": 0.5})))
    (warning,) = [one for one in found["warnings"] if one["kind"] == "rough"]
    assert warning["remedy"].startswith(
        "reduce joints.A.history.accuracy; increase joints.A.history.cells; tighten solver"
    )


@pytest.mark.slow
def test_the_engines_agree(system_of):
    """Both are of first order in their steps, which are alike here."""
    history = {"cells": [24, 3], "step": 2e-4}
    values = {"duration": 1e-3, "joints.O.history": history, "solver.accuracy": 1e-8, "solver.max_step": 1e-6}
    times = np.linspace(0.0, 1e-3, 21)
    one, other = (linkages.simulate(system_of(*DRIVEN, values), name).evaluate(times) for name in ("compiled", "drake"))
    for name in ("O.ex", "O.ey"):
        np.testing.assert_allclose(one[name], other[name], rtol=0.0, atol=1e-6 * CLEARANCE)
    for name in ("O.fx", "O.fy"):
        np.testing.assert_allclose(one[name], other[name], rtol=0.0, atol=2e-5 * LOAD)
    np.testing.assert_allclose(one["O.torque"], other["O.torque"], rtol=1e-5)
    np.testing.assert_allclose(one["O.film_content"], other["O.film_content"], atol=1e-5)


@pytest.mark.slow
def test_the_map_moves_alike_where_its_rule_allows_it(rotor):
    """A load that changes slowly beside the filling time: places within 0.012 of the clearance.

    The maps of `linkages.laws.film.map_nodes` have another mesh, and count a part of the cavity as full.
    """
    formula = ["0", f"{LOAD} * (1 + 0.5 * sin(8 * t))"]
    values = {"forces.F": {"point": "block", "formula": formula}, "duration": 1.2}
    with_history = rotor(values)
    static = linkages.System(with_history.mechanism, with_history.experiment.replaced({"joints.A.history": None}))
    times = np.linspace(0.7, 1.2, 400)
    one, other = (linkages.simulate(system).evaluate(times) for system in (with_history, static))
    apart = np.hypot(one["A.ex"] - other["A.ex"], one["A.ey"] - other["A.ey"]).max()
    assert apart < 0.012 * CLEARANCE < 0.1 * np.ptp(one["A.ey"])


@pytest.mark.slow
def test_the_film_step_limits_the_error(rotor):
    """Half the film step has half the deviation; the error estimate of the summary contains it."""
    times = np.linspace(0.01, 0.06, 200)
    values = {"forces.F": {"point": "block", "formula": ["0", f"{LOAD} * (1 + 0.5 * sin(300 * t))"]}, "duration": 0.06}
    places = []
    for step in (4e-4, 2e-4, 1e-4, 2.5e-5):
        found = linkages.simulate(rotor(values | {"joints.A.history.step": step})).evaluate(times)
        places.append(np.array([found["A.ex"], found["A.ey"]]))
    errors = [np.hypot(*(place - places[-1])).max() for place in places[:-1]]
    assert errors[1] < 0.65 * errors[0]
    assert errors[2] < 0.65 * errors[1]
    assert errors[0] < 0.02 * CLEARANCE


def test_a_run_that_pauses_and_one_in_a_batch_are_the_same(rotor):
    """The content is kept between the parts of a run, and recorded for states between its steps."""
    system = rotor({"duration": 0.06})
    flow, whole = Flow(system), linkages.simulate(system)
    for until in (0.011, 0.02, 0.06):
        piece = flow.advance(until)
    assert flow.columns(piece, np.array([0.06]), ["A.ey"])["A.ey"][0] == pytest.approx(whole["A.ey"][-1], rel=1e-5)
    batch = linkages.simulate_batch(system, ["joints.A.viscosity"], [[0.02], [VISCOSITY]], ["A.ey", "A.film_content"])
    assert batch.last[1, 0].tolist() == [whole["A.ey"][-1], whole["A.film_content"][-1]]
    assert batch.minimum[1, 0, 1] == linkages.extremes(whole, ["A.film_content"])["A.film_content"].min
    assert batch.last[0, 0, 0] != pytest.approx(whole["A.ey"][-1], rel=1e-2)


def test_the_summary_estimates_the_error_of_the_film_step(rotor):
    found = linkages.summarize(linkages.assess(rotor({"duration": 0.03})))
    assert found["status"] == "ok"
    assert 0.0 < found["error"]["A.eccentricity_ratio.peak"] < 0.01
    assert not [one for one in found["warnings"] if one["kind"] == "film"]


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("joints.A.history.content=1.5", "joints.A.history.content"),
        ("joints.A.history.step=0", "joints.A.history.step"),
        ("joints.A.history.cells=[8, 4]", "8 cells around: must be 16 to 240"),
        ("joints.A.history.cells=[48, 40]", "40 cells along: must be 2 to 20"),
        ("joints.A.cavitation=reynolds", 'history needs model "lubricated", film "finite" and cavitation'),
        ("joints.A.small_eccentricity={ratio = 0.1, power = 2}", "history and small_eccentricity exclude each other"),
        ("start=equilibrium", 'joints.A.history: has no equilibrium that start = "equilibrium" could find'),
        ("drives.O={torque = 0.1}", "joints.A.history.step: is missing"),
    ],
)
def test_invalid_histories_are_refused(experiment_file, refusal, given, text):
    assert text in refusal(experiment_file(rotor_in_block(), TOML), given)


@pytest.mark.parametrize(
    "use",
    [
        pytest.param(lambda system: linkages.simulate(system, wrt=["joints.A.viscosity"]), id="derivatives"),
        pytest.param(lambda system: linkages.simulate_batch(system, wrt=["joints.A.viscosity"]), id="batch"),
        pytest.param(lambda system: linkages.periodic_motion(system), id="periodic"),
        pytest.param(lambda system: linkages.largest_exponent(system, revolutions=2, transient=1), id="exponent"),
        pytest.param(lambda system: linkages.linearise(system), id="linear"),
        pytest.param(check_wears, id="wear"),
        pytest.param(Session, id="live page"),
    ],
)
def test_analyses_that_do_not_follow_the_content_refuse_it(rotor, use):
    """They refuse before any run: one with such short film steps would take hours."""
    with pytest.raises(
        linkages.InputError, match=r"joints\.A\.history: .* cannot follow the film content; remove the table"
    ):
        use(rotor({"joints.A.history.step": 1e-9}))
