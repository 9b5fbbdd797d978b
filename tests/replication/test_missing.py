"""The scan of the press paper's missing data: what a miss is, and that the page's guesses are what was found."""

import numpy as np
import pytest
from replication.measured import read
from replication.press_missing import ASKED, ASSUMED, MISSING, mismatch, outcome, overrides

from linkages import find_file, load


def test_a_miss_is_a_factor_and_signs_count():
    assert mismatch(ASKED) == 0.0
    assert np.exp(mismatch(2.0 * ASKED)) == pytest.approx(2.0)
    assert np.exp(mismatch(0.5 * ASKED)) == pytest.approx(2.0)
    for wrong in (-1.0, np.nan):
        one = np.where(np.arange(len(ASKED)) == 6, wrong * ASKED, ASKED)  # the nominal spike
        assert mismatch(one) == pytest.approx(np.log(10.0) / np.sqrt(len(ASKED)))


def test_cranks_have_turned_at_their_speeds_when_a_later_run_starts():
    system = load(find_file("seven_bar.toml"), overrides((2.0, -3.0, 0.5, 0.1, 1.0)))
    assert [system.value(f"drives.{name}.angle") for name in ("O1", "O4")] == [1.0, -1.5]
    assert system.value("joints.B.small_eccentricity.ratio") == 0.1


def test_scans_do_not_miss_by_more_than_what_they_start_from():
    """More freedom never misses by more, and each recorded guess misses by what is recorded."""
    scans = [*read("press_missing")["scans"].values()]
    missed = [mismatch(outcome(ASSUMED)), *(scan["mismatch"] for scan in scans)]
    assert missed == sorted(missed, reverse=True)
    for scan in scans:
        assert len(scan["guess"]) == len(MISSING)
        assert all(low <= value <= high for value, (low, high) in zip(scan["guess"], scan["bounds"], strict=False))
        assert mismatch(outcome(scan["guess"])) == pytest.approx(scan["mismatch"], rel=1e-3)
