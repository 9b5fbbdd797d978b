"""Outputs of the ideal linkage: against other ways to compute them, without a simulation; the surrogate orders designs."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import qmc, spearmanr
from shipped import FAST_PRESS

from linkages import InputError, ideal
from optim.evaluate.evaluator import Evaluator, Screened
from optim.evaluate.single_runs import turning_rate
from optim.problem.load import find_study, load_study

STUDY = f"""
experiment = "{FAST_PRESS}"
set.duration = 1.0
[variables.mass]
path = "sdf.links.link2.mass"
lower = 0.1
upper = 0.5
[objectives.force]
terms = [{{ functional = "peak", output = "ideal.A.force" }}]
[constraints.acceleration]
at_most = 10.0
terms = [{{ functional = "peak", output = "ideal.slider7.ax" }}]
[constraints.turn]
at_most = 100.0
terms = [{{ functional = "max", output = "ideal.A.turning_rate" }}]
[constraints.real]
at_most = 1.0
terms = [{{ functional = "peak", output = "slider7.ax" }}]
[algorithm]
name = "ga"
"""


def test_turning_rate_of_known_vectors():
    t = np.linspace(0.0, 1.0, 2001)
    angle, length = 2.0 * np.pi * t + 0.3 * np.sin(9.0 * t), 1.5 + np.cos(7.0 * t)
    rate = turning_rate(length * np.cos(angle), length * np.sin(angle), t)
    assert rate == pytest.approx(2.0 * np.pi + 2.7 * np.cos(9.0 * t), abs=1e-6)
    assert turning_rate(-length, length, t) == pytest.approx(0.0, abs=1e-12)


@pytest.fixture
def surrogate():
    return load_study(find_study("fourbar_surrogate"))


def test_the_surrogate_against_differences_of_the_angle(surrogate):
    """The force in B of the ideal linkage, its angle by atan2, that by differences."""
    times = np.linspace(0.1, 0.2, 40001)
    columns = ideal(surrogate.points[0].system).evaluate(times)
    rate = np.gradient(np.unwrap(np.arctan2(columns["B.fy"], columns["B.fx"])), times)
    found = Evaluator(surrogate)(surrogate.nominal[None]).objectives[0, 0]
    # lengths of bars set masses to more digits than the machine's file has
    assert found == pytest.approx(np.abs(rate).max(), rel=1e-3)


def test_no_simulation_is_made(surrogate):
    def engine(request):
        raise AssertionError("a run")

    assert Evaluator(surrogate, engine=engine)(surrogate.nominal[None]).status == ("ok",)


def test_beside_outputs_of_a_run(tmp_path, invented_engine):
    """The drives dictate the slider's acceleration; the force in A grows with the moved mass."""
    path = tmp_path / "mine.toml"
    path.write_text(STUDY)
    study = load_study(path)
    masses = np.array([[0.15], [0.4]])
    found = Evaluator(study)(masses)
    alone = Evaluator(study)(masses[1:])
    assert found.status == ("ok", "ok")
    assert found.objectives[1, 0] > found.objectives[0, 0] > 0.0
    assert found.constraints[:, 0] == pytest.approx([4.667, 4.667], abs=1e-3)
    assert found.constraints[1].tobytes() == alone.constraints[0].tobytes()
    assert found.constraints[0, 2] != found.constraints[1, 2]  # the invented engine's


def test_a_design_that_cannot_be_assembled(surrogate):
    longer = surrogate.nominal * [1.0, 1.0, 5.0, 1.0]
    found = Evaluator(surrogate)(longer[None])
    assert found.failed[0]
    assert found.status[0] == "no-assembly"


@pytest.mark.parametrize(
    ("output", "why"),
    [
        ("ideal.B.ex", r'objectives\.\w+\.terms\[0\]: .*output "B\.ex": is unknown; did you mean "B\.fx"'),
        ("ideal.follower.alpha.jitter", "jitter exists only for the motion of a link or frame"),
        ("ideal.B.turning_ratio", 'output "B.turning_ratio": is unknown'),
        ("B.turning_rate", 'output "B.turning_rate": is unknown'),
    ],
)
def test_refused(tmp_path, output, why):
    path = tmp_path / "mine.toml"
    path.write_text(find_study("fourbar_surrogate").read_text().replace("ideal.B.turning_rate", output))
    with pytest.raises(InputError, match=why):
        load_study(path)


@pytest.mark.slow
def test_the_surrogate_orders_designs_as_the_steady_jitter(surrogate):
    """That of one start and three revolutions, which takes a tenth of the study's time."""
    steady = load_study(find_study("fourbar_jitter_steady"))
    point = steady.points[0]
    windows = {**point.windows, "steady": point.windows["steady"][:3]}
    short = point.system.replaced({"duration": float(windows["steady"][-1, 1])})
    steady = dataclasses.replace(steady, points=(dataclasses.replace(point, system=short, windows=windows),))
    sample = qmc.LatinHypercube(4, rng=np.random.default_rng(1)).random(400)
    designs = surrogate.lower + sample * (surrogate.upper - surrogate.lower)
    screened = Screened(surrogate, Evaluator(surrogate))(designs)
    turning = screened.objectives[:, 0]
    good = np.flatnonzero(np.isfinite(turning))[:16]
    assert len(good) == 16
    jitter = Evaluator(steady)(designs[good]).objectives[:, 0]
    assert np.isfinite(jitter).all()
    assert spearmanr(turning[good], jitter).statistic > 0.8
