"""Films in closed form: exact half film, Pinkus-Sternlicht, short bearing; signature: see `linkages.laws.film`."""

from __future__ import annotations

import math

from linkages.base.kernel import inlined_kernel, kernel

#: Films are evaluated at min(eps, EPS_MAX): beyond it they cancel to round-off and lose their sign.
EPS_MAX = 1.0 - 1e-6

#: A film thinner than this fraction of the clearance has broken down: real surfaces touch long before.
THINNEST = 1e-4


@inlined_kernel
def _extent(eps: float, deps: float, ew: float) -> tuple[float, float, float]:
    """Return the long film's angle of pressure [rad], with ew/(2 + eps^2) and the speed that belong to it."""
    a = ew / (2.0 + eps * eps)
    speed = math.sqrt(a * a + deps * deps)
    root_q = math.sqrt(1.0 - eps * eps)
    return 2.0 * math.atan2(root_q * speed, -eps * deps) if speed > 0.0 else math.pi, a, speed


@kernel
def half_film_long(eps: float, deps: float, ew: float, slenderness: float) -> tuple[float, float, float]:
    """Long bearing, exact closed form on the film of extent pi (Guembel's half film).

    The pressure is the long-bearing solution of Reynolds' equation on theta_1 <= theta <= theta_1 + pi,
    tan(theta_1) = deps*(2 + eps^2)/ew, where it vanishes at both ends; theta = 0 is the widest gap.
    It is the closed form that Pinkus and Sternlicht's expressions approximate.

    Source: derived from Reynolds' equation, Chen 2025 eq. (8); checked against quadrature in the tests.
    """
    q = 1.0 - eps * eps
    root_q = math.sqrt(q)
    extent, a, speed = _extent(eps, deps, ew)
    f_n = -6.0 * (2.0 * eps * root_q * speed + deps * extent) / (q * root_q)
    f_t = 6.0 * a * extent / root_q
    return f_n, f_t, extent / root_q


@inlined_kernel
def _fit(eps: float, deps: float, ew: float) -> tuple[float, float]:
    """Force of Pinkus and Sternlicht's fit."""
    q = 1.0 - eps * eps
    root_q = math.sqrt(q)
    speed = math.sqrt(0.25 * ew * ew + deps * deps)
    wedge = root_q * speed
    squeeze = eps * abs(deps)
    ratio = 1.0
    if wedge > 0.0:
        ratio = (wedge + 3.0 * squeeze if deps >= 0.0 else wedge) / (wedge + 1.5 * squeeze)
    shape = 2.0 + eps * eps
    f_n = -6.0 * (4.0 * eps * wedge / shape + math.pi * deps * ratio) / (q * root_q)
    f_t = 6.0 * math.pi * ew * ratio / (shape * root_q)
    return f_n, f_t


@kernel
def pinkus_sternlicht(eps: float, deps: float, ew: float, slenderness: float) -> tuple[float, float, float]:
    """Long bearing, Pinkus and Sternlicht's fit of the half film, with the sign of eq. (11) corrected.

    Source: Chen 2025 eqs. (9)-(11). Eq. (11) is printed with the wrong sign of F_LN for deps < 0; as
    printed the force jumps at deps = 0 and the film feeds energy in. With k*eps*|deps| written as
    `wedge` and eps*|deps| as `squeeze` both branches are one expression without a singularity at
    eps = 0 or deps = 0. Within 9 % of the exact half film's largest force at each eps, but many times
    too large where journal and wall separate at high eps.
    """
    f_n, f_t = _fit(eps, deps, ew)
    return f_n, f_t, _extent(eps, deps, ew)[0] / math.sqrt(1.0 - eps * eps)


@kernel
def pinkus_sternlicht_bare(eps: float, deps: float, ew: float, slenderness: float) -> tuple[float, float, float]:
    """Force of `pinkus_sternlicht` without the extent."""
    f_n, f_t = _fit(eps, deps, ew)
    return f_n, f_t, 0.0


@kernel
def short_bearing(eps: float, deps: float, ew: float, slenderness: float) -> tuple[float, float, float]:
    """Short bearing (Ocvirk), half film: the parabolic axial pressure wherever it is positive.

    Valid for L/D below about 1/4, usable to 1/2. Source: the Ocvirk pressure
    p = 6 mu/h^3 * dh/dt * (z^2 - L^2/4) integrated in closed form over its positive half.
    """
    q = 1.0 - eps * eps
    speed = math.sqrt(deps * deps + 0.25 * ew * ew)
    if speed == 0.0:
        return 0.0, 0.0, math.pi
    s = deps / speed
    k = 0.5 * ew / speed
    d = 1.0 - eps * eps * k * k
    extent = 2.0 * math.atan2(math.sqrt(q), -eps * s) / math.sqrt(q)
    g1 = -2.0 * eps * k**3 / (d * d)
    g2 = ((0.5 + eps * eps) * extent + eps * s * (3.0 + k * k * (2.0 - 5.0 * eps * eps)) / (d * d)) / (q * q)
    g3 = (0.5 * extent + eps * s * (1.0 - k * k * (2.0 - eps * eps)) / (d * d)) / q
    scale = 4.0 * slenderness * slenderness * speed
    return scale * (k * g1 - s * g2), scale * (k * g3 - s * g1), extent
