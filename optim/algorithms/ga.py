"""Genetic algorithms on pygad: one objective with elitism, several with the survival of NSGA-II.

pygad supplies the generations, simulated binary crossover, polynomial mutation and two random generators of its own.
The choice between designs is ours and enters through its callable operators: pygad orders by finite scalar fitness,
knows no constraints, and in its NSGA-II parents and children do not compete. Its probability of mutation is that of
each gene, and so it is here.

K. Deb, R. B. Agrawal, Simulated binary crossover for continuous search space, Complex Systems 9 (1995) 115-148.
K. Deb et al., A fast and elitist multiobjective genetic algorithm: NSGA-II, IEEE Transactions on Evolutionary
Computation 6 (2002) 182-197.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import InitVar, dataclass, replace
from typing import Annotated, Any

import numpy as np
import pygad
from pydantic import Field
from scipy.stats import qmc

from linkages.files.toml import NonNegative, Positive, Table
from optim.algorithms.archive import Archive, by_feasibility
from optim.algorithms.nlp import Array, Ending, Indices, Problem, Progress, Report, Result, Values
from optim.algorithms.pareto import by_domination, front

#: From an evaluation by genes, the pool and its children to the survivors, the best first.
Survival = Callable[[Callable[[Array], Values], Array, Array], Array]
Probability = Annotated[float, Field(ge=0.0, le=1.0)]

# pygad prints what is raised while it runs; callers see the exceptions themselves
_silent = logging.getLogger("optim.algorithms.ga")
_silent.addHandler(logging.NullHandler())
_silent.propagate = False


class _Generations(Table):
    """Settings of both algorithms."""

    population: int = Field(30, ge=4, description="designs of a generation")
    generations: int = Field(50, ge=1, description="generations, the first one among them")
    crossover: Probability = Field(0.7, description="probability that a child is crossed")
    mutation: Probability = Field(0.6, description="probability of each variable of a child to be mutated")
    crossover_index: Positive = Field(15.0, description="distribution index of crossover: higher is nearer")
    mutation_index: Positive = Field(20.0, description="distribution index of mutation: higher is nearer")
    tolerance: NonNegative = Field(1e-6, description="violation up to which a constraint counts as satisfied")
    restarts: int = Field(1, ge=1, description="independent runs, with seeds derived from the seed")


class Genetic(_Generations):
    """Settings of the genetic algorithm; the defaults are those of Chen 2025, section 2.2, where it prints them."""

    elites: int = Field(30, ge=0, description="best designs that compete with their children")


class NondominatedSorting(_Generations):
    """Settings of the genetic algorithm for several objectives."""

    population: int = Field(100, ge=4, description="designs of a generation")
    generations: int = Field(100, ge=1, description="generations, the first one among them")
    crossover: Probability = Field(0.9, description="probability that a child is crossed")
    mutation: Probability = Field(0.2, description="probability of each variable of a child to be mutated")


def genetic(problem: Problem, settings: Genetic, seed: int = 0, progress: Report | None = None) -> Result:
    """Minimise one objective; designs are ordered by the rules of feasibility.

    Parameters are those of `optim.minimise`. The problem's start is a member of the first generation; `progress` is
    called after each generation, with the states of the random generators.

    Returns
    -------
    Result
        `runs` are the restarts.
    """

    def survive(evaluate: Callable[[Array], Values], pool: Array, children: Array) -> Array:
        candidates = np.vstack([pool[: settings.elites], children])
        return candidates[by_feasibility(evaluate(candidates), settings.tolerance)[: settings.population]]

    return _restarts(problem, settings, seed, progress, survive)


def nondominated_sorting(
    problem: Problem, settings: NondominatedSorting, seed: int = 0, progress: Report | None = None
) -> Result:
    """Find the front of several objectives: parents and children compete by constrained domination and crowding.

    Parameters are those of `genetic`.

    Returns
    -------
    Result
        The front of all designs that were evaluated, by the first objective.
    """

    def survive(evaluate: Callable[[Array], Values], pool: Array, children: Array) -> Array:
        candidates = np.unique(np.vstack([pool, children]), axis=0) if len(pool) else children
        if len(candidates) < settings.population:  # copies only where there is nothing else
            candidates = np.vstack([pool, children])
        return candidates[by_domination(evaluate(candidates), settings.tolerance)[: settings.population]]

    return _restarts(problem, settings, seed, progress, survive)


def statistics(result: Result) -> dict[str, float]:
    """Best, mean, worst and standard deviation of the first objective over the feasible restarts."""
    found = np.array([run.values.objectives[0, 0] for run in result.runs if run.status != Ending.INFEASIBLE])
    if len(found) == 0:
        return {}
    names = "best", "mean", "worst", "standard deviation"
    return dict(zip(names, map(float, (found.min(), found.mean(), found.max(), found.std())), strict=True))


def _restarts(
    problem: Problem, settings: _Generations, seed: int, progress: Report | None, survive: Survival
) -> Result:
    """Run several times from seeds derived from one."""
    archive = Archive(problem)
    runs: list[Result] = []
    seeds = np.random.SeedSequence(seed).generate_state(settings.restarts)
    for i, own in enumerate(seeds):
        runs.append(_Run(problem, settings, i, progress, survive, archive, int(own)).result())
        if runs[-1].status is Ending.INTERRUPTED:
            break
    status = Ending.INTERRUPTED if runs[-1].status is Ending.INTERRUPTED else Ending.BUDGET_USED
    rows = front(archive.values, settings.tolerance)  # of one objective the best design
    return archive.result(rows, status, sum(run.iterations for run in runs), settings.tolerance, runs)


@dataclass
class _Run:
    """One run of pygad; genes are the variables relative to their bounds, in [0, 1]."""

    problem: Problem
    settings: _Generations
    number: int
    progress: Report | None
    survive: Survival
    shared: Archive  # evaluates for all restarts
    seed: InitVar[int]

    def __post_init__(self, seed: int) -> None:
        problem, settings = self.problem, self.settings
        self.archive = Archive(replace(problem, evaluate=self.shared))  # what this one saw
        self.pool = np.empty((0, problem.size))
        self.generation = 0
        random = np.random.default_rng(seed)
        first = qmc.LatinHypercube(problem.size, rng=random).random(settings.population)
        if problem.start is not None:
            width = np.where(problem.upper > problem.lower, problem.upper - problem.lower, 1.0)
            first[0] = np.clip((problem.start - problem.lower) / width, 0.0, 1.0)
        self.pygad = pygad.GA(
            num_generations=settings.generations - 1,  # pygad does not count the first one
            num_parents_mating=settings.population,
            fitness_func=self._fitness,
            fitness_batch_size=settings.population,
            initial_population=first,
            init_range_low=0.0,
            init_range_high=1.0,
            parent_selection_type=self._select,
            # the population of pygad is the children; what lives on is in the pool
            keep_elitism=0,
            keep_parents=0,
            crossover_type=self._cross,
            sbx_crossover_eta=settings.crossover_index,
            mutation_type="polynomial",
            mutation_probability=settings.mutation,
            polynomial_mutation_eta=settings.mutation_index,
            random_seed=seed,
            logger=_silent,
            suppress_warnings=True,
        )

    def result(self) -> Result:
        """Run, and return what was found."""
        status = Ending.INTERRUPTED
        with self.archive.interruptible():
            self.pygad.run()
            status = Ending.BUDGET_USED
        rows = front(self.archive.values, self.settings.tolerance)
        return self.archive.result(rows, status, self.generation, self.settings.tolerance)

    def _values(self, genes: Array) -> Values:
        lower, upper = self.problem.lower, self.problem.upper
        return self.archive(np.clip(lower + genes * (upper - lower), lower, upper))

    def _fitness(self, ga: Any, genes: Array, indices: Any) -> list[float]:
        """Evaluate the children in one call, let the next pool survive; pygad's own order is not used."""
        genes = np.asarray(genes, dtype=float)
        self._values(genes)
        self.pool = self.survive(self._values, self.pool, genes)
        self.generation += 1
        if self.progress is not None:
            self.progress(self._progress(ga))
        return [0.0] * len(genes)

    def _select(self, fitness: Array, count: int, ga: Any) -> tuple[Array, Indices]:
        """Binary tournaments; the pool is in order, so the lower row wins."""
        rows = ga.numpy_random_generator.randint(0, len(self.pool), size=(count, 2)).min(axis=1)
        return self.pool[rows], rows

    def _cross(self, parents: Array, size: tuple[int, int], ga: Any) -> Array:
        """Cross each parent with the next one, or copy it.

        The probability is that of a child to be crossed, as usual; pygad's is that of a parent to be eligible, so
        that nearly every child is crossed.
        """
        children = ga.sbx_crossover(parents, size)
        copied = ga.numpy_random_generator.random(size[0]) >= self.settings.crossover
        children[copied] = parents[np.flatnonzero(copied) % len(parents)]
        return np.asarray(children)

    def _progress(self, ga: Any) -> Progress:
        rows, count = front(self.shared.values, self.settings.tolerance), self.settings.generations
        done, total = self.number * count + self.generation, self.settings.restarts * count
        kind, keys, *rest = ga.numpy_random_generator.get_state()
        version, words, gauss = ga.python_random_generator.getstate()
        state = {
            "restart": self.number,
            "generation": self.generation,
            "pool": self.pool.tolist(),
            "numpy": [kind, keys.tolist(), *rest],
            "python": [version, list(words), gauss],
        }
        return Progress(done, total, self.shared.designs[rows], self.shared.values.take(rows), state)
