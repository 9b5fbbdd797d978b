"""Computed distributions of dry objectives: their rule, and that other start angles give the same on any processor."""

import numpy as np
import pytest
from replication.dry import CASES, COUNTED, STARTS, Dry, counted, peaks, phases, stored


def made(change, scatter, starts=200, seed=3):
    """A distribution whose recorded design changes every peak by a factor, with some scatter."""
    rng = np.random.default_rng(seed)
    first = np.exp(scatter * rng.standard_normal((2, starts)))
    later = np.exp(scatter * rng.standard_normal((2, starts, 10)))
    first[1] *= change
    later[1] *= change
    return Dry(first, later)


def test_intervals_are_quantiles_of_the_changes():
    """Of log-normal peaks: the ratio of two has sqrt(2) times the scatter, its 5 % quantile lies 1.645 of these below."""
    found = made(0.3, 0.2, 20000).start
    expected = [100.0 * (0.3 * np.exp(x * 1.6449 * 0.2 * np.sqrt(2.0)) - 1.0) for x in (0.0, -1.0, 1.0)]
    np.testing.assert_allclose(found, expected, atol=0.5)


def test_the_interval_of_the_running_machine_contains_the_true_change():
    """In nine of ten samples, as a 5 to 95 % interval must; it shrinks with the root of the number of start angles."""
    found = [made(0.3, 0.5, 24, seed).running for seed in range(60)]
    assert 0.78 < np.mean([one.low < -70.0 < one.high for one in found]) <= 0.99
    wide, narrow = (made(0.3, 0.5, starts).running for starts in (12, 192))
    assert (narrow.high - narrow.low) < 0.4 * (wide.high - wide.low)


@pytest.mark.parametrize("name", CASES)
def test_every_dry_study_has_a_distribution(name):
    for output in CASES[name].outputs:
        found = stored(name, output)
        assert found.first.shape == (2, STARTS)
        assert found.later.shape == (2, STARTS, CASES[name].later)
        assert (found.first > 0.0).all()
        assert (found.later > 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "periods"), [("sixbar_jitter", 1), ("sevenbar_jitter", 2)])
def test_the_robust_objective_is_that_of_other_start_angles(name, periods):
    """Six angles between the stored ones, fewer periods: the change of the median has the sign of the interval, and half its size."""
    later = peaks(name, phases(6, 0.3), periods)[:, :, 1:, 0]
    change = 100.0 * (np.median(later[1]) / np.median(later[0]) - 1.0)
    assert change < 0.5 * stored(name).running.high < 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fourbar_jitter", "fivebar_jitter"])
def test_other_start_angles_lie_within_the_distribution(name):
    """Angles between the stored ones: the median change of six lies between the extremes of the 24, on any processor."""
    found, first = stored(name), peaks(name, phases(6, 0.3), 0)[:, :, 0, 0]
    changes = found.first[1] / found.first[0]
    assert changes.min() < np.median(first[1] / first[0]) < changes.max()


def test_counts_are_of_both_designs():
    """The recorded design has fewer contacts, and fewer large departures, from every start angle that was counted."""
    for before, after in counted("fourbar_jitter").values():
        assert after[1] <= after[0] <= after[2] < before[1]
    assert COUNTED >= 8
