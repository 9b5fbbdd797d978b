"""Results that variants of a system share: `System.replaced` changes few of the values from which they follow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, TypeVarTuple

T = TypeVar("T")
Arguments = TypeVarTuple("Arguments")


class Memory:
    """The latest result of each function, and its arguments."""

    def __init__(self) -> None:
        self._kept: dict[Any, tuple[tuple[Any, ...], Any]] = {}

    def __call__(self, function: Callable[[*Arguments], T], *arguments: *Arguments) -> T:
        """Return the result of a function for arguments that can be compared, which decide it alone."""
        kept = self._kept.get(function)
        if kept is None or kept[0] != arguments:
            self._kept[function] = kept = arguments, function(*arguments)
        result: T = kept[1]
        return result
