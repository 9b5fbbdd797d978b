"""The answer of a figure in a line above it: the largest value, when it occurs, and what clearance changes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.results.assessment import Assessment
from linkages.results.extremes import peaks
from linkages.results.outputs.registry import unit
from linkages.show.plots.quantities import change, quantity, share

_INVISIBLE = 0.02  # difference over the range of the curve below which both curves look alike
_WHOLE = 0.5  # part of a run: a longer start-up is the motion itself


_LETTERS = 52, 60  # that fit above a figure of one column: of the answer, of the line below it
_WIDE_LETTERS = 70  # that fit above a panel of a wide figure


class Headline(NamedTuple):
    """What a panel of a curve says."""

    answer: str  # the largest value, and what clearance changes
    difference: str  # from ideal joints; empty without any
    alike: bool  # whether both curves look alike

    @property
    def is_long(self) -> bool:
        """Tell whether a wide figure has no room for the answer in one line."""
        return len(self.answer) > _WIDE_LETTERS

    @property
    def broken(self) -> tuple[str, str]:
        """Return the answer in two lines, if it is long."""
        head, _, told = self.answer.partition(", ")
        return (head, told) if self.is_long else (self.answer, "")

    @property
    def short(self) -> tuple[str, str]:
        """Return the answer and a second line with the difference, as a figure of one column has room for them."""
        head, _, told = self.answer.partition(", ")
        note = f"difference {self.difference}" if self.difference else ""
        if len(self.answer) <= _LETTERS[0] or not told:
            return self.answer, note
        return head, next((line for line in (f"{told}; {note}", told) if len(line) <= _LETTERS[1]), "")


def first_drawn(assessment: Assessment) -> float:
    """Return the time from which curves are drawn [s]: the end of the start-up, unless it is most of the run."""
    start, end = (float(time) for time in assessment.run.time[[0, -1]])
    if not assessment.system.play or assessment.system.settings.report == "whole":
        return start
    first = max(assessment.start_up or start, assessment.taken_up)
    return first if first - start < _WHOLE * (end - start) else start


def headline(assessment: Assessment, name: str, label: str, error: float = 0.0) -> Headline:
    """Answer what a column's largest value is, and how it differs from the ideal one.

    The numbers belong to the part of the run that tables are about; differences below the error are not told.
    """
    si, span, ideal = unit(assessment.system, name), assessment.reported_span, assessment.ideal
    run = assessment.run.within(*span)
    top = peaks(run, [name])[name]
    said = f"{label}: {quantity(top.value, si)} at {quantity(top.time, 's', 3)}"
    if ideal is None or name not in ideal.columns:
        return Headline(said, "", False)
    apart = assessment.difference
    begin, end = max(span[0], assessment.counted_from), min(span[1], float(apart.time[-1]))
    exact = ideal.within(*span) if ideal.time[-1] >= span[1] else ideal
    spread = float(np.ptp(run[name]))
    off = peaks(apart.within(begin, end), [name])[name].value if begin < end else 0.0  # as in tables
    told = change(top.value, peaks(exact, [name])[name].value) if name.endswith((".force", ".torque")) else ""
    if not told and off > error:
        told = f"off by up to {quantity(off, si, 3)}"
    part = f" ({share(off / spread)} of the range)" if spread > 0.0 and off > error else ""
    return Headline(
        f"{said}, {told}" if told else said,
        f"at most {quantity(off, si, 3)}{part}" if off > error else "below the error",
        off < _INVISIBLE * spread,
    )
