"""Figures of bearings: the usual chart and the pressure of a film; profiles, clearance and peaks over wear."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle

from linkages.base.arrays import Array
from linkages.base.palette import INK
from linkages.input.files.magnitudes import rounded
from linkages.input.files.writing import file_name
from linkages.show.plots.pages import embedded, filled, own_text
from linkages.show.plots.shown import new_figure
from linkages.show.plots.style import (
    COLORS,
    LEGEND,
    axis_label,
    engineering,
    figure_style,
    stacked_axes,
    typeset,
    write_figure,
)

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
        axes[0, 0].legend(fontsize="small")
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
        axis.plot(np.degrees(point.attitude), 0.0, "v", color=INK, label="least film")
        axis.set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 60))
        axis.set(xlabel="angle from the load, in the sense of rotation [deg]", ylabel=axis_label("z", length))
        parts = {"hatched: cavity": content.min() < 1.0, "red: groove": len(case.grooves) > 0}
        axis.set_title("; ".join(text for text, drawn in parts.items() if drawn), loc="left", fontsize="small")
        axis.legend(fontsize="small", loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
        return figure


SIDES = ("bearing", "journal")
_MOST = 8  # most profiles in one drawing
_RING = 3.0  # radius of the drawn circle over the largest depth


def write_wear_figures(found: Mapping[str, Any], folder: Path) -> None:
    """Write the figure ``wear_JOINT`` of each joint and ``wear_history`` from the content of ``wear.json``."""
    for name in found["joints"]:
        write_figure(profile_figure(found, name), folder / f"wear_{file_name(name)}")
    write_figure(history_figure(found), folder / "wear_history")


def profile_figure(found: Mapping[str, Any], joint: str) -> Figure:
    """Draw the profiles of a joint's parts over the service life: polar with enlarged depths, and unrolled."""
    sides = [side for side in SIDES if side in found["joints"][joint]]
    with figure_style():
        figure = Figure(figsize=(6.6, 3.1 * len(sides)), layout="constrained")
        for k, side in enumerate(sides):
            ring = figure.add_subplot(len(sides), 2, 2 * k + 1, projection="polar")
            flat = figure.add_subplot(len(sides), 2, 2 * k + 2)
            deepest = max(1e6 * found["joints"][joint][side]["depth"], 1e-9)
            turn = np.linspace(0.0, 2.0 * np.pi, 361)
            ring.plot(turn, np.full(361, _RING * deepest), color="0.4", lw=0.8, ls=":")
            sign = 1.0 if side == "bearing" else -1.0
            for cycles, shade, profile in _profiles(found, joint, side):
                closed = np.vstack([profile, profile[:1]])
                ring.plot(closed[:, 0], _RING * deepest + sign * 1e6 * closed[:, 1], color=shade, lw=1.1)
                angle = np.degrees((profile[:, 0] + np.pi) % (2.0 * np.pi) - np.pi)
                order = np.argsort(angle)
                flat.plot(angle[order], 1e6 * profile[order, 1], color=shade, lw=1.1, label=f"{cycles:,}")
            ring.set(yticklabels=[], ylim=(0.0, (_RING + 1.15) * deepest))
            times = rounded(1e6 * found["joints"][joint]["radius"] / (_RING * deepest))
            ring.set_title(f"joint {joint}: {side}, wear enlarged {times} times", fontsize="medium")
            flat.set(xlim=(-180, 180), xticks=range(-180, 181, 90), ylim=(0.0, None))
            flat.set(xlabel=f"angle on the {side} [deg]", ylabel="depth [µm]")
            flat.legend(
                title="cycles", fontsize="small", title_fontsize="small", **LEGEND | {"ncols": 3}
            )  # above the curves
        return figure


def history_figure(found: Mapping[str, Any]) -> Figure:
    """Draw worn volume, depth and clearance over the cycles, and below the peaks of forces, torques and jitter.

    Peaks are relative to the initial peaks, whose values are in the legend.
    """
    blocks = found["blocks"]
    cycles = np.array([block["cycles"] for block in blocks])
    middle = np.array([block["middle"] for block in blocks])
    with figure_style():
        figure = Figure(figsize=(6.3, 7.0))
        volume, length, peaks = stacked_axes(figure, (1.0, 1.0, 1.0))
        for k, name in enumerate(found["joints"]):
            line = [block["joints"][name] for block in blocks]
            color = COLORS[k % len(COLORS)]
            volume.plot(cycles, [1e9 * at["volume"] for at in line], "o-", ms=3, color=color, label=f"joint {name}")
            length.plot(cycles, [1e6 * at["depth"] for at in line], "o-", ms=3, color=color, label=f"{name}: depth")
            growth = [1e6 * (at["play"] - at["clearance"]) for at in line]
            length.plot(cycles, growth, "s--", ms=3, color=color, label=f"{name}: growth of the mean clearance")
        volume.set(ylabel="worn volume [mm³]")
        length.set(ylabel="length [µm]")
        units = found.get("units", {})
        shown = {name: value for name, value in blocks[0]["peaks"].items() if value > 0.0}
        for k, (name, first) in enumerate(shown.items()):
            values = np.array([block["peaks"][name] for block in blocks]) / first
            unit = f" {typeset(units[name])}" if name in units else ""
            style = {"ms": 3, "lw": 0.9, "color": COLORS[k % len(COLORS)]}
            peaks.plot(middle, values, "o-", label=f"{name} ({first:.3g}{unit})", **style)
        peaks.set(ylabel="mean peak of a cycle over\nthe initial one [1]", xlabel="cycles")
        for axis in (volume, length, peaks):
            axis.legend(fontsize="small")
        figure.align_ylabels()
        return figure


def _profiles(found: Mapping[str, Any], joint: str, side: str) -> Iterator[tuple[int, Any, Array]]:
    """Yield cycles, shade (darker with time) and profile (n, 2) of some stages including the last."""
    blocks = [block for block in found["blocks"] if side in block["joints"][joint]]
    chosen = sorted({round(k) for k in np.linspace(0, len(blocks) - 1, min(_MOST, len(blocks)))})
    shades = mpl.colormaps["viridis_r"](np.linspace(0.15, 1.0, len(chosen)))
    for k, shade in zip(chosen, shades, strict=True):
        yield blocks[k]["cycles"], shade, np.array(blocks[k]["joints"][joint][side]["profile"])


def write_wear_animation(found: Mapping[str, Any], path: Path) -> None:
    """Write a page with the growing profiles of all joints, from the content of ``wear.json``."""
    joints = {}
    for name, joint in found["joints"].items():
        nodes = len(joint["profile"])
        stages = [{side: _depths(block["joints"][name], side, nodes) for side in SIDES} for block in found["blocks"]]
        joints[name] = {key: joint[key] for key in ("depth", "clearance", "radius")} | {"stages": stages}
    life = {"cycles": [block["cycles"] for block in found["blocks"]], "joints": joints}
    text = own_text("linkages.show.plots", "wear_life.html")
    title = found["title"] or found["experiment"]
    path.write_text(filled(text, title=title, life=embedded(life)), encoding="utf-8")


def _depths(joint: Mapping[str, Any], side: str, nodes: int) -> list[float]:
    """Return the depths of a part at a stage [m], rounded to the visible resolution."""
    if side not in joint:
        return [0.0] * nodes
    return [float(f"{depth:.4g}") for _, depth in joint[side]["profile"]]
