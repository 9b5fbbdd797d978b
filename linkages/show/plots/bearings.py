"""Figures of a journal bearing under a static load: the usual chart, and the pressure on the developed surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle

from linkages.base.arrays import Array
from linkages.show.plots.shown import ShownFigure, new_figure
from linkages.show.plots.style import COLORS, axis_label, engineering, figure_style

if TYPE_CHECKING:
    from linkages.explore.bearing import BearingPoint
    from linkages.laws.film.surface.grooves import Groove


def chart_figure(point: BearingPoint, chart: Mapping[str, Array]) -> Figure:
    """Draw a chart over the Sommerfeld number (`linkages.explore.bearing.chart`), and the operating point."""
    content, case = point.content, point.case
    load = case.load * case.clearance
    marks = {
        "eccentricity_ratio": point.eccentricity_ratio,
        "attitude": np.degrees(point.attitude),
        "friction": content["friction_torque"] / load,
        "flow": content["flow"] / (case.clearance * case.radius**2 * case.speed),
    }
    curves = {**chart, "attitude": np.degrees(chart["attitude"])}
    labels = {
        "eccentricity_ratio": "eccentricity ratio [-]",
        "attitude": "attitude [deg]",
        "friction": "torque/(W c) [-]",
        "flow": "end flow/(c R² ω) [-]",
    }
    with figure_style():
        figure = ShownFigure(figsize=(7.2, 5.2), layout="constrained")
        for axis, (name, label), color in zip(figure.subplots(2, 2).flat, labels.items(), COLORS, strict=False):
            axis.semilogx(curves["sommerfeld"], curves[name], color=color)
            axis.plot(point.sommerfeld, marks[name], "o", color="k", ms=5, label="operating point")
            axis.set(xlabel="Sommerfeld number μ N D L/W (R/c)² [-]", ylabel=label)
            if name == "friction":
                axis.set_yscale("log")
        figure.axes[0].legend(fontsize=8)
        return figure


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
        figure, axis = new_figure(3.4, width=7.2)
        axis.grid(False)
        shades = axis.contourf(np.degrees(theta), long * z * middles, factor * pressure.T, 24, cmap="viridis")
        figure.colorbar(shades, ax=axis, label=axis_label("pressure", unit))
        if content.min() < 1.0:
            axis.contourf(
                np.degrees(theta), long * z * middles, content.T, [-1.0, 1.0 - 1e-9], colors="w", alpha=0.35,
                hatches=["///"],
            )  # fmt: skip
        for groove in case.grooves:
            for turn in (-2.0 * np.pi, 0.0, 2.0 * np.pi):
                axis.add_patch(_outline(groove, turn, long * case.length))
        axis.plot(np.degrees(point.attitude), 0.0, "v", color=COLORS[1], label="least film")
        axis.set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 60))
        axis.set(xlabel="angle from the load, in the sense of rotation [deg]", ylabel=axis_label("z", length))
        parts = {"hatched: cavity": content.min() < 1.0, "red: groove": len(case.grooves) > 0}
        axis.set_title("; ".join(text for text, drawn in parts.items() if drawn), loc="left", fontsize=8)
        axis.legend(fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
        return figure


def _outline(groove: Groove, turn: float, length: float) -> Rectangle | Ellipse:
    middle = np.degrees(groove.angle + turn), groove.position * length
    size = np.degrees(groove.extent), groove.length * length
    if groove.hole:
        return Ellipse(middle, *size, fill=False, ec="r", lw=1.4)
    return Rectangle((middle[0] - 0.5 * size[0], middle[1] - 0.5 * size[1]), *size, fill=False, ec="r", lw=1.4)
