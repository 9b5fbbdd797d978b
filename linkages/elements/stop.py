"""A stop, which limits the coordinate of an ideal joint from one side by a contact."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal

import numpy as np
from pydantic import Field

from linkages.base.arrays import Array
from linkages.elements.contact_tables import ContactTable
from linkages.elements.coordinates import Barrier
from linkages.elements.element import Checks, Element
from linkages.elements.outputs import Quantities, Source
from linkages.elements.pictures import Jointed, Named, Picture, Scene, Wall
from linkages.input.files.toml import Finite, Table

# in units of drawings
_ENDS = 2.6, 7.0  # distances from the joint of the ends of an angular stop
_EDGE = 2.3  # of a block from its joint, along the slot
_BAR = 0.65  # half of a bar


class Stop(Table):
    """A limit stop that a joint's coordinate meets from one side, with a contact law.

    At a revolute joint the law's penetration is an angle and its force a torque; at a prismatic joint read m for rad.
    """

    of_any_joint = True

    joint: str = Field(description="ideal joint whose range the stop limits")
    side: Literal["upper", "lower"] = Field(description="upper or lower limit of the coordinate")
    limit: Finite = Field(description="coordinate of the stop, zero in the reference configuration [rad]")
    contact: ContactTable = Field(description="contact law, with stiffness [N m/rad^n]")

    @property
    def beyond(self) -> float:
        """Return the sign of motion beyond the limit."""
        return 1.0 if self.side == "upper" else -1.0


def check(stop: Stop, checks: Checks) -> None:
    """Refuse joints without a coordinate of their own, wrong units, and laws of journals."""
    checks.moving(stop.joint)
    slides = checks.slides(stop.joint)
    if checks.has_clearance(stop.joint) and slides:
        checks.refuse("joint", f'"{stop.joint}" has clearance; stop a point of its block by a table [contacts.NAME]')
    checks.units(Stop, slides)
    checks.plain(stop.contact)


def contacts(stop: Stop) -> Mapping[str, Barrier]:
    """Return the contact."""
    return {"": Barrier(stop.joint, stop.beyond, stop.limit, stop.contact)}


def picture(stop: Stop, scene: Scene) -> Iterator[Picture]:
    """Draw the limit of the joint's coordinate, hatched beyond it."""
    joint = scene.joint(stop.joint)
    if joint.type == "prismatic":
        across = np.array([-joint.direction[1], joint.direction[0]])
        at = (stop.limit / scene.unit + stop.beyond * _EDGE) * joint.direction  # position of the block's edge
        ends = np.array([at + s * across for s in (-_ENDS[0], _ENDS[0])])
        yield Wall(joint.parent, joint.on_parent, ends, stop.beyond * joint.direction)
    else:
        yield _around(stop, joint, scene)
    yield Named(stop.joint)


def _around(stop: Stop, joint: Jointed, scene: Scene) -> Wall:
    """Draw the limit of an angle, where the link's longest bar meets it."""
    held, link, sense = joint.parent, joint.child, joint.sign
    if link == "world":
        held, link, sense = joint.child, joint.parent, -joint.sign
    way = scene.farthest(link, joint.on_child)
    angle = np.arctan2(way[1], way[0]) + sense * stop.limit
    along = np.array([np.cos(angle), np.sin(angle)])
    normal: Array = sense * stop.beyond * np.array([-along[1], along[0]])
    return Wall(held, joint.on_parent, np.array([s * along + _BAR * normal for s in _ENDS]), normal)


_TURNING = {
    "torque": "magnitude of the reaction torque [N m]",
    "penetration": "angle beyond the stop; negative: distance to it [rad]",
    "closing": "rate of the penetration [rad/s]",
    "power": "power that the load delivers to the linkage [W]",
}
_SLIDING = {
    "force": "magnitude of the force [N]",
    "penetration": "depth of the point beyond the wall, negative: its distance from it [m]",
    "closing": "rate of the penetration [m/s]",
    "sliding": "speed of the point along the wall [m/s]",
    "load": "normal force [N]",
    "power": "power that the force pair delivers [W]",
}

STOP = Element(
    table="stops",
    keys=Stop,
    check=check,
    contacts=contacts,
    outputs=(
        Quantities("STOP (revolute)", _TURNING, Source.CONTACT, {"torque": "load"}),
        Quantities("STOP (prismatic)", _SLIDING, Source.CONTACT),
    ),
    sort=lambda stop, slides: int(slides(stop.joint)),
    picture=picture,
    linear=False,
    from_reference=lambda stop: True,
)
