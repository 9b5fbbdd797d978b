"""Measure studies of tolerances: ``python benchmarks/tolerances.py [--samples N] [--seeds N]``; docs/benchmarks.md.

Processor time and largest memory of `linkages tolerances` for the press of batch.py with a fit and a length (2 s), and
for the dry slider-crank with a clearance and a mass (two turns). Then errors of the mean force of 256 machines of the
press, with Sobol points and random ones, against the mean of all machines; the deviation to first order.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

import optim

PRESS = f"""experiment = "{Path(__file__).with_name("seven_bar_fast.toml")}"
[scatter.fit]
path = "joints.A.clearance"
fit = "30 D10/d9"
[scatter.length]
path = "sdf.frames.link2_C.pose.x"
normal = ["0 mm", "0.05 mm"]
relative_to = "nominal"
[windows.second]
start = 1.0
end = 2.0
[constraints.force]
unit = "N"
terms = [{{ functional = "peak", output = "A.force", window = "second" }}]
at_most = 3.3469
[algorithm]
name = "scatter"
"""
DRY = """experiment = "slider_crank_dry.toml"
[scatter.clearance]
path = "joints.B.clearance"
normal = ["0.5 mm", "0.02 mm"]
[scatter.mass]
path = "sdf.links.rod.mass"
normal = ["210 g", "2 g"]
[constraints.force]
unit = "N"
terms = [{ functional = "peak", output = "B.force" }]
at_most = 47000
[algorithm]
name = "scatter"
"""
FEW = 256


def used(file: Path, samples: int) -> tuple[float, float, dict]:
    """Run the command: processor time [s], largest memory [MB], result."""
    command = "import sys; from linkages.cli.main import main; sys.exit(main(sys.argv[1:]))"
    words = ["tolerances", str(file), "--samples", str(samples), "--no-plots", "--out", str(file.with_suffix(""))]
    child = os.spawnv(os.P_NOWAIT, sys.executable, [sys.executable, "-c", command, *words])
    _, status, usage = os.wait4(child, 0)
    assert status == 0
    result = json.loads((file.with_suffix("") / "tolerances.json").read_text())
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0, result


def errors(file: Path, seeds: int, mean: float) -> dict[str, float]:
    """Root mean square errors of means of few machines by the sequence of their points."""
    found = {}
    for sequence in ("sobol", "random"):
        study = optim.load_study(file)
        study.file.algorithm["sequence"] = sequence
        means = [
            optim.tolerances(study, seed=seed, samples=FEW)["outputs"]["force"]["mean"]
            for seed in range(100, 100 + seeds)
        ]
        found[sequence] = float(np.sqrt(np.mean((np.array(means) - mean) ** 2)))
    return found


def main() -> None:
    """Print all numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=10000)
    parser.add_argument("--seeds", type=int, default=8)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("press", PRESS), ("dry", DRY)):
            file = Path(folder) / f"{name}.toml"
            file.write_text(text)
            seconds, memory, result = used(file, options.samples)
            entry = result["outputs"]["force"]
            print(f"{name}: {options.samples} machines, {seconds:.1f} s of processors, {memory:.0f} MB")
            linear = entry["first_order"]
            said = linear["unknown"] or f"{linear['error']:+.2%} of the deviation"
            print(f"  yield {result['yield']}, first order {said}")
            if name == "press":
                found = errors(file, options.seeds, entry["mean"])
                print(f"  error of the mean of {FEW}: {found}, ratio {found['random'] / found['sobol']:.1f}")


if __name__ == "__main__":
    main()
