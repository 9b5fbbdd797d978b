"""Exploring around the run that is shown: sweeps of a value, sensitivities and tolerances, as batches of runs like it.

The runs start where the shown one did, in parts of their clearances, and are summarised over the same part of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import ARGUMENT, InputError, Status
from linkages.engines.compiled.batch.batch import Batch, run_batch
from linkages.engines.compiled.effects import check_varied, near, varied
from linkages.explore.prediction import STATED, WHY, extent, finer, numbers_of, reaches
from linkages.results.characteristics import peaks_of_models
from linkages.results.derivatives import MEANING, OK
from linkages.results.outputs.registry import default_outputs, unit
from linkages.show.live.controls import Control
from linkages.show.live.session import Session
from linkages.show.live.view import FRAMES
from linkages.show.naming import output_in_words
from linkages.show.plots.pages import short
from linkages.show.plots.presentation import shown
from linkages.system import System

SPREAD = 1.0 / 300.0  # of a value without another one: deviation over the value; three deviations are 1 %
MOST_RUNS, _MOST_PATHS = 5000, 40
_WHY = (
    "-: no statement about 1 % is possible. The row tells up to which change of the value the derivative predicts the"
    " peak, or why there is none: {}."
)
_QUANTILES = 5.0, 50.0, 95.0  # [%]
_SAMPLES, _MOST_SAMPLES = 2401, 20_000_000  # of a curve of a band, of all curves of all runs


@dataclass(frozen=True)
class Around:
    """The run of a page that others are compared with."""

    system: System
    start: float  # of the part that is summarised [s]
    end: float
    drawn: tuple[float, float]  # the part whose curves the page draws [s]

    @classmethod
    def of(cls, session: Session, values: Mapping[str, Any], outdated: Callable[[], bool]) -> Around:
        """Take the run that a page shows for values; a new one, if others were shown since."""
        (start, end), drawn = session.part_shown(values, outdated), session.part_drawn()
        return cls(session.system.replaced(session.values_shown(values)), start, end, drawn)

    def acting(self, paths: Sequence[str]) -> tuple[list[str], dict[str, str]]:
        """Return the paths that change a number of the run, and the reasons of the others; InputError without any."""
        found = {path: varied(self.system, path, near(self.system, path), outputs_of(self.system)) for path in paths}
        if all(found.values()):
            raise InputError(ARGUMENT, *next(iter(found.items())))
        return [path for path in paths if not found[path]], {path: why for path, why in found.items() if why}

    def batch(self, paths: Sequence[str], table: Array, progress: Callable[[float], None], **options: Any) -> Batch:
        """Run for a table of values; a journal whose clearance varies starts in the same part of it."""
        columns = dict(zip(paths, np.asarray(table).T, strict=True))
        for path in paths:
            joint = self.system.experiment.joints.get(path.split(".")[1])
            if joint is not None and path == f"joints.{path.split('.')[1]}.clearance" and any(joint.offset):
                ratio = columns[path] / (joint.clearance or 1.0)
                columns |= {f"{path.rpartition('.')[0]}.offset.{k}": ratio * x for k, x in enumerate(joint.offset)}
        rows = np.array([*columns.values()]).T if columns else None
        window, outputs = [[self.start, self.end]], outputs_of(self.system)
        return run_batch(self.system, list(columns), rows, outputs, window, progress=progress, **options)


def outputs_of(system: System) -> list[str]:
    """Name the outputs whose peaks are explored: the usual ones, and those of models of links."""
    of_links = (column for _, own in peaks_of_models(system, "link") for column in own)
    return [*dict.fromkeys((*default_outputs(system), *of_links))]


def sweep(around: Around, control: Control, request: Mapping[str, Any], progress: Callable[[float], None]) -> Any:
    """Return peaks by output for values (n,) of a control; None where a run fails, with its reason."""
    low, high, count = (request.get(key, getattr(control, key, 21)) for key in ("low", "high", "count"))
    if not all(map(is_number, (low, high, count))) or not low < high or not 2 <= count <= MOST_RUNS:
        raise InputError("page", control.path, f"a sweep needs low < high, and a count from 2 to {MOST_RUNS}")
    check_varied(around.system, control.path, [low, high], ARGUMENT, outputs_of(around.system))
    space = np.geomspace if control.logarithmic and low * high > 0.0 else np.linspace
    values = space(low, high, int(count))
    values = np.unique(values.round()) if control.whole else values
    batch = around.batch([control.path], values[:, None], progress)
    found = {"path": control.path, "values": values.tolist(), "peaks": _by_output(batch, batch.peak[:, 0])}
    return found | _described(around, batch) | {"reasons": batch.reason}


def sensitivities(around: Around, paths: Sequence[str], progress: Callable[[float], None]) -> dict[str, Any]:
    """Return peaks by output, and by path and output the relative change of a peak over the one of a value.

    A change is None where the derivative does not predict what 1 % of the value does; `reasons` then tells why.
    Paths `without` an effect have their reasons.
    """
    paths, without = around.acting(paths)
    batch = around.batch((), np.zeros((1, 0)), lambda part: progress(0.3 * part), wrt=paths)
    if batch.status[0] is not Status.OK:
        raise InputError("page", "sensitivities", f"the run has none: {batch.reason[0]}")
    peak, values = batch.peak[0, 0], np.array([around.system.value(path) for path in paths])
    rates = np.array([batch.sensitivity[path]["peak"][0, 0] for path in paths])
    reach = _reach(around, dict(zip(paths, values.tolist(), strict=True)), rates, peak, progress)
    with np.errstate(divide="ignore", invalid="ignore"):
        changes = np.where(reach >= STATED, rates * values[:, None] / peak, np.nan)
    found: dict[str, Any] = {
        "peaks": dict(zip(batch.outputs, peak.tolist(), strict=True)),
        "changes": {},
        "reasons": {},
    }
    for path, line, reached in zip(paths, changes, reach.tolist(), strict=True):
        found["changes"][path] = dict(zip(batch.outputs, short(line), strict=True))
        why = {
            name: _unstated(one, batch.sensitivity_status[0]) for name, one in zip(batch.outputs, reached, strict=True)
        }
        found["reasons"][path] = {name: text for name, text in why.items() if found["changes"][path][name] is None}
    return found | _described(around, batch) | {"why": _WHY.format(WHY), "without": without}


def _reach(
    around: Around, values: Mapping[str, float], rates: Array, peak: Array, progress: Callable[[float], None]
) -> Array:
    """Find how far derivatives of peaks predict, (np, no)."""
    keys = [f"{name}.peak" for name in outputs_of(around.system)]

    def numbers(table: Array, tight: bool) -> Array:
        """Make the peaks (m, no) of runs with values (m, np)."""
        one, done = (replace(around, system=finer(around.system)), 0.6) if tight else (around, 0.3)
        return numbers_of(one.batch([*values], table, lambda part: progress(done + 0.3 * part)), keys)

    found = reaches(values, rates, peak, numbers)
    progress(1.0)
    return found


def _unstated(reach: float, status: str) -> str:
    """Tell why a derivative makes no statement about a change of 1 %."""
    if not np.isnan(reach):
        return f"predicts to: {extent(reach)}"
    return f"no derivative: {MEANING[status]}" if status != OK else "no derivative"


def tolerances(
    around: Around, spreads: Mapping[str, float], runs: int, progress: Callable[[float], None]
) -> dict[str, Any]:
    """Return quantiles of curves and of peaks for normally scattered values: deviations over the values.

    Their times are counted from the begin of the part that the page draws, as in `linkages.show.live.view`.
    """
    system = around.system
    paths, without = around.acting([*spreads])
    spreads = {path: spreads[path] for path in paths}
    nominal = np.array([system.value(path) for path in spreads])
    scatter = np.random.default_rng(0).standard_normal((runs, len(spreads)))
    table = nominal * (1.0 + np.array([*spreads.values()]) * scatter)
    times = np.linspace(*around.drawn, _samples(runs * len(outputs_of(system))))
    batch = around.batch([*spreads], table, progress, samples=times)
    good = np.array([status is Status.OK for status in batch.status])
    if not good.any():
        raise InputError("page", "tolerances", f"no run reaches its end: {batch.reason[0]}")
    factors = np.array([shown(unit(system, name))[1] for name in batch.outputs])
    bands = np.percentile(batch.samples[good] * factors, _QUANTILES, axis=0)  # (3, nt, no)
    peaks = batch.peak[good, 0]
    ends = np.percentile(peaks, _QUANTILES, axis=0)
    found = zip(batch.outputs, peaks.mean(axis=0).tolist(), peaks.std(axis=0).tolist(), ends.T.tolist(), strict=True)
    return {
        "time": short(times - around.drawn[0]),
        "bands": {name: short(bands[:, :, k]) for k, name in enumerate(batch.outputs)},
        "peaks": {name: {"mean": mean, "deviation": std, "quantiles": of} for name, mean, std, of in found},
        "runs": int(good.sum()),
        "failed": int((~good).sum()),
        "spreads": dict(spreads),
        "without": without,
    } | _described(around, batch)


def _samples(curves: int) -> int:
    """Count the samples of each curve of a band: enough for the short forces of impacts, within a limited memory."""
    return min(max(_MOST_SAMPLES // curves, FRAMES), _SAMPLES)


def usual_spreads(controls: Mapping[str, Control], values: Mapping[str, Any]) -> dict[str, float]:
    """Return the deviations of the numbers that a page shows at first, and of changed ones: a third of 1 %.

    Drives keep their motion, so that the curves of all runs have the same phase.
    """
    numbers = {path: control for path, control in controls.items() if not control.choices and not control.whole}
    shown = {path for path, control in numbers.items() if control.first or path in values}
    return {path: SPREAD for path in numbers if path in shown and not path.startswith("drives.")}


def checked_spreads(given: Any, controls: Mapping[str, Control]) -> dict[str, float]:
    """Check deviations from outside; InputError unless they are a table of positive numbers by path."""
    if not isinstance(given, dict) or not 0 < len(given) <= _MOST_PATHS:
        raise InputError("page", "spreads", f"must be a table of 1 to {_MOST_PATHS} deviations by path")
    checked_paths(list(given), controls)
    for path, spread in given.items():
        if not is_number(spread) or not 0.0 < spread < 1.0:
            raise InputError("page", path, "its deviation must be a part of the value, above 0 and below 1")
    return given


def checked_paths(given: Any, controls: Mapping[str, Control]) -> list[str]:
    """Check paths of numbers from outside; InputError for others."""
    if not isinstance(given, list) or not 0 < len(given) <= _MOST_PATHS:
        raise InputError("page", "paths", f"must be a list of 1 to {_MOST_PATHS} paths")
    for path in given:
        if not isinstance(path, str) or path not in controls or controls[path].choices or controls[path].whole:
            raise InputError("page", str(path)[:100], "is not the path of a number that can be varied")
    return given


def _described(around: Around, batch: Batch) -> dict[str, dict[str, str]]:
    """Return units and names in words of the outputs of a batch."""
    return {
        "units": {name: unit(around.system, name) for name in batch.outputs},
        "labels": {name: output_in_words(name) for name in batch.outputs},
    }


def _by_output(batch: Batch, table: Array) -> dict[str, list[float | None]]:
    """Return columns (n,) by output; None where a run has no value."""
    return {name: [None if np.isnan(x) else float(x) for x in table[:, k]] for k, name in enumerate(batch.outputs)}


def is_number(value: Any) -> bool:
    """Check whether a value from outside is a finite number; an integer can be too large for one."""
    with suppress(OverflowError):
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    return False
