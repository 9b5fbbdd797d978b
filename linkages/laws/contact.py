"""Normal contact of a journal in a bearing: many laws behind one signature, `contact_force`.

delta, ddelta
    Penetration |e| - c [m] and its rate v.n [m/s], positive while journal and bearing approach.
ddelta0
    Approach speed at the start of *this* contact [m/s], latched by the caller, >= 0.
stiffness
    K of F = K delta^n [N/m^n] (`hertz_stiffness`); for conformal cylinders S = pi*E'*L [N/m]
    (`line_stiffness`).
exponent
    n, 1.5 for Hertz; Kelvin-Voigt and the laws for conformal cylinders have none.
restitution
    Nominal coefficient of restitution e, in [0, 1]; laws that divide by e use `LEAST_RESTITUTION` at least.
damping
    D of Kelvin-Voigt [N s/m] (`kelvin_voigt_damping`).
clearance, shape
    DR = R_b - R_j [m], of conformal cylinders, and L^2/(R_b*R_j), of Dubowsky-Freudenstein.
limit
    Largest |ddelta/ddelta0| that the damping sees: `CLIP` by default, infinity to switch the clip off.

Returned is the normal force [N]: zero without penetration, never negative (a contact does not pull).

All but Kelvin-Voigt have the form F = F_e(delta)*(1 + chi*ddelta/ddelta0). Their *effective* restitution e'
depends on chi alone, whatever stiffness, exponent, mass and speed (divide m*v*dv = -F*d(delta) by
1 + chi*v/ddelta0 and integrate over the impact):

    chi - ln(1 + chi) = -chi*e' - ln(1 - chi*e')        (`effective_restitution`)

**Why the ratio is clipped.** chi is derived for a free impact, where |ddelta| <= ddelta0. A journal that
swings inside a contact which never separates can move many times faster than the latched speed, and the
damping explodes. Clipped, the force stays below F_e*(1 + chi). Latched speeds below `GRAZING` are taken as
`GRAZING`, which keeps the force continuous in a contact that starts without any speed.

To add a law: write the function here, and add a line to `CONTACTS` and to the if-chain it belongs to.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from linkages.kernel import kernel

#: Default bound of |ddelta/ddelta0|.
CLIP = 1.0
#: Latched speeds below this are taken as this [m/s]: such a contact dissipates next to nothing anyway.
GRAZING = 1e-6
#: Smallest restitution that a law with 1/e uses.
LEAST_RESTITUTION = 1e-3

_NEWTON_STEPS = 12
_TINY = 1e-200  # penetrations below this part of the clearance carry no load that floats could hold
_HALF_TURN = 0.5  # the implicit laws are used up to this part of the load where they stop rising


@kernel
def chi_hunt_crossley(e: float) -> float:
    """3(1 - e)/2."""
    return 1.5 * (1.0 - e)


@kernel
def chi_lankarani_nikravesh(e: float) -> float:
    """3(1 - e^2)/4."""
    return 0.75 * (1.0 - e * e)


@kernel
def chi_herbert_mcwhannell(e: float) -> float:
    """6(1 - e)/((2e - 1)^2 + 3)."""
    return 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0)


@kernel
def chi_lee_wang(e: float) -> float:
    """3(1 - e)/4."""
    return 0.75 * (1.0 - e)


@kernel
def chi_flores(e: float) -> float:
    """8(1 - e)/(5e)."""
    return 1.6 * (1.0 - e) / max(e, LEAST_RESTITUTION)


@kernel
def chi_gonthier(e: float) -> float:
    """(1 - e^2)/e."""
    return (1.0 - e * e) / max(e, LEAST_RESTITUTION)


@kernel
def chi_zhiying_qishao(e: float) -> float:
    """3(1 - e^2)/4 * exp(2(1 - e))."""
    return 0.75 * (1.0 - e * e) * math.exp(2.0 * (1.0 - e))


@kernel
def chi_hu_guo(e: float) -> float:
    """3(1 - e)/(2e)."""
    return 1.5 * (1.0 - e) / max(e, LEAST_RESTITUTION)


@kernel
def damped(elastic: float, chi: float, ddelta: float, ddelta0: float, limit: float) -> float:
    """F_e*(1 + chi*ddelta/ddelta0), the ratio clipped to [-limit, limit], the force to >= 0."""
    ratio = ddelta / max(ddelta0, GRAZING)
    ratio = min(max(ratio, -limit), limit)
    return max(elastic * (1.0 + chi * ratio), 0.0)


@kernel
def power_law(delta: float, stiffness: float, exponent: float) -> float:
    """K*delta^n for delta > 0, else 0."""
    if delta <= 0.0:
        return 0.0
    return stiffness * (delta * math.sqrt(delta) if exponent == 1.5 else delta**exponent)


@kernel
def kelvin_voigt(delta: float, ddelta: float, stiffness: float, damping: float) -> float:
    """K*delta + D*ddelta: the force jumps to D*ddelta0 at the first touch, which no real contact does.

    `kelvin_voigt_damping` gives the D that reaches a restitution for one impacting mass.
    """
    return max(stiffness * delta + damping * ddelta, 0.0) if delta > 0.0 else 0.0


@kernel
def line_contact(delta: float, stiffness: float, clearance: float, shape: float) -> float:
    """Solve delta/DR = u*ln(shape/u) for the load F = stiffness*DR*u of two conformal cylinders.

    The right-hand side rises up to u = shape/e only; beyond half of that load, far outside the validity of
    the half-space theory, the law goes on along its tangent. Newton's method: from the left of the root it
    rises to it monotonically, the right-hand side being concave.
    """
    depth = delta / clearance
    if depth < _TINY:
        return 0.0
    end = _HALF_TURN * shape / math.e
    rise = math.log(shape / end)
    if depth >= end * rise:
        return stiffness * clearance * (end + (depth - end * rise) / (rise - 1.0))
    u = depth / math.log(shape / min(depth, end))  # two steps of the fixed point from the right
    u = depth / math.log(shape / min(u, end))
    for _ in range(_NEWTON_STEPS):
        slope = math.log(shape / u)
        step = (depth - u * slope) / (slope - 1.0)
        u += step
        if abs(step) <= 1e-15 * u:
            break
    return stiffness * clearance * u


class Contact(NamedTuple):
    """A normal contact law by name: its code, what it is, and what it is good for."""

    code: int
    formula: str
    valid: str
    source: str
    chi: str  # chi(e) where the force is F_e*(1 + chi*ddelta/ddelta0), else empty


_DAMPED = "K delta^n (1 + chi ddelta/ddelta0)"

#: The contact laws an experiment can name.
CONTACTS = {
    "hertz": Contact(0, "K delta^n", "elastic, no loss", "Hertz 1882; Johnson, Contact Mechanics, 1985", "0"),
    "kelvin-voigt": Contact(
        1,
        "K delta + D ddelta",
        "one known impacting mass; jumps at first touch",
        "Goldsmith, Impact, 1960",
        "",
    ),
    "hunt-crossley": Contact(
        2,
        _DAMPED,
        "e > 0.9",
        "Hunt and Crossley, J. Appl. Mech. 42, 1975",
        "3(1-e)/2",
    ),
    "lankarani-nikravesh": Contact(
        3,
        _DAMPED,
        "e > 0.9, low speed, compact bodies",
        "Lankarani and Nikravesh, J. Mech. Des. 112, 1990",
        "3(1-e^2)/4",
    ),
    "herbert-mcwhannell": Contact(
        4,
        _DAMPED,
        "e > 0.7",
        "Herbert and McWhannell, J. Eng. Ind. 99, 1977",
        "6(1-e)/((2e-1)^2+3)",
    ),
    "lee-wang": Contact(
        5,
        _DAMPED,
        "e > 0.97: half the damping that small losses need",
        "Lee and Wang, J. Mech. Transm. 105, 1983",
        "3(1-e)/4",
    ),
    "flores": Contact(
        6,
        _DAMPED,
        "any e",
        "Flores, Machado, Silva and Martins, Multibody Syst. Dyn. 25, 2011",
        "8(1-e)/(5e)",
    ),
    "gonthier": Contact(
        7,
        _DAMPED,
        "any e",
        "Gonthier, McPhee, Lange and Piedboeuf, Multibody Syst. Dyn. 11, 2004",
        "(1-e^2)/e",
    ),
    "zhiying-qishao": Contact(
        8,
        _DAMPED,
        "e > 0.3",
        "Zhiying and Qishao, J. Dyn. Control 4, 2006",
        "3(1-e^2)/4 exp(2(1-e))",
    ),
    "hu-guo": Contact(
        9,
        _DAMPED,
        "any e",
        "Hu and Guo, Multibody Syst. Dyn. 35, 2015",
        "3(1-e)/(2e)",
    ),
    "esdu-78035": Contact(
        10,
        "delta = F/S (ln(4 S DR/F) + 1), S = pi E' L",
        "conformal cylinders, delta << DR",
        "ESDU 78035, 1978",
        "3(1-e^2)/4",
    ),
    "johnson": Contact(
        11,
        "delta = F/S (ln(4 S DR/F) - 1), S = pi E' L",
        "conformal cylinders, delta << DR",
        "Johnson, Contact Mechanics, 1985",
        "3(1-e^2)/4",
    ),
    "dubowsky-freudenstein": Contact(
        12,
        "delta = F/S (ln(L^3 DR pi E'/(F R_b R_j)) + 1), S = pi E' L",
        "conformal cylinders, delta << DR",
        "Dubowsky and Freudenstein, J. Eng. Ind. 93, 1971",
        "3(1-e^2)/4",
    ),
}


@kernel
def hysteresis_factor(code: int, e: float) -> float:
    """Evaluate chi(e) of the law with this code; 0 for Hertz and Kelvin-Voigt."""
    if code < 2:
        return 0.0
    if code == 2:
        return chi_hunt_crossley(e)
    if code == 4:
        return chi_herbert_mcwhannell(e)
    if code == 5:
        return chi_lee_wang(e)
    if code == 6:
        return chi_flores(e)
    if code == 7:
        return chi_gonthier(e)
    if code == 8:
        return chi_zhiying_qishao(e)
    if code == 9:
        return chi_hu_guo(e)
    return chi_lankarani_nikravesh(e)


@kernel
def elastic_force(
    code: int, delta: float, stiffness: float, exponent: float, clearance: float, shape: float
) -> float:
    """Evaluate the elastic force F_e(delta) of the law with this code [N]."""
    if code == 10:
        return line_contact(delta, stiffness, clearance, 4.0 * math.e)
    if code == 11:
        return line_contact(delta, stiffness, clearance, 4.0 / math.e)
    if code == 12:
        return line_contact(delta, stiffness, clearance, shape * math.e)
    return power_law(delta, stiffness, exponent)


@kernel
def contact_force(
    code: int,
    delta: float,
    ddelta: float,
    ddelta0: float,
    stiffness: float,
    exponent: float,
    restitution: float,
    damping: float,
    clearance: float,
    shape: float,
    limit: float,
) -> float:
    """Evaluate the contact law with this code. See the head of the module."""
    if code == 1:
        return kelvin_voigt(delta, ddelta, stiffness, damping)
    elastic = elastic_force(code, delta, stiffness, exponent, clearance, shape)
    return damped(elastic, hysteresis_factor(code, restitution), ddelta, ddelta0, limit)
