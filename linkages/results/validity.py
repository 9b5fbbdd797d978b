"""Rules on the validity of models in a run, and the warnings from their findings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

Case = TypeVar("Case")


def warning(kind: str, time: float | None, what: str, remedy: str) -> dict[str, Any]:
    """Make an entry of ``warnings`` in ``summary.json``; docs/outputs.md explains the kinds."""
    return {"kind": kind, "time": time, "what": what, "remedy": remedy}


class Violation(NamedTuple):
    """A number outside its limits, the time [s] (None: always), and the limits as text."""

    value: float
    time: float | None
    limit: str


class Rule(NamedTuple, Generic[Case]):
    """A rule: kind of the warning, problem, remedy, and the function that finds it (None: valid)."""

    kind: str
    what: str
    remedy: str
    find: Callable[[Case], Violation | None]


def broken(rules: Iterable[Rule[Case]], cases: Sequence[tuple[str, Case]]) -> list[dict[str, Any]]:
    """Return a warning for each rule violated by the named cases."""
    result = []
    for rule in rules:
        found = [(name, finding) for name, case in cases if (finding := rule.find(case)) is not None]
        if found:
            numbers = [
                f"{value:.3g} in {name}{'' if time is None else f' at {time:.6g} s'} ({limit})"
                for name, (value, time, limit) in found
            ]
            times = [finding.time for _, finding in found if finding.time is not None]
            result.append(
                warning(rule.kind, min(times, default=None), f"{rule.what}: {', '.join(numbers)}", rule.remedy)
            )
    return result
