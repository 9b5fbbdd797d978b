"""Genetic algorithms: known fronts and optima, constraints, failures, repeatability, what pygad does."""

import dataclasses
import json
import random

import numpy as np
import pygad
import pytest
from hock_schittkowski import EXAMPLES
from multiobjective import bnh, bnh_front, constr_ex, constr_ex_front, problem, zdt

from optim.algorithms import ga
from optim.algorithms.ga import Genetic, NondominatedSorting, genetic, nondominated_sorting
from optim.algorithms.nlp import Ending, Values
from optim.algorithms.pareto import hypervolume

SEVERAL = NondominatedSorting(population=60, generations=100)
SMALL = Genetic(population=10, generations=8)


def sphere(n=4):
    return problem(np.full(n, -1.0), np.full(n, 3.0), lambda x: ((x - 1.0) ** 2).sum(axis=1)[:, None])


def recorded(base):
    """A problem that records the requested populations."""
    asked = []

    def evaluate(designs):
        asked.append(designs.copy())
        return base.evaluate(designs)

    return dataclasses.replace(base, evaluate=evaluate), asked


@pytest.mark.parametrize(
    ("power", "volume"),
    [
        pytest.param(0.5, 0.1 + 2.0 / 3.0 + 0.11, id="zdt1"),
        pytest.param(2.0, 0.1 + 1.0 / 3.0 + 0.11, id="zdt2", marks=pytest.mark.slow),
    ],
)
def test_zdt(power, volume):
    """The hypervolume up to (1.1, 1.1) is an integral of the front's closed form."""
    result = nondominated_sorting(zdt(power), SEVERAL, seed=1)
    f = result.values.objectives
    assert np.all(np.diff(f[:, 0]) > 0.0)
    assert np.all(np.diff(f[:, 1]) < 0.0)
    assert np.all(f[:, 1] >= 1.0 - f[:, 0] ** power - 1e-12)  # nothing is better than the front
    assert hypervolume(f, np.array([1.1, 1.1])) == pytest.approx(volume, rel=0.01)
    assert hypervolume(f, np.array([1.1, 1.1])) < volume


@pytest.mark.parametrize(
    ("case", "closed_form", "near", "span"),
    [(constr_ex, constr_ex_front, 0.02, (7.0 / 18.0, 1.0)), (bnh, bnh_front, 0.01, (0.0, 136.0))],
)
def test_constrained_fronts(case, closed_form, near, span):
    result = nondominated_sorting(case(), SEVERAL, seed=2)
    f1, f2 = result.values.objectives.T
    expected = closed_form(f1)
    assert np.all(result.values.feasible(SEVERAL.tolerance))
    assert np.all(f2 >= expected - 1e-4)
    assert np.median((f2 - expected) / expected) < near
    assert f1.min() == pytest.approx(span[0], abs=0.02 * span[1])
    assert f1.max() == pytest.approx(span[1], rel=0.02)


def test_one_objective():
    result = genetic(sphere(), Genetic(generations=80), seed=1)
    assert result.status is Ending.BUDGET_USED
    assert result.values.objectives[0, 0] < 1e-2
    assert result.iterations == 80
    assert result.evaluations <= 81 * 30  # the elites of the first generation in addition


def test_constraints_by_feasibility_rules():
    """Problem 65: from a population almost without feasible designs to near the optimum."""
    example = next(example for example in EXAMPLES if example.number == 65)
    result = genetic(example.problem, Genetic(generations=80), seed=3)
    assert result.values.feasible(1e-6)[0]
    assert example.optimum <= result.values.objectives[0, 0] < example.optimum * 1.1


def test_the_best_never_gets_worse():
    seen = []
    genetic(sphere(), SMALL, seed=5, progress=seen.append)
    objectives = [step.values.objectives[0, 0] for step in seen]
    assert [step.iteration for step in seen] == list(range(1, 9))
    assert np.all(np.diff(objectives) <= 0.0)
    pools = [step.state["pool"] for step in seen]
    # relative to the bounds, the best of a pool is the best of all
    assert -1.0 + 4.0 * np.array(pools[-1][0]) == pytest.approx(seen[-1].best[0])


def test_whole_generations_and_no_design_twice():
    base, asked = recorded(sphere())
    result = genetic(base, SMALL, seed=1)
    assert len(asked) <= SMALL.generations
    assert len(asked[0]) == 2 * SMALL.population  # children and elites
    assert all(len(population) <= SMALL.population for population in asked[1:])
    everything = np.vstack(asked)
    assert len(np.unique(everything, axis=0)) == len(everything) == result.evaluations
    assert np.all((base.lower <= everything) & (everything <= base.upper))


def test_without_crossover_and_mutation_there_is_nothing_new():
    base, asked = recorded(sphere())
    genetic(base, SMALL.model_copy(update={"crossover": 0.0, "mutation": 0.0}), seed=1)
    assert len(asked) == 1


def test_the_start_is_in_the_first_generation():
    base, asked = recorded(dataclasses.replace(sphere(), start=np.array([0.1, 0.2, 0.3, 0.4])))
    genetic(base, SMALL, seed=1)
    assert asked[0][0] == pytest.approx([0.1, 0.2, 0.3, 0.4], abs=1e-15)


@pytest.mark.parametrize(
    ("solver", "base", "table"), [(genetic, sphere(), Genetic), (nondominated_sorting, zdt(0.5), NondominatedSorting)]
)
def test_the_same_seed_gives_the_same_designs(solver, base, table):
    settings = table(population=10, generations=5, restarts=2)
    runs = []
    for seed in (4, 4, 5):
        again, asked = recorded(base)
        result = solver(again, settings, seed)
        runs.append((np.vstack(asked), result))
    assert np.array_equal(runs[0][0], runs[1][0])
    assert np.array_equal(runs[0][1].x, runs[1][1].x)
    assert not np.array_equal(runs[0][0][:20], runs[2][0][:20])


def test_no_random_generator_of_others_is_touched():
    before = (np.random.get_state()[1].copy(), random.getstate())  # noqa: NPY002
    genetic(sphere(), SMALL, seed=1)
    assert np.array_equal(before[0], np.random.get_state()[1])  # noqa: NPY002
    assert before[1] == random.getstate()


def test_the_state_is_json_and_tells_how_it_goes_on():
    states = []
    genetic(sphere(), SMALL, seed=1, progress=lambda step: states.append(json.dumps(step.state)))
    assert len(set(states)) == len(states)
    state = json.loads(states[0])
    generator = np.random.RandomState()
    generator.set_state((state["numpy"][0], np.array(state["numpy"][1], dtype=np.uint32), *state["numpy"][2:]))
    other = random.Random()
    other.setstate((state["python"][0], tuple(state["python"][1]), state["python"][2]))
    assert len(state["pool"]) == SMALL.population


def test_interrupted_runs_are_prefixes():
    def stop(step):
        if step.iteration == 3:
            raise KeyboardInterrupt

    whole, asked = recorded(sphere())
    genetic(whole, SMALL, seed=1)
    part, asked_part = recorded(sphere())
    result = genetic(part, SMALL, seed=1, progress=stop)
    assert (result.status, result.iterations) == (Ending.INTERRUPTED, 3)
    assert len(asked_part) == 3
    assert all(np.array_equal(a, b) for a, b in zip(asked, asked_part, strict=False))
    assert result.evaluations == len(np.vstack(asked_part))


def test_interrupted_before_the_first_value():
    def stop(designs):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        genetic(dataclasses.replace(sphere(), evaluate=stop), SMALL)


def test_failed_evaluations():
    """Half of the box has no values, some not-a-number among them."""

    def some(designs):
        values = sphere().evaluate(designs)
        failed = designs[:, 0] > 0.5
        objectives = np.where(designs[:, 1:2] > 2.0, np.nan, values.objectives)
        return Values(objectives, values.inequalities, values.equalities, failed)

    result = genetic(dataclasses.replace(sphere(), evaluate=some), Genetic(generations=60), seed=2)
    assert result.x[0, 0] <= 0.5
    assert result.values.objectives[0, 0] == pytest.approx(0.25, abs=0.05)


@pytest.mark.parametrize("elites", [1, 30])
def test_elites_live_on(elites):
    """With one elite the rest of a pool are children; with as many as designs, parents stay until bettered."""
    seen = []
    settings = Genetic(generations=2, mutation=1.0, crossover=1.0, elites=elites)
    genetic(sphere(), settings, seed=1, progress=seen.append)
    first, second = ({tuple(genes) for genes in step.state["pool"]} for step in seen)
    assert len(first & second) == 1 if elites == 1 else len(first & second) > 1


def test_the_best_restart_is_the_result():
    result = genetic(sphere(), SMALL.model_copy(update={"restarts": 4}), seed=1)
    found = [run.values.objectives[0, 0] for run in result.runs]
    assert len(set(found)) == 4
    assert min(found) == result.values.objectives[0, 0]
    assert result.iterations == 32


def test_units_do_not_matter():
    """Bounds of 1e-9 and 1e9: the same genes, so the same objectives."""
    unit = np.array([1e-9, 1e9, 1.0, 1e-3])
    base = sphere()
    scaled = dataclasses.replace(
        base, lower=base.lower * unit, upper=base.upper * unit, evaluate=lambda x: base.evaluate(x / unit)
    )
    one, other = genetic(base, SMALL, seed=1), genetic(scaled, SMALL, seed=1)
    assert other.x / unit == pytest.approx(one.x, rel=1e-9)


@pytest.mark.parametrize("crossover", [0.02, 0.1, 0.9])
def test_parents_are_crossed_as_by_pygad_with_the_same_random_numbers(crossover):
    parents = np.random.default_rng(1).uniform(size=(20, 5))
    parents[3:6], parents[7, 2:] = parents[2], [0.0, 1.0, 0.5]  # equal parents, limits
    found = []
    for cross in (pygad.GA.sbx_crossover, ga._Pygad.sbx_crossover):
        run = ga._Pygad(
            num_generations=1, num_parents_mating=20, fitness_func=lambda ga, genes, index: 0.0, sbx_crossover_eta=15.0,
            initial_population=parents, parent_selection_type="tournament", crossover_type="sbx", random_seed=2,
            crossover_probability=crossover, init_range_low=0.0, init_range_high=1.0, suppress_warnings=True,
        )  # fmt: skip
        found += [[cross(run, parents, (50, 5)) for _ in range(2)]]
    np.testing.assert_array_equal(*found)
