"""Domination, Pareto fronts, hypervolume and knee."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from linkages import InputError
from optim.algorithms.archive import Archive, by_feasibility
from optim.algorithms.ga import fitness_of
from optim.algorithms.nlp import Problem, Values
from optim.algorithms.pareto import hypervolume, knee, pareto_front, ranks


def values(objectives, inequalities=None, failed=None):
    objectives = np.asarray(objectives, dtype=float)
    m = len(objectives)
    return Values(
        objectives,
        np.empty((m, 0)) if inequalities is None else np.asarray(inequalities, dtype=float).reshape(m, -1),
        np.empty((m, 0)),
        np.zeros(m, dtype=bool) if failed is None else np.asarray(failed),
    )


small = arrays(np.float64, st.tuples(st.integers(1, 12), st.integers(2, 3)), elements=st.integers(0, 4).map(float))


@given(small)
def test_ranks_by_definition(f):
    """Peel the fronts one by one, with plain loops."""
    left, expected, level = set(range(len(f))), np.empty(len(f), dtype=int), 0
    while left:
        best = {
            i for i in left
            if not any(np.all(f[j] <= f[i]) and np.any(f[j] < f[i]) for j in left)
        }  # fmt: skip
        expected[list(best)] = level
        left, level = left - best, level + 1
    assert np.array_equal(ranks(f), expected)
    rows = pareto_front(values(f))
    assert {tuple(row) for row in f[rows]} == {tuple(row) for row in f[expected == 0]}
    assert len({tuple(row) for row in f[rows]}) == len(rows)


@given(small, st.integers(1, 5), st.integers(0, 2**12 - 1))
def test_the_front_of_an_archive_grows_like_that_of_all_designs(f, size, feasible):
    """Designs come in parts, some of them infeasible; rows and their order are those of one comparison of all."""
    designs = np.arange(float(len(f)))[:, None]
    excess = np.array([[1.0 + k if not feasible >> k & 1 else 0.0] for k in range(len(f))])
    all_values = values(f, excess)
    names = tuple(map(str, range(f.shape[1])))
    problem = Problem(np.zeros(1), np.full(1, 12.0), lambda x: all_values.take(x[:, 0].astype(int)), names, ("limit",))
    archive = Archive(problem)
    for first in range(0, len(f), size):
        archive(designs[first : first + size])
        assert np.array_equal(archive.front(), pareto_front(archive.values))


def test_constrained_domination():
    """Feasible before less infeasible before more infeasible before failed, for any objectives."""
    v = values([[9, 9], [0, 0], [0, 0], [0, 0]], [[-1.0], [0.5], [2.0], [np.inf]], [False, False, False, True])
    assert np.array_equal(ranks(-fitness_of(v, np.zeros(2), np.ones(2), 1e-6)), [0, 1, 2, 3])
    assert np.array_equal(pareto_front(v), [0])
    assert np.array_equal(pareto_front(v.take([3, 2, 1])), [2])


def test_one_fitness_orders_by_the_rules_of_feasibility():
    v = values([[3], [1], [2], [np.inf], [0]], [[-1.0], [0.5], [0.0], [7.0], [np.inf]], [False] * 4 + [True])
    fitness = fitness_of(v, np.zeros(1), np.ones(1), 1e-6)
    assert np.array_equal(np.argsort(-fitness), by_feasibility(v, 1e-6))
    assert np.array_equal(by_feasibility(v, 1e-6), [2, 0, 1, 3, 4])


@given(small)
def test_hypervolume_by_counting_unit_cells(f):
    """Objectives are whole numbers: count the unit cells below the reference that something dominates."""
    cells = itertools.product(range(5), repeat=f.shape[1])
    counted = sum(any(np.all(point <= cell) for point in f) for cell in cells)
    assert hypervolume(f, np.full(f.shape[1], 5.0)) == pytest.approx(counted)


def test_hypervolume_of_numbers_that_are_none():
    """A design without a value dominates no volume, and the volume is no number: not 0."""
    for f, reference, problem in (
        ([[np.nan, 0.5]], np.ones(2), "objectives: have nan; give finite numbers"),
        ([[0.5, 0.5]], [1.0, np.nan], "reference: have nan; give finite numbers"),
        ([[0.5, 0.5]], np.ones(3), "reference: have 3 numbers for 2 objectives"),
        (np.ma.masked_greater([[0.5, 2.0]], 1.0), np.ones(2), "objectives: have masked entries"),
    ):
        with pytest.raises(InputError, match=problem):
            hypervolume(f, reference)
    assert hypervolume([[0, 0]], [2, 3]) == 6.0


def test_hypervolume_of_a_sphere():
    """The octant of the unit sphere around the reference: the dominated volume is an eighth of it."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi / 2, 60), np.linspace(0, np.pi / 2, 60))
    points = 1.0 - np.column_stack(
        [(np.sin(theta) * np.cos(phi)).ravel(), (np.sin(theta) * np.sin(phi)).ravel(), np.cos(theta).ravel()]
    )
    assert hypervolume(points, np.ones(3)) == pytest.approx(np.pi / 6.0, rel=0.03)


def test_knee_of_a_circle():
    """Nearest to the ideal point, whatever the units of the objectives."""
    angle = np.linspace(0.0, np.pi / 2.0, 91)
    f = np.column_stack([1.0 - np.cos(angle), 1.0 - np.sin(angle)])
    assert knee(f) == 45
    assert knee(f * [1e-6, 1e3] + [5.0, -7.0]) == 45


def test_knee_in_three_objectives():
    rng = np.random.default_rng(0)
    direction = np.vstack([np.eye(3), np.abs(rng.normal(size=(200, 3))), np.ones((1, 3))])
    f = 1.0 - direction / np.linalg.norm(direction, axis=1)[:, None]
    # the extremes of an octant: worst in two objectives, so the plane is x + y + z = 2
    assert knee(f) == len(f) - 1


@pytest.mark.parametrize(
    "f",
    [
        [[0, 1], [1, 0]],  # two designs only
        [[0, 1], [0.5, 0.5], [1, 0]],  # a straight line
        [[0, 1], [0.7, 0.7], [1, 0]],  # curved the other way
        [[1, 1], [1, 1], [1, 1]],  # a point
    ],
)
def test_no_knee(f):
    assert knee(np.array(f, dtype=float)) is None
