"""A point of a link at a straight line, on the ground or on another link: a unilateral contact."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from pydantic import Field

from linkages.elements.contact_tables import ContactTable, FrictionTable, check_states
from linkages.elements.coordinates import Edge
from linkages.elements.element import Checks, Element
from linkages.elements.outputs import Quantities, Source
from linkages.elements.pictures import Labelled, Picture, Scene, Traced, Wall
from linkages.input.files.toml import Finite, Table, TwoOf

# in units of drawings
_REACH = 12.0  # half the length of the line
_NAME = 2.2  # distance of the name


class LineContact(Table):
    """Contact of a point of a link with a straight line, on the ground or on another link: a foot, a probe, a buffer.

    The line is infinite; its free side is to the left of its direction: along y if the line is along x.
    """

    point: str = Field(description="origin of this link or frame")
    line: str | None = Field(None, description="frame whose x axis is the line; its y axis points to the free side")
    anchor: TwoOf[Finite] | None = Field(None, description="instead: a point of a fixed line, plane axes [m]")
    angle: Finite = Field(0.0, description="direction of the fixed line, from x_P counter-clockwise [rad]")
    contact: ContactTable = Field(description="normal contact law, with stiffness [N/m^n]")
    friction: FrictionTable | None = Field(None, description="friction; default: none")

    def _complete(self) -> None:
        if (self.line is None) == (self.anchor is None):
            raise ValueError("give either line, a frame, or anchor, a fixed point (with angle)")
        if self.line is not None and self.angle:
            raise ValueError("angle belongs to anchor; the line's frame has its own direction")
        check_states(self.contact, self.friction)

    @property
    def place(self) -> str | list[float]:
        """Return the frame of the line, or a point of a fixed one."""
        return self.line if self.line is not None else self.anchor or []


def check(touch: LineContact, checks: Checks) -> None:
    """Refuse a line on the point's own link, and laws of journals."""
    link = checks.link_of("point", touch.point)
    if link == checks.link_of("line", touch.place):
        checks.refuse("", f'has its point and its line on the same link, "{link}"')
    checks.plain(touch.contact)


def contacts(touch: LineContact) -> Mapping[str, Edge]:
    """Return the contact."""
    return {"": Edge(touch.point, touch.place, touch.angle, touch.contact, touch.friction)}


def picture(touch: LineContact, scene: Scene) -> Iterator[Picture]:
    """Draw the line, hatched on the forbidden side."""
    link, at, angle = "world", np.array(touch.anchor), touch.angle
    if touch.line is not None:
        link, at, angle = scene.frame(touch.line)
    along, into = np.array([np.cos(angle), np.sin(angle)]), np.array([np.sin(angle), -np.cos(angle)])
    yield Traced([(link, at, s * along) for s in (-_REACH, _REACH)], "rail")
    yield Wall(link, at, np.outer([-_REACH, _REACH], along), into)
    yield Labelled(link, at, _NAME * into)


_OUTPUTS = Quantities(
    "CONTACT",
    {
        "force": "magnitude of the force [N]",
        "fx": "force on the point along x_P [N]",
        "fy": "force on the point along y_P [N]",
        "penetration": "depth of the point beyond the wall, negative: its distance from it [m]",
        "closing": "rate of the penetration [m/s]",
        "sliding": "speed of the point along the wall [m/s]",
        "load": "normal force [N]",
        "power": "power that the force pair delivers [W]",
    },
    Source.CONTACT,
)

TOUCH = Element(
    table="contacts",
    keys=LineContact,
    check=check,
    points=lambda touch: (touch.point, touch.place),
    contacts=contacts,
    outputs=(_OUTPUTS,),
    picture=picture,
    linear=False,
    from_reference=lambda touch: touch.line is not None,
)
