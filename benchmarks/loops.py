"""Times of linkages with many loops: ``python benchmarks/loops.py [--loops N ...]``.

N four-bar windows side by side (the N-four-bar of IFToMM's benchmarks): right-hand side, and the forces in all joints
at a sample of a run, which should both grow with N. Times are medians; compilation and set-up are not counted.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
import timeit
from pathlib import Path

import numpy as np
from compiled import each, evaluate

from linkages import load, simulate
from linkages.results.outputs.columns import columns

LOOPS = (1, 2, 5, 10, 20, 40)
DURATION = 0.3  # s: ends before all windows are flat
REPEAT = 5

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))


def windows(n, folder):
    """Load n windows."""
    from reference_machines import WINDOWS, windows_sdf

    (folder / "windows.sdf").write_text(windows_sdf(n))
    file = folder / "windows.toml"
    file.write_text(f'mechanism = "windows.sdf"\nduration = {DURATION}\n{WINDOWS}')
    return load(file)


def forces(system):
    """Median time of the forces in all joints at one sample [us]."""
    run = simulate(system, "compiled")
    states = run.evaluate.function.runner.evaluate(run.evaluate.function.steps, run.time)
    names = [f"{joint}.force" for joint in system.mechanism.joint]
    count = max(1, 2000 // len(run.time))

    def often():
        for _ in range(count):
            columns(system, run.time, *states, names=names)

    often()
    return (
        1e6
        * statistics.median(timeit.repeat(often, timer=time.process_time, repeat=REPEAT, number=1))
        / count
        / len(run.time)
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--loops", type=int, nargs="+", default=LOOPS)
    options = parser.parse_args()
    print(f"{'loops':>5s}{'right-hand side [us]':>22s}{'forces [us]':>13s}   exponents since the line before")
    before = None
    with tempfile.TemporaryDirectory() as folder:
        for n in options.loops:
            system = windows(n, Path(folder))
            found = np.array([n, each(evaluate, system, 1, max(20, 4000 // n), REPEAT), forces(system)])
            growth = np.log(found[1:] / before[1:]) / np.log(n / before[0]) if before is not None else ()
            print(f"{n:5d}{found[1]:22.1f}{found[2]:13.1f}   " + " ".join(f"{x:.2f}" for x in growth), flush=True)
            before = found


if __name__ == "__main__":
    main()
