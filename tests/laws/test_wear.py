"""Worn profiles: contact on them, and Archard's law at held loads."""

import math

import joint_records
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from wearing_press import CLEARANCE, LENGTH, RADIUS, crescent

from linkages.laws.journal import clearance_force
from linkages.laws.parameters import MODELS
from linkages.laws.wear.archard import wear_away
from linkages.laws.wear.force import worn_force
from linkages.laws.wear.overlap import Place, overlap, round_depth, round_overlap
from linkages.laws.wear.profile import depth_at, depth_of, node_depths, removed_of, volume_of

RADII = RADIUS, RADIUS - CLEARANCE
NODES = 360
ANGLES = 2.0 * np.pi * np.arange(NODES) / NODES
ROUND = np.zeros(0)
TURN = st.floats(-np.pi, np.pi)
#: Two pockets on the bearing, one on the journal [m].
BEARING = 2e-5 * np.maximum(np.cos(ANGLES - 1.0), 0.0) ** 3 + 1e-5 * np.maximum(np.cos(ANGLES + 2.0), 0.0) ** 5
JOURNAL = 1e-5 * np.maximum(np.cos(ANGLES - 0.5), 0.0) ** 2


def law(bearing=ROUND, journal=ROUND, name="hertz", **changes):
    sizes = {"clearance": CLEARANCE, "radius": RADIUS, "length": LENGTH, "model": MODELS["dry"], "stiffness": 1e11}
    nodes = {"bearing_nodes": len(bearing), "journal_nodes": len(journal)}
    return joint_records.joint(contact=name, **sizes | nodes | changes), np.concatenate([bearing, journal])


def force(joint, x, y, angles=(0.0, 0.0), velocity=(0.0, 0.0), rates=(0.0, 0.0), approach=1e3):
    return worn_force(*joint, x, y, *velocity, *rates, *angles, approach, 0.0, 0.0, 0.0)


@given(st.floats(1e-9, 5e-5), TURN, st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-50, 50), st.floats(-50, 50))
def test_an_almost_round_profile_gives_the_round_joints_force(depth, angle, vx, vy, wb, wj):
    """What 1e-18 m of wear change is lost in rounding; the round joint's law is another function."""
    record, table = law(np.full(NODES, 1e-18), name="lankarani-nikravesh", hysteresis=0.3)
    e = (CLEARANCE + depth) * np.array([math.cos(angle), math.sin(angle)])
    expected = clearance_force(record, table, *e, vx, vy, wb, wj, (0.1, 0.0, 0.0, 0.0))
    found = force((record, table), *e, (0.3, -0.7), (vx, vy), (wb, wj), 0.1)
    scale = max(math.hypot(*expected[:2]), 1e-12)
    assert np.allclose(found[:3], expected[:3], rtol=0.0, atol=2e-8 * scale)  # 1e-18 m of rounding in 1e-9 m
    assert found[-1] == pytest.approx(expected[-1], rel=2e-8)


@pytest.mark.parametrize("bearing", [True, False])
def test_even_wear_is_a_larger_clearance_to_the_order_of_the_penetration(bearing):
    """Hertz's stiffness for the clearance c + w is less by sqrt(c/(c + w)), and the overlap gives the same."""
    worn = np.full(NODES, 5e-5)
    joint = law(worn, ROUND) if bearing else law(ROUND, worn)
    errors = []
    for depth in (1e-6, 1e-7):
        expected = 1e11 * depth**1.5 * math.sqrt(CLEARANCE / (CLEARANCE + 5e-5))
        errors.append(abs(force(joint, CLEARANCE + 5e-5 + depth, 0.0)[-1] / expected - 1.0))
    # 0.4 per cent: the difference of radii counts, not e/R, which is left out of Hertz's formula above
    assert max(errors) < 0.01
    assert force(joint, CLEARANCE + 5e-5 - 1e-9, 0.0)[-4] == pytest.approx(-1e-9, rel=1e-6)


@given(TURN, TURN, st.floats(0.0, 1.6e-4), TURN, st.floats(-100, 100), st.floats(-20, 20), st.floats(-20, 20))
def test_the_force_is_the_same_seen_from_any_turned_and_rotating_frame(at, turn, size, beta, rate, wb, wj):
    joint = law(BEARING, JOURNAL, friction="ambrosio", mu_d=0.2, v_0=1e-5, v_1=1e-4)
    e, velocity, angles = size * np.exp(1j * at), 0.05 + 0.03j, np.array([0.4, beta])
    fx, fy, couple = force(joint, e.real, e.imag, angles, (velocity.real, velocity.imag), (wb, wj))[:3]
    seen, moved = e * np.exp(1j * turn), (velocity - 1j * rate * e) * np.exp(1j * turn)
    gx, gy, other = force(joint, seen.real, seen.imag, angles + turn, (moved.real, moved.imag), (wb - rate, wj - rate))[
        :3
    ]
    expected = (fx + 1j * fy) * np.exp(1j * turn)
    scale = abs(expected) + 1e-3
    assert abs(gx + 1j * gy - expected) < 1e-6 * scale
    assert abs(other - couple) < 1e-6 * scale * RADIUS


def test_an_elastic_worn_joint_conserves_energy():
    """The force and the couple on the journal are the gradient of a potential: their mixed derivatives are equal."""
    joint = law(BEARING, JOURNAL, name="johnson")

    def action(x):
        return np.array(force(joint, x[0], x[1], (0.2, x[2]))[:3])

    steps = np.array([1e-9, 1e-9, 1e-5])
    for at in (-2.0, 0.3, 1.0):
        place = np.array([1.3e-4 * math.cos(at), 1.3e-4 * math.sin(at), 0.4])
        assert force(joint, *place[:2], (0.2, 0.4))[-1] > 1.0
        columns = [(action(place + h) - action(place - h)) / (2 * h.max()) for h in np.diag(steps)]
        matrix = np.array(columns)
        scale = np.sqrt(np.outer(np.abs(np.diag(matrix)), np.abs(np.diag(matrix))))
        assert np.all(np.abs(matrix - matrix.T) <= 1e-5 * scale)
    assert abs(matrix[2, 2]) > 0.0  # the last place is on the worn part of the journal


def test_a_frictionless_pair_has_no_power_left_over():
    """Power of the pair is -dE/dt; round a closed path of both bodies nothing is left."""
    joint = law(BEARING, JOURNAL)
    s = 2.0 * np.pi * (np.arange(4000) + 0.5) / 4000
    x, y = 1.2e-4 * np.cos(s) + 1e-5 * np.cos(2 * s), 1.25e-4 * np.sin(s)
    beta, psi = 0.3 * np.sin(s), 0.2 * np.cos(2 * s)
    dx, dy = -1.2e-4 * np.sin(s) - 2e-5 * np.sin(2 * s), 1.25e-4 * np.cos(s)
    dbeta, dpsi = 0.3 * np.cos(s), -0.4 * np.sin(2 * s)
    work, paid = 0.0, 0.0
    for k in range(len(s)):
        fx, fy, couple = force(joint, x[k], y[k], (beta[k], psi[k]))[:3]
        # both forces act at the journal's centre: the bearing's moves there with its angular velocity
        power = fx * (dx[k] + dbeta[k] * y[k]) + fy * (dy[k] - dbeta[k] * x[k]) + couple * (dpsi[k] - dbeta[k])
        work, paid = work + power, paid + abs(power)
    assert paid > 0.0
    assert abs(work) < 1e-6 * paid


OIL = {"film": "pinkus-sternlicht", "viscosity": 0.05, "film_limit": 0.99, "model": MODELS["mixed"]}
BLEND = {"transition": 2e-6}
ASPERITIES = {"roughness": 2e-6, "asperity_pressure": 1e9}
SPEED, SPIN = st.floats(-0.1, 0.1), st.floats(-50, 50)


def round_force(worn, x, y, velocity, rates, **mixed):
    """Force of the round joint whose clearance is larger by a depth."""
    record, table = law(**mixed, clearance=CLEARANCE + worn)
    return clearance_force(record, table, x, y, *velocity, *rates, (0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("mixed", [BLEND, ASPERITIES], ids=["blend", "asperities"])
@pytest.mark.parametrize("parts", [(5e-5, 0.0), (0.0, 3e-5), (2e-5, 3e-5)], ids=["bearing", "journal", "both"])
@given(st.floats(0.01, 0.999), TURN, SPEED, SPEED, SPIN, SPIN)
def test_the_film_of_an_evenly_worn_joint_is_that_of_the_larger_clearance(mixed, parts, eps, at, vx, vy, wb, wj):
    mixed, even = OIL | mixed, [np.full(NODES, depth) if depth else ROUND for depth in parts]
    x, y = eps * (CLEARANCE + sum(parts)) * np.array([math.cos(at), math.sin(at)])
    expected = round_force(sum(parts), x, y, (vx, vy), (wb, wj), **mixed)
    found = force(law(*even, **mixed), x, y, (0.3, -0.7), (vx, vy), (wb, wj))
    # asperities push along the normal where the gap is smallest: a flat minimum, found to the root of rounding
    accuracy = 2e-7 if expected[-1] > 0.0 else 1e-9
    assert np.allclose(found[:3], expected[:3], rtol=0.0, atol=accuracy * (math.hypot(*expected[:2]) + 1e-9))
    assert found[-1] == pytest.approx(expected[-1], rel=1e-9)
    assert (expected[-1] > 0.0) == ("roughness" in mixed and (1.0 - eps) * (CLEARANCE + sum(parts)) < 10 * 2e-6)


@given(st.floats(0.01, 0.8), TURN, TURN, SPEED, SPEED, SPIN, SPIN)
def test_the_film_of_a_pocket_sees_the_depth_of_both_parts_where_the_journal_is(eps, at, turn, vx, vy, wb, wj):
    bearing, journal, angles = 2e-5 + BEARING, JOURNAL, (turn, -0.5 * turn)
    worn = depth_at(bearing, at - angles[0])[0] + depth_at(journal, at - angles[1])[0]
    x, y = eps * (CLEARANCE + worn) * np.array([math.cos(at), math.sin(at)])
    expected = round_force(worn, x, y, (vx, vy), (wb, wj), **OIL, **BLEND)
    found = force(law(bearing, journal, **OIL, **BLEND), x, y, angles, (vx, vy), (wb, wj))
    assert found[-4] < 0.0  # they do not touch
    assert np.allclose(found[:3], expected[:3], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("curvature", [0.2, 5.0])
def test_the_stiffness_follows_the_local_difference_of_curvatures(curvature):
    """A wavy part of the bearing with delta = d - kappa phi^2/2: Hertz's force goes with 1/sqrt(kappa)."""
    fine = 2.0 * np.pi * np.arange(3600) / 3600
    phi = (fine + np.pi) % (2.0 * np.pi) - np.pi
    worn = np.where(np.abs(phi) < 0.3, (curvature - 1.0) * CLEARANCE * 0.5 * phi**2, 0.0) + 2e-5
    worn = np.where(np.abs(phi) < 0.3, worn, 3e-5)
    depth = 1e-8
    e = CLEARANCE + node_depths(worn)[0] + depth
    found = force(law(worn), e, 0.0)
    assert found[-4] == pytest.approx(depth, rel=1e-3)
    kappa = CLEARANCE * curvature + 2e-5  # e sets the curvature of the overlap, not c
    assert found[-1] == pytest.approx(1e11 * depth**1.5 * math.sqrt(CLEARANCE / kappa), rel=0.02)


@given(st.floats(1e-18, 1e-5))
def test_the_round_joints_overlap_is_inverted(energy):
    depth, slope = round_depth(energy, CLEARANCE, RADIUS - CLEARANCE)
    assert round_overlap(depth, CLEARANCE, RADIUS - CLEARANCE) == pytest.approx((energy, slope), rel=1e-9)


def test_profiles_have_no_ripples_and_keep_their_volume():
    depths = np.where((ANGLES > 1.0) & (ANGLES < 2.0), 3e-5, 0.0)
    fine = np.linspace(-7.0, 7.0, 5001)
    values = np.array([depth_at(depths, angle) for angle in fine])
    assert values[:, 0].min() >= 0.0
    assert values[:, 0].max() <= 3e-5 * (1 + 1e-15)
    slopes = np.gradient(values[:, 0], fine)
    assert np.abs(slopes - values[:, 1])[1:-1].max() < 0.02 * np.abs(slopes).max()
    assert node_depths(depths) == pytest.approx([depth_at(depths, angle)[0] for angle in ANGLES], abs=1e-17)
    for radius in (RADIUS, -RADIUS):
        removed = removed_of(depths, radius)
        assert depth_of(removed, radius) == pytest.approx(depths, rel=1e-13)
        ring = np.pi * abs((radius + 3e-5) ** 2 - radius**2) * LENGTH  # of the whole turn
        assert volume_of(removed, radius, LENGTH) == pytest.approx(ring * np.mean(depths > 0), rel=1e-12)


def samples(count, load=1e-7, spread=1.0):
    """Loads all over an arc, of a journal that turns in a round bearing."""
    at = np.linspace(-spread, spread, count)
    place = (CLEARANCE + 1e-7) * np.column_stack([np.cos(at), np.sin(at)])
    moment = load * (1.0 + 0.5 * np.sin(3 * at))[:, None] * np.column_stack([np.cos(at), np.sin(at)])
    return np.column_stack([0.1 * at, 7.0 * at, place, moment, 1.0 + np.cos(at)])


@pytest.mark.parametrize("parts", [(1.0, 0.0), (0.0, 1.0), (0.3, 0.7)])
def test_worn_volume_is_the_coefficient_times_the_integral_of_load_and_speed(parts):
    history, removed = samples(40), np.zeros((2, NODES))
    removed[0] = removed_of(BEARING, RADIUS)
    start = volume_of(removed[0], RADIUS, LENGTH)
    k = 1e-11
    assert wear_away(history, CLEARANCE, RADII, LENGTH, (parts[0] * k, parts[1] * k), 4, removed) < 1e-6
    work = history[:, 6].sum()
    assert volume_of(removed[0], RADIUS, LENGTH) - start == pytest.approx(parts[0] * k * work, rel=1e-12, abs=1e-24)
    assert volume_of(removed[1], RADIUS - CLEARANCE, LENGTH) == pytest.approx(parts[1] * k * work, rel=1e-12)


def test_each_load_is_carried_where_its_moment_is_what_it_was():
    history, removed = samples(12), np.zeros((2, NODES))
    wear_away(history, CLEARANCE, RADII, LENGTH, (1e-11, 0.0), 3, removed)
    depths = depth_of(removed[0], RADIUS)
    one = history[:1].copy()
    wear_away(one, CLEARANCE, RADII, LENGTH, (1e-30, 0.0), 1, removed)  # finds the place, removes nothing
    place = Place(one[0, 2], one[0, 3], one[0, 0], one[0, 1], CLEARANCE, RADIUS - CLEARANCE, depths, ROUND)
    found = overlap(place, np.zeros(0), np.zeros(0))
    assert (found.ix, found.iy) == pytest.approx(tuple(one[0, 4:6]), rel=1e-5)


def test_the_crescent_is_that_of_the_published_row():
    """k 5e-13 m2/N, 100 N, 100 m, bearing 10 mm, c 0.1 mm, L 20 mm: 28.1219 um, 38.4630 deg."""
    depth, half = crescent(5e-13 * 100.0 * 100.0 / LENGTH)
    assert depth == pytest.approx(28.1219e-6, rel=1e-6)
    assert math.degrees(half) == pytest.approx(38.4630, rel=1e-6)


@pytest.mark.parametrize("load", [30.0, 100.0, 400.0])
def test_a_load_of_constant_direction_wears_the_pocket_of_the_journals_circle(load):
    """Depth and half-angle of the exact conforming pocket to 1e-3: a rigid journal, k F s = A(d) L."""
    work = load * 100.0
    history = np.array([[0.2, 0.1, CLEARANCE + 1e-8, 0.0, 7e-10 * load, 0.0, work]])  # almost rigid
    removed = np.zeros((2, 720))
    for _ in range(8):
        one = history.copy()
        one[:, 6] /= 8.0
        wear_away(one, CLEARANCE, RADII, LENGTH, (5e-13, 0.0), 400, removed)
        history[:, 2:4] = one[:, 2:4]
    depth, half = crescent(5e-13 * work / LENGTH)
    profile = node_depths(depth_of(removed[0], RADIUS))
    assert profile.max() == pytest.approx(depth, rel=1e-3)
    phi = (2.0 * np.pi * np.arange(720) / 720 + 0.2 + np.pi) % (2.0 * np.pi) - np.pi
    flank = (profile > 0.1 * depth) & (profile < 0.5 * depth)
    for side in (-1.0, 1.0):  # the flank's line to zero: it is the edge of the crescent
        chosen = flank & (side * phi > 0.0)
        edge = np.polyval(np.polyfit(profile[chosen], phi[chosen], 3), 0.0)
        assert side * edge == pytest.approx(half, rel=1e-3)
