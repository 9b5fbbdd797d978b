"""`identify`: the values that explain measurements; the content of ``result.json``."""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from linkages import InputError, RunError
from linkages.base.arguments import Count, validated
from linkages.base.arrays import Array
from linkages.input.files.toml import leaves
from linkages.input.files.versions import versions
from linkages.input.files.writing import finite, write_json
from optim.identify.certainty import DOUBT, Certainty, certainty, doubts, interval, mixture_text
from optim.identify.fit import Fitted, best_of, first_window, fit_all, hopeless, refine, starts
from optim.identify.load import Identification, described
from optim.identify.plan import missing_sensors
from optim.identify.posterior import check_sampler, posterior
from optim.identify.profile import profile
from optim.identify.residuals import Residuals
from optim.identify.statistics import NAMES, Statistics

SAMPLES = "posterior.bin"  # keeps samples, in the folder of the checkpoint
_HALF = 0.5  # part that is predicted where alternatives are compared, by default
_NEW = 8  # further starts where the best one is hopeless
_ROUNDS = 3  # times that they are added, as long as they help
_BETTER = 0.95  # largest ratio of chi-square that helps
_SAME = 0.05  # relative difference of chi-square up to which two starts have found the same


@validated
def identify(
    task: Identification,
    checkpoint: Path | None = None,
    *,
    resume: bool = False,
    profiles: bool = False,
    samples: bool = False,
    threads: Count | None = None,
    executor: Executor | None = None,
    show: Callable[[str], None] = lambda text: None,
) -> dict[str, Any]:
    """Find the values that explain the measurements, and how certain they are.

    Parameters
    ----------
    task : Identification
        From `optim.load_identification`.
    checkpoint : Path, optional
        File that keeps the starts that have ended; ``posterior.bin`` in its folder keeps the samples.
    resume : bool
        Whether the checkpoint may exist; it must be of the same file.
    profiles : bool
        Whether to compute the profile likelihood of each unknown.
    samples : bool
        Whether to sample the posterior by emcee.
    threads : int, optional
        Threads in which starts and samples run; default all there are. The results do not depend on it.
    executor : Executor, optional
        Where starts run; default here.
    show : callable, optional
        Called with a line of progress after each window.

    Returns
    -------
    dict
        The content of ``result.json``, SI units: ``parameters``: by name ``path``, ``value``, ``deviation`` and
        ``interval`` of 95 % (None if not identifiable), ``identifiable``; ``nuisance``: gains, offsets, shifts;
        ``residual``, ``correlation``, ``prediction``, ``best_alternative``; ``mixtures`` that the data leave open, and
        ``sensors`` that would determine them; ``warnings``; ``curves`` and ``statistics``: the compared samples or
        numbers; ``posterior``: see `optim.identify.posterior.posterior`.

    Raises
    ------
    InputError
        If the file has no measurements, the checkpoint is of another file, or emcee is not installed.
    RunError
        If no start can be fitted, or no point can be sampled.

    Examples
    --------
    >>> import optim
    >>> found = optim.identify(optim.load_identification("slider_crank_fit"))
    >>> found["parameters"]["mass"]["interval"][0] < 0.152 < found["parameters"]["mass"]["interval"][1]  # kg
    True
    """
    if not task.measurements:
        raise InputError(task.source, "data", "is missing; add [data.NAME] with file and columns, or give --plan")
    if samples:
        check_sampler()
        if task.file.fit.windows == "statistics":
            raise InputError(
                task.source, "fit.windows", 'is "statistics", which have no posterior; leave out --posterior'
            )
    begun = time.perf_counter()
    share = task.file.fit.predict or (_HALF if task.file.alternatives else 0.0)
    models: dict[str, tuple[Identification, tuple[str, ...] | None]] = {"": (task, None)}
    for name, other in task.file.alternatives.items():
        own = None if other.unknowns is None else tuple(other.unknowns)
        models[name] = _with_values(task, name, dict(leaves(other.set))), own
    kept = _Checkpoint(checkpoint, task, resume)
    results = {}
    for name, (model, active) in models.items():
        say = partial(_labelled, show, f"{name}: " if name else "")
        kind = Statistics if task.file.fit.windows == "statistics" else Residuals
        results[name] = _fit(kind(model, active), share, (threads, executor), kept, name, say)
    residuals, found, judged, all_starts = results[""]
    content = _content(residuals, found, judged, share)
    content["starts"] = _agreement(all_starts, found, judged)
    content["warnings"] += content["starts"].pop("warnings")
    if task.file.alternatives:
        content["alternatives"] = {
            name or "this": {
                "prediction": _prediction(*results[name][:2], share),
                "chi_square": results[name][1].cost,
                "parameters": _parameters(*results[name][:3]),
            }
            for name in results
        }
        content["best_alternative"] = _best_prediction(content["alternatives"], residuals)
    if profiles:
        for k, name in enumerate(residuals.names[: len(residuals.active)]):
            show(f"profile of {name}")
            ends, points, runs = profile(residuals, found, judged, k)
            content["parameters"][name] |= {
                "profile": points.tolist(),
                "profile_interval": list(ends),
                "profile_runs": runs,
            }
    if samples:
        store = None if checkpoint is None else checkpoint.with_name(SAMPLES)
        content["posterior"] = posterior(residuals, found, judged, threads, show, store)
        if not content["posterior"]["enough"]:
            content["warnings"].append(
                f"the posterior has {content['posterior']['autocorrelation_times']:.2g} autocorrelation times, not 50:"
                " its intervals are uncertain; raise fit.posterior_runs, and continue with --resume"
            )
    return content | {
        "title": task.title,
        "file": described(task),
        "runs": sum(one.runs for one in all_starts) + max(found.runs - max(one.runs for one in all_starts), 0),
        "versions": versions("scipy"),
        "wall_time": time.perf_counter() - begun,
    }


def _labelled(show: Callable[[str], None], label: str, text: str) -> None:
    show(label + text)


def _with_values(task: Identification, name: str, values: Mapping[str, Any]) -> Identification:
    try:
        measurements = tuple(replace(one, system=one.system.replaced(values)) for one in task.measurements)
    except InputError as problem:
        raise InputError(task.source, f"alternatives.{name}.set", str(problem)) from None
    return replace(task, measurements=measurements)


def _fit(
    residuals: Residuals,
    share: float,
    where: tuple[int | None, Executor | None],
    kept: _Checkpoint,
    name: str,
    show: Callable[[str], None],
) -> tuple[Residuals, Fitted, Certainty, list[Fitted]]:
    fit = residuals.task.file.fit
    first, last = residuals.span()
    last = last - share * (last - first)
    touches = any(one.system.experiment.can_touch for one in residuals.task.measurements)
    windows = fit.windows or ("impacts" if touches else "all")
    shortest = first_window(residuals, last, windows)
    found: list[Fitted] = []
    points = starts(residuals, fit.starts, fit.seed, shortest)
    keep, known = partial(kept.keep, name), kept.known(name)
    for more in range(1, _ROUNDS + 2):
        least = best_of(residuals, found).cost if found else math.inf
        found += fit_all(residuals, points, len(found), last, windows, *where, known, keep, show)
        best = best_of(residuals, found)
        if not hopeless(residuals, best) or best.cost > _BETTER * least:
            break
        points = starts(residuals, _NEW + 1, fit.seed + more, shortest)[1:]
    if best.evaluated.reason:
        raise RunError(
            f"no start can be fitted: {best.evaluated.reason}; change the start or the limits of the unknowns"
        )
    best = refine(residuals, best)
    return residuals, best, certainty(residuals, best, fit.deviations), found


def _content(residuals: Residuals, found: Fitted, judged: Certainty, share: float) -> dict[str, Any]:
    n, names = len(residuals.active), residuals.names
    channels = [f"{m.name}.{c.name}" for m in residuals.task.measurements for c in m.channels]
    groups = residuals.groups(found.horizon)
    deviations = [x for one in residuals.deviations for x in one]
    rms = [
        float(np.sqrt(np.mean(found.evaluated.residual[rows] ** 2))) if rows.stop > rows.start else None
        for _, rows in groups
    ]
    open_ones = [
        mixture_text(residuals, mixture)
        for value, mixture in zip(judged.singular, judged.mixtures, strict=True)
        if value < 1.0
    ]
    rate = 1.0 / float(np.median(np.diff(residuals.task.measurements[0].channels[0].times)))
    sensors = []
    if open_ones:
        try:
            sensors = missing_sensors(residuals, found.z, found.evaluated.jacobian, rate)
        except RunError:  # the machine does not run as long as the samples
            sensors = []
    scale = judged.deviations
    known = np.isfinite(scale)
    correlation = np.where(np.outer(known, known), judged.covariance / np.outer(scale, scale), np.nan)
    return {
        "parameters": _parameters(residuals, found, judged),
        "nuisance": _sensors(residuals, found.z, judged),
        "residual": {
            "columns": channels,
            "rms": [None if r is None else r * d for r, d in zip(rms, deviations, strict=True)],
            "deviation": deviations,
            "samples": [rows.stop - rows.start for _, rows in groups],
            "autocorrelation_time": judged.times,
            **judged.tests,
        },
        "correlation": {"names": names, "matrix": [[finite(x) for x in row] for row in correlation]},
        "prediction": _prediction(residuals, found, share),
        "singular_values": judged.singular.tolist(),
        "mixtures": open_ones,
        "sensors": sensors,
        "fitted_until": found.horizon,
        "warnings": doubts(residuals, found, judged),
        "history": [list(row) for row in found.history],
        "curves": {} if isinstance(residuals, Statistics) else _curves(residuals, found),
        "statistics": _statistics(residuals, found.z),
        "values": dict(zip(names[:n], residuals.values(found.z).tolist(), strict=True)),
    }


def _parameters(residuals: Residuals, found: Fitted, judged: Certainty) -> dict[str, dict[str, Any]]:
    values, slopes, result = residuals.values(found.z), residuals.slopes(found.z), {}
    for k, j in enumerate(residuals.active):
        deviation, known = float(judged.deviations[k]), bool(judged.identifiable[k])
        known = known and math.isfinite(deviation)
        ends = interval(residuals, found.z, k, deviation, judged.freedom) if known else None
        result[residuals.task.names[j]] = {
            "path": residuals.task.paths[j],
            "value": float(values[k]),
            "unit": residuals.task.units()[j],
            "deviation": deviation * float(slopes[k]) if known else None,
            "interval": None if ends is None else list(ends),
            "identifiable": known,
        }
    return result


def _sensors(residuals: Residuals, z: Array, judged: Certainty) -> dict[str, dict[str, float | None]]:
    """Return fitted gains, offsets and shifts as the file defines them, with their deviations."""
    result: dict[str, dict[str, float | None]] = {}
    n = len(residuals.active)
    for k, (kind, m, c) in enumerate(residuals.places, n):
        one = residuals.task.measurements[m]
        gradient = np.zeros(len(z))
        if kind == "shift":
            name, value, gradient[k] = f"{one.name}.shift", float(z[k]), 1.0
        else:
            factor, bias = residuals.sensor(z, "factor", m, c), residuals.sensor(z, "bias", m, c)
            at = {p.kind: i for i, p in enumerate(residuals.places, n) if (p.measurement, p.channel) == (m, c)}
            name = f"{one.name}.{one.channels[c].name}." + ("gain" if kind == "factor" else "offset")
            value = 1.0 / factor if kind == "factor" else -bias / factor
            if kind == "factor":
                gradient[k] = -1.0 / factor**2
            else:
                gradient[k] = -1.0 / factor
                if "factor" in at:
                    gradient[at["factor"]] = bias / factor**2
        known = gradient != 0.0
        variance = float(gradient[known] @ judged.covariance[np.ix_(known, known)] @ gradient[known])
        result[name] = {
            "value": value,
            "deviation": finite(math.sqrt(max(variance, 0.0)) if variance == variance else math.nan),
        }
    return result


def _prediction(residuals: Residuals, found: Fitted, share: float) -> dict[str, Any] | None:
    """Root mean square of the residuals after the fitted part, by column; None if nothing is predicted."""
    if share == 0.0:
        return None
    evaluated = residuals(found.z)
    result: dict[str, Any] = {"from": found.horizon, "rms": {}}
    groups, k = residuals.groups(math.inf), 0
    for m, one in enumerate(residuals.task.measurements):
        for c, channel in enumerate(one.channels):
            rows = groups[k][1]
            left = evaluated.residual[rows][residuals.used(channel, found.horizon).stop :] * residuals.deviations[m][c]
            good = len(left) and not evaluated.reason
            result["rms"][f"{one.name}.{channel.name}"] = float(np.sqrt(np.mean(left**2))) if good else None
            k += 1
    return result


def _statistics(residuals: Residuals, z: Array) -> dict[str, dict[str, dict[str, float]]]:
    """Return measured and computed statistics by column and name; none if samples are compared."""
    if not isinstance(residuals, Statistics):
        return {}
    return {
        column: {key: dict(zip(NAMES, row, strict=True)) for key, row in rows.items()}
        for column, rows in residuals.compared_numbers(z).items()
    }


def _best_prediction(models: Mapping[str, Any], residuals: Residuals) -> str:
    """Return the name of the model whose prediction has the least sum of squares, in deviations of the columns."""
    deviations = [x for one in residuals.deviations for x in one]
    misses = {}
    for name, one in models.items():
        left = [math.inf if x is None else x for x in one["prediction"]["rms"].values()]
        misses[name] = sum((x / deviation) ** 2 for x, deviation in zip(left, deviations, strict=True))
    return min(misses, key=lambda name: misses[name])


def _curves(residuals: Residuals, found: Fitted) -> dict[str, Any]:
    """Return times, measured and computed samples of the fitted part, for figures: some thousand of each column."""
    curves, k = {}, 0
    groups = residuals.groups(found.horizon)
    for m, one in enumerate(residuals.task.measurements):
        for c, channel in enumerate(one.channels):
            rows, part = groups[k][1], residuals.used(channel, found.horizon)
            step = max(1, (part.stop - part.start) // 4000)
            left = found.evaluated.residual[rows] * residuals.deviations[m][c]
            measured = channel.values[part]
            curves[f"{one.name}.{channel.name}"] = {
                "unit": channel.unit,
                "time": channel.times[part][::step].tolist(),
                "measured": measured[::step].tolist(),
                "computed": (measured - left)[::step].tolist(),
            }
            k += 1
    return curves


def _agreement(all_starts: list[Fitted], best: Fitted, judged: Certainty) -> dict[str, Any]:
    """Return how many starts have ended at the best chi-square, and a warning if one has that no deviation confirms."""
    costs = [one.cost for one in all_starts]
    least = min((one.cost for one in all_starts if one.horizon >= 0.99 * best.horizon), default=math.inf)
    same = sum(one.cost <= least * (1.0 + _SAME) + 1e-9 and one.horizon >= 0.99 * best.horizon for one in all_starts)
    result: dict[str, Any] = {
        "count": len(costs),
        "same": same,
        "chi_square": [finite(x) for x in costs],
        "warnings": [],
    }
    explained = [p is not None and p >= DOUBT for p in judged.tests["chi_square_probability"]]
    if len(costs) > 1 and same == 1 and not all(explained):
        result["warnings"] = ["one start only has found these values: give more starts, or narrower limits"]
    return result


class _Checkpoint:
    """The starts that have ended, in a JSON file."""

    def __init__(self, path: Path | None, task: Identification, resume: bool) -> None:
        self.path, self._identity = path, json.loads(json.dumps(described(task)))
        self._rows: dict[str, dict[str, Any]] = {}
        self._lock = threading.Lock()
        if path is None or not path.exists():
            return
        if not resume:
            raise InputError("--out", str(path), "exists already; continue with --resume, or give another --out")
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            same, self._rows = content["task"] == self._identity, content["starts"]
        except (ValueError, KeyError, TypeError):
            raise InputError(path, "", "is damaged; give another --out") from None
        if not same:
            raise InputError(path, "", "is of another file or other data; give another --out")

    def known(self, name: str) -> dict[int, dict[str, Any]]:
        """Return the starts of a model that have ended, by number: fields of `Fitted`."""
        return {int(k): row for k, row in self._rows.get(name, {}).items()}

    def keep(self, name: str, k: int, found: Fitted) -> None:
        if self.path is None or found.evaluated.reason:
            return
        row = {"z": found.z.tolist(), "horizon": found.horizon, "runs": found.runs, "history": found.history}
        with self._lock:
            self._rows.setdefault(name, {})[str(k)] = row
            write_json(self.path, {"task": self._identity, "starts": self._rows})
