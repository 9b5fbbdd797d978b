"""Differential evolution, SciPy's, to compare the other algorithms with.

R. Storn, K. Price, Differential evolution, Journal of Global Optimization 11 (1997) 341-359; constraints by the
rules of J. Lampinen, A constraint handling approach for the differential evolution algorithm, Proc. CEC 2002.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field
from scipy.optimize import Bounds, NonlinearConstraint, differential_evolution

from linkages.input.files.toml import NonNegative, Table
from optim.algorithms.archive import Archive, latin_hypercube
from optim.algorithms.nlp import Array, Ending, Problem, Progress, Report, Result


class DifferentialEvolution(Table):
    """Settings of differential evolution."""

    population: int = Field(30, ge=5, description="designs of a generation")
    generations: int = Field(50, ge=2, description="generations at most, the first one among them")
    strategy: Literal["best1bin", "rand1bin", "currenttobest1bin", "rand2bin", "best2bin"] = Field(
        "best1bin", description="how a trial design is made"
    )
    mutation: Annotated[float, Field(gt=0.0, le=2.0)] = Field(0.7, description="weight of a difference")
    recombination: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        0.9, description="probability of each variable to come from the trial"
    )
    convergence: NonNegative = Field(0.0, description="stop when the population's objectives spread less, relatively")
    tolerance: NonNegative = Field(1e-6, description="violation up to which a constraint counts as satisfied")


def evolve(problem: Problem, settings: DifferentialEvolution, seed: int = 0, progress: Report | None = None) -> Result:
    """Minimise one objective; whole generations are evaluated in one call.

    Parameters as in `optim.minimise`. The first generation is a Latin hypercube, with the problem's start among
    it; `progress` is called after each generation from the second on, with the state of the random generator.
    """
    archive = Archive(problem)
    random = np.random.default_rng(seed)
    lower, upper, n = problem.lower, problem.upper, problem.size
    generations = 1

    def constraints(designs: Array) -> Array:
        values = archive(np.atleast_2d(designs.T))
        residuals = np.hstack([values.inequalities, np.abs(values.equalities)]).T - settings.tolerance
        return residuals if designs.ndim == 2 else residuals[:, 0]

    def objective(designs: Array) -> Array:
        return archive(np.atleast_2d(designs.T)).objectives[:, 0]

    def after(intermediate_result: Any) -> None:
        nonlocal generations
        generations += 1
        if progress is not None:
            row = [archive.best(settings.tolerance)]
            population = intermediate_result.population.tolist()
            state = {"random": random.bit_generator.state, "population": population}
            best, values = archive.designs[row], archive.values.take(row)
            progress(Progress(generations, settings.generations, best, values, state))

    first = lower + latin_hypercube(settings.population, n, random) * (upper - lower)
    if problem.start is not None:
        first[0] = problem.start
    constrained = bool(problem.inequalities or problem.equalities)
    status = Ending.INTERRUPTED
    with archive.interruptible():
        result = differential_evolution(
            objective,
            Bounds(lower, upper),
            strategy=settings.strategy,
            maxiter=settings.generations - 1,
            tol=settings.convergence,
            mutation=settings.mutation,
            recombination=settings.recombination,
            rng=random,
            callback=after,
            polish=False,
            init=np.clip(first, lower, upper),
            updating="deferred",
            constraints=NonlinearConstraint(constraints, -np.inf, 0.0) if constrained else (),
            vectorized=True,
        )
        status = Ending.CONVERGED if result.success else Ending.BUDGET_USED
    return archive.result([archive.best(settings.tolerance)], status, generations, settings.tolerance)
