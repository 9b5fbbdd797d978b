"""Claims of a source, and the one rule by which our numbers judge them.

A claim holds texts for readers, and the evidence from which its verdict follows; nobody writes a verdict. There are three kinds of
claims, each with its own words, from best to worst:

- *equation* (`Printed`): a formula or arithmetic of the source against the right one: *right as printed* within `WITHIN`, else *wrong as printed*;
- *number*: *reproduced* if ours is within `WITHIN` of the printed one. A value (`Number`) is else *within a factor of 2* or *not reproduced*. A
  change in per cent (`Change`) is else *trend only* if it has the printed direction and at least 1/`FACTOR` of the printed size. A chaotic
  quantity has no digits: of it we give an interval (`Interval`), which is *within the scatter* if it contains the printed number;
- *statement* (`Share`): the share of its parts, or of time, for which it is true: it *holds* from 1 - `WITHIN`, *holds in part* from 1/`FACTOR`.

The worst evidence of a claim decides. A claim without evidence has *nothing to compare*. A number or statement that fails may name a cause
(`because`): evidence of a computation that tests the cause makes the failure *explained*; an empty list says that the cause is *open*.

How to use it::

    def _forces() -> list[Claim]:
        found = extremes(run({}), ["A.force"])["A.force"].peak
        return [
            Claim(
                "largest F_A, nominal, fig. 10", "7.446 N", f"{found:.3f} N", [Number(7.446, found, "N")],
                "drive speeds missing; forces grow with their square", "the drives' speeds", because=[],
            )
        ]

    SECTIONS = {"forces": _forces}

- a value: ``Number(printed, ours, unit)``; a change in per cent: ``Change(printed, ours, "%")``;
- a dry run, whose digits depend on rounding: ``Interval(printed, low, high, "%")``, quantiles over start angles (`replication.dry`);
- a statement of several parts ("both below the nominal"): ``parts([a < n, b < n])``, the share of parts that are true;
  a statement about a span of time: ``Share(100.0, share, "% of the time")``;
- an equation, or arithmetic: ``Printed(as_printed, right, unit)``, at the place where they differ most;
- curves without numbers, lost tables, questions of ours: no evidence;
- numbers that are read from a file instead of computed: ``stored="python docs/make_x.py"``, the command that computes them.

A page shows the `brief` rows of its source, the appendix `LEGEND` and the causes (`replication.summary`); ``python docs/replicate.py SOURCE.SECTION`` prints all `rows`
of a section (a new source enters in `SOURCES`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import ClassVar, NamedTuple

import numpy as np

#: A number agrees within this part of the printed one.
WITHIN = 0.05
#: A value is near the printed one, and a change shows its trend, within this factor.
FACTOR = 2.0
#: What would change the verdict of a claim without evidence.
SAID = "a number in the source"
#: Module of each source's `SECTIONS`.
SOURCES = {
    "press": "replication.press_claims",
    "patent": "replication.patent_claims",
    "robot": "replication.robot_claims",
}

Sections = Mapping[str, Callable[[], "list[Claim]"]]


@dataclass(frozen=True)
class Number:
    """A printed number beside ours."""

    printed: float
    ours: float
    unit: str = ""

    kind: ClassVar[str] = "number"
    #: From best to worst.
    words: ClassVar[tuple[str, ...]] = ("reproduced", f"within a factor of {FACTOR:g}", "not reproduced")

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Ranges of our value for each of the words but the worst, from narrow to wide."""
        return [self._near, _sorted(self.printed / FACTOR, self.printed * FACTOR)]

    @property
    def grade(self) -> int:
        """Place among the words."""
        return next((n for n, (low, high) in enumerate(self.ranges) if low <= self.ours <= high), len(self.ranges))

    @property
    def otherwise(self) -> str:
        """Values of ours that would give another verdict."""
        inside = [f"{self._span(n)}: {self.words[n]}" for n in range(self.grade)]
        outside = [
            f"outside {self._span(n)}: {self.words[n + 1]}" for n in range(self.grade, len(self.ranges))
        ]  # fmt: skip
        return "; ".join(inside[::-1] + outside)

    @property
    def _near(self) -> tuple[float, float]:
        return _sorted(self.printed * (1.0 - WITHIN), self.printed * (1.0 + WITHIN))

    def _span(self, n: int) -> str:
        return _span(*self.ranges[n], self.unit)


class Fitted(Number):
    """A printed number that takes part in a fit of conditions that are not printed, beside ours."""

    words = ("met by a fit", *Number.words[1:])


class Change(Number):
    """A printed change beside ours: its trend is its direction, at not less than 1/`FACTOR` of its size."""

    words = ("reproduced", "trend only", "not reproduced")

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Ranges of our change for each of the words but the worst."""
        return [self._near, _sorted(self.printed / FACTOR, float(np.copysign(np.inf, self.printed)))]


class FittedChange(Change):
    """A printed change of numbers that take part in such a fit, beside ours."""

    words = ("met by a fit", *Change.words[1:])


class Printed(Number):
    """The result of a source's equation as printed, beside the right one."""

    kind = "equation"
    words = ("right as printed", "wrong as printed")

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Range of the right value for which the printed one is right."""
        return [self._near]


class Share(Number):
    """The share, in per cent, for which a statement is true: never more than the asserted 100 %."""

    kind = "statement"
    words = ("holds", "holds in part", "does not hold")

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Ranges of our share for each of the words but the worst."""
        return [(self.printed * part, self.printed) for part in (1.0 - WITHIN, 1.0 / FACTOR)]


@dataclass(frozen=True)
class Interval:
    """A printed change beside the interval of ours, where one run has no digits."""

    printed: float
    low: float
    high: float
    unit: str = ""

    kind: ClassVar[str] = Number.kind
    words: ClassVar[tuple[str, ...]] = ("within the scatter", "trend only", "not reproduced")

    @property
    def grade(self) -> int:
        """Place among the words."""
        if self.low <= self.printed <= self.high:
            return 0
        low, high = self._trend
        return 1 if low <= self.low and self.high <= high else 2

    @property
    def otherwise(self) -> str:
        """Intervals that would give another verdict."""
        low, high = self._trend
        others = (
            f"an interval that contains {self.printed:g} {self.unit}", f"one without it, but within {_span(low, high, self.unit)}",
            f"one that is not within {_span(low, high, self.unit)}",
        )  # fmt: skip
        return "; ".join(f"{what.rstrip()}: {self.words[n]}" for n, what in enumerate(others) if n != self.grade)

    @property
    def _trend(self) -> tuple[float, float]:
        return Change(self.printed, 0.0).ranges[1]


Evidence = Number | Interval


class Claim(NamedTuple):
    """One line of a page: the claim and its place, the printed and the computed value, and why they differ.

    `numbers` are the evidence of the verdict; `unless` says what in the source or in our assumptions would change it. `because` is
    evidence of a computation that tests a named cause of a failure: empty if no cause is known, None if the comparison itself says all.
    `stored` is the command that computes numbers which the page reads from a file. A `trial` is ours: it tests an explanation or a guess at
    missing data, and is no claim of the source; the summary leaves it out. `chosen` conditions were selected with the printed number in view.
    """

    claim: str
    printed: str
    ours: str
    numbers: Sequence[Evidence]
    why: str
    unless: str = ""
    because: Sequence[Evidence] | None = None
    stored: str = ""
    trial: bool = False
    chosen: bool = False

    @property
    def kind(self) -> str:
        """Kind of the evidence that decides: equation, number or statement; "-" without any."""
        return self._worst.kind if self.numbers else "-"

    @property
    def fitted(self) -> bool:
        """Whether the conditions are chosen or fitted for the number, so that it is no prediction."""
        return self.chosen or any(isinstance(number, Fitted | FittedChange) for number in self.numbers)

    @property
    def verdict(self) -> str:
        """The word of the worst evidence, and whether a failure is explained."""
        if not self.numbers:
            return "nothing to compare"
        word = self._worst.words[self._worst.grade]
        return word if self.because is None or not self.fails else f"{word}: {'open' if self.is_open else 'explained'}"

    @property
    def holds(self) -> bool:
        """Whether the best word applies."""
        return bool(self.numbers) and self._worst.grade == 0

    @property
    def fails(self) -> bool:
        """Whether the worst word applies."""
        return bool(self.numbers) and self._worst.grade == len(self._worst.words) - 1

    @property
    def is_open(self) -> bool:
        """Whether a failure has a cause that no computation confirms."""
        if self.because is None or not self.fails:
            return False
        return not self.because or any(number.grade for number in self.because)

    @property
    def otherwise(self) -> str:
        """What would change the verdict: another number of ours, and what could make it."""
        return "; ".join(filter(None, (self._worst.otherwise if self.numbers else "", self.unless))) or SAID

    @property
    def _worst(self) -> Evidence:
        return max(self.numbers, key=lambda number: (number.grade == len(number.words) - 1, number.grade))


#: The rule, for readers.
LEGEND = f"""One rule (`docs/replication/verdicts.py`) derives verdicts from the numbers of a row; the worst number decides. *Ours* means this package.

- An *equation*, or arithmetic, is *right as printed* if it agrees within {100 * WITHIN:.0f} % with the right one, otherwise *wrong as printed*.
- A *number* is *reproduced* if ours is within {100 * WITHIN:.0f} % of it; *met by a fit* if it also takes part in the choice or fit of conditions that
  are not printed. Otherwise a value is *within a factor of {FACTOR:g}* or *not reproduced*. A change in per cent is *trend only* if it has the printed direction
  and at least half of the printed size. For a chaotic run ours is an interval, and the printed number lies *within the scatter* or not.
- A *statement* *holds* if it is true for {100 * (1 - WITHIN):.0f} % or more of its parts or of the time; it *holds in part* from {100 / FACTOR:.0f} %; otherwise it *does not hold*.
- A failure is *explained* if a computation confirms a named cause, otherwise *open*. *Nothing to compare* means that the source prints no number.

The pages have printed and own numbers of the claims, this appendix the causes, and *missing* data that would change a verdict. A *trial* is no claim of the
source: it tests an explanation or an assumption about missing data. `python docs/replicate.py press.model` computes the section *press.model* again and
prints the ranges of each verdict. *Stored* numbers take minutes to hours: they are in `docs/replication/computed/` and `docs/replication/designs/`, and the section
names the command that computes them.
"""
#: Head of the pages' tables, and of the rows that the command prints.
BRIEF = ("claim", "printed", "ours", "verdict")
HEAD = ("claim", "kind", "printed", "ours", "verdict", "why", "what would change the verdict", "repeat with")


@cache
def section(source: str, name: str) -> tuple[Claim, ...]:
    """Compute the claims of a section."""
    sections: Sections = import_module(SOURCES[source]).SECTIONS
    return tuple(sections[name]())


def claims(source: str, names: Iterable[str] | None = None) -> list[tuple[str, Claim]]:
    """Compute a source's claims, each with its section: of all sections, or of some."""
    names = import_module(SOURCES[source]).SECTIONS if names is None else names
    return [(name, claim) for name in names for claim in section(source, name)]


def rows(source: str, names: Iterable[str] | None = None) -> list[tuple[str, ...]]:
    """Cells of a source's claims under `HEAD`: of all its sections, or of some."""
    return [
        (
            f"{c.claim} (trial)" if c.trial else c.claim, c.kind, c.printed, f"{c.ours} (stored)" if c.stored else c.ours, c.verdict, c.why, c.otherwise,
            f"`python docs/replicate.py {source}.{name}`" + (f"; stored; repeat with `{c.stored}`" if c.stored else ""),
        )
        for name, c in claims(source, names)
    ]  # fmt: skip


def brief(source: str) -> list[tuple[str, ...]]:
    """Cells of a source's claims that have a verdict under `BRIEF`, without trials."""
    found = [claim for _, claim in claims(source) if claim.numbers and not claim.trial]
    return [(claim.claim, claim.printed, claim.ours, claim.verdict) for claim in found]


def parts(held: Iterable[bool]) -> Share:
    """Judge a statement of several parts: the share of parts that are true."""
    truth = list(held)
    return Share(100.0, 100.0 * sum(truth) / len(truth), "% of its parts")


def _span(low: float, high: float, unit: str) -> str:
    """Write a range, which may have one end only."""
    if np.isinf(low) or np.isinf(high):
        return f"{high:.4g} {unit} or less" if np.isinf(low) else f"{low:.4g} {unit} or more"
    return f"{low:.4g} to {high:.4g} {unit}".rstrip()


def _sorted(a: float, b: float) -> tuple[float, float]:
    return min(a, b), max(a, b)
