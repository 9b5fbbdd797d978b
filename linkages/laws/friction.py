"""Friction between journal and bearing: the coefficient as a function of the sliding speed.

A friction law is a function ``law(v, joint) -> mu``; the tangential force on the journal is -mu*N along the sliding
direction in which v is positive. A law with states (`linkages.laws.states`) is ``law(v, ..., joint) -> mu, ...``: it
takes their values, and returns their rates.

v
    Sliding speed of the journal's surface on the bearing's [m/s]; zero without a normal load.
joint
    Record of `linkages.laws.PARAMETERS`: static and dynamic coefficient ``mu_s >= mu_d >= 0``, ``mu_s > 0`` (LuGre:
    ``mu_d > 0``); where both are zero no law is called. And the parameters that the law declares, by name.

All laws are odd in v and their states, continuous and dissipative (LuGre: passive). To add one: its function,
parameters and states here, and a line in `FRICTIONS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numba import types

from linkages.base.kernel import address, caller, inlined_kernel, kernel
from linkages.laws.parameters import Parameter, named_record, set_numbers, slots
from linkages.laws.states import (
    NEW,
    STATES,
    WITH_RATES,
    Remembered,
    State,
    call_with_states,
    friction_with_states,
    set_scales,
)

_F = types.float64
_call = caller(_F)

AMBROSIO = (
    Parameter("v_0", "m/s", 1e-4, "speed below which friction is zero", ge=0.0, source="Chen 2025, Table 4"),
    Parameter(
        "v_1", "m/s", 1e-3, "speed above which friction is full", gt=0.0, above="v_0", source="Chen 2025, Table 4"
    ),
)


@kernel
def ambrosio(v: float, joint: np.record) -> float:
    """Zero up to v_0, rising linearly to mu_d at v_1: no stiction, no jump where sliding turns round.

    Source: Chen 2025 Table 4 (its "limits of static and dynamic friction speed"); Ambrosio 2003.
    """
    ramp = min(max((abs(v) - joint.v_0) / (joint.v_1 - joint.v_0), 0.0), 1.0)
    return math.copysign(joint.mu_d * ramp, v)


CUBIC = (
    Parameter("v_0", "m/s", 1e-4, "speed of the largest (static) friction", gt=0.0, source="assumed"),
    Parameter("v_1", "m/s", 1e-3, "speed above which friction is dynamic", gt=0.0, above="v_0", source="assumed"),
)


@kernel
def cubic(v: float, joint: np.record) -> float:
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


COULOMB = (
    Parameter("v_1", "m/s", 1e-3, "speed at which friction is tanh(1) of its largest value", gt=0.0, source="assumed"),
)


@kernel
def coulomb(v: float, joint: np.record) -> float:
    """mu_d*tanh(v/v_1): smooth, 76 % of mu_d at v_1 and 96 % at 2 v_1.

    Source: regularised Coulomb friction; Marques, Flores, Claro and Lankarani, Nonlinear Dyn. 86, 2016.
    """
    return joint.mu_d * math.tanh(v / joint.v_1)


LUGRE = (
    Parameter("v_1", "m/s", 1e-3, "Stribeck's speed", gt=0.0, source="assumed"),
    Parameter(
        "bristle_stiffness", "1/m", 1e5, "stiffness sigma_0 of the bristles per unit of load", gt=0.0, source="assumed"
    ),
    Parameter(
        "bristle_damping", "s/m", 0.0, "damping sigma_1 of the bristles per unit of load", ge=0.0, source="assumed"
    ),
)


@kernel
def stribeck(v: float, mu_s: float, mu_d: float, v_1: float) -> float:
    """g(v) = mu_d + (mu_s - mu_d) exp(-(v/v_1)^2), the coefficient of steady sliding in LuGre's law."""
    return mu_d + (mu_s - mu_d) * math.exp(-((v / v_1) ** 2))


@kernel
def lugre(v: float, bristle: float, joint: np.record) -> tuple[float, float]:
    """sigma_0*z + sigma_1(v)*dz/dt, z the deflection of bristles: dz/dt = v - sigma_0*|v|*z/g(v), v_1 Stribeck's speed.

    |z| never leaves [0, mu_s/sigma_0] once it is inside.

    With a constant sigma_1 the law can feed energy in at high speed. Here
    sigma_1(v) = sigma_1/(1 + sigma_1*|v|/(4*mu_d)): then v*mu - d/dt(sigma_0*z^2/2) >= 0 in every state,
    since sigma_1(v)*|v| <= 4*g(v). At the speeds of presliding it is the constant one.

    Source: Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Trans. Autom. Control 40, 1995; passivity: Barabanov and
    Ortega, IEEE TAC 45, 2000.
    """
    rate = v - joint.bristle_stiffness * abs(v) * bristle / stribeck(v, joint.mu_s, joint.mu_d, joint.v_1)
    fading = joint.bristle_damping / (1.0 + 0.25 * joint.bristle_damping * abs(v) / joint.mu_d)
    return joint.bristle_stiffness * bristle + fading * rate, rate


def _full_deflection(values: Mapping[str, Any]) -> float:
    """Compute the deflection of the bristles under the static friction [m]."""
    return float((values.get("static") or values.get("coefficient") or 0.0) * (1.0 / values["bristle_stiffness"]))


BRISTLE = State("bristle", "m", _full_deflection, "deflection of the bristles")


#: Most sliding speeds, of either sign counted, at which a law can have kinks.
MOST_KINKS = 4


class FrictionLaw(NamedTuple):
    """A friction law: coefficient, formula, validity, source."""

    coefficient: Callable[..., float | tuple[float, ...]] | None  # with states also their rates; none: frictionless
    formula: str
    valid: str
    source: str
    states: tuple[State, ...] = ()
    parameters: tuple[Parameter, ...] = ()  # at most `SLOTS`
    needs: tuple[str, ...] = ("coefficient",)  # keys of `NEEDS`
    #: Sliding speeds, of either sign, at which the slope or the curvature jumps, as a function of the parameters.
    kinks: Callable[[Mapping[str, float]], tuple[float, ...]] = lambda parameters: ()

    @property
    def address(self) -> int:
        """Address of the compiled coefficient in this process, made by `friction_with_states` if it has states.

        0 without friction.
        """
        if self.coefficient is None:
            return 0
        record = named_record("friction", self.parameters, self.needs)
        if not self.states:
            return address(self.coefficient, _F(_F, record))
        return address(friction_with_states(self.coefficient, len(self.states)), WITH_RATES(_F, *STATES * [_F], record))

    def own(self, values: Mapping[str, Any]) -> dict[str, str]:
        """Return the keys whose values the record has as they are, by its fields."""
        given = [key for key in ("static", "coefficient") if values.get(key)]
        own = ({"mu_d": "coefficient"} if "coefficient" in given else {}) | ({"mu_s": given[0]} if given else {})
        return slots("friction", self.parameters) | own

    def fill(self, record: Any, values: Mapping[str, Any]) -> None:
        """Write the law into a record of `linkages.laws.PARAMETERS`, from the keys of the experiment's table."""
        record["friction"] = self.address
        set_scales(record, "friction", self.states, values)
        set_numbers(record, self.own(values), values)


def _both(parameters: Mapping[str, float]) -> tuple[float, ...]:
    return parameters["v_0"], parameters["v_1"]


#: The friction laws an experiment can name.
FRICTIONS = {
    "none": FrictionLaw(None, "0", "frictionless contact", "-", needs=()),
    "ambrosio": FrictionLaw(
        ambrosio, "mu_d clip((abs(v) - v_0)/(v_1 - v_0), 0, 1) sign(v)",
        "sliding; no stiction", "Chen 2025 Table 4; Ambrosio 2003", parameters=AMBROSIO, kinks=_both,
    ),
    "cubic": FrictionLaw(
        cubic, "cubic steps 0 -> mu_s at v_0 -> mu_d at v_1",
        "sliding with a static peak; creeps at rest", "Bai 2016 [0051]-[0055], formulas lost: our reading",
        parameters=CUBIC, kinks=_both,
    ),
    "coulomb": FrictionLaw(
        coulomb, "mu_d tanh(v/v_1)",
        "sliding; smooth for gradients", "Marques et al., Nonlinear Dyn. 86, 2016", parameters=COULOMB,
    ),
    "lugre": FrictionLaw(
        lugre,
        "sigma_0 z + sigma_1/(1 + sigma_1 abs(v)/(4 mu_d)) dz/dt, dz/dt = v - sigma_0 abs(v) z/g(v), "
        "g = mu_d + (mu_s - mu_d) exp(-(v/v_1)^2)",
        "stick and slip; one state per joint",
        "Canudas de Wit et al., IEEE TAC 40, 1995; passivity: Barabanov and Ortega 2000",
        states=(BRISTLE,), parameters=LUGRE, kinks=lambda parameters: (0.0,),
    ),
}  # fmt: skip


@inlined_kernel
def friction_action(v: float, remembered: Remembered, joint: np.record) -> tuple[float, float, float, float]:
    """Evaluate the friction law of a joint with what its contact remembers: coefficient, rates of the states."""
    if joint.friction == 0:
        return 0.0, 0.0, 0.0, 0.0
    if joint.friction_states:
        _, a, b, c = remembered
        return call_with_states(joint.friction, (v, a, b, c, joint))
    return _call(joint.friction, (v, joint)), 0.0, 0.0, 0.0


@kernel
def friction_coefficient(v: float, joint: np.record) -> float:
    """Evaluate the friction law of a joint, with states that are zero; see the head of the module."""
    mu, _, _, _ = friction_action(v, NEW, joint)
    return mu
