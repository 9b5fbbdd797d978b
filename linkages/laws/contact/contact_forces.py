"""Contact forces; see the head of `linkages.laws.contact` for their arguments."""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import kernel
from linkages.base.kernel.dual import varies

#: Default bound of |ddelta/ddelta0|.
CLIP = 1.0
#: Latched speeds below this are taken as this [m/s]: such a contact dissipates almost nothing.
GRAZING = 1e-6

_NEWTON_STEPS = 12
_TINY = 1e-200  # relative penetrations with a load below the smallest float
_HALF_TURN = 0.5  # the implicit laws are used up to this fraction of their largest load


@kernel
def damped(elastic: float, ddelta: float, ddelta0: float, joint: np.record) -> float:
    """F_e*(1 + chi*ddelta/ddelta0), chi = ``joint.hysteresis``, the ratio clipped to +-``joint.damping_limit``."""
    ratio = ddelta / max(ddelta0, GRAZING)
    ratio = min(max(ratio, -joint.damping_limit), joint.damping_limit)
    return elastic * (1.0 + joint.hysteresis * ratio)


@kernel
def power_law(delta: float, ddelta: float, ddelta0: float, joint: np.record) -> float:
    """K*delta^n, damped; n = 1.5 is Hertz's theory."""
    hertz = joint.exponent == 1.5 and not varies(joint.exponent)
    elastic = joint.stiffness * (delta * math.sqrt(delta) if hertz else delta**joint.exponent)
    return damped(elastic, ddelta, ddelta0, joint)


@kernel
def kelvin_voigt(delta: float, ddelta: float, ddelta0: float, joint: np.record) -> float:
    """K*delta + D*ddelta: the force jumps to D*ddelta0 at the first touch, which no real contact does.

    `linkages.laws.contact.material.kelvin_voigt_damping` gives the D that reaches a restitution for one impacting
    mass.
    """
    return joint.stiffness * delta + joint.damping * ddelta


@kernel
def esdu_78035(delta: float, ddelta: float, ddelta0: float, joint: np.record) -> float:
    """Delta = F/S (ln(4 S DR/F) + 1), S = K, damped. Source: ESDU 78035, 1978."""
    elastic = line_contact(delta, joint.stiffness, joint.clearance, 4.0 * math.e)
    return damped(elastic, ddelta, ddelta0, joint)


@kernel
def johnson(delta: float, ddelta: float, ddelta0: float, joint: np.record) -> float:
    """Delta = F/S (ln(4 S DR/F) - 1), S = K, damped. Source: Johnson, Contact Mechanics, 1985."""
    elastic = line_contact(delta, joint.stiffness, joint.clearance, 4.0 / math.e)
    return damped(elastic, ddelta, ddelta0, joint)


@kernel
def dubowsky_freudenstein(delta: float, ddelta: float, ddelta0: float, joint: np.record) -> float:
    """Delta = F/S (ln(S DR L^2/(F R_b R_j)) + 1), S = K, damped.

    Source: Dubowsky and Freudenstein, J. Eng. Ind. 93, 1971.
    """
    elastic = line_contact(delta, joint.stiffness, joint.clearance, joint.shape_ratio * math.e)
    return damped(elastic, ddelta, ddelta0, joint)


@kernel
def line_contact(delta: float, stiffness: float, clearance: float, shape: float) -> float:
    """Solve delta/DR = u*ln(shape/u) for the load F = S*DR*u of two conformal cylinders [N].

    The right-hand side rises up to u = shape/e only; beyond half of that load, far outside the validity of the
    half-space theory, the law continues along its tangent. Newton's method: from the left of the root it rises to it
    monotonically, the right-hand side being concave.

    Parameters
    ----------
    delta : float
        Penetration [m].
    stiffness : float
        S = pi*E'*L [N/m] (`linkages.laws.contact.material.line_stiffness`).
    clearance : float
        DR = R_b - R_j [m].
    shape : float
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
