"""The film under a tilted journal: the solver of the surface, limits, symmetry, passivity, frames, machines."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joint_records import map_quantities

from linkages.laws.film.film_map import MapCase, load_map
from linkages.laws.film.surface.balance import Thickness
from linkages.laws.film.surface.surface_film import FilmSurface, friction_torque, solve_film
from linkages.laws.film.surface.surface_mesh import surface_mesh
from linkages.laws.film.tilted_film import tilted_action, tilted_film, tilted_gap
from linkages.laws.journal import clearance_force
from linkages.laws.parameters import MODELS, PARAMETERS, SHEAR

STATES = [
    # L/D, eps, a, b, deps, ew, spin
    (0.3, 0.5, 0.2, 0.1, 0.3, 0.4, 0.7),
    (1.0, 0.1, 0.5, 0.3, 0.0, 0.2, 1.0),
    (1.0, 0.7, 0.1, -0.15, 0.0, 0.9, 0.5),
    (2.0, 0.5, 0.2, 0.1, 0.3, 0.4, 0.7),
    (2.0, 0.7, 0.1, -0.15, -0.1, 0.9, -0.5),
]


@pytest.mark.parametrize("state", STATES)
def test_force_moment_shear_and_flow_are_those_of_the_surface(state):
    """Finite volumes in both directions, in the bearing's frame: 0.5 % of force and moment, 1 % of the flow."""
    lam, eps, a, b, deps, ew, spin = state
    mesh = surface_mesh(lam, (), (eps, 0.0), 400, 26, half=False)
    thickness, velocity = Thickness(eps, 0.0, a / lam, b / lam), (deps, spin * eps - 0.5 * ew)
    film = solve_film(FilmSurface(mesh), thickness, rule="guembel", velocity=velocity, speed=spin)
    f_n, f_t, m_n, m_t, _, whole, flow = tilted_film(eps, deps, ew, spin, a, b, lam)
    force, moment = np.array(film.force) / (2.0 * lam), np.array(film.moment) / (2.0 * lam**2)
    assert math.dist((f_n, f_t), force) < 5e-3 * np.hypot(*force)
    assert math.dist((m_n, m_t), moment) < 5e-3 * np.hypot(*moment)
    assert whole == pytest.approx(film.shear / (2.0 * lam), rel=1e-4)
    assert flow == pytest.approx(film.end_flow, rel=0.01)
    torque = 2.0 * lam * (whole * 2.0 * spin + 0.5 * eps * f_t - 0.5 * (a * m_n + b * m_t))
    assert torque == pytest.approx(friction_torque(film, 2.0 * spin), rel=2e-3)


@pytest.mark.parametrize(("eps", "deps", "ew"), [(0.2, 0.3, 0.4), (0.6, 0.0, 0.4), (0.9, 0.3, 0.5), (0.9, -0.3, 0.9)])
def test_without_tilt_it_is_the_finite_film(eps, deps, ew):
    """The map of the same film, to 0.5 %: both are discrete."""
    expected = np.array(map_quantities(eps, deps, ew, 0.0, load_map(MapCase(1.0)))[:2])
    f_n, f_t, m_n, m_t, _, whole, _ = tilted_film(eps, deps, ew, 3.0, 0.0, 0.0, 1.0)
    assert math.dist((f_n, f_t), expected) < 5e-3 * np.hypot(*expected)
    assert math.hypot(m_n, m_t) < 1e-12 * np.hypot(*expected)
    assert whole == pytest.approx(2.0 * math.pi / math.sqrt(1.0 - eps**2), rel=1e-12)


def test_force_changes_with_the_square_of_a_small_tilt():
    """Both ends of a tilted journal deviate in opposite directions: force even, moment odd in the tilt."""
    plain = np.array(tilted_film(0.4, 0.2, 0.5, 0.3, 0.0, 0.0, 1.0)[:2])
    changes = [np.array(tilted_film(0.4, 0.2, 0.5, 0.3, a, 0.0, 1.0)[:2]) - plain for a in (0.05, 0.1)]
    assert np.hypot(*changes[1]) == pytest.approx(4.0 * np.hypot(*changes[0]), rel=0.1)
    one, other = (np.array(tilted_film(0.4, 0.2, 0.5, 0.3, s * 0.2, s * 0.1, 1.0)) for s in (1.0, -1.0))
    assert one[:2] == pytest.approx(other[:2], rel=1e-9)
    assert one[2:4] == pytest.approx(-other[2:4], rel=1e-9)
    assert one[6] == pytest.approx(other[6], rel=1e-9)


def record(tilt=0.3, angle=0.7, shear="full"):
    joint = np.zeros(1, PARAMETERS)[0]
    values = {"clearance": 1e-4, "radius": 0.015, "length": 0.03, "model": MODELS["lubricated"], "viscosity": 0.1}
    for name, value in {**values, "shear": SHEAR[shear], "tilt": tilt, "tilt_angle": angle, "film": 1}.items():
        joint[name] = value
    return joint


unit, speed = st.floats(-1.0, 1.0), st.floats(-100.0, 100.0)


@settings(max_examples=200, deadline=None)
@given(st.floats(0.0, 0.65), st.floats(0.0, 6.3), unit, unit, speed, speed, st.floats(0.01, 0.3), st.floats(0.0, 6.3))
def test_the_pair_is_passive(eps, direction, vx, vy, omega_b, omega_j, tilt, angle):
    """Power of the pair for an observer who turns with the bearing is not positive, whatever the motion."""
    joint = record(tilt, angle)
    ex, ey = 1e-4 * eps * math.cos(direction), 1e-4 * eps * math.sin(direction)
    vx, vy = 0.01 * vx, 0.01 * vy
    fx, fy, couple, *_ = clearance_force(
        joint, np.zeros(0), ex, ey, vx, vy, omega_b, omega_j, (0.0, 0.0, 0.0, 0.0), 0.2
    )
    power = fx * (vx + omega_b * ey) + fy * (vy - omega_b * ex) + couple * (omega_j - omega_b)
    assert power <= 0.0


@settings(max_examples=200, deadline=None)
@given(st.floats(0.0, 0.65), unit, unit, unit, st.floats(-0.21, 0.21), st.floats(-0.21, 0.21), st.floats(0.2, 3.0))
def test_the_pressure_dissipates(eps, deps, ew, spin, a, b, lam):
    """Its power is minus the integral of h^3 |grad p|^2/12."""
    f_n, f_t, m_n, m_t, _, _, flow = tilted_film(eps, deps, ew, spin, a, b, lam)
    assert f_n * deps - 0.5 * f_t * ew + spin * (a * m_n + b * m_t) <= 0.0
    assert flow >= 0.0


@pytest.mark.parametrize("rate", [-30.0, 50.0])
def test_a_turning_observer_sees_the_same_force(rate):
    joint = record()
    e, v = np.array([3e-5, 2e-5]), np.array([1e-3, -2e-3])
    seen = v + rate * np.array([-e[1], e[0]])
    one = clearance_force(joint, np.zeros(0), *e, *v, 20.0, 90.0, (0.0, 0.0, 0.0, 0.0), 0.4)
    other = clearance_force(joint, np.zeros(0), *e, *seen, 20.0 + rate, 90.0 + rate, (0.0, 0.0, 0.0, 0.0), 0.4)
    assert other[:3] == pytest.approx(one[:3], rel=1e-9)


def test_a_turned_bearing_turns_the_force():
    joint, turn = record(), 0.9
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s], [s, c]])
    e, v = np.array([3e-5, 2e-5]), np.array([1e-3, -2e-3])
    one = clearance_force(joint, np.zeros(0), *e, *v, 20.0, 90.0, (0.0, 0.0, 0.0, 0.0), 0.4)
    other = clearance_force(
        joint, np.zeros(0), *rotation @ e, *rotation @ v, 20.0, 90.0, (0.0, 0.0, 0.0, 0.0), 0.4 + turn
    )
    assert other[:2] == pytest.approx(rotation @ one[:2], rel=1e-9)
    assert other[2] == pytest.approx(one[2], rel=1e-9)


def test_units_and_the_smallest_gap():
    joint, args = record(), (4e-5, 1e-3, -2e-3, 20.0, 90.0, 1.1)
    f_n, f_t, _, m_n, m_t, flow = tilted_action(joint, *args)
    turn = 1.1 - 0.7
    hat = tilted_film(0.4, 10.0, 0.4 * 110.0 + 40.0, 35.0, 0.3 * math.cos(turn), -0.3 * math.sin(turn), 1.0)
    scale = 0.1 * 0.03 * 0.015**3 / 1e-8
    assert (f_n, f_t, m_n / 0.015, m_t / 0.015) == pytest.approx(tuple(scale * x for x in hat[:4]), rel=1e-12)
    assert flow == pytest.approx(1e-4 * 0.015**2 * hat[6], rel=1e-12)
    ends = [np.hypot(0.4 + s * 0.3 * math.cos(turn), s * 0.3 * math.sin(turn)) for s in (1.0, -1.0)]
    assert tilted_gap(joint, 4e-5, 1.1) == pytest.approx(1e-4 * (1.0 - max(ends)), rel=1e-12)
