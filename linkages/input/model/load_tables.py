"""Tables of applied loads."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from linkages.input.files.formula import Formula
from linkages.input.files.toml import Finite, TwoOf, check_history
from linkages.input.model.functions import OF_JOINTS, OF_POINTS, TIME, check_table, formula
from linkages.input.model.recorded_tables import FromFile

Times = Annotated[list[Finite] | None, Field(description="times of a table, increasing [s]")]
Over = Annotated[
    str | None,
    Field(description="instead of times: argument of the table: POINT.x|y|angle|vx|vy|omega or JOINT.coordinate|rate"),
]
At = Annotated[list[Finite] | None, Field(description="values of `over` in a table, increasing")]


class LoadFunction(FromFile):
    """Common part of forces and torques: a constant, a table, a formula, or a signal from a file."""

    @property
    def formulas(self) -> list[Formula]:
        """Return the components as formulas of t, positions and speeds; empty without a formula."""
        given = getattr(self, "formula", None)
        return [formula(text) for text in ([given] if isinstance(given, str) else given or [])]

    @property
    def over_time(self) -> bool:
        """Check whether the load depends explicitly on time."""
        from_file = self.file is not None and getattr(self, "over", None) is None
        times = getattr(self, "times", None)
        return from_file or times is not None or any(TIME in found.names for found in self.formulas)

    @property
    def signals(self) -> list[str]:
        """Return the positions and speeds that the load depends on, such as ``slider.x``."""
        over = getattr(self, "over", None)
        return [over] if over is not None else sorted({n for f in self.formulas for n in f.names} - {TIME})

    def _check(self, one: str, many: str) -> None:
        """Check for exactly one of: constant, table over time, table over a signal, formula."""
        times, over, at, values = (getattr(self, key) for key in ("times", "over", "at", many))
        if sum(getattr(self, key) is not None for key in (one, many, "formula", "file")) != 1:
            raise ValueError(
                f"give either {one}, or times with {many}, or over and at with {many}, or formula, or file"
            )
        if self._check_columns() is not None:
            self._check_file(one, times, over)
            return
        if times is not None and over is not None:
            raise ValueError("give either times, or over and at")
        check_table(over, at, values, many)
        if over is None:
            check_history(times, values, many)
        for found in self.formulas:
            if any(name.rpartition(".")[0] == "world" for name in found.names):
                raise ValueError('a formula cannot use "world", which never moves')

    def _check_file(self, one: str, times: object, over: str | None) -> None:
        """Check the signal in a file, and fit it."""
        if times is not None or (over is None) != ("at" not in self.columns):
            raise ValueError("file needs time, or over and at: the position or speed, and its column; remove times")
        if self.periodic and (over is not None or self.period is None):
            raise ValueError("periodic needs period [s], and a signal over time")
        argument = ("time", "s") if over is None else ("at", (OF_POINTS | OF_JOINTS).get(over.rpartition(".")[2], ""))
        self._fit(one, argument)


class ForceTable(LoadFunction):
    """A force at a point of a link: constant, or a function of time, position or speed.

    Components are in plane axes, or in axes of the point's frame, which rotate with the link: x along the frame's x
    axis (whose angle is the column ``POINT.angle``), y a quarter turn counter-clockwise from it.
    """

    column_keys = ("force", "at")

    point: str = Field(description="point of application: origin of this link or frame")
    axes: Literal["plane", "body"] = Field(
        "plane", description="axes of the components: the plane's, or the point's, which turn with the link"
    )
    force: TwoOf[Finite] | None = Field(None, description="constant force [N]")
    times: Times = None
    over: Over = None
    at: At = None
    forces: list[TwoOf[Finite]] | None = Field(None, description="forces at `times` or `at`: monotone cubics [N]")
    formula: TwoOf[str] | None = Field(
        None, description="two components as formulas of t, positions and speeds, [N] in SI units"
    )

    def _complete(self) -> None:
        super()._complete()
        self._check("force", "forces")


class Torque(LoadFunction):
    """A torque on a link, positive counter-clockwise about the plane's normal, or in a joint, positive about its axis.

    Constant, or a function of time, position or speed. A joint torque acts on the child, reversed on the parent.
    """

    column_keys = ("torque", "at")

    link: str | None = Field(None, description="link on which it acts")
    joint: str | None = Field(None, description="or revolute joint in which it acts, along its coordinate")
    torque: Finite | None = Field(None, description="constant torque, counter-clockwise [N m]")
    times: Times = None
    over: Over = None
    at: At = None
    torques: list[Finite] | None = Field(None, description="torques at `times` or `at`: monotone cubics [N m]")
    formula: str | None = Field(None, description="torque: a formula of t, positions and speeds, [N m] in SI units")

    def _complete(self) -> None:
        super()._complete()
        if (self.link is None) == (self.joint is None):
            raise ValueError("give either link or joint")
        self._check("torque", "torques")
