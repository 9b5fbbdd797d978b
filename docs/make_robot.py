"""Compute the robot's stresses over time steps, starts and assemblies: ``python docs/make_robot.py``, some minutes.

Writes docs/replication/computed/robot_factors.json, from which docs/make_replication_3rrr.py writes a row.
"""

from __future__ import annotations

import sys

from replication.computed import keep
from replication.robot_runs import results, second
from replication.robot_stress import FACTORS

from linkages.three_rrr.vibration import vibrate

#: Name, start, time steps in the shortest period of the first mode, and whether the other assembly is followed.
CASES = (
    ("20 steps in a period", "rest", 20.0, False),
    ("40 steps", "rest", 40.0, False),
    ("20 steps, start quasi-static", "quasi-static", 20.0, False),
    ("20 steps, other assembly", "rest", 20.0, True),
)


def main() -> None:
    """Run the cases."""
    found = {}
    for name, start, steps, other in CASES:
        analysed = second() if other else results()
        shaken = vibrate(analysed.model, analysed.branch, start, steps_per_period=steps)
        assert shaken.plate is not None  # the robot's platform is a triangle
        found[name] = {
            "crank": round(shaken.largest["crank2"], 1),
            "shear": round(float(shaken.plate[1, :, 2].max()), 2),
        }
        keep(FACTORS, found)
        print(name, found[name], flush=True)


if __name__ == "__main__":
    sys.exit(main())
