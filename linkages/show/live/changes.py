"""Changed values of a page that change nothing in a run: they are refused as long as they are requested."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from linkages.base.errors import ARGUMENT, InputError
from linkages.engines.compiled.effects import without_effect
from linkages.system import System


class Changes:
    """The changes from one request of a page to the next, for a system with the values of its file.

    Numbers that act are not compared again until a model or law changes, which is allowed to make others idle. Numbers
    that the file lacks count if they are changed alone: an edit proposes several, of which a law may need some only.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._asked: dict[str, Any] = {}  # values of the last request
        self._acting: set[str] = set()  # paths of numbers that are known to change a run
        self._idle: set[str] = set()  # of those that were refused, or not compared yet

    def check(self, values: Mapping[str, Any], changed: System) -> None:
        """Refuse a number of a request that is changed and changes nothing, `changed` being the system with all values.

        InputError with the path that acts instead.
        """
        before, self._asked = self._asked, dict(values)
        new = {path for path in values if values[path] != before.get(path)}
        if self._choices(values) != self._choices(before):
            self._acting, new = set(), set()
        asked = {path for path in new if len(new) == 1 or self._has(path)} | (self._idle & values.keys())
        self._idle = set()
        for path in sorted(asked - self._acting):
            kept = {path: before[path]} if new == {path} and path in before else {}
            others = {other: value for other, value in values.items() if other != path} | kept
            try:
                problem = without_effect(changed, self._system.replaced(others), path)
            except InputError:  # the others need this value
                continue
            if problem:
                self._idle = asked
                raise InputError(ARGUMENT, path, problem)
            self._acting.add(path)

    def _choices(self, values: Mapping[str, Any]) -> dict[str, str]:
        """Return the values that are models and laws; a text can be a number with its unit too."""
        return {path: value for path, value in values.items() if isinstance(value, str) and not self._has(path)}

    def _has(self, path: str) -> bool:
        """Check whether the file has a number at a path."""
        with suppress(InputError):
            return math.isfinite(self._system.value(path))
        return False
