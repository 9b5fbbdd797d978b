"""Linkages with films, closed loops and all kinds of drive: kinematics, planes, energy, Newton's law."""

import numpy as np
import pytest
from engines import slow_on_drake
from machines import BEARING, PLANES, bar, four_bar, joint, model, slider_crank, solid
from shipped import run as run_shipped

from linkages import InputError, ideal, impacts, simulate, simulate_batch
from linkages.input.model.plausibility import doubts
from linkages.results.extremes import integral

FILM = '[joints.{0}]\nmodel="lubricated"\nclearance=1e-4\nviscosity=0.1\n'
DRIVE = "duration=0.3\n[drives.O]\nspeed=15.0\n"


@pytest.mark.parametrize("sdf", [four_bar(), slider_crank(), slider_crank(offset=0.02, plane="xz")])
def test_ideal_loops_follow_the_exact_kinematics(run, system_of, sdf):
    """Every joint ideal: loops closed by multipliers and integrated, against closed kinematics and inverse dynamics."""
    text = DRIVE + "[solver]\naccuracy=1e-9\n"
    found, system = run(sdf, text), system_of(sdf, text)
    assert system.tree.loops
    assert found.provenance["loop_error"] < 1e-9  # m
    exact = ideal(system).evaluate(found.time)
    link = system.mechanism.links[-1].name
    np.testing.assert_allclose(found[f"{link}.x"], exact[f"{link}.x"], atol=1e-9)
    for name in ("O.torque", "A.force"):
        atol = 1e-6 * np.abs(exact[name]).max()
        np.testing.assert_allclose(found[name], exact[name], atol=atol)


@slow_on_drake
def test_an_ideal_loop_beside_a_joint_with_play(engine, seven_bar):
    """B ideal by multipliers against B with a film of a tenth of the clearance, which holds it a thousand times closer."""
    loop = seven_bar.replaced({"duration": 0.4, "joints.B": {"model": "ideal"}})
    assert loop.tree.loops
    run = simulate(loop, engine)
    assert run.provenance["loop_error"] < 1e-8  # m
    tight = simulate(seven_bar.replaced({"duration": 0.4, "joints.B.clearance": 3e-5}), engine)
    times = np.linspace(0.02, 0.38, 10)
    a, b = run.evaluate(times), tight.evaluate(times)
    size = np.hypot(a["A.ex"], a["A.ey"]).max()
    np.testing.assert_allclose(a["A.ex"], b["A.ex"], atol=1e-3 * size)
    np.testing.assert_allclose(a["A.ey"], b["A.ey"], atol=1e-3 * size)
    np.testing.assert_allclose(a["B.force"], b["B.force"], rtol=2e-3)


@slow_on_drake
@pytest.mark.parametrize("plane", [p for p in PLANES if p != "xy"])
def test_the_motion_does_not_depend_on_the_plane(run, plane):
    toml = DRIVE + FILM.format("A")
    times = np.linspace(0.02, 0.28, 8)
    a, b = (run(four_bar(plane=name), toml).evaluate(times) for name in ("xy", plane))
    size = np.hypot(a["A.ex"], a["A.ey"]).max()
    np.testing.assert_allclose(np.hypot(b["A.ex"], b["A.ey"]), np.hypot(a["A.ex"], a["A.ey"]), atol=1e-3 * size)
    np.testing.assert_allclose(b["A.force"], a["A.force"], rtol=1e-3)
    np.testing.assert_allclose(b["O.torque"], a["O.torque"], atol=1e-3 * np.abs(a["O.torque"]).max())


def test_a_joint_may_name_the_world_as_its_child(run):
    """The same motion with the opposite coordinate, force and torque."""
    times = np.linspace(0.0, 0.3, 8)
    there = run(four_bar(), DRIVE).evaluate(times)
    swapped = four_bar().replace(joint("O", "world", "crank"), joint("O", "crank", "world"))
    back = run(swapped, DRIVE.replace("15.0", "-15.0")).evaluate(times)
    for name, sign in (("follower.angle", 1.0), ("O.fx", -1.0), ("O.fy", -1.0), ("O.torque", -1.0), ("O.power", 1.0)):
        np.testing.assert_allclose(back[name], sign * there[name], atol=1e-5 * np.abs(there[name]).max())


@pytest.mark.parametrize("size", [1e-3, 100.0])
def test_the_accuracy_of_a_mass_on_a_slider_is_relative_to_its_size(run, size):
    """A single joint has no size of its own; x = s (1 - cos w t)."""
    rate, mass = 2.0 * np.pi, 7800.0 * size**3
    body = solid("block", mass, mass * size**2 / 6) + joint("G", "world", "block", "prismatic", "1 0 0")
    spring = f'[torsion_springs.S]\njoint = "G"\nstiffness = {mass * rate**2}\nfree_angle = {size}\n'
    found = run(model("block", body), "duration = 5.0\n" + spring)
    np.testing.assert_allclose(found["block.x"], size * (1.0 - np.cos(rate * found.time)), rtol=0, atol=1e-6 * size)


def test_joints_that_coincide_do_not_make_a_machine_small(run, system_of):
    """A cart on an inclined rail with a pendulum: the places of its joints differ by rounding; its momentum along it."""
    along, place = np.array([np.cos(0.7), np.sin(0.7)]), np.array([0.7 / 3.0, 0.1])
    cart = solid("cart", 0.5, 1e-3, f"{place[0]} {place[1]} 0 0 0 0.3")
    frames = [f'<frame name="F{k}" attached_to="cart"><pose>{k / 7} {k / 30} 0 0 0 0</pose></frame>' for k in (1, 2, 3)]
    rail = joint("G", "world", "cart", "prismatic", f"{np.cos(0.4)} {np.sin(0.4)} 0")
    sdf = model("cart", cart + "".join(frames) + bar("rod", 0.6, "cart", 0.4) + rail + joint("O", "cart", "rod"))
    toml = "duration = 1.0\n[drives.O]\ntorque = 0.0\nspeed = 4.0\n"
    system, found = system_of(sdf, toml), run(sdf, toml)
    assert system.tree.extent == pytest.approx(0.6)
    assert doubts(system.mechanism, system.tree.extent, system.experiment) == []
    cosine = np.cos(found["rod.angle"] + np.pi / 2.0 - 0.7)
    speed = np.column_stack([found["cart.vx"], found["cart.vy"]]) @ along
    momentum = 0.7 * speed + 0.2 * 0.3 * found["rod.omega"] * cosine
    np.testing.assert_allclose(momentum, momentum[0], rtol=0, atol=1e-6)


def test_a_rod_that_floats_on_two_films(run, system_of):
    toml = DRIVE + FILM.format("A") + FILM.format("B")
    found = run(slider_crank(), toml)
    exact = ideal(system_of(slider_crank(), toml)).evaluate(found.time)
    np.testing.assert_allclose(found["slider.x"], exact["slider.x"], atol=1e-4)
    settled = found.time > 0.02
    atol = 0.05 * exact["B.force"].max()
    np.testing.assert_allclose(found["B.force"][settled], exact["B.force"][settled], atol=atol)
    assert found["A.eccentricity_ratio"].max() > 0.01


def test_a_falling_four_bar_keeps_its_energy(run):
    """No drive at all: a closed loop under gravity, from rest; ideal joints lose nothing."""
    found = run(four_bar(), "duration=0.6\ngravity=[0.0, -9.81, 0.0]\n[solver]\naccuracy=1e-9\n")
    energy = found["kinetic_energy"] + found["potential_energy"]
    assert found["kinetic_energy"].max() > 0.05
    np.testing.assert_allclose(energy, energy[0], atol=1e-7)
    assert found.provenance["loop_error"] < 1e-8


def arm_torques(times, load):
    """Torques of shoulder and elbow (nt,) of `ARM`, turning by t^3 and sin(5 t): Lagrange's equations of two bars."""
    m, a, b, bend = 0.2, 0.3, 0.2, 0.5
    q2, w1, w2 = bend + np.sin(5.0 * times), 3.0 * times**2, 5.0 * np.cos(5.0 * times)
    a1, a2 = 6.0 * times, -25.0 * np.sin(5.0 * times)
    near, far, both = m * a**2 / 3 + m * a**2, m * b**2 / 3, m * a * b / 2
    elbow = (far + both * np.cos(q2)) * a1 + far * a2 + both * np.sin(q2) * w1**2
    shoulder = (near + both * np.cos(q2)) * a1 + both * (np.cos(q2) * a2 - np.sin(q2) * (w1 + w2) ** 2) + elbow
    return shoulder - load, elbow - load


ARM = model(
    "arm",
    bar("upper", 0.3, "__model__") + bar("lower", 0.2, "upper_tip", 0.5)
    + joint("S", "world", "upper") + joint("E", "upper_tip", "lower"),
)  # fmt: skip
MOVED = """duration = 0.5
[drives]
S = {formula = "t**3"}
E = {formula = "sin(5*t)"}
[torques]
screw = {link = "lower", formula = "0.5*sin(40*t)"}
"""


@pytest.mark.parametrize("integrator", ["dormand_prince_5_4", "radau_iia_5"])
def test_an_arm_whose_joints_are_all_driven_needs_the_torques_of_lagrange(run, integrator):
    """Neither loops nor anything free: the state has no entries, and the load varies faster than the motion."""
    found = run(ARM, MOVED + f'[solver]\nintegrator = "{integrator}"\naccuracy = 1e-10\n')
    exact = arm_torques(found.time, 0.5 * np.sin(40.0 * found.time))
    for name, torque in zip(("S.torque", "E.torque"), exact, strict=True):
        np.testing.assert_allclose(found[name], torque, rtol=0, atol=1e-9 * np.abs(torque).max())
    assert np.diff(found.time).max() < 0.1 * 2.0 * np.pi / 40.0  # extremes of the load are not stepped over


def test_a_batch_of_an_arm_whose_joints_are_all_driven(system_of):
    times = np.linspace(0.0, 0.5, 100_001)
    exact = [np.abs(torque).max() for torque in arm_torques(times, 0.5 * np.sin(40.0 * times))]
    batch = simulate_batch(system_of(ARM, MOVED), outputs=["S.torque", "E.torque"])
    np.testing.assert_allclose(batch.peak[0, 0], exact, rtol=1e-6)


STRUT = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">0.2 0 0 0 0 0</pose></frame>
{bar("left", 0.2, "__model__", np.pi / 3)}{bar("right", 0.2, "pivot", 2.0 * np.pi / 3)}
{joint("O", "world", "left")}{joint("Q", "world", "right")}
<frame name="A_on_right" attached_to="right"><pose>0.2 0 0 0 0 0</pose></frame>
{joint("A", "left_tip", "A_on_right", inner=BEARING)}"""


def test_a_linkage_that_only_its_play_lets_move_starts_with_a_speed(engine, system_of):
    """Two bars and the ground between three pins: a triangle, but for the play in one; each bar turns until it touches."""
    text = """gravity = [0.0, 0.0, 0.0]
[drives.O]
torque = 0.0
speed = 0.1
[joints.A]
model = "dry"
clearance = 5e-4
contact = {law = "lankarani-nikravesh", restitution = 0.9, youngs_modulus = 2e11}
"""
    system = system_of(model("strut", STRUT), f"duration = 0.03\n{text}")
    assert system.assembly.mobility == 0
    run = simulate(system, engine)
    free, touch = run.time < 0.0249, 5e-4 / (0.2 * 0.1)
    np.testing.assert_allclose(run["left.omega"][free], 0.1, rtol=0, atol=1e-9)
    np.testing.assert_allclose(run["right.omega"][free], 0.0, atol=1e-9)
    arc = 2.0 * 0.2 * np.sin(0.05 * run.time[free])
    np.testing.assert_allclose(run["A.eccentricity_ratio"][free], arc / 5e-4, rtol=0, atol=1e-6)
    (impact,) = impacts(run, ["A"])
    assert impact.start == pytest.approx(touch, abs=1e-6)
    assert abs(run["right.omega"][-1]) > 0.01
    assert run["kinetic_energy"][-1] < run["kinetic_energy"][0]


def test_a_speed_that_not_even_play_allows_is_refused(system_of):
    system = system_of(model("strut", STRUT), "duration = 0.03\n[drives.O]\ntorque = 0.0\nspeed = 0.1\n")
    with pytest.raises(InputError, match="0 degrees of freedom"):
        _ = system.assembly


def test_torque_drive_does_its_work(run, engine, system_of):
    """A crank under a tabulated torque: the work is the kinetic energy; its ideal counterpart is a separate run."""
    text = "duration=0.4\n[drives.O]\ntimes=[0.0, 0.2, 0.4]\ntorques=[0.02, 0.05, 0.01]\n[solver]\naccuracy=1e-9\n"
    text += FILM.format("A").replace("lubricated", "ideal")
    found = run(four_bar(), text)
    work = integral(found, found["O.torque"] * found["O.rate"])
    assert work > 1e-3
    assert found["kinetic_energy"][-1] == pytest.approx(work, rel=1e-5)
    assert found["O.torque"][found.time >= 0.2][0] == pytest.approx(0.05, abs=2e-3)
    counterpart = ideal(system_of(four_bar(), text), engine)
    assert counterpart.provenance["engine"] == engine


@slow_on_drake
def test_ramped_drive_starts_at_rest_and_follows(run):
    found = run(four_bar(), "duration=0.4\n[drives.O]\nspeed=15.0\nramp=0.2\n" + FILM.format("A"))
    assert found["O.rate"][0] == 0.0
    assert found["O.rate"][-1] == pytest.approx(15.0, abs=1e-5)
    assert found["q.O"][-1] == pytest.approx(15.0 * (0.4 - 0.1), abs=1e-6)


def test_reactions_satisfy_newtons_law_of_the_slider(engine):
    """Only D and the guide act on the slider: m a_x = F_D,x whatever path it was computed by."""
    run = run_shipped(engine, "seven_bar", duration=0.2)
    np.testing.assert_allclose(run["D.fx"], 0.139 * run["slider7.ax"], atol=1e-9)
    assert np.abs(run["D.fx"]).max() > 0.1
