"""Wall time and orbit error of the seven-bar on Drake: ``python benchmarks/sevenbar_drake.py [--repeat N]``.

For several accuracies and largest steps: wall seconds per simulated second (median; build of the diagram and
evaluation of the columns not counted), derivative evaluations, time per evaluation, and the largest difference of a
journal's orbit from a solution at 1e-9, in parts of the largest eccentricity. The reference integrates the same laws
and kinematics with SciPy's Radau, cranks eliminated.
"""

from __future__ import annotations

import argparse
import statistics
import time

import numpy as np
from pydrake.systems.analysis import Simulator
from scipy.integrate import solve_ivp

from linkages.assembly import assemble
from linkages.data import data_folder
from linkages.drake import build_diagram
from linkages.drake.simulation import _advance, _set_up, _Watch
from linkages.experiment import load
from linkages.joint_parameters import film_tables, law_parameters
from linkages.planar.clearance import WIDTH, clearance_wrenches
from linkages.planar.dynamics import constrained_dynamics
from linkages.planar.kinematics import body_positions, body_velocities


def reference(mechanism, experiment):
    """Return the eccentricities (nt, nj, 2) over time at a tolerance of 1e-10."""
    assembly = assemble(mechanism, experiment)
    tree = assembly.tree
    laws, nb = law_parameters(tree, experiment), len(tree.bodies)
    tables, memory = film_tables(tree, experiment), np.zeros((len(tree.play), 2))
    free = np.setdiff1d(np.arange(tree.size), tree.driven_dofs)
    gravity = mechanism.basis[:, :2].T @ np.array(experiment.gravity)

    def state(t, y):
        q, v, a = np.zeros(tree.size), np.zeros(tree.size), np.zeros(tree.size)
        q[free], v[free] = y[: len(free)], y[len(free) :]
        for target, values in zip((q, v, a), assembly.motions(np.array([t])), strict=True):
            target[tree.driven_dofs] = values[0]
        pose, vel, wrench = np.empty((nb, 5)), np.empty((nb, 3)), np.zeros((nb, 3))
        joints = np.empty((len(tree.play), WIDTH))
        body_positions(tree.bodies, q, pose)
        body_velocities(tree.bodies, pose, v, vel)
        clearance_wrenches(tree.ends, laws, tables, memory, pose, vel, wrench, joints)
        constrained_dynamics(
            tree.bodies, tree.loop_rows, 0.0, gravity, q, v, wrench, np.zeros(tree.size), a, np.empty(0)
        )
        return np.concatenate([v[free], a[free]]), joints

    start = np.concatenate([assembly.q[free], assembly.v[free]])
    run = solve_ivp(
        lambda t, y: state(t, y)[0], (0.0, experiment.duration), start, method="Radau", rtol=1e-10, atol=1e-13,
        dense_output=True,
    )  # fmt: skip
    return lambda times: np.array([state(t, run.sol(t))[1][:, :2] for t in times])


def one_run(mechanism, experiment):
    """Integrate once; returns wall seconds, evaluations, step times and eccentricities there."""
    diagram, linkage = build_diagram(mechanism, experiment)
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    linkage.set_initial_state(root)
    integrator = _set_up(simulator, experiment)
    watch = _Watch(linkage, experiment, None)
    simulator.set_monitor(watch)
    start = time.perf_counter()
    _advance(simulator, integrator, watch, experiment.duration)
    wall = time.perf_counter() - start
    evaluations = watch.evaluations + integrator.get_num_derivative_evaluations()
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
    parser.add_argument("--file", default=str(data_folder() / "seven_bar.toml"))
    options = parser.parse_args()
    mechanism, experiment = load(options.file, {"duration": 1.0})
    exact = reference(mechanism, experiment)
    print("radau3   accuracy  max step   wall [s/s]   evaluations   us/evaluation   orbit error")
    for accuracy in (1e-5, 1e-6, 1e-7, 1e-8):
        for step in (5e-3, 2e-3, 1e-3):
            changed = experiment.replaced({"solver.accuracy": accuracy, "solver.max_step": step})
            runs = [one_run(mechanism, changed) for _ in range(options.repeat)]
            wall = statistics.median(run[0] for run in runs)
            _, evaluations, times, orbit = runs[0]
            truth = exact(times)
            size = np.hypot(*truth.transpose(2, 0, 1)).max(axis=0)
            error = (np.hypot(*(orbit - truth).transpose(2, 0, 1)).max(axis=0) / size).max()
            each = 1e6 * wall / evaluations
            print(f"{accuracy:17.0e}{step:10.0e}{wall:13.3f}{evaluations:14d}{each:16.1f}{error:14.1e}")


if __name__ == "__main__":
    main()
