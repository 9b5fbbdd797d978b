"""Draws a machine anew: its loops closed, every joint within the limits that its file gives.

Limits say which of the assemblies of a linkage is meant, where the drawing does not close.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from linkages.arrays import Array
from linkages.files.raw_model import Pose, RawModel, rotation
from linkages.files.rigid import moved
from linkages.model.mechanism import Joint, planar
from linkages.planar.bodies import make_pose
from linkages.planar.closure import closure_error
from linkages.planar.record_types import ANGLE
from linkages.system.spanning import spanning_tree
from linkages.system.tree import Tree

_CLOSED = 1e-9  # gap in parts of the size, or angle beyond a limit [rad], of a linkage that closes within its limits
_FAR = 1e6  # as good as no limit [rad or m]
_STARTS = 20  # of the search, anywhere between the limits; before them, one from their middle


class Drawn(NamedTuple):
    """A machine in a pose, and the coordinates of its joints there, from the pose of the file [rad or m]."""

    model: RawModel
    coordinates: dict[str, float]


def closed_within_limits(path: Path, model: RawModel, limits: Mapping[str, tuple[float, float]]) -> Drawn | None:
    """Return the machine in a pose in which its loops close and every joint is within its limits.

    Parameters
    ----------
    path : Path
        The file, for errors.
    model : RawModel
    limits : mapping of str to (float, float)
        Lowest and highest coordinate of a joint, zero where it is drawn [rad or m].

    Returns
    -------
    Drawn or None
        With the machine itself if it is drawn like that; None if no such pose is found.

    Raises
    ------
    InputError
        If it is no planar linkage.
    """
    from scipy.optimize import least_squares  # takes a while to import

    mechanism = planar(path, model, {})
    tree = spanning_tree(replace(mechanism, joints=tuple(sorted(mechanism.joints, key=lambda j: j.name not in limits))))
    limited = [joint for joint in mechanism.joints if joint.name in limits]
    low, high = np.clip([limits[joint.name] for joint in limited], -_FAR, _FAR).reshape(-1, 2).T
    turns = np.array([joint.type == "revolute" for joint in limited], dtype=bool)
    middle = 0.5 * (low + high)
    size = np.where(tree.closure_rows["term"]["kind"] == ANGLE, 1.0, tree.extent)

    def misfit(q: Array) -> Array:
        pose, gaps = _assembled(tree, q)
        values = np.array([_coordinate(tree, pose, joint) for joint in limited])
        values = np.where(turns, middle + np.angle(np.exp(1j * (values - middle))), values)
        return np.concatenate([gaps / size, np.clip(low - values, 0.0, None), np.clip(values - high, 0.0, None)])

    def closes(q: Array) -> bool:
        return bool(np.abs(misfit(q)).max(initial=0.0) < _CLOSED)

    if closes(np.zeros(tree.size)):
        return Drawn(model, {joint.name: 0.0 for joint in mechanism.joints})
    reach = {"revolute": np.pi, "prismatic": tree.extent}
    ranges = [limits.get(name, (-np.inf, np.inf)) for name in tree.coordinates]
    farthest = np.array([reach[mechanism.joint[name].type] for name in tree.coordinates])
    ends = np.clip(np.array(ranges).T, -farthest, farthest)
    dice = np.random.default_rng(0)
    for part in [0.5, *dice.random((_STARTS, tree.size))]:
        found = least_squares(misfit, ends[0] + part * (ends[1] - ends[0]), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        if closes(found.x):
            pose, _ = _assembled(tree, found.x)
            at = {j.name: _coordinate(tree, pose, j) for j in mechanism.joints if j.type in reach}
            return Drawn(_posed(model, tree, found.x), at)
    return None


def _assembled(tree: Tree, q: Array) -> tuple[Array, Array]:
    """Poses of all bodies at q, and the gaps of the loops."""
    pose, rows = make_pose(tree.bodies), tree.closure_rows
    return pose, closure_error(tree.bodies, rows, np.zeros(len(rows)), q, pose)


def _coordinate(tree: Tree, pose: Array, joint: Joint) -> float:
    """Angle or way of a joint from where it is drawn [rad or m]."""
    parent, child = tree.index[joint.parent], tree.index[joint.child]
    if joint.type == "revolute":
        return float(joint.sign * (pose[child, 2] - pose[parent, 2]))
    turn = np.array([[pose[parent, 3], -pose[parent, 4]], [pose[parent, 4], pose[parent, 3]]])
    ends = (_place(tree, pose, body, at) for body, at in ((child, joint.on_child), (parent, joint.on_parent)))
    return float((turn @ joint.direction) @ np.subtract(*ends))


def _place(tree: Tree, pose: Array, body: int, drawn: Array) -> Array:
    """Where a point drawn on a body is."""
    x, y = drawn - tree.drawn[body]
    c, s = pose[body, 3:]
    return pose[body, :2] + np.array([c * x - s * y, s * x + c * y])


def _posed(model: RawModel, tree: Tree, q: Array) -> RawModel:
    """Move every link, with all that it carries, to where the tree has it at q."""
    (pose, _), basis = _assembled(tree, q), tree.mechanism.basis
    moves = {"world": Pose()}
    for name in tree.mechanism.link:
        body = tree.index[name]
        turn = basis @ rotation(np.array([0.0, 0.0, pose[body, 2]])) @ basis.T
        moves[name] = Pose(turn, basis[:, :2] @ _place(tree, pose, body, np.zeros(2)))
    closed = moved(model, moves)
    return replace(closed, joints=tuple(replace(joint, position_on_parent=joint.position) for joint in closed.joints))
