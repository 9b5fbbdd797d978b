"""Journal kinematics and the force pair between journal and bearing: film, contact, or both."""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel
from linkages.laws.contact.contact_laws import normal_force
from linkages.laws.film.closed_form import EPS_MAX
from linkages.laws.film.films import MAPPED, film_force
from linkages.laws.film.map_table import is_grooved, mapped_flow, static_film
from linkages.laws.film.tilted_film import tilted_action
from linkages.laws.friction import friction_action
from linkages.laws.journal_motion import polar, sliding_speed
from linkages.laws.mixed import asperity_force, joined
from linkages.laws.parameters import MODELS, SHEAR
from linkages.laws.states import NO_RATES, Remembered

_NO_SHEAR = SHEAR["none"]
_FULL_SHEAR = SHEAR["full"]
_LUBRICATED = MODELS["lubricated"]
_DRY = MODELS["dry"]

#: Results of a contact, see `clearance_force`.
ContactResults = tuple[float, float, float, float, float, float, float, float, float, float]


@inlined_kernel
def clearance_force(
    joint: np.record,
    table: Array,
    ex: float,
    ey: float,
    vx: float,
    vy: float,
    omega_b: float,
    omega_j: float,
    remembered: Remembered,
    angle: float = 0.0,
) -> ContactResults:
    """Force and couple on the journal, and how it moves against the wall.

    Parameters
    ----------
    joint : record of `PARAMETERS`
    table : array of float
        Map of a finite film; others ignore it.
    ex, ey : float
        Eccentricity vector e, from the bearing's centre to the journal's [m].
    vx, vy : float
        Velocity of the journal's centre relative to the bearing's centre, seen from the inertial frame [m/s].
    omega_b, omega_j : float
        Inertial angular velocities of bearing and journal [rad/s].
    remembered : tuple of float
        What the contact remembers, see `linkages.laws.states`.
    angle : float
        Of the bearing's body, for a film with a groove or a tilt [rad].

    Returns
    -------
    fx, fy : float
        Force on the journal, through the journal's centre [N].
    couple : float
        Couple on the journal [N m]. The bearing gets -(fx, fy) **at the journal's centre** and -couple, so
        that the pair has neither net force nor net moment.
    rates : three floats
        Rates of the states of the contact; 0 where there are none.
    delta, closing : float
        Penetration e - c [m] and its rate [m/s].
    sliding : float
        Sliding speed of the journal's surface [m/s].
    load : float
        Normal load of the contact, asperities included [N].
    """
    c = joint.clearance
    e, nx, ny, v_n, v_t = polar(ex, ey, vx, vy)
    delta, radius = e - c, joint.radius - c  # radius of the journal
    sliding = sliding_speed(joint, e, v_t, omega_b, omega_j)
    f_n, f_t, couple, load = 0.0, 0.0, 0.0, 0.0
    first, second, third = NO_RATES
    if joint.tilt != 0.0:  # lubricated
        f_n, f_t, couple, _, _, _ = tilted_action(joint, e, v_n, v_t, omega_b, omega_j, math.atan2(ny, nx) - angle)
    elif joint.model != _DRY:
        alpha = math.atan2(ny, nx) - angle - joint.groove_angle if joint.film == MAPPED and is_grooved(table) else 0.0
        f_n, f_t, couple = film_action(joint, table, c, e, v_n, v_t, omega_b, omega_j, alpha)
    if joint.model != _LUBRICATED:
        extra = 0.0
        if joint.model != _DRY and joint.transition == 0.0:
            extra = asperity_force(e / c, c, joint.radius, joint.length, joint.roughness, joint.asperity_pressure)
        load, drag, first, second, third = dry_force(joint, delta, v_n, sliding, remembered, extra)
        f_n, f_t, couple, load = joined(joint, (f_n, f_t, couple), (-load, -drag, -radius * drag), delta, load)
    fx, fy = f_n * nx - f_t * ny, f_n * ny + f_t * nx
    return fx, fy, couple, first, second, third, delta, v_n, sliding, load


@kernel
def end_flow(
    joint: np.record,
    table: Array,
    ex: float,
    ey: float,
    vx: float,
    vy: float,
    omega_b: float,
    omega_j: float,
    angle: float = 0.0,
) -> float:
    """Compute the volume flow out of both ends of a finite film [m3/s]; wear is neglected.

    Parameters
    ----------
    joint, table, ex, ey, vx, vy, omega_b, omega_j, angle
        As for `clearance_force`.
    """
    c = joint.clearance
    e, nx, ny, v_n, v_t = polar(ex, ey, vx, vy)
    if joint.tilt != 0.0:
        return tilted_action(joint, e, v_n, v_t, omega_b, omega_j, math.atan2(ny, nx) - angle)[5]
    eps, alpha = min(e / c, EPS_MAX), math.atan2(ny, nx) - angle - joint.groove_angle
    if joint.model != _LUBRICATED:
        eps = min(eps, joint.film_limit)
    flow = mapped_flow(eps, v_n / c, e / c * (omega_j + omega_b) - 2.0 * v_t / c, alpha, table)
    _, _, static = static_film(eps, alpha, table)
    return c * joint.radius**2 * flow + joint.supply_pressure * c**3 / joint.viscosity * static


@kernel
def dry_force(
    joint: np.record,
    delta: float,
    closing: float,
    sliding: float,
    remembered: Remembered,
    extra: float = 0.0,
    gain: float = 1.0,
) -> tuple[float, float, float, float, float]:
    """Load, friction and rates of the states of one dry contact.

    Parameters
    ----------
    joint : record of `PARAMETERS`
    delta, closing : float
        Penetration [m] and its rate [m/s].
    sliding : float
        Sliding speed [m/s].
    remembered
        As for `clearance_force`.
    extra : float
        Load carried otherwise, by asperities, which friction acts on as well [N].
    gain : float
        Factor of the contact law's force.

    Returns
    -------
    load : float
        Normal force that pushes the bodies apart, never negative [N].
    drag : float
        Friction force against positive sliding [N].
    rates : three floats
        Rates of the states of the contact law and of the friction law.
    """
    force, a, b, c = normal_force(delta, closing, remembered, joint)
    load = extra + gain * force
    # without a load nothing drags the states of friction along
    mu, d, e, f = friction_action(sliding if load > 0.0 else 0.0, remembered, joint)
    return load, mu * load, a + d, b + e, c + f


@inlined_kernel
def film_action(
    joint: np.record,
    table: Array,
    c: float,
    e: float,
    v_n: float,
    v_t: float,
    omega_b: float,
    omega_j: float,
    alpha: float = 0.0,
) -> tuple[float, float, float]:
    """Force (normal, tangential) and couple on the journal of the film in a clearance c.

    With U = omega_j + omega_b the power that the pair delivers is F.(v - U/2 z x e) - T_s*(omega_j - omega_b):
    both terms are <= 0, with T_s = mu R^3 L/c * (omega_j - omega_b) * integral dtheta/(1 + eps cos(theta)) the
    Sommerfeld-Petroff shear torque. The couple on the journal is -T_s - (e x F)/2; its second part is the shear
    by the pressure gradient, integral of h/2 dp/dtheta. Without shear torque (Chen 2025 neglects it) both are left
    out. Next to a contact the film sees eps <= film_limit, so that it stays a film.
    """
    eps = e / c
    seen = eps
    if joint.model != _LUBRICATED:
        seen = min(eps, joint.film_limit)
    deps = v_n / c
    ew = eps * (omega_j + omega_b) - 2.0 * v_t / c
    f_n, f_t, half_extent = film_force(joint, seen, deps, ew, 0.5 * joint.length / joint.radius, table, alpha)
    scale = joint.viscosity * joint.length * joint.radius**3 / (c * c)
    if eps < joint.small_eps:  # Chen 2025 eqs. (12)-(13)
        scale *= eps**joint.small_power
    f_n, f_t = scale * f_n, scale * f_t
    if joint.supply_pressure != 0.0:
        s_n, s_t, _ = static_film(seen, alpha, table)
        pressed = joint.supply_pressure * joint.radius * joint.length
        f_n, f_t = f_n + pressed * s_n, f_t + pressed * s_t
    couple = 0.0
    if joint.shear != _NO_SHEAR:
        extent = half_extent
        grooved = joint.film == MAPPED and is_grooved(table)  # its extent is weighted by the film content
        if joint.shear == _FULL_SHEAR and not grooved:
            seen = min(seen, EPS_MAX)
            extent = 2.0 * math.pi / math.sqrt(1.0 - seen * seen)
        petroff = joint.viscosity * joint.length * joint.radius**3 / c * extent * (omega_j - omega_b)
        couple = -petroff - 0.5 * e * f_t
    return f_n, f_t, couple
