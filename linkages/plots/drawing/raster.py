"""A drawing as a matplotlib figure: PNG, and a moving GIF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.patheffects import withStroke

from linkages.arrays import Array
from linkages.plots.drawing.drawing import Drawing, draw
from linkages.plots.drawing.shapes import STYLES, Shape, placed
from linkages.plots.drawing.svg import notes
from linkages.plots.shown import ShownFigure
from linkages.system import System

_WIDTH = 8.0  # width of the figure [inches]
_LINE = 0.17  # line height of text [inches]


def pose(system: System) -> Figure:
    """Draw the mechanism of a system with ideal joints at its start: links, joints, drives, loads and paths of outputs.

    Examples
    --------
    >>> import linkages
    >>> from linkages.plots import pose
    >>> figure = pose(linkages.load(linkages.find_file("four_bar_dry.toml")))
    >>> figure.savefig("four_bar.png")  # doctest: +SKIP
    """
    return picture(draw(system), said=False)


def picture(drawing: Drawing, said: bool = True) -> Figure:
    """Draw the mechanism at its start, with `said` also its properties below."""
    lines = notes(drawing) if said else []
    below = _LINE * (len(lines) + 0.7) if lines else 0.0
    figure, axis = _paper(drawing, below)
    for one in drawing.shapes:
        _put(axis, drawing, one, drawing.pose)
    whole = float(figure.get_size_inches()[1])
    for k, (text, color) in enumerate(lines):
        weight = "bold" if k == 0 else "normal"
        figure.text(0.015, (below - _LINE * (k + 0.9)) / whole, text, color=color, fontsize=8.2, weight=weight)
    return figure


def write_moving(drawing: Drawing, path: Path, frames: int = 60, dpi: float = 90.0) -> None:
    """Write a GIF of the mechanism, moved by its first drive.

    Parameters
    ----------
    drawing : Drawing
        Drawing of a movable mechanism.
    path : Path
    frames : int
        Number of frames of one revolution, or of one stroke forth and back.
    dpi : float
        Pixels per inch; the picture is 8 inches wide.
    """
    way = drawing.sliders[0]
    count = len(way.poses)
    full = np.allclose(way.poses[0, :, :2], way.poses[-1, :, :2], atol=1e-6 * 100.0 * drawing.unit)
    turn = np.linspace(0.0, 1.0, frames, endpoint=False)
    part = turn if full else 0.5 - 0.5 * np.cos(2.0 * np.pi * turn)
    poses = way.poses[(part * (count - 1)).round().astype(int)]
    figure, axis = _paper(drawing, 0.0)

    def show(pose: Array) -> list[Any]:
        axis.clear()
        _clean(axis, drawing)
        for one in drawing.shapes:
            _put(axis, drawing, one, pose)
        return []

    FuncAnimation(figure, show, poses, blit=False).save(path, PillowWriter(fps=20), dpi=dpi)


def _paper(drawing: Drawing, below: float) -> tuple[Figure, Axes]:
    """Make a figure with an axis of the drawing's size above `below` inches."""
    wide, high = drawing.high - drawing.low
    height = _WIDTH * high / wide
    figure = ShownFigure(figsize=(_WIDTH, height + below), dpi=150)
    axis = figure.add_axes((0.0, below / (height + below), 1.0, height / (height + below)))
    _clean(axis, drawing)
    return figure, axis


def _clean(axis: Axes, drawing: Drawing) -> None:
    axis.set(xlim=(drawing.low[0], drawing.high[0]), ylim=(drawing.low[1], drawing.high[1]))
    axis.set_axis_off()


def _put(axis: Axes, drawing: Drawing, one: Shape, pose: Array) -> None:
    style, points = STYLES[one.role], placed(one.at, pose)
    dots = 72.0 * _WIDTH / 100.0  # points per unit
    fill, stroke = ("none" if named is None else named or one.color for named in (style.fill, style.stroke))
    line: dict[str, Any] = {"linewidth": style.width * dots, "capstyle": "round", "joinstyle": "round", "zorder": 2}
    if style.kind == "text":
        weight = "bold" if style.bold else "normal"
        where: dict[str, Any] = {
            "ha": "center",
            "va": "center",
            "clip_on": True,
            "path_effects": [withStroke(linewidth=2.0, foreground="#FFFFFF")],
        }
        axis.text(points[0, 0], points[0, 1], one.text, color=fill, fontsize=style.size * dots, weight=weight, **where)
    elif style.kind == "circle":
        axis.add_patch(Circle(tuple(points[0]), style.radius * drawing.unit, fc=fill, ec=stroke, **line))
    elif style.kind == "area":
        axis.add_patch(Polygon(points, closed=True, fc=fill, ec=stroke, alpha=style.opacity, **line))
    else:
        dash = (0, (style.dash / style.width,) * 2) if style.dash else "-"
        open_line = Polygon(points, closed=False, fc="none", ec=stroke, linestyle=dash, **line)
        axis.add_patch(open_line)
