"""Estimate the gain of four designs side by side in vector registers: ``python benchmarks/lanes.py [--groups N]``.

Four designs of the press (``seven_bar_fast.toml``, 2 s) would be integrated at once, with one design in each lane of
`linkages.base.kernel.simd`. The script measures the parts of the present run and the part of each that lanes can share:

- the balance of forces is measured in lanes; the kinematics count with the same gain, although their sines and cosines
  are functions that lanes do not have;
- laws of joints have branches and are evaluated design by design;
- the directions of the Jacobian and the linear systems are side by side already, by columns and stages.

Groups of four of random designs show the work that lanes waste: with separate steps a group makes as many evaluations
as the design with most of them; with common steps each step is the smallest of the four.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path

import numpy as np
from batch import MASS, OIL, table
from compiled import TIME, leave

import linkages
from linkages.base.kernel import kernel
from linkages.base.kernel.by_reference import packed, reference
from linkages.base.kernel.simd import WIDTH, lane_array
from linkages.engines.compiled.run.equations import set_state
from linkages.engines.compiled.run.runner import Runner
from linkages.engines.compiled.simulation import simulate
from linkages.mechanics.planar.kinematics import body_states
from linkages.mechanics.planar.newton_euler import force_residual

COUNT, REPEAT = 20_000, 9


@kernel
def kinematics(given, y, out, count):
    """Evaluate poses and velocities many times."""
    problem = reference(given)
    set_state(problem.model, problem.work, TIME, y)
    w = problem.work.dynamics
    for _ in range(count):
        body_states(problem.model.bodies, w.q, w.v, w.pose, w.vel)
        w.q[0] += 1e-30 * w.pose[1, 0]


@kernel
def forces(bodies, gravity, work, count):
    """Evaluate the balance of forces many times, of numbers or of lanes."""
    w = reference(work)
    for _ in range(count):
        force_residual(reference(bodies), gravity, w)


def spent(function, *arguments):
    """Median processor time of one evaluation [us]."""
    times = []
    for count in [1] + [COUNT] * REPEAT:
        begun = time.thread_time()
        function(*arguments, count)
        times.append(time.thread_time() - begun)
    return 1e6 * statistics.median(times[1:]) / COUNT


def in_lanes(work):
    """Return the workspace with lanes for the arrays that the balance of forces uses."""
    changed = {}
    for name in ("q", "v", "a", "tau", "pose", "vel", "acc", "wrench", "bias", "shape_bias"):
        numbers = getattr(work, name)
        changed[name] = lane_array(*numbers.shape)
        changed[name][...] = numbers[..., None]
    return work._replace(**changed)


def common_steps(grids):
    """Count the steps if each is the smallest that one of the runs makes at that time."""
    now, count = 0.0, 0
    while now < grids[0][-1] * (1.0 - 1e-12):
        places = [min(int(np.searchsorted(grid, now, side="right")), len(grid) - 1) for grid in grids]
        now += min(grid[k] - grid[k - 1] for grid, k in zip(grids, places, strict=True))
        count += 1
    return count


def main() -> None:
    """Print the parts, and the gain that remains."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--groups", type=int, default=10)
    options = parser.parse_args()
    system = linkages.load(Path(__file__).with_name("seven_bar_fast.toml"))
    run = simulate(system.replaced({"duration": TIME})).evaluate.function
    equations, y = run.runner.aside(), run.steps.states[-1]
    problem, out = equations, np.zeros(len(y))
    whole = spent(leave, problem, y.copy(), out)
    moved = spent(kinematics, problem, y.copy(), out)
    bodies, gravity, work = run.runner.model.bodies, run.runner.model.gravity, equations.work.dynamics
    alone = spent(forces, bodies, gravity, packed(work))
    together = spent(forces, bodies, gravity, packed(in_lanes(work)))
    gain = WIDTH * alone / together

    paths, runs = [MASS, OIL], []
    for row in table(paths, 4 * options.groups).tolist():
        runner = Runner(system.replaced(dict(zip(paths, row, strict=True))))
        begun = time.thread_time()
        record = runner.run(0.0, runner.start, 0.0, 10**7)
        runs.append((time.thread_time() - begun, record))
    total = 1e6 * statistics.median(each for each, _ in runs)
    evaluations = np.array([record.evaluations for _, record in runs]).reshape(-1, 4)
    steps = np.array([record.steps for _, record in runs]).reshape(-1, 4)
    groups = [[record.times for _, record in runs[4 * k : 4 * k + 4]] for k in range(options.groups)]
    separate = float(np.mean(evaluations.max(axis=1) / evaluations.mean(axis=1)))
    common = float(np.mean([common_steps(group) for group in groups] / steps.mean(axis=1)))
    saved = (alone + moved) * (1.0 - 1.0 / gain) * float(evaluations.mean()) / total
    print(f"residual {whole:.3f} us: kinematics {moved:.3f}, balance of forces {alone:.3f}")
    print(f"balance of forces of four designs in lanes {together:.3f} us: {gain:.2f} times as fast")
    print(
        f"run {total / 1000.0:.2f} ms; {evaluations.mean() * whole / total:.0%} of it residuals; lanes save {saved:.0%}"
    )
    print(f"evaluations with separate steps, over those of single runs: {separate:.3f}; steps, if common: {common:.3f}")
    faster = 1.0 / (1.0 - saved)
    print(f"speed-up at most: separate steps {faster / separate:.2f}, common steps {faster / common:.2f}")


if __name__ == "__main__":
    main()
