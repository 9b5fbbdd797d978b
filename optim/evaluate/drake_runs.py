"""Runs of designs on Drake, with the statistics that functionals are made of: the slow, independent way."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial.legendre import leggauss

from linkages import AssemblyError, Status, System, Trajectory, extremes, ideal, simulate
from linkages.outputs.columns import Columns
from linkages.outputs.registry import JITTER
from optim.evaluate.requests import STATISTICS, Request, Statistics, run_each, statistics_of, trapezia
from optim.problem.study import Array

_NODES, _WEIGHTS = leggauss(4)
_MANY = 5000  # steps, from which on they are short by themselves: explicit ones through impacts


def run_on_drake(request: Request, progress: Callable[[float], None] | None = None) -> Statistics:
    """Run the designs of a request on Drake, one after the other.

    Parameters
    ----------
    request : Request
    progress : callable, optional
        Called with the simulated time of all runs so far [s].

    Raises
    ------
    KeyboardInterrupt
        If a run was interrupted.
    """

    def statistics(i: int, system: System) -> Array:
        before = i * request.point.system.experiment.duration
        return _statistics(request, system, progress and (lambda time: progress(before + time)))

    return run_each(request, statistics)


def _statistics(request: Request, system: System, progress: Callable[[float], None] | None) -> Array:
    """`STATISTICS` of each output in each window, (4, nw, no).

    Raises
    ------
    AssemblyError
        Also if the run does not reach its end.
    """
    outputs = request.outputs
    run = simulate(system, "drake", progress)
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    exact = ideal(system) if any(name.endswith(JITTER) for name in outputs) else run
    for part in (run, exact):
        if part.status is not Status.OK:
            raise AssemblyError(part.status, f"ended at t = {part.time[-1]:.6g} s")
    signals = _signals(run, exact, outputs)
    columns = signals(run.time)
    edges = np.setdiff1d(np.minimum(request.windows, run.time[-1]), run.time)
    if len(edges):
        order = np.argsort(np.concatenate([run.time, edges]))
        between = signals(edges)
        columns = {name: np.concatenate([x, between[name]])[order] for name, x in columns.items()}
    found = np.empty((len(STATISTICS), len(request.windows), len(outputs)))
    for w, (start, end) in enumerate(request.windows):
        inside = (columns["time"] >= start) & (columns["time"] <= end)
        within = {name: x[inside] for name, x in columns.items()}
        window = Trajectory(within["time"], within, run.status, {}, signals)
        extreme = extremes(window, outputs)
        nodes, weights = _quadrature(window.time)
        values = window.columns if nodes is window.time else signals(nodes)
        for k, name in enumerate(outputs):
            found[:, w, k] = statistics_of(values[name], weights, extreme[name].min, extreme[name].max)
    return found


def _quadrature(steps: Array) -> tuple[Array, Array]:
    """Return times and weights of a mean over time: Gauss's in each step; trapezia if there are very many."""
    if len(steps) > _MANY:
        return steps, trapezia(steps)
    half = np.diff(steps)[:, None] / 2.0
    return (steps[:-1, None] + half * (1.0 + _NODES)).ravel(), (half * _WEIGHTS).ravel() / (steps[-1] - steps[0])


def _signals(run: Trajectory, exact: Trajectory, outputs: tuple[str, ...]) -> Callable[[Array], Columns]:
    """Return what computes the outputs at any times: columns of the run, and jitter, its distance from the ideal."""
    assert run.evaluate is not None
    assert exact.evaluate is not None
    of_run, of_exact = run.evaluate, exact.evaluate

    def evaluate(times: Array) -> Columns:
        real = run.columns if times is run.time else of_run(times)  # at the steps they are known
        smooth = of_exact(times) if exact is not run else {}
        found = {"time": times}
        for name in outputs:
            plain = name.removesuffix(JITTER)
            found[name] = real[plain] - smooth[plain] if plain != name else real[plain]
        return found

    return evaluate
