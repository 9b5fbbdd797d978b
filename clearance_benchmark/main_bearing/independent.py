"""A slider-crank with a film in the bearing of its crank, which a torque drives. Run as a script: prints the columns of `reference.csv`."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from bodies import Clearance, Machine, journal, over_time, table

TIMES = np.linspace(0.0, 0.08, 161)
COLUMNS = {"t": "s", "crank.angle": "rad", "crank.omega": "rad/s", "slider.x": "m", "slider.ax": "m/s2", **journal("O")}


def machine():
    """Crank 50 mm, rod 120 mm, slider: bodies 0, 1, 2; the journal is the crank's."""
    guess = [(0.0, 0.0, 0.0), (0.11, 0.0, 0.0), (0.17, 0.0, 0.0)]
    pins = [(0, (0.05, 0.0), 1, (-0.06, 0.0)), (2, (0.0, 0.0), 1, (0.06, 0.0))]
    film = Clearance(-1, (0.0, 0.0), 0, (0.0, 0.0), 0.1e-3, 0.015, 0.02, viscosity=0.05)
    crank = {"spin": {0: 150.0}, "torque": {0: lambda rate: 2.0}}
    return Machine([0.30, 0.21, 0.14], [1e-5, 2.5e-4, 1e-4], guess, pins, [2], **crank, clearances=[film], gravity=9.81)


def solution(times=TIMES):
    """Return the columns at times."""
    return over_time(machine(), times, state=(2, 11, 6), rates=(15,))


if __name__ == "__main__":
    table(solution(), COLUMNS)
