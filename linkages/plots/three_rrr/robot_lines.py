"""The robot as lines, at rest and deformed; shared by figures and animation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.arrays import Array
from linkages.flexible.rotation import rotations
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import RobotMotion, pivots, unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes


OUTLINE = "0.35"
_SHARE = 0.12  # largest drawn deflection over the robot's size
_POINTS = 13  # number of drawn points of each element


def rest_lines(model: FiniteElementModel, state: RobotMotion, index: int) -> list[tuple[Array, str]]:
    """Return lines (n, 2) [m] of the undeformed links and the platform at one pose, with their names."""
    return displaced_lines(model, state.part(slice(index, index + 1)), np.zeros(model.full))


def shape_lines(model: FiniteElementModel, state: RobotMotion, index: int, shape: Array) -> list[tuple[Array, str]]:
    """Return lines of the robot deformed by a shape (size,) of its unknowns, magnified."""
    one = state.part(slice(index, index + 1))
    full = model.expand(one, shape[None])[0]
    still = displaced_lines(model, one, np.zeros(model.full))
    pairs = zip(displaced_lines(model, one, full), still, strict=True)
    largest = max(float(np.max(np.linalg.norm(a - b, axis=1))) for (a, _), (b, _) in pairs)
    scale = _SHARE * float(np.max(model.geometry.coupler)) / largest
    return displaced_lines(model, one, scale * full)


def displaced_lines(model: FiniteElementModel, one: RobotMotion, full: Array) -> list[tuple[Array, str]]:
    """Return lines of the robot at a single pose with displacements (full,) [m, rad]."""
    b, c = pivots(model.geometry, one.phi, one.x)
    angle = one.angles
    lines = []
    s = np.linspace(0.0, 1.0, _POINTS)
    for link in model.links:
        leg, coupler = divmod(link.angle, 2)
        start = b[0, leg] if coupler else model.geometry.base[leg]
        rotation = rotations(angle[:, link.angle])
        local = link.gather(full[None], rotation)[0]
        shapes = link.beam.shapes(s)[0]
        moved = np.einsum("nci,ei->enc", shapes, local) @ rotation[0, :2, :2]
        along = (np.arange(len(link.dofs))[:, None] + s) * link.beam.length
        points = start + along[..., None] * unit(angle[0, link.angle]) + moved
        lines.append((points.reshape(-1, 2), link.name))
    corners = c[0] + full[model.c]
    lines.append((np.vstack([corners, corners[:1]]), "platform"))
    return lines


def draw_pose(
    axis: Axes, model: FiniteElementModel, state: RobotMotion, index: int, color: str = OUTLINE, **style: Any
) -> None:
    """Draw the undeformed robot, in millimetres."""
    for line, name in rest_lines(model, state, index):
        width = 1.2 if name == "platform" else 1.6
        axis.plot(*(1e3 * line.T), color=color, lw=width, **style)
    b, c = pivots(model.geometry, state.phi[index : index + 1], state.x[index : index + 1])
    joints = np.vstack([model.geometry.base, b[0], c[0]])
    axis.plot(*(1e3 * joints.T), "o", color=color, ms=2.5, **style)
    axis.plot(*(1e3 * model.geometry.base.T), "^", color="0.2", ms=4)
