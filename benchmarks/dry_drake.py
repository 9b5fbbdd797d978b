"""Wall time of dry runs on Drake: ``python benchmarks/dry_drake.py [--repeat N]``.

For the slider-crank and the seven-bar: wall seconds per simulated revolution of the crank (median; build of the diagram
and evaluation of the columns not counted), derivative evaluations, time per evaluation, steps and number of contacts.
"""

from __future__ import annotations

import argparse
import statistics
import time

import numpy as np
from pydrake.systems.analysis import Simulator

from linkages.engines.drake import build_diagram
from linkages.engines.drake.simulation import _advance, _set_up, _Watch
from linkages.engines.study import simulate, touching
from linkages.files.shipped import data_folder
from linkages.model.experiment import load
from linkages.results.impacts import impacts

#: File, drive that counts the revolutions, revolutions to simulate.
RUNS = (("slider_crank_dry.toml", "O", 1.0), ("seven_bar_dry.toml", "O1", 0.25))


def one_run(mechanism, experiment):
    """Integrate once; returns wall seconds, derivative evaluations and steps."""
    diagram, linkage = build_diagram(mechanism, experiment)
    simulator = Simulator(diagram)
    linkage.set_initial_state(simulator.get_mutable_context())
    integrator = _set_up(simulator, experiment)
    watch = _Watch(linkage, experiment, None)
    simulator.set_monitor(watch)
    start = time.perf_counter()
    _advance(simulator, integrator, watch.steps, experiment.duration)
    wall = time.perf_counter() - start
    return wall, watch.steps.evaluations + integrator.get_num_derivative_evaluations(), len(watch.times) - 1


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    print(
        "experiment             revolutions   wall [s/rev]   evaluations   us/evaluation    steps   contacts"
    )
    for name, drive, turns in RUNS:
        path = data_folder() / name
        speed = load(path)[1].drives[drive].speed
        mechanism, experiment = load(path, {"duration": turns * 2.0 * np.pi / abs(speed)})
        contacts = impacts(trajectory := simulate(mechanism, experiment), touching(experiment, trajectory))
        runs = [one_run(mechanism, experiment) for _ in range(options.repeat)]
        wall = statistics.median(run[0] for run in runs)
        _, evaluations, steps = runs[0]
        print(
            f"{name:23s}{turns:11.2f}{wall / turns:15.2f}{evaluations:14d}{1e6 * wall / evaluations:16.1f}"
            f"{steps:9d}{len(contacts):11d}"
        )


if __name__ == "__main__":
    main()
