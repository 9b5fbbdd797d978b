"""Studies of linkages with flexible links."""

import numpy as np
import pytest

from optim import Evaluator, find_study, load_study

#: Design that the shipped study finds with its seed: height, width and length of the rod [m], clearance [m],
#: viscosity [Pa s]; its jitter [m/s2] and stress [Pa], and the nominal design's.
BEST = (0.011345880026166176, 0.006137082126849452, 0.27333576988039676, 2.510258908617855e-05, 0.19069854439546544)
FOUND, NOMINAL = (0.47306, 8.6792e7), (1.7115, 1.3896e8)


def test_the_best_design_of_the_shipped_study_is_worth_what_is_told_of_it():
    """Section, length, oil and clearance together, within the limits of mass, stress and film."""
    study = load_study(find_study("slidercrank_flexible"))
    result = Evaluator(study)(np.array([study.nominal, BEST]))
    assert result.objectives[:, 0] == pytest.approx([NOMINAL[0], FOUND[0]], rel=1e-3)
    mass, stress, film = result.constraints[1]
    assert result.constraints[:, 1] == pytest.approx([NOMINAL[1], FOUND[1]], rel=1e-3)
    assert mass == pytest.approx(7870 * BEST[0] * BEST[1] * BEST[2], rel=1e-9)
    assert mass <= 0.15
    assert stress <= 1.2e8
    assert film >= 1e-5
