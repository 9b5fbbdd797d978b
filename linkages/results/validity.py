"""Rules that say where a run leaves the range of a model, and how what they find becomes warnings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

from linkages.results.warnings import warning

Case = TypeVar("Case")


class Finding(NamedTuple):
    """A number outside its range, when [s] (None: always), and what it should be."""

    value: float
    time: float | None
    limit: str


class Rule(NamedTuple, Generic[Case]):
    """A rule: the kind of its warning, what is wrong, what to do, and how it is found (None: all is well)."""

    kind: str
    what: str
    remedy: str
    find: Callable[[Case], Finding | None]


def broken(rules: Iterable[Rule[Case]], cases: Sequence[tuple[str, Case]]) -> list[dict[str, Any]]:
    """Warn of rules that cases, each with its name, break: one entry for each rule."""
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
