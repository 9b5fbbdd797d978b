"""Show why values at steps are no references: python clearance_benchmark/steps.py.

The dry slider-crank at four accuracies: the largest force of the first turn, located between steps and at steps, and the
largest one of the second turn, which an error of a run has changed by then.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import linkages

HERE = Path(__file__).resolve().parent
TURN = 0.012  # s


def main() -> None:
    """Print a line for each accuracy."""
    print("accuracy   first turn: located [N]   at steps [N]   second turn: located [N]   contacts")
    for accuracy in (1e-6, 1e-8, 1e-10, 1e-12):
        system = linkages.load(HERE / "dry_slider_crank" / "machine.toml", {"solver.accuracy": accuracy})
        run = linkages.simulate(system)
        contacts = linkages.impacts(run, ["B"])
        first, second = (
            max(one.peak_force for one in contacts if (one.start >= TURN) is late) for late in (False, True)
        )
        steps = float(np.max(run["B.force"][run.time < TURN]))
        print(f"{accuracy:8.0e}   {first:23.1f}   {steps:12.1f}   {second:24.1f}   {len(contacts):8d}", flush=True)


if __name__ == "__main__":
    main()
