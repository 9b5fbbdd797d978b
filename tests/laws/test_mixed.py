"""Mixed lubrication: the blend of Chen 2025 eq. (15), and Greenwood and Tripp's asperities."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from joint_records import joint
from scipy.integrate import quad
from scipy.special import pbdv

from linkages.laws.contact.contact_laws import contact_force
from linkages.laws.film.films import film_force
from linkages.laws.mixed import asperity_force, asperity_pressure, dry_weight, gauss_five_halves, mix

CLEARANCE, TRANSITION, UNIT = 1e-4, 2e-6, 0.4 * 0.04 * 0.015**3 / 1e-8
STIFFNESS = 1e10
FILM_EPS_MAX = 0.99
LONG, NAME = joint(film="long"), "lankarani-nikravesh"


def radial(eps, v_n, v_t, spin, restitution=0.9):
    """Blended radial and tangential force: exact half film, Lankarani-Nikravesh."""
    ew = eps * spin - 2.0 * v_t / CLEARANCE
    f_n, f_t, _ = film_force(LONG, min(eps, FILM_EPS_MAX), v_n / CLEARANCE, ew, 1.33, np.empty(0))
    delta = (eps - 1.0) * CLEARANCE
    dry = -contact_force(delta, v_n, 0.1, joint(contact=NAME, restitution=restitution, stiffness=STIFFNESS))
    return mix(UNIT * f_n, dry, delta, TRANSITION), mix(UNIT * f_t, 0.0, delta, TRANSITION)


def test_blend_is_that_of_chen_2025():
    """Eq. (15): the film up to |e| = c, half and half at c + E_0/2, the contact beyond c + E_0."""
    assert mix(-3.0, -7.0, -1e-9, TRANSITION) == -3.0
    assert mix(-3.0, -7.0, 0.0, TRANSITION) == -3.0
    assert mix(-3.0, -7.0, 0.5 * TRANSITION, TRANSITION) == pytest.approx(-5.0)
    assert mix(-3.0, -7.0, TRANSITION, TRANSITION) == -7.0
    assert mix(-3.0, -7.0, 1.0, TRANSITION) == -7.0
    assert dry_weight(1e-9, 0.0) == 1.0  # without a transition the contact takes over at once


@given(
    eps=st.sampled_from([FILM_EPS_MAX, 1.0, 1.0 + TRANSITION / CLEARANCE]) | st.floats(0.5, 1.1),
    v_n=st.floats(-0.5, 0.5),
    v_t=st.floats(-0.5, 0.5),
    spin=st.floats(-50.0, 50.0),
)
def test_blend_is_continuous(eps, v_n, v_t, spin):
    here, there = radial(eps, v_n, v_t, spin), radial(eps * (1.0 + 1e-10), v_n, v_t, spin)
    # the film just below eps_max has the steepest slope: 5e3 times its unit, per unit of eps
    speed = math.hypot(v_n, v_t) / CLEARANCE + abs(spin)
    assert there == pytest.approx(here, abs=1e-10 * (1e6 * UNIT * speed + 1e7))


@given(eps=st.floats(0.0, 1.1), v_n=st.floats(-1.0, 1.0), v_t=st.floats(-1.0, 1.0), spin=st.floats(-50.0, 50.0))
def test_blend_is_passive(eps, v_n, v_t, spin):
    """The power in the frame of the film's mean rotation, beyond the elastic part, is never positive.

    The elastic part of the contact, weighed by the penetration, is a function of eps alone.
    """
    f_n, f_t = radial(eps, v_n, v_t, spin)
    delta = (eps - 1.0) * CLEARANCE
    elastic = -dry_weight(delta, TRANSITION) * STIFFNESS * max(delta, 0.0) ** 1.5
    power = (f_n - elastic) * v_n + f_t * (v_t - 0.5 * spin * eps * CLEARANCE)
    assert power <= 1e-9 * (abs(f_n * v_n) + abs(f_t * v_t) + abs(f_t * spin * CLEARANCE))


@pytest.mark.parametrize("u", [-5.9, -3.0, -1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 9.9])
def test_gauss_five_halves_by_quadrature(u):
    """And by the parabolic cylinder function: F_5/2(u) = Gamma(7/2)/sqrt(2 pi) exp(-u^2/4) D_-7/2(u)."""
    peak = max(u, 0.0)
    value, _ = quad(
        lambda x: 2.0 * x**6 * math.exp(-0.5 * (u + x * x) ** 2 + 0.5 * peak**2), 0.0, 5.0, epsabs=0.0, epsrel=1e-12
    )
    value *= math.exp(-0.5 * peak**2) / math.sqrt(2.0 * math.pi)
    assert gauss_five_halves(u) == pytest.approx(value, rel=1e-9)
    closed = math.gamma(3.5) / math.sqrt(2.0 * math.pi) * math.exp(-0.25 * u * u) * pbdv(-3.5, u)[0]
    assert gauss_five_halves(u) == pytest.approx(closed, rel=1e-8)


def test_gauss_five_halves_beyond_the_fit():
    """F_5/2(0) = 0.61664 (Greenwood and Tripp's table); joined to 2e-6 at -6, and gone above 10."""
    assert gauss_five_halves(0.0) == pytest.approx(0.61664, abs=1e-5)
    assert gauss_five_halves(-6.0 - 1e-9) == pytest.approx(gauss_five_halves(-6.0), rel=2e-6)
    assert gauss_five_halves(10.0) == 0.0


@pytest.mark.parametrize("eps", [0.9, 0.97, 0.99, 1.0, 1.005])
@pytest.mark.parametrize("roughness", [0.3e-6, 2e-6])
def test_asperity_force_by_quadrature(eps, roughness):
    pressure = asperity_pressure(roughness, 1e10, 1e-5, 1.1e11)

    def integrand(phi):
        return gauss_five_halves(CLEARANCE * (1.0 - eps * math.cos(phi)) / roughness) * math.cos(phi)

    arcs = [0.0, 0.05, 0.1, 0.2, 0.4, 0.8, math.pi]
    value = 2.0 * math.fsum(
        quad(integrand, low, high, epsabs=0.0, epsrel=1e-11, limit=200)[0] for low, high in pairwise(arcs)
    )
    force = asperity_force(eps, CLEARANCE, 0.015, 0.04, roughness, pressure)
    assert force == pytest.approx(pressure * 0.015 * 0.04 * value, rel=1e-7, abs=1e-20)


def test_asperities_push_back_ever_harder():
    pressure = asperity_pressure(math.hypot(0.4e-6, 0.3e-6), 1e10, 1e-5, 1.1e11)
    forces = [asperity_force(0.9 + 0.001 * k, CLEARANCE, 0.015, 0.04, 0.5e-6, pressure) for k in range(120)]
    assert forces[0] == 0.0
    assert forces == sorted(forces)
    assert forces[-1] > 0.0


def test_greenwood_tripp_factor():
    """Roughness combines as a root of squares; n beta sigma = 0.05, sigma/beta = 0.05, E' = 1e11 Pa."""
    # 16 sqrt(2) pi/15 * 0.0025 * sqrt(0.05) * 1e11 = 4.7391 * 5.5902e7
    assert asperity_pressure(math.hypot(3e-6, 4e-6), 1e8, 1e-4, 1e11) == pytest.approx(4.73910 * 5.590170e7, rel=1e-4)
