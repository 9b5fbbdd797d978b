"""The robot as lines, at rest and deformed; a mode vibrating over the moving robot, as one HTML file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.palette import INK, SOFT
from linkages.mechanics.flexible.rotation import rotations
from linkages.show.plots.lines import modes_page
from linkages.three_rrr.analysis import RobotResults
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.kinematics import RobotMotion, pivots, unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes


OUTLINE = SOFT
_POINTS = 13  # number of drawn points of each element
_FRAMES = 121
_SHARE = 0.1  # drawn deflection over the coupler's length
_EVERY = 2  # step between kept points of a line


def shape_lines(model: FiniteElementModel, state: RobotMotion, index: int, shape: Array) -> list[tuple[Array, str]]:
    """Return lines of the robot deformed by a shape (size,) of its unknowns, magnified."""
    one = state.part(slice(index, index + 1))
    rest, moved = displaced_lines(model, one), _deflections(model, one, shape, 1)
    return [(line + part, name) for (line, name), part in zip(rest, moved, strict=True)]


def _deflections(model: FiniteElementModel, one: RobotMotion, shape: Array, every: int) -> list[Array]:
    """Return the displacements of the lines at a single pose, of every n-th point, with the same largest one [m]."""
    full = model.expand(one, shape[None])[0]
    lines = (_points(displaced_lines(model, one, part), every) for part in (full, None))
    moved = [line - rest for line, rest in zip(*lines, strict=True)]
    largest = max(float(np.max(np.linalg.norm(line, axis=1))) for line in moved)
    return [_SHARE * float(np.max(model.geometry.coupler)) / largest * line for line in moved]


def displaced_lines(model: FiniteElementModel, one: RobotMotion, full: Array | None = None) -> list[tuple[Array, str]]:
    """Return lines (n, 2) [m] of links and platform at a single pose, with displacements (full,) [m, rad], by name."""
    full = np.zeros(model.full) if full is None else full
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
    for line, name in displaced_lines(model, state.part(slice(index, index + 1))):
        width = 1.2 if name == "platform" else 1.6
        axis.plot(*(1e3 * line.T), color=color, lw=width, **style)
    b, c = pivots(model.geometry, state.phi[index : index + 1], state.x[index : index + 1])
    joints = np.vstack([model.geometry.base, b[0], c[0]])
    axis.plot(*(1e3 * joints.T), "o", color=color, ms=2.5, **style)
    axis.plot(*(1e3 * model.geometry.base.T), "^", color=INK, ms=4)


def write_animation(results: RobotResults, path: Path) -> Path:
    """Write the animation; return its path."""
    title = f"{results.robot.title or 'Flexible robot'}: modes"
    path.write_text(modes_page(title, animation_data(results)), encoding="utf-8")
    return path


def animation_data(results: RobotResults) -> dict[str, Any]:
    """Return undeformed lines and their displacement in each mode, by frame [mm].

    The modes are followed by MAC, with continuous signs, and each shape is scaled to the same largest deflection.
    """
    places = np.unique(np.linspace(0, len(results.motion) - 1, _FRAMES).astype(int))
    frames: list[dict[str, Any]] = []
    for index in places:
        one = results.motion.part(slice(int(index), int(index) + 1))
        still = [_rounded(1e3 * line) for line in _points(displaced_lines(results.model, one), _EVERY)]
        modes = (_deflections(results.model, one, shape, _EVERY) for shape in results.shapes[index].T)
        shapes = [[_rounded(1e3 * line) for line in lines] for lines in modes]
        frames.append({"t": round(float(one.time[0]), 4), "rest": still, "shape": shapes})
    points = np.concatenate([line for frame in frames for line in frame["rest"]])
    return {
        "frames": frames,
        "hz": np.round(results.tracked[places], 2).tolist(),
        "base": _rounded(1e3 * results.model.geometry.base),
        "box": [*np.round(points.min(axis=0) - 60).tolist(), *np.round(points.max(axis=0) + 60).tolist()],
    }


def _points(lines: list[tuple[Array, str]], every: int) -> list[Array]:
    return [line if name == "platform" else line[::every] for line, name in lines]


def _rounded(points: Array) -> list[list[float]]:
    return np.round(points, 1).tolist()
