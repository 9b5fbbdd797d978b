"""Figures and an offline page of wear: profiles; clearance, forces, torques and jitter over the service life."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from linkages.base.arrays import Array
from linkages.input.files.magnitudes import rounded
from linkages.input.files.writing import file_name
from linkages.show.plots.pages import embedded, filled, own_text
from linkages.show.plots.style import COLORS, LEGEND, figure_style, stacked_axes, typeset, write_png

SIDES = ("bearing", "journal")
_MOST = 8  # most profiles in one drawing
_RING = 3.0  # radius of the drawn circle over the largest depth


def write_figures(found: Mapping[str, Any], folder: Path) -> None:
    """Write ``wear_JOINT.png`` of each joint and ``wear_history.png`` from the content of ``wear.json``."""
    for name in found["joints"]:
        write_png(profile_figure(found, name), folder / f"wear_{file_name(name)}.png")
    write_png(history_figure(found), folder / "wear_history.png")


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
            ring.set_title(f"joint {joint}: {side}, wear enlarged {times} times", fontsize=9)
            flat.set(xlim=(-180, 180), xticks=range(-180, 181, 90), ylim=(0.0, None))
            flat.set(xlabel=f"angle on the {side} [deg]", ylabel="depth [µm]")
            flat.legend(title="cycles", fontsize=7, title_fontsize=7, **LEGEND | {"ncols": 3})  # above the curves
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
            axis.legend(fontsize=7)
        figure.align_ylabels()
        return figure


def _profiles(found: Mapping[str, Any], joint: str, side: str) -> Iterator[tuple[int, Any, Array]]:
    """Yield cycles, shade (darker with time) and profile (n, 2) of some stages including the last."""
    blocks = [block for block in found["blocks"] if side in block["joints"][joint]]
    chosen = sorted({round(k) for k in np.linspace(0, len(blocks) - 1, min(_MOST, len(blocks)))})
    shades = mpl.colormaps["viridis_r"](np.linspace(0.15, 1.0, len(chosen)))
    for k, shade in zip(chosen, shades, strict=True):
        yield blocks[k]["cycles"], shade, np.array(blocks[k]["joints"][joint][side]["profile"])


def write_animation(found: Mapping[str, Any], path: Path) -> None:
    """Write a page with the growing profiles of all joints, from the content of ``wear.json``."""
    joints = {}
    for name, joint in found["joints"].items():
        nodes = len(joint["profile"])
        stages = [{side: _depths(block["joints"][name], side, nodes) for side in SIDES} for block in found["blocks"]]
        joints[name] = {key: joint[key] for key in ("depth", "clearance", "radius")} | {"stages": stages}
    life = {"cycles": [block["cycles"] for block in found["blocks"]], "joints": joints}
    text = own_text("linkages.show.plots", "wear_life.html")
    title = found["title"] or found["experiment"]
    path.write_text(filled(text, title=title, life=embedded(life), colors=embedded(COLORS)), encoding="utf-8")


def _depths(joint: Mapping[str, Any], side: str, nodes: int) -> list[float]:
    """Return the depths of a part at a stage [m], rounded to the visible resolution."""
    if side not in joint:
        return [0.0] * nodes
    return [float(f"{depth:.4g}") for _, depth in joint[side]["profile"]]
