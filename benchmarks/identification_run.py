"""Time of a run with derivatives at its samples, in an identification, and its parts.

    python benchmarks/identification_run.py [--rounds 15] [--rows 2001]

A slider-crank with a film and friction in its guide has four unknown values, and four columns of samples. Lines are
medians of processor time.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import linkages
import optim
from linkages.engines.assessment import differentiated
from optim.identify.residuals import Residuals

EXPERIMENT = """mechanism = "slider_crank.sdf"
duration = 2.01
gravity = [0.0, -9.81, 0.0]
outputs = ["slider.ax"]
drives.O.formula = "30*t + 0.75*sin(4*t)"
joints.B = { model = "lubricated", film = "short", clearance = 1.7e-4, viscosity = 0.05, shear_torque = false }
frictions.guide_f = { joint = "guide", constant = 1.0, viscous = 0.0, speed = 0.01 }
"""
OUTPUTS = {"ax": "slider.ax", "torque": "O.torque", "fx": "B.fx", "fy": "B.fy"}
UNKNOWNS = {
    "clearance": ("joints.B.clearance", 5e-5, 5e-4, 1.7e-4),
    "viscosity": ("joints.B.viscosity", 0.005, 0.2, 0.05),
    "mass": ("sdf.links.slider.mass", 0.05, 0.4, 0.15),
    "friction": ("frictions.guide_f.constant", 0.0, 5.0, 1.0),
}
END = 2.0  # time of the last sample [s]


def written(folder: Path, rows: int) -> Path:
    """Write experiment, data (any, as times count alone) and identification; return the path of the last one."""
    shutil.copy(linkages.find_file("slider_crank.sdf"), folder)
    (folder / "machine.toml").write_text(EXPERIMENT, encoding="utf-8")
    times = np.linspace(0.0, END, rows)
    table = np.column_stack([times, *[np.sin(30.0 * times)] * len(OUTPUTS)])
    np.savetxt(folder / "data.csv", table, "%.9g", ",", header="time," + ",".join(OUTPUTS), comments="")
    lines = ['experiment = "machine.toml"', "[data.run]", 'file = "data.csv"', 'time = { column = "time", unit = "s" }']
    lines += [f'columns.{name} = {{ output = "{output}", deviation = 1.0 }}' for name, output in OUTPUTS.items()]
    for name, (path, lower, upper, start) in UNKNOWNS.items():
        lines += [f"[unknowns.{name}]", f'path = "{path}"', f"lower = {lower}", f"upper = {upper}", f"start = {start}"]
    (folder / "fit.toml").write_text("\n".join(lines), encoding="utf-8")
    return folder / "fit.toml"


def median(work: Callable[[], object], rounds: int) -> float:
    """Return the median of the processor time of some work [ms], after a first time that compiles."""
    work()
    taken = []
    for _ in range(rounds):
        begun = time.process_time()
        work()
        taken.append(time.process_time() - begun)
    return 1e3 * float(np.median(taken))


def main() -> None:
    """Print a line for each part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--rows", type=int, default=2001)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        residuals = Residuals(optim.load_identification(written(Path(folder), given.rows)))
    task, z = residuals.task, residuals.start
    system, names = task.measurements[0].system, list(OUTPUTS.values())
    print(f"residuals and four derivatives: {median(lambda: residuals(z), given.rounds):.1f} ms")
    print(f"residuals alone: {median(lambda: residuals(z, derivatives=False), given.rounds):.1f} ms")
    print(f"run: {median(lambda: differentiated(system, names), given.rounds):.1f} ms")
    both = median(lambda: differentiated(system, names, task.paths), given.rounds)
    print(f"run and derivatives at steps: {both:.1f} ms")


if __name__ == "__main__":
    main()
