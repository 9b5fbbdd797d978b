"""A slider-crank whose joint between rod and slider is dry. Run as a script: prints the columns of `reference.csv`."""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from bodies import CONTACT as COLUMNS
from bodies import Clearance, Machine, steady, table


def machine():
    """Crank 50 mm, rod 120 mm, slider: bodies 0, 1, 2; 5000 r/min."""
    guess = [(0.0, 0.0, 0.0), (0.11, 0.0, 0.0), (0.17, 0.0, 0.0)]
    pins = [(-1, (0.0, 0.0), 0, (0.0, 0.0)), (0, (0.05, 0.0), 1, (-0.06, 0.0))]
    joint = Clearance(2, (0.0, 0.0), 1, (0.06, 0.0), 0.5e-3, 0.01, restitution=0.9, friction=0.03)
    driven = {0: steady(5000.0 * math.pi / 30.0)}
    return Machine([0.30, 0.21, 0.14], [1e-5, 2.5e-4, 1e-4], guess, pins, [2], driven, clearances=[joint])


def solution(most=5):
    """Return the first contacts."""
    return machine().contacts(most, free_step=1e-5, contact_step=1e-6)


if __name__ == "__main__":
    table(solution(), COLUMNS)
