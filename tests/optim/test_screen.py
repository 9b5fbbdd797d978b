"""Designs that formulas exclude are not run, and algorithms get along without their objectives."""

import json
from dataclasses import replace

import numpy as np
import pytest

from linkages.cli.main import main
from optim.algorithms.archive import Archive
from optim.algorithms.derivatives import jacobian
from optim.algorithms.nlp import Ending, Problem, Values
from optim.algorithms.registry import minimise, read_settings
from optim.cli import optimise as command
from optim.evaluate.evaluator import Evaluator, Screened
from optim.evaluate.limits import problem_of, values_of
from optim.problem.load import load_study

STUDY = """
experiment = "seven_bar.toml"
set.duration = 0.1
[variables.mass]
path = "sdf.links.link2.mass"
lower = 0.1
upper = 0.5
[variables.slider]
path = "sdf.links.slider7.mass"
lower = 0.05
upper = 0.3
[objectives.force]
terms = [{ functional = "peak", output = "A.force" }]
[constraints.speed]
at_most = 100.0
terms = [{ functional = "peak", output = "slider7.vx" }]
[constraints.light]
formula = "mass + slider"
at_most = 0.5
[constraints.share]
formula = "sqrt(mass - slider)"
at_least = 0.2
[algorithm]
name = "ga"
population = 8
generations = 4
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(STUDY)
    return path


@pytest.fixture
def study(file):
    return load_study(file)


@pytest.fixture
def asked(study, invented_engine, monkeypatch):
    """Designs that were run."""
    designs = []

    def keep(request):
        designs.extend(request.values[:, :2].tolist())
        return invented_engine(request)

    monkeypatch.setattr("optim.evaluate.evaluator.run_compiled", keep)
    return designs


GOOD, HEAVY, NO_ROOT = [0.3, 0.1], [0.45, 0.2], [0.1, 0.3]


def test_no_run_is_made(study, asked):
    designs = np.array([GOOD, HEAVY, NO_ROOT])
    found = Screened(study, Evaluator(study))(designs)
    assert asked == [GOOD]
    assert found.status == ("ok", "infeasible", "no-value")
    assert found.reason == ("", "violates light.at_most", "share has no finite value")
    assert found.failed.tolist() == [False, False, True]
    assert found.constraints[1, 1:] == pytest.approx([0.65, 0.5])
    assert np.isnan(found.objectives[1:]).all()
    assert np.isnan(found.constraints[1, 0])
    whole = Evaluator(study)(designs[:1])
    assert found.objectives[0] == whole.objectives[0]
    assert found.constraints[0].tobytes() == whole.constraints[0].tobytes()


def test_a_violation_that_counts_as_none_is_run(study, asked):
    Screened(study, Evaluator(study))(np.array([[0.4, 0.1 + 4e-7], [0.4, 0.1 + 6e-7]]))
    assert asked == [[0.4, 0.1 + 4e-7]]


def test_designs_that_differences_ask_for_are_run(study, asked):
    """A tenth of the bounds: 0.04 and 0.025; up to twice that along one variable from 0.5 in sum."""
    study = replace(study, nominal=np.array(GOOD))
    screened = Screened(study, Evaluator(study), 0.1)
    near, far = [[0.4, 0.12], [0.47, 0.1], [0.42, 0.14]], [[0.49, 0.1], [0.45, 0.15]]
    assert screened(np.array(near + far)).status == ("ok",) * 3 + ("infeasible",) * 2
    assert asked == near


def test_beyond_a_hard_constraint_nothing_is_run(file, asked):
    file.write_text(STUDY.replace("at_most = 0.5\n", "at_most = 0.5\nhard = true\n"))
    study = replace(load_study(file), nominal=np.array(GOOD))
    found = Screened(study, Evaluator(study), 0.1)(np.array([[0.4, 0.12], [0.4, 0.1]]))
    assert found.status == ("infeasible", "ok")
    assert asked == [[0.4, 0.1]]


def test_the_nominal_design_is_run_in_any_case(study, asked):
    study = replace(study, nominal=np.array(HEAVY))
    assert Screened(study, Evaluator(study))(study.nominal[None]).status == ("ok",)
    assert asked == [HEAVY]


def test_limits_of_relative_formulas(file, asked):
    """1.2 times the nominal design's 0.219 + 0.139 is 0.43."""
    file.write_text(STUDY.replace('"mass + slider"\nat_most = 0.5', '"mass + slider"\nrelative = true\nequals = 1.2'))
    study = load_study(file)
    m = 1.2 * study.nominal.sum() - 0.1
    Screened(study, Evaluator(study))(np.array([[m, 0.1], [m + 0.01, 0.1], [m - 0.01, 0.1]]))
    assert asked == [[m, 0.1]]


def test_what_algorithms_see(study, asked):
    screened = Screened(study, Evaluator(study))
    nominal = screened(study.nominal[None])
    values = values_of(study, screened(np.array([GOOD, HEAVY, NO_ROOT])), nominal)
    assert values.failed.tolist() == [False, False, True]
    assert values.objectives[1:, 0].tolist() == [np.inf, np.inf]
    assert values.violation[1:] == pytest.approx([0.15 / 0.5, np.inf])
    seen = problem_of(study, screened, nominal)
    problem = replace(seen, evaluate=lambda designs: values)
    assert Archive(problem)(np.array([GOOD, HEAVY, NO_ROOT])).failed.tolist() == [False, False, True]


def test_an_infinite_objective_without_a_violation_has_failed():
    values = Values(np.full((2, 1), np.inf), np.array([[-1.0], [1.0]]), np.empty((2, 0)), np.zeros(2, bool))
    archive = Archive(Problem(np.zeros(1), np.ones(1), lambda designs: values, inequalities=("limit",)))
    assert archive(np.array([[0.0], [1.0]])).failed.tolist() == [True, False]


def test_from_end_to_end(file, asked, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["optimise", str(file), "--out", str(out), "--no-plots"]) == 0
    result = json.loads((out / command.RESULT).read_text())
    assert len({tuple(design) for design in asked}) == len(asked)
    assert result["unrun"] > 0
    assert result["evaluations"] == len(asked) + result["unrun"] + result["failed"]
    assert set(result["failures"]) == {"no-value"}
    assert f"{result['unrun']} infeasible and not run" in " ".join(capsys.readouterr().out.split())
    for mass, slider in asked:
        assert mass + slider <= 0.5 * (1 + 1e-6)
        assert mass > slider
    assert main(["study", "show", str(out / command.STORE)]) == 0
    assert f"infeasible, not run: {result['unrun']}" in " ".join(capsys.readouterr().out.split())


# -- algorithms on a problem with no objective beyond its constraints ------------------------------------


def cliff(start):
    """Minimise (x - 2)^2 + (y - 1)^2 within the unit disc and above y = 1/4; not far outside there is no objective."""

    def evaluate(designs):
        x, y = designs.T
        limits = np.column_stack([x**2 + y**2 - 1.0, 0.25 - y])
        f = np.where((limits <= 2e-3).all(axis=1), (x - 2.0) ** 2 + (y - 1.0) ** 2, np.inf)
        return Values(f[:, None], limits, np.empty((len(designs), 0)), np.zeros(len(designs), bool))

    return Problem(-2.0 * np.ones(2), 2.0 * np.ones(2), evaluate, ("f",), ("disc", "above"), (), np.array(start))


OPTIMUM = np.array([2.0, 1.0]) / np.sqrt(5.0)


@pytest.mark.parametrize("step", [1e-4, 1e-2])
def test_in_a_corner_slopes_are_taken_beside(step):
    """Where the disc ends above and y = 1/4 below, the longer differences along y see nothing on either side."""
    corner = np.array([np.sqrt(1.0 - 0.25**2), 0.25])
    problem = cliff(corner)
    alone = problem.evaluate(corner + step * np.array([[0.0, 1.0], [0.0, -1.0]])).objectives
    assert np.isfinite(alone).all() == (step < 1e-3)
    slopes = jacobian(problem, problem.evaluate, corner, np.ones(2), step)
    exact = [2.0 * (corner - [2.0, 1.0]), [2.0 * corner[0], 0.5], [0.0, -1.0]]
    assert slopes == pytest.approx(np.array(exact), abs=1.01 * step)


def test_no_objective_around_is_no_slope():
    """A step longer than the feasible range around the corner."""
    corner = np.array([np.sqrt(1.0 - 0.25**2), 0.25])
    problem = cliff(corner)
    assert jacobian(problem, problem.evaluate, corner, np.ones(2), 3.0) is None


def test_a_search_that_reaches_a_corner_goes_on():
    """The best design is in the corner: the method must see it as such, and not as a failure."""
    base = cliff((0.0, 0.5))

    def evaluate(designs):  # the optimum of the disc is below y = 1/4 now
        values = base.evaluate(designs)
        x, y = designs.T
        f = np.where(np.isfinite(values.objectives[:, 0]), (x - 2.0) ** 2 + (y + 1.0) ** 2, np.inf)
        return replace(values, objectives=f[:, None])

    result = minimise("grg", replace(base, evaluate=evaluate), read_settings("grg", {"step": 1e-2}), seed=1)
    assert result.status is Ending.CONVERGED
    assert result.x[0] == pytest.approx([np.sqrt(1.0 - 0.25**2), 0.25], abs=2e-3)


@pytest.mark.parametrize("start", [(0.0, 0.5), (-1.5, -1.0), (1.5, 1.9)], ids=["inside", "below", "above"])
@pytest.mark.parametrize(
    ("name", "settings", "within"),
    [
        ("grg", {"step": 1e-4}, 1e-3),
        ("snopt", {"step": 1e-4}, 1e-3),
        ("ga", {"generations": 60}, 5e-2),
        ("differential-evolution", {"generations": 60}, 1e-3),
    ],
)
def test_algorithms_find_the_constrained_optimum(name, settings, within, start):
    result = minimise(name, cliff(start), read_settings(name, settings), seed=1)
    assert result.values.feasible(1e-6)[0]
    assert result.x[0] == pytest.approx(OPTIMUM, abs=within)
    assert result.status is not Ending.EVALUATION_FAILED
