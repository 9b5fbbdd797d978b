"""Rules on the validity of models in a run, and the warnings from their findings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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


#: Function of a rule.
Find = Callable[[Case], Violation | None]


class Rules(Generic[Case]):
    """Rules for cases of one kind, in the order of their warnings; `rule` adds one."""

    def __init__(self) -> None:
        self._rules: list[tuple[str, str, str, Find[Case]]] = []

    def rule(self, kind: str, what: str, remedy: str) -> Callable[[Find[Case]], Find[Case]]:
        """Add a function that returns a violation (None: valid), with kind and texts of its warning."""

        def add(find: Find[Case]) -> Find[Case]:
            self._rules.append((kind, what, remedy, find))
            return find

        return add

    def broken(self, cases: Sequence[tuple[str, Case]]) -> list[dict[str, Any]]:
        """Return a warning for each rule violated by the named cases."""
        result = []
        for kind, what, remedy, find in self._rules:
            found = [(name, violation) for name, case in cases if (violation := find(case)) is not None]
            if found:
                numbers = [
                    f"{value:.3g} in {name}{'' if time is None else f' at {time:.6g} s'} ({limit})"
                    for name, (value, time, limit) in found
                ]
                times = [violation.time for _, violation in found if violation.time is not None]
                result.append(warning(kind, min(times, default=None), f"{what}: {', '.join(numbers)}", remedy))
        return result
