"""The film of finite length under a tilted journal, solved at each evaluation: Guembel's condition, no groove.

A map would need five parameters, because the tilt turns with the bearing and so is a motion of its own. The Reynolds
equation is therefore solved at once: along the bearing by Galerkin's method with `MODES` polynomials that vanish at
the ends, around it by finite volumes on `LINES` lines, graded towards the thin film. The blocks of this cyclic
tridiagonal system are of the size `MODES`. Its force errs by up to 4e-4, for which cells of
`linkages.laws.film.surface` need 60 times the time (L/D 1, eccentricity ratio 0.8, at an end 0.9).

With theta counted from the eccentricity, s = z/(L/2) in [-1, 1] and the tilt (a, b) as displacement of the end s = 1
over the clearance, along the eccentricity and across,

    h = 1 - (eps + a s) cos(theta) - b s sin(theta),
    d/dtheta (h^3 dp/dtheta) + 1/lam^2 d/ds (h^3 dp/ds) = 12 dh/dt,
    dh/dt = -(deps + W b s) cos(theta) + (ew/2 + W a s) sin(theta),

in the frame of the mean angular velocity, in which the tilt turns with -W, W = (omega_j - omega_b)/2. Pressure in units
of mu R^2/c^2, force mu L R^3/c^2. Source: derived from Reynolds' equation; checked against
`linkages.laws.film.surface` in the tests.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre

from linkages.base.kernel import Array, kernel, lazy_kernel
from linkages.base.kernel.dual import room
from linkages.laws.film.closed_form import THINNEST
from linkages.laws.film.surface.cavity import eliminate, folded
from linkages.laws.parameters import SHEAR

#: Polynomials along the bearing, and lines around it.
MODES, LINES = 7, 64
_POINTS = 10  # Gauss points along the bearing


def _modes(s: Array) -> tuple[Array, Array]:
    """Values and slopes of the polynomials (P_{k-1} - P_{k+1})/sqrt(4k + 2), k = 1 ... `MODES`, (MODES, ns) each."""
    values, slopes = np.zeros((MODES, len(s))), np.zeros((MODES, len(s)))
    for k in range(1, MODES + 1):
        series = np.zeros(k + 2)
        series[k - 1], series[k + 1] = 1.0, -1.0
        series /= math.sqrt(4.0 * k + 2.0)
        values[k - 1], slopes[k - 1] = legendre.legval(s, series), legendre.legval(s, legendre.legder(series))
    return values, slopes


_S, _W = legendre.leggauss(_POINTS)  # exact for the products below, of degree 19
_PHI, _SLOPE = _modes(_S)
_POWERS = _S ** np.arange(4)[:, None]
#: Integrals of s^j phi_k phi_l and s^j phi_k' phi_l', (4, MODES, MODES); of phi_k and s phi_k, (2, MODES).
_MASS = np.einsum("js,ks,ls,s->jkl", _POWERS, _PHI, _PHI, _W)
_STIFFNESS = np.einsum("js,ks,ls,s->jkl", _POWERS, _SLOPE, _SLOPE, _W)
_LOAD = np.einsum("js,ks,s->jk", _POWERS[:2], _PHI, _W)
_ENDS = _modes(-np.ones(1))[1][:, 0]  # slopes at the end s = -1
SHEAR_NONE, SHEAR_FULL = SHEAR["none"], SHEAR["full"]


@lazy_kernel(makes_arrays=True)
def tilted_film(
    eps: float, deps: float, ew: float, spin: float, a: float, b: float, slenderness: float
) -> tuple[float, float, float, float, float, float, float]:
    """Force, moment, extents and flow of the film under a tilted journal, both of whose ends are inside the clearance.

    Arguments as in the head of this module, spin is W [1/s]. Return the force f_n, f_t [mu L R^3/c^2] and the moment of
    the pressure m_n, m_t [mu L^2 R^3/(2 c^2)] on the journal, about the bearing's middle; the axial means of the
    integral of dtheta/h over the film that carries pressure, and over the whole film; the flow out of both ends where
    the film carries pressure [c R^2].
    """
    lines, modes = LINES, MODES
    faces, middles = room(eps, lines + 1), room(eps, lines)
    grade = 1.0 - math.sqrt(1.0 - eps * eps)
    step = 2.0 * math.pi / lines
    for i in range(lines + 1):  # the thin film is at 0
        xi = (i - 0.5) * step
        faces[i] = xi - grade * math.sin(xi)
    for i in range(lines):
        middles[i] = i * step - grade * math.sin(i * step)
    width = 3 * modes - 1
    band, pressure = room(eps, (lines * modes, 2 * width + 1)), room(eps, lines * modes)
    own, beside = room(eps, (modes, modes)), room(eps, (modes, modes))
    for i in range(lines):
        after = middles[i + 1] if i + 1 < lines else 2.0 * math.pi
        _cubes(eps, a, b, faces[i + 1], _MASS, 1.0 / (after - middles[i]), beside)
        span = faces[i + 1] - faces[i]
        _cubes(eps, a, b, middles[i], _STIFFNESS, span / (slenderness * slenderness), own)
        sines = math.sin(faces[i + 1]) - math.sin(faces[i])
        cosines = math.cos(faces[i]) - math.cos(faces[i + 1])
        here, there = folded(i, lines) * modes, folded((i + 1) % lines, lines) * modes
        for k in range(modes):
            pressure[here + k] = 12.0 * (
                _LOAD[0, k] * (deps * sines - 0.5 * ew * cosines) + _LOAD[1, k] * spin * (b * sines - a * cosines)
            )
            for j in range(modes):
                band[here + k, width + j - k] += own[k, j] + beside[k, j]
                band[there + k, width + j - k] += beside[k, j]
                band[here + k, width + there - here + j - k] -= beside[k, j]
                band[there + k, width + here - there + j - k] -= beside[k, j]
    eliminate(band, pressure, width)
    f_n, f_t, m_n, m_t, extent, whole, flow = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for g in range(_POINTS):
        s, weight = _S[g], 0.5 * _W[g]
        x, y = eps + a * s, b * s
        whole += weight * 2.0 * math.pi / math.sqrt(1.0 - x * x - y * y)
        for i in range(lines):
            p, here = 0.0, folded(i, lines) * modes
            for k in range(modes):
                p += _PHI[k, g] * pressure[here + k]
            if p > 0.0:
                along = weight * p * (math.sin(faces[i + 1]) - math.sin(faces[i]))
                across = weight * p * (math.cos(faces[i]) - math.cos(faces[i + 1]))
                f_n, f_t = f_n - along, f_t - across
                m_n, m_t = m_n + s * across, m_t - s * along
                gap = 1.0 - x * math.cos(middles[i]) - y * math.sin(middles[i])
                extent += weight * (faces[i + 1] - faces[i]) / gap
    for side in (-1.0, 1.0):
        for i in range(lines):
            rise, here = 0.0, folded(i, lines) * modes  # of the pressure from this end inwards
            for k in range(modes):
                rise += _ENDS[k] * pressure[here + k] * (1.0 if k % 2 == 0 or side < 0.0 else -1.0)
            gap = 1.0 - (eps + a * side) * math.cos(middles[i]) - b * side * math.sin(middles[i])
            flow += max(rise, 0.0) * gap * gap * gap * (faces[i + 1] - faces[i]) / (12.0 * slenderness)
    return f_n, f_t, m_n, m_t, extent, whole, flow


@lazy_kernel
def tilted_action(
    joint: np.record, e: float, v_n: float, v_t: float, omega_b: float, omega_j: float, alpha: float
) -> tuple[float, float, float, float, float, float]:
    """Force, couple, moment and flow of the film of a tilted journal; arguments of `linkages.laws.journal.film_action`.

    Eccentricity and rates belong to the middle, alpha is the eccentricity's angle in the bearing's frame [rad].
    Return the force f_n, f_t on the journal [N], the couple on it about the normal of the plane, the moment m_n, m_t in
    the plane about the bearing's middle [N m], and the flow out of both ends [m3/s].

    With the moment's part of the couple, (tilt . M)/2, the pair delivers F.v + couple (omega_j - omega_b) <= 0, for an
    observer in the bearing: minus the integral of h^3 |grad p|^2/12, and the shear.
    """
    c, turn = joint.clearance, alpha - joint.tilt_angle
    a, b = joint.tilt * math.cos(turn), -joint.tilt * math.sin(turn)
    ew = e / c * (omega_j + omega_b) - 2.0 * v_t / c
    f_n, f_t, m_n, m_t, extent, whole, flow = tilted_film(
        min(e / c, 1.0 - joint.tilt - THINNEST), v_n / c, ew, 0.5 * (omega_j - omega_b), a, b,
        0.5 * joint.length / joint.radius,
    )  # fmt: skip
    scale = joint.viscosity * joint.length * joint.radius**3 / (c * c)
    couple = 0.0
    if joint.shear != SHEAR_NONE:
        sheared = whole if joint.shear == SHEAR_FULL else extent
        couple = c * scale * (0.5 * (a * m_n + b * m_t) - sheared * (omega_j - omega_b)) - 0.5 * e * scale * f_t
    moment = 0.5 * joint.length * scale
    return scale * f_n, scale * f_t, couple, moment * m_n, moment * m_t, c * joint.radius**2 * flow


@kernel
def tilted_gap(joint: np.record, e: float, alpha: float) -> float:
    """Smallest film thickness under a tilted journal, which is at an end [m]; arguments as of `tilted_action`."""
    across = joint.tilt * abs(math.cos(alpha - joint.tilt_angle))
    eps = e / joint.clearance
    return joint.clearance * (1.0 - math.sqrt(eps * eps + 2.0 * eps * across + joint.tilt * joint.tilt))


@kernel
def _cubes(eps: float, a: float, b: float, theta: float, integrals: Array, factor: float, out: Array) -> None:
    """Fill ``out`` with the integral of h^3 times two polynomials, or their slopes, times a factor."""
    cosine, sine = math.cos(theta), math.sin(theta)
    h, slope = 1.0 - eps * cosine, a * cosine + b * sine
    c0, c1, c2, c3 = h * h * h, -3.0 * h * h * slope, 3.0 * h * slope * slope, -slope * slope * slope
    for k in range(MODES):
        for j in range(MODES):
            out[k, j] = factor * (
                c0 * integrals[0, k, j] + c1 * integrals[1, k, j] + c2 * integrals[2, k, j] + c3 * integrals[3, k, j]
            )
