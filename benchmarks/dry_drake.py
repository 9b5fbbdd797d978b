"""Wall time of dry runs on Drake: ``python benchmarks/dry_drake.py [--repeat N]``.

For the slider-crank and the seven-bar: wall seconds per simulated revolution of the crank (median; build of the diagram
and evaluation of the columns not counted), derivative evaluations, time per evaluation, steps and number of contacts.
"""

from __future__ import annotations

import argparse
import statistics

import numpy as np
from sevenbar_drake import one_run

from linkages import load
from linkages.engines.assessment import simulate
from linkages.input.files.shipped import data_folder
from linkages.results.assessment import touching
from linkages.results.impacts import impacts

#: File, drive that counts the revolutions, revolutions to simulate.
RUNS = (("slider_crank_dry.toml", "O", 1.0), ("seven_bar_dry.toml", "O1", 0.25))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    print("experiment             revolutions   wall [s/rev]   evaluations   us/evaluation    steps   contacts")
    for name, drive, turns in RUNS:
        path = data_folder() / name
        speed = load(path).experiment.drives[drive].speed
        system = load(path, {"duration": turns * 2.0 * np.pi / abs(speed)})
        contacts = impacts(simulate(system, "drake"), touching(system))
        runs = [one_run(system) for _ in range(options.repeat)]
        wall = statistics.median(run[0] for run in runs)
        _, evaluations, times, _ = runs[0]
        print(
            f"{name:23s}{turns:11.2f}{wall / turns:15.2f}{evaluations:14d}{1e6 * wall / evaluations:16.1f}"
            f"{len(times) - 1:9d}{len(contacts):11d}"
        )


if __name__ == "__main__":
    main()
