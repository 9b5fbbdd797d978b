"""The page of runs that were pinned on the live page: their values, peaks and commands, for print."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from linkages.base.errors import InputError
from linkages.input.files.versions import versions
from linkages.results.outputs.registry import unit
from linkages.show.live.controls import Control
from linkages.show.live.exploring import is_number
from linkages.show.live.units import unit_of
from linkages.show.naming import output_in_words, value_in_words
from linkages.show.plots.drawing.drawing import draw
from linkages.show.plots.drawing.svg import svg
from linkages.show.plots.quantities import number
from linkages.show.report.page import report_page
from linkages.show.report.page_tables import PageTable
from linkages.show.report.words import toml_value
from linkages.system import System

_MOST = 10  # runs of a page
_DIGITS = 5  # of numbers: runs may differ by little


@dataclass(frozen=True)
class Pinned:
    """A run of the page."""

    name: str
    values: Mapping[str, float | str]
    peaks: Mapping[str, float | None]  # by output


def pinned_page(system: System, runs: Sequence[Pinned], known: Mapping[str, Control], notes: str, units: str) -> str:
    """Return a page that loads nothing; curves go where it has the comment ``curves``. InputError for unknown outputs.

    `system` has the values of the last run, whose machine is drawn, and `known` the values that can be changed.
    """
    paths = [*dict.fromkeys(path for run in runs for path in run.values)]
    outputs = [*dict.fromkeys(name for run in runs for name in run.peaks)]
    heads = tuple(run.name for run in runs)
    changed = [
        (f"{value_in_words(path)} ({path})", *(_value(run, path, known, units) for run in runs)) for path in paths
    ]
    peaks = [(output_in_words(name), *(_peak(system, run, name, units) for run in runs)) for name in outputs]
    file = system.description.source.name
    return report_page(
        title=system.description.heading,
        question="What do the runs that were pinned on the live page differ in, and what changes with it?",
        sentences=[line for line in notes.split("\n") if line.strip()],
        picture=svg(draw(system), said=False),
        tables=[
            PageTable("Changed values", ("value", *heads), changed),
            PageTable("Peaks", ("peak of", *heads), peaks),
        ],
        commands=[f"{_command(file, run)}  # {run.name}" for run in runs],
        versions=[("The versions of the packages:", "\n".join(" ".join(one) for one in versions().items()))],
    )


def checked_runs(given: Any, values_of: Any) -> list[Pinned]:
    """Check runs from outside; `values_of` checks the values of one. InputError for others."""
    if not isinstance(given, list) or not 0 < len(given) <= _MOST or not all(isinstance(one, dict) for one in given):
        raise InputError("page", "runs", f"must be a list of 1 to {_MOST} runs")
    found = []
    for one in given:
        peaks = one.get("peaks")
        if not isinstance(peaks, dict) or not all(one is None or is_number(one) for one in peaks.values()):
            raise InputError("page", "runs", "must have numbers as peaks, by output")
        found.append(Pinned(str(one.get("name", ""))[:40], values_of(one), peaks))
    return found


def _value(run: Pinned, path: str, known: Mapping[str, Control], units: str) -> str:
    control = known.get(path)
    value = run.values.get(path, control.value if control else None)
    shown, factor = unit_of(control.unit if control else "", units)
    return f"{number(factor * value, _DIGITS)} {shown}".strip() if isinstance(value, int | float) else value or "-"


def _peak(system: System, run: Pinned, name: str, units: str) -> str:
    value = run.peaks.get(name)
    shown, factor = unit_of(unit(system, name), units)
    return "-" if value is None else f"{number(factor * value, _DIGITS)} {shown}".strip()


def _command(file: str, run: Pinned) -> str:
    settings = [word for path, value in run.values.items() for word in ("--set", f"{path}={toml_value(value)}")]
    return shlex.join(["linkages", "simulate", file, *settings])
