"""Time of a step of `linkages.Stepper`, with and without its outputs: ``python benchmarks/stepper.py``.

Processor time per step of the press, medians of ten runs of 1,000 steps of 1 ms.
"""

from __future__ import annotations

import statistics
import time

import linkages

STEPS, RUNS, STEP = 1000, 10, 1e-3


def main() -> None:
    """Print the times [us]."""
    system = linkages.load(linkages.find_file("seven_bar.toml"))
    for look in (False, True):
        found = []
        for _ in range(RUNS):
            stepper = linkages.Stepper(system)
            stepper.outputs()
            begin = time.process_time()
            for k in range(STEPS):
                stepper.step((k + 1) * STEP)
                if look:
                    stepper.outputs()
            found.append(1e6 * (time.process_time() - begin) / STEPS)
        print(f"a step{' with outputs' if look else ''}: {statistics.median(found):.0f} us")


if __name__ == "__main__":
    main()
