"""Rules on the validity of models in a run, and the warnings from what breaks them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from linkages.base.arrays import Array

Case = TypeVar("Case")


class Warned(NamedTuple):
    """A warning about a run: its kind, what is wrong, the remedy, since when [s], and values that heed it, by path."""

    kind: str
    what: str
    remedy: str
    time: float | None = None
    changes: Mapping[str, Any] = MappingProxyType({})


class Columns(Protocol):
    """A run: its times, and its columns by name."""

    @property
    def time(self) -> Array:
        """Return the times (nt,) [s]."""

    def __getitem__(self, name: str) -> Array:
        """Return a column (nt,)."""


class Blow(Protocol):
    """A time in contact."""

    @property
    def start(self) -> float:
        """Return its start [s]."""

    @property
    def duration(self) -> float:
        """Return its duration [s]."""


class Observed(NamedTuple):
    """A link with a model that deforms it, in one run."""

    name: str
    bodies: Sequence[Any]  # its deformable bodies, such as `linkages.elements.flexible.substructure.Substructure`
    run: Columns
    impacts: Sequence[Blow]  # of the contacts on it
    rates: Sequence[Array]  # of the drives of revolute joints, (nt,) [rad/s]


class Violation(NamedTuple):
    """A number outside its limits, the time [s] (None: always), and the limits as text."""

    value: float
    time: float | None
    limit: str


#: Function of a rule.
Find = Callable[[Case], Violation | None]
#: Function that returns values by dotted path which heed the warning of a rule.
Heed = Callable[[Case], dict[str, Any]]


class Rules(Generic[Case]):
    """Rules for cases of one kind, in the order of their warnings; `rule` adds one."""

    def __init__(self) -> None:
        self._rules: list[tuple[str, str, str, Heed[Case] | None, Find[Case]]] = []

    def rule(
        self, kind: str, what: str, remedy: str, heed: Heed[Case] | None = None
    ) -> Callable[[Find[Case]], Find[Case]]:
        """Add a function that returns a violation (None: valid), with kind, texts and changes of its warning."""

        def add(find: Find[Case]) -> Find[Case]:
            self._rules.append((kind, what, remedy, heed, find))
            return find

        return add

    def broken(self, cases: Sequence[tuple[str, Case]]) -> list[Warned]:
        """Return a warning for each rule violated by the named cases."""
        result = []
        for kind, what, remedy, heed, find in self._rules:
            broken = [(name, case, violation) for name, case in cases if (violation := find(case)) is not None]
            found = [(name, violation) for name, _, violation in broken]
            if found:
                numbers = [
                    f"{value:.3g} in {name}{'' if time is None else f' at {time:.6g} s'} ({limit})"
                    for name, (value, time, limit) in found
                ]
                times = [violation.time for _, violation in found if violation.time is not None]
                said = f"{what}: {', '.join(numbers)}"
                changes = {path: new for _, case, _ in broken if heed for path, new in heed(case).items()}
                result.append(Warned(kind, said, remedy, min(times, default=None), changes))
        return result
