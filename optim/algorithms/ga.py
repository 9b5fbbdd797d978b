"""Genetic algorithms of pygad: one objective, and NSGA-II for several objectives.

pygad supplies selection by tournament, simulated binary crossover, polynomial mutation, elitism, non-dominated sorting
and crowding. `population` children and the elites compete for the places of the next elites. With as many elites as
children this is the survival of NSGA-II, in which parents and children compete.

pygad maximises a fitness without constraints. The fitness is the negative objective, scaled by the range of the first
generation; an infeasible design has a lower fitness than any feasible one, in order of its violation. So designs are
ordered by the rules of feasibility and by constrained domination.

K. Deb, R. B. Agrawal, Simulated binary crossover for continuous search space, Complex Systems 9 (1995) 115-148.
K. Deb et al., A fast and elitist multiobjective genetic algorithm: NSGA-II, IEEE Transactions on Evolutionary
Computation 6 (2002) 182-197. K. Deb, An efficient constraint handling method for genetic algorithms, Computer Methods
in Applied Mechanics and Engineering 186 (2000) 311-338.
"""

from __future__ import annotations

import logging
from dataclasses import InitVar, dataclass, replace
from typing import Annotated, Any

import numpy as np
import pygad
from pydantic import Field

from linkages.base.arrays import Indices
from linkages.input.files.toml import NonNegative, Positive, Table
from optim.algorithms.archive import Archive, latin_hypercube
from optim.algorithms.nlp import Array, Ending, Problem, Progress, Report, Result, Values
from optim.algorithms.numerics import GA_EQUAL, GA_TOURNAMENT, GA_VIOLATION, GA_WORST
from optim.algorithms.pareto import ranks

Probability = Annotated[float, Field(ge=0.0, le=1.0)]


# pygad logs exceptions; callers get the exceptions themselves
_silent = logging.getLogger("optim.algorithms.ga")
_silent.addHandler(logging.NullHandler())
_silent.propagate = False


class _Generations(Table):
    population: int = Field(30, ge=4, description="children of a generation; the first one has the elites in addition")
    generations: int = Field(50, ge=1, description="generations, including the first one")
    crossover: Probability = Field(
        0.7, description="probability of each parent to take part in the crossover of a child"
    )
    mutation: Probability = Field(0.6, description="probability of each variable of a child to be mutated")
    crossover_index: Positive = Field(
        15.0, description="distribution index of crossover; a higher one gives nearer children"
    )
    mutation_index: Positive = Field(
        20.0, description="distribution index of mutation; a higher one gives smaller changes"
    )
    tolerance: NonNegative = Field(1e-6, description="violation up to which a constraint counts as satisfied")
    restarts: int = Field(1, ge=1, description="independent runs, with seeds derived from the seed")


class Genetic(_Generations):
    """Settings of the genetic algorithm; the defaults are the values of Chen 2025, section 2.2, as far as printed."""

    elites: int = Field(30, ge=0, description="best designs that are kept beyond the children; at most the population")


class NondominatedSorting(_Generations):
    """Settings of the genetic algorithm for several objectives."""

    population: int = Field(100, ge=4, description="children of a generation, and elites")
    generations: int = Field(100, ge=1, description="generations, including the first one")
    crossover: Probability = Field(
        0.9, description="probability of each parent to take part in the crossover of a child"
    )
    mutation: Probability = Field(0.2, description="probability of each variable of a child to be mutated")


def genetic(problem: Problem, settings: Genetic, seed: int = 0, progress: Report | None = None) -> Result:
    """Minimise one objective; `Result.runs` are the restarts.

    Parameters as in `optim.minimise`. The problem's start is a member of the first generation; `progress` is called
    after each generation, with the states of the random generators.
    """
    return _restarts(problem, settings, seed, progress, min(settings.elites, settings.population))


def nondominated_sorting(
    problem: Problem, settings: NondominatedSorting, seed: int = 0, progress: Report | None = None
) -> Result:
    """Find the Pareto front of all designs that were evaluated, in order of the first objective, by NSGA-II.

    Parameters as in `genetic`.
    """
    return _restarts(problem, settings, seed, progress, settings.population)


def scale_of(values: Values, tolerance: float) -> tuple[Array, Array]:
    """Compute least value and range of each objective (no,), of the feasible designs or else of all with values."""
    feasible, known = values.feasible(tolerance), np.isfinite(values.objectives).all(axis=1)
    some = values.objectives[feasible if feasible.any() else known]
    some = some if len(some) else np.zeros((1, values.objectives.shape[1]))
    span = np.ptp(some, axis=0)
    return some.min(axis=0), np.where(span > 0.0, span, 1.0)


def fitness_of(values: Values, least: Array, span: Array, tolerance: float) -> Array:
    """Compute the fitness that pygad maximises, (m, no), or (m,) for one objective; see the head of the module."""
    violation = np.where(values.failed, 2.0 * GA_VIOLATION, np.minimum(values.violation, GA_VIOLATION))[:, None]
    scaled = np.minimum((values.objectives - least) / span, GA_WORST)
    scaled = np.where(values.feasible(tolerance)[:, None], scaled, GA_WORST * (1.0 + violation))
    return -(scaled[:, 0] if scaled.shape[1] == 1 else scaled)


def _restarts(problem: Problem, settings: _Generations, seed: int, progress: Report | None, elites: int) -> Result:
    archive = Archive(problem)
    runs: list[Result] = []
    seeds = np.random.SeedSequence(seed).generate_state(settings.restarts)
    for i, own in enumerate(seeds):
        runs.append(_Run(problem, settings, i, progress, elites, archive, int(own)).result())
        if runs[-1].status is Ending.INTERRUPTED:
            break
    status = Ending.INTERRUPTED if runs[-1].status is Ending.INTERRUPTED else Ending.BUDGET_USED
    rows = archive.front(settings.tolerance)  # for one objective the best design
    return archive.result(rows, status, sum(run.iterations for run in runs), settings.tolerance, runs)


class _Pygad(pygad.GA):
    """pygad with genes in [0, 1] and a vectorised sort, made once for each generation.

    The sort of version 3.9 makes generations of 100 designs take 19 times as long.
    """

    _sorted: tuple[bytes, list[Any]] = (b"", [])  # fitness that was sorted last, and the rows in order

    def sort_solutions_nsga2(self, fitness: Array, find_best_solution: bool = False) -> list[Any]:
        """Sort as pygad does, which asks for the order of each generation four times."""
        given = np.asarray(fitness).tobytes()
        if given != self._sorted[0]:
            self._sorted = given, super().sort_solutions_nsga2(fitness)
        return list(self._sorted[1])

    def sbx_crossover(self, parents: Array, offspring_size: tuple[int, int]) -> Array:
        """Cross parents with the same random numbers as pygad, which clips each gene by numpy three times."""
        genes, children = parents.tolist(), []
        for k in range(offspring_size[0]):
            chosen = self.numpy_random_generator.random(size=len(genes)) < self.crossover_probability
            mating = list(set(np.flatnonzero(chosen).tolist()))
            if not mating:
                children.append(genes[k % len(genes)])
                continue
            pair = self.python_random_generator.sample(mating, 2) if len(mating) > 1 else mating * 2
            children.append([self._crossed(a, b) for a, b in zip(*(genes[i] for i in pair), strict=True)])
        return np.array(children)

    def _crossed(self, a: float, b: float) -> float:
        """Return one of the two values of bounded simulated binary crossover."""
        low, high, power = min(a, b), max(a, b), self.sbx_crossover_eta + 1.0
        if high - low < GA_EQUAL:
            return a
        alpha = 2.0 - pow(1.0 + 2.0 * min(low, 1.0 - high) / (high - low), -power)
        part: float = self.numpy_random_generator.random()
        spread = pow(part * alpha if part <= 1.0 / alpha else 1.0 / (2.0 - part * alpha), 1.0 / power)
        side = -1.0 if self.numpy_random_generator.random() < 0.5 else 1.0
        return min(max(0.5 * ((low + high) + side * spread * (high - low)), 0.0), 1.0)

    def get_bounded_operator_gene_range(self, gene_index: int) -> tuple[float, float]:
        """Return the limits of a gene, which pygad asks for several times for each gene of a child."""
        return 0.0, 1.0

    def convert_bounded_operator_gene_value(self, gene_index: int, value: float) -> float:
        """Return the value of a gene within its limits, which pygad converts to their type and compares once more."""
        return value

    def non_dominated_sorting(self, fitness: Array) -> tuple[list[Any], Indices]:
        """Sort designs into fronts: for each the rows (index, fitness), and the number of the front of each design."""
        rank = ranks(-fitness)
        fronts = [np.flatnonzero(rank == level) for level in range(rank.max() + 1)]
        return [np.array([(i, fitness[i]) for i in front], dtype=object) for front in fronts], rank


@dataclass
class _Run:
    """One run of pygad; genes are the variables relative to their bounds, in [0, 1]."""

    problem: Problem
    settings: _Generations
    number: int
    progress: Report | None
    elites: int
    shared: Archive  # evaluates for all restarts
    seed: InitVar[int]

    def __post_init__(self, seed: int) -> None:
        problem, settings = self.problem, self.settings
        self.archive = Archive(replace(problem, evaluate=self.shared))  # designs of this run
        self.generation = 0
        first = latin_hypercube(settings.population + self.elites, problem.size, np.random.default_rng(seed))
        if problem.start is not None:
            width = np.where(problem.upper > problem.lower, problem.upper - problem.lower, 1.0)
            first[0] = np.clip((problem.start - problem.lower) / width, 0.0, 1.0)
        self.pygad = _Pygad(
            num_generations=settings.generations - 1,  # after the first one
            num_parents_mating=settings.population,
            fitness_func=self._fitness,
            fitness_batch_size=len(first),
            on_generation=lambda ga: self._report(ga, ga.population, ga.last_generation_fitness),
            initial_population=first,
            init_range_low=0.0,
            init_range_high=1.0,
            parent_selection_type="tournament",
            K_tournament=GA_TOURNAMENT,
            keep_elitism=self.elites,
            keep_parents=0,
            crossover_type="sbx",
            crossover_probability=settings.crossover,
            sbx_crossover_eta=settings.crossover_index,
            mutation_type="polynomial",
            mutation_probability=settings.mutation,
            polynomial_mutation_eta=settings.mutation_index,
            random_seed=seed,
            logger=_silent,
            suppress_warnings=True,
        )

    def result(self) -> Result:
        status = Ending.INTERRUPTED
        with self.archive.interruptible():
            self.pygad.run()
            status = Ending.BUDGET_USED
        rows = self.archive.front(self.settings.tolerance)
        return self.archive.result(rows, status, self.generation, self.settings.tolerance)

    def _fitness(self, ga: Any, genes: Array, indices: Any) -> list[Any]:
        """Evaluate new designs in one call; the first generation is reported here, the others by pygad's callback."""
        genes = np.asarray(genes, dtype=float)
        lower, upper = self.problem.lower, self.problem.upper
        values = self.archive(np.clip(lower + genes * (upper - lower), lower, upper))
        first, tolerance = self.generation == 0, self.settings.tolerance
        if first:
            self._scale = scale_of(values, tolerance)
        fitness = fitness_of(values, *self._scale, tolerance)
        if first:
            self._report(ga, genes, fitness)
        return fitness.tolist()

    def _report(self, ga: Any, genes: Array, fitness: Array) -> None:
        """Report a generation, with its best designs in order and the states of pygad's random generators."""
        self.generation += 1
        if self.progress is None:
            return
        rows, count = self.shared.front(self.settings.tolerance), self.settings.generations
        done, total = self.number * count + self.generation, self.settings.restarts * count
        kind, keys, *rest = ga.numpy_random_generator.get_state()
        version, words, gauss = ga.python_random_generator.getstate()
        best = ga.sort_solutions_nsga2(fitness=fitness, find_best_solution=True)[: self.settings.population]
        state = {
            "restart": self.number,
            "generation": self.generation,
            "pool": np.asarray(genes)[best].tolist(),
            "numpy": [kind, keys.tolist(), *rest],
            "python": [version, list(words), gauss],
        }
        self.progress(Progress(done, total, self.shared.designs[rows], self.shared.values.take(rows), state))
