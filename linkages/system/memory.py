"""Results that variants of a system share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

T = TypeVar("T")


class Memory:
    """The two latest results of each function and their arguments, shared by variants of a system."""

    def __init__(self) -> None:
        self._kept: dict[Any, list[tuple[tuple[Any, ...], Any]]] = {}

    def __call__(self, function: Callable[..., T], *arguments: Any) -> T:
        """Return the result of a function for arguments that can be compared, which decide it alone."""
        kept = self._kept.get(function, [])
        for known, found in kept:
            if known == arguments:
                return cast(T, found)
        result = function(*arguments)
        self._kept[function] = [*kept[-1:], (arguments, result)]
        return result
