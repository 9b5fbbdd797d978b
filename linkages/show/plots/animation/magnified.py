"""Common part of the magnified joint views: positions in a Meshcat scene, arrows, and the instant that a frame shows.

Contacts are much shorter than a frame; therefore each frame shows the instant of its largest force. The length of an
arrow grows with the square root of the force, because impacts are hundreds of times harder than the forces between
them.
"""

from __future__ import annotations

import numpy as np
from pydrake.geometry import Box, Cylinder, Meshcat, MeshcatCone, Rgba, Shape
from pydrake.math import RigidTransform, RotationMatrix

from linkages.base.arrays import Array
from linkages.input.files.magnitudes import rounded
from linkages.results.assessment import Assessment
from linkages.show.plots.instants import GAP
from linkages.system.joints import SystemJoint

REACH = 1.3  # length of the longest arrow over the view's radius
_HEAD = 0.28  # length of an arrow's head over the view's radius

WALL, BODY, GROUND = Rgba(0.78, 0.80, 0.83, 1.0), Rgba(0.62, 0.66, 0.72, 1.0), Rgba(0.25, 0.25, 0.25, 1.0)
FLOOR, DARK = Rgba(1.0, 1.0, 1.0, 1.0), Rgba(0.15, 0.15, 0.15, 1.0)
_FORCE, _TOUCH = Rgba(0.84, 0.37, 0.0, 1.0), Rgba(0.95, 0.85, 0.1, 1.0)


def joint_axes(basis: Array, joint: SystemJoint) -> Array:
    """Return the axes (3, 3) of a joint's view in the world: the plane's; for a prismatic joint x is its axis."""
    if joint.type != "prismatic":
        return basis
    along = basis[:, :2] @ joint.direction
    return np.column_stack([along, np.cross(basis[:, 2], along), basis[:, 2]])


class MagnifiedView:
    """A magnified view of a joint around a centre (2,) in the plane [m], half its size the radius [m]."""

    def __init__(self, meshcat: Meshcat, assessment: Assessment, name: str, centre: Array, radius: float) -> None:
        self.meshcat, self.name, self.path = meshcat, name, f"/joints/{name}"
        self.centre, self.radius = centre, radius
        self.clearance = assessment.system.joints[name].clearance or 0.0
        self.largest = float(assessment.run[f"{name}.force"].max())
        basis = assessment.system.basis
        axes = joint_axes(basis, assessment.system.joints[name])
        meshcat.SetTransform(self.path, RigidTransform(RotationMatrix(axes), basis[:, :2] @ centre))

    @property
    def scales(self) -> str:
        """Return the magnification, and the force of the longest arrow."""
        factor = rounded(GAP * self.radius / self.clearance)
        return f"{factor} times, longest arrow {rounded(self.largest)}\u00a0N"

    def put(self, part: str, shape: Shape, color: Rgba, position: list[float], along_x: bool = False) -> None:
        """Draw a shape, in units of the radius; with `along_x` its z axis points along -x."""
        path = f"{self.path}/{part}/shape"
        turned = RotationMatrix.MakeYRotation(-np.pi / 2) if along_x else RotationMatrix()
        self.meshcat.SetObject(path, shape, color)
        self.meshcat.SetTransform(path, RigidTransform(turned, self.radius * np.array(position)))

    def box(self, part: str, sides: tuple[float, float, float], color: Rgba, position: list[float]) -> None:
        """Draw a box, in units of the radius."""
        self.put(part, Box(*(self.radius * side for side in sides)), color, position)

    def disc(self, part: str, radius: float, color: Rgba, position: list[float]) -> None:
        """Draw a flat disc, in units of the radius."""
        self.put(part, Cylinder(self.radius * radius, 0.01 * self.radius), color, position)

    def line(self, part: str, points: Array, height: float, color: Rgba) -> None:
        """Draw a line through points (2, n) at a height above the plane, in units of the radius."""
        vertices = self.radius * np.vstack([points, np.full(points.shape[1], height)])
        self.meshcat.SetLine(f"{self.path}/{part}", np.asfortranarray(vertices), 2.0, color)

    def place(self, part: str, position: Array, angle: float, time: float) -> None:
        """Record the position of a part, in units of the radius."""
        pose = RigidTransform(RotationMatrix.MakeZRotation(angle), self.radius * np.array([*position, 0.0]))
        self.meshcat.SetTransform(f"{self.path}/{part}", pose, time)

    def draw_arrow(self) -> None:
        """Draw an arrow along x from its origin; `show_arrow` sets its length."""
        self.box("arrow/shaft", (1.0, 0.1, 0.02), _FORCE, [0.5, 0.0, 0.1])
        head = MeshcatCone(*(self.radius * side for side in (_HEAD, 0.03, 0.14)))
        self.put("arrow/head", head, _FORCE, [0.0, 0.0, 0.1], along_x=True)

    def show_arrow(self, start: Array, force: Array, time: float) -> None:
        """Record the arrow from `start`, in units of the radius, along a force (2,) [N]."""
        share = float(np.linalg.norm(force)) / self.largest if self.largest > 0.0 else 0.0
        length = REACH * np.sqrt(share)
        head = min(_HEAD, length)
        wide = max(0.5, head / _HEAD) if share > 0.0 else 0.0
        self.place("arrow", start, float(np.arctan2(force[1], force[0])), time)
        self._scale("arrow/shaft", length - head, 1.0, time)
        self._scale("arrow/head", head / _HEAD, wide, time)
        self.place("arrow/head", np.array([length, 0.0]), 0.0, time)

    def draw_spot(self, part: str, position: list[float]) -> None:
        """Draw the spot of a contact, in units of the radius; `show_spot` shows and hides it."""
        self.disc(f"{part}/rim", 0.11, DARK, [*position, 0.12])
        self.disc(f"{part}/spot", 0.08, _TOUCH, [*position, 0.13])

    def show_spot(self, part: str, touches: bool, time: float) -> None:
        """Record whether a contact is closed."""
        self.meshcat.SetProperty(f"{self.path}/{part}", "visible", bool(touches), time)

    def set_label(self, height: float) -> None:
        """Set the anchor of the label at a height above the centre, in units of the radius."""
        self.meshcat.SetTransform(f"{self.path}/label", RigidTransform([0.0, height * self.radius, 0.0]))

    def _scale(self, part: str, along: float, across: float, time: float) -> None:
        scale = [max(along, 1e-6), max(across, 1e-6), 1.0]  # a scale of zero has no inverse
        self.meshcat.SetProperty(f"{self.path}/{part}", "scale", scale, time)
