"""Friction between journal and bearing: the coefficient as a function of the sliding speed.

A friction law is a function ``law(v, bristle, joint) -> mu``; the tangential force on the journal is -mu*N along the
sliding direction in which v is positive.

v
    Sliding speed of the journal's surface on the bearing's [m/s].
bristle
    State z of the bristles [m], of LuGre only (`bristle_rate` is its rate).
joint
    Record of `linkages.laws.PARAMETERS`: static and dynamic coefficient ``mu_s >= mu_d >= 0``, ``mu_s > 0`` (LuGre:
    ``mu_d > 0``); where both are zero no law is called. Speeds ``v_0 >= 0`` and ``v_1 > 0`` [m/s], whose meaning is
    said with each law, ``v_0 < v_1`` of a law with `Friction.two_speeds`; ``bristle_stiffness`` sigma_0 [1/m] and
    ``bristle_damping`` sigma_1 [s/m], per unit of load.

All laws are odd in (v, bristle), continuous and dissipative (LuGre: passive). To add one: its function here, and a
line in `FRICTIONS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import types

from linkages.kernel import address, caller, kernel
from linkages.laws.parameters import RECORD

_F = types.float64
_SIGNATURE = _F(_F, _F, RECORD)
_call = caller(_F)


@kernel
def ambrosio(v: float, bristle: float, joint: np.record) -> float:
    """Zero up to v_0, rising linearly to mu_d at v_1: no stiction, no jump where sliding turns round.

    Source: Chen 2025 Table 4 (its "limits of static and dynamic friction speed"); Ambrosio 2003.
    """
    ramp = min(max((abs(v) - joint.v_0) / (joint.v_1 - joint.v_0), 0.0), 1.0)
    return math.copysign(joint.mu_d * ramp, v)


@kernel
def cubic(v: float, bristle: float, joint: np.record) -> float:
    """Cubic steps: up to mu_s at v_0 > 0, down to mu_d at v_1, then constant; continuous slope.

    Source: Bai 2016 [0051]-[0055], modified Coulomb friction (v_0 = v_s, v_1 = v_d); its formulas are lost in the text
    that is known, which names the steps' speeds and coefficients: our reading.
    """
    speed, mu_s, mu_d = abs(v), joint.mu_s, joint.mu_d
    if speed >= joint.v_1:
        mu = mu_d
    elif speed > joint.v_0:
        s = (speed - joint.v_0) / (joint.v_1 - joint.v_0)
        mu = mu_s + (mu_d - mu_s) * s * s * (3.0 - 2.0 * s)
    else:
        s = speed / joint.v_0
        mu = 0.5 * mu_s * s * (3.0 - s * s)
    return math.copysign(mu, v)


@kernel
def coulomb(v: float, bristle: float, joint: np.record) -> float:
    """mu_d*tanh(v/v_1): smooth, 76 % of mu_d at v_1 and 96 % at 2 v_1.

    Source: regularised Coulomb friction; Marques, Flores, Claro and Lankarani, Nonlinear Dyn. 86, 2016.
    """
    return joint.mu_d * math.tanh(v / joint.v_1)


@kernel
def stribeck(v: float, joint: np.record) -> float:
    """g(v) = mu_d + (mu_s - mu_d) exp(-(v/v_1)^2), the coefficient of steady sliding in LuGre's law."""
    return joint.mu_d + (joint.mu_s - joint.mu_d) * math.exp(-((v / joint.v_1) ** 2))


@kernel
def bristle_rate(v: float, bristle: float, joint: np.record) -> float:
    """dz/dt = v - sigma_0*|v|*z/g(v) [m/s]; |z| never leaves [0, mu_s/sigma_0] once it is inside.

    Source: Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Autom. Control 40, 1995.
    """
    return v - joint.bristle_stiffness * abs(v) * bristle / stribeck(v, joint)


@kernel
def lugre(v: float, bristle: float, joint: np.record) -> float:
    """sigma_0*z + sigma_1(v)*dz/dt, v_1 Stribeck's speed.

    With a constant sigma_1 the law can feed energy in at high speed. Here
    sigma_1(v) = sigma_1/(1 + sigma_1*|v|/(4*mu_d)): then v*mu - d/dt(sigma_0*z^2/2) >= 0 in every state,
    since sigma_1(v)*|v| <= 4*g(v). At the speeds of presliding it is the constant one.

    Source: Canudas de Wit et al. 1995; passivity: Barabanov and Ortega, IEEE TAC 45, 2000.
    """
    fading = joint.bristle_damping / (1.0 + 0.25 * joint.bristle_damping * abs(v) / joint.mu_d)
    return joint.bristle_stiffness * bristle + fading * bristle_rate(v, bristle, joint)


class Friction(NamedTuple):
    """A friction law: its coefficient, what it is, and what it is good for."""

    coefficient: Callable[..., float] | None  # none: frictionless
    formula: str
    valid: str
    source: str
    bristles: bool = False  # whether the joint has LuGre's bristles as a state
    two_speeds: bool = True  # whether it needs v_0 below v_1

    @property
    def address(self) -> int:
        """Address of the compiled coefficient in this process; 0 without friction."""
        return 0 if self.coefficient is None else address(self.coefficient, _SIGNATURE)


#: The friction laws an experiment can name.
FRICTIONS = {
    "none": Friction(None, "0", "frictionless contact", "-", two_speeds=False),
    "ambrosio": Friction(
        ambrosio, "mu_d clip((abs(v) - v_0)/(v_1 - v_0), 0, 1) sign(v)",
        "sliding; no stiction", "Chen 2025 Table 4; Ambrosio 2003",
    ),
    "cubic": Friction(
        cubic, "cubic steps 0 -> mu_s at v_0 -> mu_d at v_1",
        "sliding with a static peak; creeps at rest", "Bai 2016 [0051]-[0055], formulas lost: our reading",
    ),
    "coulomb": Friction(
        coulomb, "mu_d tanh(v/v_1)",
        "sliding; smooth for gradients", "Marques et al., Nonlinear Dyn. 86, 2016", two_speeds=False,
    ),
    "lugre": Friction(
        lugre, "sigma_0 z + sigma_1 dz/dt, dz/dt = v - sigma_0 abs(v) z/g(v)",
        "stick and slip; one state per joint", "Canudas de Wit et al., IEEE TAC 40, 1995",
        bristles=True, two_speeds=False,
    ),
}  # fmt: skip


@kernel
def friction_coefficient(v: float, bristle: float, joint: np.record) -> float:
    """Evaluate the friction law of a joint; see the head of the module."""
    if joint.friction == 0:
        return 0.0
    return _call(joint.friction, (v, bristle, joint))
