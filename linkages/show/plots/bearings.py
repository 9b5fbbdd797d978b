"""Figures of bearings: the usual chart and the pressure of a film."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle
from matplotlib.patheffects import withStroke
from scipy.interpolate import PchipInterpolator

from linkages.base.arrays import Array
from linkages.base.palette import INK, PAPER, SCALE, SOFT
from linkages.show.plots.panels import legend_below, make_panels, say
from linkages.show.plots.quantities import number, quantity
from linkages.show.plots.style import COLORS, axis_label, engineering, figure_style, small_text

if TYPE_CHECKING:
    from linkages.explore.bearing import BearingPoint

_FINE = 200  # points of a smooth curve


def chart_figure(point: BearingPoint, chart: Mapping[str, Array]) -> Figure:
    """Draw a chart over the Sommerfeld number (`linkages.explore.bearing.chart`), and the operating point."""
    content, case = point.content, point.case
    load = case.load * case.clearance
    flow = content["flow"] / (case.clearance * case.radius**2 * case.speed)
    quantities = [
        ("eccentricity ratio [-]", chart["eccentricity_ratio"], point.eccentricity_ratio),
        ("attitude [deg]", np.degrees(chart["attitude"]), np.degrees(point.attitude)),
        ("torque/(W c) [-]", chart["friction"], content["friction_torque"] / load),
        ("end flow/(c R² ω) [-]", chart["flow"], flow),
    ]
    with figure_style():
        figure, axes = make_panels(len(quantities), 2.3)
        for axis, (label, values, mark) in zip(axes, quantities, strict=True):
            axis.set_xscale("log")
            axis.set_yscale("log" if "torque" in label else "linear")
            axis.plot(*_smooth(chart["sommerfeld"], values), color=COLORS[0])
            axis.plot(chart["sommerfeld"], values, ".", color=COLORS[0], ms=3)
            _guide(axis, point.sommerfeld, mark)
            axis.set(xlabel="Sommerfeld number μ N D L/W (R/c)² [-]", ylabel=label)
        say(figure, settled(content))
        return figure


def settled(content: Mapping[str, Any]) -> str:
    """Tell where a journal settles and how much oil remains, from the content of ``bearing.json``."""
    ratio, film = number(content["eccentricity_ratio"], 3), quantity(content["least_film"], "m")
    return f"The journal settles at {ratio} of the clearance from the centre; {film} of oil remain"


def _smooth(x: Array, y: Array) -> tuple[Array, Array]:
    """Return a smooth monotone curve through computed points over the logarithm of x."""
    order = np.argsort(x)
    curve = PchipInterpolator(np.log(x[order]), y[order])
    fine = np.linspace(np.log(x.min()), np.log(x.max()), _FINE)
    return np.exp(fine), curve(fine)


def _guide(axis: Axes, x: float, y: float) -> None:
    """Mark the operating point, with lines to both axes and its value."""
    (left, _), (low, _) = axis.get_xlim(), axis.get_ylim()
    axis.plot([left, x, x], [y, y, low], color=SOFT, lw=0.8, ls="--", zorder=1)
    axis.plot(x, y, "o", color=INK, ms=5, zorder=3)
    axis.set(xlim=(left, None), ylim=(low, None))
    axis.annotate(number(y, 3), (left, y), (3.0, 2.0), textcoords="offset points", color=INK, fontsize=small_text())


def pressure_figure(point: BearingPoint) -> Figure:
    """Draw gauge pressure and cavity on the developed surface; angles from the load, in the sense of rotation."""
    film, case = point.film, point.case
    if film is None:
        raise ValueError("a film in closed form has no field of pressure")
    mesh = film.mesh
    pressure, content, ends = film.pressure * case.pressure_unit, film.content, mesh.ends
    if mesh.half:
        pressure, content = (np.hstack([field[:, ::-1], field]) for field in (pressure, content))
        ends = np.concatenate([-ends[:0:-1], ends])
    shift = int(np.argmin(np.abs(np.remainder(mesh.theta + np.pi, 2.0 * np.pi))))
    theta = np.remainder(np.roll(mesh.theta, -shift) + np.pi, 2.0 * np.pi) - np.pi
    middles, z = 0.5 * (ends[1:] + ends[:-1]), case.radius
    pressure, content = np.roll(pressure, -shift, axis=0), np.roll(content, -shift, axis=0)
    unit, factor = engineering("Pa", float(np.abs(pressure).max()))
    length, long = engineering("m", 0.5 * case.length)
    with figure_style():
        figure, (axis,) = make_panels(1, 2.9)
        axis.grid(False)
        shades = axis.contourf(np.degrees(theta), long * z * middles, factor * pressure.T, 24, cmap=SCALE)
        figure.colorbar(shades, ax=axis, label=axis_label("pressure", unit))
        marks = {"hatched: the gap is not full": content.min() < 1.0, "outlined: groove": len(case.grooves) > 0}
        most = quantity(point.content["largest_pressure"], "Pa")
        say(figure, "; ".join([f"Largest pressure: {most}", *(mark for mark, drawn in marks.items() if drawn)]))
        if content.min() < 1.0:
            axis.contourf(
                np.degrees(theta), long * z * middles, content.T, [-1.0, 1.0 - 1e-9], colors=PAPER, alpha=0.35,
                hatches=["///"],
            )  # fmt: skip
        halo = withStroke(linewidth=3.0, foreground=PAPER)
        for groove in case.grooves:
            for turn in (-2.0 * np.pi, 0.0, 2.0 * np.pi):
                middle = np.array([np.degrees(groove.angle + turn), groove.position * long * case.length])
                size = np.array([np.degrees(groove.extent), groove.length * long * case.length])
                edge: dict[str, Any] = {"fill": False, "ec": INK, "lw": 1.4, "path_effects": [halo]}
                corner = tuple(middle - 0.5 * size)
                outline = Ellipse(tuple(middle), *size, **edge) if groove.hole else Rectangle(corner, *size, **edge)
                axis.add_patch(outline)
        axis.plot(np.degrees(point.attitude), 0.0, "v", color=INK, mec=PAPER, ms=8, label="least film")
        axis.set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 60))
        axis.set(xlabel="angle from the load, in the sense of rotation [deg]", ylabel=axis_label("z", length))
        legend_below(figure)
        return figure
