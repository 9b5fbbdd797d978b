"""A mode vibrating over the moving robot, as one HTML file that needs no network."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from linkages.arrays import Array
from linkages.plots.pages import embedded, filled, own_text
from linkages.plots.style import COLORS
from linkages.plots.three_rrr.robot_lines import displaced_lines
from linkages.three_rrr.analysis import RobotResults

_FRAMES = 121
_SHARE = 0.1  # drawn deflection over the coupler's length
_EVERY = 2  # step between kept points of a line


def write_animation(results: RobotResults, path: Path) -> Path:
    """Write the animation; return its path."""
    values = {"colors": embedded(COLORS), "data": embedded(animation_data(results))}
    text = own_text("linkages.plots.three_rrr", "animation.html")
    path.write_text(filled(text, title=results.robot.title or "Flexible robot", **values), encoding="utf-8")
    return path


def animation_data(results: RobotResults) -> dict[str, Any]:
    """Return undeformed lines and their displacement in each mode, by frame [mm].

    The modes are followed by MAC, with continuous signs, and each shape is scaled to the same largest deflection.
    """
    places = np.unique(np.linspace(0, len(results.motion) - 1, _FRAMES).astype(int))
    size = _SHARE * float(np.max(results.model.geometry.coupler))
    frames: list[dict[str, Any]] = []
    for index in places:
        one = results.motion.part(slice(int(index), int(index) + 1))
        rest = _points(displaced_lines(results.model, one, np.zeros(results.model.full)))
        shapes = []
        for mode in range(results.tracked.shape[1]):
            full = results.model.expand(one, results.shapes[index, :, mode][None])[0]
            lines = _points(displaced_lines(results.model, one, full))
            moved = [a - b for a, b in zip(lines, rest, strict=True)]
            largest = max(float(np.max(np.linalg.norm(line, axis=1))) for line in moved)
            shapes.append([_rounded(1e3 * size / largest * line) for line in moved])
        still = [_rounded(1e3 * line) for line in rest]
        frames.append({"t": round(float(one.time[0]), 4), "rest": still, "shape": shapes})
    points = np.concatenate([line for frame in frames for line in frame["rest"]])
    return {
        "frames": frames,
        "hz": np.round(results.tracked[places], 2).tolist(),
        "base": _rounded(1e3 * results.model.geometry.base),
        "box": [*np.round(points.min(axis=0) - 60).tolist(), *np.round(points.max(axis=0) + 60).tolist()],
    }


def _points(lines: list[tuple[Array, str]]) -> list[Array]:
    return [line if name == "platform" else line[::_EVERY] for line, name in lines]


def _rounded(points: Array) -> list[list[float]]:
    return np.round(points, 1).tolist()
