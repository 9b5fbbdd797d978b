"""Between film and contact: the blend of Chen 2025 eq. (15), and the asperities of Greenwood and Tripp.

*Blend.* Eq. (15) is F_L for |e| < c, F_L + (|e| - c)/E_0*(F_D - F_L) up to |e| = c + E_0, and F_D beyond. As
printed, F_L is evaluated where 1 - eps^2 <= 0. Here the film sees min(eps, eps_max), eps_max < 1, and
`mix` weighs the two forces by `dry_weight`. The joint force is then continuous, and passive because each
part is: the film's inequality f_n*deps - f_t*ew/2 <= 0 holds at any eps < 1 with the true deps and ew, and
the elastic part of the contact, weighed by a function of the penetration alone, still conserves energy.

*Asperities.* The physical alternative adds to the film the pressure of the rough surfaces' contact,

    p_a(h) = 16 sqrt(2) pi/15 * (n beta sigma)^2 * sqrt(sigma/beta) * E' * F_5/2(h/sigma),
    F_5/2(u) = integral over s > u of (s - u)^(5/2) * exp(-s^2/2)/sqrt(2 pi) ds,

integrated over the conformal gap h = c (1 - eps cos(phi)). It acts before |e| = c, without any E_0.

Source: Greenwood and Tripp, Proc. IMechE 185, 1970.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from linkages.base.kernel import inlined_kernel, kernel, lazy_kernel
from linkages.laws.contact.material import modulus_of

_LOW, _HIGH = -6.0, 10.0  # range of the fit of ln F_5/2
_PIECES, _DEGREE = 16, 10


def _fit() -> np.ndarray:
    """Coefficients of ln F_5/2 in each piece of [_LOW, _HIGH], powers of -1 to 1, the highest first.

    F_5/2 by quadrature with s = u + x^2, at Chebyshev's nodes of each piece.
    """
    x, weight = np.polynomial.legendre.leggauss(120)
    x, weight = 2.25 * (x + 1.0), 2.25 * weight
    nodes = np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
    u = _LOW + (_HIGH - _LOW) / _PIECES * (np.arange(_PIECES)[:, None] + 0.5 * (nodes + 1.0))
    power = x**2 * (2.0 * u[..., None] + x**2) / 2.0
    values = (2.0 * x**6 * np.exp(-power) / math.sqrt(2.0 * math.pi)) @ weight
    return np.linalg.solve(np.vander(nodes), (np.log(values) - 0.5 * u**2).T).T.copy()


_COEFFICIENTS = _fit()
_X, _WEIGHT = np.polynomial.legendre.leggauss(32)


def fill_mixed(record: Any, values: Mapping[str, Any], material: Mapping[str, Any]) -> None:
    """Write blend or asperities into a record, from the keys of the experiment's tables for mixed and contact."""
    record["film_limit"] = values["film_limit"]
    if values["law"] == "blend":
        record["transition"] = values["transition"]
        return
    sigma = math.hypot(values["roughness"], values["roughness"])  # of the two surfaces
    record["roughness"] = sigma
    record["asperity_pressure"] = asperity_pressure(
        sigma, values["density"], values["tip_radius"], modulus_of(material)
    )


@kernel
def dry_weight(delta: float, transition: float) -> float:
    """Weight of the dry contact: 0 without penetration, 1 from delta = E_0 = `transition` on [m]."""
    if delta <= 0.0:
        return 0.0
    return delta / transition if delta < transition else 1.0


@kernel
def mix(film: float, dry: float, delta: float, transition: float) -> float:
    """Blend a component of the film and contact forces: Chen 2025 eq. (15)."""
    return film + dry_weight(delta, transition) * (dry - film)


@inlined_kernel
def joined(
    joint: np.record, film: tuple[float, float, float], dry: tuple[float, float, float], delta: float, load: float
) -> tuple[float, float, float, float]:
    """Add force (2) and couple of film and contact, or blend them, at a penetration; and the load of the contact."""
    if joint.transition == 0.0:
        return film[0] + dry[0], film[1] + dry[1], film[2] + dry[2], load
    x, y, couple = (
        mix(film[0], dry[0], delta, joint.transition),
        mix(film[1], dry[1], delta, joint.transition),
        mix(film[2], dry[2], delta, joint.transition),
    )
    return x, y, couple, load * dry_weight(delta, joint.transition)


@kernel
def gauss_five_halves(u: float) -> float:
    """Evaluate F_5/2(u) of Greenwood and Tripp.

    A fit of ln F_5/2 in pieces of [-6, 10], relative error below 1e-11; the moments of the full normal
    distribution below -6 (relative error below 2e-6 there), zero above 10 (F_5/2 < 1e-25).
    """
    if u >= _HIGH:
        return 0.0
    if u < _LOW:
        r = 1.0 / (u * u)
        return (-u) ** 2.5 * (1.0 + r * (15.0 / 8.0 + r * (-15.0 / 128.0)))
    place = (u - _LOW) * (_PIECES / (_HIGH - _LOW))
    piece = min(int(place), _PIECES - 1)
    t, total = 2.0 * (place - piece) - 1.0, _COEFFICIENTS[piece, 0]
    for k in range(1, _DEGREE + 1):
        total = total * t + _COEFFICIENTS[piece, k]
    return math.exp(total)


def asperity_pressure(sigma: float, density: float, tip_radius: float, modulus: float) -> float:
    """Factor of F_5/2 in the asperities' pressure [Pa].

    Parameters
    ----------
    sigma : float
        Combined standard deviation of the surfaces' summits [m], sigma^2 = sigma_b^2 + sigma_j^2.
    density : float
        Summits per area n [1/m^2].
    tip_radius : float
        Radius beta of the summits [m].
    modulus : float
        Contact modulus E' [Pa], see `linkages.laws.contact.material.contact_modulus`.
    """
    number = density * tip_radius * sigma
    return 16.0 * math.sqrt(2.0) * math.pi / 15.0 * number**2 * math.sqrt(sigma / tip_radius) * modulus


@lazy_kernel
def asperity_force(
    eps: float, clearance: float, radius: float, length: float, roughness: float, pressure: float
) -> float:
    """Compute the normal force of the asperities, pushing the journal back to the centre [N].

    Parameters
    ----------
    eps : float
        Eccentricity ratio; beyond 1 the mean surfaces overlap and the law is a steep penalty only.
    clearance, radius, length : float
        c, R and L of the bearing [m].
    roughness : float
        Combined roughness sigma [m].
    pressure : float
        From `asperity_pressure` [Pa].

    Notes
    -----
    A function of eps alone, hence conservative; friction on it is the caller's. Gauss-Legendre quadrature
    with 32 points over the arc where h < 10 sigma; the pressure beyond is below 1e-24 of its scale.
    """
    reach = clearance - _HIGH * roughness
    if clearance * eps <= reach:
        return 0.0
    cosine = reach / (clearance * eps) if eps > 0.0 else -1.0
    arc = math.acos(min(max(cosine, -1.0), 1.0))
    total = 0.0
    for k in range(_X.size):
        phi = 0.5 * arc * (_X[k] + 1.0)
        gap = clearance * (1.0 - eps * math.cos(phi)) / roughness
        total += _WEIGHT[k] * gauss_five_halves(gap) * math.cos(phi)
    return max(pressure * radius * length * arc * total, 0.0)
