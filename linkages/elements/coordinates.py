"""What elements do to coordinates and points: couple two coordinates, bar one by a contact, push along one; touch.

Joint coordinates are zero in the reference configuration, in rad or m.
"""

from __future__ import annotations

from dataclasses import dataclass

from linkages.elements.contact_tables import ContactTable, FrictionTable
from linkages.elements.pictures import Point
from linkages.input.functions.definitions import Definition

#: End of the name of the coordinate of a wheel that a drive turns before its joint, after the joint's name.
WHEEL = ".wheel"

#: Separator of a link's name and the number of a hinge, in the name of a coordinate between rigid segments of the link.
HINGE = "/hinge"


@dataclass(frozen=True)
class Coupled:
    """Two joints with coupled coordinates: second = ratio * first + offset, or at most half a width from it."""

    joints: tuple[str, str]
    ratio: float
    offset: float
    carrier: str | None  # link from which both coordinates are seen; None: their own
    label: str  # in messages: the kind and the joints
    width: float | None = None  # free travel of the second coordinate; None: none
    travel: str = ""  # in messages: what the free travel is
    start: float = 0.0  # second coordinate at t = 0, from the middle of the free travel


@dataclass(frozen=True)
class Barrier:
    """A contact that a joint's coordinate, less `ratio` times another's, meets from one side."""

    joint: str
    side: float  # 1: from below, -1: from above
    place: float  # [rad or m]
    contact: ContactTable
    lever: float = 1.0  # penetration per coordinate beyond the place
    ratio: float = 0.0
    other: str | None = None
    carrier: str | None = None  # link from which both coordinates are seen; None: their own
    friction: FrictionTable | None = None
    arm: float = 0.0  # sliding speed over the angular velocity of both joints' children relative to each other [m]


@dataclass(frozen=True)
class Edge:
    """A contact of a point with a straight line, whose free side is to the left of its direction."""

    point: str  # origin of this link or frame
    line: Point  # frame whose x axis is the line; or a fixed point of the line, plane axes [m]
    angle: float  # direction of a fixed line, from x_P counter-clockwise [rad]
    contact: ContactTable
    friction: FrictionTable | None = None


@dataclass(frozen=True)
class Push:
    """A torque, or force, along a joint's coordinate: a formula, and a share of the load of the joint.

    The load is the force in the joint or, if that is larger, the leverage times the magnitude of its moment.
    """

    joint: str
    law: Definition  # [N m or N]
    share: Definition | None = None  # over the load [m or 1]; None: it does not depend on the load
    leverage: float = 0.0  # [1/m]
