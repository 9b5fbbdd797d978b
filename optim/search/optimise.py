"""`optimise`: solve a study; the content of ``result.json``."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from linkages.arguments import Vector, Whole, fitting, validated
from optim.algorithms import pareto
from optim.evaluate.evaluations import INFEASIBLE, Evaluations, finite
from optim.evaluate.evaluator import Evaluator
from optim.evaluate.limits import FEASIBLE, in_units, values_of
from optim.problem.study import Array, Study
from optim.search.run import Observer, Outcome, run
from optim.search.task import described, task_of


@validated
def optimise(
    study: Study,
    store: Path | None = None,
    *,
    algorithm: str | Mapping[str, Any] | None = None,
    seed: Whole | None = None,
    start: Vector | None = None,
    evaluator: Evaluator | None = None,
    resume: bool = False,
    observe: Observer | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> dict[str, Any]:
    """Solve a study.

    Parameters
    ----------
    study : Study
    store : Path, optional
        File that keeps every evaluation, ``study.sqlite``; default a temporary one.
    algorithm : str or mapping, optional
        Its name, or a table of its name and settings; default the study's.
    seed : int, optional
        Default the study's.
    start : (n,) array, optional
        Where the search begins; default the nominal design.
    evaluator : Evaluator, optional
        Default one that runs here, in all threads.
    resume : bool
        Whether the store may exist; it must be of the same study, algorithm, start and seed.
    observe : callable, optional
        Called after every iteration with an `Iteration` and the `Values` of the nominal design.
    stop : callable, optional
        Asked after every iteration whether to stop.

    Returns
    -------
    dict
        The content of ``result.json``, SI units; relative quantities are multiples of the nominal design's. See
        docs/study_files.md.

    Raises
    ------
    InputError
        If the study's algorithm cannot solve it, or the store cannot be used.
    RunError
        If the disk is full, relative quantities have no nominal value, or a replay differs from the store.
    Stopped
        If `stop` said so.

    Examples
    --------
    >>> import optim
    >>> study = optim.load_study(optim.find_study("sevenbar_force"))
    >>> result = optim.optimise(study, algorithm={"name": "ga", "population": 6, "generations": 3})
    >>> result["best"]["objectives"]["force"] < result["nominal"]["objectives"]["force"]
    True
    """
    if algorithm is not None:
        table = {"name": algorithm} if isinstance(algorithm, str) else dict(algorithm)
        file = study.file.model_copy(update={"algorithm": table})
        study = dataclasses.replace(study, file=file)
    if start is not None:
        fitting(start, len(study.names), "start", "variables")
    seed = study.file.seed if seed is None else seed
    evaluate = Evaluator(study) if evaluator is None else evaluator
    task = task_of(study, seed, evaluate, start)
    with ExitStack() as stack:
        if store is None:
            store = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "study.sqlite"
        outcome = run(task, store, resume, observe, stop)
    result = _summarized(study, outcome, seed, task.versions, start)
    if study.designs:
        references = np.array([*study.designs.values()])
        entries = _entries(study, references, evaluate(references), outcome.nominal)
        result["designs"] = dict(zip(study.designs, entries, strict=True))
    return result


def compromise(objectives: Array) -> int:
    """Index of the design to name first in a Pareto front (k, no), whose objectives are minimised.

    The knee, or, without one, the design nearest to the ideal point, each objective measured by its range.
    """
    if not np.isfinite(objectives).all():
        return 0
    found = pareto.knee(objectives)
    if found is not None:
        return found
    span = np.ptp(objectives, axis=0)
    scaled = (objectives - objectives.min(axis=0)) / np.where(span > 0.0, span, 1.0)
    return int(np.argmin(np.linalg.norm(scaled, axis=1)))


def _summarized(
    study: Study, outcome: Outcome, seed: int, versions: dict[str, str], start: Array | None
) -> dict[str, Any]:
    """Make the content of ``result.json``, the reference designs aside."""
    designs = np.atleast_2d(outcome.result.x)
    values = values_of(study, outcome.found, outcome.nominal)
    several = len(study.file.objectives) > 1
    entries = _entries(study, designs, outcome.found, outcome.nominal)
    best = compromise(values.objectives) if several else 0
    failures = {status: n for status, n in outcome.failures.items() if status != INFEASIBLE}
    return {
        "study": study.source.stem,
        "title": study.title,
        "algorithm": described(study),
        "labels": {name: study.label(name) for _, name, _ in study.quantities},
        "seed": seed,
        "start": None if start is None else dict(zip(study.paths, map(float, start), strict=True)),
        "status": outcome.result.status,
        "best": entries[best],
        "front": entries if several else [],
        "nominal": _entries(study, study.nominal[None], outcome.nominal, outcome.nominal)[0],
        "designs": {},
        "iterations": outcome.result.iterations,
        "evaluations": outcome.evaluations,
        "unrun": outcome.failures.get(INFEASIBLE, 0),
        "failed": sum(failures.values()),
        "failures": failures,
        "versions": versions,
        "wall_time": outcome.elapsed,
    }


def _entries(study: Study, designs: Array, found: Evaluations, nominal: Evaluations) -> list[dict[str, Any]]:
    """Designs (m, n) as JSON types; None where one failed."""
    objectives, constraints = in_units(study, found, nominal)
    violation = values_of(study, found, nominal).violation
    point, n = study.points[0], len(study.paths)
    entries = []
    for k, design in enumerate(designs):
        row = study.row(design, point)
        entry: dict[str, Any] = {
            "variables": dict(zip(study.paths, row[:n], strict=True)),
            "linked": dict(zip(point.paths[n:], row[n:], strict=True)),
            "objectives": dict(zip(study.file.objectives, map(finite, objectives[k]), strict=True)),
            "constraints": dict(zip(study.file.constraints, map(finite, constraints[k]), strict=True)),
            "feasible": bool(violation[k] <= FEASIBLE),
            "status": found.status[k],
        }
        entries.append(entry | ({"reason": found.reason[k]} if found.reason[k] else {}))
    return entries
