"""Applied loads: closed forms, energy balances, equilibrium, comparison with the ideal linkage."""

import numpy as np
import pytest
from engines import slow_on_drake
from machines import bar, four_bar, joint, model, solid
from scipy.integrate import simpson

from linkages import assess, ideal, summarize
from linkages.show.report.terminal import format_summary

#: A block of 2 kg on a slide along x, drawn at the origin.
BLOCK = model("block", solid("block", 2.0) + joint("slide", "world", "block", "prismatic", "1 0 0"))
EXACT = "[solver]\nintegrator = 'dormand_prince_5_4'\naccuracy = 1e-10\n"


@pytest.mark.parametrize("damping", [0.0, 6.0])
def test_a_mass_on_a_spring_oscillates_as_its_closed_form(run, damping):
    """Drawn 0.3 m from its anchor, 0.1 m beyond the free length, released from rest."""
    k, m, stretch = 50.0, 2.0, 0.1
    toml = f"""duration = 3.0
[springs.S]
point = "block"
anchor = [-0.3, 0.0]
stiffness = {k}
free_length = 0.2
damping = {damping}
"""
    found = run(BLOCK, toml + EXACT)
    t = found.time
    decay = damping / (2 * m)
    omega = np.sqrt(k / m - decay**2)
    wave = stretch * np.exp(-decay * t)
    offset = wave * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    speed = -wave * k / (m * omega) * np.sin(omega * t)
    tolerance = 1e-8 * stretch  # a hundred times the accuracy: errors of all steps
    np.testing.assert_allclose(found["block.x"], offset - stretch, atol=tolerance)
    np.testing.assert_allclose(found["block.vx"], speed, atol=omega * tolerance)
    np.testing.assert_allclose(found["S.length"], 0.2 + offset, atol=tolerance)
    np.testing.assert_allclose(found["S.force"], k * offset + damping * speed, atol=2 * k * tolerance)
    np.testing.assert_allclose(found["potential_energy"], 0.5 * k * offset**2, atol=k * stretch * tolerance)
    np.testing.assert_allclose(2.0 * found["block.ax"], -found["S.force"], atol=1e-9)


def test_a_force_over_time_moves_a_mass(run):
    """A force that grows with t: the table's cubics are exact there, x = F t^3/(6 m)."""
    toml = """duration = 1.0
[forces.P]
point = "block"
times = [0.0, 0.2, 0.7, 1.5]
forces = [[0.0, 3.0], [1.2, 3.0], [4.2, 3.0], [9.0, 3.0]]
"""
    found = run(BLOCK, toml + EXACT)
    np.testing.assert_allclose(found["block.x"], 6.0 * found.time**3 / 12.0, atol=1e-9)
    np.testing.assert_allclose(found["slide.fy"], -3.0, atol=1e-12)  # the guide carries the transverse force
    np.testing.assert_allclose(found["P.power"], 6.0 * found.time * found["block.vx"], atol=1e-9)


DRAG = {
    "of a point": 'formula = ["3 - 0.5*block.vx**2", "0"]\n',
    "of a joint": 'formula = ["3 - 0.5*slide.rate*abs(slide.rate)", "0"]\n',
}


@pytest.mark.parametrize("drag", DRAG)
def test_a_mass_in_a_stream_reaches_its_speed_as_its_closed_form(run, drag):
    """m dv/dt = P - c v^2 from rest: v = sqrt(P/c) tanh(t sqrt(P c)/m); power and work follow from it."""
    found = run(BLOCK, "duration = 3.0\n[forces.P]\npoint = 'block'\n" + DRAG[drag] + EXACT)
    speed = np.sqrt(6.0) * np.tanh(found.time * np.sqrt(1.5) / 2.0)
    assert speed[-1] > 2.2
    np.testing.assert_allclose(found["block.vx"], speed, atol=1e-8)
    np.testing.assert_allclose(found["P.fx"], 3.0 - 0.5 * speed**2, atol=2e-8)
    np.testing.assert_allclose(found["P.power"], found["P.fx"] * found["block.vx"], atol=1e-12)


def test_a_spring_by_a_table_over_the_position_oscillates_as_its_closed_form(run):
    """A straight line is a monotone cubic too."""
    toml = """duration = 2.0
[forces.pull]
point = "block"
over = "block.x"
at = ["-100 mm", 0.0, "300 mm"]
forces = [[10.0, 0.0], [5.0, 0.0], [-10.0, 0.0]]
"""
    found = run(BLOCK, toml + EXACT)
    np.testing.assert_allclose(found["block.x"], 0.1 * (1.0 - np.cos(5.0 * found.time)), atol=1e-8)


@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1"])
@pytest.mark.parametrize(
    "law", ["formula = '0.6 - 0.05*O.rate'", "over = 'O.rate'\nat = [0.0, 12.0]\ntorques = [0.6, 0.0]"]
)
def test_a_motor_with_a_falling_characteristic_runs_up_as_its_closed_form(run, axis, law):
    """Torque 0.6 N m less 0.05 N m s/rad: the speed goes to 12 rad/s with the time constant J/0.05."""
    sdf = model("arm", bar("arm", 0.4, "__model__", mass=1.5) + joint("O", "world", "arm", axis=axis))
    found = run(sdf, f"duration = 3.0\n[torques.motor]\njoint = 'O'\n{law}\n" + EXACT)
    rate = 12.0 * (1.0 - np.exp(-found.time * 0.05 / 0.08))
    np.testing.assert_allclose(found["arm.omega"], rate if axis == "0 0 1" else -rate, atol=1e-7)
    np.testing.assert_allclose(found["motor.power"], (0.6 - 0.05 * rate) * rate, atol=1e-6)


@pytest.mark.parametrize(
    "where", ['joint = "O"', 'links = ["world", "arm"]', 'links = ["arm", "world"]\nstiffness = 3.0']
)
@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1"])
def test_a_torsion_pendulum_oscillates_as_its_closed_form(run, axis, where):
    """Released in the reference configuration; in a joint the angle is the joint's, between links the second's from the first."""
    sdf = model("arm", bar("arm", 0.4, "__model__", mass=1.5) + joint("O", "world", "arm", axis=axis))
    spring = f"[torsion_springs.T]\n{where}\nfree_angle = 0.3\ndamping = 0.02\n"
    spring += "" if "stiffness" in where else "stiffness = 3.0\n"
    found = run(sdf, "duration = 2.0\n" + spring + EXACT)
    towards = -1.0 if ("joint" in where and axis == "0 0 -1") or where.startswith('links = ["arm"') else 1.0
    t, inertia = found.time, 1.5 * 0.4**2 / 3
    decay = 0.02 / (2 * inertia)
    omega = np.sqrt(3.0 / inertia - decay**2)
    angle = 0.3 * (1.0 - np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t)))
    np.testing.assert_allclose(found["arm.angle"], towards * angle, atol=3e-9)
    np.testing.assert_allclose(found["T.angle"], angle, atol=3e-9)
    np.testing.assert_allclose(found["arm.alpha"] * inertia, -towards * found["T.torque"], atol=1e-9)


@pytest.mark.parametrize("axis", ["1 0 0", "-0.6 0.8 0"])
@pytest.mark.parametrize("parent", ["world", "carrier"])
def test_a_spring_in_a_slider_oscillates_as_its_closed_form(run, axis, parent):
    """On the world, and on a carrier that turns at a constant speed: the centrifugal force softens the spring."""
    turning = 4.0 if parent == "carrier" else 0.0
    body = solid("block", 2.0) + joint("slide", parent, "block", "prismatic", axis)
    text = "duration = 1.0\noutputs = ['block.x', 'block.y']\n"
    if turning:
        body += bar("carrier", 0.1, "__model__") + joint("O", "world", "carrier")
        text += f"[drives.O]\nspeed = {turning}\n"
    spring = "[torsion_springs.S]\njoint = 'slide'\nstiffness = 1000.0\nfree_angle = 0.1\ndamping = 5.0\n"
    found = run(model("m", body), text + spring + EXACT)
    t, decay, square = found.time, 5.0 / (2.0 * 2.0), 1000.0 / 2.0 - turning**2  # m x'' = -k (x - x0) - c x' + m w^2 x
    middle, omega = 1000.0 * 0.1 / (2.0 * square), np.sqrt(square - decay**2)
    x = middle * (1.0 - np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t)))
    rate = middle * np.exp(-decay * t) * square / omega * np.sin(omega * t)
    np.testing.assert_allclose(found["S.displacement"], x, atol=1e-8)
    np.testing.assert_allclose(found["S.force"], 1000.0 * (x - 0.1) + 5.0 * rate, atol=1e-5)
    np.testing.assert_allclose(found["S.power"], -(1000.0 * (x - 0.1) + 5.0 * rate) * rate, atol=1e-5)
    way = np.exp(1j * turning * t) * complex(*map(float, axis.split()[:2]))
    np.testing.assert_allclose(found["block.x"] + 1j * found["block.y"], x * way, atol=1e-8)


LOADED = """duration = 0.4
outputs = ["follower.omega"]
[drives.O]
speed = 15.0
[springs.S]
point = "coupler_tip"
anchor = [-0.1, 0.1]
stiffness = 200.0
free_length = 0.2
[springs.damper]
point = "elbow"
to = "follower"
stiffness = 0.0
free_length = 0.0
damping = 4.0
[torsion_springs.hinge]
joint = "Q"
stiffness = 2.0
free_angle = 0.5
damping = 0.01
[torques.load]
link = "follower"
times = [0.0, 0.1, 0.3, 0.5]
torques = [0.0, -0.5, 0.2, 0.0]
"""
ELBOW = '<frame name="elbow" attached_to="coupler"><pose>0.1 0.08 0 0 0 0</pose></frame>'
PLAY = '[joints.A]\nmodel = "lubricated"\nclearance = 1e-4\nviscosity = 0.1\n'


@slow_on_drake
@pytest.mark.parametrize(
    ("drive", "play"), [("", ""), ("", PLAY), ("torque = 0.4\n", "")], ids=["ideal", "play", "torque"]
)
def test_energy_balance_of_a_driven_linkage_with_springs_and_dampers(run, drive, play):
    """Drive, torque, dampers and film account for all energy; springs return their stored energy."""
    found = run(four_bar(extra=ELBOW), LOADED.replace("speed = 15.0\n", "speed = 15.0\n" + drive) + play)
    times = np.linspace(0.1, 0.4, 401)  # after the film's start-up, which takes microseconds
    found = found.evaluate(times)
    hinge_loss = -0.01 * found["follower.omega"] ** 2
    along, rate = (
        np.array([found[f"elbow.{axis}"] - found[f"follower.{axis}"] for axis in axes])
        for axes in (("x", "y"), ("vx", "vy"))
    )
    damper_rate = np.sum(along * rate, axis=0) / np.hypot(*along)
    assert np.abs(damper_rate).max() > 0.9
    np.testing.assert_allclose(found["damper.force"], 4.0 * damper_rate, atol=1e-9)
    power = found["O.torque"] * found["O.rate"] + found["load.power"] + found["damper.power"] + hinge_loss
    if play:
        power = power + found["A.power"]
    energy = found["kinetic_energy"] + found["potential_energy"]
    size = np.ptp(energy)
    assert size > 0.1
    assert simpson(power, x=times) == pytest.approx(energy[-1] - energy[0], abs=1e-5 * size)
    stored = found["S.power"] + found["hinge.power"] - hinge_loss
    change = found["potential_energy"][-1] - found["potential_energy"][0]
    assert abs(change) > 0.1
    assert simpson(stored, x=times) == pytest.approx(-change, abs=1e-6)


def test_run_and_inverse_dynamics_agree_on_a_loaded_ideal_linkage(run, system_of):
    """Multipliers of closed loops, integrated, against the forces of the exact motion."""
    given = four_bar(extra=ELBOW), LOADED, {"gravity": [0.0, -9.81, 0.0]}
    found, exact = run(*given), ideal(system_of(*given))
    assert exact.provenance["engine"] == "kinematics"
    times = np.linspace(0.01, 0.39, 39)
    a, b = found.evaluate(times), exact.evaluate(times)
    for name in ("O.torque", "O.fx", "A.fy", "B.fx", "Q.fy", "S.force", "damper.force", "hinge.torque"):
        size = np.abs(b[name]).max()
        np.testing.assert_allclose(a[name], b[name], atol=1e-6 * size, err_msg=name)


def test_the_summary_and_the_table_show_the_loads(engine, system_of):
    """A force at rest does no work; a spring's peak is at its extreme length, its work is the returned energy."""
    toml = """duration = 0.9
[forces.P]
point = "block"
force = [0.0, 3.0]
[springs.S]
point = "block"
anchor = [-0.3, 0.0]
stiffness = 50.0
free_length = 0.2
"""
    # work is integrated over the run's steps: 1.5e-4 off at the default accuracy, with 23 steps, 8e-6 at 1e-8
    summary = summarize(assess(system_of(BLOCK, toml, {"solver.accuracy": 1e-8}), engine))
    assert summary["loads"]["P"]["force"]["peak"] == 3.0
    assert summary["loads"]["P"]["work"] == 0.0
    spring = summary["loads"]["S"]
    assert spring["force"]["peak"] == pytest.approx(50.0 * 0.1, rel=1e-6)
    released = 25.0 * 0.1**2 * (1.0 - np.cos(5.0 * 0.9) ** 2)
    assert spring["work"] == pytest.approx(released, rel=1e-4)
    assert summary["error"]["S.force.peak"] < 1e-4
    assert summary["ideal"]["loads"]["P"]["force"]["peak"] == 3.0
    row = next(line for line in format_summary(summary).splitlines() if line.startswith("S force"))
    ideal, now, _, _, work, unit = row.partition("]")[2].split()
    assert (float(ideal), float(now)) == (5.0, 5.0)
    assert (float(work), unit) == (pytest.approx(1e3 * released, rel=5e-3), "mJ")  # as printed


def test_a_bar_hung_on_a_spring_rests_where_statics_says(run):
    """A bar of 1.5 kg, pinned at one end, level, held at the other by a slanting spring: pin reaction in closed form."""
    weight, length = 1.5 * 9.81, 0.4
    sdf = model("bar", bar("bar", length, "__model__", mass=1.5) + joint("O", "world", "bar"))
    anchor = np.array([0.7, 0.4])
    line = anchor - [length, 0.0]
    direction = line / np.linalg.norm(line)
    tension = 0.5 * weight / direction[1]  # moments about the pin
    toml = f"""duration = 0.2
gravity = [0.0, -9.81, 0.0]
[springs.S]
point = "bar_tip"
anchor = [0.7, 0.4]
stiffness = 400.0
free_length = {np.linalg.norm(line) - tension / 400.0}
"""
    found = run(sdf, toml)
    np.testing.assert_allclose(found["bar.angle"], 0.0, atol=1e-12)
    np.testing.assert_allclose(found["S.force"], tension, rtol=1e-11)
    np.testing.assert_allclose(found["O.fx"], -tension * direction[0], rtol=1e-11)
    np.testing.assert_allclose(found["O.fy"], weight - tension * direction[1], rtol=1e-11)
