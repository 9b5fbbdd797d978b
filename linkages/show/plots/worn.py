"""Figures of wear: profiles, clearance and peaks over the service life, and the page of growing profiles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.base.arrays import Array
from linkages.base.errors import listed
from linkages.base.palette import LATER, SOFT
from linkages.input.files.magnitudes import rounded
from linkages.input.files.writing import file_name
from linkages.show.plots.lines import wear_page
from linkages.show.plots.names import name_of_output, sentence
from linkages.show.plots.panels import legend_below, make_panels, narrow, page, say
from linkages.show.plots.quantities import number, quantity
from linkages.show.plots.style import COLORS, figure_style, look, small_text, write_figure

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
        figure, columns = page(2.6 * len(sides) * (2 if narrow() else 1)), 1 if narrow() else 2
        grid = figure.add_gridspec(2 * len(sides) // columns, columns)
        cells = [grid[k // columns, k % columns] for k in range(2 * len(sides))]
        for k, side in enumerate(sides):
            ring = figure.add_subplot(cells[2 * k], projection="polar")
            flat = figure.add_subplot(cells[2 * k + 1])
            deepest = max(1e6 * found["joints"][joint][side]["depth"], 1e-9)
            turn = np.linspace(0.0, 2.0 * np.pi, 361)
            ring.plot(turn, np.full(361, _RING * deepest), color=SOFT, lw=0.8, ls=":")
            sign = 1.0 if side == "bearing" else -1.0
            for cycles, shade, profile in _profiles(found, joint, side):
                closed = np.vstack([profile, profile[:1]])
                ring.plot(closed[:, 0], _RING * deepest + sign * 1e6 * closed[:, 1], color=shade, lw=1.1)
                angle = np.degrees((profile[:, 0] + np.pi) % (2.0 * np.pi) - np.pi)
                order = np.argsort(angle)
                label = f"{cycles:,} cycles"
                flat.plot(angle[order], 1e6 * profile[order, 1], color=shade, lw=1.1, label=label)
            ring.set(yticklabels=[], ylim=(0.0, (_RING + 1.15) * deepest), xticks=np.radians(range(0, 360, 90)))
            times = rounded(1e6 * found["joints"][joint]["radius"] / (_RING * deepest))
            ring.set_title(f"{side}, wear {times} times enlarged", fontsize="medium", loc="left")
            flat.set(xlim=(-180, 180), xticks=range(-180, 181, 90), ylim=(0.0, None))
            flat.set(xlabel=f"angle on the {side} [deg]", ylabel="depth [µm]")
        depths = (f"{quantity(found['joints'][joint][side]['depth'], 'm', 3)} in the {side}" for side in sides)
        say(figure, f"Joint {joint} is worn by up to {listed(depths)} after {found['cycles']:,} cycles")
        legend_below(figure)
        return figure


def history_figure(found: Mapping[str, Any]) -> Figure:
    """Draw worn volume, depth and clearance over the cycles, and below the peaks of forces, torques and jitter.

    Peaks are relative to the initial peaks, whose values are in the legend.
    """
    with figure_style():
        figure, (volume, length, peaks) = make_panels(3, 1.9, 1, sharex=True)
        _draw_lengths(found, volume, length)
        shown = {name: value for name, value in found["blocks"][0]["peaks"].items() if value > 0.0}
        middle = [block["middle"] for block in found["blocks"]]
        growth = {}
        for k, (name, first) in enumerate(shown.items()):
            values = np.array([block["peaks"][name] for block in found["blocks"]]) / first
            growth[name] = float(values[-1])
            unit = found.get("units", {}).get(name, "1")
            label = f"{name_of_output(name)}, new {quantity(first, unit, 3)}"
            peaks.plot(middle, values, marker="o", ms=3, lw=0.9, label=label, **look(k))
        peaks.set(ylabel="mean peak of a cycle\nover the new one [1]", xlabel="cycles")
        for axis in (volume, length):
            axis.legend(fontsize=small_text())
        figure.align_ylabels()
        say(figure, *_grown(found, growth))
        legend_below(figure, [peaks])
        return figure


def _draw_lengths(found: Mapping[str, Any], volume: Axes, length: Axes) -> None:
    """Draw worn volumes, depths and the growth of clearances over the cycles."""
    cycles = np.array([block["cycles"] for block in found["blocks"]])
    for k, name in enumerate(found["joints"]):
        line = [block["joints"][name] for block in found["blocks"]]
        color = COLORS[k % len(COLORS)]
        volume.plot(cycles, [1e9 * at["volume"] for at in line], "o-", ms=3, color=color, label=f"joint {name}")
        length.plot(cycles, [1e6 * at["depth"] for at in line], "o-", ms=3, color=color, label=f"{name}: depth")
        growth = [1e6 * (at["play"] - at["clearance"]) for at in line]
        length.plot(cycles, growth, "s--", ms=3, color=color, label=f"{name}: growth of the mean clearance")
    volume.set(ylabel="worn volume [mm³]")
    length.set(ylabel="length [µm]")


def _grown(found: Mapping[str, Any], growth: Mapping[str, float]) -> list[str]:
    """Tell the largest growth of a clearance, and the largest change of a peak."""
    worn = {name: one["play"] - one["clearance"] for name, one in found["joints"].items()}
    name = max(worn, key=worn.__getitem__)
    told = [f"Wear enlarges the clearance of {name} by {quantity(worn[name], 'm', 3)} in {found['cycles']:,} cycles"]
    if growth:
        most = max(growth, key=lambda one: abs(growth[one] - 1.0))
        told.append(f"{sentence(name_of_output(most))}: {number(growth[most], 3)} times the new peak")
    return told


def _profiles(found: Mapping[str, Any], joint: str, side: str) -> Iterator[tuple[int, Any, Array]]:
    """Yield cycles, shade (darker with time) and profile (n, 2) of some stages including the last."""
    blocks = [block for block in found["blocks"] if side in block["joints"][joint]]
    chosen = sorted({round(k) for k in np.linspace(0, len(blocks) - 1, min(_MOST, len(blocks)))})
    shades = mpl.colormaps[LATER](np.linspace(0.15, 1.0, len(chosen)))
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
    title = found["title"] or found["experiment"]
    path.write_text(wear_page(f"{title}: wear", life), encoding="utf-8")


def _depths(joint: Mapping[str, Any], side: str, nodes: int) -> list[float]:
    """Return the depths of a part at a stage [m], rounded to the visible resolution."""
    if side not in joint:
        return [0.0] * nodes
    return [float(f"{depth:.4g}") for _, depth in joint[side]["profile"]]
