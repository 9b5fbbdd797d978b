"""Growth of the cost with a linkage's size: ``python benchmarks/growth.py [--only loops ...]``; docs/benchmarks.md.

Links of an open chain; loops side by side (four-bar windows, the N-four-bar of IFToMM's benchmarks) and on top of each
other: right-hand side. Joint forces of the windows at a sample. Chains of 20 links with lubricated joints, and bending
modes of the shipped flexible slider-crank: integration, per step. The press with thinner oil: a simulated second. The
exponent is that of the growth since the line before. Processor times are medians; compilation and set-up are not
counted.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import timeit
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import process_time
from typing import NamedTuple

import numpy as np
from compiled import each, evaluate

from linkages import load, simulate
from linkages.engines.compiled.run.runner import Runner
from linkages.input.files.shipped import data_folder
from linkages.results.outputs.columns import columns

LINKS = 20  # of the chain with lubricated joints
REPEAT = 9
ROOT = Path(__file__).resolve().parents[1]
GRAVITY = "gravity = [0.0, -9.81, 0.0]\n"
VISCOSITIES = ("joints.A.viscosity", "joints.B.viscosity")
FILM = 'model = "lubricated"\nclearance = 1e-4\nviscosity = 0.1\n'

sys.path.append(str(ROOT / "tests"))


def written(folder, sdf, toml):
    """Load a machine and its experiment from their texts."""
    (folder / "machine.sdf").write_text(sdf)
    (folder / "machine.toml").write_text(f'mechanism = "machine.sdf"\n{toml}')
    return load(folder / "machine.toml")


def chain(folder, n, films=0):
    """Load a hanging chain of n bars, drawn in a zigzag, the first joints with films."""
    from machines import BEARING
    from reference_machines import chain_sdf

    start, *joints = chain_sdf(np.full(n, 0.1), -np.pi / 2 + 0.3 * (-1.0) ** np.arange(n)).split("<joint ")
    joints = [text.replace("</joint>", f"{BEARING}</joint>") if k < films else text for k, text in enumerate(joints)]
    toml = f"duration = 0.1\n{GRAVITY}" + "".join(f"[joints.pin{k + 1}]\n{FILM}" for k in range(films))
    return written(folder, "<joint ".join([start, *joints]), toml)


def windows(folder, n):
    """Load n windows; the run ends before they are flat."""
    from reference_machines import WINDOWS, windows_sdf

    return written(folder, windows_sdf(n), f"duration = 0.3\n{WINDOWS}")


def tower(folder, n):
    """Load n parallelograms on top of each other."""
    from reference_machines import tower_sdf

    return written(folder, tower_sdf(n), "duration = 0.1\n")


def bending(folder, n):
    """Load the flexible slider-crank with so many bending modes."""
    return load(data_folder() / "slider_crank_flexible.toml", {"links.rod.bending": n, "duration": 0.02})


def press(folder, n):
    """Load the old press with a viscosity of 1/n Pa s: the less, the more its films are loaded."""
    return load(ROOT / "benchmarks" / "seven_bar_fast.toml", {"duration": 1.0, **dict.fromkeys(VISCOSITIES, 1.0 / n)})


def second(system):
    """Time of a simulated second [us]."""
    runner = Runner(system)
    return _median(partial(runner.run, 0.0, runner.start, 0.0, 10**6), 3) / system.experiment.duration


def right_hand_side(system):
    """Time of the right-hand side [us]."""
    return each(evaluate, system, 1, max(20, 5000 // len(system.tree.bodies.records)), REPEAT)


def forces(system):
    """Time of the forces in all joints at one sample [us]."""
    run = simulate(system, "compiled")
    states = run.evaluate.function.runner.evaluate(run.evaluate.function.steps, run.time)
    names = [f"{joint}.force" for joint in system.mechanism.joint]
    return _median(lambda: columns(system, run.time, *states, names=names), max(1, 2000 // len(run.time))) / len(
        run.time
    )


def step(system):
    """Time of a step of a run [us]."""
    runner = Runner(system)
    return _median(partial(runner.run, 0.0, runner.start, 0.0, 10**6), 3) / simulate(system).provenance["steps"]


def _median(function, count):
    """Time of one call [us]."""
    function()
    walls = timeit.repeat(function, timer=process_time, repeat=REPEAT, number=count)
    return 1e6 * statistics.median(walls) / count


class Growth(NamedTuple):
    """What is measured."""

    title: str
    machine: Callable
    sizes: tuple[int, ...]
    cost: Callable


CASES = {
    "links": Growth("links of an open chain, right-hand side", chain, (10, 20, 50, 100, 200), right_hand_side),
    "loops": Growth("loops side by side, right-hand side", windows, (5, 10, 20, 40, 80), right_hand_side),
    "forces": Growth("loops side by side, forces at a sample", windows, (5, 10, 20, 40, 80), forces),
    "tower": Growth("loops on top of each other, right-hand side", tower, (5, 10, 20, 40), right_hand_side),
    "films": Growth(
        f"lubricated joints of {LINKS} links, step", lambda folder, n: chain(folder, LINKS, n), (1, 2, 5, 10, 20), step
    ),
    "modes": Growth("bending modes, step", bending, (2, 4, 8, 16, 32), step),
    "second": Growth("load of the press's films, 1 / (Pa s), a simulated second", press, (1, 10, 100, 1000), second),
}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--only", nargs="+", choices=CASES, default=[*CASES])
    for name in parser.parse_args().only:
        case, before = CASES[name], None
        print(f"\n{case.title}\n{'number':>8s}{'[us]':>10s}   exponent")
        with tempfile.TemporaryDirectory() as folder:
            for n in case.sizes:
                cost = case.cost(case.machine(Path(folder), n))
                growth = f"{np.log(cost / before[1]) / np.log(n / before[0]):.2f}" if before else ""
                print(f"{n:8d}{cost:10.2f}   {growth}", flush=True)
                before = n, cost


if __name__ == "__main__":
    main()
