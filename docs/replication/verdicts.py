"""Claims of a source, and the one rule by which our numbers judge them.

A claim holds texts for readers, and the numbers from which its verdict follows; nobody writes a verdict. The rule, for every
number of every source: ours is *reproduced* within `WITHIN` of the printed one, *trend only* within a factor of `FACTOR`, else *not
reproduced*. What a source asserts of itself or of mechanics (an equation, a percentage of its own numbers) is judged alike, printed
against right: *right as printed* within `WITHIN`, else *wrong as printed*. The worst number of a claim decides. A claim without
numbers has *nothing to compare*. From the same limits follows what would change the verdict.

How to use it::

    def _forces() -> list[Claim]:
        found = extremes(run({}), ["A.force"])["A.force"].peak
        return [
            Claim(
                "largest F_A, nominal, fig. 10", "7.446 N", f"{found:.3f} N", [Number(7.446, found, "N")],
                "drive speeds missing; forces grow with their square", "the drives' speeds",
            )
        ]

    SECTIONS = {"forces": _forces}

- a value, or a change in per cent: ``Number(printed, ours, unit)``; what an optimisation lowers is a change like any other;
- a statement of several parts ("both below the nominal"): ``parts([a < n, b < n])``, the share of parts that hold, of 100 %;
  what is said of a span of time: ``Share(100.0, share, "% of the time")``;
- an equation, or arithmetic: ``Printed(as_printed, right, unit)``, at the place where they differ most;
- curves without numbers, lost tables, questions of ours: no numbers.

A page says `LEGEND` and shows the `rows` of its source; ``python docs/replicate.py SOURCE.SECTION``, which each row names, repeats a section
(a new source enters in `SOURCES`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from typing import NamedTuple

#: A number agrees within this part of the printed one.
WITHIN = 0.05
#: A number shows the trend within this factor of the printed one.
FACTOR = 2.0
#: What would change the verdict of a claim without numbers.
SAID = "a number in the source"
#: Module of each source's `SECTIONS`.
SOURCES = {"press": "replication.press_claims", "patent": "replication.patent_claims", "robot": "replication.three_rrr"}

Sections = Mapping[str, Callable[[], "list[Claim]"]]


class Number(NamedTuple):
    """A printed number beside ours."""

    printed: float
    ours: float
    unit: str = ""

    #: From best to worst.
    words = ("reproduced", "trend only", "not reproduced")

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Where ours must lie for each of the words but the worst, from narrow to wide."""
        near, far = (1.0 - WITHIN, 1.0 + WITHIN), (1.0 / FACTOR, FACTOR)
        return [_sorted(self.printed * low, self.printed * high) for low, high in (near, far)]

    @property
    def grade(self) -> int:
        """Place among the words."""
        return next((n for n, (low, high) in enumerate(self.ranges) if low <= self.ours <= high), len(self.ranges))

    @property
    def otherwise(self) -> str:
        """What of ours would give another verdict."""
        inside = [f"{self._span(n)}: {self.words[n]}" for n in range(self.grade)]
        outside = [
            f"outside {self._span(n)}: {self.words[n + 1]}" for n in range(self.grade, len(self.ranges))
        ]  # fmt: skip
        return "; ".join(inside[::-1] + outside)

    def _span(self, n: int) -> str:
        low, high = self.ranges[n]
        return f"{low:.4g} to {high:.4g} {self.unit}".rstrip()


class Fitted(Number):
    """A printed number that has its part in a fit of what is not printed, beside ours."""

    words = ("met by a fit", "trend only", "not reproduced")


class Printed(Number):
    """What a source's equation gives as printed, beside what is right."""

    words = ("right as printed", "wrong as printed")

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Where the right value must lie for the printed one to be right."""
        return super().ranges[:1]


class Share(Number):
    """How much holds of what is said to hold, in per cent: never more than the printed 100 %."""

    @property
    def ranges(self) -> list[tuple[float, float]]:
        """Where ours must lie for each of the words but the worst."""
        return [(low, self.printed) for low, _ in super().ranges]


class Claim(NamedTuple):
    """One line of a page: what is claimed and where, what is printed, what we compute, and why they differ.

    `numbers` are what the verdict follows from; `unless` says what in the source or in our assumptions would change it. `because` are
    numbers of a computation that tests a named cause, empty if none is known: a claim that is not reproduced is then explained, if all
    of these agree, or open.
    """

    claim: str
    printed: str
    ours: str
    numbers: Sequence[Number]
    why: str
    unless: str = ""
    because: Sequence[Number] | None = None

    @property
    def verdict(self) -> str:
        """The word of the worst number, and whether a miss is explained."""
        if not self.numbers:
            return "nothing to compare"
        word = self._worst.words[self._worst.grade]
        if word != "not reproduced" or self.because is None:
            return word
        explained = bool(self.because) and all(number.grade == 0 for number in self.because)
        return f"{word}: {'explained' if explained else 'open'}"

    @property
    def otherwise(self) -> str:
        """What would change the verdict: another number of ours, and what could make it."""
        return "; ".join(filter(None, (self._worst.otherwise if self.numbers else "", self.unless))) or SAID

    @property
    def _worst(self) -> Number:
        return max(self.numbers, key=lambda number: number.grade)


#: The rule, for readers.
LEGEND = f"""All numbers are computed when the page is written; verdicts follow from them by one rule (`docs/replication/verdicts.py`), and the
worst number of a row decides:

- *reproduced*: ours is within {100 * WITHIN:.0f} % of the printed number; *trend only*: within a factor of {FACTOR:g}, and of the same sign; *not
  reproduced*: neither; *explained* if a computation confirms a named cause, else *open*;
- *met by a fit*: within {100 * WITHIN:.0f} %, but the number has its part in a fit of conditions that are not printed;
- *right as printed*, *wrong as printed*: an equation, or arithmetic, agrees within {100 * WITHIN:.0f} % with what is right, or does not;
- *nothing to compare*: no number is printed.
"""
#: Head of the pages' tables.
HEAD = ("claim", "printed", "ours", "verdict", "why", "what would change the verdict", "repeat with")


def rows(source: str, names: Iterable[str] | None = None) -> list[tuple[str, ...]]:
    """Cells of a source's claims under `HEAD`: of all its sections, or of some."""
    sections: Sections = import_module(SOURCES[source]).SECTIONS
    return [
        (c.claim, c.printed, c.ours, c.verdict, c.why, c.otherwise, f"`python docs/replicate.py {source}.{name}`")
        for name in (sections if names is None else names)
        for c in sections[name]()
    ]


def parts(held: Iterable[bool]) -> Share:
    """How much of a statement holds: its parts that do, of 100 %."""
    truth = list(held)
    return Share(100.0, 100.0 * sum(truth) / len(truth), "% of its parts")


def _sorted(a: float, b: float) -> tuple[float, float]:
    return min(a, b), max(a, b)
