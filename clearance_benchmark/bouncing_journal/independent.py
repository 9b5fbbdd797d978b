"""A spinning journal falls in its bearing. Run as a script: prints the columns of `reference.csv`."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from bodies import CONTACT as COLUMNS
from bodies import Clearance, Machine, table


def machine():
    """One free body in the frame's bearing."""
    joint = Clearance(-1, (0.0, 0.0), 0, (0.0, 0.0), 0.5e-3, 0.01, restitution=0.9, friction=0.05)
    return Machine([0.5], [2e-5], [(0.0, 0.0, 0.0)], spin={0: 50.0}, clearances=[joint], gravity=9.81)


def solution(most=8):
    """Return the first contacts."""
    return machine().contacts(most, free_step=1e-3, contact_step=2e-6)


if __name__ == "__main__":
    table(solution(), COLUMNS)
