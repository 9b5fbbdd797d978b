"""Two wheels with backlash; the speed of the pinion fluctuates. Run as a script: prints the columns of `reference.csv`."""

from __future__ import annotations

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from bodies import CONTACT as COLUMNS
from bodies import Flanks, Machine, table


def fluctuating(t):
    """Angle, rate and acceleration of the pinion."""
    rate, angle = 251.3, 0.01
    wave = angle * math.sin(rate * t)
    return 80.0 * t + wave, 80.0 + angle * rate * math.cos(rate * t), -(rate**2) * wave


def machine():
    """Pinion and wheel: bodies 0, 1."""
    flanks = Flanks((0, 1), -0.5, 0.0564, 50e-6, 5e8, 0.6)
    pins = [(-1, (0.0, 0.0), 0, (0.0, 0.0)), (-1, (0.09, 0.0), 1, (0.0, 0.0))]
    moving = {"driven": {0: fluctuating}, "spin": {1: -0.5 * fluctuating(0.0)[1]}}
    drag = {1: lambda rate: -0.01 * rate}
    return Machine(
        [0.44, 1.78],
        [2.0e-4, 3.2e-3],
        [(0.0, 0.0, 0.0), (0.09, 0.0, 0.0)],
        pins,
        **moving,
        torque=drag,
        flanks=[flanks],
    )


def solution(most=6):
    """Return the first contacts."""
    return machine().contacts(most, free_step=1e-5, contact_step=1e-5)


if __name__ == "__main__":
    table(solution(), COLUMNS)
