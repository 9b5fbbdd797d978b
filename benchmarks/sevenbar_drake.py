"""Wall time and orbit error of the seven-bar on Drake: ``python benchmarks/sevenbar_drake.py [--repeat N]``.

For several accuracies and largest steps: wall seconds per simulated second (median; build of the diagram and
evaluation of the columns not counted), derivative evaluations, time per evaluation, and the largest difference of a
journal's orbit from a solution at 1e-10, in parts of the largest eccentricity. The reference integrates the same laws
and kinematics with SciPy's Radau, cranks eliminated.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from seven_bar_reference import orbit_error, reference

from linkages import load
from linkages.engines.drake import build_diagram
from linkages.engines.drake.simulation import _Watch
from linkages.engines.drake.steps import StepControl


def one_run(system):
    """Integrate once; returns wall seconds, evaluations, step times and eccentricities there."""
    diagram, linkage = build_diagram(system)
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    linkage.set_initial_state(root)
    watch = _Watch(linkage, StepControl(simulator, system), None)
    simulator.set_monitor(watch)
    start = time.perf_counter()
    simulator.Initialize()
    watch.steps.advance(system.experiment.duration)
    wall = time.perf_counter() - start
    evaluations = watch.steps.evaluations
    context = linkage.clearance.GetMyContextFromRoot(root)
    orbit = []
    for t, x in zip(watch.times, watch.states, strict=True):
        root.SetTime(t)
        root.SetContinuousState(x)
        orbit.append(linkage.clearance.evaluate(context)[:, :2].copy())
    return wall, evaluations, np.array(watch.times), np.array(orbit)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--file", default=str(Path(__file__).with_name("seven_bar_fast.toml")))
    options = parser.parse_args()
    system = load(options.file, {"duration": 1.0})
    exact = reference(system)
    print("radau3   accuracy  max step   wall [s/s]   evaluations   us/evaluation   orbit error")
    for accuracy in (1e-5, 1e-6, 1e-7, 1e-8):
        for step in (5e-3, 2e-3, 1e-3):
            changed = system.replaced({"solver.accuracy": accuracy, "solver.max_step": step})
            runs = [one_run(changed) for _ in range(options.repeat)]
            wall = statistics.median(run[0] for run in runs)
            _, evaluations, times, orbit = runs[0]
            error = orbit_error(orbit, exact(times))
            each = 1e6 * wall / evaluations
            print(f"{accuracy:17.0e}{step:10.0e}{wall:13.3f}{evaluations:14d}{each:16.1f}{error:14.1e}")


if __name__ == "__main__":
    main()
