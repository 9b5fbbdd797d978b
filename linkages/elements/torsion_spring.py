"""A spring and a damper along a joint's coordinate, or along the angle between two links.

It resists the coordinate s, zero in the reference configuration, with M = k (s - s_0) + c ds/dt: -M along s on the
second body, M on the first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pydantic import Field

from linkages.base.kernel import Array, inlined_kernel, kernel, record_type
from linkages.elements.element import ENERGY, POWER, SECOND, VALUE, Around, Checks, Element, Places, Quantities
from linkages.input.files.toml import Finite, NonNegative, Table, TwoOf
from linkages.mechanics.planar.closure_rows import add_term_wrench, term_rate, term_value
from linkages.mechanics.planar.record_types import TERM


class TorsionSpring(Table):
    """A spring with a damper along a joint's coordinate, or along the angle between two links.

    The coordinate is zero in the reference configuration. In a prismatic joint the spring gives a force.
    """

    of_any_joint = True

    joint: str | None = Field(None, description="joint along whose coordinate it acts")
    links: TwoOf[str] | None = Field(
        None, description='or two links, "world" included; its angle is the angle of the second relative to the first'
    )
    stiffness: NonNegative = Field(description="stiffness [N m/rad]")
    free_angle: Finite = Field(
        description="angle, or displacement, without torque or force; zero in the reference configuration [rad]"
    )
    damping: NonNegative = Field(0.0, description="damping [N m s/rad]")

    def _complete(self) -> None:
        if (self.joint is None) == (self.links is None):
            raise ValueError("give either joint or links")

    def is_along(self, slides: Callable[[str], bool]) -> bool:
        """Tell whether it acts along a prismatic joint."""
        return self.joint is not None and slides(self.joint)

    @property
    def outer_link(self) -> str | None:
        """Return the link at which a torsion spring between two links is drawn."""
        return next((link for link in reversed(self.links or []) if link != "world"), None)


def check(spring: TorsionSpring, checks: Checks) -> None:
    """Refuse unknown joints and links, and a spring within a link."""
    checks.units(TorsionSpring, spring.joint is not None and checks.slides(checks.moving(spring.joint)))
    for link in spring.links or ():
        checks.known_link("links", link)
    if spring.links is not None and spring.links[0] == spring.links[1]:
        checks.refuse("links", "are the same link")


RECORD = record_type(
    term=TERM,
    sign="f8",  # change of the coordinate over the change of the term: 1 or -1
    stiffness="f8",  # [N m/rad or N/m]
    free="f8",  # coordinate without torque or force [rad or m]
    damping="f8",  # [N m s/rad or N s/m]
)


def pack(spring: TorsionSpring, places: Places) -> dict[str, Any]:
    """Return the coordinate along which it acts."""
    term, sign = places.coordinate_of(spring.joint, spring.links or ())
    return {"term": term, "sign": sign}


@kernel
def _resist(spring: np.record, pose: Array, vel: Array) -> tuple[float, float, float]:
    """Resisting torque or force, coordinate and its rate."""
    value = spring.sign * term_value(spring.term, pose)
    rate = spring.sign * term_rate(spring.term, pose, vel)
    return spring.stiffness * (value - spring.free) + spring.damping * rate, value, rate


@inlined_kernel
def act(spring: np.record, pose: Array, vel: Array, wrench: Array) -> None:
    """Add the torques, or forces, to the wrenches of the bodies."""
    add_term_wrench(spring.term, pose, -spring.sign * _resist(spring, pose, vel)[0], wrench)


@inlined_kernel
def tell(spring: np.record, pose: Array, vel: Array, row: Array) -> None:
    """Fill torque [N m] or force [N], coordinate [rad or m], power and energy."""
    torque, value, rate = _resist(spring, pose, vel)
    row[VALUE], row[SECOND], row[POWER] = torque, value, -torque * rate
    row[ENERGY] = 0.5 * spring.stiffness * (value - spring.free) ** 2


def _force(spring: TorsionSpring, slides: Callable[[str], bool], extent: float) -> float:
    """Return the force on a machine of this size [N]."""
    return spring.stiffness * extent if spring.is_along(slides) else spring.stiffness / extent


_TURNING = {"torque": "torque against its angle [N m]", "angle": "angle, zero in the reference configuration [rad]"}
_SLIDING = {
    "force": "force against its displacement [N]",
    "displacement": "displacement, zero in the reference configuration [m]",
}

TORSION_SPRING = Element(
    table="torsion_springs",
    keys=TorsionSpring,
    check=check,
    from_reference=lambda spring: True,
    record=RECORD,
    values={"stiffness": "stiffness", "free": "free_angle", "damping": "damping"},
    pack=pack,
    act=act,
    tell=tell,
    outputs=(Quantities("TORSION SPRING", _TURNING), Quantities("TORSION SPRING (prismatic)", _SLIDING)),
    sort=lambda spring, slides: int(spring.is_along(slides)),
    picture=lambda spring, scene: (Around(spring.joint, spring.outer_link),),
    force=_force,
)
