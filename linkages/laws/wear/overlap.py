"""Overlap of a journal and its bearing, one or both of them worn, along the bearing's radius.

On the ray at the angle theta (plane axes) from the bearing's centre, with u the ray's direction, t = z x u, e_n = e.u
and e_t = e.t, a journal of radius R_j ends at e_n + sqrt(R_j^2 - e_t^2), at the angle theta - e_t/R_j about its own
centre (to third order), so that

    delta = e_n - c - (R_j - sqrt(R_j^2 - e_t^2)) - w_b(theta - psi_b) - w_j(theta - e_t/R_j - psi_j).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel
from linkages.laws.wear.profile import add_spread, cell_of, depth_at, depth_in

_X, _W = np.polynomial.legendre.leggauss(3)
_X_ROUND, _W_ROUND = np.polynomial.legendre.leggauss(7)
_ROUNDS = 30


class Place(NamedTuple):
    """Position of a journal in its bearing, with both profiles."""

    ex: float  # eccentricity vector, plane axes [m]
    ey: float
    bearing_angle: float  # of the two parts' frames [rad]
    journal_angle: float
    clearance: float  # before wear [m]
    journal_radius: float  # before wear [m]
    bearing: Array  # control depths of the bearing's profile [m], (n,); none if it is round
    journal: Array  # of the journal's


class Overlap(NamedTuple):
    """Integrals over the arc of contact, and the deepest point.

    Moments are taken with the gradient g of delta by the eccentricity vector.
    """

    energy: float  # U = 1/2 integral of delta_+^2 dtheta [m2]
    ix: float  # its gradient, integral of delta_+ g dtheta [m]
    iy: float
    turn: float  # its derivative by the journal's angle [m2]
    hxx: float  # its second derivatives, integral of g g^T where delta > 0 [1]
    hxy: float
    hyy: float
    peak: float  # largest delta on any ray [m]
    peak_x: float  # g there [1]
    peak_y: float
    peak_turn: float  # derivative of delta by the journal's angle there [m]


@inlined_kernel
def _on_ray(
    ex: float,
    ey: float,
    clearance: float,
    radius: float,
    journal: Array,
    journal_angle: float,
    ux: float,
    uy: float,
    theta: float,
    wb: float,
    sb: float,
) -> tuple[float, float, float, float, float]:
    """Compute `delta_at` from a place, the ray's direction, the bearing's depth and its derivative."""
    en, et = ex * ux + ey * uy, ey * ux - ex * uy
    root = math.sqrt(radius * radius - et * et)
    delta, slope, across, sj = en - clearance - et * et / (radius + root) - wb, et - sb, -et / root, 0.0
    slope -= en * across
    if len(journal):
        wj, sj = depth_at(journal, theta - et / radius - journal_angle)
        delta -= wj
        slope -= sj * (1.0 + en / radius)
        across += sj / radius
    return delta, slope, ux - across * uy, uy + across * ux, sj


@kernel
def delta_at(place: Place, theta: float) -> tuple[float, float, float, float, float]:
    """Overlap on a ray [m], its derivative along theta, its gradient by e, its derivative by the journal's angle."""
    ex, ey, bearing_angle, journal_angle, clearance, radius, bearing, journal = place
    wb, sb = depth_at(bearing, theta - bearing_angle)
    ux, uy = math.cos(theta), math.sin(theta)
    return _on_ray(ex, ey, clearance, radius, journal, journal_angle, ux, uy, theta, wb, sb)


@kernel
def overlap(place: Place, spread_b: Array, spread_j: Array) -> Overlap:
    """Integrate over the arcs where journal and bearing overlap.

    Parameters
    ----------
    place : Place
    spread_b, spread_j : (n,) or empty arrays
        To the nodes of bearing and journal the integrals of delta_+ times their B-splines are added [m].
    """
    ex, ey, bearing_angle, journal_angle, clearance, radius, bearing, journal = place
    n = max(len(bearing), len(journal))
    h = 2.0 * math.pi / n
    e, toward = math.hypot(ex, ey), math.atan2(ey, ex)
    first = delta_at(place, toward)
    peak, px, py, pj = first[0], first[2], first[3], first[4]
    # delta < e cos(theta - toward) - c: rays without contact that cannot be the deepest are skipped
    level = min(peak, 0.0) + clearance
    half = math.pi
    if e > abs(level):
        half = math.acos(level / e)
    elif level > 0.0:
        half = 0.0
    cell = math.floor((toward - half - bearing_angle) / h)
    cells = min(int(math.ceil((toward + half - bearing_angle) / h) - cell), n)
    left = bearing_angle + cell * h
    i, _ = cell_of(n, (cell + 0.5) * h)
    turn_x, turn_y = math.cos(h), math.sin(h)
    ux, uy = math.cos(left), math.sin(left)
    wb, sb = depth_in(bearing, i, 0.0)
    d0, s0, _, _, _ = _on_ray(ex, ey, clearance, radius, journal, journal_angle, ux, uy, left, wb, sb)
    none = 0.0 * e  # of the kind of the eccentricity, a float or a dual
    energy, ix, iy, turn, hxx, hxy, hyy = none, none, none, none, none, none, none
    for _ in range(cells):
        vx, vy = ux * turn_x - uy * turn_y, uy * turn_x + ux * turn_y
        wb, sb = depth_in(bearing, i, 1.0)
        d1, s1, _, _, _ = _on_ray(ex, ey, clearance, radius, journal, journal_angle, vx, vy, left + h, wb, sb)
        a, b = 0.0, 1.0
        inside = d0 > 0.0 or d1 > 0.0
        if s0 >= 0.0 >= s1:  # a top within the cell
            x = _top(d0, h * s0, d1, h * s1)
            model = _cubic(x, d0, h * s0, d1, h * s1)
            if not inside or model > peak:
                top, slope, gx, gy, gj = delta_at(place, left + x * h)
                curvature = _curvature(x, d0, h * s0, d1, h * s1)
                if curvature < 0.0:
                    top -= 0.5 * (h * slope) ** 2 / curvature
                if top > peak:
                    peak, px, py, pj = top, gx, gy, gj
                if not inside and top > 0.0:
                    inside, shift = True, top - model
                    a = _zero(0.0, x, d0 + shift, h * s0, d1 + shift, h * s1)
                    b = _zero(1.0, x, d0 + shift, h * s0, d1 + shift, h * s1)
        if d0 > 0.0 >= d1:
            b = _zero(1.0, 0.0, d0, h * s0, d1, h * s1)
        elif d1 > 0.0 >= d0:
            a = _zero(0.0, 1.0, d0, h * s0, d1, h * s1)
        if inside:
            for k in range(len(_X)):
                x = 0.5 * (a + b) + 0.5 * (b - a) * _X[k]
                weight = 0.5 * h * (b - a) * _W[k]
                cx, cy, theta = math.cos(x * h), math.sin(x * h), left + x * h
                wb, sb = depth_in(bearing, i, x)
                rx, ry = ux * cx - uy * cy, uy * cx + ux * cy
                delta, _, gx, gy, gj = _on_ray(ex, ey, clearance, radius, journal, journal_angle, rx, ry, theta, wb, sb)
                if delta <= 0.0:
                    continue
                part = weight * delta
                energy += 0.5 * part * delta
                ix += part * gx
                iy += part * gy
                turn += part * gj
                hxx += weight * gx * gx
                hxy += weight * gx * gy
                hyy += weight * gy * gy
                if len(spread_b):
                    add_spread(spread_b, i, x, part)
                if len(spread_j):
                    across = (ey * rx - ex * ry) / radius
                    j, y = cell_of(len(spread_j), theta - across - journal_angle)
                    add_spread(spread_j, j, y, part)
        d0, s0, ux, uy, left = d1, s1, vx, vy, left + h
        i = i + 1 if i + 1 < n else 0
    return Overlap(energy, ix, iy, turn, hxx, hxy, hyy, peak, px, py, pj)


@inlined_kernel
def _cubic(x: float, a: float, da: float, b: float, db: float) -> float:
    """Evaluate Hermite's cubic on [0, 1]."""
    c2 = 3.0 * (b - a) - 2.0 * da - db
    c3 = 2.0 * (a - b) + da + db
    return a + x * (da + x * (c2 + x * c3))


@inlined_kernel
def _curvature(x: float, a: float, da: float, b: float, db: float) -> float:
    """Second derivative of Hermite's cubic."""
    return 2.0 * (3.0 * (b - a) - 2.0 * da - db) + 6.0 * x * (2.0 * (a - b) + da + db)


@inlined_kernel
def _top(a: float, da: float, b: float, db: float) -> float:
    """Where Hermite's cubic on [0, 1] that rises at 0 and falls at 1 has its top."""
    c2 = 3.0 * (b - a) - 2.0 * da - db
    c3 = 2.0 * (a - b) + da + db
    below = math.sqrt(max(c2 * c2 - 3.0 * c3 * da, 0.0)) - c2
    return min(da / below, 1.0) if below > 0.0 else 0.0


@kernel
def _zero(below: float, above: float, a: float, da: float, b: float, db: float) -> float:
    """Zero of Hermite's cubic between where it is not positive and where it is: Newton's method, or halves."""
    c2 = 3.0 * (b - a) - 2.0 * da - db
    c3 = 2.0 * (a - b) + da + db
    x = 0.5 * (below + above)
    for _ in range(_ROUNDS):
        value, slope = a + x * (da + x * (c2 + x * c3)), da + x * (2.0 * c2 + 3.0 * x * c3)
        if value > 0.0:
            above = x
        else:
            below = x
        step = -value / slope if slope != 0.0 else math.inf
        new = x + step
        if not min(below, above) <= new <= max(below, above):
            new = 0.5 * (below + above)
        if abs(new - x) < 1e-12:
            break
        x = new
    return x


@kernel
def round_overlap(depth: float, clearance: float, journal_radius: float) -> tuple[float, float]:
    """U_0 [m2] and its derivative U_0' [m] of a round journal in a round bearing at a penetration [m]."""
    e, bearing = clearance + depth, clearance + journal_radius
    # sin^2(alpha/2), free of cancellation: the arc ends where delta = 0
    part = depth * (2.0 * journal_radius - depth) / (4.0 * e * bearing)
    arc = 2.0 * math.asin(math.sqrt(min(max(part, 0.0), 1.0)))
    energy, slope = 0.0, 0.0
    for i in range(len(_X_ROUND)):
        phi = 0.5 * arc * (1.0 + _X_ROUND[i])
        half = math.sin(0.5 * phi)
        sine = 2.0 * half * math.sqrt(1.0 - half * half)
        et = e * sine
        root = math.sqrt(journal_radius * journal_radius - et * et)
        delta = depth - 2.0 * e * half * half - et * et / (journal_radius + root)
        energy += _W_ROUND[i] * delta * delta
        slope += 2.0 * _W_ROUND[i] * delta * (1.0 - 2.0 * half * half - et * sine / root)
    return 0.5 * arc * energy, 0.5 * arc * slope


@kernel
def round_depth(energy: float, clearance: float, journal_radius: float) -> tuple[float, float]:
    """Penetration d [m] at which the round joint has U_0(d) = `energy` > 0, and U_0'(d) [m].

    Newton's method for the logarithms, from U_0 = 8/15 sqrt(2/kappa) d^2.5 of a shallow contact.
    """
    kappa = clearance * (1.0 + clearance / journal_radius)
    depth, slope = (energy * math.sqrt(0.5 * kappa) * 15.0 / 8.0) ** 0.4, 0.0
    for _ in range(_ROUNDS):
        found, slope = round_overlap(depth, clearance, journal_radius)
        step = math.log(energy / found) * found / (slope * depth)
        depth *= math.exp(step)
        if abs(step) < 1e-8:  # U_0' ~ d^1.5 over so short a way
            return depth, slope * math.exp(1.5 * step)
    return depth, slope
