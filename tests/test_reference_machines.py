"""The reference machines: their independent solutions by a second way each, and against the Drake engine."""

import andrews
import numpy as np
import pytest
from machines import slider_crank
from reference_machines import (
    chain_model,
    chain_sdf,
    double_pendulum,
    equal_slider_crank_angle,
    equal_slider_crank_inertia,
    equal_slider_crank_model,
    equal_slider_crank_sdf,
    parallelogram_angle,
    parallelogram_model,
    parallelogram_sdf,
    slider_crank_motion,
)

from linkages.engines.drake.simulation import simulate
from linkages.errors import Status
from linkages.model.experiment import load
from linkages.system.assembly import assemble


@pytest.fixture
def run(experiment_file):
    """Simulate a machine of the plane x-y with Drake."""

    def simulated(sdf, toml, accuracy=1e-10):
        solver = f'[solver]\nintegrator = "runge_kutta5"\naccuracy = {accuracy}\n'
        trajectory = simulate(*load(experiment_file(sdf, toml + solver)))
        assert trajectory.status is Status.OK
        return trajectory

    return simulated


# --- squeezing mechanism ----------------------------------------------------------------------------------------------


def test_squeezing_mechanism_starts_as_published():
    model = andrews.andrews_model()
    assert np.abs(model.closure(andrews.START)).max() < 1e-16  # m
    acceleration, multipliers = model.accelerations(andrews.START, np.zeros(7))
    np.testing.assert_allclose(acceleration, andrews.START_ACCELERATION, rtol=1e-14, atol=1e-9)
    np.testing.assert_allclose(multipliers, andrews.START_MULTIPLIERS, rtol=1e-14, atol=1e-12)


def test_squeezing_mechanism_ends_as_published():
    """Nine digits of the angles, fewer of what is derived from them.

    The published solution is one of the index 3 formulation: its rates break the loops by 1e-9 m/s, and its
    accelerations are less exact again. All its angles are ahead of these by the same 1e-12 s.
    """
    model = andrews.andrews_model()
    q, v = model.solve(andrews.START, np.zeros(7), np.array([0.0, andrews.END_TIME]), 1e-13)
    np.testing.assert_allclose(q[-1], andrews.END, rtol=1e-9)
    np.testing.assert_allclose(v[-1], andrews.END_RATE, rtol=1e-7)
    acceleration, multipliers = model.accelerations(q[-1], v[-1])
    np.testing.assert_allclose(acceleration, andrews.END_ACCELERATION, rtol=1e-5)
    np.testing.assert_allclose(multipliers, andrews.END_MULTIPLIERS, rtol=1e-5)
    assert np.abs(model.closure(q[-1])).max() < 1e-14


def test_squeezing_mechanism_keeps_its_energy():
    """The torque's work is stored in the bodies and the spring."""
    model = andrews.andrews_model()
    times = np.linspace(0.0, andrews.END_TIME, 31)
    q, v = model.solve(andrews.START, np.zeros(7), times, 1e-13)
    end = andrews.B + andrews.SPRING_END * np.exp(1j * q[:, 2])
    spring = 0.5 * andrews.STIFFNESS * (np.abs(end - andrews.C) - andrews.REST_LENGTH) ** 2
    kinetic = np.array([model.energy(a, b)[0] for a, b in zip(q, v, strict=True)])
    work = andrews.TORQUE * (q[:, 0] - q[0, 0])
    np.testing.assert_allclose(kinetic + spring - spring[0], work, rtol=0, atol=1e-12 * work[-1])


def test_squeezing_mechanism_without_its_spring_moves_as_in_drake(run):
    text = (
        f"duration = {andrews.END_TIME}\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = {andrews.TORQUE}\n"
    )
    trajectory = run(andrews.andrews_sdf(), text)
    times = trajectory.time
    q, v = andrews.andrews_model(spring=False).solve(andrews.START, np.zeros(7), times)
    for name, values in andrews.columns(q, v).items():
        atol = 1e-7 * np.abs(values).max()
        np.testing.assert_allclose(trajectory[name], values, rtol=0, atol=atol, err_msg=name)


def test_squeezing_mechanism_is_drawn_closed(experiment_file):
    text = f"duration = 0.03\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = {andrews.TORQUE}\n"
    assembly = assemble(*load(experiment_file(andrews.andrews_sdf("oblique"), text)))
    assert assembly.mobility == 1
    np.testing.assert_allclose(assembly.q, 0.0, atol=1e-13)


# --- pendulums --------------------------------------------------------------------------------------------------------

LENGTHS, ANGLES = (0.3, 0.2), (0.4, -0.9)


def test_double_pendulum_by_two_derivations_and_its_energy():
    times = np.linspace(0.0, 2.0, 41)
    q, v = double_pendulum(LENGTHS, ANGLES, times)
    model = chain_model(LENGTHS)
    other, rates = model.solve(np.array(ANGLES), np.zeros(2), times)
    np.testing.assert_allclose(other, q, rtol=0, atol=1e-8)  # 1e-12 per step, chaotic growth
    np.testing.assert_allclose(rates, v, rtol=0, atol=1e-7)
    energy = np.array([sum(model.energy(a, b)) for a, b in zip(q, v, strict=True)])
    kinetic = model.energy(q[-1], v[-1])[0]
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=1e-10 * kinetic)


@pytest.mark.parametrize("n", [2, 4])
def test_chain_swings_as_in_drake_and_keeps_its_energy(run, n):
    lengths, angles = np.linspace(0.3, 0.1, n), np.linspace(0.4, -0.9, n)
    trajectory = run(chain_sdf(lengths, angles), f"duration = 1.0\ngravity = [0.0, {-9.81}, 0.0]\n")
    model = chain_model(lengths)
    q, v = model.solve(angles, np.zeros(n), trajectory.time)
    for i in range(n):
        np.testing.assert_allclose(trajectory[f"bar{i + 1}.angle"], q[:, i], rtol=0, atol=1e-6)
        np.testing.assert_allclose(trajectory[f"bar{i + 1}.omega"], v[:, i], rtol=0, atol=1e-5)
    energy = trajectory["kinetic_energy"] + trajectory["potential_energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=1e-8 * trajectory["kinetic_energy"].max())


# --- slider-crank -----------------------------------------------------------------------------------------------------


def test_slider_cranks_closed_form_is_consistent():
    """Rates by differences, drive torque by the power that the masses and gravity take."""
    theta, omega, step = np.linspace(0.0, 2.0 * np.pi, 50), 30.0, 1e-4
    here, after, before = (slider_crank_motion(theta + s, omega, gravity=9.81) for s in (0.0, step, -step))
    for value, rate in (
        ("slider.x", "slider.vx"), ("slider.vx", "slider.ax"), ("rod.angle", "rod.omega"), ("rod.omega", "rod.alpha"),
    ):  # fmt: skip
        difference = (after[value] - before[value]) / (2.0 * step / omega)
        np.testing.assert_allclose(difference, here[rate], atol=1e-7 * np.abs(here[rate]).max())

    def energy(theta, m):
        centre = np.array([0.05 * np.cos(theta) + 0.06 * np.cos(m["rod.angle"]), 0.025 * np.sin(theta)])
        velocity = np.array(
            [
                -0.05 * np.sin(theta) * omega - 0.06 * np.sin(m["rod.angle"]) * m["rod.omega"],
                0.025 * np.cos(theta) * omega,
            ]
        )
        kinetic = 0.5 * (0.21 * (velocity**2).sum(axis=0) + 0.21 * 0.12**2 / 12 * m["rod.omega"] ** 2)
        kinetic += 0.5 * 0.14 * m["slider.vx"] ** 2
        return kinetic + 9.81 * (0.21 * centre[1] + 0.3 * 0.025 * np.sin(theta))

    power = (energy(theta + step, after) - energy(theta - step, before)) / (2.0 * step / omega)
    np.testing.assert_allclose(here["O.torque"] * omega, power, atol=1e-7 * np.abs(power).max())


def test_ideal_slider_crank_moves_as_its_closed_form_in_drake(run):
    text = "duration = 0.25\ngravity = [0.0, -9.81, 0.0]\n[drives.O]\nspeed = 30.0\n"
    text += "".join(f'[joints.{name}]\nmodel = "ideal"\n' for name in "AB")
    trajectory = run(slider_crank(), text)
    expected = slider_crank_motion(30.0 * trajectory.time, 30.0, gravity=9.81)
    for name, values in expected.items():
        np.testing.assert_allclose(
            trajectory[name], values, rtol=0, atol=1e-7 * np.abs(values).max(), err_msg=name
        )


# --- through singular positions ---------------------------------------------------------------------------------------


def test_equal_slider_crank_keeps_its_energy():
    times = np.linspace(0.0, 3.0, 101)
    theta, rate = equal_slider_crank_angle(times, 0.02, 3.0)
    assert theta[-1] > 0.5 + 4.0 * np.pi
    kinetic = 0.5 * equal_slider_crank_inertia(theta)[0] * rate**2
    np.testing.assert_allclose(kinetic - kinetic[0], 0.02 * (theta - 0.5), rtol=0, atol=1e-10 * kinetic[-1])


def test_one_coordinate_models_are_those_of_the_bodies():
    """Closed forms against the vector sums of the same bodies."""
    q, v = np.array([1.2]), np.array([6.0])
    _, rate = parallelogram_angle(np.array([0.0, 1.0]), 0.01, 6.0)
    acceleration = parallelogram_model(0.01).accelerations(q, v)[0]
    assert acceleration[0] == pytest.approx(rate[1] - rate[0], rel=1e-13)
    model = equal_slider_crank_model(0.02)
    inertia, slope = equal_slider_crank_inertia(q[0])
    assert model.energy(q, v)[0] == pytest.approx(0.5 * inertia * v[0] ** 2, rel=1e-13)
    acceleration = model.accelerations(q, v)[0]
    assert acceleration[0] == pytest.approx((0.02 - 0.5 * slope * v[0] ** 2) / inertia, rel=1e-13)


#: Coarse enough that no step ends so close to a singular position that its closure rows are dependent to round-off:
#: there the multipliers, and with them the accelerations, have no digits left.
STEPS_OVER = 1e-6


def test_parallelogram_passes_its_flat_positions_in_drake(run):
    text = "duration = 0.9\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = 0.01\nspeed = 6.0\n"
    trajectory = run(parallelogram_sdf(), text, STEPS_OVER)
    theta, rate = parallelogram_angle(trajectory.time, 0.01, 6.0)
    assert theta[-1] > 2.0 * np.pi
    for link in ("crank", "follower"):
        np.testing.assert_allclose(trajectory[f"{link}.angle"], theta, rtol=0, atol=1e-6)
        np.testing.assert_allclose(trajectory[f"{link}.omega"], rate, rtol=0, atol=1e-5)
    np.testing.assert_allclose(trajectory["coupler.angle"], 0.0, atol=1e-6)


def test_equal_slider_crank_passes_its_singular_positions_in_drake(run):
    text = "duration = 1.2\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = 0.02\nspeed = 6.0\n"
    trajectory = run(equal_slider_crank_sdf(), text, STEPS_OVER)
    theta, rate = equal_slider_crank_angle(trajectory.time, 0.02, 6.0)
    assert theta[-1] > 2.0 * np.pi
    np.testing.assert_allclose(trajectory["crank.angle"], theta, rtol=0, atol=1e-6)
    np.testing.assert_allclose(trajectory["crank.omega"], rate, rtol=0, atol=1e-5)
    np.testing.assert_allclose(trajectory["rod.angle"], -theta, rtol=0, atol=1e-6)
