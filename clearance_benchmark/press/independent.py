"""The seven-bar press with films in two joints. Run as a script: prints the columns of `reference.csv`."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from bodies import Clearance, Machine, journal, over_time, steady, table

TIMES = np.linspace(0.0, 0.1, 201)
COLUMNS = {"t": "s", "slider7.x": "m", "slider7.vx": "m/s", "slider7.ax": "m/s2", **journal("A"), **journal("B")}
MASS, INERTIA = [0.107, 0.219, 0.374, 0.107, 0.354, 0.139], [1.179e-4, 7.736e-4, 3.595e-3, 1.179e-4, 3.056e-3, 6.083e-5]


def machine():
    """Crank 1, links 2 and 3, crank 4, link 6, slider 7: bodies 0 to 5; 30 and 60 r/min."""
    crank4 = math.radians(310.79)
    along = lambda r: (r * math.cos(crank4), 0.301 + r * math.sin(crank4))  # noqa: E731
    (x, y), tip = along(0.08), (0.26, 0.0)
    link3 = math.atan2(tip[1] - y, tip[0] - x)
    guess = [
        (0.04, 0.0, 0.0), (0.17, 0.0, 0.0), (x + 0.159 * math.cos(link3), y + 0.159 * math.sin(link3), link3),
        (*along(0.04), crank4), (0.41, 0.0, 0.0), (0.56, 0.0, 0.0),
    ]  # fmt: skip
    ground = [(-1, (0.0, 0.0), 0, (-0.04, 0.0)), (-1, (0.0, 0.301), 3, (-0.04, 0.0))]
    pins = [(1, (0.09, 0.0), 4, (-0.15, 0.0)), (2, (0.159, 0.0), 4, (-0.15, 0.0)), (4, (0.15, 0.0), 5, (0.0, 0.0))]
    films = [(0, (0.04, 0.0), 1, (-0.09, 0.0)), (3, (0.04, 0.0), 2, (-0.159, 0.0))]
    joints = [Clearance(*film, 0.3e-3, 0.015, 0.04, viscosity=0.4) for film in films]
    driven = {0: steady(math.pi), 3: steady(-2.0 * math.pi, crank4)}
    return Machine(MASS, INERTIA, guess, ground + pins, [5], driven, clearances=joints, gravity=9.81)


def solution(times=TIMES):
    """Return the columns at times."""
    return over_time(machine(), times, state=(15, 33), rates=(33,))


if __name__ == "__main__":
    table(solution(), COLUMNS)
