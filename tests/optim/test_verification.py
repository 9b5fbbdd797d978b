"""Results are verified by another engine, and a false claim is detected."""

import numpy as np
import pytest

from optim.evaluate.evaluator import Evaluator, run_compiled
from optim.evaluate.requests import STATISTICS
from optim.evaluate.single_runs import run_on_drake
from optim.problem.load import load_study
from optim.search.verification import format_verification, unseen_phases, verify

PRESS = """
experiment = "seven_bar.toml"
set.duration = 0.06
[variables.mass]
path = "sdf.links.link2.mass"
relative = true
lower = 0.5
upper = 2.0
[windows.late]
start = 0.02
end = 0.05
[objectives.force]
terms = [{ functional = "peak", output = "A.force" }]
[objectives.film]
terms = [{ functional = "min", output = "B.film_thickness", window = "late", over_points = "min" }]
[objectives.load]
terms = [{ functional = "rms", output = "B.force", window = "late" }]
[constraints.work]
at_most = 10.0
terms = [{ functional = "integral", output = "O1.power" }]
[algorithm]
name = "nsga2"
"""

DRY = """
experiment = "four_bar_dry.toml"
set.duration = 0.01
[variables.follower]
path = "sdf.frames.follower_B.pose.x"
relative = true
lower = 0.9
upper = 1.1
[objectives.jitter]
terms = [{ functional = "peak", output = "follower.alpha.jitter" }]
[algorithm]
name = "ga"
"""


def claim(study, objectives, constraints):
    """The nominal design as if it had been found."""
    return {
        "status": "ok",
        "variables": dict(zip(study.paths, map(float, study.nominal), strict=True)),
        "objectives": objectives,
        "constraints": constraints,
    }


@pytest.fixture(scope="module")
def press(tmp_path_factory):
    path = tmp_path_factory.mktemp("trust") / "press.toml"
    path.write_text(PRESS)
    return load_study(path)


@pytest.mark.slow
def test_drake_agrees_and_a_false_claim_is_found(press):
    found = Evaluator(press)(press.nominal[None])
    force, film, load = map(float, found.objectives[0])
    work = float(found.constraints[0, 0])
    best = claim(press, {"force": force, "film": film, "load": 1.1 * load}, {"work": work})
    parts = []
    report = verify(press, best, progress=parts.append)
    assert parts == sorted(parts)
    assert len(parts) > 10
    assert parts[-1] == 1.0
    assert report["status"] == "ok"
    assert abs(report["objectives"]["force"]["difference"]) < 1e-4
    assert abs(report["objectives"]["film"]["difference"]) < 1e-4
    assert report["objectives"]["load"]["difference"] == pytest.approx(0.1, abs=1e-3)
    assert abs(report["constraints"]["work"]["difference"]) < 1e-3  # the study's own tolerance, at the start
    assert report["phases"] is None  # no contact
    assert "1.0e-01" in format_verification(report)


@pytest.mark.slow
@pytest.mark.parametrize("text", [PRESS, DRY], ids=["lubricated", "dry"])
def test_statistics_of_both_engines(text, tmp_path):
    """Every statistic in every window, also where a window's ends lie within steps."""
    path = tmp_path / "study.toml"
    path.write_text(text)
    study, requests = load_study(path), []

    def keep(request):
        requests.append(request)
        return run_compiled(request)

    Evaluator(study, engine=keep)(study.nominal[None])
    drake, compiled = run_on_drake(requests[0]), run_compiled(requests[0])
    minimum, maximum, *_ = compiled.values[:, 0]
    for name, a, b in zip(STATISTICS, drake.values[:, 0], compiled.values[:, 0], strict=True):
        for k, output in enumerate(requests[0].outputs):
            scale = np.abs([minimum[:, k], maximum[:, k]]).max()
            assert a[:, k] == pytest.approx(b[:, k], abs=1e-3 * scale), (name, output)


def test_an_optimum_that_failed_is_not_verified(press):
    report = verify(press, {"status": "no-assembly"})
    assert report["status"] == "the optimum failed: no-assembly"
    assert "not verified" in format_verification(report)


def test_unseen_phases(tmp_path):
    path = tmp_path / "dry.toml"
    path.write_text(DRY)
    study = load_study(path)
    report = unseen_phases(study, 1.05 * study.nominal)
    angles = report["angles"]
    assert len(set(np.round(angles, 6))) == len(angles) == 10
    entry = report["objectives"]["jitter"]
    for k in (0, 7):  # the same by an experiment that starts there
        text = DRY.replace("[variables", f"set.drives.O.angle = {angles[k]!r}\n[variables", 1)
        path.write_text(text)
        there = Evaluator(load_study(path))(np.vstack([1.05 * study.nominal, study.nominal])).objectives[:, 0]
        assert [entry["best"][k], entry["nominal"][k]] == pytest.approx(there, rel=1e-12)
    assert entry["change"] == pytest.approx(np.mean(entry["best"]) / np.mean(entry["nominal"]) - 1.0)
