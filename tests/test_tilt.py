"""A tilted journal in a machine: the static bearing, both engines, limits, invalid input."""

import numpy as np
import pytest
from machines import rotor_in_block
from shipped import shipped

import linkages

SPEED, LOAD, CLEARANCE, VISCOSITY = 1000.0, 300.0, 5e-5, 0.03
TOML = f"""duration = 0.013
drives.O = {{speed = {SPEED}}}
forces.F = {{point = "block", force = [0.0, {LOAD}]}}
start = "equilibrium"
[joints.A]
model = "lubricated"
clearance = {CLEARANCE}
viscosity = {VISCOSITY}
tilt = [1e-3, -1.5e-3]
"""
PLAIN = {"joints.A.tilt": [0.0, 0.0]}


@pytest.fixture
def rotor(system_of):
    return lambda overrides=None, **options: system_of(rotor_in_block(**options), TOML, overrides)


@pytest.mark.parametrize("engine", ["compiled", pytest.param("drake", marks=pytest.mark.slow)])
def test_a_tilted_rotor_is_the_tilted_static_bearing(rotor, engine):
    """`linkages.bearing` solves the film on the surface: place to 0.5 %, moment and torque to 1 %.

    The load on the journal points along -y, so that the axes of the static bearing are (-y, x).
    """
    run = linkages.simulate(rotor(), engine)
    assert run.status is linkages.Status.OK
    point = linkages.bearing(
        0.02, 0.02, CLEARANCE, VISCOSITY, SPEED, LOAD, cavitation="guembel", tilt=(1.5e-3, 1e-3), cells=(160, 12)
    )
    along, across = -run["A.ey"][-1] / CLEARANCE, run["A.ex"][-1] / CLEARANCE
    assert (along, across) == pytest.approx((point.x, point.y), abs=5e-3 * point.eccentricity_ratio)
    moment = np.array(point.content["moment"])
    found = np.array([-run["A.my"][-1], run["A.mx"][-1]])
    assert found == pytest.approx(moment, abs=0.01 * np.hypot(*moment))
    assert -run["A.power"][-1] == pytest.approx(point.content["power"], rel=0.01)
    assert run["A.film_thickness"][-1] == pytest.approx(point.content["least_film"], rel=0.01)


def test_tilt_raises_the_power_and_lowers_the_film(rotor):
    tilted, plain = linkages.simulate(rotor()), linkages.simulate(rotor(PLAIN))
    assert tilted["A.film_thickness"][-1] < plain["A.film_thickness"][-1]
    assert tilted["A.power"][-1] < plain["A.power"][-1] < 0.0
    assert "A.mx" not in plain


def test_the_summary_has_the_peak_of_the_moment(rotor):
    found = linkages.summarize(linkages.assess(rotor()))
    run = linkages.simulate(rotor())
    largest = float(np.hypot(run["A.mx"], run["A.my"]).max())
    assert found["joints"]["A"]["tilting_moment"]["peak"] == pytest.approx(largest, rel=1e-6)
    assert found["error"]["A.tilting_moment.peak"] < 1e-3 * largest
    assert (
        "tilting_moment" not in linkages.summarize(linkages.assess(rotor(PLAIN), error_estimate=False))["joints"]["A"]
    )


def test_a_vanishing_tilt_is_the_plain_film(rotor):
    """The film is solved instead of read from its map: 0.5 % of the eccentricity."""
    tiny, plain = linkages.simulate(rotor({"joints.A.tilt": [1e-12, 0.0]})), linkages.simulate(rotor(PLAIN))
    assert tiny["A.eccentricity_ratio"][-1] == pytest.approx(plain["A.eccentricity_ratio"][-1], rel=5e-3)
    assert np.hypot(tiny["A.mx"], tiny["A.my"]).max() < 1e-8


def test_the_tilt_turns_with_the_bearing(rotor):
    """A tilt of a bearing that turns is a motion of the film: the moment turns with it, the middle stays nearly still."""
    run = linkages.simulate(rotor(outer="rotor", inner="block"))
    assert run.status is linkages.Status.OK
    assert np.ptp(run["A.mx"]) > np.abs(run["A.mx"]).max()


@pytest.mark.slow
def test_both_engines_agree_on_the_press():
    """Forces and moments of a tilted joint, start included, to 1e-4 of their peaks."""
    values = {"joints.A.film": "finite", "joints.A.tilt": [3e-3, 4e-3]}
    runs = [
        linkages.simulate(shipped("seven_bar", duration=0.05, **values), engine) for engine in ("compiled", "drake")
    ]
    times = np.linspace(0.0, 0.05, 40)
    for name in ("A.fx", "A.fy", "A.mx", "A.my"):
        one, other = (run.evaluate(times)[name] for run in runs)
        assert one == pytest.approx(other, abs=1e-4 * np.abs(one).max())


def test_the_heat_balance_of_a_tilted_joint(system_of):
    """The flow of the tilted film is that of the static bearing, 1 %."""
    toml = (
        TOML.replace(f"viscosity = {VISCOSITY}", "oil = {grade = 46, temperature = 50.0}") + "heat = {inlet = 40.0}\n"
    )
    heat = linkages.assess(system_of(rotor_in_block(), toml), error_estimate=False).heat["A"]
    point = linkages.bearing(
        0.02, 0.02, CLEARANCE, heat.viscosity, SPEED, LOAD, cavitation="guembel", tilt=(1.5e-3, 1e-3), cells=(120, 10)
    )
    assert heat.flow == pytest.approx(point.content["flow"], rel=0.01)
    assert heat.power == pytest.approx(heat.by_flow, rel=0.01)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        (
            "joints.A.tilt=[5e-3, 0.0]",
            "joints.A.tilt: is 0.005; a centred journal touches the bearing at 0.005 (2 c/L)",
        ),
        ("joints.A.tilt=[0.004, 0.004]", "touches the bearing"),
        ("joints.A.tilt=[1e-3]", "joints.A.tilt"),
        ("joints.A.film=long", 'tilt needs model "lubricated", film "finite"'),
        ("joints.A.cavitation=reynolds", 'tilt needs model "lubricated", film "finite"'),
    ],
)
def test_invalid_tilts_are_refused(experiment_file, refusal, given, text):
    assert text in refusal(experiment_file(rotor_in_block(), TOML), given)


def test_an_offset_leaves_room_for_the_tilt(rotor):
    values = {"start": "centred", "joints.A.offset": [4e-5, 0.0], "joints.A.tilt": [2e-3, 0.0]}
    with pytest.raises(linkages.InputError, match="must leave room for the tilt"):
        rotor(values)


def test_a_run_ends_where_an_end_could_touch(rotor):
    run = linkages.simulate(rotor({"forces.F.force": [0.0, 30000.0], "start": "centred"}))
    assert run.status is linkages.Status.JOURNAL_LEFT_BEARING
    limit = 1.0 - 0.01 * np.hypot(1e-3, 1.5e-3) / CLEARANCE
    before, last = run["A.eccentricity_ratio"][-2:]
    assert before < limit < last < limit + 0.01
