"""The press paper's film as it is printed, eqs. (4), (9)-(11), beside what is used: along a run of joint A.

A whole period of steady running, in which the journal turns and returns; whether an equation is right does not depend on the run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from linkages.laws.film.closed_form import pinkus_sternlicht
from replication import press_paper as paper
from replication.press_paper import Array

#: Periods after which the journals' paths repeat to a thousandth of the clearance.
PERIODS = 10


def printed(eps: float, rate: float, spin: float) -> tuple[float, float]:
    """Compute normal and tangential force of eqs. (9)-(11), signs and all, in units of mu R_b^3 L/r^2.

    Parameters
    ----------
    eps, rate : float
        Eccentricity ratio and the rate that stands for d(eps)/dt [1/s].
    spin : float
        omega - 2 dgamma/dt [rad/s].
    """
    q, s = 1.0 - eps**2, 2.0 + eps**2
    k = np.sqrt(q * ((spin / (2.0 * rate)) ** 2 + 1.0 / eps**2))  # (10)
    part = k + 3.0 if rate >= 0.0 else k  # (9), (11)
    sign = 1.0 if rate >= 0.0 else -1.0
    normal = -6.0 * (4.0 * k * eps**2 / s + sign * np.pi * part / (k + 1.5)) * rate / q**1.5
    return normal, 6.0 * part / (k + 1.5) * np.pi * eps * spin / (s * np.sqrt(q))


def jump() -> float:
    """Compare the normal force just below d(eps)/dt = 0 as printed with that just above."""
    return float(printed(0.5, -1e-9, 2.0)[0] / printed(0.5, 1e-9, 2.0)[0])


@dataclass(frozen=True)
class Orbit:
    """Joint A along the run: what the film's equations take; (nt,) arrays."""

    eps: Array
    rate: Array  # d(eps)/dt [1/s]
    speed: Array  # |de/dt| over the clearance, eq. (4) [1/s]
    turning: Array  # dgamma/dt [rad/s]
    total: Array  # sum of the angular velocities of journal and bearing [rad/s]
    relative: Array  # their difference [rad/s]


@cache
def orbit() -> Orbit:
    """Joint A of the nominal design over a period of steady running."""
    end = PERIODS * paper.PERIOD
    t = np.linspace(end - paper.PERIOD, end, 4001)
    c = paper.run({}, end).evaluate(t)
    ex, ey, journal, bearing = c["A.ex"], c["A.ey"], c["link2.omega"], c["crank1.omega"]
    vx, vy, size = np.gradient(ex, t), np.gradient(ey, t), np.hypot(c["A.ex"], c["A.ey"])
    r = paper.CLEARANCE
    rate, turning = (ex * vx + ey * vy) / size / r, (ex * vy - ey * vx) / size**2
    return Orbit(size / r, rate, np.hypot(vx, vy) / r, turning, journal + bearing, journal - bearing)


def never() -> float:
    """Part of the time in which the journal moves inwards, where eq. (11) should apply [%]."""
    return 100.0 * float(np.mean(orbit().rate < 0.0))


def farthest(speed: bool = False, relative: bool = False) -> tuple[float, float]:
    """One component of the film's force with a printed quantity, and the right one, where they differ most.

    In units of the largest right force.

    Parameters
    ----------
    speed : bool
        Take eq. (4) for d(eps)/dt.
    relative : bool
        Take the relative angular velocity for the sum.
    """
    o = orbit()

    def forces(rate: Array, omega: Array) -> Array:
        rows = zip(o.eps, rate, o.eps * (omega - 2.0 * o.turning), strict=True)
        return np.array([pinkus_sternlicht(*row, 1.0)[:2] for row in rows])

    right = forces(o.rate, o.total)
    wrong = forces(o.speed if speed else o.rate, o.relative if relative else o.total)
    at = np.unravel_index(np.abs(wrong - right).argmax(), right.shape)
    largest = np.linalg.norm(right, axis=1).max()
    return float(wrong[at] / largest), float(right[at] / largest)
