"""Formulas are evaluated correctly, and nothing else is executed."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkages.input.files.formula import Formula, parse

NAMES = {"a": 1.25, "L_2": -0.5, "x": 3.0}

numbers = st.floats(0.01, 100.0).map(lambda x: (repr(x), x))
names = st.sampled_from(sorted(NAMES)).map(lambda name: (name, NAMES[name]))


def combined(inner):
    """A composed formula with its value."""
    pairs = st.tuples(inner, inner)
    return st.one_of(
        pairs.map(lambda p: (f"({p[0][0]} + {p[1][0]})", p[0][1] + p[1][1])),
        pairs.map(lambda p: (f"({p[0][0]}-{p[1][0]})", p[0][1] - p[1][1])),
        pairs.map(
            lambda p: (
                f"{p[0][0]} * ({p[1][0]})" if p[0][0][0] == "(" else f"(({p[0][0]}) * ({p[1][0]}))",
                p[0][1] * p[1][1],
            )
        ),
        pairs.map(lambda p: (f"(({p[0][0]}) / (2 + abs({p[1][0]})))", p[0][1] / (2.0 + abs(p[1][1])))),
        pairs.map(lambda p: (f"hypot({p[0][0]}, {p[1][0]})", math.hypot(p[0][1], p[1][1]))),
        pairs.map(lambda p: (f"max({p[0][0]}, {p[1][0]}, -1)", max(p[0][1], p[1][1], -1.0))),
        inner.map(lambda f: (f"-({f[0]})", -f[1])),
        inner.map(lambda f: (f"sin({f[0]})**2", math.sin(f[1]) ** 2)),
        inner.map(lambda f: (f"sqrt(abs({f[0]}))", math.sqrt(abs(f[1])))),
    ).map(lambda f: (f"({f[0]})", f[1]))


@given(st.recursive(st.one_of(numbers, names), combined, max_leaves=8))
def test_value(formula):
    text, value = formula
    if len(text) > 1000:
        return
    assert parse(text)(NAMES) == pytest.approx(value, rel=1e-12, abs=1e-12)


@given(st.text(max_size=60))
def test_any_text_is_a_formula_or_refused_with_a_value_error(text):
    try:
        found = parse(text)
    except ValueError:
        return
    assert isinstance(found, Formula)
    assert isinstance(found(dict.fromkeys(found.names, 1.0)), float)


def test_names():
    assert parse("rho * L_2**2 / 12 + pi").names == {"rho", "L_2"}
    assert parse("2 * pi")({}) == 2.0 * math.pi
    assert parse("-2**2")({}) == -4.0  # as in Python and in mathematics


@pytest.mark.parametrize(
    "text",
    [
        "1 / 0",
        "log(0)",
        "sqrt(-1)",
        "(-8)**(1/3)",
        "acos(2)",
        "9**9**9**9**9",
        "exp(1000)",
        "1e308 * 10",
        "0**-1",
        "1e400",
    ],
)
def test_no_value_is_nan(text):
    assert math.isnan(parse(text)({}))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("__import__('os').system('true')", "is not arithmetic"),
        ("a.real", "is not arithmetic"),
        ("(lambda: 1)()", "is not arithmetic"),
        ("[x for x in (1, 2)]", "is not arithmetic"),
        ("'text'", "is not arithmetic"),
        ("True", "is not arithmetic"),
        ("1 if a else 2", "is not arithmetic"),
        ("a < b", "is not arithmetic"),
        ("a // b", "is not arithmetic"),
        ("(a := 1)", "is not arithmetic"),
        ("2j", "is not arithmetic"),
        ("f'{a}'", "is not arithmetic"),
        ("max(a, *b)", "is not arithmetic"),
        ("max(a, b, key=c)", "is not arithmetic"),
        ("sqr(2)", 'no function "sqr"; did you mean "sqrt"'),
        ("open('x')", 'no function "open"'),
        ("sin(1, 2)", "sin takes 1 argument$"),
        ("max(1)", "max takes two or more arguments"),
        ("1 +", "is not a formula"),
        ("", "is not a formula"),
        ("a = 1", "is not a formula"),
        ("import os", "is not a formula"),
        ("1\n2", "is not a formula"),
        ("-" * 300 + "1", "nested too deeply"),
        ("(" * 300 + "1" + ")" * 300, "is not a formula"),
        ("1+" * 100_000 + "1", "longer than 200,000"),
        ("1+" * 20_000 + "1", "has too many terms"),
        ("1+" * 100 + "x y", r'"(1\+){40}..." is not a formula'),
        ("9" * 900, "too large"),
    ],
)
def test_refused(text, message):
    with pytest.raises(ValueError, match=message):
        parse(text)
