"""Tables of unilateral contacts other than clearance joints: limit stops, points at straight lines."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from linkages.files.toml import Finite, Table
from linkages.model.experiment_tables import Contact, Friction
from linkages.model.load_tables import Pair


class Stop(Table):
    """A limit stop that a joint's coordinate meets from one side, with a contact law.

    At a revolute joint the law's penetration is an angle and its force a torque; at a prismatic joint read m for rad.
    """

    of_any_joint = True

    joint: str = Field(description="ideal joint whose range the stop limits")
    side: Literal["upper", "lower"] = Field(description="upper or lower limit of the coordinate")
    limit: Finite = Field(description="coordinate of the stop, zero in the reference configuration [rad]")
    contact: Contact = Field(description="contact law, with stiffness [N m/rad^n]")

    @property
    def laws(self) -> tuple[str, ...]:
        """Return the names of the acting laws."""
        return (self.contact.law,)


class LineContact(Table):
    """Contact of a point of a link with a straight line, on the ground or on another link: a foot, a probe, a buffer.

    The line is infinite; its free side is to the left of its direction: along y if the line is along x.
    """

    point: str = Field(description="origin of this link or frame")
    line: str | None = Field(None, description="frame whose x axis is the line; its y axis points to the free side")
    anchor: Pair | None = Field(None, description="instead: a point of a fixed line, plane axes [m]")
    angle: Finite = Field(0.0, description="direction of the fixed line, from x_P counter-clockwise [rad]")
    contact: Contact = Field(description="normal contact law, with stiffness [N/m^n]")
    friction: Friction | None = Field(None, description="friction; default: none")

    @model_validator(mode="after")
    def _one_line(self) -> LineContact:
        if (self.line is None) == (self.anchor is None):
            raise ValueError("give either line, a frame, or anchor, a fixed point (with angle)")
        if self.line is not None and self.angle:
            raise ValueError("angle belongs to anchor; the line's frame has its own direction")
        return self

    @property
    def laws(self) -> tuple[str, ...]:
        """Return the names of the acting laws."""
        return (self.contact.law, *((self.friction.law,) if self.friction is not None else ()))
