"""The one rule of verdicts: its limits, and that what a claim says would change its verdict does."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from replication.verdicts import Claim, Number, Printed, Share, parts

MAGNITUDE = st.floats(1e-6, 1e6)


def claim(*numbers):
    return Claim("c", "p", "o", numbers, "w", "the data")


@pytest.mark.parametrize(
    ("printed", "ours", "word"),
    [
        (10.0, 10.4, "reproduced"),
        (10.0, 6.0, "trend only"),
        (10.0, 21.0, "not reproduced"),
        (10.0, -10.0, "not reproduced"),
        (-14.8, -14.5, "reproduced"),
        (-14.8, -18.9, "trend only"),
        (-77.5, -88.0, "trend only"),  # more than is printed is another number
        (-25.0, -0.01, "not reproduced"),  # a decrease is no trend
        (-25.0, 24.0, "not reproduced"),
    ],
)
def test_limits_of_numbers(printed, ours, word):
    assert claim(Number(printed, ours)).verdict == word


def test_equations_are_right_or_wrong():
    assert claim(Printed(-14.8, -14.79)).verdict == "right as printed"
    assert claim(Printed(0.15, 0.94)).verdict == claim(Printed(1.0, -1.0)).verdict == "wrong as printed"


def test_the_worst_number_decides():
    assert claim(Number(1.0, 1.0), Number(1.0, 1.5), Number(1.0, 1.01)).verdict == "trend only"
    assert claim(parts([True, True])).verdict == "reproduced"
    assert claim(parts([True, False, True])).verdict == "trend only"
    assert claim(parts([True, False, False])).verdict == "not reproduced"
    assert claim().verdict == "nothing to compare"
    assert claim().otherwise == "the data"
    assert claim()._replace(unless="").otherwise == "a number in the source"


def test_more_than_all_is_not_asked_for():
    told = claim(Share(100.0, 96.0, "%"))
    assert told.verdict == "reproduced"
    assert told.otherwise == "outside 95 to 100 %: trend only; outside 50 to 100 %: not reproduced; the data"


@given(MAGNITUDE, MAGNITUDE, st.sampled_from([-1.0, 1.0]), st.sampled_from([Number, Printed]))
def test_what_would_change_a_verdict_does(printed, ours, sign, kind):
    """A number from inside a range that `otherwise` names has its word; outside of it another one."""
    told = claim(kind(sign * printed, sign * ours, "N"))
    assert told.otherwise.endswith("; the data")
    clauses = told.otherwise.split("; ")[:-1]
    assert clauses
    for clause in clauses:
        outside, low, high, word = re.fullmatch(r"(outside )?(\S+) to (\S+) N: (.*)", clause).groups()
        middle, beyond = 0.5 * (float(low) + float(high)), float(high) + 0.01 * abs(float(high))
        assert word != told.verdict
        assert claim(kind(sign * printed, beyond if outside else middle)).verdict == word
