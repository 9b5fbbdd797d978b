"""The sources' figures, drawn from our runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.plots.style import COLORS

Columns = dict[str, NDArray[np.float64]]

#: Line styles tell the designs apart without colours.
STYLES = {
    "nominal": {"color": "#000000", "linestyle": "-"},
    "paper 1": {"color": COLORS[1], "linestyle": "--"},
    "paper 2": {"color": COLORS[0], "linestyle": "-."},
    "ours": {"color": COLORS[2], "linestyle": ":"},
}
_RC: dict[Any, Any] = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "figure.dpi": 150,
    "lines.linewidth": 1.2,
}
_SETTLED = 0.01  # s: before it the journals leave the centre, and differences hide all others
_MOTION = (
    ("slider7.x", 1e3, "displacement [mm]"),
    ("slider7.vx", 1.0, "velocity [m/s]"),
    ("slider7.ax", 1.0, "acceleration [m/s²]"),
)


def write_motion(designs: Mapping[str, Columns], path: Path) -> None:
    """Draw the slider's motion (the paper's figures 6-8) and how far each design is from the nominal one.

    Parameters
    ----------
    designs : mapping of columns
        At the same times, by name; "nominal" is among them.
    """
    with mpl.rc_context(_RC):
        figure = Figure(figsize=(7.5, 6.5), layout="constrained")
        axes = figure.subplots(3, 2, sharex=True)
        for (left, right), (name, scale, label) in zip(axes, _MOTION, strict=True):
            for key, columns in designs.items():
                left.plot(columns["time"], scale * columns[name], label=key, **STYLES[key])
                if key != "nominal":
                    later = columns["time"] > _SETTLED
                    apart = 1e3 * (columns[name] - designs["nominal"][name])[later]
                    right.plot(columns["time"][later], apart, label=key, **STYLES[key])
            left.set_ylabel(label)
            right.set_ylabel("minus nominal [" + {"x": "mm", "vx": "mm/s", "ax": "mm/s²"}[name[8:]] + "]")
        axes[0, 0].legend(frameon=False)
        for ax in axes[-1]:
            ax.set_xlabel("time [s]")
        figure.savefig(path, format="png")


def write_orbits(designs: Mapping[str, Columns], clearance: float, path: Path) -> None:
    """Draw the journals' paths in joints A and B (figure 9); `clearance` [m]."""
    with mpl.rc_context(_RC):
        figure = Figure(figsize=(7.5, 4.2), layout="constrained")
        axes = figure.subplots(1, 2)
        for ax, joint in zip(axes, "AB", strict=True):
            largest = 0.0
            for key, columns in designs.items():
                x, y = 1e6 * columns[f"{joint}.ex"], 1e6 * columns[f"{joint}.ey"]
                ax.plot(x, y, label=key, **STYLES[key])
                largest = max(largest, float(np.hypot(x, y).max()))
            ax.set(
                title=f"joint {joint} (clearance {1e6 * clearance:.0f} µm)", aspect="equal",
                xlabel="$e_x$ [µm]", ylabel="$e_y$ [µm]", xlim=(-1.1 * largest, 1.1 * largest),
                ylim=(-1.1 * largest, 1.1 * largest),
            )  # fmt: skip
        figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False
        )
        figure.savefig(path, format="png")


def write_forces(designs: Mapping[str, Columns], path: Path) -> None:
    """Draw the forces in joints A and B (figure 10)."""
    with mpl.rc_context(_RC):
        figure = Figure(figsize=(6.5, 5.0), layout="constrained")
        axes = figure.subplots(2, 1, sharex=True)
        for ax, joint in zip(axes, "AB", strict=True):
            for key, columns in designs.items():
                ax.plot(columns["time"], columns[f"{joint}.force"], label=key, **STYLES[key])
            ax.set_ylabel(f"force in joint {joint} [N]")
        axes[0].legend(frameon=False, ncols=4)
        axes[1].set_xlabel("time [s]")
        figure.savefig(path, format="png")


def write_jitter(before: tuple[Columns, Columns], after: tuple[Columns, Columns], path: Path) -> None:
    """Draw the follower's acceleration before and after the optimisation (the patent's figure 4).

    Parameters
    ----------
    before, after : pairs of columns
        With clearance, and ideal, at the same times.
    """
    with mpl.rc_context(_RC):
        figure = Figure(figsize=(6.5, 5.0), layout="constrained")
        axes = figure.subplots(2, 1, sharex=True, sharey=True)
        for ax, (real, ideal), title in zip(axes, (before, after), ("before", "after"), strict=True):
            _acceleration(ax, real, ideal)
            ax.set_title(title)
        axes[0].legend(frameon=False, loc="upper right", ncols=2)
        axes[1].set_xlabel("time [s]")
        figure.savefig(path, format="png")


def _acceleration(ax: Axes, real: Columns, ideal: Columns) -> None:
    ax.plot(
        real["time"], 1e-3 * real["follower.alpha"], color="#D55E00", linewidth=0.7, label="with clearance"
    )
    ax.plot(ideal["time"], 1e-3 * ideal["follower.alpha"], color="#000000", label="ideal")
    ax.set_ylabel("angular acceleration\nof the follower [10³ rad/s²]")
