"""From material and geometry to the constants of the contact laws; and what restitution they really give.

Units are SI. Journal and bearing are elastic, with Young's modulus E and Poisson's ratio nu; E' is the
contact modulus, 1/E' = (1 - nu_b^2)/E_b + (1 - nu_j^2)/E_j. (Many papers divide each term by pi, and then have
pi in the stiffness too: it cancels. The formula of Bai 2016, [0043]-[0046], is lost in the text that is known.)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping


def contact_modulus(young_b: float, poisson_b: float, young_j: float, poisson_j: float) -> float:
    """Contact modulus E' of bearing and journal [Pa]."""
    return 1.0 / ((1.0 - poisson_b**2) / young_b + (1.0 - poisson_j**2) / young_j)


def modulus_of(values: Mapping[str, float]) -> float:
    """Contact modulus E' of two bodies of one material, from the keys of an experiment's contact table [Pa]."""
    young, poisson = values["youngs_modulus"], values["poissons_ratio"]
    return contact_modulus(young, poisson, young, poisson)


def hertz_stiffness(radius_b: float, radius_j: float, modulus: float) -> float:
    """Stiffness K of F = K delta^1.5 for a sphere in a spherical cavity [N/m^1.5].

    K = 4/3 E' sqrt(R), 1/R = 1/R_j - 1/R_b: the cavity's curvature counts as negative, so that
    R = R_b R_j/(R_b - R_j). Hertz: F = 4/3 E' sqrt(R) delta^1.5. The sum of radii that some print belongs
    to two convex bodies; in a bearing it makes K several times too small.

    Raises
    ------
    ValueError
        If the journal is not smaller than the bearing.

    Source: Johnson, Contact Mechanics, 1985, eq. (4.23); Bai 2016 [0043] uses it; the formula is missing in the known
    text.
    """
    _check_radii(radius_b, radius_j)
    return 4.0 / 3.0 * modulus * math.sqrt(radius_b * radius_j / (radius_b - radius_j))


def line_stiffness(length: float, modulus: float) -> float:
    """Line stiffness S = pi E' L of conformal cylinders in contact over the length L [N/m]."""
    return math.pi * modulus * length


def cylinder_stiffness(length: float, modulus: float) -> float:
    """Stiffness K = pi/4 E' L of F = K delta for parallel cylinders in contact over the length L [N/m].

    It is Hertz's force for a contact of half-width a = sqrt(R delta), 1/R the difference of the curvatures, and does
    not depend on the radii. The true approach grows slightly slower than the force, by a logarithm that depends on the
    size of the bodies.

    Source: Popov, Contact Mechanics and Friction, 2010, eq. (5.33).
    """
    return math.pi / 4.0 * modulus * length


def line_shape(radius_b: float, radius_j: float, length: float) -> float:
    """Shape ratio L^2/(R_b R_j) of Dubowsky-Freudenstein's law [-].

    Raises
    ------
    ValueError
        If the journal is not smaller than the bearing.
    """
    _check_radii(radius_b, radius_j)
    return length * length / (radius_b * radius_j)


def _check_radii(radius_b: float, radius_j: float) -> None:
    if not 0.0 < radius_j < radius_b:
        raise ValueError(f"journal radius {radius_j!r} m: must be positive and below the bearing's {radius_b!r} m")


def effective_restitution(chi: float) -> float:
    """Restitution e' that F_e(delta)*(1 + chi*ddelta/ddelta0) gives in a free impact.

    Solves chi - ln(1 + chi) = -chi*e' - ln(1 - chi*e'), see the head of `linkages.laws.contact`.
    """
    if chi < 1e-9:
        return 1.0
    loss = chi - math.log1p(chi)
    return bisect(lambda e: -chi * e - math.log1p(-chi * e) - loss, 0.0, min(1.0, (1.0 - 1e-15) / chi))


def kelvin_voigt_damping(stiffness: float, mass: float, restitution: float) -> float:
    """Damping D with which K*delta + D*ddelta >= 0 gives a mass this restitution in a free impact [N s/m].

    With z = D/(2 sqrt(K m)) the contact ends when the force vanishes, and
    e = exp(-z/sqrt(1 - z^2)*atan2(2 z sqrt(1 - z^2), 2 z^2 - 1)). The largest z is 1, where e = exp(-2).

    Raises
    ------
    ValueError
        If the restitution is not in [exp(-2), 1].

    Source: Schwager and Poeschel, Granular Matter 9, 2007, eq. (20).
    """
    if not math.exp(-2.0) <= restitution <= 1.0:
        raise ValueError(f"restitution {restitution!r}: Kelvin-Voigt reaches 0.1354 to 1")

    def excess(z: float) -> float:
        root = math.sqrt(1.0 - z * z)
        return math.exp(-z / root * math.atan2(2.0 * z * root, 2.0 * z * z - 1.0)) - restitution

    return 2.0 * math.sqrt(stiffness * mass) * bisect(excess, 0.0, 1.0 - 1e-12)


def bisect(function: Callable[[float], float], low: float, high: float, halvings: int = 200) -> float:
    """Root of a monotonic function in [low, high]; the nearer end if it does not change sign."""
    rising = function(high) > function(low)
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        if (function(middle) > 0.0) == rising:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)
