"""Twin experiments of identification, of which docs/certainty.md states the coverage.

    python benchmarks/identification.py [--draws 100]

A slider-crank with a film, and one with dry contact, are computed with noise of 1 % of each column's deviation. Each
draw is fitted from other starts, within a factor of two; a line states how many
intervals of 95 % contain the true values.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

import linkages
import optim

FACTOR = 2.0  # largest ratio of a start and the true value
#: Experiment, its samples [s], and the true values by path.
TWINS = {
    "film": (
        "slider_crank_lubricated.toml",
        np.arange(1e-4, 0.024, 1e-4),
        {"joints.B.clearance": 5e-4, "joints.B.viscosity": 0.4, "sdf.links.slider.mass": 0.14},
    ),
    "dry": (
        "slider_crank_dry.toml",
        np.arange(0.0, 0.002, 2e-5),
        {"joints.B.clearance": 5e-4, "joints.B.contact.restitution": 0.9, "joints.B.friction.coefficient": 0.03},
    ),
}
OUTPUTS = ("slider.ax", "O.torque", "B.force")
NOISE = 0.01


def draw(name: str, seed: int, folder: Path) -> tuple[list[bool], list[float]]:
    """Fit one draw; return whether each interval contains the true value, and the errors in deviations."""
    experiment, times, values = TWINS[name]
    rng = np.random.default_rng(seed)
    system = linkages.load(linkages.find_file(experiment), {"duration": float(times[-1]), "solver.accuracy": 1e-9})
    curves = linkages.simulate(system, outputs=OUTPUTS).evaluate(times)
    sizes = [NOISE * float(np.std(curves[output])) for output in OUTPUTS]
    noisy = [
        curves[output] + size * rng.standard_normal(len(times)) for output, size in zip(OUTPUTS, sizes, strict=True)
    ]
    np.savetxt(folder / "run.csv", np.column_stack([times, *noisy]), delimiter=",", header="t,a,b,c", comments="")
    lines = [f'experiment = "{experiment}"', "[data.run]", 'file = "run.csv"', 'time = "t"']
    for column, output, size in zip("abc", OUTPUTS, sizes, strict=True):
        lines += [f"[data.run.columns.{column}]", f'output = "{output}"', f"deviation = {size}"]
    for k, (path, value) in enumerate(values.items()):
        start = value * FACTOR ** rng.uniform(-1.0, 1.0)
        upper = 0.99 if path.endswith("restitution") else 4.0 * value
        lines += [f"[unknowns.u{k}]", f'path = "{path}"', f"lower = {value / 4.0}", f"upper = {upper}"]
        lines.append(f"start = {min(start, 0.98 * upper)}")
    (folder / "task.toml").write_text("\n".join(lines), encoding="utf-8")
    found = optim.identify(optim.load_identification(folder / "task.toml"))["parameters"].values()
    pairs = list(zip(found, values.values(), strict=True))
    inside = [one["identifiable"] and one["interval"][0] <= v <= one["interval"][1] for one, v in pairs]
    errors = [(one["value"] - v) / (one["deviation"] or np.inf) for one, v in pairs]
    return inside, errors


def main() -> None:
    """Print a line for each machine."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=100)
    given = parser.parse_args()
    for name in TWINS:
        begun, inside, errors = time.perf_counter(), [], []
        with tempfile.TemporaryDirectory() as folder:
            for seed in range(given.draws):
                one, error = draw(name, seed, Path(folder))
                inside.append(one)
                errors.append(error)
        shares, spread = np.mean(inside, axis=0).round(3), np.std(errors, axis=0).round(2)
        print(f"{name}: intervals with the true value {shares}, all {np.mean(inside):.3f};", end=" ")
        print(
            f"errors in deviations {spread}, mean time {(time.perf_counter() - begun) / given.draws:.2f} s", flush=True
        )


if __name__ == "__main__":
    main()
