"""Friction between journal and bearing: the coefficient as a function of the sliding speed.

Every law gives mu for the signature ``friction_coefficient(code, v, bristle, mu_s, mu_d, v_0, v_1,
bristle_stiffness, bristle_damping)``; the tangential force on the journal is -mu*N along the sliding
direction in which v is positive.

v
    Sliding speed of the journal's surface on the bearing's [m/s].
bristle
    State z of the bristles [m], of LuGre only (`bristle_rate` is its derivative); others ignore it.
mu_s, mu_d
    Static and dynamic coefficient, mu_s >= mu_d > 0.
v_0, v_1
    Speeds [m/s], 0 <= v_0 < v_1; what they mean is said with each law.
bristle_stiffness, bristle_damping
    sigma_0 [1/m] and sigma_1 [s/m], per unit of load, of LuGre only.

All laws are odd in (v, bristle), continuous and dissipative (LuGre: passive). To add a law: write the
function here and add a line to `FRICTIONS` and to `friction_coefficient`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from linkages.kernel import kernel


@kernel
def ambrosio(v: float, mu_d: float, v_0: float, v_1: float) -> float:
    """Zero up to v_0, rising linearly to mu_d at v_1: no stiction, no jump where sliding turns round.

    Source: Chen 2025 Table 4 (its "limits of static and dynamic friction speed"); Ambrosio 2003.
    """
    ramp = min(max((abs(v) - v_0) / (v_1 - v_0), 0.0), 1.0)
    return math.copysign(mu_d * ramp, v)


@kernel
def cubic(v: float, mu_s: float, mu_d: float, v_0: float, v_1: float) -> float:
    """Cubic steps: up to mu_s at v_0 > 0, down to mu_d at v_1, then constant; continuous slope.

    Source: Bai 2016 [0051]-[0055], modified Coulomb friction (v_0 = v_s, v_1 = v_d).
    """
    speed = abs(v)
    if speed >= v_1:
        mu = mu_d
    elif speed > v_0:
        s = (speed - v_0) / (v_1 - v_0)
        mu = mu_s + (mu_d - mu_s) * s * s * (3.0 - 2.0 * s)
    else:
        s = speed / v_0
        mu = 0.5 * mu_s * s * (3.0 - s * s)
    return math.copysign(mu, v)


@kernel
def coulomb(v: float, mu_d: float, v_1: float) -> float:
    """mu_d*tanh(v/v_1): smooth, 76 % of mu_d at v_1 and 96 % at 2 v_1.

    Source: regularised Coulomb friction; Marques, Flores, Claro and Lankarani, Nonlinear Dyn. 86, 2016.
    """
    return mu_d * math.tanh(v / v_1)


@kernel
def stribeck(v: float, mu_s: float, mu_d: float, v_1: float) -> float:
    """g(v) = mu_d + (mu_s - mu_d) exp(-(v/v_1)^2), the coefficient of steady sliding in LuGre's law."""
    return mu_d + (mu_s - mu_d) * math.exp(-((v / v_1) ** 2))


@kernel
def bristle_rate(v: float, bristle: float, mu_s: float, mu_d: float, v_1: float, stiffness: float) -> float:
    """dz/dt = v - sigma_0*|v|*z/g(v) [m/s]; |z| never leaves [0, mu_s/sigma_0] once it is inside.

    Source: Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Autom. Control 40, 1995.
    """
    return v - stiffness * abs(v) * bristle / stribeck(v, mu_s, mu_d, v_1)


@kernel
def lugre(
    v: float, bristle: float, mu_s: float, mu_d: float, v_1: float, stiffness: float, damping: float
) -> float:
    """sigma_0*z + sigma_1(v)*dz/dt, v_1 Stribeck's speed.

    With a constant sigma_1 the law can feed energy in at high speed. Here
    sigma_1(v) = sigma_1/(1 + sigma_1*|v|/(4*mu_d)): then v*mu - d/dt(sigma_0*z^2/2) >= 0 in every state,
    since sigma_1(v)*|v| <= 4*g(v). At the speeds of presliding it is the constant one.

    Source: Canudas de Wit et al. 1995; passivity: Barabanov and Ortega, IEEE TAC 45, 2000.
    """
    fading = damping / (1.0 + 0.25 * damping * abs(v) / mu_d)
    return stiffness * bristle + fading * bristle_rate(v, bristle, mu_s, mu_d, v_1, stiffness)


class Friction(NamedTuple):
    """A friction law by name: its code, what it is, and what it is good for."""

    code: int
    formula: str
    valid: str
    source: str


#: The friction laws an experiment can name.
FRICTIONS = {
    "none": Friction(0, "0", "frictionless contact", "-"),
    "ambrosio": Friction(
        1,
        "mu_d clip((abs(v) - v_0)/(v_1 - v_0), 0, 1) sign(v)",
        "sliding; no stiction",
        "Chen 2025 Table 4; Ambrosio 2003",
    ),
    "cubic": Friction(
        2,
        "cubic steps 0 -> mu_s at v_0 -> mu_d at v_1",
        "sliding with a static peak; creeps at rest",
        "Bai 2016 [0051]-[0055]",
    ),
    "coulomb": Friction(
        3, "mu_d tanh(v/v_1)", "sliding; smooth for gradients", "Marques et al., Nonlinear Dyn. 86, 2016"
    ),
    "lugre": Friction(
        4,
        "sigma_0 z + sigma_1 dz/dt, dz/dt = v - sigma_0 abs(v) z/g(v)",
        "stick and slip; one state per joint",
        "Canudas de Wit et al., IEEE TAC 40, 1995",
    ),
}


@kernel
def friction_coefficient(
    code: int,
    v: float,
    bristle: float,
    mu_s: float,
    mu_d: float,
    v_0: float,
    v_1: float,
    bristle_stiffness: float,
    bristle_damping: float,
) -> float:
    """Evaluate the friction law with this code. See the head of the module."""
    if code == 1:
        return ambrosio(v, mu_d, v_0, v_1)
    if code == 2:
        return cubic(v, mu_s, mu_d, v_0, v_1)
    if code == 3:
        return coulomb(v, mu_d, v_1)
    if code == 4:
        return lugre(v, bristle, mu_s, mu_d, v_1, bristle_stiffness, bristle_damping)
    return 0.0
