"""Service life as objective: against the exact pocket, together with outputs of a run; rejected input."""

import math

import numpy as np
import pytest
from wearing_press import CLEARANCE, LENGTH, RADIUS, area, write_press

from linkages import InputError
from optim.evaluate.evaluator import Evaluator
from optim.evaluate.single_runs import cycles_of
from optim.problem.load import find_study, load_study

LOAD, LIMIT = 100.0, 5e-6
STUDY = f"""
experiment = "press.toml"
set.joints.B.wear.nodes = 120
[variables.k]
path = "joints.B.wear.coefficient"
lower = 1e-13
upper = 2e-12
[lives.pocket]
until = "B.depth"
limit = {LIMIT}
cycles = 500
[objectives.life]
maximise = true
terms = [{{ functional = "mean", output = "life.pocket" }}]
[constraints.force]
at_most = 1e4
terms = [{{ functional = "max", output = "B.force" }}]
[algorithm]
name = "ga"
"""


@pytest.fixture
def study(tmp_path):
    def made(old="", new=""):
        assert old in STUDY
        write_press(tmp_path)
        (tmp_path / "mine.toml").write_text(STUDY.replace(old, new) if old else STUDY)
        return load_study(tmp_path / "mine.toml")

    return made


def test_the_life_until_a_depth_is_the_exact_pockets(study):
    """k F s = A(d) L, s the path of a journal in so many turns; a longer life counts as the simulated one."""
    k = np.array([1e-12, 2e-12, 1e-13])
    found = Evaluator(study())(k[:, None])
    assert found.status == ("ok",) * 3
    turns = area(LIMIT) * LENGTH / (k * LOAD) / (2.0 * math.pi * (RADIUS - CLEARANCE))
    assert turns[1] < turns[0] < 500.0 < turns[2]
    # the contact is elastic, so that the pocket is a little wider than the rigid journal's
    assert found.objectives[:2, 0] == pytest.approx(turns[:2], rel=0.02)
    assert found.objectives[2, 0] == 500.0
    assert np.all(found.constraints[:, 0] > LOAD)  # of a run, not of a life; the block falls upon the shaft


@pytest.mark.slow
def test_the_optimum_of_the_shipped_study_stands_in_finer_runs():
    """The optimum of the study, 34.7 kN/m: its life at half the tolerance, and its neighbours' at the study's.

    Impacts magnify the last bit of a stiffness to 5 % of a life: means of three lives.
    """
    study = load_study(find_study("slidercrank_life"))
    given = study.file.lives["pocket"]
    finer = given.model_copy(update={"tolerance": 5e-6})
    stiffnesses = 34665.0 * (1.0 + np.array([0.0, 1e-12, -1e-12]))
    lives, fine = ([cycles_of(study.system(np.array([k])), life) for k in stiffnesses] for life in (given, finer))
    best = np.mean(fine)
    below, above = (cycles_of(study.system(np.array([k])), given) for k in (20e3, 60e3))
    assert best > 1.2 * below
    assert best > 1.2 * above
    found = Evaluator(study)(np.array([[34665.0]])).objectives[0, 0]
    assert found == lives[0]
    assert np.mean(lives) == pytest.approx(best, rel=0.1)  # the depth to 1e-5 of 5e-5 m


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("life.pocket", "life.pockets", r'objectives.life.terms\[0\].output: "life.pockets" is unknown; did you mean'),
        ('"mean"', '"range"', r'terms\[0\].functional: is "range" of one number; write "mean"'),
        ("B.depth", "B.death", r'lives.pocket: .*B.death: is unknown; did you mean "B.depth"'),
        ("cycles = 500", "cycles = 0", "cycles: .*greater than or equal to 1"),
        ("limit = 5e-06", "limit = 5e-06\ndrive = 'B'", 'lives.pocket: drive: "B" has no prescribed motion'),
    ],
)
def test_refused(study, old, new, why):
    with pytest.raises(InputError, match=why):
        study(old, new)
