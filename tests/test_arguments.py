"""Arguments of public functions: one line names the argument, the value and what is allowed."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from shipped import shipped

import linkages
import optim
from linkages import InputError, Status, three_rrr
from linkages.base.arguments import Count, Lines, Matrix, Names, Vector, Whole, validated
from linkages.results.trajectory import sample
from optim.evaluate.requests import Statistics

TIMES = np.linspace(0.0, 2.0, 41)


def run():
    return sample(TIMES, lambda times: {"time": times, "y": times**2}, Status.OK, {})


@validated
def taken(
    number: float = 0.0,
    count: Count = 1,
    whole: Whole | None = None,
    names: Names = (),
    vector: Vector | None = None,
    matrix: Matrix | None = None,
    lines: Lines | None = None,
    system: linkages.System | None = None,
    text: str = "",
    function: Callable[[float], float] | None = None,
    pair: tuple[float, Count] = (0.0, 1),
    either: str | float = 0.0,
):
    """Return what the checks return."""
    return {key: value for key, value in locals().items() if value is not None}


@pytest.mark.parametrize(
    ("name", "given", "wanted"),
    [
        ("number", np.float32(0.5), 0.5),
        ("number", Fraction(1, 4), 0.25),
        ("count", np.int64(3), 3),
        ("whole", 0, 0),
        ("whole", None, None),
        ("names", iter("ab"), ("a", "b")),
        ("vector", [1, 2], [1.0, 2.0]),
        ("vector", np.array([1, 2], ">f4"), [1.0, 2.0]),
        ("vector", np.arange(6.0)[::2], [0.0, 2.0, 4.0]),
        ("vector", [Fraction(1, 2)], [0.5]),
        ("vector", np.ma.array([1.0, 2.0]), [1.0, 2.0]),
        ("matrix", [[1, 2]], [[1.0, 2.0]]),
        ("lines", [1, np.nan], [[1.0, np.nan]]),
        ("pair", np.array([1, 2]), (1.0, 2)),
        ("either", 1j, 1j),
    ],
)
def test_values_that_mean_the_same_are_converted(name, given, wanted):
    found = taken(**{name: given}).get(name)
    if isinstance(found, np.ndarray):
        assert found.dtype == np.float64
        assert found.flags.c_contiguous
        np.testing.assert_array_equal(found, wanted)
    else:
        assert found == wanted
        assert type(found) is type(wanted)


@pytest.mark.parametrize(
    ("name", "given", "problem"),
    [
        ("number", float("nan"), "is nan; give a finite number"),
        ("number", "1", "is '1'; give a finite number"),
        ("number", True, "is True; give a finite number"),
        ("number", 1j, "is 1j; give a finite number"),
        ("number", [1.0], r"is \[1.0\]; give a finite number"),
        ("number", None, "is None; give a finite number"),
        ("count", 0, "is 0; give a whole number, 1 or more"),
        ("count", 2.5, "is 2.5; give a whole number, 1 or more"),
        ("whole", -1, "is -1; give a whole number, 0 or more"),
        ("names", "ab", r'is a text; give a list: \["ab"\]'),
        ("names", 3, "is 3; give a list of names"),
        ("vector", 1.0, "have 0 dimensions; give a list of numbers"),
        ("vector", [[1.0]], "have 2 dimensions; give a list of numbers"),
        ("vector", [1.0, 1j], "are no real numbers but complex"),
        ("vector", ["1"], "are no real numbers but texts"),
        ("vector", [1.0, np.inf], "have inf; give finite numbers"),
        ("vector", np.ma.masked_less([1.0, 2.0], 1.5), "have masked entries"),
        ("vector", [[1.0], [1.0, 2.0]], "are no table of numbers"),
        ("matrix", [1.0], "have 1 dimensions; give a table, a line for each"),
        ("lines", [[[1.0]]], "have 3 dimensions; give a table, a line for each"),
        ("names", ["a", 3], "is 3; give a list of names"),
        ("text", 3, "is 3; give a text"),
        ("function", 3, "is 3; give a function"),
        ("pair", 3.0, "is 3.0; give 2 values"),
        ("pair", (1.0,), r"is \(1.0,\); give 2 values"),
        ("pair", (1.0, 0.5), "is 0.5; give a whole number, 1 or more"),
        ("system", "seven_bar.toml", "is 'seven_bar.toml'; give a System of linkages"),
    ],
)
def test_other_values_are_refused_in_one_line(name, given, problem):
    with pytest.raises(InputError, match=f"^argument: {name}: {problem}") as caught:
        taken(**{name: given})
    assert "\n" not in str(caught.value)


def test_a_wrong_call_is_an_error_of_python():
    with pytest.raises(TypeError, match="numbers"):
        taken(numbers=1.0)


def bowl(shape=(1,), failed=1, jacobian=None):
    def evaluate(designs):
        m = len(designs)
        objectives = (designs**2).sum(axis=1).reshape(m, *shape)
        return optim.Values(objectives, np.empty((m, 0)), np.empty((m, 0)), np.zeros(m * failed, dtype=bool))

    return optim.Problem(np.zeros(2), np.ones(2), evaluate, jacobian=jacobian)


CRANKS = {
    "two arrays": lambda times: (np.zeros((len(times), 3)),) * 2,
    "a wrong shape": lambda times: (np.zeros(len(times)),) * 3,
}


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (lambda system: linkages.simulate("seven_bar.toml"), "system: is 'seven_bar.toml'; give a System"),
        (lambda system: linkages.simulate_batch(system, threads=-1), "threads: is -1; give a whole number, 1 or more"),
        (lambda system: linkages.simulate_batch(system, windows=[[0.0, 1j]]), "windows: are no real numbers"),
        (
            lambda system: linkages.simulate_batch(system, ["joints.A.viscosity"], [[0.1]], limits=[[0.1], [np.inf]]),
            "limits",
        ),
        (lambda system: linkages.simulate(system, wrt=[3]), "wrt: has 3; give dotted paths, or Direction"),
        (lambda system: linkages.simulate(system, progress=3), "progress: is 3; give a function"),
        (
            lambda system: linkages.bearing(0.1, 0.05, 1e-4, 0.03, 100.0, 1e3, cells=(72, 1)),
            "cells: is 1; give a whole",
        ),
        (lambda system: linkages.integral(run(), 1j * TIMES), "values: are no real numbers but complex"),
        (
            lambda system: linkages.IdealMotion(system).states([0.0], np.zeros((2, 2))),
            "offset: its values have the shape",
        ),
        (lambda system: linkages.linearise(system, time=-1.0), "time: is -1 s, before the start of the run"),
        (lambda system: linkages.stroboscopic(system, ["A.force"], 1.5), "revolutions: is 1.5; give a whole number"),
        (lambda system: linkages.sweep(system, "joints.A.viscosity", [[0.1]], ["A.force"], 1), "values: have 2 dim"),
        (lambda system: linkages.sweep(system, "joints.A.viscosity", [0.1], ["A.force"], 1, threads=0), "threads: is"),
        (lambda system: linkages.largest_exponent(system, 0), "revolutions: is 0; give a whole number, 1 or more"),
        (lambda system: linkages.modes(system, time="now"), "time: is 'now'; give a finite number"),
        (lambda system: linkages.linearise(system, time=float("nan")), "time: is nan; give a finite number"),
        (lambda system: linkages.horizon(system, most=float("inf")), "most: is inf; give a finite number"),
        (lambda system: linkages.wear_life(system, 2.5), "cycles: is 2.5; give a whole number, 1 or more"),
        (lambda system: linkages.crossings(run(), "y", start=1j), "start: is 1j; give a finite number"),
        (lambda system: linkages.spectrum(run(), "y", samples=64.5), "samples: is 64.5; give a whole number"),
        (lambda system: linkages.extremes(run(), "y"), 'names: is a text; give a list: ["y"]'),
        (lambda system: linkages.impacts({"y": TIMES}, ["B"]), "trajectory: is {'y': array"),
        (lambda system: linkages.IdealMotion(system).states([[0.0]]), "times: have 2 dimensions"),
        (lambda system: optim.minimise("grg", bowl(), seed=0.5), "seed: is 0.5; give a whole number, 0 or more"),
        (lambda system: optim.minimise("grg", bowl(())), "its objectives have the shape (1,); they must have (1, 1)"),
        (lambda system: optim.minimise("ga", bowl((1, 1))), "they must have (60, 1)"),
        (lambda system: optim.minimise("grg", bowl(failed=2)), "its failed have the shape (2,); they must have (1,)"),
        (lambda system: optim.minimise("grg", bowl(jacobian=lambda x: x)), "jacobian: its derivatives have the shape"),
        (lambda system: optim.Problem(np.zeros(2), np.ones(3), bowl().evaluate), "upper: its numbers have the shape"),
        (lambda system: optim.knee([1.0, 2.0]), "objectives: have 1 dimensions; give a table"),
        (lambda system: optim.knee([[1.0, np.nan]]), "objectives: have nan; give finite numbers"),
        (lambda system: three_rrr.follow(*robot(), [0.0, 0.0], 1.0), "x0: have 2 numbers for 3"),
        (lambda system: three_rrr.follow(*robot(), np.zeros(3), -1.0), "duration: is -1 s; it must be above zero"),
        (lambda system: three_rrr.follow(*robot("two arrays"), np.zeros(3), 1.0), "cranks: returned 2 arrays"),
        (lambda system: three_rrr.follow(*robot("a wrong shape"), np.zeros(3), 1.0), "cranks: its angles, rates or"),
        (lambda system: three_rrr.drive_map(robot()[0], 0.0, points=0), "points: is 0; give a whole number, 1 or more"),
    ],
)
def test_public_functions_check_their_arguments(call, problem):
    with pytest.raises(InputError) as caught:
        call(shipped("seven_bar"))
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


def robot(cranks=None):
    found = three_rrr.load_robot(linkages.find_file("three_rrr.toml"))
    return found.geometry, CRANKS.get(cranks, found.cranks)


def test_a_study_refuses_designs_of_another_size():
    study = optim.load_study(optim.find_study("sevenbar_force"))
    evaluate = optim.Evaluator(study)
    with pytest.raises(InputError, match="designs: have 2 numbers for 6 variables; give as many"):
        evaluate([[0.1, 0.2]])
    with pytest.raises(InputError, match="design: have 2 numbers for 6 variables; give as many"):
        optim.check_derivatives(study, [0.1, 0.2])
    with pytest.raises(InputError, match="start: have 2 numbers for 6 variables; give as many"):
        optim.optimise(study, start=[0.1, 0.2])
    with pytest.raises(InputError, match="threads: is -1; give a whole number, 1 or more"):
        optim.Evaluator(study, threads=-1)


@pytest.mark.parametrize(
    ("shape", "count", "problem"),
    [
        ((4, 1, 1), 1, r"engine: its statistics have the shape \(4, 1, 1\)"),
        ((4, 1, 1, 1), 2, "2 statuses and 2 reasons for 1"),
    ],
)
def test_an_engine_of_the_users_must_answer_all_that_it_is_asked(shape, count, problem):
    study = optim.load_study(optim.find_study("sevenbar_force"))

    def engine(request):
        size = (*np.shape(request.windows)[:1], len(request.outputs))
        return Statistics(
            np.zeros((*shape[:2], *(size if len(shape) == 4 else size[:1]))), ["ok"] * count, [""] * count
        )

    with pytest.raises(InputError, match=problem):
        optim.Evaluator(study, engine=engine)(study.nominal[None])
