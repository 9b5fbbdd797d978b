"""The force pair: action and reaction, frames, power."""

import math

import joint_records
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from linkages.laws import FILMS
from linkages.laws.film.film_map import MapCase, load_map
from linkages.laws.journal import clearance_force as whole_force

CLEARANCE = 1e-4
TABLE = load_map(MapCase(1.0))
UNIT = st.floats(-0.6, 0.6)
SPEED = st.floats(-50.0, 50.0)
FILM = st.sampled_from(sorted(FILMS))


def clearance_force(record, ex, ey, vx, vy, wb, wj):
    """Force and couple of a joint that remembers nothing."""
    return whole_force(record, TABLE, ex, ey, vx, vy, wb, wj, (0.0, 0.0, 0.0, 0.0))[:3]


def joint(film="long", shear="full", **changes):
    return joint_records.joint(
        film, shear=shear, clearance=CLEARANCE, radius=0.01, length=0.02, viscosity=0.05, **changes
    )


@given(FILM, UNIT, UNIT, UNIT, UNIT, SPEED, SPEED, SPEED, st.floats(0.0, 6.3))
def test_force_is_the_same_seen_from_any_rotating_frame(film, x, y, u, v, wb, wj, rate, angle):
    """A frame turned by any angle and turning at any rate: with the sum of both speeds nothing changes."""
    record = joint(film)
    e, velocity = CLEARANCE * np.array([x, y]), CLEARANCE * 10 * np.array([u, v])
    fx, fy, couple = clearance_force(record, *e, *velocity, wb, wj)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    seen_e = turn @ e
    seen_v = turn @ (velocity - rate * np.array([-e[1], e[0]]))
    gx, gy, seen_couple = clearance_force(record, *seen_e, *seen_v, wb - rate, wj - rate)
    # of a film that turns with the frame: terms that must cancel for a journal at rest
    spin = 0.05 * 0.02 * 0.01**3 / CLEARANCE**2 * (abs(rate) + 1.0)
    scale = math.hypot(fx, fy) + spin
    assert np.array([gx, gy]) == pytest.approx(turn @ [fx, fy], abs=1e-8 * scale)
    assert seen_couple == pytest.approx(couple, abs=1e-8 * (abs(couple) + scale * CLEARANCE))


def test_relative_speed_would_depend_on_the_observer():
    """The trap of Chen 2025 eqs. (9)-(11): with omega_j - omega_b the force changes with the frame it is seen from.

    The law fed with -omega_b is the printed one: the sum it forms is then the relative speed.
    """
    record, e, rate, wb, wj = joint(shear="none"), np.array([0.5 * CLEARANCE, 0.0]), 2.0, 1.0, 3.0
    seen_v = -rate * np.array([-e[1], e[0]])
    right = [clearance_force(record, *e, 0.0, 0.0, wb, wj), clearance_force(record, *e, *seen_v, wb - rate, wj - rate)]
    printed = [
        clearance_force(record, *e, 0.0, 0.0, -wb, wj),
        clearance_force(record, *e, *seen_v, -(wb - rate), wj - rate),
    ]
    assert right[1] == pytest.approx(right[0], rel=1e-12)
    assert abs(printed[1][1] / printed[0][1] - 1.0) > 0.5


@given(FILM, st.sampled_from(["full", "half"]), UNIT, UNIT, UNIT, UNIT, SPEED, SPEED)
def test_pair_with_shear_torque_only_takes_power(film, shear, x, y, u, v, wb, wj):
    e, velocity = CLEARANCE * np.array([x, y]), CLEARANCE * 10 * np.array([u, v])
    fx, fy, couple = clearance_force(joint(film, shear), *e, *velocity, wb, wj)
    at_journal = velocity - wb * np.array([-e[1], e[0]])  # relative velocity where the pair acts
    power = fx * at_journal[0] + fy * at_journal[1] + couple * (wj - wb)
    scale = abs(fx * at_journal[0]) + abs(fy * at_journal[1]) + abs(couple * (wj - wb))
    assert power <= 1e-10 * scale


@given(UNIT, UNIT, UNIT, UNIT)
def test_without_rotation_the_film_only_takes_power(x, y, u, v):
    e, velocity = CLEARANCE * np.array([x, y]), CLEARANCE * 10 * np.array([u, v])
    fx, fy, _couple = clearance_force(joint(shear="none"), *e, *velocity, 0.0, 0.0)
    assert fx * velocity[0] + fy * velocity[1] <= 1e-12 * math.hypot(fx, fy)


@pytest.mark.parametrize("eps", [0.0, 0.5, 0.9])
def test_shear_torque_is_petroffs_and_sommerfelds(eps):
    """Full film, no load direction: T = 2 pi mu R^3 L (omega_j - omega_b) / (c sqrt(1 - eps^2)) + (e x F)/2."""
    record = joint()
    _, fy, couple = clearance_force(record, eps * CLEARANCE, 0.0, 0.0, 0.0, 0.0, 7.0)
    petroff = 2 * math.pi * 0.05 * 0.01**3 * 0.02 * 7.0 / (CLEARANCE * math.sqrt(1 - eps**2))
    assert couple == pytest.approx(-petroff - 0.5 * eps * CLEARANCE * fy, rel=1e-12)


@pytest.mark.parametrize("shear", ["none", "full", "half"])
def test_isolated_pair_keeps_momentum_and_angular_momentum(shear):
    """Two free bodies, joined by the film alone: both momenta constant to the integration's round-off."""
    record = joint(shear=shear)
    mass, inertia = np.array([0.3, 0.2]), np.array([2e-4, 1e-4])

    def rates(_, s):
        p, angle, v, w = s[:4].reshape(2, 2), s[4:6], s[6:10].reshape(2, 2), s[10:]
        del angle
        e, relative = p[1] - p[0], v[1] - v[0]
        fx, fy, couple = clearance_force(record, *e, *relative, w[0], w[1])
        force = np.array([fx, fy])
        # the bearing gets -force at the journal's centre
        torque_b = -couple - (e[0] * fy - e[1] * fx)
        acceleration = np.array([-force / mass[0], force / mass[1]])
        return np.concatenate([v.ravel(), w, acceleration.ravel(), [torque_b / inertia[0], couple / inertia[1]]])

    start = np.array([0.4, 0.1, 0.4, 0.1 + 0.6 * CLEARANCE, 0, 0, 0.01, 0.0, 0.012, -0.005, 3.0, -8.0])
    run = solve_ivp(rates, (0.0, 0.02), start, method="Radau", rtol=1e-9, atol=1e-13)

    def momenta(s):
        p, v, w = s[:4].reshape(2, 2), s[6:10].reshape(2, 2), s[10:]
        spin = inertia @ w + sum(m * (a[0] * b[1] - a[1] * b[0]) for m, a, b in zip(mass, p, v, strict=True))
        return np.array([*(mass @ v), spin])

    assert run.success
    assert np.abs(run.y[6:10, -1] - start[6:10]).max() > 1e-3  # the film did act
    first, last = momenta(run.y[:, 0]), momenta(run.y[:, -1])
    assert last == pytest.approx(first, abs=1e-12)


def test_small_eccentricity_option_is_eqs_12_and_13():
    plain, patched = joint(shear="none"), joint(shear="none", small_eps=0.2, small_power=2.0)
    for eps, factor in ((0.1, 0.1**2), (0.3, 1.0)):
        f = clearance_force(plain, eps * CLEARANCE, 0.0, 1e-4, 2e-4, 1.0, 2.0)
        g = clearance_force(patched, eps * CLEARANCE, 0.0, 1e-4, 2e-4, 1.0, 2.0)
        assert g == pytest.approx(tuple(factor * x for x in f), rel=1e-12)
