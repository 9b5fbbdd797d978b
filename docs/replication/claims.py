"""Claims of a source beside our numbers: verdicts that follow from them, tables, the comparison of two pages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

REPRODUCED, TREND, NOT, MISPRINT = "reproduced", "trend only", "not reproducible", "wrong as printed"
#: A value agrees within this part of the printed one.
WITHIN = 0.05
_NUMBER = re.compile(r"(?<![\w.])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


class Claim(NamedTuple):
    """One line of the table: what is printed and where, what we compute, what follows, and why."""

    claim: str
    printed: str
    ours: str
    verdict: str
    why: str


def grade(reproduced: bool, trend: bool = False) -> str:
    """Return `REPRODUCED`, or else `TREND`, or else `NOT`."""
    return REPRODUCED if reproduced else TREND if trend else NOT


def verdict(printed: float, ours: float) -> str:
    """Compare a value with the printed one: `REPRODUCED` within `WITHIN`, `TREND` within a factor of two, or `NOT`."""
    return grade(_within(printed, ours), 0.5 <= ours / printed <= 2.0)


def verdict_of_change(printed: float, ours: float) -> str:
    """Compare changes in per cent: `REPRODUCED` within `WITHIN`, `TREND` with the sign and a tenth of it, or `NOT`."""
    return grade(_within(printed, ours), ours / printed >= 0.1)


def verdict_of_gain(printed: float, ours: float) -> str:
    """Compare what an optimisation lowers, in per cent: as `verdict_of_change`, but more than is printed serves too."""
    return REPRODUCED if ours <= printed else verdict_of_change(printed, ours)


def _within(printed: float, ours: float) -> bool:
    return abs(ours - printed) <= WITHIN * abs(printed)


def change(before: float, after: float) -> float:
    """Change in per cent."""
    return 100.0 * (after / before - 1.0)


def percent(value: float) -> str:
    """Write a change, or that there is none to speak of."""
    return f"less than {0.01:g} %" if abs(value) < 0.01 else f"{value:+.2f} %"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write cells as a Markdown table."""
    lines = [f"| {' | '.join(cells)} |\n" for cells in (head, *rows)]
    lines.insert(1, "|" + "---|" * len(head) + "\n")
    return "".join(lines)


def differences(old: str, new: str, digits: float = 2.0) -> list[str]:
    """Where two pages differ: words at all, numbers by more than some units of the last printed digit.

    Parameters
    ----------
    old, new : str
    digits : float
        Units of the coarser last digit: one for the rounding of each page.
    """
    old_words, new_words = (_NUMBER.sub("#", page) for page in (old, new))
    if old_words != new_words:
        lines = zip(old_words.splitlines(), new_words.splitlines(), strict=False)
        return [f"{a} -> {b}" for a, b in lines if a != b] or ["one page is longer"]
    pairs = zip(_NUMBER.findall(old), _NUMBER.findall(new), strict=True)
    near = digits + 1e-6
    return [f"{a} -> {b}" for a, b in pairs if abs(float(a) - float(b)) > near * max(_unit(a), _unit(b))]


def _unit(number: str) -> float:
    """One unit of the last digit of a printed number; exact for an integer."""
    mantissa, _, exponent = number.partition("e")
    places = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - places)) if places or exponent else 0.0
