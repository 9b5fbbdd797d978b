"""A study with an algorithm and a seed, as a task for `optim.search.run`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, nearest
from linkages.files.toml import Table
from linkages.files.versions import versions
from optim.algorithms import registry as algorithms
from optim.evaluate.evaluator import Evaluator
from optim.evaluate.limits import equality_names, inequality_names, values_of
from optim.evaluate.screen import Screened
from optim.problem.study import Study
from optim.search.run import Task


def settings_of(study: Study) -> tuple[str, Table]:
    """Name and settings of a study's algorithm.

    Raises
    ------
    InputError
        If there is no such algorithm, it has no such setting, or it cannot solve the problem.
    """
    given = dict(study.file.algorithm)
    name = given.pop("name", None)
    if not isinstance(name, str) or name not in algorithms.ALGORITHMS:
        problem = "is missing" if name is None else f'"{name}" is unknown'
        raise InputError(
            study.source, "algorithm.name", f"{problem}; {nearest(str(name or ''), algorithms.ALGORITHMS)}"
        )
    if len(study.file.objectives) > 1 and not algorithms.ALGORITHMS[name].several:
        able = ", ".join(key for key, entry in algorithms.ALGORITHMS.items() if entry.several)
        raise InputError(study.source, "algorithm.name", f'"{name}" takes one objective; of several: {able}')
    return name, algorithms.settings_of(name, given, f"{study.source.name}: algorithm")


def described(study: Study) -> dict[str, Any]:
    """Return the algorithm's name and all its settings, as JSON types."""
    name, settings = settings_of(study)
    return {"name": name, **settings.model_dump(mode="json")}


def task_of(study: Study, seed: int, evaluator: Evaluator, start: NDArray[np.float64] | None = None) -> Task:
    """Make the task of solving a study from a start (n,), by default its nominal design.

    Designs that the study's formulas exclude are not run.

    Raises
    ------
    InputError
        As `settings_of`.
    """
    name, settings = settings_of(study)
    return Task(
        {
            "algorithm": described(study),
            "seed": seed,
            "start": None if start is None else start.tolist(),
            **study.description(),
        },
        versions(),
        study.paths,
        tuple(study.file.objectives),
        tuple(study.file.constraints),
        study.lower,
        study.upper,
        study.nominal,
        study.nominal if start is None else start,
        Screened(study, evaluator, getattr(settings, "step", None)),
        lambda found, nominal: values_of(study, found, nominal),
        lambda problem, progress: algorithms.optimise(name, problem, settings, seed, progress),
        inequality_names(study),
        equality_names(study),
    )
