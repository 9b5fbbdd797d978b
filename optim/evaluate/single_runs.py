"""Requests answered by one run after the other: on Drake, of the ideal linkage, over the service life."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from linkages import AssemblyError, InputError, RunError, Status, System, Trajectory, extremes, ideal, simulate
from linkages.mechanics.integrate.peak_search import average
from linkages.results.extremes import averages
from linkages.results.outputs.columns import Columns
from linkages.results.outputs.registry import IDEAL, JITTER, TURNING
from optim.evaluate.evaluations import NO_VALUE, OK
from optim.evaluate.requests import STATISTICS, Request, Statistics
from optim.problem.schema import LIFE, ServiceLife
from optim.problem.study import Array

#: Samples of a window; extremes are taken from the samples, so windows should not be much longer than a revolution.
SAMPLES = 2001


def run_on_drake(request: Request, progress: Callable[[float], None] | None = None) -> Statistics:
    """Run the designs of a request on Drake: the slow, independent way; KeyboardInterrupt if one was interrupted.

    `progress` is called with the simulated time of all runs so far [s].
    """

    def statistics(i: int, system: System) -> Array:
        before = i * request.point.system.settings.duration
        return _of_drake(request, system, progress and (lambda time: progress(before + time)))

    return _run_each(request, statistics)


def run_ideal(request: Request) -> Statistics:
    """Sample the motion of the linkage without clearance (``ideal.`` names): kinematics and inverse dynamics, no run.

    A journal with play leans where the force presses it; where the direction of the force turns fast
    (``ideal.JOINT.turning_rate``) it loses touch, flies across and strikes.
    """
    return _run_each(request, lambda _, system: _of_ideal(request, system))


def run_lives(request: Request, lives: Mapping[str, ServiceLife]) -> Statistics:
    """Wear the designs of a request (``life.`` names), each by its own jumps; KeyboardInterrupt as `run_on_drake`.

    A service life, of `lives` by name, is one number: each of `STATISTICS`, in each window.
    """
    wanted = [lives[name.removeprefix(LIFE)] for name in request.outputs]

    def statistics(_: int, system: System) -> Array:
        numbers = np.array([cycles_of(system, life) for life in wanted])
        return np.broadcast_to(numbers, (len(STATISTICS), len(request.windows), len(wanted)))

    return _run_each(request, statistics)


def _run_each(request: Request, statistics: Callable[[int, System], Array]) -> Statistics:
    """Run the designs of a request one after the other; one that fails has a status.

    `statistics` gets a design's number and system, and returns `STATISTICS` of each output in each window, (4, nw, no),
    or raises InputError or RunError.
    """
    m = len(request.values)
    found = np.full((len(STATISTICS), m, len(request.windows), len(request.outputs)), np.nan)
    status, reason = [OK] * m, [""] * m
    for i, line in enumerate(request.values):
        try:
            values = dict(zip(request.point.paths, map(float, line), strict=True))
            found[:, i] = statistics(i, request.point.system.replaced(values))
        except InputError as problem:
            status[i], reason[i] = Status.BAD_INPUT.value, str(problem)
        except AssemblyError as problem:
            status[i], reason[i] = problem.status.value, str(problem)
        except RunError as problem:
            status[i], reason[i] = NO_VALUE, str(problem)
    return Statistics(found, status, reason)


def _of_drake(request: Request, system: System, progress: Callable[[float], None] | None) -> Array:
    """`STATISTICS` of each output in each window, (4, nw, no)."""
    outputs = request.outputs
    run = simulate(system, "drake", progress)
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    exact = ideal(system) if any(name.endswith(JITTER) for name in outputs) else run
    signals = _signals(run, exact, outputs)
    whole = Trajectory(run.time, signals(run.time), run.status, {}, signals, jumps=run.jumps)
    found = np.empty((len(STATISTICS), len(request.windows), len(outputs)))
    for w, (start, end) in enumerate(request.windows):
        window = whole.within(start, min(end, run.time[-1]))
        extreme = extremes(window, outputs)
        for k, name in enumerate(outputs):
            found[:, w, k] = extreme[name].min, extreme[name].max, *averages(window, name)
    return found


def _signals(run: Trajectory, exact: Trajectory, outputs: tuple[str, ...]) -> Callable[[Array], Columns]:
    """Return what computes the outputs at any times: columns of the run, and jitter, its distance from the ideal."""
    of_run, of_exact = _dense(run), _dense(exact)

    def evaluate(times: Array) -> Columns:
        real = run.columns if times is run.time else of_run(times)  # at the steps they are known
        smooth = of_exact(times) if exact is not run else {}
        found = {"time": times}
        for name in outputs:
            plain = name.removesuffix(JITTER)
            found[name] = real[plain] - smooth[plain] if plain != name else real[plain]
        return found

    return evaluate


def _of_ideal(request: Request, system: System) -> Array:
    """`STATISTICS` of each output in each window, (4, nw, no)."""
    evaluate = _dense(ideal(system, "compiled"))
    found = np.empty((len(STATISTICS), len(request.windows), len(request.outputs)))
    for w, (start, end) in enumerate(request.windows):
        times = np.linspace(start, end, SAMPLES)
        columns = evaluate(times)
        for k, output in enumerate(request.outputs):
            name = output.removeprefix(IDEAL)
            owner, _, what = name.rpartition(".")
            turning = what == TURNING
            y = turning_rate(columns[f"{owner}.fx"], columns[f"{owner}.fy"], times) if turning else columns[name]
            found[:, w, k] = y.min(), y.max(), average(times, y, False), average(times, y, True)
    return found


def _dense(run: Trajectory) -> Callable[[Array], Columns]:
    """Return the dense output of a run; AssemblyError if it did not reach its end."""
    if run.status is not Status.OK:
        raise AssemblyError(run.status, f"ended at t = {run.time[-1]:.6g} s")
    assert run.evaluate is not None  # set by every engine
    return run.evaluate


def turning_rate(fx: Array, fy: Array, times: Array) -> Array:
    """Rate of the angle of a vector from samples of its components, by splines; infinite where it vanishes [rad/s]."""
    from scipy.interpolate import CubicSpline  # a tenth of a second, for few studies

    ax, ay = (CubicSpline(times, f)(times, 1) for f in (fx, fy))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((fx * ay - fy * ax) / (fx**2 + fy**2))


def cycles_of(system: System, life: ServiceLife) -> float:
    """Compute the service life, at most the limit of simulated cycles; AssemblyError if a block failed before."""
    from linkages import wear_life  # for few studies

    found = wear_life(
        system,
        int(life.cycles),
        life.tolerance,
        life.scatter,
        life.drive,
        enough=lambda so_far: so_far.history(life.until)[1][-1] > life.limit,
    )
    if found.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    until = found.cycles_until(life.until, life.limit)
    if until == float("inf") and found.status is not Status.OK:
        raise AssemblyError(found.status, f"ended after {found.cycles[-1]:,} cycles")
    return min(until, life.cycles)
