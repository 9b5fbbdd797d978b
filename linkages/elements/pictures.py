"""Pictures of elements as data: shapes at points and joints, without a drawing's units or colours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from linkages.base.arrays import Array

Point = str | Sequence[float]  #: origin of a link or frame, by name; or a fixed point in plane axes [m]


class Jointed(Protocol):
    """A joint; `linkages.input.model.mechanism.Joint` is one, and explains these attributes."""

    name: str
    type: str
    parent: str
    child: str
    on_parent: Array
    on_child: Array
    sign: float
    direction: Array


class Scene(Protocol):
    """A machine to draw in, for `linkages.elements.element.Element.picture`."""

    @property
    def unit(self) -> float:
        """Return the unit of lengths in drawings [m]."""

    def joint(self, name: str) -> Any:
        """Return a joint, a `Jointed`."""

    def frame(self, name: str) -> tuple[str, Array, float]:
        """Return link, origin (2,) [m] and angle of a link's or named frame, in the reference configuration."""

    def farthest(self, link: str, point: Array) -> Array:
        """Return the way (2,) from a point to the farthest place of a link, in the reference configuration [m]."""


@dataclass(frozen=True)
class Between:
    """A dashed line between two points, with the element's name."""

    one: Point
    other: Point


@dataclass(frozen=True)
class Around:
    """A spiral at a joint or at a link's centre of mass; a zigzag along a prismatic joint; with the element's name."""

    joint: str | None
    link: str | None


@dataclass(frozen=True)
class Arrow:
    """An arrow to a point, along the largest value of the element's first two quantities; with its name."""

    point: str
    turns: bool  #: whether the values are in axes of the point, which rotate with the link
    values: ClassVar[int] = 2


@dataclass(frozen=True)
class Turning:
    """An arrow around a joint or a link's centre of mass, in the sense of the largest value; with its name."""

    joint: str | None
    link: str | None
    values: ClassVar[int] = 1


@dataclass(frozen=True)
class Traced:
    """A line through points: a link, a place on it [m], and a way from there [units]; its style in drawings."""

    points: Sequence[tuple[str, Array, Array]]
    style: str = "pitch line"


@dataclass(frozen=True)
class Wall:
    """A hatched line on a link: ways of both ends from a place on it [units], and the direction of the hatching."""

    link: str
    place: Array
    ends: Array
    into: Array


@dataclass(frozen=True)
class Ring:
    """A circle around a joint."""

    joint: str


@dataclass(frozen=True)
class Named:
    """The element's name beside a joint."""

    joint: str


@dataclass(frozen=True)
class Labelled:
    """The element's name at a place of a link [m], moved by a way [units, plane axes]."""

    link: str
    place: Array
    away: Array


Picture = Between | Around | Arrow | Turning | Traced | Wall | Ring | Named | Labelled
