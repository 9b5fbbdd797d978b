"""All algorithms by name, with their settings: `minimise`.

An algorithm is a function ``(problem, settings, seed, progress) -> Result`` that depends on nothing else: run again
with the same arguments it evaluates the same designs in the same order. So a run that was stopped is resumed by
running it again on the stored values.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from linkages import InputError
from linkages.base.arguments import Whole, validated
from linkages.base.errors import nearest
from linkages.base.packages import check_installed
from linkages.input.files.toml import Table, validate
from optim.algorithms.archive import Archive, by_feasibility, latin_hypercube
from optim.algorithms.nlp import Array, Ending, Problem, Progress, Report, Result, Values

Minimiser = Callable[[Problem, Any, int, Report | None], Result]
#: Violation up to which a start's result counts as feasible when the best one is taken.
TOLERANCE = 1e-6


class Algorithm(NamedTuple):
    """An algorithm by the names of its parts, so that it is imported only when it is used."""

    module: str
    function: str
    settings: str
    summary: str
    local: bool = False  # searches from a start; its settings have a key `starts`
    several: bool = False  # takes several objectives
    revision: int = 1  # larger if other designs come from a seed than in earlier versions: their stores are refused
    package: str = ""  # that it needs besides the dependencies of all systems

    @property
    def table(self) -> type[Table]:
        """Its settings."""
        return getattr(import_module(self.module), self.settings)

    @property
    def solver(self) -> Minimiser:
        """The function."""
        return getattr(import_module(self.module), self.function)


ALGORITHMS = {
    "ga": Algorithm("optim.algorithms.ga", "genetic", "Genetic", "genetic algorithm of pygad", revision=2),
    "nsga2": Algorithm(
        "optim.algorithms.ga",
        "nondominated_sorting",
        "NondominatedSorting",
        "genetic algorithm of pygad for several objectives",
        several=True,
        revision=2,
    ),
    "grg": Algorithm(
        "optim.algorithms.gradient",
        "reduced_gradient",
        "ReducedGradient",
        "generalised reduced gradient",
        local=True,
        revision=3,
    ),
    "snopt": Algorithm(
        "optim.algorithms.snopt",
        "snopt",
        "Snopt",
        "sequential quadratic programming, Drake's SNOPT",
        local=True,
        package="pydrake",
    ),
    "differential-evolution": Algorithm(
        "optim.algorithms.evolution", "evolve", "DifferentialEvolution", "differential evolution, SciPy's"
    ),
}


def read_settings(name: str, data: Mapping[str, Any], source: Path | str = "settings") -> Table:
    """Read the settings of an algorithm from the values of a table; missing keys have their default.

    InputError, which names the source, if there is no such algorithm, or a value is wrong.
    """
    return validate(_find(name, source).table, data, Path(source))


@validated
def minimise(
    name: str,
    problem: Problem,
    settings: Table | Mapping[str, Any] | None = None,
    seed: Whole = 0,
    progress: Report | None = None,
) -> Result:
    """Solve a problem by an algorithm.

    Parameters
    ----------
    name : str
        Key of `ALGORITHMS`.
    problem : Problem
        With finite bounds; a local method with a single start can do with `Problem.start` instead.
    settings : Table or mapping, optional
        Settings of this algorithm; missing keys have their default.
    seed : int
        Not negative.
    progress : callable, optional
        Called after each iteration; if it raises KeyboardInterrupt, the best design so far is returned.

    Raises
    ------
    InputError
        If there is no such algorithm, a setting is wrong, or it cannot solve such a problem.

    Examples
    --------
    >>> import numpy as np
    >>> import optim
    >>> def evaluate(designs):
    ...     m = len(designs)
    ...     distance = ((designs - 0.25) ** 2).sum(axis=1, keepdims=True)
    ...     return optim.Values(distance, np.empty((m, 0)), np.empty((m, 0)), np.zeros(m, dtype=bool))
    >>> problem = optim.Problem(np.zeros(2), np.ones(2), evaluate)
    >>> optim.minimise("grg", problem).x.round(6)
    array([[0.25, 0.25]])
    """
    algorithm = _find(name, "algorithm")
    if not isinstance(settings, Table):
        settings = read_settings(name, settings or {})
    no = len(problem.objectives)
    if no > 1 and not algorithm.several:
        several = ", ".join(key for key, other in ALGORITHMS.items() if other.several)
        raise InputError("algorithm", name, f"takes one objective and this problem has {no}: use {several}")
    starts = getattr(settings, "starts", 1)
    bounded = bool(np.all(np.isfinite(problem.lower) & np.isfinite(problem.upper)))
    if not bounded and (not algorithm.local or starts > 1 or problem.start is None):
        raise InputError("algorithm", name, "needs finite bounds of all variables")
    if np.any(problem.lower > problem.upper):
        worst = int(np.argmax(problem.lower - problem.upper))
        raise InputError("problem", f"variable {worst + 1}", "its lower bound is above its upper bound")
    if algorithm.local and starts > 1:
        return _multistart(algorithm.solver, problem, settings, starts, seed, progress)
    return algorithm.solver(problem, settings, seed, progress)


def start_designs(problem: Problem, count: int, seed: int) -> Array:
    """Choose starts of a local method, (count, n): the nominal design or the middle, then a Latin hypercube."""
    sample = latin_hypercube(count - 1, problem.size, np.random.default_rng(seed))
    return np.vstack([problem.first, problem.lower + sample * (problem.upper - problem.lower)])


def _multistart(
    solver: Minimiser, problem: Problem, settings: Any, starts: int, seed: int, progress: Report | None
) -> Result:
    archive = Archive(problem)  # of all starts: none evaluates what another one did
    problem = dataclasses.replace(problem, evaluate=archive)
    runs: list[Result] = []
    report = None if progress is None else _report(progress, runs, starts)
    for start in start_designs(problem, starts, seed):
        runs.append(solver(dataclasses.replace(problem, start=start), settings, seed, report))
        if runs[-1].status is Ending.INTERRUPTED:
            break
    best = runs[int(by_feasibility(Values.join([run.values for run in runs]), TOLERANCE)[0])]
    status = Ending.INTERRUPTED if runs[-1].status is Ending.INTERRUPTED else best.status
    iterations = sum(run.iterations for run in runs)
    return Result(best.x, best.values, status, iterations, len(archive), tuple(runs))


def _report(progress: Report, runs: list[Result], starts: int) -> Report:
    """Progress of all starts during the next one: the best of all, iterations as parts of all budgets."""

    def report(step: Progress) -> None:
        values = Values.join([*(run.values for run in runs), step.values])
        row = by_feasibility(values, TOLERANCE)[:1]
        best = np.vstack([*(run.x for run in runs), step.best])[row]
        iteration, state = len(runs) * step.iterations + step.iteration, {"start": len(runs), **step.state}
        progress(Progress(iteration, starts * step.iterations, best, values.take(row), state))

    return report


def _find(name: str, source: Path | str) -> Algorithm:
    if name not in ALGORITHMS:
        raise InputError(source, name, f"no such algorithm; {nearest(name, ALGORITHMS)}")
    if package := ALGORITHMS[name].package:
        check_installed(package, str(source), name)
    return ALGORITHMS[name]
