"""Derivatives of peaks, means and works of a run with respect to values, with marks where they mean less."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from linkages.base.arguments import Names, validated, vector
from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError, RunError, Status
from linkages.engines.assessment import simulate
from linkages.engines.compiled.batch.batch import run_batch
from linkages.engines.compiled.derivatives.neighbours import magnitude_of
from linkages.engines.compiled.effects import check_varied, near
from linkages.engines.repetition import tightened
from linkages.explore.numerics import (
    SENSITIVITY_CHECK,
    SENSITIVITY_NEAR,
    SENSITIVITY_ROUNDING,
    SENSITIVITY_SAFETY,
    SENSITIVITY_SHARED,
)
from linkages.explore.prediction import STATED, finer, numbers_of, reaches, warnings_of
from linkages.results.derivatives import MEANING, OK
from linkages.results.outputs.registry import default_outputs
from linkages.results.shape import RunWarning
from linkages.results.statistic_derivatives import Found, Wanted, differentiate_statistics
from linkages.results.trajectory import TimeReport, Trajectory
from linkages.results.validity import warning
from linkages.system import System

# Accuracy of the run that gives the errors, over the accuracy of the run; least accuracy of this kind; the ratio where
# the run has that accuracy already. Ten times is too little elsewhere: near kinks and with interpolated films both runs
# share a part of their errors.
_TIGHTER, _LEAST, _LITTLE = 1e-3, 1e-13, 0.1
_STATISTICS = ("peak", "mean", "rms")
#: Accuracy of runs whose derivatives err by less than 1 %, measured with the press (4 % at 1e-7).
NEEDED = 1e-9


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
    warnings : list of RunWarning
        As in ``summary.json``.
    run : Trajectory
    window : (float, float)
        Begin and end of the part of the run that the numbers are about [s].
    times : dict of float
        Times of peaks by key [s].
    reach : dict of dict of float
        By path and key how far a derivative predicts, in parts of the value, see `linkages.explore.prediction`; empty
        unless requested.
    """

    values: dict[str, float]
    numbers: dict[str, float]
    derivatives: dict[str, dict[str, float | None]]
    errors: dict[str, dict[str, float | None]]
    checks: dict[str, dict[str, float]]
    warnings: list[RunWarning]
    run: Trajectory
    window: tuple[float, float]
    times: dict[str, float]
    reach: dict[str, dict[str, float]] = field(default_factory=dict)

    def _facts(self) -> tuple[str, dict[str, str]]:
        line = f"{counted(len(self.numbers), 'number')}, {counted(len(self.values), 'value')}"
        return line, {"numbers": ", ".join(self.numbers), "values": ", ".join(self.values)}

    def per_cent(self, path: str, key: str) -> float | None:
        """Return the change of a number with a value that grows by 1 %, in parts of the number.

        None where there is no derivative or it does not predict this change, or the value or the number is zero.
        """
        rate, number = self.derivatives[path][key], self.numbers[key]
        if rate is None or number == 0.0 or self.values[path] == 0.0 or self.reaches(path, key) < STATED:
            return None
        return STATED * rate * self.values[path] / number

    def reaches(self, path: str, key: str) -> float:
        """Return how far a derivative predicts, in parts of the value; at least `STATED` if that is not examined."""
        return self.reach[path].get(key, 0.0) if self.reach else STATED


@validated
def sensitivities(
    system: System,
    wrt: Names,
    outputs: Names | None = None,
    error_estimate: bool = True,
    check: bool = False,
    progress: Callable[[str], TimeReport] | None = None,
    window: Annotated[Sequence[float] | Array, vector] | None = None,
    reach: bool = True,
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
    window : (2,) array_like, optional
        Begin and end of the part of the run that the numbers are about [s]. Default: the whole run;
        `Assessment.reported_span` is the part of tables.
    reach : bool
        Whether to find how far the derivatives predict, by 6 to 26 runs for each value.

    Raises
    ------
    InputError
        If a path, an output or the window is not valid, or a model has no derivatives.
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
    span = (0.0, system.settings.duration) if window is None else (float(window[0]), float(window[-1]))
    found = _Differentiated(system, paths, names, span, stage("run"))
    errors: dict[str, dict[str, float | None]] = {path: dict.fromkeys(found.numbers) for path in paths}
    if error_estimate:
        repeated = _finer(system, found, paths, names, stage("error estimate"))
        errors = {path: _errors(found, repeated, path, system.value(path)) for path in paths}
    checks = {path: _differences(system, path, names, span) for path in paths} if check else {}
    values = {path: system.value(path) for path in paths}
    examined = _reach(system, found, values, names, stage("reach")) if reach else {}
    warnings = [*found.warnings, *warnings_of(examined)]
    about = span, found.times, examined
    return Sensitivities(values, found.numbers, found.derivatives, errors, checks, warnings, found.run, *about)


def _reach(
    system: System, found: _Differentiated, values: Mapping[str, float], names: Sequence[str], progress: TimeReport
) -> dict[str, dict[str, float]]:
    """Find how far the derivatives of numbers predict, by path and key; without an entry where there is none."""
    span, keys = found.span, list(found.numbers)
    outputs = list(dict.fromkeys([*names, *(f"{name}.power" for name in system.drives)]))

    def numbers(table: Array, tight: bool) -> Array:
        """Make the numbers (m, nk) of runs with values (m, np)."""
        one = finer(system) if tight else system
        done = lambda share: progress(share * system.settings.duration)  # noqa: E731
        return numbers_of(run_batch(one, [*values], table, outputs, [span], progress=done), keys)

    rates = np.array([[found.derivatives[path][key] for key in keys] for path in values], dtype=float)
    table = reaches(values, rates, np.array([found.scales[key] for key in keys]), numbers)
    lines = {path: dict(zip(keys, line.tolist(), strict=True)) for path, line in zip(values, table, strict=True)}
    return {path: {key: one for key, one in line.items() if not math.isnan(one)} for path, line in lines.items()}


def _finer(
    system: System, found: _Differentiated, paths: Sequence[str], names: Sequence[str], progress: TimeReport
) -> _Differentiated:
    """Repeat a run with a tighter accuracy: ten times, if the integrator does not reach the accuracy that is wanted."""
    ratio = max(_TIGHTER, min(_LITTLE, _LEAST / system.settings.accuracy))
    try:
        return _Differentiated(tightened(system, found.run, ratio), paths, names, found.span, progress)
    except RunError:
        return _Differentiated(tightened(system, found.run, _LITTLE), paths, names, found.span, progress)


def _errors(found: _Differentiated, finer: _Differentiated, path: str, value: float) -> dict[str, float | None]:
    """Estimate the errors of derivatives: their change, but at least their rounding and a part that both runs share."""
    errors: dict[str, float | None] = dict.fromkeys(found.numbers)
    for key, rate in found.derivatives[path].items():
        if rate is not None and (other := finer.derivatives[path][key]) is not None:
            rounding = SENSITIVITY_ROUNDING * abs(found.numbers[key]) / magnitude_of(path, value)
            change = abs(rate - other) + found.quadrature[path][key]
            errors[key] = max(SENSITIVITY_SAFETY * change, rounding, SENSITIVITY_SHARED * abs(rate))
    return errors


def _differences(system: System, path: str, names: Sequence[str], span: tuple[float, float]) -> dict[str, float]:
    """Differences of the fourth order of the peaks of runs, by key; NaN where a run fails."""
    value = system.value(path)
    step = SENSITIVITY_CHECK * magnitude_of(path, value)
    batch = run_batch(system, [path], [[value + k * step] for k in (-2, -1, 1, 2)], names, [span])
    slopes = np.array([1 / 12, -2 / 3, 2 / 3, -1 / 12]) @ batch.peak[:, 0] / step
    return {f"{name}.peak": float(slope) for name, slope in zip(names, slopes, strict=True)}


class _Differentiated:
    """A run with the derivatives of its numbers."""

    def __init__(
        self,
        system: System,
        paths: Sequence[str],
        names: Sequence[str],
        span: tuple[float, float],
        progress: TimeReport,
    ) -> None:
        drives = list(system.drives)
        columns = [*names, *(f"{name}.power" for name in drives)]
        self.run = simulate(system, progress=progress, outputs=list(dict.fromkeys(columns)), wrt=paths)
        if self.run.status is not Status.OK:
            raise RunError(f"the run ended at t = {self.run.time[-1]:.6g} s: {self.run.status.value}")
        self.span, self.part = span, self.run.within(*span)
        wanted = {f"{name}.{kind}": Wanted(name, kind, *span) for kind in _STATISTICS for name in names}
        wanted |= {f"{name}.work": Wanted(f"{name}.power", "integral", *span) for name in drives}
        found = dict(zip(wanted, differentiate_statistics(self.run, list(wanted.values()), errors=True), strict=True))
        found = {key: one for key, one in found.items() if one.number or not key.endswith(".rms")}
        self.numbers = {key: one.number for key, one in found.items()}
        self.derivatives: dict[str, dict[str, float | None]] = {
            path: {key: float(one.rates[k]) if math.isfinite(one.rates[k]) else None for key, one in found.items()}
            for k, path in enumerate(paths)
        }
        self.times = {key: one.time for key, one in found.items() if key.endswith(".peak")}
        self.scales = {key: self._scale(*key.rsplit(".", 1)) for key in found}
        self.quadrature = {
            path: {key: 0.0 if one.quadrature is None else float(one.quadrature[k]) for key, one in found.items()}
            for k, path in enumerate(paths)
        }
        self.warnings = list(self._warnings({name: found[f"{name}.peak"] for name in names}))

    def _scale(self, name: str, kind: str) -> float:
        """Return the magnitude of a number: the peak of its output, of a work the peak of the power times its time."""
        output, factor = (f"{name}.power", self.span[1] - self.span[0]) if kind == "work" else (name, 1.0)
        return factor * float(np.abs(self.part[output]).max())

    def _warnings(self, peaks: Mapping[str, Found]) -> Iterator[RunWarning]:
        """Warn of peaks, by output, whose derivatives mean less, and of the end of the derivatives."""
        for name, peak in peaks.items():
            if (mark := _mark(self.part, name, peak)) is not None:
                what = f"the peak of {name} at t = {peak.time:.6g} s {mark}"
                yield warning("peak", peak.time, what, "compare with differences of runs (--check)")
        rates = self.run.sensitivity
        if rates.status != OK:
            what = f"derivatives end at t = {rates.until:.6g} s: {MEANING[rates.status]}"
            remedy = "give a duration up to there; derivatives of means, works and later peaks are null"
            yield warning("derivatives", rates.until, what, remedy)


def _mark(run: Trajectory, name: str, peak: Found) -> str | None:
    """Return why the derivative of a peak means less than others; None if nothing is known against it."""
    values, times, time = peak.sign * run[name], run.time, peak.time
    if time in (times[0], times[-1]):
        return "is at an end of its part of the run: its derivative is that at this fixed time"
    k = min(max(int(np.searchsorted(times, time)), 1), len(times) - 1)
    if peak.jump:
        return "is at a jump: its time changes with the values, which its derivative does not include"
    inner = values[1:-1]
    tops = np.flatnonzero((inner >= values[:-2]) & (inner > values[2:])) + 1
    away = tops[np.abs(tops - k) > 2]
    if len(away) and values[away].max() > (1.0 - SENSITIVITY_NEAR) * peak.number:
        other = times[away[np.argmax(values[away])]]
        return f"is as high as another one at t = {other:.6g} s: beyond a small change of the values that one counts"
    return None
