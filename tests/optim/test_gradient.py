"""The generalised reduced gradient method: published optima, another code, and failures."""

import dataclasses

import numpy as np
import pytest
from hock_schittkowski import EXAMPLES, NO_MULTIPLIERS, SEVERAL_OPTIMA
from scipy.optimize import linprog, minimize, nnls

from optim.algorithms.archive import Archive
from optim.algorithms.derivatives import jacobian
from optim.algorithms.gradient import ReducedGradient, bounded_minimum, damped_bfgs, reduced_gradient
from optim.algorithms.nlp import Ending, Problem, Values
from optim.algorithms.registry import minimise as solved_by

SETTINGS = ReducedGradient()
#: Tolerance of the objective, relative to max(1, |optimum|), and of constraints: the book's digits.
OPTIMUM, FEASIBILITY = 1e-6, 1e-6
BY_NUMBER = {example.number: example for example in (*EXAMPLES, *SEVERAL_OPTIMA)}


def error(result, example):
    return abs(result.values.objectives[0, 0] - example.optimum) / max(1.0, abs(example.optimum))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: f"hs{example.number}")
def test_hock_schittkowski(example):
    result = reduced_gradient(example.problem, SETTINGS)
    assert error(result, example) <= OPTIMUM
    assert result.values.feasible(FEASIBILITY)[0]
    assert result.status in (Ending.CONVERGED, Ending.NO_PROGRESS)
    problem, x = example.problem, result.x[0]
    assert np.all((problem.lower <= x) & (x <= problem.upper))
    slacks = np.concatenate([x - problem.lower, problem.upper - x, -result.values.inequalities[0]])
    active = np.sum(slacks <= 1e-6) + len(problem.equalities)
    assert (active >= problem.size) == ("v" in example.kind)


def test_the_examples_are_of_every_kind():
    assert len(EXAMPLES) >= 25
    for kind in "beivd":
        assert sum(kind in example.kind for example in EXAMPLES) >= 5


@pytest.mark.parametrize("number", [43, 65, 71, 79, 100])
def test_constraints_that_are_known_save_evaluations(number):
    """The way is the same; the returns to the constraints need no evaluation."""
    problem = BY_NUMBER[number].problem

    def constraints(x):
        values = problem.evaluate(x[None])
        return np.concatenate([values.inequalities[0], values.equalities[0]])

    result = reduced_gradient(problem, SETTINGS)
    known = reduced_gradient(dataclasses.replace(problem, constraints=constraints), SETTINGS)
    assert known.x.tobytes() == result.x.tobytes()
    assert known.iterations == result.iterations
    assert known.evaluations < result.evaluations


def test_an_optimum_without_multipliers():
    """The constraint ``(1 - x1)^3 >= x2``, held to a tolerance t, does not determine x1 within t^(1/3) of 1.

    On which side of it the search ends is left to rounding, which differs between processors.
    """
    result = reduced_gradient(NO_MULTIPLIERS.problem, SETTINGS)
    assert result.values.feasible(1e-8)[0]
    x1 = result.x[0, 0]
    assert abs(x1 - 1.0) <= 1e-8 ** (1.0 / 3.0)
    assert result.values.objectives[0, 0] == pytest.approx((x1 - 2.0) ** 2, abs=1e-9)


@pytest.mark.parametrize("number", [43, 65, 71, 79, 100, 104, 113])
def test_another_code_finds_the_same(number):
    """SciPy's sequential quadratic programming from the same start."""
    example = BY_NUMBER[number]
    constraints = [
        {"type": kind, "fun": lambda x, function=function: np.array(function(x))}
        for kind, function in (("ineq", example.g), ("eq", example.h))
        if function(np.array(example.start, dtype=float))
    ]
    problem = example.problem
    other = minimize(
        example.f, problem.start, method="SLSQP", constraints=constraints,
        bounds=list(zip(problem.lower, problem.upper, strict=True)), options={"ftol": 1e-12, "maxiter": 500},
    )  # fmt: skip
    ours = reduced_gradient(problem, SETTINGS)
    assert ours.values.objectives[0, 0] == pytest.approx(other.fun, rel=2e-6)
    assert ours.x[0] == pytest.approx(other.x, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize(("number", "start"), [(20, (0.4, 1.0)), (61, (0.0, -1.0, 1.0))])
def test_where_the_start_decides(number, start):
    example = BY_NUMBER[number]
    printed = reduced_gradient(example.problem, SETTINGS)
    assert printed.status is Ending.CONVERGED
    assert printed.values.feasible(FEASIBILITY)[0]
    assert error(printed, example) > OPTIMUM
    better = reduced_gradient(dataclasses.replace(example.problem, start=np.array(start)), SETTINGS)
    assert error(better, example) <= OPTIMUM


def quadratic(inequalities=None, equalities=None, lower=-2.0, upper=2.0, n=2, objective=None, failed=None):
    """Minimise ``|x - 1|^2`` from 0, with constraints as functions of the population."""

    def evaluate(designs):
        m = len(designs)
        none = np.empty((m, 0))
        return Values(
            (((designs - 1.0) ** 2).sum(axis=1) if objective is None else objective(designs))[:, None],
            none if inequalities is None else inequalities(designs),
            none if equalities is None else equalities(designs),
            np.zeros(m, dtype=bool) if failed is None else failed(designs),
        )

    one = np.zeros((1, n))
    return Problem(
        np.full(n, lower), np.full(n, upper), evaluate,
        inequalities=() if inequalities is None else tuple("abcdef"[: inequalities(one).shape[1]]),
        equalities=() if equalities is None else tuple("uvwxyz"[: equalities(one).shape[1]]),
        start=np.zeros(n),
    )  # fmt: skip


def test_dependent_equalities():
    """One equality three times, one of them nonlinear: the Jacobian has rank one everywhere on it."""

    def same(x):
        total = x.sum(axis=1) - 1.0
        return np.column_stack([total, 2.0 * total, total + total**3])

    result = reduced_gradient(quadratic(equalities=same), SETTINGS)
    assert result.x[0] == pytest.approx([0.5, 0.5], abs=1e-6)
    assert result.values.feasible(1e-8)[0]


def test_more_active_constraints_than_variables():
    def corner(x):
        a, b = x[:, 0], x[:, 1]
        return np.column_stack([a, b, a + b, a + 2.0 * b, 2.0 * a + b, a**2 + b])

    result = reduced_gradient(quadratic(corner), SETTINGS)
    assert result.status is Ending.CONVERGED
    assert result.x[0] == pytest.approx([0.0, 0.0], abs=1e-7)


def test_every_iterate_of_phase_two_is_feasible_and_better():
    example = BY_NUMBER[100]
    seen = []
    reduced_gradient(example.problem, SETTINGS, progress=seen.append)
    later = [step for step in seen if step.state["phase"] == 2]
    assert len(later) > 5
    assert all(step.values.feasible(FEASIBILITY)[0] for step in later)
    objectives = np.array([step.values.objectives[0, 0] for step in later])
    assert np.all(np.diff(objectives) <= 1e-9 * np.abs(objectives[1:]))


def test_infeasible():
    """The violation is least at the origin, and the constraint cannot hold anywhere."""
    result = reduced_gradient(quadratic(lambda x: (x**2).sum(axis=1)[:, None] + 1.0), SETTINGS)
    assert result.status is Ending.INFEASIBLE
    assert result.values.violation[0] == pytest.approx(1.0, abs=1e-4)
    assert result.status.remedy


@pytest.mark.parametrize("name", ["grg", "snopt"])
@pytest.mark.parametrize("kind", ["inequalities", "equalities"])
@pytest.mark.parametrize("size", [1.0, 1e-9])
def test_a_start_beyond_the_constraints_without_objectives_around_it(name, kind, size):
    """Least x^2 + y^2 with x y = 0.1: the start alone is evaluated beyond the constraint, as a study's nominal design.

    The objective is measured where it is known first: a small one ends no search early.
    """
    start = np.array([0.4, 0.14])

    def constraint(x):
        return np.array([0.1 - x[0] * x[1]])

    def evaluate(designs):
        g, none = np.array([constraint(x) for x in designs]), np.empty((len(designs), 0))
        excess = np.abs(g[:, 0]) if kind == "equalities" else g[:, 0]
        known = (excess <= 1e-4) | (designs == start).all(axis=1)  # with the designs of the differences
        f = np.where(known, size * (designs**2).sum(axis=1), np.inf)[:, None]
        return Values(f, *((g, none) if kind == "inequalities" else (none, g)), np.zeros(len(designs), dtype=bool))

    names = {kind: ("product",)}
    problem = Problem(np.full(2, 0.1), np.full(2, 0.9), evaluate, ("f",), **names, start=start, constraints=constraint)
    result = solved_by(name, problem)
    assert result.status is Ending.CONVERGED
    assert result.x[0] == pytest.approx(np.sqrt([0.1, 0.1]), rel=1e-4)
    assert result.values.feasible(1e-6)[0]


def test_a_violation_that_the_problem_counts_is_not_feasible():
    """The scale of this constraint is 1e8: within the method's tolerance of it there is no objective."""

    def evaluate(designs):
        g, none = 1e8 * (designs.prod(axis=1) - 0.1)[:, None], np.empty((len(designs), 0))
        f = np.where(np.abs(g) <= 1e-3, (designs**2).sum(axis=1)[:, None], np.inf)
        return Values(f, none, g, np.zeros(len(designs), dtype=bool))

    def derivatives(x):
        return np.array([2.0 * x, 1e8 * x[::-1]])

    problem = Problem(
        np.full(2, 0.1), np.full(2, 0.9), evaluate, ("f",), equalities=("product",), start=np.array([0.4, 0.14]),
        jacobian=derivatives, constraints=lambda x: np.array([1e8 * (x.prod() - 0.1)]),
    )  # fmt: skip
    result = reduced_gradient(problem, SETTINGS)
    assert result.values.objectives[0, 0] == pytest.approx(0.2, rel=1e-5)


def test_failed_evaluations_are_kept_away_from():
    """Nothing can be evaluated beyond a circle that holds the unconstrained optimum out."""
    problem = quadratic(failed=lambda x: (x**2).sum(axis=1) > 1.0)
    result = reduced_gradient(problem, SETTINGS)
    assert not result.values.failed[0]
    assert result.values.objectives[0, 0] < 0.4  # sqrt(2) - 1 squared is 0.17


def test_values_that_are_no_numbers_count_as_failed():
    problem = quadratic(objective=lambda x: np.where(x[:, 0] > 0.5, np.nan, ((x - 1.0) ** 2).sum(axis=1)))
    result = reduced_gradient(problem, SETTINGS)
    assert np.isfinite(result.values.objectives[0, 0])
    assert result.x[0, 0] <= 0.5


def polynomial(f, start, equality=None, inequality=None):
    """Minimise a function of one design within [-2, 2] from a start."""
    columns = [np.empty if one is None else one for one in (inequality, equality)]

    def evaluate(designs):
        lines = [[[one(x)] if one is not np.empty else [] for x in designs] for one in columns]
        sides = [np.array(line, dtype=float).reshape(len(designs), -1) for line in lines]
        return Values(np.array([[f(x)] for x in designs]), *sides, np.zeros(len(designs), dtype=bool))

    names = [() if one is None else ("c",) for one in (inequality, equality)]
    box = np.full(len(start), 2.0)
    return Problem(-box, box, evaluate, ("f",), *names, np.array(start, dtype=float))


#: Problems whose start is stationary, or leads to a stationary point, that is no minimum; and their minima.
STATIONARY = {
    "maximum": (polynomial(lambda x: np.cos(x[0]), [0.0]), np.cos(2.0)),
    "saddle": (polynomial(lambda x: x[0] * x[1], [0.0, 0.0]), -4.0),
    "two saddles": (polynomial(lambda x: x[0] * x[1] + x[2] * x[3], [0.0] * 4), -8.0),
    "line of symmetry": (polynomial(lambda x: x[0] ** 2 + (x[1] ** 2 - 1.0) ** 2, [1.0, 0.0]), 0.0),
    "maximum on a circle": (polynomial(lambda x: -x[1], [0.0, -1.0], lambda x: x @ x - 1.0), -1.0),
    "saddle on a sphere": (polynomial(lambda x: x**2 @ [1, 2, 3], [0.0, 1.0, 0.0], lambda x: x @ x - 1.0), 1.0),
    "maximum in a disc": (polynomial(lambda x: -(x @ x), [0.0, 0.0], None, lambda x: x @ x - 1.0), -1.0),
}


@pytest.mark.parametrize("name", ["grg", "snopt"])
@pytest.mark.parametrize("case", STATIONARY)
def test_a_stationary_point_that_is_no_minimum_is_left(name, case):
    problem, minimum = STATIONARY[case]
    result = solved_by(name, problem)
    assert result.status is Ending.CONVERGED
    assert result.values.objectives[0, 0] == pytest.approx(minimum, abs=1e-6)
    assert result.values.feasible(FEASIBILITY)[0]


@pytest.mark.parametrize("name", ["grg", "snopt"])
def test_a_start_at_the_minimum_stays_there(name):
    """Ten designs for two gradients and the curvature; a flat objective has no direction either."""
    for objective in (lambda x: x @ x, lambda x: 0.0 * x[0]):
        result = solved_by(name, polynomial(objective, [0.0, 0.0]))
        assert (result.status, result.x[0].tolist()) == (Ending.CONVERGED, [0.0, 0.0])
        assert result.evaluations <= 10


def test_differences_are_one_population():
    """One call for the start, then 2 n designs for each gradient, in addition to one or two of the line search.

    The bowl's minimum is found in one step: for the curvature in the four other directions 4 x 2 + 6 designs follow.
    """
    sizes = []
    base = quadratic(n=5)

    def evaluate(designs):
        sizes.append(len(designs))
        return base.evaluate(designs)

    reduced_gradient(dataclasses.replace(base, evaluate=evaluate), SETTINGS)
    assert set(sizes) <= {1, 2, 10, 14}
    assert sizes.count(14) == 1


def test_no_design_is_evaluated_twice_or_outside_the_bounds():
    seen = []
    base = BY_NUMBER[83].problem

    def evaluate(designs):
        seen.extend(map(bytes, designs))
        assert np.all((base.lower <= designs) & (designs <= base.upper))
        return base.evaluate(designs)

    result = reduced_gradient(dataclasses.replace(base, evaluate=evaluate), SETTINGS)
    assert len(seen) == len(set(seen)) == result.evaluations


def test_a_step_and_its_double_are_evaluated_together():
    """The first step is short of the optimum, and the search goes on to its double; gradients take four designs."""
    sizes = []

    def evaluate(designs):
        sizes.append(len(designs))
        f = ((designs - 1.0) ** 2).sum(axis=1)[:, None]
        return Values(f, np.empty((len(f), 0)), np.empty((len(f), 0)), np.zeros(len(f), dtype=bool))

    problem = Problem(np.full(2, -20.0), np.full(2, 20.0), evaluate, start=np.array([-15.0, 10.0]))
    result = reduced_gradient(problem, SETTINGS)
    assert result.x[0] == pytest.approx([1.0, 1.0], abs=1e-5)
    assert sizes[:4] == [1, 4, 2, 4]


def test_a_given_jacobian_replaces_the_differences():
    example = BY_NUMBER[65]

    def derivatives(x):
        sum_, slope = x[0] + x[1] - 10.0, 2.0 * (x[0] - x[1])
        objective = [slope + 2.0 * sum_ / 9.0, -slope + 2.0 * sum_ / 9.0, 2.0 * (x[2] - 5.0)]
        return np.array([objective, 2.0 * x])

    problem = dataclasses.replace(example.problem, jacobian=derivatives)
    x = np.array([1.0, 2.0, 5.0])  # x3 on its bound
    by_differences = jacobian(example.problem, Archive(example.problem), x, np.full(3, 10.0), 1e-6)
    assert by_differences == pytest.approx(derivatives(x), abs=1e-7)
    result = reduced_gradient(problem, SETTINGS)
    assert error(result, example) <= OPTIMUM
    assert result.evaluations < reduced_gradient(example.problem, SETTINGS).evaluations / 2


@pytest.mark.parametrize("number", [83, 71])
@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_it_does_not_depend_on_units(number, factor):
    """Variables, their bounds, the objective and the constraints in other units: the same designs."""
    base = BY_NUMBER[number].problem
    unit = np.geomspace(1e-6, 1e3, base.size)

    def evaluate(designs):
        values = base.evaluate(designs / unit)
        return Values(values.objectives * factor, values.inequalities * 10.0, values.equalities / factor, values.failed)

    scaled = dataclasses.replace(
        base, lower=base.lower * unit, upper=base.upper * unit, evaluate=evaluate, start=base.start * unit
    )
    one, other = reduced_gradient(base, SETTINGS), reduced_gradient(scaled, SETTINGS)
    assert other.x[0] / unit == pytest.approx(one.x[0], rel=1e-5)


@pytest.mark.parametrize("name", ["grg", "snopt"])
@pytest.mark.parametrize("factor", [1e-7, 2e7])
def test_a_constraint_that_does_not_change_at_the_start_has_a_measure(name, factor):
    """Problem 12: at the start (0, 0) its constraint 25 - 4 x^2 - y^2 is stationary."""
    example = BY_NUMBER[12]

    def evaluate(designs):
        values = example.problem.evaluate(designs)
        return dataclasses.replace(values, inequalities=values.inequalities * factor)

    result = solved_by(name, dataclasses.replace(example.problem, evaluate=evaluate))
    assert result.status is Ending.CONVERGED
    assert error(result, example) <= OPTIMUM
    assert result.values.inequalities.max() <= FEASIBILITY * factor


def test_a_basis_that_becomes_singular():
    """The equality's derivative with respect to its only basic variable vanishes where the search arrives."""
    problem = quadratic(
        equalities=lambda x: (x[:, 0] ** 2 - x[:, 1])[:, None], objective=lambda x: (x[:, 0] - 1.0) ** 2 + x[:, 1] ** 2
    )
    for start in ([-1.0, 1.0], [0.0, 0.0], [0.0, 1.0]):
        result = reduced_gradient(dataclasses.replace(problem, start=np.array(start)), SETTINGS)
        # stationary where 2 (x - 1) + 4 x^3 = 0
        assert result.x[0, 0] == pytest.approx(0.5897545, abs=1e-6)
        assert result.values.feasible(1e-8)[0]


@pytest.mark.parametrize("seed", range(4))
def test_random_quadratic_programmes_satisfy_the_conditions_of_optimality(seed):
    """Convex problems of several sizes: the result is compared by what defines it, not by another code."""
    random = np.random.default_rng(seed)
    n, m = 6, 4
    root, G, b = random.normal(size=(n, n)), random.normal(size=(m, n)), random.uniform(0.1, 0.5, m)
    target = random.normal(size=n)
    problem = quadratic(
        lambda x: x @ G.T - b, objective=lambda x: (((x - target) @ root) ** 2).sum(axis=1), n=n, lower=-1, upper=1
    )
    x = reduced_gradient(problem, SETTINGS).x[0]
    gradient = 2.0 * root @ root.T @ (x - target)
    rows = [row for row, slack in zip(G, b - G @ x, strict=True) if slack < 1e-6]
    rows += [np.eye(n)[i] * np.sign(x[i]) for i in range(n) if abs(x[i]) > 1.0 - 1e-6]
    _, rest = nnls(np.array(rows).T, -gradient) if rows else (None, np.linalg.norm(gradient))
    assert rest < 1e-4 * (1.0 + np.linalg.norm(gradient))


def test_a_rough_constraint_needs_a_loose_tolerance():
    def rough(x):
        return (x.sum(axis=1) - 1.0 + 1e-6 * np.sin(1e6 * x).sum(axis=1))[:, None]

    result = reduced_gradient(quadratic(rough), ReducedGradient(step=1e-2, feasibility=1e-4))
    assert result.x[0] == pytest.approx([0.5, 0.5], abs=1e-2)
    assert result.values.feasible(1e-3)[0]


def test_a_rough_objective_needs_a_long_step():
    """Ripples of 1e-4: differences over 1e-6 of the bounds see nothing else, over 2e-2 the bowl beneath."""

    def rough(x):
        return ((x - 1.0) ** 2).sum(axis=1) + 1e-4 * np.sin(1e5 * x).sum(axis=1)

    problem = quadratic(objective=rough)
    smooth = reduced_gradient(problem, ReducedGradient(step=2e-2))
    noise = reduced_gradient(problem, SETTINGS)
    assert smooth.values.objectives[0, 0] < 5e-3
    assert noise.values.objectives[0, 0] > 0.1
    assert noise.status is Ending.NO_PROGRESS
    assert "longer difference step" in noise.status.remedy


def test_interrupted_after_three_iterations():
    def stop(step):
        if step.iteration == 3:
            raise KeyboardInterrupt

    example = BY_NUMBER[100]
    result = reduced_gradient(example.problem, SETTINGS, progress=stop)
    assert (result.status, result.iterations) == (Ending.INTERRUPTED, 3)
    again = reduced_gradient(example.problem, SETTINGS.model_copy(update={"iterations": 3}))
    assert np.array_equal(again.x, result.x)


def test_model_minimum_against_conditions_of_optimality():
    random = np.random.default_rng(1)
    for _ in range(50):
        n, rows = 5, 9
        root = random.normal(size=(n, n))
        H, r, Z = root @ root.T + 0.1 * np.eye(n), random.normal(size=n), random.normal(size=(rows, n))
        low, high = -random.uniform(0.0, 0.3, rows), random.uniform(0.0, 0.3, rows)
        low[0], high[1] = -np.inf, np.inf
        v, multipliers = bounded_minimum(H, r, Z, low, high)
        moved = Z @ v
        assert np.all(moved >= low - 1e-9)
        assert np.all(moved <= high + 1e-9)
        assert H @ v + r == pytest.approx(Z.T @ multipliers, abs=1e-9)
        held = np.where(multipliers > 0.0, moved - low, high - moved)[multipliers != 0.0]
        assert held == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("size", [1.0, 1e-6, 1e-10, 1e-13])
def test_the_model_minimum_lies_on_its_bounds_however_small_the_curvature(size):
    """The curvature of a linear objective is rounding alone: the minimum is the vertex to rounding."""
    H = size * np.array([[1.1, -0.2], [-0.2, 2.0]])
    high = np.array([0.08445825, 0.2])
    v, multipliers = bounded_minimum(H, np.array([-0.5, -1.0]), np.eye(2), np.full(2, -1.0), high)
    np.testing.assert_allclose(v, high, rtol=1e-12)
    np.testing.assert_allclose(multipliers, H @ v - [0.5, 1.0], rtol=1e-12)


def test_linear_objectives_end_in_their_vertex():
    """Random linear programmes, against SciPy's simplex method."""
    random = np.random.default_rng(0)
    for _ in range(40):
        n, m = random.integers(2, 7), random.integers(0, 4)
        cost, A, start = random.normal(size=n), random.normal(size=(m, n)), random.uniform(0.2, 0.8, n)
        limit = A @ start + random.uniform(0.05, 0.3, m)
        problem = quadratic(lambda x, A=A, b=limit: x @ A.T - b, None, 0.0, 1.0, n, lambda x, cost=cost: x @ cost)
        result = reduced_gradient(dataclasses.replace(problem, start=start), SETTINGS)
        vertex = linprog(cost, A, limit, bounds=(0.0, 1.0))
        assert result.status is Ending.CONVERGED
        assert result.values.objectives[0, 0] == pytest.approx(vertex.fun, abs=1e-9)


def test_the_update_satisfies_the_secant_condition_and_stays_positive_definite():
    random = np.random.default_rng(2)
    H = np.eye(4)
    for _ in range(20):
        s, y = random.normal(size=4), random.normal(size=4)
        damped = s @ y < 0.2 * s @ H @ s
        H = damped_bfgs(H, s, y)
        assert np.linalg.eigvalsh(H).min() > 0.0
        if not damped:
            assert H @ s == pytest.approx(y)
