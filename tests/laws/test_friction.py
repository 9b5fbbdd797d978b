"""Friction laws: odd, dissipative, continuous; LuGre's steady state and passivity."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from joint_records import joint

from linkages.laws import FRICTIONS
from linkages.laws.friction import friction_action, friction_coefficient, stribeck

MU_S, MU_D, V_0, V_1 = 0.15, 0.1, 1e-3, 5e-3
SIGMA_0, SIGMA_1 = 1e5, 300.0
NUMBERS = {"mu_s": MU_S, "mu_d": MU_D, "v_0": V_0, "v_1": V_1}
BRISTLES = {"bristle_stiffness": SIGMA_0, "bristle_damping": SIGMA_1}
JOINTS = {name: joint(friction=name, **NUMBERS, **BRISTLES) for name in FRICTIONS}
LUGRE = JOINTS["lugre"]
STATIC = st.sampled_from([name for name, law in FRICTIONS.items() if not law.states])
SPEED = st.floats(-10.0, 10.0) | st.floats(-0.01, 0.01)
BRISTLE = st.floats(-MU_S / SIGMA_0, MU_S / SIGMA_0)


def mu(name, v, bristle=0.0):
    return friction_action(v, (0.0, 0.0, 0.0, bristle), JOINTS[name])[0]


def bristle_rate(v, bristle):
    return friction_action(v, (0.0, 0.0, 0.0, bristle), LUGRE)[3]


@given(name=st.sampled_from(sorted(FRICTIONS)), v=SPEED, bristle=BRISTLE)
def test_odd(name, v, bristle):
    assert mu(name, -v, -bristle) == -mu(name, v, bristle)


@given(name=STATIC, v=SPEED)
def test_dissipative_and_bounded(name, v):
    assert mu(name, v) * v >= 0.0
    assert abs(mu(name, v)) <= MU_S


@given(name=STATIC, v=SPEED, step=st.floats(0.0, 1e-6))
def test_continuous(name, v, step):
    """Lipschitz: no law rises faster than 1.5 mu_s/v_0 or falls faster than its ramp."""
    slope = 1.5 * MU_S / V_0
    assert abs(mu(name, v + step) - mu(name, v)) <= slope * step * (1.0 + 1e-6) + 1e-14


def test_ambrosio_is_the_ramp_of_chen_2025():
    """Table 4: nothing up to 0.1 mm/s, all of it from 1 mm/s on."""
    ramp = joint(friction="ambrosio", mu_d=0.03, v_0=1e-4, v_1=1e-3)
    assert friction_coefficient(1e-4, ramp) == 0.0
    assert friction_coefficient(5.5e-4, ramp) == pytest.approx(0.015)
    assert friction_coefficient(-1e-3, ramp) == pytest.approx(-0.03)
    assert friction_coefficient(1.0, ramp) == 0.03


def test_cubic_peaks_at_the_static_coefficient_and_is_smooth():
    """What Bai et al. (2016) name, formulas lost: mu_s at v_s, mu_d at v_d; zero slope at both is our reading."""
    assert mu("cubic", V_0) == pytest.approx(MU_S)
    assert mu("cubic", V_1) == pytest.approx(MU_D)
    for v in (V_0, V_1):
        for side in (-1e-7, 1e-7):
            change = mu("cubic", v + side) - mu("cubic", v)
            assert abs(change / side) < 2e-3 * MU_S / V_0


def slide(v, time, bristle=0.0, steps=20000):
    """Bristle state after sliding at a constant speed, by Heun's method."""
    step = time / steps
    for _ in range(steps):
        first = bristle_rate(v, bristle)
        second = bristle_rate(v, bristle + step * first)
        bristle += 0.5 * step * (first + second)
    return bristle


@pytest.mark.parametrize("v", [1e-4, -3e-3, 0.05])
def test_lugre_settles_on_stribecks_curve(v):
    """Sliding by thirty times the bristles' deflection leaves exp(-20) of the start."""
    bristle = slide(v, 30.0 * MU_S / SIGMA_0 / abs(v))
    steady = math.copysign(stribeck(v, MU_S, MU_D, V_1), v)
    assert bristle * SIGMA_0 == pytest.approx(steady, rel=1e-6)
    assert mu("lugre", v, bristle) == pytest.approx(steady, rel=1e-6)


@given(v=SPEED | st.floats(-1e4, 1e4), bristle=BRISTLE)
def test_lugre_is_passive(v, bristle):
    """Power taken in exceeds the growth of the bristles' energy sigma_0 z^2/2, in every state."""
    rate = bristle_rate(v, bristle)
    loss = v * mu("lugre", v, bristle) - SIGMA_0 * bristle * rate
    assert loss >= -1e-12 * (abs(v * mu("lugre", v, bristle)) + abs(SIGMA_0 * bristle * rate))


@given(v=SPEED)
def test_bristles_stay_within_the_static_limit(v):
    limit = MU_S / SIGMA_0
    assert bristle_rate(v, limit) <= 1e-12
    assert bristle_rate(v, -limit) >= -1e-12


def test_lugre_sticks_like_a_spring():
    """A small displacement x from rest gives mu = sigma_0 x to first order in x."""
    x = 1e-3 * MU_D / SIGMA_0
    bristle = slide(x / 1.0, 1.0, steps=1000)
    assert SIGMA_0 * bristle == pytest.approx(SIGMA_0 * x, rel=1e-3)
