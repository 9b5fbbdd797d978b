"""A torque on a link or in a revolute joint: constant, or a function of time, positions, speeds and states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pydantic import Field

from linkages.base.kernel import Array, inlined_kernel, record_type
from linkages.elements.element import ENERGY, POWER, SECOND, VALUE, Applied, Checks, Element, Places, Quantities
from linkages.elements.load_function import At, LoadFunction, Over, Times
from linkages.elements.pictures import Turning
from linkages.input.files.toml import Finite
from linkages.input.functions.definitions import Function
from linkages.mechanics.planar.closure_rows import add_term_wrench, term_rate
from linkages.mechanics.planar.functions import Given, value_of
from linkages.mechanics.planar.record_types import TERM


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


def check(torque: Torque, checks: Checks) -> None:
    """Refuse unknown inputs of the function, an unknown link, and a joint that is not revolute."""
    torque.check_inputs(checks)
    if torque.link is not None:
        checks.moved_link("link", torque.link)
    if torque.joint is not None:
        checks.revolute("joint", torque.joint)


RECORD = record_type(
    term=TERM,
    sign="f8",  # change of the coordinate over the change of the term: 1 or -1
    value="i8",  # function of the torque [N m]
)


def pack(torque: Torque, places: Places) -> dict[str, Any]:
    """Return the numbers of the record."""
    return along(places.coordinate_of(torque.joint, ("world", torque.link or "world")))


def along(coordinate: tuple[Any, float]) -> dict[str, Any]:
    """Return the numbers of a record along a coordinate."""
    return {"term": coordinate[0], "sign": coordinate[1]}


def functions(torque: Torque, _: str) -> Mapping[str, Sequence[Function]]:
    """Return the torque [N m]."""
    constant, values = torque.torque, torque.torques
    return {
        "value": torque.components(
            None if constant is None else [constant], None if values is None else [[value] for value in values]
        )
    }


@inlined_kernel
def act(torque: np.record, given: Given, pose: Array, vel: Array, wrench: Array) -> None:
    """Add the torque to the wrench of the outer body, and the opposite one to the inner body."""
    add_term_wrench(torque.term, pose, torque.sign * value_of(given, torque.value), wrench)


@inlined_kernel
def tell(torque: np.record, given: Given, pose: Array, vel: Array, row: Array) -> None:
    """Fill the torque [N m] and the power."""
    value = value_of(given, torque.value)
    row[VALUE], row[SECOND], row[ENERGY] = value, 0.0, 0.0
    row[POWER] = value * torque.sign * term_rate(torque.term, pose, vel)


TORQUE = Element(
    table="torques",
    keys=Torque,
    check=check,
    record=RECORD,
    pack=pack,
    functions=functions,
    act=act,
    tell=tell,
    outputs=(
        Quantities("TORQUE", {"torque": "applied torque, counter-clockwise; in a joint: along its coordinate [N m]"}),
    ),
    applied=Applied("torque", "value", {"torque": "N m"}),
    picture=lambda torque, scene: (Turning(torque.joint, torque.link),),
    force=lambda torque, slides, extent: abs(torque.torque or 0.0) / extent,
)
