"""Journal kinematics and the force pair between journal and bearing."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from linkages.laws.film import EPS_MAX, film_force
from linkages.laws.parameters import SHEAR

_NO_SHEAR = SHEAR["none"]
_FULL_SHEAR = SHEAR["full"]


@njit(cache=True)
def clearance_force(
    joint: np.record, ex: float, ey: float, vx: float, vy: float, omega_b: float, omega_j: float
) -> tuple[float, float, float]:
    """Force and couple on the journal.

    Parameters
    ----------
    joint : record of `PARAMETERS`
    ex, ey : float
        Eccentricity vector e, from the bearing's centre to the journal's [m].
    vx, vy : float
        Velocity of the journal's centre relative to the bearing's centre, seen from the inertial frame [m/s].
    omega_b, omega_j : float
        Inertial angular velocities of bearing and journal [rad/s].

    Returns
    -------
    fx, fy : float
        Force on the journal, through the journal's centre [N].
    couple : float
        Couple on the journal [N m]. The bearing gets -(fx, fy) **at the journal's centre** and -couple, so
        that the pair has neither net force nor net moment.

    Notes
    -----
    With U = omega_j + omega_b the power that the pair delivers is F.(v - U/2 z x e) - T_s*(omega_j - omega_b):
    both terms are <= 0, with T_s = mu R^3 L/c * (omega_j - omega_b) * integral dtheta/(1 + eps cos(theta)) the
    Sommerfeld-Petroff shear torque. The couple on the journal is -T_s - (e x F)/2; its second part is the shear
    by the pressure gradient, integral of h/2 dp/dtheta. Without shear torque (seed 000 neglects it) both are left out.
    """
    c = joint.clearance
    e = math.hypot(ex, ey)
    if e > 0.0:
        nx, ny = ex / e, ey / e
    else:  # the force is isotropic at the centre: any direction serves
        nx, ny = 1.0, 0.0
    eps = e / c
    deps = (vx * nx + vy * ny) / c
    ew = eps * (omega_j + omega_b) - 2.0 * (vy * nx - vx * ny) / c
    f_n, f_t, half_extent = film_force(joint.film, eps, deps, ew, 0.5 * joint.length / joint.radius)
    scale = joint.viscosity * joint.length * joint.radius**3 / (c * c)
    if eps < joint.small_eps:  # seed 000 eqs. (12)-(13)
        scale *= eps**joint.small_power
    fx = scale * (f_n * nx - f_t * ny)
    fy = scale * (f_n * ny + f_t * nx)
    couple = 0.0
    if joint.shear != _NO_SHEAR:
        extent = half_extent
        if joint.shear == _FULL_SHEAR:
            eps = min(eps, EPS_MAX)
            extent = 2.0 * math.pi / math.sqrt(1.0 - eps * eps)
        petroff = joint.viscosity * joint.length * joint.radius**3 / c * extent * (omega_j - omega_b)
        couple = -petroff - 0.5 * (ex * fy - ey * fx)
    return fx, fy, couple
