"""The one rule of verdicts: its limits, its three kinds, and the stated change of a claim changes its verdict."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from replication.verdicts import Change, Claim, Fitted, Interval, Number, Printed, Share, parts

MAGNITUDE = st.floats(1e-6, 1e6)


def claim(*numbers, because=None):
    return Claim("c", "p", "o", numbers, "w", "the data", because)


@pytest.mark.parametrize(
    ("printed", "ours", "word"),
    [(10.0, 10.4, "reproduced"), (10.0, 6.0, "within a factor of 2"), (10.0, 21.0, "not reproduced"), (10.0, -10.0, "not reproduced")],
)  # fmt: skip
def test_limits_of_values(printed, ours, word):
    assert claim(Number(printed, ours)).verdict == word
    assert claim(Fitted(printed, ours)).verdict == word.replace("reproduced", "met by a fit", word == "reproduced")


@pytest.mark.parametrize(
    ("printed", "ours", "word"),
    [
        (-14.8, -14.5, "reproduced"),
        (-14.8, -18.9, "trend only"),
        (-25.0, -80.0, "trend only"),  # the trend is there, the number is another
        (-25.0, -12.0, "not reproduced"),
        (-25.0, -0.01, "not reproduced"),  # a decrease alone is no trend
        (-25.0, 24.0, "not reproduced"),
        (0.9, 1.9, "trend only"),
    ],
)
def test_a_trend_has_the_direction_and_half_the_size(printed, ours, word):
    assert claim(Change(printed, ours)).verdict == word


@pytest.mark.parametrize(
    ("low", "high", "word"),
    [
        (-88.0, -73.0, "within the scatter"),
        (-70.0, -60.0, "trend only"),
        (-99.0, -80.0, "trend only"),
        (-70.0, -10.0, "not reproduced"),  # a part of the scatter has no trend
        (-30.0, -20.0, "not reproduced"),
        (-75.0, 5.0, "not reproduced"),
    ],
)
def test_an_interval_is_judged_as_a_whole(low, high, word):
    told = claim(Interval(-77.5, low, high, "%"))
    assert told.verdict == word
    assert word not in told.otherwise


def test_equations_are_right_or_wrong():
    assert claim(Printed(-14.8, -14.79)).verdict == "right as printed"
    assert claim(Printed(0.15, 0.94)).verdict == claim(Printed(1.0, -1.0)).verdict == "wrong as printed"


def test_statements_have_words_of_their_own():
    """Half of a statement is no trend of a number."""
    assert claim(parts([True, True])).verdict == "holds"
    assert claim(parts([True, False, True])).verdict == "holds in part"
    assert claim(parts([True, False, False])).verdict == "does not hold"
    kinds = [claim(number).kind for number in (Printed(1.0, 1.0), Number(1.0, 1.0), Interval(1, 0, 2), parts([True]))]
    assert kinds == ["equation", "number", "number", "statement"]
    assert claim().kind == "-"


def test_the_worst_number_decides():
    assert claim(Number(1.0, 1.0), Number(1.0, 1.5), Number(1.0, 1.01)).verdict == "within a factor of 2"
    assert claim(Number(1.0, 1.0), parts([False])).verdict == "does not hold"
    assert claim(Number(1.0, 1.5), Printed(1.0, -1.0)).verdict == "wrong as printed"
    assert claim().verdict == "nothing to compare"
    assert claim().otherwise == "the data"
    assert claim()._replace(unless="").otherwise == "a number in the source"


def test_a_failure_is_explained_by_a_computation_or_open():
    miss, met = Number(1.0, 9.0), Number(1.0, 1.0)
    assert claim(miss).verdict == "not reproduced"
    assert claim(miss, because=[]).verdict == claim(miss, because=[met, miss]).verdict == "not reproduced: open"
    assert claim(miss, because=[met]).verdict == "not reproduced: explained"
    assert claim(parts([False]), because=[met]).verdict == "does not hold: explained"
    assert claim(met, because=[]).verdict == "reproduced"
    assert claim(Number(1.0, 1.5), because=[]).verdict == "within a factor of 2"


def test_more_than_all_is_not_asked_for():
    told = claim(Share(100.0, 96.0, "%"))
    assert told.verdict == "holds"
    assert told.otherwise == "outside 95 to 100 %: holds in part; outside 50 to 100 %: does not hold; the data"


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
