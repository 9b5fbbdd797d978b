"""Cost of the 3-RRR robot with flexible links: ``python benchmarks/flexible.py [--figure FILE.png]``.

Prints the time of the modal map of 360 poses with one element in each link (21 unknowns; wanted: 0.15 s),
with 16 elements (first 10 modes; wanted: 10 s), and dense against sparse for several numbers of elements; then one
revolution of the robot as a linkage with six links of five modes each and three lubricated joints (wanted: 5 s).
"""

from __future__ import annotations

import argparse
import statistics
import timeit
from collections.abc import Callable
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np

from linkages import load, simulate
from linkages.input.files.shipped import data_folder
from linkages.three_rrr import modes as modes_module
from linkages.three_rrr.branch import AssemblyBranch, follow, start_assembly
from linkages.three_rrr.direct import assemblies, count
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.modes import frequencies, modes
from linkages.three_rrr.robot import changed, load_robot

POSES = 360
MODES = 10


def best(run: Callable[[], object], repeats: int = 3) -> float:
    """Least wall time of some runs [s]."""
    return min(timeit.repeat(run, repeat=repeats, number=1))


def with_solver(dense_up_to: int, run: Callable[[], object]) -> float:
    """Time with the dense solver used up to a number of unknowns."""
    with patch.object(modes_module, "DENSE", dense_up_to):
        return best(run, 2)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figure", type=Path)
    options = parser.parse_args()
    robot = load_robot(data_folder() / "three_rrr.toml")
    g = robot.geometry
    start = start_assembly(g, robot.phi0, np.deg2rad(98.05))

    def revolve() -> AssemblyBranch:
        return follow(g, robot.cranks, start, robot.duration)

    state = revolve().motion(np.linspace(0.0, robot.duration, POSES))
    model = FiniteElementModel(robot)
    frequencies(model, state.part(slice(0, 2)))  # builds the tables
    wall = best(lambda: frequencies(model, state))
    print(f"modal map, {POSES} poses x {model.size} unknowns, all frequencies: {wall:.3f} s")
    print(f"  the same with shapes: {best(lambda: modes(model, state)):.3f} s")
    fine = FiniteElementModel(changed(robot, model={"elements": 16}))
    frequencies(fine, state.part(slice(0, 2)), MODES)
    wall = best(lambda: modes(fine, state, MODES), 1)
    print(f"16 elements, {POSES} poses x {fine.size} unknowns, {MODES} modes: {wall:.2f} s")
    wall = best(lambda: [assemblies(g, p) for p in state.phi[:50]]) / 50
    print(f"one direct kinematics, certified: {1e3 * wall:.2f} ms")
    wall = best(lambda: count(g, np.tile(state.phi, (10, 1)))) / (10 * POSES)
    print(f"one assembly count in a batch: {1e6 * wall:.1f} us")
    print(f"one branch over the revolution: {best(revolve):.3f} s")
    print(f"\n{'elements':>8s}{'unknowns':>10s}{'dense':>12s}{'sparse':>12s}   ms per pose, first {MODES} modes")
    rows = []
    for n in (1, 2, 3, 4, 6, 8, 16, 32, 64):
        model = FiniteElementModel(changed(robot, model={"elements": n}))
        some = state.part(slice(0, 36 if n <= 8 else 8))
        frequencies(model, some.part(slice(0, 1)), 3)
        run = partial(modes, model, some, MODES)
        dense = 1e3 * with_solver(10**9, run) / len(some) if n <= 16 else np.nan
        sparse = 1e3 * with_solver(0, run) / len(some) if model.size > 4 * MODES else np.nan
        rows.append((n, dense, sparse))
        print(f"{n:8d}{model.size:10d}{dense:12.3f}{sparse:12.3f}")
    linkage = load(data_folder() / "three_rrr_clearance.toml")
    steps = simulate(linkage, "compiled").provenance["steps"]
    walls = timeit.repeat(lambda: simulate(linkage, "compiled"), repeat=5, number=1)
    print(f"\none revolution with three lubricated joints: {statistics.median(walls):.2f} s, {steps} steps")
    if options.figure:
        draw(np.array(rows), options.figure)


def draw(rows: np.ndarray, path: Path) -> None:
    from matplotlib.figure import Figure

    from linkages.show.plots.style import COLORS, figure_style

    elements, dense, sparse = rows.T
    with figure_style():
        figure = Figure(figsize=(6.3, 3.4), layout="constrained")
        axis = figure.subplots()
        axis.loglog(elements, dense, "o-", color=COLORS[0], label="dense, batched")
        axis.loglog(elements, sparse, "s--", color=COLORS[1], label="sparse, shift and invert")
        axis.set_xticks(elements, [f"{int(n)}" for n in elements])
        axis.minorticks_off()
        axis.set(xlabel="elements in each link", ylabel=f"time per pose, first {MODES} modes [ms]")
        axis.legend()
        figure.savefig(path)


if __name__ == "__main__":
    main()
