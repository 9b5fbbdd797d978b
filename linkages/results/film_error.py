"""Error of a closed-form film in a run: its force and eccentricity against the film of finite length."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Array
from linkages.laws.film.films import film_force
from linkages.laws.film.map_nodes import finite_force

#: Largest eccentricity ratio of the comparison: the film of finite length is not solved beyond.
_LARGEST = 0.999
_NO_MAP = np.zeros(0)


class FilmError(NamedTuple):
    """Estimated error of a film of infinite or vanishing length in one run."""

    force: float  # force over the finite film's in the same motion, at the largest force
    eccentricity: float  # largest eccentricity ratio of the run
    finite: float  # eccentricity ratio at which a finite film carries the same force at the same speeds


def film_error(record: Any, slenderness: float, e: Array, force: Array) -> FilmError | None:
    """Estimate the effect of a film of finite length (Guembel's condition) on a run; None where no force acts.

    From the record of the joint, L/D, the eccentricities (n, 2) from the bearing's centre to the journal's [m], and the
    forces of the film on the journal (n, 2) [N]. The motion (deps, ew) follows, but for its scale, from the direction
    of the force: a film is homogeneous of degree one. The eccentricity is an estimate: it keeps the speeds deps and
    ew/eps of the moment, and so neglects that a film that carries less is squeezed for longer.
    """
    ratio = np.hypot(*e.T) / record.clearance
    size = np.hypot(*force.T)
    usable = (size > 0.0) & (ratio > 1e-3) & (ratio < _LARGEST)
    if not usable.any():
        return None
    strongest = int(np.argmax(np.where(usable, size, -1.0)))
    widest = int(np.argmax(np.where(usable, ratio, -1.0)))
    unit = float(record.viscosity * record.length * record.radius**3 / record.clearance**2)
    eps, deps, ew = _motion(record, slenderness, e[strongest], force[strongest] / unit)
    excess = float(size[strongest]) / unit / math.hypot(*finite_force(eps, slenderness, deps, 0.5 * ew))
    eps, deps, ew = _motion(record, slenderness, e[widest], force[widest] / unit)
    needed = float(size[widest]) / unit

    def lacks(other: float) -> bool:
        return math.hypot(*finite_force(other, slenderness, deps, 0.5 * ew * other / eps)) < needed

    low, high = 0.0, _LARGEST
    for _ in range(20):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if lacks(middle) else (low, middle)
    return FilmError(excess, eps, high)


def _motion(record: Any, slenderness: float, e: Array, force: Array) -> tuple[float, float, float]:
    """Find eps, deps and ew for which the film gives a dimensionless force."""
    eps = float(np.hypot(*e)) / record.clearance
    nx, ny = e / np.hypot(*e)
    aim = math.atan2(force[1] * nx - force[0] * ny, force[0] * nx + force[1] * ny)

    def acting(angle: float) -> tuple[float, float]:
        f_n, f_t, _ = film_force(record, eps, math.cos(angle), 2.0 * math.sin(angle), slenderness, _NO_MAP)
        return math.atan2(f_t, f_n), math.hypot(f_n, f_t)

    # rotation turns the force from -n (approach, angle 0) by way of t to n (separation, angle pi), and is odd in ew
    low, high = 0.0, math.pi
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if acting(middle)[0] > abs(aim) else (low, middle)
    angle = math.copysign(low, aim)
    speed = float(np.hypot(*force)) / acting(angle)[1]
    return eps, speed * math.cos(angle), 2.0 * speed * math.sin(angle)
