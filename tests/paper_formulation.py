"""The paper's own formulation of the seven-bar, written independently of the package.

Chen, Wang and Wang, China Mechanical Engineering 36(1), 2025: 18 absolute coordinates (16), 14 constraints (17),
Lagrange multipliers and Baumgarte stabilisation (22) with alpha = beta = 50, integrated with SciPy. The film
is eqs. (9)-(11) as printed, in terms of k, but for three corrections: e points from the bearing to the journal, the
attitude rate counts against the sum of both angular velocities, and the sign of F_LN in (11). Other joints are other
laws, see `joint_laws`; where they touch, integration stops at the start and the end of each contact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import contact_events
import numpy as np
from scipy.integrate import solve_ivp

L1, L2, L3, L4, L5, L6 = 0.080, 0.180, 0.318, 0.080, 0.301, 0.300  # Table 2 [m]
S1, S2, S3, S4, S6 = 0.040, 0.090, 0.159, 0.040, 0.150  # Table 2: mass centres [m]
THETA4 = np.radians(310.79)  # eq. (17)
RADIUS, LENGTH = 0.015, 0.04  # Tables 4 and 5 [m]
ALPHA = BETA = 50.0  # Table 4


def film_law(data, joint, e, v, omega_b, omega_j, approach):
    """Force on the journal of a film without shear torque, and no couple; other laws take the same arguments."""
    return film(data, joint, e, v, omega_b + omega_j), 0.0


@dataclass
class Data:
    """Masses [kg] and inertias [kg m2] of bodies 1, 2, 3, 4, 6, 7 (Table 3), film, drives and gravity."""

    mass: tuple = (0.107, 0.219, 0.374, 0.107, 0.354, 0.139)
    inertia: tuple = (1.179e-4, 7.736e-4, 3.595e-3, 1.179e-4, 3.056e-3, 6.083e-5)
    clearance: tuple = (0.3e-3, 0.3e-3)  # A, B
    viscosity: tuple = (0.4, 0.4)
    omega: tuple = (2 * np.pi, 2 * np.pi)  # cranks 1 and 4
    gravity: tuple = (0.0, 0.0)  # m/s2
    law: Callable = film_law


def film(data, joint, e, v, omega_sum):
    """Force on the journal from eqs. (9)-(11)."""
    c, mu = data.clearance[joint], data.viscosity[joint]
    size = np.hypot(*e)
    if size < 1e-12 * c:
        # the limit of eqs. (9)-(11) at the centre: pi k/(k + 1.5) -> pi, omega eps -> 0, -2 eps gamma' = -2 v_t/c
        return -6 * np.pi * mu * RADIUS**3 * LENGTH / c**3 * np.asarray(v)
    n = e / size
    eps = size / c
    eps_rate = (v @ n) / c
    gamma_rate = (e[0] * v[1] - v[0] * e[1]) / size**2  # eq. (6)
    wedge = omega_sum - 2 * gamma_rate
    q, s = 1 - eps**2, 2 + eps**2
    factor = 6 * mu * RADIUS**3 * LENGTH / c**2
    if eps_rate == 0.0:
        eps_rate = 1e-300
    k = np.sqrt(q * ((wedge / (2 * eps_rate)) ** 2 + 1 / eps**2))  # (10)
    if eps_rate > 0:  # (9)
        f_n = -factor * (4 * k * eps**2 / s + np.pi * (k + 3) / (k + 1.5)) * eps_rate / q**1.5
        f_t = factor * (k + 3) / (k + 1.5) * np.pi * eps * wedge / (s * q**0.5)
    else:  # (11), sign of F_LN corrected
        f_n = -factor * (np.pi * k / (k + 1.5) - 4 * k * eps**2 / s) * eps_rate / q**1.5
        f_t = factor * k / (k + 1.5) * np.pi * eps * wedge / (s * q**0.5)
    return f_n * n + f_t * np.array([-n[1], n[0]])


def constraints(q, t, data):
    """Phi (14,), eq. (17); coordinates of bodies 1, 2, 3, 4, 6, 7."""
    x1, y1, a1, x2, y2, a2, x3, y3, a3, x4, y4, a4, x6, y6, a6, x7, y7, a7 = q
    cos, sin = np.cos, np.sin
    return np.array(
        [
            x1 - S1 * cos(a1),
            y1 - S1 * sin(a1),
            x4 - S4 * cos(a4),
            y4 - S4 * sin(a4) - L5,
            x2 + (L2 - S2) * cos(a2) - x3 - (L3 - S3) * cos(a3),
            y2 + (L2 - S2) * sin(a2) - y3 - (L3 - S3) * sin(a3),
            x2 + (L2 - S2) * cos(a2) - x6 + S6 * cos(a6),
            y2 + (L2 - S2) * sin(a2) - y6 + S6 * sin(a6),
            x6 + (L6 - S6) * cos(a6) - x7,
            y6 + (L6 - S6) * sin(a6) - y7,
            y7,
            a7 - np.pi,
            a1 - data.omega[0] * t,
            a4 - THETA4 - data.omega[1] * t,
        ]
    )


def jacobian(q):
    """Phi_q (14, 18)."""
    J = np.zeros((14, 18))
    a1, a2, a3, a4, a6 = q[2], q[5], q[8], q[11], q[14]
    J[0, 0], J[0, 2] = 1, S1 * np.sin(a1)
    J[1, 1], J[1, 2] = 1, -S1 * np.cos(a1)
    J[2, 9], J[2, 11] = 1, S4 * np.sin(a4)
    J[3, 10], J[3, 11] = 1, -S4 * np.cos(a4)
    for row, trig in ((4, lambda a: -np.sin(a)), (5, np.cos)):
        column = row - 4
        J[row, 3 + column], J[row, 5] = 1, (L2 - S2) * trig(a2)
        J[row, 6 + column], J[row, 8] = -1, -(L3 - S3) * trig(a3)
        J[row + 2, 3 + column], J[row + 2, 5] = 1, (L2 - S2) * trig(a2)
        J[row + 2, 12 + column], J[row + 2, 14] = -1, S6 * trig(a6)
        J[row + 4, 12 + column], J[row + 4, 14] = 1, (L6 - S6) * trig(a6)
        J[row + 4, 15 + column] = -1
    J[10, 16] = J[11, 17] = J[12, 2] = J[13, 11] = 1
    return J


def gamma(q, v):
    """-(Phi_q v)_q v (14,): every angle enters as the position of a point on a circle."""
    a, w2 = q[2::3], v[2::3] ** 2
    centre = lambda i, r: r * w2[i] * np.array([np.cos(a[i]), np.sin(a[i])])  # noqa: E731
    g = np.zeros(14)
    g[0:2] = -centre(0, S1)
    g[2:4] = -centre(3, S4)
    g[4:6] = centre(1, L2 - S2) - centre(2, L3 - S3)
    g[6:8] = centre(1, L2 - S2) + centre(4, S6)
    g[8:10] = centre(4, L6 - S6)
    return g


def gaps(q, v):
    """Eccentricities of the journals A (on link 2) and B (on link 3) and their rates, with bodies and lever arms."""
    result = []
    for bearing, length_b, journal, length_j in ((0, L1 - S1, 1, S2), (3, L4 - S4, 2, S3)):
        pb, pj = q[3 * bearing : 3 * bearing + 2], q[3 * journal : 3 * journal + 2]
        ab, aj = q[3 * bearing + 2], q[3 * journal + 2]
        wb, wj = v[3 * bearing + 2], v[3 * journal + 2]
        rb = length_b * np.array([np.cos(ab), np.sin(ab)])
        rj = -length_j * np.array([np.cos(aj), np.sin(aj)])
        turn = lambda w, r: w * np.array([-r[1], r[0]])  # noqa: E731
        e = pj + rj - pb - rb
        relative = v[3 * journal : 3 * journal + 2] + turn(wj, rj) - v[3 * bearing : 3 * bearing + 2] - turn(wb, rb)
        result.append((e, relative, bearing, rb + e, journal, rj))
    return result


def joints(q, v, data, approach=(None, None)):
    """Add forces on the journals to the `gaps`: e, rate, force, couple, bearing, its arm, journal, its arm.

    `approach` has the speeds at which the contacts began [m/s], None without contact. A film has no force where
    a journal has left its bearing.
    """
    result = []
    for joint, (e, rate, bearing, arm_b, journal, arm_j) in enumerate(gaps(q, v)):
        force, couple = data.law(data, joint, e, rate, v[3 * bearing + 2], v[3 * journal + 2], approach[joint])
        result.append((e, rate, force, couple, bearing, arm_b, journal, arm_j))
    return result


def masses(data):
    """Diagonal of the mass matrix (21), (18,)."""
    return np.stack([data.mass, data.mass, data.inertia], axis=1).ravel()


def accelerations(t, q, v, data, approach=(None, None)):
    """Eq. (22)."""
    force = np.zeros(18)
    for _, _, f, couple, bearing, arm_b, journal, arm_j in joints(q, v, data, approach):
        for body, arm, sign in ((bearing, arm_b, -1), (journal, arm_j, 1)):
            force[3 * body : 3 * body + 2] += sign * f
            force[3 * body + 2] += sign * (arm[0] * f[1] - arm[1] * f[0] + couple)
    mass = masses(data)
    force += mass * np.tile([*data.gravity, 0.0], 6)
    J = jacobian(q)
    phi_t = np.zeros(14)
    phi_t[12:] = -np.array(data.omega)
    phi_rate = J @ v + phi_t
    right = gamma(q, v) - 2 * ALPHA * phi_rate - BETA**2 * constraints(q, t, data)
    free = force / mass
    multipliers = np.linalg.solve((J / mass) @ J.T, J @ free - right)
    return free - (J.T @ multipliers) / mass


def start(data):
    """Ideal position and velocity with centred journals: the constraints and e_A = e_B = 0, by Newton."""
    a1, a4 = 0.0, THETA4
    A = L1 * np.array([1.0, 0.0])
    B = np.array([L4 * np.cos(a4), L5 + L4 * np.sin(a4)])
    d = np.linalg.norm(B - A)
    u = (B - A) / d
    along = (L2**2 - L3**2 + d**2) / (2 * d)
    C = A + along * u + np.sqrt(L2**2 - along**2) * np.array([u[1], -u[0]])  # the branch with C on the right
    D = np.array([C[0] + np.sqrt(L6**2 - C[1] ** 2), 0.0])
    a2, a3, a6 = (np.arctan2(*(q - p)[::-1]) for p, q in ((A, C), (B, C), (C, D)))
    q = np.array(
        [
            *(0.5 * A), a1, *(A + C) / 2, a2, *(B + C) / 2, a3,
            *(B + np.array([0, L5])) / 2, a4, *(C + D) / 2, a6, *D, np.pi,
        ]
    )  # fmt: skip

    def closed(p, t):
        state = joints(p, np.zeros(18), data)
        return np.concatenate([constraints(p, t, data), state[0][0], state[1][0]])

    h = 1e-6  # consistent velocities: implicit differentiation of the 18 closed equations
    matrix = np.array([(closed(q + h * x, 0) - closed(q - h * x, 0)) / (2 * h) for x in np.eye(18)]).T
    rate = (closed(q, h) - closed(q, -h)) / (2 * h)
    assert np.abs(closed(q, 0)).max() < 1e-12
    return q, -np.linalg.solve(matrix, rate)


def solve(data, duration, rtol=1e-8, method="Radau"):
    """Integrate with a method of `solve_ivp`.

    Returns the step times, and a function of times: eccentricities (nt, 2, 2), forces (nt, 2, 2), slider
    accelerations (nt,).
    """
    q0, v0 = start(data)
    rates = lambda t, s: np.concatenate([s[18:], accelerations(t, s[:18], s[18:], data)])  # noqa: E731
    run = solve_ivp(
        rates, (0.0, duration), np.concatenate([q0, v0]), method=method, rtol=rtol, atol=1e-3 * rtol, dense_output=True
    )
    assert run.success

    def at(times):
        e, f, a = np.empty((len(times), 2, 2)), np.empty((len(times), 2, 2)), np.empty(len(times))
        for i, t in enumerate(times):
            state = run.sol(t)
            for j, item in enumerate(joints(state[:18], state[18:], data)):
                e[i, j], f[i, j] = item[0], item[2]
            a[i] = accelerations(t, state[:18], state[18:], data)[15]
        return e, f, a

    return run.t, at


def contacts(data, duration):
    """Contacts of joints that touch (0: A, 1: B), see `contact_events.contacts`."""

    def rates(t, s, approach):
        return np.concatenate([s[18:], accelerations(t, s[:18], s[18:], data, approach)])

    def depths(t, s):
        found = [(np.hypot(*e), e @ v) for e, v, *_ in joints(s[:18], s[18:], data)]
        sizes, products = np.array(found).T
        return sizes - data.clearance, products / np.maximum(sizes, 1e-300)

    def loads(t, s, approach):
        return [np.hypot(*force) for _, _, force, *_ in joints(s[:18], s[18:], data, approach)]

    return contact_events.contacts(rates, depths, loads, np.concatenate(start(data)), duration, 1e-9, 2e-4)
