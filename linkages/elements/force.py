"""A force at a point of a link: constant, or a function of time, positions, speeds and states."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from pydantic import Field

from linkages.base.kernel import Array, inlined_kernel, record_type
from linkages.elements.element import ENERGY, POWER, SECOND, VALUE, Applied, Checks, Element, Places, Quantities
from linkages.elements.load_function import At, LoadFunction, Over, Times
from linkages.elements.pictures import Arrow
from linkages.input.files.toml import Finite, TwoOf
from linkages.input.functions.definitions import Function
from linkages.mechanics.planar.functions import Given, value_of
from linkages.mechanics.planar.markers import add_force, arm, marker_velocity, turned
from linkages.mechanics.planar.record_types import MARKER


class Force(LoadFunction):
    """A force at a point of a link: constant, or a function of time, position or speed.

    Components are in plane axes, or in axes of the point's frame, which rotate with the link: x along the frame's x
    axis (whose angle is the column ``POINT.angle``), y a quarter turn counter-clockwise from it.
    """

    column_keys = ("force", "at")

    point: str = Field(description="point of application: origin of this link or frame")
    axes: Literal["plane", "body"] = Field(
        "plane", description="axes of the components: the plane's, or the point's, which turn with the link"
    )
    force: TwoOf[Finite] | None = Field(None, description="constant force [N]")
    times: Times = None
    over: Over = None
    at: At = None
    forces: list[TwoOf[Finite]] | None = Field(None, description="forces at `times` or `at`: monotone cubics [N]")
    formula: TwoOf[str] | None = Field(
        None, description="two components as formulas of t, positions and speeds, [N] in SI units"
    )

    def _complete(self) -> None:
        super()._complete()
        self._check("force", "forces")


def check(force: Force, checks: Checks) -> None:
    """Refuse unknown inputs of the function, and a point that is fixed to the world."""
    force.check_inputs(checks)
    if checks.link_of("point", force.point) == "world":
        checks.refuse("point", f'"{force.point}" is fixed to the world; name a link\'s')


RECORD = record_type(
    a=MARKER,
    value="i8",  # function of the first component [N]; the second one follows
    turns="i8",  # 1 if given in the axes of a frame on the body, 0 if in plane axes
    ux="f8",  # x axis of that frame
    uy="f8",
)


def pack(force: Force, places: Places) -> dict[str, Any]:
    """Return the numbers of the record."""
    turns = force.axes == "body"
    angle = places.angle_of(force.point) if turns else 0.0
    return {"a": places.marker_of(force.point), "turns": turns, "ux": math.cos(angle), "uy": math.sin(angle)}


def functions(force: Force, _: str) -> Mapping[str, Sequence[Function]]:
    """Return both components in the force's own axes [N]."""
    return {"value": force.components(force.force, force.forces)}


@inlined_kernel
def _in_plane(force: np.record, given: Given, pose: Array) -> tuple[float, float]:
    """Components in plane axes."""
    x, y, ux, uy = value_of(given, force.value), value_of(given, force.value + 1), force.ux, force.uy
    if force.turns:
        ux, uy = turned(pose, force.a.body, ux, uy)
    return ux * x - uy * y, uy * x + ux * y


@inlined_kernel
def act(force: np.record, given: Given, pose: Array, vel: Array, wrench: Array) -> None:
    """Add the force to the wrench of its body."""
    fx, fy = _in_plane(force, given, pose)
    rx, ry = arm(pose, force.a)
    add_force(wrench, force.a.body, rx, ry, fx, fy)


@inlined_kernel
def tell(force: np.record, given: Given, pose: Array, vel: Array, row: Array) -> None:
    """Fill both components in plane axes [N] and the power."""
    fx, fy = _in_plane(force, given, pose)
    rx, ry = arm(pose, force.a)
    vx, vy = marker_velocity(vel, force.a.body, rx, ry)
    row[VALUE], row[SECOND], row[POWER], row[ENERGY] = fx, fy, fx * vx + fy * vy, 0.0


FORCE = Element(
    table="forces",
    keys=Force,
    check=check,
    points=lambda force: (force.point,),
    from_reference=lambda force: force.axes == "body",
    record=RECORD,
    pack=pack,
    functions=functions,
    act=act,
    tell=tell,
    outputs=(
        Quantities(
            "FORCE",
            {"fx": "applied force along x_P [N]", "fy": "applied force along y_P [N]"},
            size={"force": "magnitude of the applied force [N]"},
        ),
    ),
    applied=Applied("force", "value", {"fx": "N", "fy": "N"}),
    picture=lambda force, scene: (Arrow(force.point, force.axes == "body"),),
    force=lambda force, slides, extent: max(map(abs, force.force or (0.0,))),
)
