"""Films against quadrature of the Reynolds pressure, and the laws every film must keep."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from joint_records import joint
from scipy.integrate import quad

from linkages.laws import FILMS
from linkages.laws.film.closed_form import EPS_MAX, half_film_long, pinkus_sternlicht, short_bearing
from linkages.laws.film.film_map import MapCase, load_map
from linkages.laws.film.films import film_force

EPS = st.floats(0.0, 0.999)
RATE = st.floats(-100.0, 100.0).filter(lambda rate: rate == 0.0 or abs(rate) > 1e-150)  # whose square does not vanish
FILM = st.sampled_from(sorted(FILMS))
CLOSED = st.sampled_from(sorted(set(FILMS) - {"finite"}))  # the map is as good as its spline, 5e-4
TABLE = load_map(MapCase(0.7))


def force(name, eps, deps, ew, slenderness=0.7):
    return film_force(joint(film=name), eps, deps, ew, slenderness, TABLE)


def long_film_by_quadrature(eps, deps, ew):
    """Integrate the long-bearing pressure over its half film; theta = 0 is the widest gap."""
    a = ew / (2.0 + eps**2)

    def shape(theta):
        return 6.0 / (1 + eps * np.cos(theta)) ** 2 * (deps / eps + a * np.sin(theta) * (2 + eps * np.cos(theta)))

    start = math.atan2(deps, a)  # the zero that the pressure has again at start + pi
    if shape(start + math.pi / 2) < shape(start):
        start += math.pi
    assert shape(start) == pytest.approx(shape(start + math.pi), rel=1e-9, abs=1e-9)

    def integrate(weight):
        f = lambda t: (shape(t) - shape(start)) * weight(t)  # noqa: E731
        return quad(f, start, start + math.pi, epsabs=1e-11, epsrel=1e-11)[0]

    extent = quad(lambda t: 1 / (1 + eps * np.cos(t)), start, start + math.pi)[0]
    return integrate(np.cos), integrate(np.sin), extent


@pytest.mark.parametrize("eps", [0.01, 0.3, 0.6, 0.9, 0.97])
@pytest.mark.parametrize(("deps", "ew"), [(1.0, 0.5), (-1.0, 0.5), (0.2, -1.0), (-0.1, -2.0), (1e-3, 1.0)])
def test_exact_half_film_equals_quadrature(eps, deps, ew):
    # quadrature is good to 1e-10 of the force's scale
    expected = long_film_by_quadrature(eps, deps, ew)
    scale = max(map(abs, expected))
    assert half_film_long(eps, deps, ew, 1.0) == pytest.approx(expected, rel=1e-9, abs=1e-9 * scale)


def test_pressure_of_the_half_film_solves_reynolds_equation():
    """h^3 p' must be 6*ew*cos - ... : d/dtheta(h^3 dp/dtheta) = 12*(deps*cos(theta) - ew/2*sin(theta))."""
    eps, deps, ew = 0.6, 0.7, -0.4
    a = ew / (2 + eps**2)
    theta = np.linspace(0.0, 2 * np.pi, 4001)
    h = 1 + eps * np.cos(theta)
    p = 6.0 / h**2 * (deps / eps + a * np.sin(theta) * (2 + eps * np.cos(theta)))
    flux = h**3 * np.gradient(p, theta, edge_order=2)
    left = np.gradient(flux, theta, edge_order=2)
    right = 12.0 * (deps * np.cos(theta) - 0.5 * ew * np.sin(theta))
    np.testing.assert_allclose(left[5:-5], right[5:-5], atol=2e-4 * np.abs(right).max())  # second differences


@pytest.mark.parametrize("eps", [0.05, 0.5, 0.9])
@pytest.mark.parametrize(("deps", "ew"), [(1.0, 0.5), (-1.0, 0.5), (0.2, -1.0), (-0.3, -2.0), (0.0, 1.0)])
def test_short_bearing_equals_quadrature(eps, deps, ew):
    slenderness = 0.25

    def pressure(theta):
        # p = 6 mu/h^3 * dh/dt_eff * (z^2 - L^2/4), integrated over z: -L^3/6 * ...
        source = deps * np.cos(theta) - 0.5 * ew * np.sin(theta)
        return max(-source, 0.0) / (1 + eps * np.cos(theta)) ** 3

    zero = math.atan2(deps, 0.5 * ew)
    cuts = sorted(z % (2 * math.pi) for z in (zero, zero + math.pi))
    total = [quad(lambda t: pressure(t) * f(t), 0, 2 * math.pi, points=cuts, limit=200)[0] for f in (np.cos, np.sin)]
    expected = [4 * slenderness**2 * x for x in total]
    got = short_bearing(eps, deps, ew, slenderness)[:2]
    assert got == pytest.approx(expected, rel=1e-7, abs=1e-9)


@given(FILM, EPS, RATE, RATE)
def test_films_are_passive(name, eps, deps, ew):
    """Seen from the frame that turns with half the sum of both speeds, the film only takes power."""
    f_n, f_t, _ = force(name, eps, deps, ew)
    scale = abs(f_n * deps) + abs(f_t * ew)
    assert f_n * deps - 0.5 * f_t * ew <= 1e-12 * scale


@given(FILM, EPS, RATE, RATE, st.floats(1e-3, 1e3))
def test_films_are_homogeneous_of_degree_one(name, eps, deps, ew, factor):
    f, g = force(name, eps, deps, ew), force(name, eps, factor * deps, factor * ew)
    scale = factor * max(abs(f[0]), abs(f[1]), 1e-300)
    assert g[0] == pytest.approx(factor * f[0], rel=1e-9, abs=1e-9 * scale)
    assert g[1] == pytest.approx(factor * f[1], rel=1e-9, abs=1e-9 * scale)


@given(FILM, EPS, RATE, RATE)
def test_mirror_image_turns_the_tangential_force(name, eps, deps, ew):
    f, g = force(name, eps, deps, ew), force(name, eps, deps, -ew)
    assert g[:2] == pytest.approx((f[0], -f[1]), rel=1e-12, abs=1e-300)


@given(FILM, EPS, st.floats(0.1, 10.0))
def test_no_jump_between_approach_and_separation(name, eps, ew):
    """Printed with the wrong sign, Chen 2025 eq. (11) jumps here by twice the wedge's normal force."""
    step = 1e-9 * ew
    below, above = force(name, eps, -step, ew), force(name, eps, step, ew)
    scale = abs(above[0]) + abs(above[1])
    tolerance = 1e-6 * scale / (1.0 - eps)  # the slope in deps grows as the film thins
    assert below[:2] == pytest.approx(above[:2], abs=tolerance)


def test_eq_11_as_printed_jumps_and_feeds_energy():
    """The misprint: F_LN for deps < 0 with the printed sign is not the continuation of eq. (9)."""
    eps, ew, deps = 0.5, 1.0, -1e-9
    k = math.sqrt((1 - eps**2) * ((ew / eps / (2 * deps)) ** 2 + 1 / eps**2))
    printed = -6 * (4 * k * eps**2 / (2 + eps**2) - math.pi * k / (k + 1.5)) * deps / (1 - eps**2) ** 1.5
    corrected = pinkus_sternlicht(eps, deps, ew, 1.0)[0]
    assert printed == pytest.approx(-corrected, rel=1e-6)
    assert corrected == pytest.approx(pinkus_sternlicht(eps, -deps, ew, 1.0)[0], rel=1e-6)


@given(st.floats(0.02, 0.95), RATE, RATE)
def test_pinkus_sternlicht_equals_the_paper_eqs_9_to_11(eps, deps, ew):
    assume(abs(deps) > 1e-3)
    k = math.sqrt((1 - eps**2) * ((ew / eps / (2 * deps)) ** 2 + 1 / eps**2))
    q, s = 1 - eps**2, 2 + eps**2
    if deps >= 0:
        f_n = -6 * (4 * k * eps**2 / s + math.pi * (k + 3) / (k + 1.5)) * deps / q**1.5
        f_t = 6 * (k + 3) / (k + 1.5) * math.pi * ew / (s * q**0.5)
    else:  # sign of F_LN corrected
        f_n = -6 * (math.pi * k / (k + 1.5) - 4 * k * eps**2 / s) * deps / q**1.5
        f_t = 6 * k / (k + 1.5) * math.pi * ew / (s * q**0.5)
    scale = abs(f_n) + abs(f_t)
    assert pinkus_sternlicht(eps, deps, ew, 1.0)[:2] == pytest.approx((f_n, f_t), abs=1e-10 * scale)


@pytest.mark.parametrize("eps", [0.05, 0.3, 0.6, 0.9])
def test_pinkus_sternlicht_is_within_nine_percent_of_the_exact_film(eps):
    angle = np.linspace(0.0, 2 * np.pi, 721)
    exact = np.array([half_film_long(eps, np.cos(t), 2 * np.sin(t), 1.0)[:2] for t in angle])
    fit = np.array([pinkus_sternlicht(eps, np.cos(t), 2 * np.sin(t), 1.0)[:2] for t in angle])
    error = np.hypot(*(fit - exact).T).max() / np.hypot(*exact.T).max()
    assert error < 0.09


def test_pinkus_sternlicht_is_many_times_too_large_when_separating_near_the_wall():
    ratios = [pinkus_sternlicht(e, -1.0, 0.0, 1.0)[0] / half_film_long(e, -1.0, 0.0, 1.0)[0] for e in (0.99, 0.999)]
    assert 20.0 < ratios[0] < 25.0
    assert ratios[1] > 200.0


@given(CLOSED, RATE, RATE)
def test_at_the_centre_the_force_is_isotropic(name, deps, ew):
    """At eps = 0 only the velocity counts: f_n/deps = f_t/(-ew/2)."""
    assume(abs(deps) > 1e-3)
    assume(abs(ew) > 1e-3)
    f_n, f_t, _ = force(name, 0.0, deps, ew)
    assert f_n / deps == pytest.approx(-f_t / (0.5 * ew), rel=1e-9)
    assert f_n / deps < 0.0


def test_rotation_only_has_the_sommerfeld_half_film_values():
    """Classical: f_n = -12 eps^2/((2+eps^2)(1-eps^2)), f_t = 6 pi eps/((2+eps^2) sqrt(1-eps^2)) for ew = eps."""
    for eps in (0.1, 0.5, 0.9):
        f_n, f_t, extent = half_film_long(eps, 0.0, eps, 1.0)
        assert f_n == pytest.approx(-12 * eps**2 / ((2 + eps**2) * (1 - eps**2)), rel=1e-12)
        assert f_t == pytest.approx(6 * math.pi * eps / ((2 + eps**2) * math.sqrt(1 - eps**2)), rel=1e-12)
        assert extent == pytest.approx(math.pi / math.sqrt(1 - eps**2), rel=1e-12)


@given(FILM, st.floats(1.0, 10.0), RATE, RATE)
def test_beyond_the_wall_the_force_stays_finite(name, eps, deps, ew):
    assert force(name, eps, deps, ew) == force(name, EPS_MAX, deps, ew)
    assert all(map(math.isfinite, force(name, eps, deps, ew)))
