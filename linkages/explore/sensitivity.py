"""Derivatives of peaks, means and works of a run with respect to values, with marks where they mean less."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from linkages.base.arguments import Names, validated
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError, RunError, Status
from linkages.engines.assessment import simulate, tightened
from linkages.engines.compiled.batch.batch import simulate_batch
from linkages.engines.compiled.derivatives.neighbours import magnitude_of
from linkages.engines.compiled.effects import check_varied, near
from linkages.results.derivatives import MEANING, OK
from linkages.results.outputs.registry import default_outputs
from linkages.results.statistic_derivatives import Found, Wanted, differentiate_statistics, kink_weights
from linkages.results.trajectory import TimeReport, Trajectory
from linkages.results.validity import warning
from linkages.system import System

# Accuracy of the run that gives the errors, over the accuracy of the run; least accuracy of this kind; the ratio where
# the run has that accuracy already. Ten times is too little elsewhere: near kinks and with interpolated films both runs
# share a part of their errors.
_TIGHTER, _LEAST, _LITTLE = 1e-3, 1e-13, 0.1
_SAFETY = 1.5  # factor on the change, because the tighter run has an error too
_SHARED = 1e-6  # error that both runs share, in parts of a derivative: of differences of laws, of the times of peaks
_ROUNDING = 1e-11  # of the differences in derivatives, in parts of the number over the value's magnitude
_NEAR = 1e-3  # relative distance of two maxima whose order may change
_BESIDE = 1e-4  # distance from a peak at which it is tested, in parts of the local step
_SLOPE = 0.05  # of a parabola's own slope there: a steeper output has a jump, or a kink
_STATISTICS = ("peak", "mean", "rms")
#: Accuracy of runs whose derivatives err by less than 1 %, measured with the press (4 % at 1e-7).
NEEDED = 1e-9
_CHECK = 1e-3  # step of the differences that check derivatives, in parts of the value, or of its unit if it is zero


@dataclass(frozen=True, repr=False)
class Sensitivities(Brief):
    """Derivatives of a run's characteristic numbers.

    Attributes
    ----------
    values : dict of float
        The values by path, SI units.
    numbers : dict of float
        The numbers by key: ``A.force.peak``, ``slider.ax.mean``, ``slider.ax.rms``, ``O.work``.
    derivatives : dict of dict of float or None
        By path and key, in units of the number per unit of the value; None where there is none.
    errors : dict of dict of float or None
        Their errors: 1.5 times the sum of the change with a thousand times tighter accuracy and, for means, root mean
        squares and works, of the error of their quadrature within the steps.
    checks : dict of dict of float
        Differences of runs, by path and key of peaks; empty unless requested.
    warnings : list of dict
        As in ``summary.json``.
    run : Trajectory
    """

    values: dict[str, float]
    numbers: dict[str, float]
    derivatives: dict[str, dict[str, float | None]]
    errors: dict[str, dict[str, float | None]]
    checks: dict[str, dict[str, float]]
    warnings: list[dict[str, Any]]
    run: Trajectory

    def _facts(self) -> tuple[str, dict[str, str]]:
        line = f"{counted(len(self.numbers), 'number')}, {counted(len(self.values), 'value')}"
        return line, {"numbers": ", ".join(self.numbers), "values": ", ".join(self.values)}

    def per_cent(self, path: str, key: str) -> float | None:
        """Return the change of a number with a value that grows by 1 %, in parts of the number.

        None where there is no derivative, or the value or the number is zero.
        """
        rate, number = self.derivatives[path][key], self.numbers[key]
        return (
            None
            if rate is None or number == 0.0 or self.values[path] == 0.0
            else 0.01 * rate * self.values[path] / number
        )


@validated
def sensitivities(
    system: System,
    wrt: Names,
    outputs: Names | None = None,
    error_estimate: bool = True,
    check: bool = False,
    progress: Callable[[str], TimeReport] | None = None,
) -> Sensitivities:
    """Differentiate the peaks, means, root mean squares and works of a run with respect to values.

    Use `linkages.simulate` with ``wrt`` for derivatives over time.

    Parameters
    ----------
    system : System
    wrt : sequence of str
        Dotted paths of values.
    outputs : sequence of str, optional
        Default: the outputs of `simulate_batch`.
    error_estimate : bool
        Whether to repeat the run at a thousand times tighter accuracy.
    check : bool
        Whether to compute differences of runs of the fourth order as well.
    progress : callable, optional
        Called with the name of each stage; returns the stage's progress function.

    Raises
    ------
    InputError
        If a path or an output is not valid, or a model has no derivatives.
    RunError
        If the run does not reach its end.

    Examples
    --------
    >>> import linkages
    >>> system = linkages.load(linkages.find_file("slider_crank_lubricated.toml"), {"duration": 0.012})
    >>> found = linkages.sensitivities(system, ["drives.O.speed"], ["slider.ax"], error_estimate=False)
    >>> round(found.per_cent("drives.O.speed", "slider.ax.peak"), 4)
    0.0255
    """
    paths = tuple(dict.fromkeys(wrt))
    if not paths:
        raise InputError("argument", "wrt", "names no value; give dotted paths, such as joints.A.clearance")
    names = list(dict.fromkeys(default_outputs(system) if outputs is None else outputs))
    for path in paths:
        check_varied(system, path, near(system, path), "argument", names)
    stage = progress or (lambda name: lambda time: None)
    found = _Differentiated(system, paths, names, stage("run"))
    errors: dict[str, dict[str, float | None]] = {path: dict.fromkeys(found.numbers) for path in paths}
    if error_estimate:
        finer = _finer(system, found.run, paths, names, stage("error estimate"))
        errors = {path: _errors(found, finer, path, system.value(path)) for path in paths}
    checks = {path: _differences(system, path, names) for path in paths} if check else {}
    values = {path: system.value(path) for path in paths}
    return Sensitivities(values, found.numbers, found.derivatives, errors, checks, found.warnings, found.run)


def _finer(
    system: System, run: Trajectory, paths: Sequence[str], names: Sequence[str], progress: TimeReport
) -> _Differentiated:
    """Repeat a run with a tighter accuracy: ten times, if the integrator does not reach the accuracy that is wanted."""
    ratio = max(_TIGHTER, min(_LITTLE, _LEAST / system.experiment.solver.accuracy))
    try:
        return _Differentiated(tightened(system, run, ratio), paths, names, progress)
    except RunError:
        return _Differentiated(tightened(system, run, _LITTLE), paths, names, progress)


def _errors(found: _Differentiated, finer: _Differentiated, path: str, value: float) -> dict[str, float | None]:
    """Estimate the errors of derivatives: their change, but at least their rounding and a part that both runs share."""
    errors: dict[str, float | None] = dict.fromkeys(found.numbers)
    for key, rate in found.derivatives[path].items():
        if rate is not None and (other := finer.derivatives[path][key]) is not None:
            rounding = _ROUNDING * abs(found.numbers[key]) / magnitude_of(path, value)
            change = abs(rate - other) + found.quadrature[path][key]
            errors[key] = max(_SAFETY * change, rounding, _SHARED * abs(rate))
    return errors


def _differences(system: System, path: str, names: Sequence[str]) -> dict[str, float]:
    """Differences of the fourth order of the peaks of runs, by key; NaN where a run fails."""
    value = system.value(path)
    step = _CHECK * magnitude_of(path, value)
    batch = simulate_batch(system, [path], [[value + k * step] for k in (-2, -1, 1, 2)], names)
    slopes = np.array([1 / 12, -2 / 3, 2 / 3, -1 / 12]) @ batch.peak[:, 0] / step
    return {f"{name}.peak": float(slope) for name, slope in zip(names, slopes, strict=True)}


class _Differentiated:
    """A run with the derivatives of its numbers."""

    def __init__(self, system: System, paths: Sequence[str], names: Sequence[str], progress: TimeReport) -> None:
        drives = list(system.experiment.drives)
        columns = [*names, *(f"{name}.power" for name in drives)]
        self.run = simulate(system, progress=progress, outputs=list(dict.fromkeys(columns)), wrt=paths)
        if self.run.status is not Status.OK:
            raise RunError(f"the run ended at t = {self.run.time[-1]:.6g} s: {self.run.status.value}")
        span = float(self.run.time[0]), float(self.run.time[-1])
        wanted = {f"{name}.{kind}": Wanted(name, kind, *span) for kind in _STATISTICS for name in names}
        wanted |= {f"{name}.work": Wanted(f"{name}.power", "integral", *span) for name in drives}
        found = dict(zip(wanted, differentiate_statistics(self.run, list(wanted.values()), errors=True), strict=True))
        found = {key: one for key, one in found.items() if one.number or not key.endswith(".rms")}
        self.numbers = {key: one.number for key, one in found.items()}
        self.derivatives: dict[str, dict[str, float | None]] = {
            path: {key: float(one.rates[k]) if math.isfinite(one.rates[k]) else None for key, one in found.items()}
            for k, path in enumerate(paths)
        }
        self.quadrature = {
            path: {key: 0.0 if one.quadrature is None else float(one.quadrature[k]) for key, one in found.items()}
            for k, path in enumerate(paths)
        }
        self.warnings = list(self._warnings({name: found[f"{name}.peak"] for name in names}))

    def _warnings(self, peaks: Mapping[str, Found]) -> Iterator[dict[str, Any]]:
        """Warn of peaks, by output, whose derivatives mean less, and of the end of the derivatives."""
        for name, peak in peaks.items():
            if (mark := _mark(self.run, name, peak.sign, peak.time)) is not None:
                what = f"the peak of {name} at t = {peak.time:.6g} s {mark}"
                yield warning("peak", peak.time, what, "compare with differences of runs (--check)")
        rates = self.run.sensitivity
        if rates.status != OK:
            what = f"derivatives end at t = {rates.until:.6g} s: {MEANING[rates.status]}"
            remedy = "give a duration up to there; derivatives of means, works and later peaks are null"
            yield warning("derivatives", rates.until, what, remedy)


def _mark(run: Trajectory, name: str, sign: float, time: float) -> str | None:
    """Return why the derivative of a peak means less than others; None if nothing is known against it."""
    values, times = sign * run[name], run.time
    if time in (times[0], times[-1]):
        return "is at an end of the run: its derivative is that at this fixed time"
    assert run.evaluate is not None
    k = min(max(int(np.searchsorted(times, time)), 1), len(times) - 1)
    h = _BESIDE * (times[k] - times[k - 1])
    around = np.clip(time + h * np.array([-2.0, -1.0, 0.0, 1.0, 2.0]), times[0], times[-1])
    beside = sign * run.evaluate(around)[name]
    left, right = (beside[1] - beside[0]) / h, (beside[4] - beside[3]) / h
    usual = (np.ptp(values) or 1.0) / (times[k] - times[k - 1])
    kink = np.isfinite(kink_weights(run, [((name, times[0], times[-1]), time)])).all()
    if max(abs(left), abs(right)) > _SLOPE * usual and not kink:
        return "is at a jump: its time changes with the values, which its derivative does not include"
    inner = values[1:-1]
    tops = np.flatnonzero((inner >= values[:-2]) & (inner > values[2:])) + 1
    away = tops[np.abs(tops - k) > 2]
    if len(away) and values[away].max() > (1.0 - _NEAR) * beside[2]:
        other = times[away[np.argmax(values[away])]]
        return f"is as high as another one at t = {other:.6g} s: beyond a small change of the values that one counts"
    return None
