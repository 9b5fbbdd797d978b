"""A spring and a damper in parallel, along the line between two points.

From point a to point b, d = p_b - p_a, length l = |d|, u = d/l, it pulls with the tension T = k (l - l_0) + c dl/dt:
T u on a, -T u on b. At exactly zero length it has the direction of the relative velocity v_rel, and only the damping
force c v_rel acts, the mean of the forces just before and just after. With a free length above zero the force jumps
there.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from linkages.base.kernel import Array, inlined_kernel, kernel, record_type
from linkages.elements.element import ENERGY, POWER, SECOND, VALUE, Between, Checks, Element, Places, Point, Quantities
from linkages.input.files.toml import Finite, NonNegative, Table, TwoOf
from linkages.mechanics.planar.markers import add_pair, gap, gap_rate
from linkages.mechanics.planar.record_types import MARKER


class Spring(Table):
    """A spring and a damper in parallel, along the line between two points."""

    point: str = Field(description="one end: origin of this link or frame")
    to: str | None = Field(None, description="other end: origin of this link or frame")
    anchor: TwoOf[Finite] | None = Field(None, description="other end instead: a fixed point, plane axes [m]")
    stiffness: NonNegative = Field(description="stiffness [N/m]")
    free_length: NonNegative = Field(description="length without force [m]")
    damping: NonNegative = Field(0.0, description="damping along the line [N s/m]")

    def _complete(self) -> None:
        if (self.to is None) == (self.anchor is None):
            raise ValueError("give the other end: either to, a link or frame, or anchor, a fixed point")

    @property
    def end(self) -> Point:
        """Return the other end."""
        return self.to if self.to is not None else self.anchor or ()


def check(spring: Spring, checks: Checks) -> None:
    """Refuse a spring within a link."""
    link = checks.link_of("point", spring.point)
    if link == checks.link_of("to", spring.end):
        checks.refuse("", f'joins two points of the same link, "{link}"')


RECORD = record_type(
    a=MARKER,
    b=MARKER,
    stiffness="f8",  # [N/m]
    free="f8",  # length without force [m]
    damping="f8",  # [N s/m]
)


def pack(spring: Spring, places: Places) -> dict[str, Any]:
    """Return both ends."""
    return {"a": places.marker_of(spring.point), "b": places.marker_of(spring.end)}


@kernel
def _pull(spring: np.record, pose: Array, vel: Array) -> tuple[float, float, float, float, float]:
    """Tension, its direction, length and rate of length."""
    dx, dy, arms = gap(pose, spring.a, spring.b)
    vx, vy = gap_rate(vel, spring.a, spring.b, arms)
    length = math.sqrt(dx * dx + dy * dy)
    if length > 0.0:
        ux, uy = dx / length, dy / length
        rate = vx * ux + vy * uy
        return spring.stiffness * (length - spring.free) + spring.damping * rate, ux, uy, length, rate
    rate = math.sqrt(vx * vx + vy * vy)
    if rate > 0.0:
        return spring.damping * rate, vx / rate, vy / rate, length, rate
    return 0.0, 0.0, 0.0, length, rate


@inlined_kernel
def act(spring: np.record, pose: Array, vel: Array, wrench: Array) -> None:
    """Add the pair of forces to the wrenches of the bodies."""
    tension, ux, uy, length, _ = _pull(spring, pose, vel)
    dx, dy, arms = gap(pose, spring.a, spring.b)
    fx, fy = -tension * ux, -tension * uy
    if length == 0.0:  # the same force, and the derivatives of its differentiable part
        vx, vy = gap_rate(vel, spring.a, spring.b, arms)
        fx, fy = -spring.stiffness * dx - spring.damping * vx, -spring.stiffness * dy - spring.damping * vy
    add_pair(wrench, spring.a, spring.b, arms, fx, fy)


@inlined_kernel
def tell(spring: np.record, pose: Array, vel: Array, row: Array) -> None:
    """Fill tension [N], length [m], power and energy."""
    tension, _, _, length, rate = _pull(spring, pose, vel)
    row[VALUE], row[SECOND], row[POWER] = tension, length, -tension * rate
    row[ENERGY] = 0.5 * spring.stiffness * (length - spring.free) ** 2


def _undirected(spring: Spring, row: Array, closest: float) -> str:
    """Refuse a spring with a free length whose ends coincide: it has no direction."""
    if spring.free_length == 0.0 or row[SECOND] > closest:
        return ""
    return (
        "its points coincide at t = 0, where a spring with a free length has no direction; set free_length = 0 or "
        "start elsewhere"
    )


SPRING = Element(
    table="springs",
    keys=Spring,
    check=check,
    points=lambda spring: (spring.point, spring.end),
    record=RECORD,
    values={"stiffness": "stiffness", "free": "free_length", "damping": "damping"},
    pack=pack,
    act=act,
    tell=tell,
    outputs=(Quantities("SPRING", {"force": "tension [N]", "length": "distance of the ends [m]"}),),
    picture=lambda spring, scene: (Between(spring.point, spring.end),),
    force=lambda spring, slides, extent: spring.stiffness * extent,
    problem_at_start=_undirected,
)
