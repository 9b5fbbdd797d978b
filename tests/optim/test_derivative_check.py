"""``linkages optimise --check``: derivatives of studies against differences of designs, and the rule that judges them."""

import json

import numpy as np
import pytest

import linkages
import optim
from linkages.cli.main import main
from optim.algorithms.derivatives import jacobian
from optim.search import derivative_check

STUDY = """
experiment = "seven_bar.toml"

[set]
duration = 0.1

[variables.mass]
path  = "sdf.links.link2.mass"
lower = 0.15
upper = 0.45

[variables.clearance]
path  = "joints.A.clearance"
lower = 2e-4
upper = 4e-4

[objectives.force]
relative = true
terms    = [{ functional = "peak", output = "A.force" }]

[constraints.motion]
at_most = 30.0
terms   = [{ functional = "rms", output = "B.force" }]

[constraints.work]
equals = 0.1
terms  = [{ functional = "integral", output = "O1.power" }]

[algorithm]
name        = "grg"
iterations  = 2
derivatives = "sensitivities"
"""


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "press.toml"
    file.write_text(STUDY, encoding="utf-8")
    return file


@pytest.fixture
def study(file):
    return optim.load_study(file).replaced(lambda system: {"solver.accuracy": 1e-9})


def _verdicts(report):
    return {one["verdict"] for table in report["quantities"].values() for one in table.values()}


def test_sensitivities_agree_with_differences(study):
    report = optim.check_derivatives(study, study.nominal)
    assert report["agrees"]
    assert list(report["quantities"]) == ["force", "motion.at_most", "work.equals"]
    for name, table in report["quantities"].items():
        assert list(table) == ["sdf.links.link2.mass", "joints.A.clearance"], name
        assert {one["verdict"] for one in table.values()} == {"agrees"}
        assert max(one["deviation"] for one in table.values()) < 1e-3
    text = optim.format_derivative_check(study, report, "start")
    assert text.splitlines()[1] == "force [of nominal]"
    assert "DIFFERS" not in text


def test_a_wrong_derivative_differs(study, monkeypatch):
    right = optim.Gradients.__call__
    wrong = np.array([[1.05, 1.0], [1.0, 1.0], [1.0, 1.0]])
    monkeypatch.setattr(optim.Gradients, "__call__", lambda self, design: right(self, design) * wrong)
    report = optim.check_derivatives(study, study.nominal)
    assert not report["agrees"]
    assert report["quantities"]["force"]["sdf.links.link2.mass"]["verdict"] == "DIFFERS"
    assert _verdicts(report) == {"DIFFERS", "agrees"}


def test_differences_that_change_with_their_step_say_nothing(study, monkeypatch):
    def rough(problem, evaluate, design, width, step):
        return jacobian(problem, evaluate, design, width, step) * (1.1 + 0.2 * (-1) ** round(np.log10(step)))

    monkeypatch.setattr(derivative_check, "jacobian", rough)
    report = optim.check_derivatives(study, study.nominal)
    assert report["agrees"]
    assert "unclear" in _verdicts(report)


def test_absent_derivatives_are_not_judged(study, monkeypatch):
    monkeypatch.setattr(optim.Gradients, "__call__", lambda self, design: np.full((3, 2), np.nan))
    report = optim.check_derivatives(study, study.nominal)
    assert report["agrees"]
    assert _verdicts(report) == {"none"}


def test_the_command_checks_start_and_optimum(file, tmp_path, capsys, monkeypatch):
    out = tmp_path / "out"
    assert main(["optimise", str(file), "--out", str(out), "--no-plots", "--check"]) == 0
    found = capsys.readouterr()
    assert "derivatives at the start" in found.out
    assert "derivatives at the optimum" in found.out
    assert "warning" not in found.err
    result = json.loads((out / "result.json").read_text())
    assert set(result["derivatives"]) == {"start", "best"}
    assert all(one["agrees"] for one in result["derivatives"].values())
    right = optim.Gradients.__call__
    monkeypatch.setattr(optim.Gradients, "__call__", lambda self, design: -right(self, design))
    assert main(["optimise", str(file), "--out", str(tmp_path / "other"), "--no-plots", "--check"]) == 0
    assert "warning: derivatives at the start differ" in capsys.readouterr().err


def test_an_algorithm_without_derivatives_is_refused(file, tmp_path, capsys):
    text = STUDY[: STUDY.index("[algorithm]")] + '[algorithm]\nname = "ga"\n'
    file.write_text(text, encoding="utf-8")
    assert main(["optimise", str(file), "--out", str(tmp_path / "out"), "--check"]) == 2
    assert '"ga" uses no derivatives' in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_service_life_is_refused():
    study = optim.load_study(optim.find_study("slidercrank_life"))
    with pytest.raises(linkages.InputError, match="no sensitivities"):
        optim.check_derivatives(study, study.nominal)
