"""Reference configurations of imported mechanisms: loops closed, every joint within the limits of its file.

Where the file's pose does not close the loops, the joint limits select the intended assembly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.input.files.raw_model import Pose, RawModel, rotation
from linkages.input.files.rigid import moved
from linkages.input.model.mechanism import planar
from linkages.mechanics.planar.kinematics import poses_at
from linkages.mechanics.planar.record_types import ANGLE
from linkages.system.spanning import spanning_tree
from linkages.system.tree import Tree

_CLOSED = 1e-9  # largest gap over the size, or angle beyond a limit [rad], of a closed linkage
_FAR = 1e6  # limits beyond this count as absent [rad or m]
_STARTS = 20  # random starts of the search between the limits, after a start from their middle


class Drawn(NamedTuple):
    """A mechanism in a pose, and its joint coordinates relative to the file's pose [rad or m]."""

    model: RawModel
    coordinates: dict[str, float]


def closed_within_limits(
    path: Path, model: RawModel, limits: Mapping[str, tuple[float, float]], displaced: bool = False
) -> Drawn:
    """Find a pose of the mechanism with closed loops and every joint within its limits.

    The limits are coordinates, zero in the file's pose [rad or m]. The result is the mechanism itself if the file's
    pose fulfils both conditions; with `displaced`, places of a joint on both its links must coincide too. InputError if
    the mechanism is not a planar linkage, or no pose was found.
    """
    from scipy.optimize import least_squares  # slow to import

    mechanism = planar(path, model, {})
    tree = spanning_tree(replace(mechanism, joints=tuple(sorted(mechanism.joints, key=lambda j: j.name not in limits))))
    movable = [joint.name for joint in mechanism.joints if joint.type != "fixed"]
    limited = [name for name in movable if name in limits]
    low, high = np.clip([limits[name] for name in limited], -_FAR, _FAR).reshape(-1, 2).T
    turns = np.array([mechanism.joint[name].type == "revolute" for name in limited], dtype=bool)
    middle = 0.5 * (low + high)
    size = np.where(tree.closure_rows["term"]["kind"] == ANGLE, 1.0, tree.extent)

    def misfit(q: Array) -> Array:
        gaps, values = tree.gaps(q), tree.joint_coordinates(limited, q)
        values = np.where(turns, middle + np.angle(np.exp(1j * (values - middle))), values)
        return np.concatenate([gaps / size, np.clip(low - values, 0.0, None), np.clip(values - high, 0.0, None)])

    def closes(q: Array) -> bool:
        return bool(np.abs(misfit(q)).max(initial=0.0) < _CLOSED)

    apart = [float(np.linalg.norm(joint.on_parent - joint.on_child)) for joint in mechanism.joints if displaced]
    if closes(np.zeros(tree.size)) and max(apart, default=0.0) <= _CLOSED * tree.extent:
        return Drawn(model, {joint.name: 0.0 for joint in mechanism.joints})
    reach = {"revolute": np.pi, "prismatic": tree.extent}
    ranges = [limits.get(name, (-np.inf, np.inf)) for name in tree.coordinates]
    farthest = np.array([reach[mechanism.joint[name].type] for name in tree.coordinates])
    ends = np.clip(np.array(ranges).T, -farthest, farthest)
    dice = np.random.default_rng(0)
    for part in [0.5, *dice.random((_STARTS, tree.size))]:
        found = least_squares(misfit, ends[0] + part * (ends[1] - ends[0]), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        if closes(found.x):
            at = dict(zip(movable, tree.joint_coordinates(movable, found.x).tolist(), strict=True))
            return Drawn(_posed(model, tree, found.x), at)
    if limits:
        problem = "no pose was found in which all loops close and every joint is within its limits"
        raise InputError(path, "<limit>", f"{problem}; check or remove them")
    raise InputError(path, "<joint>", "no pose was found in which all loops close; check the places of the joints")


def _posed(model: RawModel, tree: Tree, q: Array) -> RawModel:
    """Move every link, with its joints and frames, to its pose in the tree at q."""
    pose, basis = poses_at(tree.bodies, q), tree.mechanism.basis
    moves = {"world": Pose()}
    for name in tree.mechanism.link:
        body = tree.index[name]
        c, s = pose[body, 3:]
        turned = np.array([[c, -s], [s, c]])
        turn = basis @ rotation(np.array([0.0, 0.0, pose[body, 2]])) @ basis.T
        moves[name] = Pose(turn, basis[:, :2] @ (pose[body, :2] - turned @ tree.drawn[body]))
    closed = moved(model, moves)
    return replace(closed, joints=tuple(replace(joint, position_on_parent=joint.position) for joint in closed.joints))
