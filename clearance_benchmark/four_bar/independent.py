"""A drag-link double crank with films in both joints of its coupler. Run as a script: prints the columns of `reference.csv`."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from bodies import Clearance, Machine, journal, over_time, steady, table

TIMES = np.linspace(0.0, 0.1, 201)
COLUMNS = {
    "t": "s",
    "follower.angle": "rad",
    "follower.omega": "rad/s",
    "follower.alpha": "rad/s2",
    **journal("A"),
    **journal("B"),
}


def machine():
    """Crank, coupler, follower: bodies 0, 1, 2; 600 r/min."""
    up, coupler, follower = math.radians(90.0), math.radians(1.5808464), math.radians(68.6954659)
    centre = lambda x, y, r, a: (x + r * math.cos(a), y + r * math.sin(a), a)  # noqa: E731
    guess = [centre(0.0, 0.0, 0.1, up), centre(0.0, 0.2, 0.09, coupler), centre(0.1, 0.0, 0.11, follower)]
    pins = [(-1, (0.0, 0.0), 0, (-0.1, 0.0)), (-1, (0.1, 0.0), 2, (-0.11, 0.0))]
    films = [(0, (0.1, 0.0), 1, (-0.09, 0.0)), (1, (0.09, 0.0), 2, (0.11, 0.0))]
    joints = [Clearance(*film, 0.2e-3, 0.015, 0.03, viscosity=0.1) for film in films]
    mass, inertia = [0.314, 0.2826, 0.3454], [0.0010571, 0.00077244, 0.0014046]
    return Machine(mass, inertia, guess, pins, driven={0: steady(20.0 * math.pi, up)}, clearances=joints, gravity=9.81)


def solution(times=TIMES):
    """Return the columns at times."""
    return over_time(machine(), times, state=(8, 17), rates=(17,))


if __name__ == "__main__":
    table(solution(), COLUMNS)
