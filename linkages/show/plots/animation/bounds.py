"""Bounds of all shapes of a plant while it moves, in the plane of the linkage."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from pydrake.geometry import Cylinder, FrameId, GeometryId, Role, SceneGraph, SceneGraphInspector, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context

from linkages.base.arrays import Array


def bounds(plant: MultibodyPlant, scene_graph: SceneGraph, poses: Iterable[Context], plane: Array) -> Array:
    """Return the lower left and the upper right corner (2, 2) of all drawn shapes in all poses, plane axes [m].

    The contexts are the plant's, one for each pose; `plane` (3, 2) has the axes of the plane in its columns. Without
    shapes there are no corners, (0, 2).
    """
    seen, ends = scene_graph.model_inspector(), []
    shapes = [(plant.GetBodyFromFrameId(frame), one) for frame, one in _drawn(seen)]
    for context in poses:
        for body, one in shapes:
            pose = plant.EvalBodyPoseInWorld(context, body)
            ends += [plane.T @ corner for corner in _ends(seen, one, pose @ seen.GetPoseInFrame(one), plane)]
    found = np.array(ends).reshape(-1, 2)
    return np.array([found.min(axis=0), found.max(axis=0)]) if len(found) else found


def _drawn(seen: SceneGraphInspector) -> list[tuple[FrameId, GeometryId]]:
    """List the shapes of finite size that are drawn, each after the frame of its body."""
    found = [one for one in seen.GetAllGeometryIds(Role.kIllustration) if seen.GetObbInGeometryFrame(one) is not None]
    return [(seen.GetFrameId(one), one) for one in found]


def _ends(seen: SceneGraphInspector, one: GeometryId, pose: RigidTransform, plane: Array) -> Array:
    """Return two opposite corners (2, 3) of the box along the axes of the plane around a shape in the world."""
    shape = seen.GetShape(one)
    box = seen.GetObbInGeometryFrame(one)
    middle, turn, half = pose @ box.center(), (pose.rotation() @ box.pose().rotation()).matrix(), box.half_width()
    along = np.abs(turn.T @ plane)  # (3, 2) parts of the box's axes along those of the plane
    reach = half @ along
    if isinstance(shape, Sphere):
        reach = np.full(2, shape.radius())
    elif isinstance(shape, Cylinder):  # about its third axis
        reach = 0.5 * shape.length() * along[2] + shape.radius() * np.sqrt(np.maximum(1.0 - along[2] ** 2, 0.0))
    return middle + np.outer([-1.0, 1.0], plane @ reach)
