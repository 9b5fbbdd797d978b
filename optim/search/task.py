"""What a study asks of an algorithm: its settings, and the identity by which a store knows the study."""

from __future__ import annotations

from typing import Any, NamedTuple

from linkages import InputError
from linkages.base.arguments import fitting
from linkages.base.errors import nearest
from linkages.input.files.toml import Table
from linkages.input.files.versions import versions
from optim.algorithms.derivatives import DIFFERENCES
from optim.algorithms.nlp import Problem, Report, Result
from optim.algorithms.registry import ALGORITHMS, minimise, read_settings
from optim.evaluate.gradients import check_sensitivities
from optim.problem.study import Array, Study


class Task(NamedTuple):
    """What an algorithm is asked: its name, settings and seed, the start of the search, and the study's identity."""

    name: str
    settings: Table
    seed: int
    start: Array | None
    identity: dict[str, Any]

    @property
    def by_sensitivities(self) -> bool:
        """Check whether derivatives come from sensitivities of runs."""
        return getattr(self.settings, "derivatives", DIFFERENCES) != DIFFERENCES

    @property
    def step(self) -> float | None:
        """Return the step of the algorithm's differences, if it has one."""
        return getattr(self.settings, "step", None)

    def minimise(self, problem: Problem, report: Report) -> Result:
        """Run the algorithm."""
        return minimise(self.name, problem, self.settings, self.seed, report)


def task_of(study: Study, seed: int | None = None, start: Array | None = None) -> Task:
    """Return the task of a study with a seed (default the study's); InputError if its algorithm cannot solve it."""
    seed = study.file.seed if seed is None else seed
    task = Task(*settings_of(study), seed, start, identity_of(study, seed, start))
    if task.by_sensitivities:
        check_sensitivities(study)
    if start is not None:
        fitting(start, len(study.names), "start", "variables")
    return task


def settings_of(study: Study) -> tuple[str, Table]:
    """Name and settings of a study's algorithm.

    InputError if there is no such algorithm, it has no such setting, or it cannot solve the problem.
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


def identity_of(study: Study, seed: int, start: Array | None = None) -> dict[str, Any]:
    """Return what tells the store of a study from others, see `optim.search.recorder.recording`."""
    name, settings = settings_of(study)
    algorithm, revision = {"name": name, **settings.model_dump(mode="json")}, ALGORITHMS[name].revision
    if algorithm.get("derivatives") == DIFFERENCES:  # stores from before this setting have no such key
        del algorithm["derivatives"]
    task = {"algorithm": algorithm, "seed": seed, "start": None if start is None else start.tolist()}
    task |= study.description() | ({"revision": revision} if revision > 1 else {})
    return {
        "task": task,
        "versions": versions("pygad"),
        "variables": study.paths,
        "objectives": tuple(study.file.objectives),
        "constraints": tuple(study.file.constraints),
    }
