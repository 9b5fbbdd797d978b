"""Equilibrium of a loaded journal, its eight dynamic coefficients, and the stability of a rigid journal.

The load acts along x; y is at a right angle to it, in the sense of rotation. A film is a function of the place
(x, y) and velocity of the journal, in units of the clearance c and of c*omega.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array

#: Force on the journal at (x, y) with the velocity (vx, vy).
FilmForce = Callable[[float, float, float, float], tuple[float, float]]

_NEAR = 1e-8  # of the load: accuracy of the equilibrium
_STEPS = 60
_DIFFERENCE = 2e-3  # of the film's least thickness: step of differences; smaller ones see the cells of the mesh
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
    """Find the place where the film carries the load along x.

    Parameters
    ----------
    force : callable
        Of the film, in any unit.
    load : float
        In the same unit, positive.
    least : callable
        Least thickness of the film at a place; positive without contact.
    start : (float, float), optional
        A place near by.

    Raises
    ------
    ArithmeticError
        If no equilibrium is found.
    """
    places = [(eps * math.cos(angle), eps * math.sin(angle)) for eps, angle in _STARTS]
    for x, y in ([start] if start is not None else []) + places:
        if least(x, y) > 0.0:
            found = _newton(force, load, least, x, y)
            if found is not None:
                return found
    raise ArithmeticError("no equilibrium of load and film was found")


def _newton(
    force: FilmForce, load: float, least: Callable[[float, float], float], x: float, y: float
) -> tuple[float, float] | None:
    """Damped Newton's method on the relative residual."""

    def residual(x: float, y: float) -> Array:
        fx, fy = force(x, y, 0.0, 0.0)
        return np.array([fx / load + 1.0, fy / load])

    r = residual(x, y)
    for _ in range(_STEPS):
        if np.abs(r).max() < _NEAR:
            return x, y
        h = _DIFFERENCE * least(x, y)
        jacobian = np.column_stack([(residual(x + h, y) - r) / h, (residual(x, y + h) - r) / h])
        try:
            dx, dy = np.linalg.solve(jacobian, -r)
        except np.linalg.LinAlgError:
            return None
        part, room = 1.0, least(x, y)
        size = math.hypot(dx, dy)
        if not math.isfinite(size):
            return None
        part = min(1.0, 0.3 / size) if size > 0.3 else 1.0
        while least(x + part * dx, y + part * dy) < (1.0 - _SHARE) * room:
            part *= 0.5
        # a large residual is measured by its logarithm: film forces grow without bound towards the wall
        for _ in range(12):
            following = residual(x + part * dx, y + part * dy)
            if np.hypot(*following) < np.hypot(*r):
                break
            part *= 0.5
        else:
            return (x, y) if np.abs(r).max() < 1e3 * _NEAR else None
        x, y, r = x + part * dx, y + part * dy, following
    return None


def coefficients(force: FilmForce, x: float, y: float, least: float, part: float = _DIFFERENCE) -> Coefficients:
    """Differentiate a film's force at a place by central differences.

    Parameters
    ----------
    force : callable
    x, y : float
    least : float
        Least thickness of the film there.
    part : float
        Step of the differences over it; default: for films on a mesh.
    """
    h = part * least
    columns = []
    for step in np.eye(4) * h:
        ahead = np.array(force(x + step[0], y + step[1], step[2], step[3]))
        behind = np.array(force(x - step[0], y - step[1], -step[2], -step[3]))
        columns.append((behind - ahead) / (2.0 * h))
    table = np.transpose(columns)
    return Coefficients(table[:, :2], table[:, 2:])


def stability(stiffness: Array, damping: Array) -> Stability:
    """Find the mass at which a rigid journal begins to whirl.

    Parameters
    ----------
    stiffness, damping : (2, 2) arrays
        K c/W and B c omega/W.

    Notes
    -----
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
