"""Friction in ideal joints, given by its torque or force: decay, stopping and momentum in closed form, on both engines."""

import numpy as np
import pytest
from engines import slow_on_drake
from joint_records import joint as joint_record
from machines import bar, joint, model, solid
from scipy.integrate import simpson

from linkages import InputError, load
from linkages.elements.friction import JointFriction
from linkages.laws.friction import friction_coefficient

EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-9\n"
CART, BLOCK = solid("cart", 3.0), solid("block", 2.0)


def test_the_coulomb_part_is_the_law_of_dry_joints():
    record = joint_record(friction="coulomb", mu_d=0.3, v_1=0.02)
    friction = JointFriction(joint="O", constant=0.3, speed=0.02)
    for v in (-0.5, -0.01, 0.0, 0.003, 0.05):
        law = friction.law
        assert law.formula({**law.names, "v": v}) == pytest.approx(-friction_coefficient(v, record), rel=1e-14)


@slow_on_drake
@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1"])
def test_a_pendulum_loses_the_same_angle_in_each_half_swing(run, axis):
    """On a linear spring: 2 T/k, whatever the amplitude; half a swing lasts pi sqrt(J/k), as without friction."""
    sdf = model("arm", bar("arm", 0.4, "__model__", mass=1.5) + joint("O", "world", "arm", axis=axis))
    inertia, stiffness, torque = 0.08, 20.0, 0.4
    half = np.pi * np.sqrt(inertia / stiffness)
    text = f"""duration = {3.2 * half}
[drives.O]
torque = 0.0
angle = 0.5
[torsion_springs.S]
joint = "O"
stiffness = {stiffness}
free_angle = 0.0
[frictions.pin]
joint = "O"
constant = {torque}
speed = 1e-3
"""
    found = run(sdf, text + EXACT)
    turns = found.evaluate(half * np.arange(1, 4))["q.O"]
    lost = 0.5 - np.abs(turns)
    np.testing.assert_allclose(lost, 2 * torque / stiffness * np.arange(1, 4), rtol=1e-4)
    np.testing.assert_array_equal(np.sign(turns), [-1, 1, -1])
    assert found["pin.power"].max() <= 0.0
    times = np.linspace(0.0, half, 2001)
    swing = found.evaluate(times)
    energy = swing["kinetic_energy"] + swing["potential_energy"]
    assert simpson(swing["pin.power"], x=times) == pytest.approx(energy[-1] - energy[0], rel=1e-5)


def test_a_block_stops_after_its_way_and_stays(run):
    """From 0.8 m/s against 4 N: after 0.4 s, m v^2/(2 F) = 0.16 m; then it creeps not at all, as nothing pushes."""
    sdf = model("block", BLOCK + joint("slide", "world", "block", "prismatic", "1 0 0"))
    text = "duration = 0.6\n[drives.slide]\nforce = 0.0\nspeed = 0.8\n"
    text += "[frictions.rail]\njoint = 'slide'\nconstant = '4 N'\nspeed = '1 mm/s'\n"
    found = run(sdf, text + EXACT)
    early = found.time < 0.38
    np.testing.assert_allclose(found["block.vx"][early], 0.8 - 2.0 * found.time[early], atol=1e-7)
    np.testing.assert_allclose(found["rail.force"][early], -4.0, rtol=1e-9)
    assert found["block.x"][-1] == pytest.approx(0.16, abs=1e-5)
    assert abs(found["block.vx"][-1]) < 1e-8  # integration error: accuracy 1e-9 of some m/s


def test_viscous_friction_slows_exponentially(run):
    sdf = model("arm", bar("arm", 0.4, "__model__", mass=1.5) + joint("O", "world", "arm"))
    text = "duration = 1.0\n[drives.O]\ntorque = 0.0\nspeed = 5.0\n[frictions.oil]\njoint = 'O'\nviscous = 0.1\n"
    found = run(sdf, text + EXACT)
    np.testing.assert_allclose(found["O.rate"], 5.0 * np.exp(-found.time * 0.1 / 0.08), atol=1e-7)


@slow_on_drake
def test_a_block_on_a_moving_cart_takes_it_along(run):
    """Momentum is kept; the relative speed falls at F (1/m + 1/M) until both go together."""
    body = CART + BLOCK + joint("rail", "world", "cart", "prismatic", "1 0 0")
    body += joint("slide", "cart", "block", "prismatic", "1 0 0")
    text = "duration = 0.5\n[drives.slide]\nforce = 0.0\nspeed = 1.5\n"
    text += "[frictions.table]\njoint = 'slide'\nconstant = 6.0\nspeed = 1e-4\n"
    found = run(model("cart", body), text + EXACT)
    momentum = 3.0 * found["cart.vx"] + 2.0 * found["block.vx"]
    np.testing.assert_allclose(momentum, 3.0, atol=1e-9)
    early = found.time < 0.28
    np.testing.assert_allclose(found["slide.rate"][early], 1.5 - 5.0 * found.time[early], atol=1e-7)
    np.testing.assert_allclose([found["cart.vx"][-1], found["block.vx"][-1]], 0.6, atol=1e-8)


PIN = "[frictions.pin]\njoint = 'O'\n"
#: case -> (text, expected part of the message)
REFUSED = {
    "nothing": (PIN, "frictions.pin: give constant, viscous, or coefficient"),
    "negative": (PIN + "constant = -1.0\n", "frictions.pin.constant: is -1.0"),
    "unknown joint": (PIN.replace("'O'", "'P'") + "constant = 1.0\n", 'frictions.pin.joint: "P" is not in machine.sdf'),
    "another unit": (PIN + "constant = '3 N'\n", 'frictions.pin.constant: is "3 N"; it must be measured in N m'),
    "no radius": (PIN + "coefficient = 0.1\n", "frictions.pin.radius: is missing: a coefficient needs the radius"),
    "length of a pin": (
        PIN + "coefficient = 0.1\nradius = 0.01\nlength = 0.1\n",
        'frictions.pin.length: has no effect: "O" is revolute',
    ),
    "Stribeck without speed": (
        PIN + "coefficient = 0.1\nradius = 0.01\nstatic_coefficient = 0.2\n",
        "frictions.pin: give static_coefficient and stribeck_speed, with coefficient, or neither",
    ),
    "name of a joint": (PIN.replace("pin", "O") + "constant = 1.0\n", "frictions.O: is also the name of"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_frictions_are_refused_in_one_line(experiment_file, case):
    text, reason = REFUSED[case]
    sdf = model("arm", bar("arm", 0.4, "__model__", mass=1.5) + joint("O", "world", "arm"))
    with pytest.raises(InputError) as problem:
        load(experiment_file(sdf, "duration = 1.0\n" + text))
    assert reason in str(problem.value)
    assert "\n" not in str(problem.value)
