"""The reference machines: their independent solutions by a second way each, without the package."""

import andrews
import numpy as np
import pytest
from reference_machines import (
    chain_model,
    double_pendulum,
    equal_slider_crank_angle,
    equal_slider_crank_inertia,
    equal_slider_crank_model,
    parallelogram_angle,
    parallelogram_model,
    slider_crank_motion,
    windows_angle,
)

# --- squeezing mechanism ----------------------------------------------------------------------------------------------


def test_squeezing_mechanism_starts_as_published():
    model = andrews.andrews_model()
    assert np.abs(model.closure(andrews.START)).max() < 1e-16  # m
    acceleration, multipliers = model.accelerations(andrews.START, np.zeros(7))
    np.testing.assert_allclose(acceleration, andrews.START_ACCELERATION, rtol=1e-14, atol=1e-9)
    np.testing.assert_allclose(multipliers, andrews.START_MULTIPLIERS, rtol=1e-14, atol=1e-12)


def test_squeezing_mechanism_ends_as_published():
    """Nine digits of the angles, fewer of derived quantities.

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


@pytest.mark.slow
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


def test_squeezing_mechanism_is_drawn_closed(system_of):
    text = f"duration = 0.03\ngravity = [0.0, 0.0, 0.0]\n[drives.O]\ntorque = {andrews.TORQUE}\n"
    assembly = system_of(andrews.andrews_sdf("oblique"), text).assembly
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


def test_windows_end_as_published():
    """B0 of two windows at 10 s."""
    angle = windows_angle(2, np.array([0.0, 10.0]))[0, -1]
    np.testing.assert_allclose([np.cos(angle), np.sin(angle)], [0.3284581115, 0.9445185382], rtol=0, atol=1e-10)
