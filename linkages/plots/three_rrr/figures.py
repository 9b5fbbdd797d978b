"""The paper's figures 5 to 12, and the list of all figures of the robot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.flexible import Array
from linkages.plots.style import COLORS, LINES, figure_style
from linkages.plots.three_rrr.drawing import OUTLINE, draw_pose, shape_lines
from linkages.plots.three_rrr.parameters import (
    WIDTH,
    convergence_figure,
    map_figure,
    speed_figure,
    velocity_figure,
)
from linkages.three_rrr.modes import DENSE
from linkages.three_rrr.response import generalised_alpha
from linkages.three_rrr.results import RobotResults
from linkages.three_rrr.stress import platform_stress

_WINDOW = 0.12  # s, in which the vibration after a start from rest is drawn
_SHAPE_POSES = 3


def write_figures(
    results: RobotResults, folder: Path, progress: Callable[[float], None] | None = None
) -> list[Path]:
    """Draw all figures as PNG files; returns their paths."""
    jobs: list[tuple[str, Callable[[RobotResults], Figure]]] = [
        ("fig05_pose", _pose),
        ("fig06_path", _path),
        ("fig07_velocity", _velocity),
        ("fig08_acceleration", _acceleration),
        ("fig09_frequencies", _frequencies),
        ("fig10_mode_shapes", _shapes),
        ("fig11_elastic_displacement", _displacement),
        ("fig12_stress", _stress),
        ("map_assemblies", map_figure),
        ("convergence", convergence_figure),
        ("velocity_terms", velocity_figure),
        ("speed_sweep", speed_figure),
    ]
    written = []
    with figure_style():
        for index, (name, draw) in enumerate(jobs):
            path = folder / f"{name}.png"
            draw(results).savefig(path)
            written.append(path)
            if progress is not None:
                progress((index + 1) / len(jobs))
    return written


def _over_time(results: RobotResults, curves: list[tuple[str, Array]]) -> Figure:
    """One panel above the other over time."""
    figure = Figure(figsize=(WIDTH, 1.55 * len(curves) + 0.4), layout="constrained")
    axes = figure.subplots(len(curves), 1, sharex=True)
    for axis, (label, values), color in zip(axes, curves, COLORS, strict=False):
        axis.plot(results.motion.time, values, color=color, lw=1.2)
        axis.set_ylabel(label)
    axes[-1].set_xlabel("time [s]")
    figure.align_ylabels(axes)
    return figure


def _pose(results: RobotResults) -> Figure:
    x = results.motion.x
    angle = np.rad2deg(np.unwrap(x[:, 0]))
    return _over_time(results, [("θ [deg]", angle), ("x [mm]", 1e3 * x[:, 1]), ("y [mm]", 1e3 * x[:, 2])])


def _velocity(results: RobotResults) -> Figure:
    v = results.motion.dx
    return _over_time(
        results,
        [("dθ/dt [rad/s]", v[:, 0]), ("dx/dt [mm/s]", 1e3 * v[:, 1]), ("dy/dt [mm/s]", 1e3 * v[:, 2])],
    )


def _acceleration(results: RobotResults) -> Figure:
    a = results.motion.ddx
    labels = ("d²θ/dt² [rad/s²]", "d²x/dt² [mm/s²]", "d²y/dt² [mm/s²]")
    return _over_time(results, list(zip(labels, (a[:, 0], 1e3 * a[:, 1], 1e3 * a[:, 2]), strict=True)))


def _path(results: RobotResults) -> Figure:
    figure = Figure(figsize=(WIDTH, 3.3), layout="constrained")
    axis, whole = figure.subplots(1, 2)
    x, y = 1e3 * results.motion.x[:, 1], 1e3 * results.motion.x[:, 2]
    for panel in (axis, whole):
        panel.plot(x, y, color=COLORS[0], lw=1.3, zorder=4)
        panel.plot(x[0], y[0], "o", color=COLORS[1], ms=4, zorder=5, label="start")
        panel.plot(x[-1], y[-1], "s", color=COLORS[2], ms=4, zorder=5, label="end")
        panel.set_aspect("equal", adjustable="datalim")
        panel.set_xlabel("x [mm]")
    axis.set_ylabel("y [mm]")
    axis.set_title("platform's centre", fontsize=9)
    axis.legend()
    for index, alpha in ((0, 0.9), (len(results.motion) // 3, 0.35)):
        draw_pose(whole, results.model, results.motion, index, alpha=alpha)
    whole.set_title("in the robot at two poses", fontsize=9)
    return figure


def _frequencies(results: RobotResults) -> Figure:
    figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
    axis = figure.subplots()
    for n in range(results.tracked.shape[1]):
        axis.plot(
            results.motion.time,
            results.tracked[:, n],
            color=COLORS[n],
            ls=LINES[n],
            lw=1.4,
            label=f"mode {n + 1}",
        )
    axis.set_xlabel("time [s]")
    axis.set_ylabel("natural frequency [Hz]")
    axis.set_ylim(bottom=0.0)
    figure.suptitle("modes followed by MAC from t = 0, crank roots held", fontsize=9)
    axis.legend(ncols=6, loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=7.5)
    return figure


def _shapes(results: RobotResults) -> Figure:
    """Modes (rows) drawn deformed at several poses (columns)."""
    rows = min(4, results.tracked.shape[1])
    figure = Figure(figsize=(WIDTH, 2.2 * rows), layout="constrained")
    axes = figure.subplots(rows, _SHAPE_POSES, sharex=True, sharey=True)
    places = np.linspace(0, len(results.motion) - 1, _SHAPE_POSES + 1).astype(int)[:-1]
    for column, index in enumerate(places):
        for mode in range(rows):
            axis: Axes = axes[mode, column]
            draw_pose(axis, results.model, results.motion, index, color="0.75")
            lines = shape_lines(results.model, results.motion, index, results.shapes[index, :, mode])
            for line, name in lines:
                axis.plot(*(1e3 * line.T), color=COLORS[mode], lw=1.6 if name == "platform" else 1.3)
            axis.set_aspect("equal")
            axis.grid(False)
            axis.set_title(
                f"mode {mode + 1}, t = {results.motion.time[index]:.2f} s: {results.tracked[index, mode]:.1f} Hz",
                fontsize=7.5,
            )
    for axis in axes[-1]:
        axis.set_xlabel("x [mm]")
    for axis in axes[:, 0]:
        axis.set_ylabel("y [mm]")
    return figure


def _displacement(results: RobotResults) -> Figure:
    """Left the whole motion, quasi-static; right its first moments with vibration from rest."""
    figure = Figure(figsize=(WIDTH, 5.0), layout="constrained")
    axes = figure.subplots(3, 2, sharex="col")
    window = min(_WINDOW, float(results.branch.times[-1]))
    vibration = None
    if results.model.size <= DENSE:
        vibration = generalised_alpha(
            results.model, results.branch, np.linspace(0.0, window, 4001), radius=1.0
        )
    for k, label in enumerate(("x [µm]", "y [µm]", "turning [µrad]")):
        axes[k, 0].plot(results.motion.time, 1e6 * results.static.platform[:, k], color=COLORS[1], lw=1.2)
        axes[k, 0].set_ylabel(f"elastic {label}")
        near = results.motion.time <= window * 1.5
        if vibration is not None:
            time = 1e3 * vibration.motion.time
            axes[k, 1].plot(
                time, 1e6 * vibration.platform[:, k], color=COLORS[0], lw=0.8, label="started from rest"
            )
        axes[k, 1].plot(
            1e3 * results.motion.time[near],
            1e6 * results.static.platform[near, k],
            color=COLORS[1],
            lw=1.6,
            label="quasi-static",
        )
        axes[k, 1].set_xlim(0.0, 1e3 * window)
    axes[0, 0].set_title("over the motion, quasi-static", fontsize=9)
    axes[0, 1].set_title("the first moments, undamped", fontsize=9)
    figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    axes[2, 0].set_xlabel("time [s]")
    axes[2, 1].set_xlabel("time [ms]")
    return figure


def _stress(results: RobotResults) -> Figure:
    """Over time in leg 2 and the platform; along the rods where it is largest."""
    figure = Figure(figsize=(WIDTH, 7.0), layout="constrained")
    axes = figure.subplots(3, 2, width_ratios=[1.7, 1])
    time = results.motion.time
    for row, link in enumerate((results.stress[2], results.stress[3])):
        pose, _ = np.unravel_index(np.argmax(link.largest), link.largest.shape)
        left, right = axes[row]
        for end, k in enumerate((0, len(link.s) // 2, len(link.s) - 1)):
            label = f"{1e3 * link.s[k]:.0f} mm"
            left.plot(time, 1e-3 * link.fibre[:, k], color=COLORS[end], ls=LINES[end], lw=1.2, label=label)
        left.set_ylabel(f"{link.name}: outer fibre [kPa]")
        left.set_xlabel("time [s]")
        right.plot(1e3 * link.s, 1e-3 * link.axial[pose], color=COLORS[2], ls="--", lw=1.2, label="axial")
        right.plot(1e3 * link.s, 1e-3 * link.bending[pose], color=COLORS[1], lw=1.2, label="bending")
        right.set_xlabel(f"along the rod [mm], t = {time[pose]:.2f} s", fontsize=8)
        _legend_above(left)
        _legend_above(right)
    left, right = axes[2]
    if results.model.rigid:
        left.text(0.5, 0.5, "the platform is rigid", transform=left.transAxes, ha="center")
    else:
        plate = platform_stress(results.model, results.static)
        curves = (
            (plate.first, "larger principal"),
            (plate.second, "smaller"),
            (plate.largest_shear, "shear"),
        )
        for k, (values, label) in enumerate(curves):
            left.plot(time, values, color=COLORS[k], ls=LINES[k], lw=1.2, label=label)
        _legend_above(left)
    left.set_ylabel("platform: stress [Pa]")
    left.set_xlabel("time [s]")
    right.axis("off")
    draw_pose(right, results.model, results.motion, 0, color=OUTLINE)
    right.set_aspect("equal")
    right.set_title("robot at t = 0", fontsize=7.5)
    return figure


def _legend_above(axis: Axes) -> None:
    axis.legend(
        fontsize=7.5,
        ncols=3,
        loc="lower left",
        bbox_to_anchor=(0.0, 0.98),
        borderaxespad=0.0,
        columnspacing=1.0,
    )
