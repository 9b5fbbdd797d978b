"""Derivatives of studies by sensitivities of runs, against differences of designs."""

import dataclasses

import numpy as np
import pytest
from machines import joint, model, solid

import linkages
import optim
from linkages.cli.main import main
from optim.algorithms.derivatives import jacobian

STUDY = """
experiment = "seven_bar.toml"

[set]
duration = 0.12

[constants]
ratio = 2.0

[variables.mass]
path  = "sdf.links.link2.mass"
lower = 0.15
upper = 0.45

[variables.clearance]
path  = "joints.A.clearance"
lower = 2e-4
upper = 4e-4

[linked]
"joints.B.clearance"      = "ratio * clearance"
"sdf.links.link2.inertia" = "mass**2 / 100"

[windows.late]
start = 0.05
end   = 0.11
count = 2

[points.slow]

[points.fast]
set = { "drives.O1.speed" = 9.0 }

[objectives.force]
relative = true
terms = [
    { functional = "peak", output = "A.force", weight = 0.5, over_points = "mean" },
    { functional = "rms", output = "B.force", window = "late", over_windows = "mean" },
]

[constraints.motion]
at_most = 5.0
terms   = [
    { functional = "mean", output = "A.force", window = "late", weight = 2.0 },
    { functional = "range", output = "slider7.x.jitter", window = "late", over_points = "min", weight = 1e3 },
    { functional = "min", output = "A.eccentricity_ratio", window = "late" },
]
over_terms = "sum"

[constraints.work]
equals = 0.1
terms  = [{ functional = "integral", output = "O1.power" }]

[constraints.size]
formula  = "mass * clearance"
at_least = 1e-5

[algorithm]
name        = "grg"
derivatives = "sensitivities"
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    file = tmp_path_factory.mktemp("study") / "press.toml"
    file.write_text(STUDY, encoding="utf-8")
    return optim.load_study(file).replaced(lambda system: {"solver.accuracy": 1e-11})


def test_all_functionals_have_the_derivatives_of_differences(study):
    evaluate = optim.Evaluator(study)
    nominal = evaluate(study.nominal[None])
    problem = optim.problem_of(study, evaluate, nominal)
    x, width = study.nominal * 1.02, study.upper - study.lower
    found = optim.Gradients(study, evaluate, nominal)(x)
    expected = jacobian(problem, problem.evaluate, x, width, 1e-2)
    assert found.shape == expected.shape == (4, 2)
    errors = np.abs((found - expected) * width)
    # the means of a batch have errors of up to 1e-6 of themselves, which shorter steps magnify further
    assert np.all(errors < 3e-5 * np.abs(expected * width).max(axis=1, keepdims=True))


def test_the_reduced_gradient_method_needs_fewer_designs_with_sensitivities(tmp_path):
    text = optim.find_study("sevenbar_force").read_text(encoding="utf-8")
    file = tmp_path / "sevenbar_force.toml"
    file.write_text(text.replace("[set]", "[set]\nduration = 0.2"), encoding="utf-8")
    study, found = optim.load_study(file), []
    for source in ("sensitivities", "differences"):
        found.append(optim.optimise(study, algorithm={"name": "grg", "derivatives": source, "step": 1e-4}))
    best = [one["best"]["objectives"]["force"] for one in found]
    assert best[0] == pytest.approx(best[1], rel=1e-4)
    assert best[0] < 0.95 * found[0]["nominal"]["objectives"]["force"]
    assert 2 * found[0]["evaluations"] < found[1]["evaluations"]


def test_derivatives_that_are_unknown_are_taken_by_differences():
    def evaluate(designs):
        empty = np.empty((len(designs), 0))
        return optim.Values((designs**2).sum(axis=1, keepdims=True), empty, empty, np.zeros(len(designs), dtype=bool))

    problem = optim.Problem(np.zeros(2), np.ones(2), evaluate, jacobian=lambda x: np.array([[2.0 * x[0], np.nan]]))
    x = np.array([0.5, 0.25])
    np.testing.assert_allclose(jacobian(problem, evaluate, x, np.ones(2), 1e-3), [[1.0, 0.5]], rtol=1e-9)
    exact = dataclasses.replace(problem, jacobian=lambda x: np.array([[1.5, 2.5]]))
    assert jacobian(exact, evaluate, x, np.ones(2), 1e-3).tolist() == [[1.5, 2.5]]


def test_a_design_that_formulas_exclude_is_not_run(study):
    screened = optim.Screened(study, optim.Evaluator(study))
    gradients = optim.Gradients(study, screened, screened(study.nominal[None]))
    found = gradients(np.array([0.15, 2e-5]))
    assert (found[0] == 0.0).all()
    assert found[2, 0] == pytest.approx(-2e-5 / 1e-5)  # d(mass clearance)/d mass, by the limit


def test_service_lives_have_no_sensitivities():
    study = optim.load_study(optim.find_study("slidercrank_life"))
    algorithm = {"name": "grg", "derivatives": "sensitivities"}
    with pytest.raises(linkages.InputError, match="life"):
        optim.optimise(study, algorithm=algorithm)


@pytest.mark.slow
def test_the_shipped_study_of_a_flexible_machine_has_the_gradient_of_differences():
    """Central differences of runs with tight accuracy; the two of small numbers have errors of a per cent."""
    study = optim.load_study(optim.find_study("slidercrank_flexible"))
    evaluate = optim.Evaluator(study)
    found = optim.Gradients(study, evaluate, evaluate(study.nominal[None]))(study.nominal)[0]
    gradient = dict(zip(study.names, found, strict=True))
    assert [gradient[name] for name in ("height", "width", "length")] == pytest.approx([-746.0, -1.91, 28.8], rel=0.015)


#: A block of 2 kg falls 0.2 m onto a dashpot with a soft spring: its force jumps to D v at the touch, and falls.
DASHPOT = """mechanism = "block.sdf"
duration = 0.25
gravity = [0.0, 0.0, 0.0]
outputs = ["block.y"]
[drives.slide]
angle = 0.0
speed = 0.0
force = -19.62
[stops.floor]
joint = "slide"
side = "lower"
limit = -0.2
contact = { law = "kelvin-voigt", restitution = 0.5, stiffness = 1e3, damping = 1e3 }
[solver]
max_step = 1e-2
accuracy = 1e-11
"""
DROP = """
experiment = "block.toml"
[variables.limit]
path = "stops.floor.limit"
lower = -0.3
upper = -0.1
[objectives.force]
terms = [{ functional = "peak", output = "floor.load" }]
[algorithm]
name = "grg"
derivatives = "sensitivities"
"""


def test_the_gradient_of_a_peak_at_a_jump_is_that_of_differences(tmp_path, capsys):
    """The peak D sqrt(2 g h) changes with the drop h by D g / v: the change of the time of the jump is part of it."""
    body = solid("block", 2.0) + joint("slide", "world", "block", "prismatic", "0 1 0")
    (tmp_path / "block.sdf").write_text(model("block", body))
    (tmp_path / "block.toml").write_text(DASHPOT)
    (tmp_path / "drop.toml").write_text(DROP)
    study = optim.load_study(tmp_path / "drop.toml")
    evaluate = optim.Evaluator(study)
    nominal = evaluate(study.nominal[None])
    damping, speed = 1e3, np.sqrt(2.0 * 9.81 * 0.2)
    assert nominal.objectives[0, 0] == pytest.approx(damping * speed, rel=1e-6)
    assert np.isnan(optim.Gradients(study, evaluate, nominal)(study.nominal)).all()
    problem = optim.problem_of(study, evaluate, nominal)
    slope = jacobian(problem, problem.evaluate, study.nominal, study.upper - study.lower, 1e-4)
    assert slope[0, 0] == pytest.approx(-damping * 9.81 / speed, rel=1e-4)
    (entry,) = optim.check_derivatives(study, study.nominal)["quantities"]["force"].values()
    assert (entry["verdict"], entry["sensitivity"]) == ("none", None)
    system = linkages.load(tmp_path / "block.toml")
    batch = linkages.simulate_batch(system, outputs=["floor.load"], wrt=["stops.floor.limit"])
    assert np.isnan(batch.sensitivity["stops.floor.limit"]["peak"]).all()
    command = ["sensitivity", str(tmp_path / "block.toml"), "--wrt", "stops.floor.limit", "--no-plots"]
    assert main([*command, "--output", "floor.load", "--no-error-estimate", "--out", str(tmp_path / "out")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "is at a jump" in said
    assert "no statement is possible about a change of stops.floor.limit by 1 %" in said
