"""The contact laws by name; see the head of `linkages.laws.contact` for their signature.

To add a law: a line in `CONTACTS`, and for a new force a function in `linkages.laws.contact.contact_forces`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numba import types

from linkages.base.kernel import address, caller, inlined_kernel, kernel
from linkages.laws.contact.contact_forces import (
    CLIP,
    GRAZING,
    dubowsky_freudenstein,
    esdu_78035,
    johnson,
    kelvin_voigt,
    power_law,
)
from linkages.laws.contact.material import cylinder_stiffness, hertz_stiffness, line_shape, line_stiffness, modulus_of
from linkages.laws.parameters import Parameter, named_record, set_numbers, slots
from linkages.laws.states import (
    NEW,
    STATES,
    WITH_RATES,
    Remembered,
    State,
    call_with_states,
    contact_with_states,
    set_scales,
)

#: Smallest restitution that a law with 1/e uses.
LEAST_RESTITUTION = 1e-3

_SHALLOW = 1e-10  # smallest penetration of `push`, in parts of the clearance

_F = types.float64
_call = caller(_F)


class ContactLaw(NamedTuple):
    """A contact law: force, formula, validity, source."""

    force: Callable[..., float | tuple[float, ...]]  # with states also their rates
    formula: str
    valid: str
    source: str
    chi: str = ""  # chi(e) where the force is F_e*(1 + chi*ddelta/ddelta0)
    factor: Callable[[float], float] = lambda e: 0.0  # the same as a function
    conformal: bool = False  # its stiffness is S = pi E' L
    linear: bool = False  # stiffness of parallel cylinders; otherwise Hertz's
    parameters: tuple[Parameter, ...] = ()  # at most `SLOTS`
    needs: tuple[str, ...] = ("restitution", "stiffness")  # keys of `NEEDS`
    states: tuple[State, ...] = ()

    @property
    def address(self) -> int:
        """Address of the compiled force in this process, with states the one of `contact_with_states`."""
        record = named_record("contact", self.parameters, self.needs)
        if not self.states:
            return address(self.force, _F(_F, _F, _F, record))
        made = contact_with_states(self.force, len(self.states))
        return address(made, WITH_RATES(_F, _F, _F, *STATES * [_F], record))

    def own(self, values: Mapping[str, Any]) -> dict[str, str]:
        """Return the keys whose values the record has as they are, by its fields."""
        given = {"stiffness": "stiffness"} if values.get("stiffness") is not None else {}
        return slots("contact", self.parameters) | given

    def fill(self, record: Any, values: Mapping[str, Any]) -> None:
        """Write the law into a record that holds the geometry of its contact.

        Parameters
        ----------
        record : record of `linkages.laws.PARAMETERS`
            Without a radius, of a corner at a wall.
        values : mapping
            Keys of the experiment's table: parameters, restitution, stiffness or material of both bodies, clip.
        """
        record["contact"], record["damping_limit"] = self.address, CLIP if values.get("clip", True) else np.inf
        set_numbers(record, self.own(values), values)
        set_scales(record, "contact", self.states, values)
        if values.get("restitution") is not None:
            record["restitution"], record["hysteresis"] = values["restitution"], self.factor(values["restitution"])
        bearing, length = float(record["radius"]), float(record["length"])
        if bearing > 0.0:
            journal = bearing - float(record["clearance"])
            record["shape_ratio"] = line_shape(bearing, journal, length)
            if values.get("stiffness") is None and values.get("youngs_modulus") is not None:
                record["stiffness"] = self._stiffness(bearing, journal, length, modulus_of(values))

    def _stiffness(self, bearing: float, journal: float, length: float, modulus: float) -> float:
        """Compute the stiffness from the material; see `NEEDS`."""
        if self.conformal:
            return line_stiffness(length, modulus)
        return cylinder_stiffness(length, modulus) if self.linear else hertz_stiffness(bearing, journal, modulus)


#: Parameter of `power_law`.
EXPONENT = Parameter("exponent", "1", 1.5, "exponent n of power laws", ge=1.0, le=3.0, source="1.5: Hertz's theory")
#: Parameter of `kelvin_voigt`.
DAMPING = Parameter("damping", "N s/m", 0.0, "damping D", ge=0.0, source="0: none")


MAXWELL = (
    EXPONENT,
    Parameter(
        "branch_stiffness", "N/m", 0.0, "stiffness of a spring in series with a damper", ge=0.0, source="0: none"
    ),
    Parameter(
        "relaxation", "s", 1e-4, "relaxation time, damping over stiffness of the branch", gt=0.0, source="assumed"
    ),
)


@kernel
def maxwell(delta: float, ddelta: float, ddelta0: float, creep: float, joint: np.record) -> tuple[float, float]:
    """K*delta^n beside a spring and a damper in series, K_1*(delta - z), whose damper has the length z.

    A fast impact meets both springs, a slow one the first alone; between them the branch dissipates. Without contact
    the damper returns to its length. Source: the standard linear solid, Zener, Elasticity and Anelasticity of Metals,
    1948.
    """
    rate = (delta - creep) / joint.relaxation
    return joint.stiffness * delta**joint.exponent + joint.branch_stiffness * (delta - creep), rate


def _damped(chi: str, factor: Callable[[float], float], valid: str, source: str) -> ContactLaw:
    formula = "K delta^n (1 + chi ddelta/ddelta0)"
    return ContactLaw(power_law, formula, valid, source, chi, factor, parameters=(EXPONENT,))


def _lankarani_nikravesh(e: float) -> float:
    return 0.75 * (1.0 - e * e)


def _conformal(force: Callable[..., float], formula: str, source: str) -> ContactLaw:
    valid = "conformal cylinders, delta << DR"
    return ContactLaw(force, formula, valid, source, "3(1-e^2)/4", _lankarani_nikravesh, conformal=True)


#: The contact laws an experiment can name.
CONTACTS = {
    "hertz": ContactLaw(
        power_law, "K delta^n", "elastic, no loss", "Hertz 1882; Johnson, Contact Mechanics, 1985", "0",
        parameters=(EXPONENT,),
    ),
    "kelvin-voigt": ContactLaw(
        kelvin_voigt, "K delta + D ddelta",
        "one known impacting mass; jumps at first touch", "Goldsmith, Impact, 1960", linear=True,
        parameters=(DAMPING,),
    ),
    "hunt-crossley": _damped(
        "3(1-e)/2", lambda e: 1.5 * (1.0 - e),
        "e > 0.9", "Hunt and Crossley, J. Appl. Mech. 42, 1975",
    ),
    "lankarani-nikravesh": _damped(
        "3(1-e^2)/4", _lankarani_nikravesh,
        "e > 0.9, low speed, compact bodies", "Lankarani and Nikravesh, J. Mech. Des. 112, 1990",
    ),
    "herbert-mcwhannell": _damped(
        "6(1-e)/((2e-1)^2+3)", lambda e: 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
        "e > 0.7", "Herbert and McWhannell, J. Eng. Ind. 99, 1977",
    ),
    "lee-wang": _damped(
        "3(1-e)/4", lambda e: 0.75 * (1.0 - e),
        "e > 0.97: half the damping that small losses need", "Lee and Wang, J. Mech. Transm. 105, 1983",
    ),
    "flores": _damped(
        "8(1-e)/(5e)", lambda e: 1.6 * (1.0 - e) / max(e, LEAST_RESTITUTION),
        "any e", "Flores, Machado, Silva and Martins, Multibody Syst. Dyn. 25, 2011",
    ),
    "gonthier": _damped(
        "(1-e^2)/e", lambda e: (1.0 - e * e) / max(e, LEAST_RESTITUTION),
        "any e", "Gonthier, McPhee, Lange and Piedboeuf, Multibody Syst. Dyn. 11, 2004",
    ),
    "zhiying-qishao": _damped(
        "3(1-e^2)/4 exp(2(1-e))", lambda e: 0.75 * (1.0 - e * e) * math.exp(2.0 * (1.0 - e)),
        "e > 0.3", "Zhiying and Qishao, J. Dyn. Control 4, 2006",
    ),
    "hu-guo": _damped(
        "3(1-e)/(2e)", lambda e: 1.5 * (1.0 - e) / max(e, LEAST_RESTITUTION),
        "any e", "Hu and Guo, Multibody Syst. Dyn. 35, 2015",
    ),
    "maxwell": ContactLaw(
        maxwell, "K delta^n + K_1 (delta - z), dz/dt = (delta - z)/T",
        "viscoelastic bodies; one state per contact", "Zener, Elasticity and Anelasticity of Metals, 1948",
        parameters=MAXWELL, needs=("stiffness",), states=(State("creep", "m", 1e-4, "length of the damper"),),
    ),
    "esdu-78035": _conformal(esdu_78035, "delta = F/S (ln(4 S DR/F) + 1), S = pi E' L", "ESDU 78035, 1978"),
    "johnson": _conformal(
        johnson, "delta = F/S (ln(4 S DR/F) - 1), S = pi E' L", "Johnson, Contact Mechanics, 1985",
    ),
    "dubowsky-freudenstein": _conformal(
        dubowsky_freudenstein, "delta = F/S (ln(L^3 DR pi E'/(F R_b R_j)) + 1), S = pi E' L",
        "Dubowsky and Freudenstein, J. Eng. Ind. 93, 1971",
    ),
}  # fmt: skip


@inlined_kernel
def normal_force(
    delta: float, ddelta: float, remembered: Remembered, joint: np.record
) -> tuple[float, float, float, float]:
    """Evaluate the contact law of a joint: its force [N], which is zero without penetration and never negative; rates.

    Parameters
    ----------
    delta, ddelta : float
        Penetration [m] and its rate. Without penetration a law with states has none, and no rate of it.
    remembered : tuple
        What the contact remembers.
    joint : record of `linkages.laws.PARAMETERS`
    """
    touches = delta > 0.0
    if not touches and joint.contact_states == 0:
        return 0.0, 0.0, 0.0, 0.0
    force, a, b, c = unlimited_force(delta if touches else 0.0, ddelta if touches else 0.0, remembered, joint)
    return (max(force, 0.0) if touches else 0.0), a, b, c


@kernel
def contact_force(delta: float, ddelta: float, ddelta0: float, joint: np.record) -> float:
    """Evaluate the contact law of a joint, with states that are zero [N].

    Arguments as of `normal_force`, and the speed at which the contact began [m/s].
    """
    _, a, b, c = NEW
    force, _, _, _ = normal_force(delta, ddelta, (ddelta0, a, b, c), joint)
    return force


@inlined_kernel
def reference_speed(remembered: Remembered) -> float:
    """Return the speed at which a contact began, at least `GRAZING` [m/s]; infinite: it has no damping."""
    return max(remembered[0], GRAZING)


@inlined_kernel
def unlimited_force(
    delta: float, ddelta: float, remembered: Remembered, joint: np.record
) -> tuple[float, float, float, float]:
    """Evaluate the contact law of a joint at a penetration [N]; negative where the damping would pull.

    Arguments and results as of `normal_force`.
    """
    _, a, b, c = remembered
    began = reference_speed(remembered)
    if joint.contact_states:
        return call_with_states(joint.contact, (delta, ddelta, began, a, b, c, joint))
    return _call(joint.contact, (delta, ddelta, began, joint)), 0.0, 0.0, 0.0


@kernel
def push(delta: float, ddelta: float, remembered: Remembered, joint: np.record) -> float:
    """Compute how far the contact is from losing its force while the bodies still overlap.

    Arguments as of `normal_force`.

    Returns
    -------
    float
        Between -1 and 1 with the sign of `unlimited_force`; zero where this force vanishes. A penetration of zero or
        less counts as a very small one, so that the value is defined up to the parting.
    """
    depth = max(delta, _SHALLOW * joint.clearance)
    force, _, _, _ = unlimited_force(depth, ddelta, remembered, joint)
    elastic, _, _, _ = unlimited_force(depth, 0.0, remembered, joint)
    size = abs(force) + abs(elastic)
    return force / size if size > 0.0 else 1.0
