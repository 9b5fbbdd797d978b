"""Distributions of the objectives of studies with dry joints.

A dry run is chaotic: its largest acceleration depends on the start angle, and after some revolutions on every rounding. One run
has no three digits. ``python docs/make_dry.py`` runs the nominal and the recorded design of each study from `STARTS` start angles
and keeps the largest magnitude of each output in the first revolutions (*start*) and in each later period (*running*).

Intervals on the pages follow from these by one rule: the 5 % and 95 % quantiles,

- `Dry.start`: of the change from the nominal to the recorded design, over the start angles;
- `Dry.running`: of the change of the median over start angles and periods, over `RESAMPLED` choices of start angles
  (bootstrap). This median is the robust objective: it hardly depends on rounding, see `tests/replication/test_dry.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from linkages import simulate_batch
from replication.claims import change
from replication.computed import read
from replication.patent_designs import Array, Pair, pair, period, start_angles
from replication.verdicts import Interval

#: Name of the file of computed distributions, and the command that writes it.
FILE, COMMAND = "dry", "python docs/make_dry.py"


class Case(NamedTuple):
    """Kept results of a study: outputs, the objective's first; length of the start, and number of later periods [periods]."""

    outputs: tuple[str, ...]
    start: float = 1.0
    later: int = 10


_FOURBAR = Case(("follower.alpha.jitter", "follower_B.acceleration", "B.force"), start=2.1)  # [0084]: 0.21 s
CASES = {
    "fourbar_jitter": _FOURBAR,
    "fourbar_kept": _FOURBAR,
    "fivebar_jitter": Case(("coupler2.alpha.jitter", "C.force")),
    "sixbar_jitter": Case(("output.alpha.jitter", "C.force")),
    "sevenbar_jitter": Case(("slider7.ax.jitter", "A.force", "B.force"), later=4),
}
#: Start angles of the distributions, and of the counts, which take single runs.
STARTS, COUNTED = 24, 8
RESAMPLED, QUANTILES = 2000, (0.05, 0.95)


class Range(NamedTuple):
    """Middle and ends of an interval [%]."""

    middle: float
    low: float
    high: float

    def judged(self, printed: float) -> Interval:
        """Put the interval beside a printed number."""
        return Interval(printed, self.low, self.high, "%")

    def __str__(self) -> str:
        return f"{self.middle:+.0f} % ({self.low:+.0f} to {self.high:+.0f} %)"


@dataclass(frozen=True)
class Dry:
    """Computed distribution of one output of a study.

    Attributes
    ----------
    first : (2, n) array
        Largest magnitude in the first revolutions, nominal and recorded design, by start angle.
    later : (2, n, p) array
        The same in each later period.
    """

    first: Array
    later: Array

    @property
    def start(self) -> Range:
        """Change in the first revolutions over the start angles [%]."""
        changes = 100.0 * (self.first[1] / self.first[0] - 1.0)
        return Range(float(np.median(changes)), *map(float, np.quantile(changes, QUANTILES)))

    @property
    def running(self) -> Range:
        """Change of the median over start angles and later periods [%]."""
        n = self.later.shape[1]
        chosen = np.random.default_rng(1).integers(0, n, (RESAMPLED, n))
        before, after = (np.median(part[chosen].reshape(RESAMPLED, -1), axis=1) for part in self.later)
        middle = change(*(float(np.median(part)) for part in self.later))
        return Range(middle, *map(float, np.quantile(100.0 * (after / before - 1.0), QUANTILES)))


def stored(name: str, output: str | None = None) -> Dry:
    """Read the distribution of a study's output, by default its objective's."""
    found = read(FILE)[name][output or CASES[name].outputs[0]]
    return Dry(np.array(found["start"]), np.array(found["running"]))


def phases(count: int = STARTS, shift: float = 0.0) -> Array:
    """Start angles as parts of the drives' common period, (count,)."""
    return (np.arange(count) + shift) / count


def peaks(name: str, parts: Array, periods: int | None = None) -> Array:
    """Run both designs of a study from several start angles.

    Parameters
    ----------
    name : str
        Of a shipped study.
    parts : (n,) array
        Start angles as parts of the drives' common period.
    periods : int, optional
        Periods after the start; default all.

    Returns
    -------
    (2, n, 1 + periods, outputs) array
        Largest magnitudes of the case's outputs at the start and in each later period.
    """
    systems, case = pair(name).systems, CASES[name]
    length = period(systems[0])
    count = case.later if periods is None else periods
    ends = length * (case.start + np.arange(count + 1))
    windows = np.column_stack([np.append(0.0, ends[:-1]), ends])
    values = [start_angles(systems[0], part) for part in parts]
    found = []
    for system in systems:
        longer = system.replaced({"duration": float(ends[-1])})
        found.append(
            simulate_batch(longer, list(values[0]), [[*row.values()] for row in values], case.outputs, windows).peak
        )
    return np.array(found)


def counts(name: str, parts: Array) -> dict[str, list[list[int]]]:
    """Count contacts, and how often the departure rises above half of the nominal run's largest, nominal and recorded design, by start angle."""
    pairs = [Pair(name, float(part)) for part in parts]
    output = CASES[name].outputs[0].removesuffix(".jitter")
    found = {
        "contacts": [[len(listed) for listed in one.impacts] for one in pairs],
        "above": [one.times_above_half(output) for one in pairs],
    }
    return {key: [list(column) for column in zip(*rows, strict=True)] for key, rows in found.items()}


def counted(name: str) -> dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Read the counts: median, 5 % and 95 % quantile of the nominal and of the recorded design."""
    return {
        key: tuple(tuple(map(float, np.quantile(row, (0.5, *QUANTILES)))) for row in rows)
        for key, rows in read(FILE)[f"{name}/counts"].items()
    }  # type: ignore[return-value]
