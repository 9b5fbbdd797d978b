"""Reference machines on the compiled engine: published values, closed forms, singular positions, long runs."""

import andrews
import numpy as np
import pytest
from machines import bar, joint, model, slider_crank
from reference_machines import (
    chain_sdf,
    double_pendulum,
    equal_slider_crank_angle,
    equal_slider_crank_sdf,
    parallelogram_angle,
    parallelogram_sdf,
    slider_crank_motion,
)

from linkages.engines.compiled.simulation import simulate
from linkages.errors import Status
from linkages.model.experiment import load


@pytest.fixture
def run(experiment_file):
    """Simulate a machine of the plane x-y."""

    def simulated(sdf, toml, accuracy=1e-12):
        mechanism, experiment = load(experiment_file(sdf, toml + f"[solver]\naccuracy = {accuracy}\n"))
        trajectory = simulate(mechanism, experiment)
        assert trajectory.status is Status.OK
        assert trajectory.provenance["loop_error"] <= 1e-10
        return trajectory

    return simulated


SQUEEZER = f"""duration = {andrews.END_TIME}
gravity = [0.0, 0.0, 0.0]
[drives.O]
torque = {andrews.TORQUE}
[springs.S]
point = "spring_K3"
to = "spring_ground"
stiffness = {andrews.STIFFNESS}
free_length = {andrews.REST_LENGTH}
"""


def test_squeezing_mechanism_ends_as_published(run):
    """Torque, spring, three loops; digits as in the test of the independent model: angles 1e-9, rates 1e-7."""
    last = run(andrews.andrews_sdf(), SQUEEZER)
    for published, suffix, digits in (
        (andrews.END, "angle", 1e-9), (andrews.END_RATE, "omega", 1e-7), (andrews.END_ACCELERATION, "alpha", 1e-5)
    ):  # fmt: skip
        expected = andrews.TURNS @ published
        got = np.array([last[f"K{b + 1}.{suffix}"][-1] for b in range(7)])
        np.testing.assert_allclose(
            got, expected, rtol=0, atol=digits * np.abs(published).max(), err_msg=suffix
        )


def test_squeezing_mechanism_moves_as_the_independent_model(run):
    trajectory = run(andrews.andrews_sdf(), SQUEEZER)
    q, v = andrews.andrews_model().solve(andrews.START, np.zeros(7), trajectory.time, 1e-13)
    for name, values in andrews.columns(q, v).items():
        atol = 1e-9 * np.abs(values).max()
        np.testing.assert_allclose(trajectory[name], values, rtol=0, atol=atol, err_msg=name)


@pytest.mark.parametrize("integrator", ["runge_kutta5", "radau3"])
def test_double_pendulum_swings_as_lagrange_says_and_keeps_its_energy(experiment_file, integrator):
    lengths, angles = (0.3, 0.2), (0.4, -0.9)
    text = f'duration = 2.0\ngravity = [0.0, -9.81, 0.0]\n[solver]\naccuracy = 1e-12\nintegrator = "{integrator}"\n'
    trajectory = simulate(*load(experiment_file(chain_sdf(lengths, angles), text)))
    assert (
        trajectory.provenance["method"]
        == {"runge_kutta5": "dormand-prince-5", "radau3": "radau-iia-5"}[integrator]
    )
    q, v = double_pendulum(lengths, angles, trajectory.time)
    for i in range(2):
        np.testing.assert_allclose(trajectory[f"bar{i + 1}.angle"], q[:, i], rtol=0, atol=1e-8)
        np.testing.assert_allclose(trajectory[f"bar{i + 1}.omega"], v[:, i], rtol=0, atol=1e-7)
    energy = trajectory["kinetic_energy"] + trajectory["potential_energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=1e-9 * trajectory["kinetic_energy"].max())


def test_ideal_slider_crank_moves_as_its_closed_form(run):
    """With reactions and drive torque."""
    text = "duration = 0.25\ngravity = [0.0, -9.81, 0.0]\n[drives.O]\nspeed = 30.0\n"
    text += "".join(f'[joints.{name}]\nmodel = "ideal"\n' for name in "AB")
    trajectory = run(slider_crank(), text)
    for name, values in slider_crank_motion(30.0 * trajectory.time, 30.0, gravity=9.81).items():
        atol = 1e-9 * np.abs(values).max()
        np.testing.assert_allclose(trajectory[name], values, rtol=0, atol=atol, err_msg=name)


@pytest.mark.parametrize("accuracy", [1e-6, 1e-9, 1e-12])
def test_parallelogram_passes_its_flat_positions(run, accuracy):
    text = "duration = 0.9\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = 0.01\nspeed = 6.0\n"
    trajectory = run(parallelogram_sdf(), text, accuracy)
    theta, rate = parallelogram_angle(trajectory.time, 0.01, 6.0)
    assert theta[-1] > 2.0 * np.pi
    for link in ("crank", "follower"):
        np.testing.assert_allclose(trajectory[f"{link}.angle"], theta, rtol=0, atol=1e-6)
        np.testing.assert_allclose(trajectory[f"{link}.omega"], rate, rtol=0, atol=1e-5)
    np.testing.assert_allclose(trajectory["coupler.angle"], 0.0, atol=1e-6)


@pytest.mark.parametrize("accuracy", [1e-6, 1e-9, 1e-12])
def test_equal_slider_crank_passes_its_singular_positions(run, accuracy):
    text = "duration = 1.2\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = 0.02\nspeed = 6.0\n"
    trajectory = run(equal_slider_crank_sdf(), text, accuracy)
    theta, rate = equal_slider_crank_angle(trajectory.time, 0.02, 6.0)
    assert theta[-1] > 2.0 * np.pi
    np.testing.assert_allclose(trajectory["crank.angle"], theta, rtol=0, atol=1e-6)
    error = np.abs(trajectory["crank.omega"] - rate)
    apart = (
        np.abs(np.cos(theta)) > 1e-2
    )  # nearer the loop's rows are all but dependent: rates have few digits
    assert error[apart].max() < 1e-5
    assert error.max() < 1e-3
    np.testing.assert_allclose(trajectory["rod.angle"], -theta, rtol=0, atol=1e-6)


def drag_link() -> str:
    """A four-bar whose crank and follower both turn fully, every pin ideal; it coasts for ever."""
    ground, crank, coupler, follower = 0.1, 0.2, 0.18, 0.22
    pin = crank * np.exp(1j * np.pi / 2)
    reach = ground - pin
    inner = (coupler**2 + abs(reach) ** 2 - follower**2) / (2 * coupler * abs(reach))
    coupler_angle = np.angle(reach) + np.arccos(inner)
    follower_angle = np.angle(pin + coupler * np.exp(1j * coupler_angle) - ground)
    body = f"""
<frame name="pivot" attached_to="world"><pose relative_to="__model__">{ground} 0 0 0 0 0</pose></frame>
{bar("crank", crank, "__model__", np.pi / 2)}{bar("coupler", coupler, "crank_tip", coupler_angle - np.pi / 2)}
{bar("follower", follower, "pivot", follower_angle)}
{joint("O", "world", "crank")}{joint("A", "crank_tip", "coupler")}{joint("Q", "world", "follower")}
{joint("B", "coupler_tip", "follower_tip")}"""
    return model("drag_link", body)


@pytest.mark.slow
def test_a_loop_stays_closed_over_a_thousand_revolutions(run):
    """A drag-link that coasts: no torque, no gravity; its loop is integrated, its energy is all that it started with."""
    text = "duration = 110.0\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = 0.0\nspeed = 60.0\n"
    trajectory = run(drag_link(), text, 1e-7)
    turned = np.ptp(trajectory["crank.angle"])
    assert turned > 1000 * 2.0 * np.pi
    assert trajectory.provenance["loop_error"] <= 1e-12  # round-off of angles of 6000 rad
    energy = trajectory["kinetic_energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-8)
