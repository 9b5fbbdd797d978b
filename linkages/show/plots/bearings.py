"""Figures of a journal bearing under a static load: the usual chart, and the pressure on the developed surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle

from linkages.base.arrays import Array
from linkages.show.plots.shown import new_figure
from linkages.show.plots.style import COLORS, axis_label, engineering, figure_style

if TYPE_CHECKING:
    from linkages.explore.bearing import BearingPoint


def chart_figure(point: BearingPoint, chart: Mapping[str, Array]) -> Figure:
    """Draw a chart over the Sommerfeld number (`linkages.explore.bearing.chart`), and the operating point."""
    content, case = point.content, point.case
    load = case.load * case.clearance
    flow = content["flow"] / (case.clearance * case.radius**2 * case.speed)
    panels = [
        ("eccentricity ratio [-]", chart["eccentricity_ratio"], point.eccentricity_ratio),
        ("attitude [deg]", np.degrees(chart["attitude"]), np.degrees(point.attitude)),
        ("torque/(W c) [-]", chart["friction"], content["friction_torque"] / load),
        ("end flow/(c R² ω) [-]", chart["flow"], flow),
    ]
    with figure_style():
        figure, axes = new_figure(5.2, 2, 2, width=7.2)
        for axis, (label, curve, mark), color in zip(axes.flat, panels, COLORS, strict=False):
            axis.semilogx(chart["sommerfeld"], curve, color=color)
            axis.plot(point.sommerfeld, mark, "o", color="k", ms=5, label="operating point")
            axis.set(xlabel="Sommerfeld number μ N D L/W (R/c)² [-]", ylabel=label)
        axes[0, 0].legend(fontsize=8)
        axes[1, 0].set_yscale("log")
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
                middle = np.array([np.degrees(groove.angle + turn), groove.position * long * case.length])
                size = np.array([np.degrees(groove.extent), groove.length * long * case.length])
                look: dict[str, Any] = {"fill": False, "ec": "r", "lw": 1.4}
                corner = tuple(middle - 0.5 * size)
                outline = Ellipse(tuple(middle), *size, **look) if groove.hole else Rectangle(corner, *size, **look)
                axis.add_patch(outline)
        axis.plot(np.degrees(point.attitude), 0.0, "v", color=COLORS[1], label="least film")
        axis.set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 60))
        axis.set(xlabel="angle from the load, in the sense of rotation [deg]", ylabel=axis_label("z", length))
        parts = {"hatched: cavity": content.min() < 1.0, "red: groove": len(case.grooves) > 0}
        axis.set_title("; ".join(text for text, drawn in parts.items() if drawn), loc="left", fontsize=8)
        axis.legend(fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
        return figure
