"""Linear state-space models against closed forms, natural frequencies, and starts of runs."""

import json

import numpy as np
import pytest
from machines import bar, four_bar, joint, model, rotor_in_block, solid
from shipped import shipped

from linkages import InputError, RunError, linearise, modes, simulate
from linkages.cli.main import main
from linkages.explore.flow import Flow

LENGTH, MASS, GRAVITY = 0.4, 0.5, 9.81
INERTIA = MASS * LENGTH**2 / 3.0  # of a uniform bar about its end
WEIGHT = f"gravity = [0.0, {-GRAVITY}, 0.0]\nduration = 1.0\n"


@pytest.fixture
def pendulum(system_of):
    """A bar that hangs on the world, with a damped torsion spring and a torque."""

    def make(angle=0.3, torque=0.7, damping=0.02, stiffness=0.4):
        body = bar("rod", LENGTH, "__model__", -np.pi / 2, mass=MASS) + joint("O", "world", "rod")
        text = f"""{WEIGHT}outputs = ["rod_tip.x"]
[drives.O]
angle = {angle}
torque = {torque}
[torsion_springs.S]
joint = "O"
stiffness = {stiffness}
free_angle = 0.0
damping = {damping}
"""
        return system_of(model("pendulum", body), text)

    return make


def test_a_pendulum_has_the_matrices_of_the_textbook(pendulum):
    angle, damping, stiffness = 0.3, 0.02, 0.4
    found = linearise(pendulum(angle), ["rod_tip.x", "O.fx", "O.torque"])
    slope = -(0.5 * MASS * GRAVITY * LENGTH * np.cos(angle) + stiffness) / INERTIA
    np.testing.assert_allclose(found.A, [[0.0, 1.0], [slope, -damping / INERTIA]], rtol=1e-12)
    np.testing.assert_allclose(found.B, [[0.0], [1.0 / INERTIA]], rtol=1e-12)
    assert found.states, found.inputs == (("q.O", "v.O"), ("O.torque",))
    # the pin pulls the mass centre: m x'' along x, with x = sin(angle) L/2
    acceleration = (0.7 - 0.5 * MASS * GRAVITY * LENGTH * np.sin(angle) - stiffness * angle) / INERTIA
    half = 0.5 * MASS * LENGTH
    pulls = [half * (np.cos(angle) * slope - np.sin(angle) * acceleration), -half * np.cos(angle) * damping / INERTIA]
    np.testing.assert_allclose(found.C, [[LENGTH * np.cos(angle), 0.0], pulls, [0.0, 0.0]], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(found.D, [[0.0], [half * np.cos(angle) / INERTIA], [1.0]], rtol=1e-11, atol=1e-12)
    assert not found.at_rest
    assert found.error < 1e-10


def test_the_equilibrium_of_a_pendulum_balances_its_torque(pendulum):
    found = linearise(pendulum(angle=0.0, torque=0.5, stiffness=0.0), equilibrium=True)
    angle = np.arcsin(0.5 / (0.5 * MASS * GRAVITY * LENGTH))
    assert found.at_rest
    np.testing.assert_allclose(found.x, [angle, 0.0], rtol=1e-14)
    np.testing.assert_allclose(found.y, [LENGTH * np.sin(angle)], rtol=1e-14)
    upright = linearise(pendulum(angle=3.0, torque=0.0, stiffness=0.0), equilibrium=True)
    assert upright.x[0] == pytest.approx(np.pi, rel=1e-14)
    assert upright.poles[0].real > 0.0
    with pytest.raises(RunError, match="no equilibrium"):
        linearise(pendulum(angle=0.0, torque=2.0, stiffness=0.0), equilibrium=True)
    pushed = shipped("slider_crank_dry", **{"joints": {}, "drives.O": {"torque": 1.0}})
    with pytest.raises(RunError, match="no equilibrium"):  # the slope vanishes where the rod lies along the crank
        linearise(pushed, equilibrium=True)


ROTOR = """duration = 0.01
drives.O = {speed = 0.0}
forces.F = {point = "block", force = [0.0, 300.0]}
[joints.A]
model = "lubricated"
film = "short"
clearance = 5e-5
viscosity = 0.03
"""


def test_a_journal_outside_its_film_is_no_state(system_of):
    """A film without motion has no pressure: it carries no load, and the loaded journal has no equilibrium."""
    loaded = system_of(rotor_in_block(), ROTOR)
    with pytest.raises(RunError, match=r"no equilibrium .* inside its film"):
        linearise(loaded, equilibrium=True)
    assert linearise(loaded.replaced({"forces": {}}), ["A.ex"], equilibrium=True).at_rest
    thin = loaded.replaced({"joints.A.offset": [0.99995 * 5e-5, 0.0]})
    with pytest.raises(RunError, match="journal-left-bearing at t = 0 s"):
        linearise(thin)
    flow, beyond = Flow(loaded), loaded.replaced({"joints.A.offset": [0.0, 4e-5]})
    flow.resume(0.0, Flow(beyond).y, flow.memory, 0.0)
    with pytest.raises(RunError, match="journal-left-bearing"):
        flow.resume(0.0, 2.0 * Flow(beyond).y, flow.memory, 0.0)


def test_a_mass_on_a_spring_has_the_frequency_response_of_the_textbook(system_of, tmp_path):
    mass, stiffness, damping = 0.14, 300.0, 1.3
    slider = solid("slider", mass, 1e-4, "0.2 0 0 0 0 0")
    sdf = model("mass", slider + joint("guide", "world", "slider", "prismatic", "1 0 0"))
    text = f"""duration = 1.0
outputs = ["slider.x"]
[springs.S]
point = "slider"
anchor = [0.0, 0.0]
stiffness = {stiffness}
free_length = 0.2
damping = {damping}
[forces.F]
point = "slider"
formula = ["-2*slider.vx", "0"]
"""
    found = linearise(system_of(sdf, text), ["slider.x", "slider.ax", "S.force"], ["F.fx"])
    assert found.at_rest
    assert found.states == ("q.guide", "v.guide")
    assert found.units == {"slider.x": "m", "slider.ax": "m/s2", "S.force": "N", "F.fx": "N"}
    omega = np.array([1.0, 40.0, 46.3, 1e3])
    s = 1j * omega
    x = 1.0 / (mass * s**2 + (damping + 2.0) * s + stiffness)
    expected = np.array([x, s**2 * x, (stiffness + damping * s) * x])
    np.testing.assert_allclose(found.frequency_response(omega)[:, 0], expected, rtol=1e-9)
    found.save(tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as kept:
        assert list(kept["outputs_units"]) == ["m", "m/s2", "N"]
        for name in "ABCD":
            np.testing.assert_array_equal(kept[name], getattr(found, name))


def double_pendulum(q, v, torque):
    """Accelerations of two uniform bars, angles of each from the reference pose (both hang); q2 is relative."""
    half, c, s = 0.5 * LENGTH, np.cos(q[1]), np.sin(q[1])
    own = MASS * LENGTH**2 / 12.0
    cross = MASS * LENGTH * half
    m22 = own + MASS * half**2
    m12 = m22 + cross * c
    m11 = 2.0 * own + MASS * half**2 + MASS * (LENGTH**2 + half**2) + 2.0 * cross * c
    bias = cross * s * np.array([-2.0 * v[0] * v[1] - v[1] ** 2, v[0] ** 2])
    weight = MASS * GRAVITY * half * np.sin(q[0] + q[1])
    load = np.array([MASS * GRAVITY * (half + LENGTH) * np.sin(q[0]) + weight, weight])
    return np.linalg.solve(np.array([[m11, m12], [m12, m22]]), np.array([torque, 0.0]) - bias - load)


@pytest.mark.parametrize("time", [0.0, 0.37])
def test_a_double_pendulum_in_motion(system_of, time):
    rods = bar("one", LENGTH, "__model__", -np.pi / 2, MASS) + bar("two", LENGTH, "one_tip", 0.0, MASS)
    sdf = model("double", rods + joint("O", "world", "one") + joint("A", "one_tip", "two"))
    system = system_of(sdf, WEIGHT + "[drives.O]\nangle = 0.4\nspeed = 2.0\ntorque = 0.3\n")
    found = linearise(system, time=time)
    assert found.states == ("q.O", "q.A", "v.O", "v.A")
    q, v = found.x[:2], found.x[2:]
    expected = np.zeros((4, 4))
    expected[:2, 2:] = np.eye(2)
    for k in range(4):  # complex steps are exact
        moved = np.concatenate([q, v]).astype(complex)
        moved[k] += 1e-30j
        expected[2:, k] = double_pendulum(moved[:2], moved[2:], 0.3).imag / 1e-30
    np.testing.assert_allclose(found.A, expected, rtol=1e-11, atol=1e-10)
    np.testing.assert_allclose(found.C, np.eye(2, 4), atol=1e-11)


def test_a_four_bar_in_motion_agrees_with_starts_of_other_runs(system_of):
    """The accelerations of its loop at other starts, by finite differences: the change of rates with the pose counts."""
    text = WEIGHT + "[drives.O]\nangle = 0.9\nspeed = 6.0\ntorque = 0.2\n"
    system = system_of(four_bar(), text)
    found = linearise(system, ["coupler_tip.ay", "follower.omega", "B.force"])
    assert found.states == ("q.O", "v.O")

    def start(angle, speed, torque):
        run = simulate(
            system.replaced({"drives.O": {"angle": angle, "speed": speed, "torque": torque}, "duration": 1e-4})
        )
        return np.array([run[name][0] for name in ("crank.alpha", "coupler_tip.ay", "follower.omega", "B.force")])

    h, base = 1e-4, np.array([0.9, 6.0, 0.2])
    slopes = np.array([(start(*(base + h * e)) - start(*(base - h * e))) / (2.0 * h) for e in np.eye(3)]).T
    np.testing.assert_allclose(found.A[1], slopes[0, :2], rtol=1e-6)
    np.testing.assert_allclose(found.B[1], slopes[0, 2:], rtol=1e-6)
    np.testing.assert_allclose(found.C, slopes[1:, :2], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(found.D, slopes[1:, 2:], rtol=1e-6, atol=1e-7)


def test_the_poles_of_a_flexible_linkage_are_its_natural_modes():
    system = shipped("slider_crank_flexible", **{"drives.O.speed": 0.0, "joints": {}})
    poles, found = linearise(system).poles, modes(system)
    upper = poles[poles.imag > 0.0]
    upper = upper[np.argsort(np.abs(upper))]
    np.testing.assert_allclose(np.abs(upper) / (2.0 * np.pi), found.frequencies, rtol=1e-9)
    np.testing.assert_allclose(-upper.real / np.abs(upper), found.damping, rtol=1e-8)


def test_a_moving_drive_a_closed_contact_and_unknown_names_are_refused(pendulum):
    with pytest.raises(InputError, match=r"drives\.O: prescribes a motion; give the torque"):
        linearise(shipped("slider_crank_dry"))
    with pytest.raises(InputError, match=r'inputs: "O\.torqe" is unknown; .*O\.torque'):
        linearise(pendulum(), inputs=["O.torqe"])
    with pytest.raises(InputError, match="rod_tip"):
        linearise(pendulum(), outputs=["rod_tip.z"])
    with pytest.raises(InputError, match="nothing can move"):  # its loop has a free coordinate, which the drive holds
        linearise(shipped("slider_crank_dry", joints={}, **{"drives.O.speed": 0.0}))
    touching = shipped("slider_crank_dry", **{"duration": 0.1, "drives.O": {"angle": 0.5, "torque": 9.0}})
    with pytest.raises(InputError, match="B: is closed at this state"):
        linearise(touching, time=9.6e-4)


def test_the_command_writes_the_model(tmp_path, capsys):
    words = ["linearise", "slider_crank_dry.toml", "--set", "joints={}", "--out", str(tmp_path)]
    words += [
        "--set",
        'drives.O={torque=0.0, angle="30 deg"}',
        "--set",
        'springs.S={point="slider", anchor=[0.0, 0.0]}',
    ]
    words += ["--set", "springs.S.stiffness=1e4", "--set", "springs.S.free_length=0.4"]
    more = ["--equilibrium", "--output", "slider.x", "--frequencies", "1:100:20"]
    assert main([*words, *more]) == 0
    shown = capsys.readouterr().out
    assert "equilibrium" in shown
    content = json.loads((tmp_path / "linear.json").read_text())
    with np.load(tmp_path / "linear.npz") as kept:
        np.testing.assert_array_equal(kept["A"], content["A"])
        assert list(kept["states"]) == list(content["states"]) == ["q.O", "v.O"]
    assert content["at_rest"]
    assert (tmp_path / "bode.png").stat().st_size > 10_000
    for wrong in ("1:1:5", "0:1:5", "1:2:1", "1:2", "a:b:c"):
        assert main([*words, "--frequencies", wrong]) == 2
        assert capsys.readouterr().err.startswith("error: --frequencies: ")
