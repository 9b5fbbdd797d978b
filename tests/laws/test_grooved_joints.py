"""Joints with a groove and a mass-conserving film beside a contact: mixed and worn ones."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from joint_records import joint, map_quantities

from linkages.laws.film.film_map import MapCase, build_map
from linkages.laws.film.films import MAPPED
from linkages.laws.film.map_table import static_film
from linkages.laws.film.surface import Groove
from linkages.laws.journal import clearance_force
from linkages.laws.mixed import asperity_force, mix
from linkages.laws.parameters import MODELS
from linkages.laws.wear.force import worn_force
from linkages.laws.wear.profile import depth_at

CLEARANCE, RADIUS, LENGTH, OIL, SUPPLY, LIMIT = 1e-4, 0.015, 0.04, 0.4, 2e5, 0.97
ROUGHNESS, HARDNESS, FRICTION = 2e-6, 1e9, 0.1
NODES = 180
ANGLES = 2.0 * np.pi * np.arange(NODES) / NODES
ASPERITIES = {"roughness": ROUGHNESS, "asperity_pressure": HARDNESS}
BLEND = {"transition": 4e-6}
TURN, SPEED, SPIN = st.floats(-math.pi, math.pi), st.floats(-0.1, 0.1), st.floats(-50.0, 50.0)
MIXED = pytest.mark.parametrize("mixed", [ASPERITIES, BLEND], ids=["asperities", "blend"])


@cache
def table():
    """A map with few nodes; the static part is that of the supply pressure."""
    groove = Groove(0.0, math.radians(20.0), 0.8, SUPPLY)
    return build_map(MapCase(0.5 * LENGTH / RADIUS, "mass-conserving", (groove,), (13, 24, 16), (36, 4)))


def record(**changes):
    values = {
        "model": MODELS["mixed"], "clearance": CLEARANCE, "radius": RADIUS, "length": LENGTH, "viscosity": OIL,
        "film_limit": LIMIT, "supply_pressure": SUPPLY, "groove_angle": 0.3, "stiffness": 1e10,
        "mu_s": FRICTION, "mu_d": FRICTION, "v_1": 1e-3,
    }  # fmt: skip
    return joint(contact="hertz", friction="coulomb", film="finite", **values | changes)


def film_alone(c, e, v, rates, angle):
    """Force and couple of the film in a clearance, from the quantities of the map by hand."""
    size = math.hypot(*e)
    n = e / size
    t = np.array([-n[1], n[0]])
    eps, alpha = min(size / c, LIMIT), math.atan2(n[1], n[0]) - angle - 0.3
    wedge = size / c * sum(rates) - 2.0 * v @ t / c
    f_n, f_t, extent, _ = map_quantities(eps, v @ n / c, wedge, alpha, table())
    s_n, s_t, _ = static_film(eps, alpha, table())
    unit, fed = OIL * LENGTH * RADIUS**3 / c**2, SUPPLY * RADIUS * LENGTH
    force = np.array([unit * f_n + fed * s_n, unit * f_t + fed * s_t])
    shear = OIL * LENGTH * RADIUS**3 / c * extent * (rates[1] - rates[0])
    return force[0] * n + force[1] * t, -shear - 0.5 * size * force[1]


@MIXED
@given(st.floats(0.05, 1.06), TURN, SPEED, SPEED, SPIN, SPIN, TURN)
def test_a_mixed_joint_is_the_sum_of_its_laws(mixed, eps, at, vx, vy, wb, wj, angle):
    """Film, asperities, Hertz and friction, each by itself; blended or added."""
    e, v, rates = eps * CLEARANCE * np.array([math.cos(at), math.sin(at)]), np.array([vx, vy]), (wb, wj)
    fx, fy, couple, *_, load = clearance_force(record(**mixed), table(), *e, *v, *rates, (0.1, 0.0, 0.0, 0.0), angle)
    n = e / np.hypot(*e)
    t, journal = np.array([-n[1], n[0]]), RADIUS - CLEARANCE
    film, torque = film_alone(CLEARANCE, e, v, rates, angle)
    depth = np.hypot(*e) - CLEARANCE
    pressed = 1e10 * max(depth, 0.0) ** 1.5
    if mixed is ASPERITIES:
        pressed += asperity_force(eps, CLEARANCE, RADIUS, LENGTH, ROUGHNESS, HARDNESS)
    drag = pressed * FRICTION * math.tanh((v @ t + wj * journal - wb * (np.hypot(*e) + journal)) / 1e-3)
    dry, turned = -pressed * n - drag * t, -journal * drag
    if mixed is ASPERITIES:
        expected = *(film + dry), torque + turned
    else:
        blended = [mix(one, other, depth, 4e-6) for one, other in zip((*film, torque), (*dry, turned), strict=True)]
        expected = tuple(blended)
    scale = np.hypot(*film) + np.hypot(*dry) + 1e-9
    np.testing.assert_allclose((fx, fy), expected[:2], rtol=0.0, atol=1e-9 * scale)
    assert couple == pytest.approx(expected[2], abs=1e-9 * (abs(torque) + abs(turned) + scale * RADIUS))
    assert load >= 0.0


@MIXED
@given(st.floats(0.05, 1.06), TURN, SPEED, SPEED, SPIN, SPIN)
def test_a_mixed_joint_is_passive(mixed, eps, at, vx, vy, wb, wj):
    """Seen from the bearing, the power of the pair beyond that of elastic and supply pressure is never positive."""
    joint_law = record(**mixed, supply_pressure=0.0)
    e, v = eps * CLEARANCE * np.array([math.cos(at), math.sin(at)]), np.array([vx, vy])
    fx, fy, couple, *_, closing, sliding, load = clearance_force(
        joint_law, table(), *e, *v, wb, wj, (0.1, 0.0, 0.0, 0.0), 0.2
    )
    seen = v - wb * np.array([-e[1], e[0]])
    power = fx * seen[0] + fy * seen[1] + couple * (wj - wb)
    size = math.hypot(fx, fy) * (np.hypot(*v) + CLEARANCE * (abs(wb) + abs(wj))) + abs(couple) * abs(wj - wb)
    assert power + load * closing <= 1e-9 * size  # hertz and asperities conserve energy
    assert load * sliding * math.tanh(sliding / 1e-3) >= 0.0


@pytest.mark.parametrize("parts", [(3e-5, 0.0), (0.0, 3e-5), (1e-5, 2e-5)], ids=["bearing", "journal", "both"])
@given(st.floats(0.05, 0.9), TURN, SPEED, SPEED, SPIN, SPIN, TURN)
def test_even_wear_of_a_fed_joint_is_a_larger_clearance(parts, eps, at, vx, vy, wb, wj, angle):
    """Pressure film, supply pressure and shear of the evenly worn joint are those of the round one."""
    e = eps * (CLEARANCE + 3e-5) * np.array([math.cos(at), math.sin(at)])
    profile = np.concatenate([np.full(NODES, depth) for depth in parts if depth])
    nodes = {"bearing_nodes": NODES * (parts[0] > 0.0), "journal_nodes": NODES * (parts[1] > 0.0)}
    worn = record(**nodes, **ASPERITIES)
    found = worn_force(worn, np.concatenate([table(), profile]), *e, vx, vy, wb, wj, angle, -0.4, 0.0, 0.0, 0.0, 0.0)
    round_joint = record(**ASPERITIES, clearance=CLEARANCE + 3e-5)
    expected = clearance_force(round_joint, table(), *e, vx, vy, wb, wj, (0.0, 0.0, 0.0, 0.0), angle)
    scale = np.hypot(*expected[:2])
    np.testing.assert_allclose(found[:2], expected[:2], rtol=0.0, atol=1e-9 * scale)
    assert found[2] == pytest.approx(expected[2], abs=1e-9 * (abs(expected[2]) + scale * CLEARANCE))


@given(st.floats(0.05, 0.9), TURN, SPEED, SPEED, SPIN, SPIN, TURN, TURN)
def test_pocket_and_groove_turn_with_the_bearing(eps, at, vx, vy, wb, wj, angle, turn):
    """Away from contact: the film at the depth where the journal is; everything turned turns the force."""
    bearing = 1e-5 + 2e-5 * np.maximum(np.cos(ANGLES - 1.0), 0.0) ** 3
    worn, whole = record(bearing_nodes=NODES, **BLEND), np.concatenate([table(), bearing])

    def force(by):
        matrix = np.array([[math.cos(by), -math.sin(by)], [math.sin(by), math.cos(by)]])
        e, v = matrix @ (c * eps * np.array([math.cos(at), math.sin(at)])), matrix @ [vx, vy]
        found = worn_force(worn, whole, *e, *v, wb, wj, angle + by, 0.1 + by, 0.0, 0.0, 0.0, 0.0)
        return e, v, np.array(found[:2]), found[2], matrix

    c = CLEARANCE + depth_at(bearing, at - angle)[0]
    e, v, first, couple, _ = force(0.0)
    expected, torque = film_alone(c, e, v, (wb, wj), angle)
    scale = np.hypot(*expected) + 1e-9
    np.testing.assert_allclose(first, expected, rtol=0.0, atol=1e-9 * scale)
    assert couple == pytest.approx(torque, abs=1e-9 * (abs(torque) + scale * CLEARANCE))
    *_, turned, _, matrix = force(turn)
    np.testing.assert_allclose(turned, matrix @ first, rtol=0.0, atol=1e-7 * scale)


def test_the_groove_is_a_map_of_the_joint():
    """What the records of these tests say: a map, and the angle of its groove."""
    assert record()["film"] == MAPPED
    assert table()[7] == 1.0  # a static part
