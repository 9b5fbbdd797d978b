"""Runs of designs on Drake, with the statistics that functionals are made of: the slow, independent way."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from linkages import AssemblyError, Status, System, Trajectory, extremes, ideal, simulate
from linkages.results.extremes import averages
from linkages.results.outputs.columns import Columns
from linkages.results.outputs.registry import JITTER
from optim.evaluate.requests import STATISTICS, Request, Statistics, run_each
from optim.problem.study import Array


def run_on_drake(request: Request, progress: Callable[[float], None] | None = None) -> Statistics:
    """Run the designs of a request on Drake, one after the other; KeyboardInterrupt if a run was interrupted.

    `progress` is called with the simulated time of all runs so far [s].
    """

    def statistics(i: int, system: System) -> Array:
        before = i * request.point.system.experiment.duration
        return _statistics(request, system, progress and (lambda time: progress(before + time)))

    return run_each(request, statistics)


def _statistics(request: Request, system: System, progress: Callable[[float], None] | None) -> Array:
    """`STATISTICS` of each output in each window, (4, nw, no); AssemblyError if the run does not reach its end."""
    outputs = request.outputs
    run = simulate(system, "drake", progress)
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    exact = ideal(system) if any(name.endswith(JITTER) for name in outputs) else run
    for part in (run, exact):
        if part.status is not Status.OK:
            raise AssemblyError(part.status, f"ended at t = {part.time[-1]:.6g} s")
    signals = _signals(run, exact, outputs)
    whole = Trajectory(run.time, signals(run.time), run.status, {}, signals)
    found = np.empty((len(STATISTICS), len(request.windows), len(outputs)))
    for w, (start, end) in enumerate(request.windows):
        window = whole.within(start, min(end, run.time[-1]))
        extreme = extremes(window, outputs)
        for k, name in enumerate(outputs):
            found[:, w, k] = extreme[name].min, extreme[name].max, *averages(window, name)
    return found


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
