"""Friction laws: odd, dissipative, continuous; LuGre's steady state and passivity."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkages.laws.friction import FRICTIONS, ambrosio, bristle_rate, cubic, friction_coefficient, stribeck

MU_S, MU_D, V_0, V_1 = 0.15, 0.1, 1e-3, 5e-3
SIGMA_0, SIGMA_1 = 1e5, 300.0
LUGRE = FRICTIONS["lugre"].code
STATIC = st.sampled_from([law.code for law in FRICTIONS.values() if law.code != LUGRE])
SPEED = st.floats(-10.0, 10.0) | st.floats(-0.01, 0.01)
BRISTLE = st.floats(-MU_S / SIGMA_0, MU_S / SIGMA_0)


def mu(code, v, bristle=0.0):
    return friction_coefficient(code, v, bristle, MU_S, MU_D, V_0, V_1, SIGMA_0, SIGMA_1)


@given(code=st.sampled_from([law.code for law in FRICTIONS.values()]), v=SPEED, bristle=BRISTLE)
def test_odd(code, v, bristle):
    assert mu(code, -v, -bristle) == -mu(code, v, bristle)


@given(code=STATIC, v=SPEED)
def test_dissipative_and_bounded(code, v):
    assert mu(code, v) * v >= 0.0
    assert abs(mu(code, v)) <= MU_S


@given(code=STATIC, v=SPEED, step=st.floats(0.0, 1e-6))
def test_continuous(code, v, step):
    """Lipschitz: no law rises faster than 1.5 mu_s/v_0 or falls faster than its ramp."""
    slope = 1.5 * MU_S / V_0
    assert abs(mu(code, v + step) - mu(code, v)) <= slope * step * (1.0 + 1e-6) + 1e-14


def test_ambrosio_is_the_ramp_of_seed_000():
    """Table 4: nothing up to 0.1 mm/s, all of it from 1 mm/s on."""
    assert ambrosio(1e-4, 0.03, 1e-4, 1e-3) == 0.0
    assert ambrosio(5.5e-4, 0.03, 1e-4, 1e-3) == pytest.approx(0.015)
    assert ambrosio(-1e-3, 0.03, 1e-4, 1e-3) == pytest.approx(-0.03)
    assert ambrosio(1.0, 0.03, 1e-4, 1e-3) == 0.03


def test_cubic_peaks_at_the_static_coefficient_and_is_smooth():
    """Bai et al. (2016): mu_s at v_s and mu_d at v_d, both with zero slope."""
    assert cubic(V_0, MU_S, MU_D, V_0, V_1) == pytest.approx(MU_S)
    assert cubic(V_1, MU_S, MU_D, V_0, V_1) == pytest.approx(MU_D)
    for v in (V_0, V_1):
        for side in (-1e-7, 1e-7):
            change = cubic(v + side, MU_S, MU_D, V_0, V_1) - cubic(v, MU_S, MU_D, V_0, V_1)
            assert abs(change / side) < 2e-3 * MU_S / V_0


def slide(v, time, bristle=0.0, steps=20000):
    """Bristle state after sliding at a constant speed, by Heun's method."""
    step = time / steps
    for _ in range(steps):
        first = bristle_rate(v, bristle, MU_S, MU_D, V_1, SIGMA_0)
        second = bristle_rate(v, bristle + step * first, MU_S, MU_D, V_1, SIGMA_0)
        bristle += 0.5 * step * (first + second)
    return bristle


@pytest.mark.parametrize("v", [1e-4, -3e-3, 0.05])
def test_lugre_settles_on_stribecks_curve(v):
    """Sliding by thirty times the bristles' deflection leaves exp(-20) of the start."""
    bristle = slide(v, 30.0 * MU_S / SIGMA_0 / abs(v))
    steady = math.copysign(stribeck(v, MU_S, MU_D, V_1), v)
    assert bristle * SIGMA_0 == pytest.approx(steady, rel=1e-6)
    assert mu(LUGRE, v, bristle) == pytest.approx(steady, rel=1e-6)


@given(v=SPEED | st.floats(-1e4, 1e4), bristle=BRISTLE)
def test_lugre_is_passive(v, bristle):
    """Power taken in exceeds the growth of the bristles' energy sigma_0 z^2/2, in every state."""
    rate = bristle_rate(v, bristle, MU_S, MU_D, V_1, SIGMA_0)
    loss = v * mu(LUGRE, v, bristle) - SIGMA_0 * bristle * rate
    assert loss >= -1e-12 * (abs(v * mu(LUGRE, v, bristle)) + abs(SIGMA_0 * bristle * rate))


@given(v=SPEED)
def test_bristles_stay_within_the_static_limit(v):
    limit = MU_S / SIGMA_0
    assert bristle_rate(v, limit, MU_S, MU_D, V_1, SIGMA_0) <= 1e-12
    assert bristle_rate(v, -limit, MU_S, MU_D, V_1, SIGMA_0) >= -1e-12


def test_lugre_sticks_like_a_spring():
    """A small displacement x from rest gives mu = sigma_0 x to first order in x."""
    x = 1e-3 * MU_D / SIGMA_0
    bristle = slide(x / 1.0, 1.0, steps=1000)
    assert SIGMA_0 * bristle == pytest.approx(SIGMA_0 * x, rel=1e-3)
