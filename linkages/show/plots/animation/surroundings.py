"""Fixed surroundings in a Meshcat scene: hatched ground, rails, a scale, the paths of points.

Lines are flat ribbons, because browsers draw Meshcat's lines one pixel wide.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import Box, Cylinder, Meshcat, Rgba
from pydrake.math import RigidTransform, RotationMatrix

from linkages.base.arrays import Array
from linkages.base.palette import MARK
from linkages.results.assessment import Assessment
from linkages.show.plots.animation.magnified import GROUND, joint_axes
from linkages.show.plots.drawing.shapes import below, hatched
from linkages.show.plots.style import asked_points, round_length
from linkages.system.joints import SystemJoint

# lengths over the linkage's size
_LINE = 0.004  # width of a line
_STAND = (0.03, 0.045)  # half the width, and the height, of a support on the ground
_HATCH = 0.016  # distance of hatching lines
_RAIL = 0.035  # height of the hatched ground below a rail
_BENEATH = 0.02  # depth of paths and hatching below the plane

_PATH_POINTS = 1000
_NOWHERE = np.empty((0, 2))
SCALE = "/ground/scale/label"  # place of a label in the scene


class Surroundings:
    """Draws the surroundings of the moving parts; `bodies` (2, 2) are the corners of their shapes, plane axes [m]."""

    def __init__(self, assessment: Assessment, meshcat: Meshcat, bodies: Array = _NOWHERE) -> None:
        self.assessment, self.meshcat, self.bodies = assessment, meshcat, bodies
        self.system, self.size = assessment.system, assessment.system.tree.extent
        self.basis = self.system.basis
        depths = [float(self.basis[:, 2] @ link.translation) for link in self.system.links.values()]
        self.depth = min(depths) - _BENEATH * self.size

    def span(self) -> tuple[Array, Array]:
        """Return the lower left and upper right corner of all moving parts, plane axes [m]."""
        paths = (self._path(name) for name in self.system.points)
        places = np.concatenate([self.bodies, *paths, *self._rails().values()])
        return places.min(axis=0), places.max(axis=0)

    def draw(self) -> str:
        """Draw all surroundings; return the text of the scale, whose label is at `SCALE`."""
        for joint in self.system.joints.values():
            if "world" in (joint.parent, joint.child):
                self._ground(joint)
        every = 1 + len(self.assessment.run.time) // _PATH_POINTS
        paths = [self._path(name)[::every] for name in asked_points(self.assessment.system.settings.outputs)]
        mark = [int(MARK[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
        self._lines("paths", paths, Rgba(*mark, 0.8))
        return self._scale()

    def _ground(self, joint: SystemJoint) -> None:
        """Mark a joint on the ground: a pivot on a support for a revolute joint, a rail for a prismatic one."""
        size, normal = self.size, np.array([0.0, -1.0])
        if joint.type == "revolute":
            foot = self.basis[:, :2].T @ joint.position
            wide, high = _STAND[0] * size, _STAND[1] * size
            corners = foot + np.array([[0.0, 0.0], [-wide, -high], [wide, -high], [0.0, 0.0]])
            self._lines(f"{joint.name}/stand", [corners], GROUND)
            ends = foot + np.array([[-1.6 * wide, -high], [1.6 * wide, -high]])
            shape, position = Cylinder(0.012 * size, 0.03 * size), joint.position
        elif joint.type == "prismatic":
            start, end = self._rails()[joint.name]
            shape = Box(float(np.linalg.norm(end - start)), 0.004 * size, 0.004 * size)
            depth = self.basis[:, 2] @ joint.position
            position = self.basis @ np.append(0.5 * (start + end), depth)
            normal = below(joint.direction)
            ends = np.array([start, end]) + _RAIL * size * normal
        else:
            return
        pose = RigidTransform(RotationMatrix(joint_axes(self.basis, joint)), position)
        self.meshcat.SetObject(f"/ground/{joint.name}/joint", shape, GROUND)
        self.meshcat.SetTransform(f"/ground/{joint.name}/joint", pose)
        step = _HATCH * size
        self._lines(f"{joint.name}/hatching", [ends, *hatched(ends, normal, step, 0.8 * step)], GROUND)

    def _scale(self) -> str:
        """Draw a scale below the linkage, a length with one digit."""
        low, high = self.span()
        wide = max(high[0] - low[0], self.size)
        length, text = round_length(0.3 * wide)
        tick = 0.012 * wide
        left = np.array([low[0], low[1] - 0.14 * max(wide, high[1] - low[1])])
        ends = left + np.array([[0.0, 0.0], [length, 0.0]])
        ticks = [end + tick * np.array([[0.0, -1.0], [0.0, 1.0]]) for end in ends]
        self._lines("scale", [ends, *ticks], GROUND)
        at = ends.mean(axis=0) + np.array([0.0, 0.5 * tick])
        self.meshcat.SetTransform(SCALE, RigidTransform(self.basis[:, :2] @ at))
        return text

    def _lines(self, part: str, lines: Sequence[Array], color: Rgba) -> None:
        """Draw lines, each through points (n, 2) in plane axes [m], as ribbons."""
        quads = [_ribbon(line, _LINE * self.size) for line in lines]
        corners = np.concatenate([np.empty((0, 2)), *quads])
        if not len(corners):
            return
        first = 4 * np.arange(len(corners) // 4, dtype=np.int32)[:, None]
        faces = np.concatenate([first + corner for corner in np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)])
        vertices = self.basis[:, :2] @ corners.T + self.basis[:, 2:] * self.depth
        self.meshcat.SetTriangleMesh(f"/ground/{part}", vertices, faces.T, color)

    def _path(self, name: str) -> Array:
        """Return the positions (n, 2) of a link or frame over the run, plane axes [m]."""
        return np.column_stack([self.assessment.run[f"{name}.x"], self.assessment.run[f"{name}.y"]])

    def _rails(self) -> dict[str, Array]:
        """Find the ends (2, 2) of each rail on the ground [m]: the stroke of a prismatic joint, extended."""
        result = {}
        for joint in self.system.joints.values():
            if joint.type == "prismatic" and "world" in (joint.parent, joint.child):
                block, at = joint.child, joint.on_child
                if block == "world":
                    block, at = joint.parent, joint.on_parent
                travel = (self._path(block) - self.system.links[block].origin) @ joint.direction
                margin = 0.2 * np.ptp(travel) + 0.05 * self.size
                reach = [travel.min() - margin, travel.max() + margin]
                result[joint.name] = at + np.outer(reach, joint.direction)
        return result


def _ribbon(line: Array, width: float) -> Array:
    """Return the corners (4 m, 2) of rectangles along the m line segments of nonzero length."""
    start, way = line[:-1], np.diff(line, axis=0)
    length = np.linalg.norm(way, axis=1)
    start, way = start[length > 0.0], way[length > 0.0]
    along = 0.5 * width * way / length[length > 0.0, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    tail, tip = start - along, start + way + along  # longer by half the width, so that segments overlap
    return np.stack([tail - across, tip - across, tip + across, tail + across], axis=1).reshape(-1, 2)
