"""The tables of an experiment's applied loads: forces, torques, springs, torsion springs."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from linkages.files.toml import Finite, NonNegative, Table, check_history
from linkages.planar import motion
from linkages.planar.motion import Pieces

Pair = Annotated[list[Finite], Field(min_length=2, max_length=2)]


class Force(Table):
    """A force at a point of a link, constant or over time.

    In plane axes, or in those of the point's own frame, which turn with the link: x along its x axis (whose angle is
    the column ``POINT.angle``), y a quarter turn counter-clockwise from it.
    """

    point: str = Field(description="where it acts: origin of this link or frame")
    axes: Literal["plane", "body"] = Field(
        "plane", description="axes of its components: the plane's, or the point's own, turning with the link"
    )
    force: Pair | None = Field(None, description="constant force [N]")
    times: list[Finite] | None = Field(None, description="times of a table, increasing [s]")
    forces: list[Pair] | None = Field(None, description="forces at `times`; between them monotone cubics [N]")

    @model_validator(mode="after")
    def _one_kind(self) -> Force:
        _check_values("force", "forces", self.force, self.times, self.forces)
        return self

    def components(self) -> tuple[Pieces, Pieces]:
        """Both components over time."""
        if self.times is not None and self.forces is not None:
            xs, ys = zip(*self.forces, strict=True)
            return motion.monotone_table(self.times, xs), motion.monotone_table(self.times, ys)
        x, y = self.force or (0.0, 0.0)
        return motion.constant_rate(x, 0.0), motion.constant_rate(y, 0.0)


class Torque(Table):
    """A torque on a link, constant or over time, positive counter-clockwise about the plane's normal."""

    link: str = Field(description="the link it acts on")
    torque: Finite | None = Field(None, description="constant torque, counter-clockwise [N m]")
    times: list[Finite] | None = Field(None, description="times of a table, increasing [s]")
    torques: list[Finite] | None = Field(None, description="torques at `times`; between them monotone cubics [N m]")

    @model_validator(mode="after")
    def _one_kind(self) -> Torque:
        _check_values("torque", "torques", self.torque, self.times, self.torques)
        return self

    def history(self) -> Pieces:
        """Torque over time."""
        if self.times is not None and self.torques is not None:
            return motion.monotone_table(self.times, self.torques)
        return motion.constant_rate(self.torque or 0.0, 0.0)


class Spring(Table):
    """A spring with a damper beside it, along the line between two points."""

    point: str = Field(description="one end: origin of this link or frame")
    to: str | None = Field(None, description="other end: origin of this link or frame")
    anchor: Pair | None = Field(None, description="other end instead: a fixed point, plane axes [m]")
    stiffness: NonNegative = Field(description="stiffness [N/m]")
    free_length: NonNegative = Field(description="length without force [m]")
    damping: NonNegative = Field(0.0, description="damping along the line [N s/m]")

    @model_validator(mode="after")
    def _one_end(self) -> Spring:
        if (self.to is None) == (self.anchor is None):
            raise ValueError("give its other end: either to, a link or frame, or anchor, a fixed point")
        return self


class TorsionSpring(Table):
    """A torsion spring with a damper, in a joint or between two links; its angle is zero in the drawn pose."""

    joint: str | None = Field(None, description="the revolute joint it acts in; its angle is the joint's")
    links: Annotated[list[str], Field(min_length=2, max_length=2)] | None = Field(
        None, description='or two links, "world" included; its angle is that of the second from the first'
    )
    stiffness: NonNegative = Field(description="stiffness [N m/rad]")
    free_angle: Finite = Field(description="angle without torque, zero in the drawn pose [rad]")
    damping: NonNegative = Field(0.0, description="damping [N m s/rad]")

    @model_validator(mode="after")
    def _one_place(self) -> TorsionSpring:
        if (self.joint is None) == (self.links is None):
            raise ValueError("give either joint or links")
        return self


def _check_values(one: str, many: str, value: object, times: list[float] | None, values: object) -> None:
    """Check that a load is either constant or a table."""
    if (value is None) == (values is None):
        raise ValueError(f"give either {one}, or times with {many}")
    check_history(times, values, many)  # type: ignore[arg-type]
