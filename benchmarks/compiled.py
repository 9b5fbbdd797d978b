"""Measure the times of the compiled engine: ``python benchmarks/compiled.py [--repeat N]``.

Right-hand side, residual of Newton's iterations and Jacobian of the seven-bar; wall time per simulated second and orbit
error of the seven-bar at several accuracies. Times are medians; compilation and set-up are not counted. For other codes
see sevenbar_engines.py, for the growth with a linkage's size growth.py.
"""

from __future__ import annotations

import argparse
import statistics
import timeit
from functools import partial
from pathlib import Path

import numpy as np
import seven_bar_reference

from linkages import load
from linkages.base.kernel import kernel
from linkages.base.kernel.by_reference import reference
from linkages.engines.compiled.run.equations import derivatives, residual
from linkages.engines.compiled.run.jacobian import jacobian
from linkages.engines.compiled.run.runner import Runner
from linkages.engines.compiled.simulation import simulate

TIME = 0.01  # s


@kernel
def evaluate(given, y, dy, count):
    """Evaluate the right-hand side many times."""
    problem = reference(given)
    for _ in range(count):
        derivatives(problem, TIME, y, dy)
        y[0] += 1e-12 * dy[0]


@kernel(makes_arrays=True)
def leave(given, y, out, count):
    """Evaluate the residual many times."""
    problem = reference(given)
    dy = np.zeros(len(y) - len(problem.model.free))
    for _ in range(count):
        residual(problem, TIME, y, dy, out)
        y[0] += 1e-30 * out[0]


@kernel(makes_arrays=True)
def differentiate(given, y, out, count):
    """Evaluate the Jacobian many times."""
    problem = reference(given)
    rates = len(y) - len(problem.model.free)
    mass = np.empty((rates, rates))
    for _ in range(count):
        jacobian(problem, TIME, y, mass, out)
        y[0] += 1e-30 * out[0, 0]


def each(function, system, shape, count, repeat):
    """Median time of one evaluation [us], at a state of a run."""
    run = simulate(system.replaced({"duration": TIME})).evaluate.function
    problem, y = run.runner.aside(), run.steps.states[-1]
    out = np.zeros((len(y),) * shape)
    function(problem, y.copy(), out, 1)
    walls = timeit.repeat(lambda: function(problem, y.copy(), out, count), repeat=repeat, number=1)
    return 1e6 * statistics.median(walls) / count


def integration(system, repeat):
    """Median time of the integration alone, from the initial state [s]."""
    runner = Runner(system)
    run = partial(runner.run, 0.0, runner.start, 0.0, 10**6)
    return statistics.median(timeit.repeat(run, repeat=repeat, number=1))


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--repeat", type=int, default=15)
    options = parser.parse_args()
    system = load(Path(__file__).with_name("seven_bar_fast.toml"), {"duration": 1.0})
    print(f"seven-bar: right-hand side {each(evaluate, system, 1, 20_000, options.repeat):.2f} us")
    print(f"seven-bar: residual        {each(leave, system, 1, 20_000, options.repeat):.2f} us")
    print(f"seven-bar: Jacobian        {each(differentiate, system, 2, 2_000, options.repeat):.2f} us")
    exact = seven_bar_reference.reference(system)
    print("\naccuracy    steps   wall [ms/s]   orbit error")
    for accuracy in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10):
        changed = system.replaced({"solver.accuracy": accuracy})
        wall = 1e3 * integration(changed, options.repeat)
        result = simulate(changed)
        times = np.linspace(0.0, 1.0, 501)
        columns = result.evaluate(times)
        orbit = np.array([[columns[f"{name}.ex"], columns[f"{name}.ey"]] for name in "AB"]).transpose(2, 0, 1)
        error = seven_bar_reference.orbit_error(orbit, exact(times))
        print(f"{accuracy:8.0e}{result.provenance['steps']:9d}{wall:14.3f}{error:14.1e}")


if __name__ == "__main__":
    main()
