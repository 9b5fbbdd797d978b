"""Independent laws of clearance joints, for `paper_formulation.Data.law`.

Signature: (data, joint, eccentricity, its rate, angular velocities of bearing and journal, approach speed) ->
(force on the journal at its centre, couple on the journal). SI units.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import paper_formulation
from paper_formulation import LENGTH, RADIUS
from scipy.sparse import diags
from scipy.sparse.linalg import spsolve

RESTITUTION, YOUNG, POISSON = 0.9, 200e9, 0.3  # Table 4


def ambrosio(speed, mu=0.03, v_0=1e-4, v_1=1e-3):
    """Ramp between the two speeds of Table 4."""
    return np.sign(speed) * mu * np.interp(abs(speed), [v_0, v_1], [0.0, 1.0])


def cubic(speed, mu_s=0.15, mu_d=0.1, v_s=1e-3, v_d=1e-2):
    """Cubic steps -mu_s -> mu_s over [-v_s, v_s], mu_s -> mu_d over [v_s, v_d], as Adams' STEP."""

    def step(x, x0, h0, x1, h1):
        s = np.clip((x - x0) / (x1 - x0), 0.0, 1.0)
        return h0 + (h1 - h0) * s**2 * (3 - 2 * s)

    size = abs(speed)
    return np.sign(speed) * (step(size, -v_s, -mu_s, v_s, mu_s) if size < v_s else step(size, v_s, mu_s, v_d, mu_d))


def dry(friction):
    """Lankarani and Nikravesh's contact with Hertz's stiffness, and a law of friction."""

    def law(data, joint, e, v, omega_b, omega_j, approach):
        size = np.hypot(*e)
        delta = size - data.clearance[joint]
        if approach is None or delta <= 0.0:
            return np.zeros(2), 0.0
        journal = RADIUS - data.clearance[joint]
        s = (1 - POISSON**2) / YOUNG
        stiffness = 4 / (3 * (s + s)) * np.sqrt(RADIUS * journal / (RADIUS - journal))
        n = e / size
        t = np.array([-n[1], n[0]])
        ratio = np.clip(v @ n / max(approach, 1e-6), -1, 1)
        load = max(stiffness * delta**1.5 * (1 + 0.75 * (1 - RESTITUTION**2) * ratio), 0.0)
        # surfaces meet at the bearing's wall: the bearing's point there turns with radius |e| + R_j
        drag = friction(v @ t + omega_j * journal - omega_b * (size + journal)) * load
        return -load * n - drag * t, -journal * drag

    return law


def mixed(friction, transition=2e-6, film_limit=0.99):
    """Eq. (15), its film at no more than `film_limit` of the clearance."""

    def law(data, joint, e, v, omega_b, omega_j, approach):
        size, c = np.hypot(*e), data.clearance[joint]
        seen, rate = e, v
        if size > film_limit * c:  # the true rates of eps and of the wedge at a smaller eccentricity
            n = e / size
            seen = film_limit * c * n
            turn = 0.5 * (omega_b + omega_j) * (size - film_limit * c)
            rate = v - turn * np.array([-n[1], n[0]])
        wet = paper_formulation.film(data, joint, seen, rate, omega_b + omega_j)
        solid, couple = dry(friction)(data, joint, e, v, omega_b, omega_j, approach)
        weight = np.clip((size - c) / transition, 0.0, 1.0)
        return wet + weight * (solid - wet), weight * couple

    return law


def sheared(data, joint, e, v, omega_b, omega_j, approach):
    """The printed film with the shear torque of a film all around: Petroff's, and the moment of the pressure."""
    force = paper_formulation.film(data, joint, e, v, omega_b + omega_j)
    c = data.clearance[joint]
    around = 2 * np.pi / np.sqrt(1 - e @ e / c**2)  # integral of dtheta/(1 + eps cos(theta))
    petroff = data.viscosity[joint] * LENGTH * RADIUS**3 / c * around * (omega_j - omega_b)
    return force, -petroff - 0.5 * (e[0] * force[1] - e[1] * force[0])


@cache
def _operator(eps, slenderness, n, m):
    """Reynolds' operator on n places around and m across half the width, by finite volumes, with its gap."""
    theta, dz = 2 * np.pi * np.arange(n) / n, 1.0 / m
    gap = 1 + eps * np.cos(theta)
    half = (1 + eps * np.cos(theta + np.pi / n)) ** 3 / (2 * np.pi / n) ** 2
    across = gap**3 / (slenderness * dz) ** 2
    east, west = np.repeat(half, m), np.repeat(np.roll(half, 1), m)
    side = np.repeat(across, m)
    inner = np.tile(np.r_[np.ones(m - 1), 0.0], n)  # cell centres; symmetric at z = 0, p = 0 at the end z = 1
    outer = np.tile(np.r_[0.0, np.ones(m - 1)], n)
    end = np.tile(np.r_[np.zeros(m - 1), 2.0], n)
    size = n * m
    matrix = diags(
        [-(east + west) - side * (inner + outer + end), side[:-1] * inner[:-1], side[1:] * outer[1:],
         east[:-m], west[m:], [*west[:m]], [*east[-m:]]],
        [0, 1, -1, m, -m, size - m, m - size],
        format="csc",
    )  # fmt: skip
    return matrix, theta


def finite(eps, deps, wedge, slenderness, n=240, m=24):
    """Dimensionless force (radial, tangential) of Guembel's film by the 2D Reynolds equation, on one grid.

    d(h^3 dp/dtheta)/dtheta + (D/L)^2 h^3 d2p/dz2 = 12 dh/dt with h = 1 + eps cos(theta) about the widest gap seen from
    the journal's side: theta counts from the direction of -e. Force in units of mu L R^3/c^2.
    """
    matrix, theta = _operator(eps, slenderness, n, m)
    squeeze = 12 * (deps * np.cos(theta) - 0.5 * wedge * np.sin(theta))
    pressure = spsolve(matrix, np.repeat(squeeze, m)).reshape(n, m).clip(min=0.0).mean(axis=1)
    return 2 * np.pi / n * np.array([pressure @ np.cos(theta), pressure @ np.sin(theta)])
