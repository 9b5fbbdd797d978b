"""Cost of the 3-RRR robot with flexible links: ``python benchmarks/flexible.py [--figure FILE.png]``.

Prints the time of the modal map of 360 poses with one element in each link (21 unknowns; wanted: 0.15 s),
with 16 elements (first 10 modes; wanted: 10 s), and dense against sparse for several numbers of elements.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from linkages.files.shipped import data_folder
from linkages.three_rrr import modes as modes_module
from linkages.three_rrr.branch import follow, start_assembly
from linkages.three_rrr.direct import assemblies, count
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.modes import frequencies, modes
from linkages.three_rrr.robot import changed, load_robot

POSES = 360
MODES = 10


def best(run: Callable[[], object], repeats: int = 3) -> float:
    """Least wall time of some runs [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def with_solver(dense_up_to: int, run: Callable[[], object], repeats: int) -> float:
    """Time with the dense solver used up to a number of unknowns."""
    kept = modes_module.DENSE
    modes_module.DENSE = dense_up_to
    try:
        return best(run, repeats)
    finally:
        modes_module.DENSE = kept


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figure", type=Path)
    options = parser.parse_args()
    robot = load_robot(data_folder() / "three_rrr.toml")
    g = robot.geometry
    start = start_assembly(g, robot.phi0, np.deg2rad(98.05))
    branch = follow(g, robot.phi0, robot.phidot, start, robot.duration)
    state = branch.motion(np.linspace(0.0, robot.duration, POSES))
    model = FiniteElementModel(robot)
    frequencies(model, state.part(slice(0, 2)))  # builds the tables
    print(
        f"modal map, {POSES} poses x {model.size} unknowns, all frequencies: "
        f"{best(lambda: frequencies(model, state)):.3f} s"
    )
    print(f"  the same with shapes: {best(lambda: modes(model, state)):.3f} s")
    fine = FiniteElementModel(changed(robot, model={"elements": 16}))
    frequencies(fine, state.part(slice(0, 2)), MODES)
    print(
        f"16 elements, {POSES} poses x {fine.size} unknowns, {MODES} modes: "
        f"{best(lambda: modes(fine, state, MODES), 1):.2f} s"
    )
    print(
        "one direct kinematics, certified: "
        f"{1e3 * best(lambda: [assemblies(g, p) for p in state.phi[:50]]) / 50:.2f} ms"
    )
    print(
        "one assembly count in a batch: "
        f"{1e6 * best(lambda: count(g, np.tile(state.phi, (10, 1)))) / (10 * POSES):.1f} us"
    )
    print(
        "one branch over the revolution: "
        f"{best(lambda: follow(g, robot.phi0, robot.phidot, start, robot.duration)):.3f} s"
    )
    print(
        f"\n{'elements':>8s}{'unknowns':>10s}{'dense':>12s}{'sparse':>12s}   ms per pose, first {MODES} modes"
    )
    rows = []
    for n in (1, 2, 3, 4, 6, 8, 16, 32, 64):
        model_n = FiniteElementModel(changed(robot, model={"elements": n}))
        some = state.part(slice(0, 36 if n <= 8 else 8))
        frequencies(model_n, some.part(slice(0, 1)), 3)

        def run(model_n: FiniteElementModel = model_n, some: object = some) -> object:
            return modes(model_n, some, MODES)  # type: ignore[arg-type]

        dense = with_solver(10**9, run, 2) / len(some) if n <= 16 else np.nan
        sparse = with_solver(0, run, 2) / len(some) if model_n.size > 4 * MODES else np.nan
        rows.append((n, model_n.size, 1e3 * dense, 1e3 * sparse))
        print(f"{n:8d}{model_n.size:10d}{1e3 * dense:12.3f}{1e3 * sparse:12.3f}")
    if options.figure:
        draw(np.array(rows), options.figure)


def draw(rows: np.ndarray, path: Path) -> None:
    from matplotlib.figure import Figure

    from linkages.plots.style import COLORS, figure_style

    with figure_style():
        figure = Figure(figsize=(6.3, 3.4), layout="constrained")
        axis = figure.subplots()
        axis.loglog(rows[:, 0], rows[:, 2], "o-", color=COLORS[0], label="dense, batched")
        axis.loglog(rows[:, 0], rows[:, 3], "s--", color=COLORS[1], label="sparse, shift and invert")
        axis.set_xticks(rows[:, 0], [f"{int(n)}" for n in rows[:, 0]])
        axis.minorticks_off()
        axis.set_xlabel("elements in each link")
        axis.set_ylabel(f"time per pose, first {MODES} modes [ms]")
        axis.legend()
        figure.savefig(path)


if __name__ == "__main__":
    main()
