"""The part that forces and torques share: a constant, a table, a formula, or a signal from a file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from linkages.elements.element import Checks
from linkages.input.files.formula import Formula
from linkages.input.files.toml import Finite, check_history
from linkages.input.functions.definitions import (
    OF_JOINTS,
    OF_POINTS,
    TIME,
    Curve,
    Definition,
    Function,
    check_table,
    formula,
)
from linkages.input.functions.recorded_tables import FromFile
from linkages.mechanics.planar.motion import monotone_table

Times = Annotated[list[Finite] | None, Field(description="times of a table, increasing [s]")]
Over = Annotated[
    str | None,
    Field(description="instead of times: argument of the table: POINT.x|y|angle|vx|vy|omega or JOINT.coordinate|rate"),
]
At = Annotated[list[Finite] | None, Field(description="values of `over` in a table, increasing")]


class LoadFunction(FromFile):
    """Common part of forces and torques: a constant, a table, a formula, or a signal from a file."""

    if TYPE_CHECKING:  # the tables declare them, in the order of their documentation
        times: Times
        over: Over
        at: At

    @property
    def formulas(self) -> list[Formula]:
        """Return the components as formulas of t, positions and speeds; empty without a formula."""
        given = getattr(self, "formula", None)
        return [formula(text) for text in ([given] if isinstance(given, str) else given or [])]

    def components(
        self, constant: Sequence[float] | None, values: Sequence[Sequence[float]] | None
    ) -> Sequence[Function]:
        """Return the components, of which the constants or the values at `times` or `at` are given."""
        if constant is not None:
            return [float(one) for one in constant]
        places = self.times or self.at
        if values is not None and places is not None:
            return [Curve(monotone_table(places, part), self.over or TIME) for part in zip(*values, strict=True)]
        if self.formulas:
            return [Definition(text) for text in self.formulas]
        return [Curve(fit.function, self.over or TIME) for fit in self.fitted]

    def check_inputs(self, checks: Checks) -> None:
        """Check the times, the positions and speeds that the function reads, and the unit of a table over one."""
        checks.covers(self.times, self.fitted if self.over is None else ())
        key = "formula" if self.formulas else "over"
        read = {name: one.text for one in self.formulas for name in sorted(one.names)}
        for name, text in ({self.over: self.over} if self.over is not None else read).items():
            checks.unit("at", checks.signal(key, name, text))

    def _check(self, one: str, many: str) -> None:
        """Check for exactly one of: constant, table over time, table over a signal, formula."""
        times, over, at, values = self.times, self.over, self.at, getattr(self, many)
        if sum(getattr(self, key) is not None for key in (one, many, "formula", "file")) != 1:
            raise ValueError(
                f"give either {one}, or times with {many}, or over and at with {many}, or formula, or file"
            )
        if self._check_columns() is not None:
            self._check_file(one)
            return
        if times is not None and over is not None:
            raise ValueError("give either times, or over and at")
        check_table(over, at, values, many)
        if over is None:
            check_history(times, values, many)
        for found in self.formulas:
            if any(name.rpartition(".")[0] == "world" for name in found.names):
                raise ValueError('a formula cannot use "world", which never moves')

    def _check_file(self, one: str) -> None:
        """Check the signal in a file, and fit it."""
        over = self.over
        if self.times is not None or (over is None) != ("at" not in self.columns):
            raise ValueError("file needs time, or over and at: the position or speed, and its column; remove times")
        if self.periodic and (over is not None or self.period is None):
            raise ValueError("periodic needs period [s], and a signal over time")
        argument = ("time", "s") if over is None else ("at", (OF_POINTS | OF_JOINTS).get(over.rpartition(".")[2], ""))
        self._fit(one, argument)
