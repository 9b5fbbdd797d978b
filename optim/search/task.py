"""A study with its algorithm and a seed, as a task for `optim.search.run`."""

from __future__ import annotations

import dataclasses
from typing import Any

from linkages import InputError
from linkages.errors import nearest
from linkages.files.toml import Table
from linkages.files.versions import versions
from optim.algorithms.derivatives import DIFFERENCES
from optim.algorithms.nlp import Problem
from optim.algorithms.registry import ALGORITHMS, minimise, read_settings
from optim.evaluate.evaluations import Evaluations
from optim.evaluate.evaluator import Evaluator
from optim.evaluate.gradients import Gradients, check_sensitivities
from optim.evaluate.limits import problem_of
from optim.evaluate.screen import Screened
from optim.problem.study import Array, Study
from optim.search.run import Evaluate, Task


def settings_of(study: Study) -> tuple[str, Table]:
    """Name and settings of a study's algorithm.

    Raises
    ------
    InputError
        If there is no such algorithm, it has no such setting, or it cannot solve the problem.
    """
    given = dict(study.file.algorithm)
    name = given.pop("name", None)
    if not isinstance(name, str) or name not in ALGORITHMS:
        problem = "is missing" if name is None else f'"{name}" is unknown'
        near = nearest(str(name or ""), ALGORITHMS)
        raise InputError(study.source, "algorithm.name", f"{problem}; {near}")
    if len(study.file.objectives) > 1 and not ALGORITHMS[name].several:
        able = ", ".join(key for key, entry in ALGORITHMS.items() if entry.several)
        raise InputError(study.source, "algorithm.name", f'"{name}" takes one objective; of several: {able}')
    return name, read_settings(name, given, f"{study.source.name}: algorithm")


def described(study: Study) -> dict[str, Any]:
    """Return the algorithm's name and all its settings, as JSON types."""
    name, settings = settings_of(study)
    return {"name": name, **settings.model_dump(mode="json")}


def task_of(study: Study, seed: int, evaluator: Evaluator, start: Array | None = None) -> Task:
    """Make the task of solving a study.

    Designs that the study's formulas exclude are not run.

    Parameters
    ----------
    study : Study
    seed : int
    evaluator : Evaluator
    start : (n,) array, optional
        Where the search begins; default the nominal design.

    Raises
    ------
    InputError
        As `settings_of`; or if an output has no sensitivities and the algorithm is to use them.
    """
    name, settings = settings_of(study)
    given = None if start is None else start.tolist()
    by_sensitivities = getattr(settings, "derivatives", DIFFERENCES) != DIFFERENCES
    if by_sensitivities:
        check_sensitivities(study)

    def problem(evaluate: Evaluate, nominal: Evaluations) -> Problem:
        found = problem_of(study, evaluate, nominal, start)
        if not by_sensitivities:
            return found
        return dataclasses.replace(found, jacobian=Gradients(study, evaluate, nominal, evaluator.threads))

    algorithm = described(study)
    if not by_sensitivities:  # stores from before this setting have no such key, and can be resumed
        algorithm.pop("derivatives", None)
    description = {"algorithm": algorithm, "seed": seed, "start": given, **study.description()}
    revision = ALGORITHMS[name].revision
    return Task(
        description | ({"revision": revision} if revision > 1 else {}),
        versions("pygad"),
        study.paths,
        tuple(study.file.objectives),
        tuple(study.file.constraints),
        study.nominal,
        Screened(study, evaluator, getattr(settings, "step", None)),
        problem,
        lambda problem, progress: minimise(name, problem, settings, seed, progress),
    )
