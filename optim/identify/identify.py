"""`identify`: the values that explain measurements."""

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

from linkages import InputError, RunError
from linkages.base.arguments import Count, validated
from linkages.base.packages import check_installed
from linkages.input.files.toml import leaves
from linkages.input.files.versions import versions
from linkages.input.files.writing import write_json
from optim.identify.accuracy import ErrorOfRuns, accurate
from optim.identify.budget import extend, search_budget
from optim.identify.certainty import Certainty, certainty
from optim.identify.content import agreement, best_prediction, content_of, other_laws, parameters, prediction
from optim.identify.fit import Fitted, agreeing, best_of, fit_all, hopeless, refine, starts
from optim.identify.load import Identification, described
from optim.identify.numerics import IDENTIFY_BETTER, IDENTIFY_HALF, IDENTIFY_NEW, IDENTIFY_ROUNDS
from optim.identify.posterior import posterior
from optim.identify.profile import profile
from optim.identify.residuals import Residuals
from optim.identify.result import Alternative, IdentificationResult
from optim.identify.statistics import Statistics

SAMPLES = "posterior.bin"  # keeps samples, in the folder of the checkpoint


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
) -> IdentificationResult:
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
    IdentificationResult
        Attributes and keys of ``result.json``, SI units: ``parameters``: by name ``path``, ``value``, ``deviation`` and
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
    >>> interval = found.parameters["mass"].interval
    >>> interval.lower < 0.152 < interval.upper  # kg
    True
    """
    if not task.measurements:
        raise InputError(task.source, "data", "is missing; add [data.NAME] with file and columns, or give --plan")
    if samples:
        check_installed("emcee", "--posterior")
        if task.file.fit.windows == "statistics":
            raise InputError(
                task.source, "fit.windows", 'is "statistics", which have no posterior; leave out --posterior'
            )
    begun = time.perf_counter()
    share = task.file.fit.predict or (IDENTIFY_HALF if task.file.alternatives else 0.0)
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
    residuals, found, judged, all_starts, runs = results[""]
    content = content_of(residuals, found, judged, share, runs)
    content["starts"], doubt = agreement(all_starts, found, judged)
    content["warnings"] += doubt
    if task.file.alternatives:
        content["alternatives"] = {
            name or "this": Alternative(
                prediction=prediction(*results[name][:2], share),
                chi_square=results[name][1].cost,
                parameters=parameters(*results[name][:3]),
            )
            for name in results
        }
        content["best_alternative"] = best_prediction(content["alternatives"], residuals)
        content["other_laws"] = other_laws(content["alternatives"], residuals)
    if profiles:
        for k, name in enumerate(residuals.names[: len(residuals.active)]):
            show(f"profile of {name}")
            followed = profile(residuals, found, judged, k)
            content["parameters"][name] = content["parameters"][name].model_copy(update=followed._asdict())
    if samples:
        store = None if checkpoint is None else checkpoint.with_name(SAMPLES)
        content["posterior"] = sampled = posterior(residuals, found, judged, threads, show, store)
        if not sampled.enough:
            content["warnings"].append(
                f"the posterior has {sampled.autocorrelation_times:.2g} autocorrelation times, not 50:"
                " its intervals are uncertain; raise fit.posterior_runs, and continue with --resume"
            )
    return IdentificationResult(
        **content,
        time_over=any(runs.ended for *_, runs in results.values()),
        title=task.title,
        file=described(task),
        runs=sum(one.runs for one in all_starts) + max(found.runs - max(one.runs for one in all_starts), 0),
        versions=dict(versions("scipy")),
        wall_time=time.perf_counter() - begun,
    )


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
) -> tuple[Residuals, Fitted, Certainty, list[Fitted], ErrorOfRuns]:
    fit = residuals.task.file.fit
    residuals.budget = search_budget(fit.time)
    first, last = residuals.span()
    last = last - share * (last - first)
    touches = any(one.system.can_touch for one in residuals.task.measurements)
    windows = fit.windows or ("impacts" if touches else "all")
    found: list[Fitted] = []
    points = starts(residuals, fit.starts, fit.seed, last, windows)
    keep, known = partial(kept.keep, name), kept.known(name)
    for more in range(1, IDENTIFY_ROUNDS + 2):
        least = best_of(residuals, found).cost if found else math.inf
        found += fit_all(residuals, points, len(found), last, windows, *where, known, keep, show, more > 1)
        best = best_of(residuals, found)
        if not hopeless(residuals, best) or best.cost > IDENTIFY_BETTER * least or residuals.budget.late:
            break
        points = starts(residuals, IDENTIFY_NEW + 1, fit.seed + more, last, windows)[1:]
    if best.evaluated.reason:
        raise RunError(
            f"no start can be fitted: {best.evaluated.reason}; change the start or the limits of the unknowns"
        )
    ended = residuals.budget.late
    extend(residuals.budget)
    residuals, best, runs = accurate(residuals, refine(residuals, best), show, not ended)
    single = len(found) > 1 and agreeing(found, best) == 1
    judged = certainty(residuals, best, fit.deviations, runs.shift, single or ended)
    return residuals, best, judged, found, replace(runs, ended=ended or runs.ended)


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
