"""Runs of designs on Drake, with the statistics that functionals are made of: the slow, independent way."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from linkages.engines.study import ideal, simulate
from linkages.errors import Status
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Mechanism
from linkages.results.extremes import extremes
from linkages.results.trajectory import Trajectory
from linkages.system.assembly import AssemblyError
from optim.evaluate.requests import Batch, Statistics, run_each
from optim.problem.outputs import JITTER

Array = NDArray[np.float64]

_NODES, _WEIGHTS = leggauss(4)
_MANY = 5000  # steps, from which on they are short by themselves: explicit ones through impacts


def run_on_drake(batch: Batch, progress: Callable[[float], None] | None = None) -> Statistics:
    """Run designs on Drake, one after the other.

    Parameters
    ----------
    batch : Batch
    progress : callable, optional
        Called with the simulated time of all runs so far [s].

    Raises
    ------
    KeyboardInterrupt
        If a run was interrupted.
    """

    def statistics(i: int, mechanism: Mechanism, experiment: Experiment) -> Array:
        before = i * batch.point.experiment.duration
        report = None if progress is None else partial(_add, progress, before)
        return _statistics(batch, mechanism, experiment, report)

    return run_each(batch, statistics)


def _add(progress: Callable[[float], None], before: float, time: float) -> None:
    progress(before + time)


def _statistics(
    batch: Batch, mechanism: Mechanism, experiment: Experiment, progress: Callable[[float], None] | None
) -> Array:
    """Minimum, maximum, mean and rms of each output in each window, (4, nw, no).

    Raises
    ------
    AssemblyError
        Also if the run does not reach its end.
    """
    run = simulate(mechanism, experiment, "drake", progress)
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    exact = ideal(mechanism, experiment) if any(name.endswith(JITTER) for name in batch.outputs) else run
    for part in (run, exact):
        if part.status is not Status.OK:
            raise AssemblyError(part.status, f"ended at t = {part.time[-1]:.6g} s; {part.status.remedy}")
    signals = _signals(experiment, run, exact, batch.outputs)
    columns = signals(run.time)
    edges = np.setdiff1d(np.minimum(batch.windows, run.time[-1]), run.time)
    if len(edges):
        order = np.argsort(np.concatenate([run.time, edges]))
        between = signals(edges)
        columns = {name: np.concatenate([x, between[name]])[order] for name, x in columns.items()}
    found = np.empty((4, len(batch.windows), len(batch.outputs)))
    for w, (start, end) in enumerate(batch.windows):
        inside = (columns["time"] >= start) & (columns["time"] <= end)
        within = {name: x[inside] for name, x in columns.items()}
        window = Trajectory(within["time"], within, run.status, {}, signals)
        extreme = extremes(window, batch.outputs)
        nodes, weights = _quadrature(window.time)
        values = window.columns if nodes is window.time else signals(nodes)
        for k, name in enumerate(batch.outputs):
            y = values[name]
            found[:, w, k] = extreme[name].min, extreme[name].max, weights @ y, np.sqrt(weights @ y**2)
    return found


def _quadrature(steps: Array) -> tuple[Array, Array]:
    """Return times and weights of a mean over time: Gauss's in each step; trapezia if there are very many."""
    span, width = steps[-1] - steps[0], np.diff(steps)
    if len(steps) > _MANY:
        return steps, np.convolve(width, [0.5, 0.5]) / span
    half = width[:, None] / 2.0
    return (steps[:-1, None] + half * (1.0 + _NODES)).ravel(), (half * _WEIGHTS).ravel() / span


def _signals(
    experiment: Experiment, run: Trajectory, exact: Trajectory, outputs: tuple[str, ...]
) -> Callable[[Array], dict[str, Array]]:
    """Return what computes the outputs at any times: columns, and what is made of them."""
    assert run.evaluate is not None
    assert exact.evaluate is not None
    of_run, of_exact = run.evaluate, exact.evaluate
    at_steps = run.columns  # they need not be computed again
    jitter = any(name.endswith(JITTER) for name in outputs)

    def evaluate(times: Array) -> dict[str, Array]:
        real = at_steps if times is run.time else of_run(times)
        smooth = of_exact(times) if jitter else real
        found = {"time": times}
        for name in outputs:
            owner, _, what = name.rpartition(".")
            if name.endswith(JITTER):
                found[name] = real[owner] - smooth[owner]
            elif what == "film_thickness":
                clearance = experiment.joints[owner].clearance or 0.0
                found[name] = clearance - np.hypot(real[f"{owner}.ex"], real[f"{owner}.ey"])
            elif what == "power" and owner in experiment.drives:
                found[name] = real[f"{owner}.torque"] * real[f"{owner}.rate"]
            else:
                found[name] = real[name]
        return found

    return evaluate
