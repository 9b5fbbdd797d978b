"""Links without mass, and masses without a moment of inertia: closed forms where others hold them, else refusals."""

import numpy as np
import pytest
from machines import BEARING, bar, joint, model, solid

from linkages import InputError, Status, simulate, simulate_batch

EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-10\n"
R, D, CRANK, LEVER, TORQUE = 0.08, 0.2, 0.01, 0.05, 0.3


def quick_return(block, more=""):
    """A crank whose pin slides in the slot of a lever; both are balanced about their joints. `block` is a link."""
    slot = f"<axis><xyz>{R / np.hypot(R, D)} {D / np.hypot(R, D)} 0</xyz></axis>"
    body = solid("crank", 1.0, CRANK) + solid("lever", 2.0, LEVER, f"0 {-D} 0 0 0 0") + block
    body += joint("O", "world", "crank") + joint("C", "world", "lever") + joint("A", "crank", "block", inner=more)
    return model(
        "quick_return",
        body + joint("slot", "lever", "block", "prismatic").replace("<axis><xyz>0 0 1</xyz></axis>", slot),
    )


def massless(name, pose="0 0 0 0 0 0", at="__model__", mass=0.0):
    return solid(name, mass, 0.0, pose, at)


BLOCK = massless("block", f"{R} 0 0 0 0 0")
TURNED = f"duration = 1.0\noutputs = ['crank.omega', 'lever.omega']\n[drives.O]\ntorque = {TORQUE}\n"


def test_a_slot_without_a_block_passes_all_work_to_crank_and_lever(run):
    """T a = (J1 + k^2 J2) w^2/2, with k = r (r + d sin a)/(r^2 + d^2 + 2 r d sin a) the lever's speed over the crank's."""
    found = run(quick_return(BLOCK), TURNED + EXACT)
    angle, rate = found["q.O"], found["crank.omega"]
    k = R * (R + D * np.sin(angle)) / (R**2 + D**2 + 2 * R * D * np.sin(angle))
    assert angle[-1] > 4.0
    np.testing.assert_allclose(found["lever.omega"], k * rate, atol=1e-8 * rate.max())
    work = TORQUE * angle
    np.testing.assert_allclose(0.5 * (CRANK + k**2 * LEVER) * rate**2, work, atol=1e-6 * work.max())
    difference = np.hypot(found["A.fx"], found["A.fy"]) - found["slot.force"]
    np.testing.assert_allclose(difference, 0.0, atol=1e-6 * found["slot.force"].max())  # nothing accelerates the block


def test_a_massless_rod_between_two_cranks_of_a_parallelogram_only_passes_force(run):
    """Both cranks turn by T = (J1 + J2) a."""
    pivot = '<frame name="pivot" attached_to="world"><pose>0.3 0 0 0 0 0</pose></frame>'
    end = '<frame name="left_tip" attached_to="left"><pose>0 0.1 0 0 0 0</pose></frame>'
    end += '<frame name="right_tip" attached_to="right"><pose>0 0.1 0 0 0 0</pose></frame>'
    body = (
        pivot + solid("left", 1.0, 0.02) + solid("right", 1.0, 0.03, at="pivot") + end + massless("rod", at="left_tip")
    )
    body += joint("O", "world", "left") + joint("Q", "world", "right") + joint("A", "left_tip", "rod")
    body += joint("B", "right_tip", "rod", inner="<pose relative_to='right_tip'/>")
    found = run(model("pair", body), "duration = 0.4\n[drives.O]\ntorque = 0.5\n" + EXACT)
    np.testing.assert_allclose(found["q.O"], 0.5 * 0.5 / 0.05 * found.time**2, atol=1e-8)
    np.testing.assert_allclose(found["B.force"][-1], found["A.force"][-1], rtol=1e-6)


def test_a_point_mass_on_an_arm_is_the_mathematical_pendulum(run):
    """A mass without a moment of inertia: from 0.2 rad, cos(a) - cos(0.2) = w^2 l/(2 g)."""
    bob = solid("bob", 0.7, 0.0, centre="0 -0.4 0 0 0 0")
    text = (
        "duration = 0.5\ngravity = [0.0, -9.81, 0.0]\noutputs = ['bob.omega']\n[drives.P]\ntorque = 0.0\nangle = 0.2\n"
    )
    found = run(model("pendulum", bob + joint("P", "world", "bob")), text + EXACT)
    np.testing.assert_allclose(
        found["bob.omega"] ** 2, 2 * 9.81 / 0.4 * (np.cos(found["q.P"]) - np.cos(0.2)), atol=1e-8
    )
    assert found["q.P"][-1] < 0.0


#: case -> (SDF, experiment, expected parts of the message)
LOOSE = {
    "wheel without inertia": (
        model("top", solid("top", 1.0, 0.0) + joint("P", "world", "top")), "",
        '<link name="top">: has no moment of inertia about the plane\'s normal, and can move while all masses rest (P)',
    ),
    "rod between two pins at one place": (
        model("arm", bar("arm", 0.2, "__model__") + massless("pin", at="arm_tip") + solid("end", 1.0, 0.1, at="arm_tip")
              + joint("A", "world", "arm") + joint("B", "arm", "pin") + joint("C", "pin", "end")), "",
        '<link name="pin">: has no mass, and can move while all masses rest (B and C)',
    ),
    "block in a bearing with clearance": (
        quick_return(BLOCK, BEARING), "[joints.A]\nmodel = 'dry'\nclearance = 1e-4\n[joints.A.contact]\nlaw = 'hunt-crossley'\n"
        "restitution = 0.9\nstiffness = 1e8\n", '<link name="block">: has no mass, and can move while all masses rest',
    ),
}  # fmt: skip


def crank_without_mass():
    """A slider of 1 kg that falls along its guide from rest; crank and rod, of 0.1 and 0.3 m, have no mass."""
    turn = np.radians(60.0)
    x, y = 0.1 * np.cos(turn), 0.1 * np.sin(turn)
    end = x + np.sqrt(0.09 - y**2)
    body = massless("crank") + massless("rod", f"{x} {y} 0 0 0 0") + solid("slider", 1.0, 0.01, f"{end} 0 0 0 0 0")
    body += joint("O", "world", "crank") + joint("A", "crank", "rod") + joint("B", "rod", "slider")
    guide = joint("guide", "world", "slider", "prismatic").replace("<xyz>0 0 1</xyz>", "<xyz>1 0 0</xyz>")
    return model("falling", body + guide), end


FALL = "duration = 1.0\ngravity = [9.81, 0.0, 0.0]\noutputs = ['slider.x', 'slider.vx']\n"


def test_a_run_ends_where_links_without_mass_become_free_of_all_masses(engine, system_of):
    """At the dead point the slider rests and the crank turns: v^2 = 2 g x up to there, and no number beyond."""
    sdf, start = crank_without_mass()
    found = simulate(system_of(sdf, FALL), engine)
    assert found.status is Status.FREE_OF_MASS
    assert 0.4 - 1e-4 < found["slider.x"][-1] < 0.4
    np.testing.assert_allclose(found["slider.vx"] ** 2, 2 * 9.81 * (found["slider.x"] - start), atol=1e-5)


def test_a_row_of_a_batch_ends_there_too(system_of):
    sdf, start = crank_without_mass()
    time = np.sqrt(2 * (0.4 - start) / 9.81)
    windows = [[0.0, 0.5 * time], [0.0, 1.0]]
    batch = simulate_batch(system_of(sdf, FALL), outputs=["slider.vx"], windows=windows)
    assert batch.status == [Status.FREE_OF_MASS]
    np.testing.assert_allclose(batch.maximum[0, :, 0], [0.5 * 9.81 * time, np.nan], rtol=1e-6)


@pytest.mark.parametrize("case", LOOSE)
def test_a_link_without_mass_that_can_move_alone_is_refused(system_of, case):
    sdf, text, said = LOOSE[case]
    with pytest.raises(InputError) as problem:
        _ = system_of(sdf, "duration = 0.1\n" + text).assembly
    assert said in str(problem.value)
    assert "give its mass and inertia" in str(problem.value)
    assert "\n" not in str(problem.value)


def test_an_end_without_mass_is_refused_as_it_is_read(mechanism_of):
    sdf = model(
        "arm",
        bar("arm", 0.2, "__model__")
        + massless("end", at="arm_tip")
        + joint("A", "world", "arm")
        + joint("B", "arm", "end"),
    )
    with pytest.raises(InputError, match='<link name="end">: has no <inertial>, or one without mass'):
        mechanism_of(sdf)
