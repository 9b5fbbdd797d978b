"""Dry and mixed joints on Drake: events, impacts, energy, against an independent model."""

import numpy as np
import pytest
from machines import BEARING, four_bar, joint, model
from scipy.special import ellipk
from slider_crank_impacts import CRANK, ROD, slider_crank_impacts, table

from linkages.engines.drake import simulate
from linkages.engines.study import ideal
from linkages.errors import Status
from linkages.files.shipped import data_folder
from linkages.model.experiment import load
from linkages.results.extremes import integral
from linkages.results.impacts import impacts


@pytest.mark.parametrize("friction", [None, 0.03])
def test_first_impacts_agree_with_an_independent_model(friction):
    """Time, speeds, duration, peaks of the first two impacts to 1e-6: another formulation, another integrator."""
    overrides = {"duration": 1e-3, "solver.accuracy": 1e-11, "solver.max_step": 2e-6}
    if friction is None:
        overrides["joints.B.friction"] = {"law": "ambrosio", "coefficient": 1e-12}
    mechanism, experiment = load(data_folder() / "slider_crank_dry.toml", overrides)
    run = simulate(mechanism, experiment)
    got = table(impacts(run, ["B"]))[:2]
    expected = slider_crank_impacts(friction or 0.0, 1e-3, 2)
    np.testing.assert_allclose(got, expected, rtol=1e-6)


def test_energy_audit_of_a_dry_run():
    """Drive work = change of kinetic energy + what contact and friction take, to 1e-5 of the work through the drive."""
    overrides = {"duration": 6e-3, "solver.accuracy": 1e-10, "solver.max_step": 2e-6}
    run = simulate(*load(data_folder() / "slider_crank_dry.toml", overrides))
    power = run["O.torque"] * run["O.rate"]
    work, through = integral(run, power), integral(run, np.abs(power))
    loss = -integral(run, run["B.power"])
    kinetic = run["kinetic_energy"][-1] - run["kinetic_energy"][0]
    assert len(impacts(run, ["B"])) > 3
    assert loss > 0.5
    assert abs(work - kinetic - loss) < 1e-5 * through


def test_every_contact_begins_and_ends_at_a_step():
    run = simulate(*load(data_folder() / "slider_crank_dry.toml", {"duration": 3e-3}))
    rows = impacts(run, ["B"])
    assert len(rows) >= 4
    for row in rows[:-1]:
        for time in (row.start, row.start + row.duration):
            at = int(np.argmin(np.abs(run.time - time)))
            assert abs(run["B.penetration"][at]) < 1e-9
        assert row.approach_speed > 0.0
        assert row.separation_speed > 0.0
    inside = run["B.penetration"] > 1e-9
    assert (run["B.force"][inside] >= 0.0).all()
    assert (run["B.force"][run["B.penetration"] < -1e-9] == 0.0).all()


def test_sampling_would_miss_the_peaks():
    """At the paper's step of 0.1 ms the largest force is seen at two thirds of its size."""
    run = simulate(*load(data_folder() / "slider_crank_dry.toml", {"duration": 4e-3}))
    rows = impacts(run, ["B"])
    sampled = run.evaluate(np.arange(0.0, 4e-3, 1e-4))["B.force"].max()
    assert 0.6 < sampled / max(row.peak_force for row in rows) < 0.75


REST = """duration = 0.25
gravity = [0.0, -9.81, 0.0]
[drives.O]
speed = 1.0
ramp = 0.1
[joints.B]
model = "dry"
clearance = 1e-4
[joints.B.contact]
law = "{law}"
restitution = 0.3
youngs_modulus = 2e9
[joints.B.friction]
law = "{friction}"
coefficient = 0.1
v_0 = 1e-3
v_1 = 1e-2
bristle_stiffness = 1e4
"""


@pytest.mark.parametrize(("law", "friction"), [("lankarani-nikravesh", "cubic"), ("flores", "lugre")])
def test_a_journal_comes_to_rest_in_its_bearing_without_chatter(experiment_file, law, friction):
    """Slow crank under gravity: the journal bounces a few times, then stays in contact and carries the ideal load."""
    mechanism, experiment = load(experiment_file(four_bar(), REST.format(law=law, friction=friction)))
    run = simulate(mechanism, experiment)
    assert run.status is Status.OK
    rows = impacts(run, ["B"])
    assert 1 < len(rows) < 60
    assert run["B.penetration"][run.time > 0.2].min() > 0.0
    exact = ideal(mechanism, experiment)
    times = np.linspace(0.22, 0.245, 6)
    np.testing.assert_allclose(run.evaluate(times)["B.force"], exact.evaluate(times)["B.force"], rtol=0.05)


def test_a_journal_that_grazes_its_wall_swings_in_it_like_a_pendulum(experiment_file):
    """Released at the height of the centre, at the wall: it touches with no speed at all, and stays in contact.

    A pendulum of length c without friction: sqrt(2 g c) at the bottom, after K(1/2) sqrt(c/g).
    """
    disc = (
        '<link name="disc"><inertial><mass>0.2</mass><inertia><ixx>1e-5</ixx><iyy>1e-5</iyy><izz>1e-5</izz>'
        "</inertia></inertial></link>"
    )
    sdf = model("bowl", disc + joint("J", "world", "disc", inner=BEARING))
    text = """duration = 0.03
gravity = [0.0, -9.81, 0.0]
[joints.J]
model = "dry"
clearance = 1e-3
offset = [-0.9999999e-3, 0.0]
[joints.J.contact]
law = "lankarani-nikravesh"
restitution = 0.9
youngs_modulus = 200e9
[solver]
accuracy = 1e-9
"""
    run = simulate(*load(experiment_file(sdf, text)))
    rows = impacts(run, ["J"])
    assert run.status is Status.OK
    assert rows[0].approach_speed < 1e-3
    assert len(rows) < 40
    assert sum(row.duration for row in rows) > 0.9 * 0.03
    fall = float(ellipk(0.5)) * np.sqrt(1e-3 / 9.81)
    assert run.evaluate(np.array([fall]))["J.ex"][0] == pytest.approx(0.0, abs=2e-5)
    assert np.abs(run["disc.vx"]).max() == pytest.approx(np.sqrt(2 * 9.81 * 1e-3), rel=1e-2)


def test_two_joints_touch_at_once(experiment_file):
    text = REST.format(law="flores", friction="coulomb").replace("duration = 0.25", "duration = 0.1")
    both = text + text[text.index("[joints.B]") :].replace("joints.B", "joints.A")
    run = simulate(*load(experiment_file(four_bar(), both)))
    rows = impacts(run, ["A", "B"])
    assert {row.joint for row in rows} == {"A", "B"}
    together = (run["A.penetration"] > 0) & (run["B.penetration"] > 0)
    assert together.any()
    energy = run["kinetic_energy"] + run["potential_energy"]
    work = integral(run, run["O.torque"] * run["O.rate"])
    loss = -sum(integral(run, run[f"{name}.power"]) for name in "AB")
    assert loss > 0.0
    assert energy[-1] - energy[0] == pytest.approx(work - loss, abs=1e-4 * abs(work) + 1e-4 * loss)


MIXED = """duration = 0.1
[drives.O]
speed = 60.0
[joints.B]
model = "mixed"
clearance = 1e-4
viscosity = 0.002
film = "finite"
[joints.B.contact]
law = "lankarani-nikravesh"
restitution = 0.5
youngs_modulus = 2e9
[joints.B.friction]
law = "coulomb"
coefficient = 0.05
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "mixed",
    [
        'law = "blend"\ntransition = 1e-6\n',
        'law = "greenwood-tripp"\nroughness = 1e-6\ndensity = 1e10\ntip_radius = 1e-5\n',
    ],
)
def test_a_mixed_joint_carries_what_its_film_cannot(experiment_file, mixed):
    """The film alone breaks down; with contact the run goes on, close to the ideal motion."""
    text = MIXED + "[joints.B.mixed]\n" + mixed
    mechanism, experiment = load(experiment_file(four_bar(), text), {"duration": 0.03})
    run = simulate(mechanism, experiment)
    assert run.status is Status.OK
    assert run["B.eccentricity_ratio"].max() > 0.95
    assert run["B.eccentricity_ratio"].max() < 1.2
    assert -integral(run, run["B.power"]) > 0.0


def test_a_step_that_throws_the_journal_through_the_wall_ends_with_a_status():
    """Far too large a step for a contact: what was computed is kept."""
    run = simulate(*load(data_folder() / "seven_bar_dry.toml", {"duration": 0.05, "solver.max_step": 5e-4}))
    assert run.status is Status.STEP_SIZE_COLLAPSE
    assert run.time[-1] > 0.001
    assert np.isfinite(run["A.force"]).all()


def guide_experiment(**overrides):
    return load(data_folder() / "slider_crank_guide.toml", {"duration": 0.02, **overrides})


def test_a_block_with_play_in_its_slot_follows_the_ideal_slider():
    """It strikes both walls, tilts a little by friction, and loses energy only in its contacts."""
    mechanism, experiment = guide_experiment(**{"solver.accuracy": 1e-9, "solver.max_step": 5e-6})
    run = simulate(mechanism, experiment)
    rows = impacts(run, [f"guide.corner{i}" for i in range(1, 5)])
    assert {row.joint for row in rows} == {f"guide.corner{i}" for i in range(1, 5)}
    exact = ideal(mechanism, experiment).evaluate(run.time)
    # a pin off the axis by y moves the slider by y*tan(rod angle), at most
    reach = np.abs(run["slider.y"]).max() * np.tan(np.arcsin(CRANK / ROD))
    np.testing.assert_allclose(run["slider.x"], exact["slider.x"], atol=1.05 * reach)
    assert np.abs(run["guide.offset"]).max() < 1e-4
    assert np.abs(run["guide.tilt"]).max() < 2 * 1e-4 / 0.04
    assert np.abs(run["guide.tilt"]).max() > 1e-6
    power = run["O.torque"] * run["O.rate"]
    energy = run["kinetic_energy"] + run["potential_energy"]
    loss = -integral(run, run["guide.power"])
    assert loss > 0.0
    balance = integral(run, power) - (energy[-1] - energy[0]) - loss
    assert abs(balance) < 1e-5 * integral(run, np.abs(power))


def test_the_slider_obeys_newton_and_euler_with_its_guide_forces():
    """Sum of the corners' forces and of the pin's = mass times acceleration; moments about the pin likewise."""
    run = simulate(*guide_experiment(duration=0.004))
    ax, ay = run["slider.ax"], run["slider.ay"] + 9.81
    np.testing.assert_allclose(run["guide.fx"] - run["B.fx"], 0.14 * ax, atol=1e-6)
    np.testing.assert_allclose(run["guide.fy"] - run["B.fy"], 0.14 * ay, atol=1e-6)
    np.testing.assert_allclose(run["guide.moment"], 1e-4 * run["slider.alpha"], atol=1e-7)
    assert run["guide.force"].max() > 1.0


def test_a_resting_block_carries_its_weight_on_two_corners(experiment_file):
    """A slider alone under gravity on a horizontal slot, pushed by nothing: half of m g on each lower corner."""
    block = (
        '<link name="block"><inertial><mass>0.5</mass><inertia><ixx>1e-4</ixx><iyy>1e-4</iyy><izz>1e-4</izz>'
        "</inertia></inertial></link>"
    )
    slot = "<linkages:slot><linkages:length>0.04</linkages:length><linkages:height>0.02</linkages:height></linkages:slot>"
    sdf = model("rest", block + joint("guide", "world", "block", "prismatic", "1 0 0", inner=slot))
    text = """duration = 0.2
gravity = [0.0, -9.81, 0.0]
[joints.guide]
model = "dry"
clearance = 1e-4
[joints.guide.contact]
law = "flores"
restitution = 0.2
stiffness = 1e8
"""
    run = simulate(*load(experiment_file(sdf, text)))
    last = {i: run[f"guide.corner{i}.force"][-1] for i in range(1, 5)}
    assert last[1] == last[2] == 0.0
    assert last[3] == pytest.approx(0.25 * 9.81, rel=0.02)
    assert last[4] == pytest.approx(0.25 * 9.81, rel=0.02)
    depth = (0.25 * 9.81 / 1e8) ** (1 / 1.5)
    assert run["guide.offset"][-1] == pytest.approx(-1e-4 - depth, rel=1e-3)
