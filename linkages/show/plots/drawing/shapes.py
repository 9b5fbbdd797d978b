"""Shapes of a drawing: points fixed to bodies, and styles by the role of a shape.

A point is a row (body, x, y, dx, dy): a position in the body's frame, and an offset in plane axes that does not rotate
with the body, both in metres. Later shapes are drawn above earlier ones.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.palette import GROUND, INK, LIMIT, LINE, MARK, MEASURED, PAPER, PLAY, SOFT

DrawnPoint = tuple[float, float, float, float, float]

LOAD = LIMIT  # loads and friction


class Style(NamedTuple):
    """The style of a shape; lengths in units of the drawing, a hundredth of its width.

    `kind` is "line", "area", "circle" or "text"; an empty colour means the shape's colour.
    """

    kind: str
    stroke: str | None = None
    width: float = 0.0
    fill: str | None = None
    opacity: float = 1.0
    radius: float = 0.0
    dash: float = 0.0
    size: float = 0.0
    bold: bool = False


STYLES = {
    "path": Style("line", MARK, 0.16, dash=0.5),
    "plate": Style("area", fill="", opacity=0.3),
    "bar": Style("line", "", 1.3),
    "rail": Style("line", GROUND, 0.5),
    "slot": Style("line", "", 0.6),
    "block": Style("area", INK, 0.2, ""),
    "ground": Style("area", INK, 0.2, LINE),
    "hatch": Style("line", INK, 0.14),
    "spring": Style("line", MEASURED, 0.35, dash=0.6),
    "bearing": Style("circle", INK, 0.2, PAPER, radius=1.35),
    "play": Style("circle", PLAY, 0.35, PAPER, radius=1.35),
    "pin": Style("circle", INK, 0.22, PAPER, radius=0.75),
    "fixed": Style("circle", INK, 0.22, INK, radius=0.55),
    "centre": Style("circle", INK, 0.14, "", radius=0.36),
    "point": Style("circle", MARK, 0.22, PAPER, radius=0.42),
    "gap": Style("line", LIMIT, 0.3, dash=0.4),
    "pitch line": Style("line", SOFT, 0.25, dash=0.8),
    "ring": Style("circle", LOAD, 0.45, radius=1.9),
    "drive": Style("line", INK, 0.25),
    "drive head": Style("area", fill=INK),
    "load": Style("line", LOAD, 0.35),
    "load head": Style("area", fill=LOAD),
    "scale": Style("line", INK, 0.25),
    "joint name": Style("text", fill=INK, size=2.1, bold=True),
    "link name": Style("text", fill=INK, size=1.8),
    "link mark": Style("line", "", 0.45),
    "load name": Style("text", fill=LOAD, size=1.7),
    "point name": Style("text", fill=MARK, size=1.7),
    "note": Style("text", fill=INK, size=1.7),
}


@dataclass(frozen=True)
class Shape:
    """A line, an area, a circle or a text."""

    role: str  # key of `STYLES`
    at: Array  # (n, 5) points of the shape; a circle or text has one
    color: str = INK  # colour for styles without a colour
    text: str = ""


def shape(role: str, points: Iterable[DrawnPoint], color: str = INK, text: str = "") -> Shape:
    """Make a shape from points."""
    return Shape(role, np.array(list(points), dtype=np.float64), color, text)


def below(direction: Array) -> Array:
    """Return the normal (2,) of a line with a direction, downwards."""
    normal = np.array([direction[1], -direction[0]])
    return normal if normal[1] <= 0.0 else -normal


def hatched(ends: Array, normal: Array, step: float, size: float) -> list[Array]:
    """Return the lines (2, 2) of a hatching on one side of a line, at a distance from each other, and of a size."""
    length = float(np.linalg.norm(ends[1] - ends[0]))
    along = (ends[1] - ends[0]) / length
    feet = ends[0] + np.outer(np.arange(0.5 * step, length, step), along)
    return [np.array([foot, foot + size * (normal - 0.8 * along)]) for foot in feet]


def placed(at: Array, pose: Array) -> Array:
    """Compute positions of points (n, 5) on bodies at `pose` (nb, 3 or more: x, y, angle): plane axes (n, 2) [m]."""
    body = at[:, 0].astype(int)
    cosine, sine = np.cos(pose[body, 2]), np.sin(pose[body, 2])
    x, y = at[:, 1], at[:, 2]
    turned = np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
    return np.asarray(pose[body, :2] + turned + at[:, 3:], dtype=np.float64)
