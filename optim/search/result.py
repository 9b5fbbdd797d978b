"""The result of an optimisation as data, which is the content of ``result.json`` too."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from pydantic import Field

from linkages.input.files.entry import Entry, Number
from linkages.input.files.writing import finite
from optim.algorithms import pareto
from optim.algorithms.nlp import Result
from optim.evaluate.evaluations import INFEASIBLE, OK, Evaluations
from optim.evaluate.limits import FEASIBLE, in_units, values_of
from optim.problem.study import Array, Study
from optim.search.task import Task


class Design(Entry):
    """A design: its values in SI units by dotted path, and its objectives and constraints, None where it failed."""

    variables: dict[str, float]
    linked: dict[str, float]
    objectives: dict[str, Number]
    constraints: dict[str, Number]
    feasible: bool
    status: str
    reason: str = ""


class StudyResult(Entry):
    """The result of an optimisation; made by `optim.optimise`.

    Its numbers are attributes, ``result.best.objectives["force"]``, and entries, ``result["best"]``; its `content` is
    that of ``result.json``. SI units; relative quantities are multiples of the nominal design's.

    Attributes
    ----------
    algorithm : dict
        Name and settings.
    labels : dict of str to str
        Names of objectives and constraints with their units.
    start : dict of str to float or None
        Where the search began, by dotted path; None for the nominal design.
    best : Design
        Of several objectives the compromise.
    front : list of Design
        Pareto front; empty for one objective.
    designs : dict of str to Design
        Reference designs of the study.
    unrun, failed : int
        Numbers of designs that formulas exclude, and of designs that failed, by reason in `failures`.
    wall_time : float
        Time spent on the study by all processes [s].
    derivatives, verification : dict
        Checks that a command adds.
    """

    study: str
    title: str
    algorithm: dict[str, Any]
    labels: dict[str, str]
    seed: int
    start: dict[str, float] | None
    status: str
    best: Design
    front: list[Design]
    nominal: Design
    designs: dict[str, Design]
    iterations: int
    evaluations: int
    unrun: int
    failed: int
    failures: dict[str, int]
    versions: dict[str, str]
    wall_time: float
    derivatives: dict[str, Any] = Field(default={})
    verification: dict[str, Any] = Field(default={})


class Solution(NamedTuple):
    """What a search has found: its result, the evaluations of its designs, and the store's counts and time [s]."""

    found: Result
    evaluations: Evaluations
    evaluated: int
    failures: dict[str, int]
    elapsed: float


def result_of(
    study: Study, task: Task, solution: Solution, nominal: Evaluations, evaluate: Callable[[Array], Evaluations]
) -> StudyResult:
    """Describe the solution of a study; `nominal` evaluates the nominal design alone."""
    found, failures = solution.found, dict(solution.failures)
    unrun, several = failures.pop(INFEASIBLE, 0), len(study.file.objectives) > 1
    start = None if task.start is None else dict(zip(study.paths, map(float, task.start), strict=True))
    described = [(study.nominal[None], nominal), (np.atleast_2d(found.x), solution.evaluations)]
    if study.designs:
        references = np.array([*study.designs.values()])
        described.append((references, evaluate(references)))
    (first,), entries, *known = (_entries(study, designs, values, nominal) for designs, values in described)
    labels = {name: study.label(name) for _, name, _ in study.quantities}
    minimised = _minimised(study, entries)
    best = entries[compromise(minimised) if several else 0]
    return StudyResult(
        study=study.source.stem,
        title=study.title,
        algorithm={"name": task.name, **task.settings.model_dump(mode="json")},
        labels=labels,
        seed=task.seed,
        start=start,
        status=found.status,
        best=best,
        front=entries if several else [],
        nominal=first,
        designs=dict(zip(study.designs, known[0] if known else [], strict=True)),
        iterations=found.iterations,
        evaluations=solution.evaluated,
        unrun=unrun,
        failed=sum(failures.values()),
        failures=failures,
        versions=task.identity["versions"],
        wall_time=solution.elapsed,
    )


def _entries(study: Study, designs: Array, found: Evaluations, nominal: Evaluations) -> list[Design]:
    """Describe designs (m, n) with their evaluations."""
    objectives, constraints = in_units(study, found, nominal)
    violation = values_of(study, found, nominal).violation
    point, n = study.points[0], len(study.usual)
    entries = []
    for k, design in enumerate(designs):
        reason = {"reason": found.reason[k]} if found.reason[k] else {}
        entry = Design(
            variables=dict(zip(study.paths, map(float, design), strict=True)),
            linked=dict(zip(point.paths[n:], study.row(design, point)[n:], strict=True)),
            objectives=dict(zip(study.file.objectives, map(finite, objectives[k]), strict=True)),
            constraints=dict(zip(study.file.constraints, map(finite, constraints[k]), strict=True)),
            feasible=bool(violation[k] <= FEASIBLE),
            status=found.status[k],
            **reason,
        )
        entries.append(entry)
    return entries


def _minimised(study: Study, entries: Sequence[Design]) -> Array:
    """Return the objectives of designs (m, no) as they are minimised; infinite where one has no value."""
    signs = dict(zip(study.file.objectives, study.signs, strict=True))

    def value(entry: Design, name: str) -> float:
        found = entry.objectives[name] if entry.status == OK else None
        return math.inf if found is None else found * signs[name]

    return np.array([[value(entry, name) for name in signs] for entry in entries])


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
