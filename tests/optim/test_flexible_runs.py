"""Studies of linkages with flexible links."""

import numpy as np
import pytest

from optim import Evaluator, find_study, load_study

#: Design that the shipped study finds with its seed: height, width and length of the rod [m], clearance [m],
#: viscosity [Pa s]; its jitter [m/s2] and stress [Pa], and the nominal design's.
BEST = (0.010945037760491305, 0.0063024146185875676, 0.2734748810014384, 2.101264742817926e-05, 0.1664463213983773)
FOUND, NOMINAL = (0.47168, 8.9819e7), (1.7115, 1.3896e8)


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
