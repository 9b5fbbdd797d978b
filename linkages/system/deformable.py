"""What the spanning tree knows of a deformable body: a body with shape coordinates, and nodes that it carries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from linkages.base.arrays import Array


class DeformableBody(Protocol):
    """A deformable link or a part of one, along a straight line in the reference configuration.

    `linkages.elements.flexible.substructure.Substructure` is one; `linkages.mechanics.planar.bodies` explains shapes.
    """

    @property
    def name(self) -> str:
        """Return its name: of the link, unless that is divided."""

    @property
    def rod(self) -> Any:
        """Return mass, mass centre and moment of inertia, as attributes."""

    @property
    def carrier(self) -> str:
        """Return the body that carries this one; empty if a joint carries it, or if it floats."""

    @property
    def origin(self) -> Array:
        """Return the origin of its frame in the reference configuration, (2,) [m]."""

    @property
    def direction(self) -> Array:
        """Return the unit vector along it in the reference configuration, (2,)."""

    @property
    def abscissas(self) -> tuple[float, ...]:
        """Return the places of joints and frames, from the origin [m]."""

    @property
    def acting(self) -> frozenset[float]:
        """Return the places of joints and loads that act, without the carrier's [m]."""

    @property
    def ends(self) -> tuple[float, float]:
        """Return the places of its ends [m]."""

    @property
    def first(self) -> float:
        """Return the distance of its origin from the first end of its link [m]."""

    @property
    def settles(self) -> bool:
        """Whether it is deflected by its loads at t = 0."""

    @property
    def is_chord(self) -> bool:
        """Whether its axis passes through another joint; else it is tangent at the origin."""

    @property
    def size(self) -> int:
        """Return the number of its shape coordinates."""

    @property
    def bends(self) -> int:
        """Return the number of shapes across, which come first."""

    @property
    def coordinates(self) -> list[str]:
        """Return the names of its shape coordinates."""

    @property
    def frequencies(self) -> Array:
        """Return the frequency of each shape alone [rad/s]."""

    def abscissa(self, point: Array) -> float:
        """Return the place that carries a joint or frame at a reference point [m]."""

    def nearest(self, s: float) -> float:
        """Return the place nearest to s [m]."""

    def moves(self, s: float) -> bool:
        """Tell whether a place moves or turns relative to the frame."""

    def slopes(self, places: Array) -> Array:
        """Return the slopes at places (ns,) [m] per unit of each shape, (ns, nf)."""

    def fill(self, shapes: Any) -> None:
        """Fill the lines of the body in `linkages.mechanics.planar.bodies.Bodies.shapes`."""

    def fill_section(self, s: float, shapes: Any) -> None:
        """Fill the lines of the node at a place [m]."""


def section_at(link: Sequence[DeformableBody], point: Array) -> tuple[str, float]:
    """Return the name of the body of a link, and the place on it, that carry a joint or frame at a reference point."""

    def beyond(part: DeformableBody) -> float:
        s = float((point - part.origin) @ part.direction)
        return max(part.ends[0] - s, s - part.ends[1])

    part = min(link, key=beyond)
    return part.name, part.abscissa(point)
