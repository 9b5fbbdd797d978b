"""A drawing as a matplotlib figure."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.patheffects import withStroke

from linkages.base.arrays import Array
from linkages.base.palette import PAPER
from linkages.show.plots.drawing.drawing import Drawing, draw
from linkages.show.plots.drawing.shapes import STYLES, Shape, placed
from linkages.show.plots.drawing.svg import notes
from linkages.show.plots.shown import ShownFigure
from linkages.system import System

_WIDTH = 8.0  # width of the figure [inches]
_LINE = 0.17  # line height of text [inches]


def pose(system: System) -> Figure:
    """Draw the mechanism of a system with ideal joints at its start: links, joints, drives, loads and paths of outputs.

    Examples
    --------
    >>> import linkages
    >>> from linkages.show.plots import pose
    >>> figure = pose(linkages.load(linkages.find_file("four_bar_dry.toml")))
    >>> figure.savefig("four_bar.png")  # doctest: +SKIP
    """
    return picture(draw(system), said=False)


def picture(drawing: Drawing, said: bool = True, pose: Array | None = None) -> Figure:
    """Draw the mechanism in a pose (default: its start), with `said` also its properties below."""
    lines = notes(drawing) if said else []
    below = _LINE * (len(lines) + 0.7) if lines else 0.0
    wide, high = drawing.high - drawing.low
    whole = _WIDTH * float(high / wide) + below
    figure = ShownFigure(figsize=(_WIDTH, whole), dpi=150)
    axis = figure.add_axes((0.0, below / whole, 1.0, 1.0 - below / whole))
    axis.set(xlim=(drawing.low[0], drawing.high[0]), ylim=(drawing.low[1], drawing.high[1]))
    axis.set_axis_off()
    put_shapes(axis, drawing, drawing.pose if pose is None else pose)
    for k, (text, color) in enumerate(lines):
        weight = "bold" if k == 0 else "normal"
        figure.text(0.015, (below - _LINE * (k + 0.9)) / whole, text, color=color, fontsize=8.2, weight=weight)
    return figure


def put_shapes(axis: Axes, drawing: Drawing, pose: Array) -> None:
    """Draw all shapes in a pose."""
    for one in drawing.shapes:
        _put(axis, drawing, one, pose)


def _put(axis: Axes, drawing: Drawing, one: Shape, pose: Array) -> None:
    style, points = STYLES[one.role], placed(one.at, pose)
    dots = 72.0 * _WIDTH / 100.0  # points per unit
    fill, stroke = ("none" if named is None else named or one.color for named in (style.fill, style.stroke))
    line: dict[str, Any] = {"linewidth": style.width * dots, "capstyle": "round", "joinstyle": "round", "zorder": 2}
    if style.kind == "text":
        weight = "bold" if style.bold else "normal"
        halo = [withStroke(linewidth=2.0, foreground=PAPER)]
        where: dict[str, Any] = {"ha": "center", "va": "center", "clip_on": True, "path_effects": halo}
        axis.text(points[0, 0], points[0, 1], one.text, color=fill, fontsize=style.size * dots, weight=weight, **where)
    elif style.kind == "circle":
        axis.add_artist(Circle(tuple(points[0]), style.radius * drawing.unit, fc=fill, ec=stroke, **line))
    elif style.kind == "area":
        axis.add_artist(Polygon(points, closed=True, fc=fill, ec=stroke, alpha=style.opacity, **line))
    else:
        dash = (0, (style.dash / style.width,) * 2) if style.dash else "-"
        axis.add_artist(Polygon(points, closed=False, fc="none", ec=stroke, linestyle=dash, **line))
