"""Plans of measurements: how certain candidate sensors would make the unknowns, alone and in pairs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from linkages import InputError, System, simulate
from linkages.base.arrays import Array
from linkages.base.brief import cell
from linkages.input.files.unit_conversion import si
from linkages.results.outputs.registry import check_output, default_outputs, unit
from optim.identify.certainty import largest_deviations, mixture_text
from optim.identify.load import Identification
from optim.identify.residuals import Residuals
from optim.problem.load import within

_NOISE = 0.01  # deviation of a sensor that is proposed, relative to the spread of its output
_PROPOSED = 3
_FEWEST = 8  # samples of a planned run


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
    deviations = {name: _deviation(task, name) for name in wanted.candidates}
    residuals, settings = Residuals(task), []
    values: list[float | None] = [*wanted.values] or [None]
    for value in values:
        changed: dict[str, Any] = {} if value is None else {wanted.vary or "": value}
        if wanted.duration is not None:
            changed["duration"] = wanted.duration
        with within(task.source, "plan"):
            system = task.system.replaced(changed) if changed else task.system
        if system.experiment.duration * wanted.rate < _FEWEST:
            raise InputError(task.source, "plan.rate", f"gives less than {_FEWEST} samples; give a higher one")
        show("plan" if value is None else f"plan, {wanted.vary} = {value:g}")
        rows = sensor_rows(residuals, system, [c.output for c in wanted.candidates.values()], wanted.rate)
        found = {name: rows[candidate.output] / deviations[name] for name, candidate in wanted.candidates.items()}
        settings.append({"value": value, **_compared(residuals, found)})
    best = min(
        (entry for setting in settings for entry in _rated(setting)),
        key=lambda entry: (-entry[1]["identifiable"], entry[1]["worst"]),
    )
    return {
        "title": task.title, "unknowns": list(task.names), "vary": wanted.vary, "settings": settings,
        "best": {"value": best[0], "sensors": best[1]["sensors"]},
    }  # fmt: skip


def _deviation(task: Identification, name: str) -> float:
    assert task.file.plan is not None
    candidate, where = task.file.plan.candidates[name], f"plan.candidates.{name}"
    try:
        check_output(task.system, candidate.output)
    except InputError as problem:
        raise InputError(task.source, where, str(problem)) from None
    given = candidate.deviation
    try:
        return si(given, unit(task.system, candidate.output)) if isinstance(given, str) else float(given)
    except ValueError as problem:
        raise InputError(task.source, f"{where}.deviation", str(problem)) from None


def sensor_rows(residuals: Residuals, system: System, outputs: list[str], rate: float) -> dict[str, Array]:
    """Return the derivatives (nt, n) of outputs with respect to the scaled unknowns at the start, at a rate [Hz].

    Samples without derivatives are left out.
    """
    task, n = residuals.task, len(residuals.active)
    paths = [task.paths[k] for k in residuals.active]
    values = residuals.values(residuals.start)
    system = system.replaced(dict(zip(paths, map(float, values), strict=True)))
    run = simulate(system, outputs=list(dict.fromkeys(outputs)), wrt=paths)
    times = np.arange(0.0, float(run.time[-1]) * (1.0 + 1e-12), 1.0 / rate)
    times = times[times <= min(run.sensitivity.until, float(run.time[-1]))]
    found, slopes = run.sensitivity.evaluate(times), residuals.slopes(residuals.start)
    return {
        output: np.nan_to_num(np.column_stack([found[path][output] for path in paths])).reshape(-1, n) * slopes
        for output in outputs
    }


def _compared(residuals: Residuals, rows: Mapping[str, Array]) -> dict[str, Any]:
    single = [_judged(residuals, (name,), rows[name]) for name in rows]
    pairs = [
        _judged(residuals, pair, np.vstack([rows[name] for name in pair])) for pair in itertools.combinations(rows, 2)
    ]
    return {"single": single, "pairs": pairs}


def _judged(residuals: Residuals, sensors: tuple[str, ...], rows: Array) -> dict[str, Any]:
    """Judge sensors by the derivatives of their samples, in deviations."""
    allowed = largest_deviations(residuals)
    _, singular, mixtures = np.linalg.svd(rows * allowed, full_matrices=len(rows) < rows.shape[1])
    singular = np.pad(singular, (0, len(mixtures) - len(singular)))
    with np.errstate(divide="ignore"):
        scaled = np.sqrt(np.sum((mixtures / np.where(singular > 0.0, singular, 0.0)[:, None]) ** 2, axis=0)) * allowed
    slopes, values = residuals.slopes(residuals.start), residuals.values(residuals.start)
    known = scaled <= allowed
    relative = scaled * slopes / np.where(values == 0.0, 1.0, np.abs(values))
    unknown = [mixture_text(residuals, m) for s, m in zip(singular, mixtures, strict=True) if s < 1.0]
    return {
        "sensors": list(sensors),
        "deviations": [float(x) if ok else None for x, ok in zip(relative, known, strict=True)],
        "identifiable": int(known.sum()),
        "worst": float(np.max(relative[known], initial=0.0)),
        "unknown": unknown,
    }


def _rated(setting: Mapping[str, Any]) -> list[tuple[Any, dict[str, Any]]]:
    """Return the pairs of a setting, or its sensors if there is one only."""
    return [(setting["value"], entry) for entry in setting["pairs"] or setting["single"]]


def missing_sensors(residuals: Residuals, z: Array, jacobian: Array, rate: float) -> list[str]:
    """Return further outputs that would make all unknowns identifiable, with samples of 1 % noise, the best first."""
    task, n = residuals.task, len(residuals.active)
    measured = {channel.output for measurement in task.measurements for channel in measurement.channels}
    system = task.measurements[0].system.replaced(
        {"duration": min(residuals.span()[1], task.system.experiment.duration)}
    )
    outputs = [name for name in default_outputs(system) if unit(system, name)] or list(default_outputs(system))
    outputs += [f"{name}.eccentricity_ratio" for name in system.experiment.play]
    known = [name for name in dict.fromkeys(outputs) if name not in measured and _exists(system, name)]
    moved = _At(residuals, z)
    rows = sensor_rows(moved, system, known, rate)
    run = simulate(system, outputs=known)
    allowed, found = largest_deviations(residuals), []
    for name in known:
        spread = _NOISE * float(np.std(run[name]))
        if spread > 0.0 and math.isfinite(spread):
            stacked = np.vstack([jacobian[:, :n], rows[name] / spread]) * allowed
            least = float(np.linalg.svd(stacked, compute_uv=False)[-1])
            found.append((least, name))
    return [name for least, name in sorted(found, reverse=True)[:_PROPOSED] if least >= 1.0]


def _exists(system: System, name: str) -> bool:
    try:
        check_output(system, name)
    except InputError:
        return False
    return True


class _At(Residuals):
    """The same residuals, which start from other values."""

    def __init__(self, residuals: Residuals, z: Array) -> None:
        self.__dict__.update(residuals.__dict__)
        self.start = z


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
    at = "" if best["value"] is None else f" at {found['vary']} = {best['value']:g}"
    lines += ["", f"best: {' and '.join(best['sensors'])}{at} (deviations at the start values, linear)"]
    return "\n".join(lines)
