"""Plans of measurements: how certain candidate sensors would make the unknowns, alone and in pairs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from linkages import InputError, RunError, System
from linkages.base.arrays import Array
from linkages.base.brief import cell
from linkages.input.files.unit_conversion import si
from linkages.results.outputs.registry import check_output, default_outputs, unit
from optim.identify.certainty import judge, largest_deviations, mixtures_of
from optim.identify.doubts import mixture_text
from optim.identify.load import Channel, Identification, Measurement
from optim.identify.numerics import PLAN_FEWEST, PLAN_NOISE, PLAN_PROPOSED
from optim.identify.residuals import Residuals
from optim.identify.schema import Plan
from optim.problem.load import within


class Sensor(NamedTuple):
    """A sensor that could be used; the deviation of a sample, gain and offset (NaN if they will be fitted)."""

    name: str
    output: str
    deviation: float = 1.0
    gain: float = 1.0
    offset: float = 0.0


def plan(task: Identification, show: Callable[[str], None] = lambda text: None) -> dict[str, Any]:
    """Compute the deviations of the unknowns that each sensor and each pair of sensors would give, at the start values.

    Returns ``unknowns``: names; ``settings``: for each value of ``vary`` (one without): ``value``, ``single`` and
    ``pairs``: sensors, ``deviations`` relative to the values (None: not identifiable), ``identifiable`` count;
    ``best``: the best pair or sensor, and the setting. InputError if the file has no table ``plan``.

    Examples
    --------
    >>> import optim
    >>> found = optim.plan(optim.load_identification("slider_crank_fit"))
    >>> found["best"]["sensors"]
    ['acceleration', 'probe']
    """
    wanted = task.file.plan
    if wanted is None:
        raise InputError(task.source, "plan", "is missing; add [plan] with rate and candidates")
    settings = []
    values: list[float | None] = [*wanted.values] or [None]
    for value in values:
        changed: dict[str, Any] = {} if value is None else {wanted.vary or "": value}
        if wanted.duration is not None:
            changed["duration"] = wanted.duration
        with within(task.source, "plan"):
            system = task.system.replaced(changed) if changed else task.system
        if system.settings.duration * wanted.rate < PLAN_FEWEST:
            raise InputError(task.source, "plan.rate", f"gives less than {PLAN_FEWEST} samples; give a higher one")
        show("plan" if value is None else f"plan, {wanted.vary} = {value:g}")
        one, owners = _planned(task, wanted, system), (None,) * len(task.names)
        settings.append({"value": value, **_compared(Residuals(replace(task, measurements=(one,), owners=owners)))})
    best = min(
        (entry for setting in settings for entry in _rated(setting)),
        key=lambda entry: (-entry[1]["identifiable"], entry[1]["worst"]),
    )
    return {
        "title": task.title, "unknowns": list(task.names), "vary": wanted.vary, "settings": settings,
        "best": {"value": best[0], "sensors": best[1]["sensors"]},
    }  # fmt: skip


def _planned(task: Identification, wanted: Plan, system: System) -> Measurement:
    """Return the measurement of a plan, without values."""
    sensors = []
    for name, candidate in wanted.candidates.items():
        where, given = f"plan.candidates.{name}", candidate.deviation
        try:
            check_output(system, candidate.output)
        except InputError as problem:
            raise InputError(task.source, where, str(problem)) from None
        with within(task.source, f"{where}.deviation"):
            size = si(given, unit(system, candidate.output)) if isinstance(given, str) else float(given)
        if size <= 0.0:
            raise InputError(task.source, f"{where}.deviation", f"is {given!r}; it must be positive")
        gain, offset = math.nan if candidate.gain else 1.0, math.nan if candidate.offset else 0.0
        sensors.append(Sensor(name, candidate.output, size, gain, offset))
    return _measurement("plan", system, sensors, wanted.rate, math.nan if wanted.shift else 0.0)


def _measurement(name: str, system: System, sensors: Iterable[Sensor], rate: float, shift: float) -> Measurement:
    """Return a measurement, the values of which are zero, with samples at a rate [Hz]."""
    times = np.arange(0.0, system.settings.duration * (1.0 + 1e-12), 1.0 / rate)
    none = np.zeros(len(times))
    channels = (
        Channel(one.name, one.output, "", times, none, none, one.deviation, one.gain, one.offset, None)
        for one in sensors
    )
    return Measurement(name, system, tuple(channels), shift)


def _rows(residuals: Residuals, z: Array) -> dict[str, tuple[Array, Array]]:
    """Return residuals and derivatives by sensor, up to where derivatives are known; "" names the priors."""
    found = residuals(z)
    if found.reason:
        raise RunError(f"the planned run fails: {found.reason}")
    rows, last = {}, 0
    for channel, part in residuals.groups(math.inf):
        known = slice(part.start, part.start + residuals.used(channel, found.until).stop)
        rows[channel.name], last = (found.residual[known], found.jacobian[known]), part.stop
    return rows | {"": (found.residual[last:], found.jacobian[last:])}


def _compared(residuals: Residuals) -> dict[str, Any]:
    rows = {name: jacobian for name, (_, jacobian) in _rows(residuals, residuals.start).items()}
    names = [name for name in rows if name]
    return {
        "single": [_judged(residuals, (name,), rows) for name in names],
        "pairs": [_judged(residuals, pair, rows) for pair in itertools.combinations(names, 2)],
    }


def _judged(residuals: Residuals, sensors: tuple[str, ...], rows: Mapping[str, Array]) -> dict[str, Any]:
    """Judge sensors by the derivatives of their samples, in deviations."""
    n = len(residuals.active)
    jacobian = np.vstack([rows[name] for name in (*sensors, "")])
    jacobian = jacobian[:, (np.arange(jacobian.shape[1]) < n) | jacobian.any(axis=0)]  # without values of other sensors
    covariance, singular, mixtures, _, known = judge(residuals, jacobian, np.ones(n, bool))
    slopes, values = residuals.slopes(residuals.start), residuals.values(residuals.start)
    relative = np.sqrt(np.diag(covariance))[:n] * slopes / np.where(values == 0.0, 1.0, np.abs(values))
    return {
        "sensors": list(sensors),
        "deviations": [float(x) if ok else None for x, ok in zip(relative, known, strict=True)],
        "identifiable": int(known.sum()),
        "worst": float(np.max(relative[known], initial=0.0)),
        "unknown": [mixture_text(residuals, m) for s, m in zip(singular, mixtures, strict=True) if s < 1.0],
    }


def _rated(setting: Mapping[str, Any]) -> list[tuple[Any, dict[str, Any]]]:
    """Return the pairs of a setting, or its sensors if there is one only."""
    return [(setting["value"], entry) for entry in setting["pairs"] or setting["single"]]


def missing_sensors(residuals: Residuals, z: Array, jacobian: Array, rate: float) -> list[str]:
    """Return further outputs that would make all unknowns identifiable, with samples of 1 % noise, the best first.

    They have the clock and the machine of the first measurement.
    """
    task, n, first = residuals.task, len(residuals.active), residuals.task.measurements[0]
    measured = {channel.output for measurement in task.measurements for channel in measurement.channels}
    system = first.system.replaced({"duration": min(residuals.span()[1], task.system.settings.duration)})
    outputs = [name for name in default_outputs(system) if unit(system, name)] or list(default_outputs(system))
    outputs += [f"{name}.eccentricity_ratio" for name in system.play]
    known = [Sensor(name, name) for name in dict.fromkeys(outputs) if name not in measured and _exists(system, name)]
    one = _measurement(first.name, system, known, rate, first.shift)
    further = Residuals(replace(task, measurements=(one,)), tuple(residuals.names[:n]))
    rows, allowed, found = _rows(further, z[: len(further.start)]), largest_deviations(residuals), []
    for name, *_ in known:
        residual, lines = rows[name]
        spread = PLAN_NOISE * float(np.std(residual))
        if spread > 0.0 and math.isfinite(spread):
            lines = np.pad(
                lines, ((0, 0), (0, jacobian.shape[1] - lines.shape[1]))
            )  # a fitted shift is the first value
            found.append((float(mixtures_of(np.vstack([jacobian, lines / spread]), allowed)[0][-1]), name))
    return [name for least, name in sorted(found, reverse=True)[:PLAN_PROPOSED] if least >= 1.0]


def _exists(system: System, name: str) -> bool:
    try:
        check_output(system, name)
    except InputError:
        return False
    return True


def format_plan(found: Mapping[str, Any]) -> str:
    """Format a plan as lines of text: the deviation of each unknown, in per cent, by sensors.

    Examples
    --------
    >>> import optim
    >>> text = optim.format_plan(optim.plan(optim.load_identification("slider_crank_fit")))
    >>> text.splitlines()[-1]
    'best: acceleration and probe (deviations at the start values, linear)'
    """
    names, lines = found["unknowns"], [found["title"]]
    first = max([14, *(len(" + ".join(e["sensors"])) + 2 for s in found["settings"] for e in s["single"] + s["pairs"])])
    for setting in found["settings"]:
        if setting["value"] is not None:
            lines += ["", f"{found['vary']} = {setting['value']:g}"]
        lines.append(f"{'sensors':{first}s}" + "".join(f"{name:>16s}" for name in names))
        for entry in setting["single"] + setting["pairs"]:
            cells = [f"{'not known':>16s}" if x is None else cell(100.0 * x, 14) + " %" for x in entry["deviations"]]
            lines.append(f"{' + '.join(entry['sensors']):{first}s}{''.join(cells)}")
    best = found["best"]
    if not any(entry["identifiable"] for setting in found["settings"] for _, entry in _rated(setting)):
        return "\n".join([*lines, "", "none of these sensors determines an unknown"])
    at = "" if best["value"] is None else f" at {found['vary']} = {best['value']:g}"
    lines += ["", f"best: {' and '.join(best['sensors'])}{at} (deviations at the start values, linear)"]
    return "\n".join(lines)
