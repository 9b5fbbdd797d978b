"""Quantities of an element: formulas of its numbers, of its signals, and of its other quantities."""

from __future__ import annotations

from collections.abc import Mapping

from linkages.input.files.formula import parse
from linkages.input.functions.definitions import Definition, Quantity


class OwnQuantities:
    """Collects the quantities of an element: formulas of its numbers, its signals, and its quantities ``own_NAME``."""

    def __init__(self, name: str, names: Mapping[str, float | str]) -> None:
        self.name, self.names = name, names
        self.found: dict[str, Quantity] = {}

    def _definition(self, text: str, **more: float | None) -> Definition:
        given = parse(text)
        own = {one: f"{self.name}.{one.removeprefix('own_')}" for one in given.names if one.startswith("own_")}
        added = {key: value for key, value in more.items() if value is not None}
        return Definition(given, {**self.names, **own, **added})

    def add(
        self, key: str, text: str, table: tuple[list[float], list[float]] | None = None, **more: float | None
    ) -> None:
        """Add a formula, or a table over its value."""
        self.found[f"{self.name}.{key}"] = Quantity(self._definition(text, **more)._replace(table=table))

    def state(self, key: str, text: str, start: float, period: float = 0.0) -> None:
        """Add a state with the formula of its rate, or of its next value."""
        self.found[f"{self.name}.{key}"] = Quantity(self._definition(text), True, start, 1.0, period)
