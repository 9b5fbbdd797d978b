"""Equilibrium of a loaded journal, its eight dynamic coefficients, and the stability of a rigid journal.

The load acts along x; y is at a right angle to it, in the sense of rotation. A film is a function of the place
(x, y) and velocity of the journal, in units of the clearance c and of c*omega.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array

#: Force on the journal at (x, y) with the velocity (vx, vy).
FilmForce = Callable[[float, float, float, float], tuple[float, float]]

_CLOSE = 1e-10  # step of Newton's method that ends it, in units of the clearance
_ITERATIONS = 60
_HALVINGS = 12  # of an iteration that does not reduce the residual
#: Step of differences of films on a mesh, over their least thickness: smaller ones see the cells.
DIFFERENCE = 2e-3
_FAR = 0.3  # longest step
_SHARE = 0.5  # of the film that a step may use up
#: Places from which the search starts: eccentricity ratio and attitude [rad].
_STARTS = ((0.5, 0.9), (0.8, 0.6), (0.2, 1.2), (0.95, 0.3), (0.05, 1.4))


class Coefficients(NamedTuple):
    """Linear film forces on the journal, F = F0 - K (dx, dy) - B (vx, vy).

    Attributes
    ----------
    stiffness, damping : (2, 2) arrays
        K and B; the first index is the force's.
    """

    stiffness: Array
    damping: Array


class Stability(NamedTuple):
    """Whirl of a rigid journal on a film, by Routh's criterion on the eight coefficients."""

    critical_mass: float  # in units of load/(c omega^2); infinite: stable for every mass
    whirl_ratio: float  # angular frequency at the threshold over omega; nan where there is none


def equilibrium(
    force: FilmForce, load: float, least: Callable[[float, float], float], start: tuple[float, float] | None = None
) -> tuple[float, float]:
    """Find the place where the film carries a load along x, both in any unit; ArithmeticError if there is none.

    `least` is the least thickness of the film at a place, positive without contact; `start` is a place near by.
    """

    def residual(x: float, y: float) -> Array:
        fx, fy = force(x, y, 0.0, 0.0)
        return np.array([fx / load + 1.0, fy / load])

    places = [(eps * math.cos(angle), eps * math.sin(angle)) for eps, angle in _STARTS]
    for place in ([start] if start is not None else []) + places:
        if least(*place) > 0.0:
            with suppress(ArithmeticError):
                (x, y), _ = balanced(residual, least, place)
                return float(x), float(y)
    raise ArithmeticError("no equilibrium of load and film was found")


def balanced(
    residual: Callable[[float, float], Array], least: Callable[[float, float], float], start: tuple[float, float],
    slope: Array | None = None,
) -> tuple[Array, Array]:  # fmt: skip
    """Find the place where a force vanishes, by Newton's method with Broyden's corrections of its Jacobian.

    Return the place (2,), at which the force was evaluated last, and the Jacobian (2, 2), a guess for a neighbouring
    problem; ArithmeticError if there is none.
    """
    place = np.array(start)
    left, fresh = residual(*place), False
    for _ in range(_ITERATIONS):
        room = least(*place)
        if slope is None:
            h, fresh = DIFFERENCE * room, True
            slope = np.column_stack([(residual(*(place + step)) - left) / h for step in h * np.eye(2)])
        change = np.linalg.lstsq(slope, -left, rcond=None)[0]
        size = np.hypot(*change)
        change *= min(1.0, _FAR / max(size, _CLOSE))
        while least(*(place + change)) < (1.0 - _SHARE) * room:
            change *= 0.5
        following = residual(*(place + change))
        if size < _CLOSE:
            return place + change, slope
        if np.hypot(*following) > np.hypot(*left) and not fresh:
            slope = None
            continue
        for _ in range(_HALVINGS):
            if np.hypot(*following) <= np.hypot(*left):
                break
            change *= 0.5
            following = residual(*(place + change))
        slope = slope + np.outer(following - left - slope @ change, change) / (change @ change)
        place, left, fresh = place + change, following, False
    raise ArithmeticError("Newton's method does not converge")


def coefficients(force: FilmForce, x: float, y: float, h: float) -> Coefficients:
    """Differentiate a film's force at a place by central differences over h."""
    columns = []
    for step in np.eye(4) * h:
        ahead = np.array(force(x + step[0], y + step[1], step[2], step[3]))
        behind = np.array(force(x - step[0], y - step[1], -step[2], -step[3]))
        columns.append((behind - ahead) / (2.0 * h))
    table = np.transpose(columns)
    return Coefficients(table[:, :2], table[:, 2:])


def stability(stiffness: Array, damping: Array) -> Stability:
    """Find the mass at which a rigid journal begins to whirl, from K c/W and B c omega/W.

    With the equivalent stiffness k = (Kxx Byy + Kyy Bxx - Kxy Byx - Kyx Bxy)/(Bxx + Byy), the square of the whirl
    ratio is ((k - Kxx)(k - Kyy) - Kxy Kyx)/(Bxx Byy - Bxy Byx) and the critical mass k over it (Lund 1965).
    """
    (kxx, kxy), (kyx, kyy) = stiffness
    (bxx, bxy), (byx, byy) = damping
    k = (kxx * byy + kyy * bxx - kxy * byx - kyx * bxy) / (bxx + byy)
    square = ((k - kxx) * (k - kyy) - kxy * kyx) / (bxx * byy - bxy * byx)
    if k <= 0.0:  # statically unstable
        return Stability(0.0, math.nan)
    if square <= 0.0:
        return Stability(math.inf, math.nan)
    return Stability(float(k / square), math.sqrt(square))
