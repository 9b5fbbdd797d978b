"""Cost and accuracy of derivatives of runs against differences of runs: ``python benchmarks/sensitivity.py``.

For each machine: CPU time of one run, with its system built anew, as differences need it, and of a built system; of the
same run with seven or ten derivatives, in parts: neighbouring systems (Python), steps (compiled) and outputs (both); of
central differences with two runs for each; the largest relative error of both over the outputs at the end of the run.
Errors are those against derivatives at an accuracy of 1e-12; differences have the step with the smallest error.
Compilation is not counted.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from linkages import find_file, load, simulate
from linkages.engines.compiled.derivatives.sensitivity import Differentiation
from linkages.engines.compiled.run.runner import Runner, join

_BODIES = ["sdf.links.link2.mass", "sdf.links.link3.mass", "sdf.links.link6.mass", "drives.O1.speed"]
_LENGTHS = ["sdf.frames.link2_C.pose.x", "sdf.frames.link6_D.pose.x"]
_JOINTS = [f"joints.{name}.{key}" for name in "AB" for key in ("clearance", "viscosity")]
_CRANK = ["sdf.links.rod.mass", "sdf.links.slider.mass", "drives.O.speed", "sdf.frames.rod_B.pose.x", "gravity.y"]
CASES = {
    "seven_bar_fast.toml": ({"duration": 2.0}, [*_JOINTS, *_BODIES, *_LENGTHS], ["A.force", "slider7.ax"]),
    "slider_crank_lubricated.toml": (
        {"duration": 0.024}, [*_CRANK, "joints.B.clearance", "joints.B.viscosity"], ["B.force", "slider.ax"],
    ),
    "slider_crank_dry.toml": (
        {"duration": 1e-3}, [*_CRANK, "joints.B.clearance", "joints.B.contact.restitution"], ["slider.x", "slider.vx"],
    ),
}  # fmt: skip
ACCURACIES = (1e-6, 1e-9)
STEPS = (1e-2, 1e-3, 1e-4, 1e-5)


def cpu(function, count: int = 3) -> float:
    """Measure the shortest CPU time of a call [s]; a first call compiles."""
    function()
    times = []
    for _ in range(count):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return min(times)


def differences(system, paths, outputs, step) -> np.ndarray:
    """Compute central differences of outputs at the end of the run, (np, no)."""
    result = []
    for path in paths:
        value = system.value(path)
        h = step * (abs(value) or 10.0)
        ends = [simulate(system.replaced({path: value + k * h}), outputs=outputs) for k in (-1, 1)]
        result.append([(ends[1][name][-1] - ends[0][name][-1]) / (2.0 * h) for name in outputs])
    return np.array(result)


def derivatives(system, paths, outputs) -> np.ndarray:
    """Differentiate outputs at the end of the run, (np, no)."""
    rates = simulate(system, outputs=outputs, wrt=paths).sensitivity
    return np.array([[rates[path][name][-1] for name in outputs] for path in paths])


def main() -> None:
    """Print a line for each machine and accuracy."""
    print(f"{'CPU times in ms':30s}{'accuracy':>10s}{'steps':>7s}{'run, anew':>10s}{'built':>7s}", end="")
    print(f"{'systems':>9s}{'steps':>7s}{'outputs':>9s}{'derivatives':>13s}{'differences':>13s}", end="")
    print(f"{'error':>10s}{'of differences':>16s}")
    for name, (overrides, paths, outputs) in CASES.items():
        beside = Path(__file__).with_name(name)
        nominal = load(beside if beside.exists() else find_file(name), overrides)
        exact = derivatives(nominal.replaced({"solver.accuracy": 1e-12}), paths, outputs)
        for accuracy in ACCURACIES:
            print(f"{name:30s}{accuracy:10.0e}{compare(nominal, accuracy, paths, outputs, exact)}", flush=True)


def compare(nominal, accuracy, paths, outputs, exact) -> str:
    """Measure a run, its derivatives and differences; return the numbers as text."""
    system = nominal.replaced({"solver.accuracy": accuracy})
    same = {paths[0]: system.value(paths[0])}
    one = cpu(lambda: simulate(system.replaced(same), outputs=outputs))
    built = cpu(lambda: simulate(system, outputs=outputs))
    many = cpu(lambda: derivatives(system, paths, outputs)) / one
    parts = "".join(
        f"{1e3 * part:{width}.1f}" for part, width in zip(split(system, paths, outputs), (9, 7, 9), strict=True)
    )
    differing = cpu(lambda: differences(system, paths, outputs, STEPS[1]), 1) / one
    steps = len(simulate(system, outputs=outputs).time)
    error = np.max(np.abs(derivatives(system, paths, outputs) / exact - 1.0))
    other = min(np.max(np.abs(differences(system, paths, outputs, step) / exact - 1.0)) for step in STEPS)
    run = f"{steps:7d}{1e3 * one:10.1f}{1e3 * built:7.1f}{parts}"
    return f"{run}{many:11.1f} x{differing:11.1f} x{error:10.1e}{other:16.1e}"


def split(system, paths, outputs) -> tuple[float, float, float]:
    """Measure the parts of derivatives [s]: neighbouring systems, steps, outputs at the steps."""
    runner = Runner(system)
    steps = join([runner.run(0.0, runner.start, 0.0, 10**6, differentiated=True)])
    found = Differentiation(runner, steps, paths)
    _ = found.columns
    systems = cpu(lambda: Differentiation(runner, steps, paths))
    return systems, cpu(found.at_steps), cpu(lambda: found.outputs(steps.times, outputs))


if __name__ == "__main__":
    main()
