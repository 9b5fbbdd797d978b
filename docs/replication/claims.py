"""Numbers and tables of the replication pages, and the comparison of two pages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

_NUMBER = re.compile(r"(?<![\w.])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


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
