"""Joints that touch: events, impacts, energy, rest; against an independent model and laws of nature."""

import numpy as np
import pytest
from engines import slow_on_drake
from machines import BEARING, four_bar, joint, model, solid
from scipy.special import ellipk
from shipped import run as run_shipped
from shipped import shipped
from slider_crank_impacts import CRANK, ROD, slider_crank_impacts, table

from linkages import InputError, Status, ideal, impacts
from linkages.laws import FRICTIONS
from linkages.results.extremes import integral


@slow_on_drake
@pytest.mark.parametrize(("friction", "clip"), [(0.0, True), (0.03, True), (0.03, False)])
def test_first_impacts_agree_with_an_independent_model(engine, friction, clip):
    """Time, speeds, duration, peaks of the first two impacts to 1e-6: another formulation, another integrator."""
    changes = {"compiled": {"solver.accuracy": 1e-12}, "drake": {"solver.accuracy": 1e-11, "solver.max_step": 2e-6}}[
        engine
    ]
    changes |= {"joints.B.friction.coefficient": friction, "joints.B.contact.clip": clip}
    run = run_shipped(engine, "slider_crank_dry", duration=1e-3, **changes)
    got = table(impacts(run, ["B"]))[:2]
    expected = slider_crank_impacts(friction, 1e-3, 2, 1.0 if clip else np.inf)
    np.testing.assert_allclose(got, expected, rtol=1e-6)


def damped(run, row, law):
    """During a contact: closing over approach speed, the law's force without any clip, the normal force [N]."""
    inside = (run.time > row.start) & (run.time < row.start + row.duration)
    e, force = (np.array([run[f"{row.joint}.{k}{axis}"][inside] for axis in "xy"]) for k in "ef")
    depth, ratio = np.hypot(*e) - law["clearance"], run[f"{row.joint}.closing"][inside] / row.approach_speed
    elastic = law["stiffness"] * np.maximum(depth, 0.0) ** 1.5
    return ratio, elastic * (1.0 + law["hysteresis"] * ratio), -(e * force).sum(axis=0) / np.hypot(*e)


UNCLIPPED = {"joints.B.contact.law": "flores", "joints.B.contact.restitution": 0.3, "joints.B.contact.clip": False}


@slow_on_drake
def test_without_the_clip_the_damping_is_the_laws(engine):
    """A journal that swings in its contact closes faster than it came; both engines meet the same force."""
    run = run_shipped(engine, "slider_crank_dry", duration=1.5e-3, **UNCLIPPED)
    assert run.status is Status.OK
    law = shipped("slider_crank_dry", **UNCLIPPED).laws[0]
    rows = impacts(run, ["B"])
    assert len(rows) == 2
    for row in rows:
        ratio, expected, normal = damped(run, row, law)
        assert ratio.max() > 1.0
        np.testing.assert_allclose(normal, expected, rtol=1e-6, atol=1e-3)
        assert row.peak_normal_force == pytest.approx(row.peak_force / np.hypot(1.0, 0.03), rel=1e-6)
    clipped = run_shipped(engine, "slider_crank_dry", duration=1.5e-3, **UNCLIPPED | {"joints.B.contact.clip": True})
    assert rows[1].peak_force < 0.96 * impacts(clipped, ["B"])[1].peak_force
    other = run_shipped("compiled", "slider_crank_dry", duration=1.5e-3, **UNCLIPPED)
    np.testing.assert_allclose(table(rows)[:, :-2], table(impacts(other, ["B"]))[:, :-2], rtol=2e-4)


def test_without_the_clip_no_contact_pulls_either(run, system_of):
    """A resting journal pulled off, faster than it came: where damping exceeds the elastic force there is none."""
    sdf = model("bowl", solid("disc", 0.2, 1e-5) + joint("J", "world", "disc", inner=BEARING))
    text = """duration = 0.02
gravity = [0.0, -9.81, 0.0]
[joints.J]
model = "dry"
clearance = 1e-3
offset = [0.0, -0.9999e-3]
[joints.J.contact]
law = "flores"
restitution = 0.3
stiffness = 1e8
clip = false
[forces.P]
point = "disc"
times = [0.0, 0.018, 0.019, 0.02]
forces = [[0.0, 0.0], [0.0, 0.0], [0.0, 30.0], [0.0, 30.0]]
"""
    found = run(sdf, text)
    last = impacts(found, ["J"])[-1]
    ratio, expected, normal = damped(found, last, system_of(sdf, text).laws[0])
    assert last.start + last.duration < 0.02
    assert ratio.min() < -1.0
    assert expected.min() < 0.0
    np.testing.assert_allclose(normal, np.maximum(expected, 0.0), atol=1e-6)


@pytest.mark.parametrize("law", [law for law in FRICTIONS if law != "none"])
def test_a_coefficient_of_zero_is_no_friction_whatever_the_law(engine, law):
    zero, none = (
        run_shipped(
            engine, "slider_crank_dry", duration=3e-4, **{f"joints.B.friction.{k}": v for k, v in friction.items()}
        )
        for friction in ({"law": law, "coefficient": 0.0}, {"law": "none"})
    )
    assert none["B.force"].max() > 1e4
    for name, column in none.columns.items():
        np.testing.assert_array_equal(zero[name], column, name)


@slow_on_drake
def test_energy_audit_of_a_dry_run(engine):
    """Drive work = change of kinetic energy + what contact and friction take, to 1e-5 of the work through the drive."""
    tight = {"solver.accuracy": 1e-10, "solver.max_step": 2e-6}
    run = run_shipped(engine, "slider_crank_dry", duration=6e-3, **tight)
    power = run["O.torque"] * run["O.rate"]
    work, through = integral(run, power), integral(run, np.abs(power))
    loss = -integral(run, run["B.power"])
    kinetic = run["kinetic_energy"][-1] - run["kinetic_energy"][0]
    assert len(impacts(run, ["B"])) > 3
    assert loss > 0.5
    assert abs(work - kinetic - loss) < 1e-5 * through


@slow_on_drake
def test_every_contact_begins_and_ends_at_a_step(engine):
    run = run_shipped(engine, "slider_crank_dry", duration=4e-3)
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


@slow_on_drake
def test_sampling_would_miss_the_peaks(engine):
    """At the paper's step of 0.1 ms the largest force is seen at two thirds of its size."""
    run = run_shipped(engine, "slider_crank_dry", duration=4e-3)
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


@slow_on_drake
@pytest.mark.parametrize(("law", "friction"), [("lankarani-nikravesh", "cubic"), ("flores", "lugre")])
def test_a_journal_comes_to_rest_in_its_bearing_without_chatter(run, system_of, law, friction):
    """Slow crank under gravity: the journal bounces a few times, then stays in contact and carries the ideal load."""
    text = REST.format(law=law, friction=friction)
    found = run(four_bar(), text)
    rows = impacts(found, ["B"])
    assert 1 < len(rows) < 60
    assert found["B.penetration"][found.time > 0.2].min() > 0.0
    times = np.linspace(0.22, 0.245, 6)
    exact = ideal(system_of(four_bar(), text)).evaluate(times)
    np.testing.assert_allclose(found.evaluate(times)["B.force"], exact["B.force"], rtol=0.05)


@slow_on_drake
def test_a_journal_that_grazes_its_wall_swings_in_it_like_a_pendulum(run):
    """Released at the height of the centre, at the wall: it touches with no speed at all, and stays in contact.

    A pendulum of length c without friction: sqrt(2 g c) at the bottom, after K(1/2) sqrt(c/g).
    """
    sdf = model("bowl", solid("disc", 0.2, 1e-5) + joint("J", "world", "disc", inner=BEARING))
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
    found = run(sdf, text)
    rows = impacts(found, ["J"])
    assert rows[0].approach_speed < 1e-3
    assert len(rows) < 40
    assert sum(row.duration for row in rows) > 0.9 * 0.03
    fall = float(ellipk(0.5)) * np.sqrt(1e-3 / 9.81)
    assert found.evaluate(np.array([fall]))["J.ex"][0] == pytest.approx(0.0, abs=2e-5)
    assert np.abs(found["disc.vx"]).max() == pytest.approx(np.sqrt(2 * 9.81 * 1e-3), rel=1e-2)


@slow_on_drake
def test_two_joints_touch_at_once(run):
    text = REST.format(law="flores", friction="coulomb").replace("duration = 0.25", "duration = 0.1")
    both = text + text[text.index("[joints.B]") :].replace("joints.B", "joints.A")
    found = run(four_bar(), both)
    rows = impacts(found, ["A", "B"])
    assert {row.joint for row in rows} == {"A", "B"}
    together = (found["A.penetration"] > 0) & (found["B.penetration"] > 0)
    assert together.any()
    energy = found["kinetic_energy"] + found["potential_energy"]
    work = integral(found, found["O.torque"] * found["O.rate"])
    loss = -sum(integral(found, found[f"{name}.power"]) for name in "AB")
    assert loss > 0.0
    assert energy[-1] - energy[0] == pytest.approx(work - loss, abs=1e-4 * abs(work) + 1e-4 * loss)


MIXED = """duration = 0.03
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
[joints.B.mixed]
"""


@slow_on_drake
@pytest.mark.parametrize(
    "mixed",
    [
        'law = "blend"\ntransition = 1e-6\n',
        'law = "greenwood-tripp"\nroughness = 1e-6\ndensity = 1e10\ntip_radius = 1e-5\n',
    ],
)
def test_a_mixed_joint_carries_what_its_film_cannot(run, mixed):
    """The film alone breaks down; with contact the run continues, close to the ideal motion."""
    found = run(four_bar(), MIXED + mixed)
    assert 0.95 < found["B.eccentricity_ratio"].max() < 1.2
    assert -integral(found, found["B.power"]) > 0.0


# --- a block in a slot ------------------------------------------------------------------------------------------------


@slow_on_drake
def test_a_block_with_play_in_its_slot_follows_the_ideal_slider(engine):
    """It strikes both walls, tilts a little by friction, and loses energy only in its contacts."""
    tight = {"solver.accuracy": 1e-9, "solver.max_step": 5e-6}
    run = run_shipped(engine, "slider_crank_guide", duration=0.02, **tight)
    rows = impacts(run, [f"guide.corner{i}" for i in range(1, 5)])
    assert {row.joint for row in rows} == {f"guide.corner{i}" for i in range(1, 5)}
    exact = ideal(shipped("slider_crank_guide", duration=0.02)).evaluate(run.time)
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


@slow_on_drake
def test_the_slider_obeys_newton_and_euler_with_its_guide_forces(engine):
    """Sum of the corners' forces and of the pin's = mass times acceleration; moments about the pin likewise."""
    run = run_shipped(engine, "slider_crank_guide", duration=0.004)
    ax, ay = run["slider.ax"], run["slider.ay"] + 9.81
    np.testing.assert_allclose(run["guide.fx"] - run["B.fx"], 0.14 * ax, atol=1e-6)
    np.testing.assert_allclose(run["guide.fy"] - run["B.fy"], 0.14 * ay, atol=1e-6)
    np.testing.assert_allclose(run["guide.moment"], 1e-4 * run["slider.alpha"], atol=1e-7)
    assert run["guide.force"].max() > 1.0
    law = shipped("slider_crank_guide").laws[0]
    for row in impacts(run, [f"guide.corner{i}" for i in range(1, 5)]):
        if not np.isnan(row.separation_speed):  # mu of the sliding block
            assert row.peak_force == pytest.approx(row.peak_normal_force * np.hypot(1.0, law["mu_d"]), rel=1e-6)


@slow_on_drake
def test_a_resting_block_carries_its_weight_on_two_corners(run):
    """A slider alone under gravity on a horizontal slot, pushed by nothing: half of m g on each lower corner."""
    slot = (
        "<linkages:slot><linkages:length>0.04</linkages:length><linkages:height>0.02</linkages:height></linkages:slot>"
    )
    block = solid("block", 0.5, 1e-4)
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
    found = run(sdf, text)
    last = {i: found[f"guide.corner{i}.force"][-1] for i in range(1, 5)}
    assert last[1] == last[2] == 0.0
    assert last[3] == pytest.approx(0.25 * 9.81, rel=0.02)
    assert last[4] == pytest.approx(0.25 * 9.81, rel=0.02)
    depth = (0.25 * 9.81 / 1e8) ** (1 / 1.5)
    assert found["guide.offset"][-1] == pytest.approx(-1e-4 - depth, rel=1e-3)


def test_contacts_of_a_joint_without_clearance_are_refused():
    with pytest.raises(InputError, match=r"O\.closing"):
        impacts(run_shipped("compiled", "slider_crank_dry", duration=1e-3), ["O"])
