"""Outputs of points: motion of links, frames and joints; coordinates of the tree."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from linkages.input.model.experiment import PIN_QUANTITIES, QUANTITIES
from linkages.mechanics.planar.markers import arm, marker_acceleration, marker_velocity
from linkages.results.outputs.quantity import Declaration, Element, Owner, Snapshot, formula, quantities
from linkages.system import System


@formula()
def _position(output: np.record, seen: Snapshot) -> float:
    b, pose = output.marker.body, seen.state.pose
    rx, ry = arm(pose, output.marker)
    return (pose[b, 0] + rx, pose[b, 1] + ry, pose[b, 2] + output.constant)[output.column]


@formula()
def _velocity(output: np.record, seen: Snapshot) -> float:
    b, vel = output.marker.body, seen.state.vel
    rx, ry = arm(seen.state.pose, output.marker)
    vx, vy = marker_velocity(vel, b, rx, ry)
    return (vx, vy, vel[b, 0])[output.column]


@formula()
def _acceleration(output: np.record, seen: Snapshot) -> float:
    b, acc = output.marker.body, seen.state.acc
    rx, ry = arm(seen.state.pose, output.marker)
    ax, ay = marker_acceleration(seen.state.vel, acc, b, rx, ry)
    return (ax, ay, acc[b, 0], math.hypot(ax, ay))[output.column]


@formula()
def _coordinate(output: np.record, seen: Snapshot) -> float:
    return seen.state.q[output.at]


def _motion(texts: dict[str, str]) -> dict[str, Declaration]:
    """Make the quantities of a point from their texts."""
    return {
        **quantities(_position, **{name: texts[name] for name in ("x", "y", "angle")}),
        **quantities(_velocity, **{name: texts[name] for name in ("vx", "vy", "omega")}),
        **quantities(_acceleration, **{name: texts[name] for name in ("ax", "ay", "alpha", "acceleration")}),
    }


def _point(system: System, name: str) -> Element:
    return Element(marker=system.tree.named_marker(name), constant=system.mechanism.place[name].angle)


def _joints_asked(system: System) -> Iterable[str]:
    """List the joints whose position the experiment reports."""
    asked = {name.rpartition(".")[0] for name in system.experiment.outputs}
    return (name for name in system.mechanism.joint if name in asked)


_OF_JOINT = {name: found for name, found in _motion(QUANTITIES | PIN_QUANTITIES).items() if name in PIN_QUANTITIES}
_COORDINATE = "coordinate of the spanning tree: of a joint, a floating link, a mode or a hinge [rad or m]"

#: Links and frames, and joints as points.
POINTS = (
    Owner("POINT", lambda system: system.mechanism.point, _point, _motion(QUANTITIES)),
    Owner("JOINT", lambda system: system.mechanism.joint, _point, _OF_JOINT, asked=_joints_asked),
)
#: Coordinates of the tree.
COORDINATES = Owner(
    "q",
    lambda system: system.tree.coordinates,
    lambda system, name: Element(system.tree.coordinates.index(name)),
    quantities(_coordinate, COORDINATE=_COORDINATE),
)
