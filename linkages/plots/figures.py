"""Figures of a study: the run beside the ideal linkage."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from linkages.engines.study import Study, touching
from linkages.plots.style import COLORS, figure_style
from linkages.results.impacts import FREE, IMPACT, SUSTAINED_CONTACT, Impact, phases

_RUN, _IDEAL = COLORS[:2]
# what a journal does: label, colour, width; distinct in grey too
_PHASES = {
    FREE: ("free flight", COLORS[5], 0.7),
    SUSTAINED_CONTACT: ("sustained contact", "#1A1A1A", 1.4),
    IMPACT: ("impact", COLORS[1], 1.4),
}

_CHORD = 0.05  # of the clearance: between the points of a drawn orbit
_MOST_PIECES = 2000  # beyond so many a drawing gains nothing from more

_LABELS = {
    "x": ("displacement x", "mm", 1e3),
    "y": ("displacement y", "mm", 1e3),
    "angle": ("angle", "deg", 180.0 / np.pi),
    "vx": ("velocity v$_x$", "m/s", 1.0),
    "vy": ("velocity v$_y$", "m/s", 1.0),
    "omega": ("angular velocity", "rad/s", 1.0),
    "ax": ("acceleration a$_x$", "m/s²", 1.0),
    "ay": ("acceleration a$_y$", "m/s²", 1.0),
    "alpha": ("angular acceleration", "rad/s²", 1.0),
}


def write_figures(study: Study, folder: Path) -> list[Path]:
    """Draw all figures of a study as PNG files; returns their paths.

    One for each output (ideal beside clearance, and their difference), the journal orbits, the impacts where there
    are any, the joint forces and the drive torques.
    """
    written = []
    with figure_style():
        jobs: list[tuple[str, Callable[[Study], Figure]]] = [
            (f"output_{name}", _output_figure(name)) for name in study.experiment.outputs
        ]
        if study.assembly.tree.journals:
            jobs.append(("orbits", _orbits))
        if study.contacts:
            jobs.append(("impacts", _impacts_figure(study.contacts)))
        jobs.append(("joint_forces", _forces))
        if study.experiment.drives:
            jobs.append(("drive_torques", _torques))
        for name, draw in jobs:
            path = folder / f"{name}.png"
            draw(study).savefig(path)
            written.append(path)
    return written


def _of_run(study: Study) -> str:
    """Label of the run's curves."""
    return "with clearance" if study.experiment.play else "integrated"


def _output_figure(name: str) -> Callable[[Study], Figure]:
    def draw(study: Study) -> Figure:
        point, _, quantity = name.rpartition(".")
        label, unit, scale = _LABELS[quantity]
        run, ideal = study.run, study.ideal
        figure = Figure(figsize=(6.3, 4.4), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
        top.plot(ideal.time, scale * ideal[name], color=_IDEAL, lw=2.2, alpha=0.8, label="ideal joints")
        top.plot(run.time, scale * run[name], color=_RUN, lw=0.9, label=_of_run(study))
        top.set_ylabel(f"{point}: {label} [{unit}]")
        top.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
        inside = run.time <= ideal.time[-1]
        times = run.time[inside]
        exact = ideal.evaluate(times)[name] if ideal.evaluate else np.interp(times, ideal.time, ideal[name])
        difference = scale * (run[name][inside] - exact)
        small, small_unit = (1e3, "µm") if unit == "mm" else (1.0, unit)
        bottom.plot(times, small * difference, color="0.25", lw=0.8)
        bottom.set_ylim(*_without_start(times, small * difference))
        bottom.set_ylabel(f"difference\n[{small_unit}]")
        bottom.set_xlabel("time [s]")
        return figure

    return draw


def _without_start(times: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Limits of an axis that leave out the microseconds in which a centred journal takes up its load."""
    settled = values[times >= times[0] + 0.005 * np.ptp(times)]
    low, high = float(settled.min()), float(settled.max())
    margin = 0.08 * (high - low) or 1.0
    return low - margin, high + margin


def _orbits(study: Study) -> Figure:
    """Above, each journal's centre in its clearance circle; below, magnified.

    Magnified is the orbit itself, or, of a joint that can touch, how deep the journal is in the wall at each angle.
    """
    names = study.assembly.tree.journals
    touches = touching(study.experiment, study.run)
    figure = Figure(figsize=(max(3.15 * len(names), 3.6), 6.4), layout="constrained")
    axes = figure.subplots(2, len(names), squeeze=False)
    circle = np.linspace(0.0, 2.0 * np.pi, 361)
    for (whole, near), name in zip(axes.T, names, strict=True):
        clearance = 1e6 * (study.experiment.joints[name].clearance or 0.0)
        ex, ey = 1e6 * study.run[f"{name}.ex"], 1e6 * study.run[f"{name}.ey"]
        whole.fill(
            clearance * np.cos(circle), clearance * np.sin(circle), facecolor="0.95", edgecolor="0.3", lw=1.2
        )
        peak = float(np.max(study.run[f"{name}.eccentricity_ratio"]))
        whole.set_title(f"joint {name}: largest e/c = {peak:.3f}", fontsize=9)
        if name in touches:
            path, phase = _path(study, name)
            _draw_phases(whole, 1e6 * path[:, 0], 1e6 * path[:, 1], phase)
            whole.plot(ex[0], ey[0], "o", color="#009E73", ms=3.5)
            _wall(near, 1e6 * path, clearance, phase)
        else:
            for axis in (whole, near):
                axis.plot(ex, ey, color=_RUN, lw=0.9)
                axis.plot(ex[0], ey[0], "o", color=_IDEAL, ms=3.5, label="start")
            near.legend(loc="best")
        for axis in (whole,) if name in touches else (whole, near):
            axis.set_aspect("equal", adjustable="datalim")
            axis.set_xlabel("e$_x$ [µm]")
            axis.set_ylabel("e$_y$ [µm]")
    if touches:
        filled = all(study.experiment.joints[name].has_film for name in touches)
        handles = [
            Line2D([], [], color=color, lw=2.0, label="film alone" if filled and code == FREE else label)
            for code, (label, color, _) in _PHASES.items()
        ]
        handles.append(Line2D([], [], color="#009E73", marker="o", ms=3.5, lw=0.0, label="start"))
        figure.legend(handles=handles, ncols=2, loc="outside lower center")
    return figure


def _path(study: Study, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Eccentricity (n, 2) [m] of a joint that can touch, and the phase (n - 1,) of each piece of its path.

    The steps of a free flight may be long: between them the run is evaluated anew, unless there are so many that
    nobody could tell.
    """
    run, phase = study.run, phases(study.run, name)
    e = np.column_stack([run[f"{name}.ex"], run[f"{name}.ey"]])
    chord = _CHORD * (study.experiment.joints[name].clearance or np.inf)
    pieces = np.ceil(np.hypot(*np.diff(e, axis=0).T) / chord).astype(int).clip(1, _MOST_PIECES)
    extra = int(np.sum(pieces - 1))
    if run.evaluate is None or not 0 < extra <= _MOST_PIECES:
        return e, phase
    cuts = [np.linspace(a, b, n + 1)[1:-1] for a, b, n in zip(run.time, run.time[1:], pieces, strict=False)]
    times = np.concatenate(cuts)
    between = run.evaluate(times)
    order = np.argsort(np.concatenate([run.time, times]), kind="stable")
    added = np.column_stack([between[f"{name}.ex"], between[f"{name}.ey"]])
    return np.concatenate([e, added])[order], np.repeat(phase, pieces)


def _wall(axis: Axes, path: np.ndarray, clearance: float, phase: np.ndarray) -> None:
    """Draw how deep the journal is in the wall over the angle at which it lies, the wall unrolled; lengths in µm."""
    depth = np.hypot(*path.T) - clearance
    angle = np.degrees(np.arctan2(path[:, 1], path[:, 0]))
    phase = np.where(np.abs(np.diff(angle)) < 180.0, phase, -1)  # no line across the page
    _draw_phases(axis, angle, depth, phase)
    deepest = float(depth.max())
    top = 1.1 * deepest if deepest > 0.0 else -0.1 * float(depth.min())
    bottom = -top if deepest > 0.0 else 1.1 * float(depth.min())
    axis.axhspan(0.0, top, color="0.92", zorder=0)
    axis.axhline(0.0, color="0.3", lw=1.0, zorder=1)
    axis.set(xlim=(-180.0, 180.0), ylim=(bottom, top), xticks=range(-180, 181, 90))
    axis.set_xlabel("angle of e [deg]")
    axis.set_ylabel("e $-$ c [µm]; above 0: in the wall")


def _draw_phases(axis: Axes, x: np.ndarray, y: np.ndarray, phase: np.ndarray) -> None:
    """Draw the line through the samples, each step in the colour of its phase; steps of no phase are left out."""
    points = np.column_stack([x, y])
    steps = np.stack([points[:-1], points[1:]], axis=1)
    for code, (_, color, width) in _PHASES.items():
        axis.add_collection(
            LineCollection(list(steps[phase == code]), colors=color, linewidths=width, capstyle="round")
        )
    axis.autoscale_view()


def _impacts_figure(rows: list[Impact]) -> Callable[[Study], Figure]:
    def draw(study: Study) -> Figure:
        names = sorted({row.joint for row in rows})  # joints, or corners of a guide
        figure = Figure(
            figsize=(6.3, 0.8 + (3.2 if len(names) < 3 else 2.4) * len(names)), layout="constrained"
        )
        axes = figure.subplots(2 * len(names), 1, sharex=True, squeeze=False)[:, 0]
        run = study.run
        for k, name in enumerate(names):
            own = [row for row in rows if row.joint == name]
            start = np.array([row.start for row in own])
            kind = phases(run, name)[np.searchsorted(run.time, start)]
            values = (
                ("force [N]", [row.peak_force for row in own]),
                ("approach [m/s]", [row.approach_speed for row in own]),
            )
            axes[2 * k].set_title(name, loc="left", fontsize=9)
            for axis, (label, value) in zip(axes[2 * k : 2 * k + 2], values, strict=True):
                for code in (IMPACT, SUSTAINED_CONTACT):
                    name_of, color, _ = _PHASES[code]
                    at, height = start[kind == code], np.array(value)[kind == code]
                    axis.vlines(at, 0.0, height, color=color, lw=1.0)
                    axis.plot(at, height, "o", color=color, ms=3.0, label=name_of)
                axis.set_ylim(bottom=0.0)
                axis.set_ylabel(label)
        axes[0].legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
        figure.align_ylabels(axes)
        axes[-1].set_xlim(run.time[0], run.time[-1])
        axes[-1].set_xlabel("start of the contact [s]")
        return figure

    return draw


def _forces(study: Study) -> Figure:
    play = study.assembly.tree.play
    names = play or tuple(joint.name for joint in study.mechanism.joints)
    figure = Figure(figsize=(6.3, 0.8 + 2.0 * len(names)), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0])
    for axis, name in zip(axes, names, strict=True):
        axis.plot(
            study.ideal.time,
            study.ideal[f"{name}.force"],
            color=_IDEAL,
            lw=2.2,
            alpha=0.8,
            label="ideal joints",
        )
        axis.plot(study.run.time, study.run[f"{name}.force"], color=_RUN, lw=0.9, label=_of_run(study))
        axis.set_ylabel(f"force in {name} [N]")
        axis.set_ylim(bottom=0.0)
    axes[0].legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    axes[-1].set_xlabel("time [s]")
    return figure


def _torques(study: Study) -> Figure:
    figure = Figure(figsize=(6.3, 3.2), layout="constrained")
    axis = figure.subplots()
    for name, color in zip(study.experiment.drives, COLORS * len(study.experiment.drives), strict=False):
        unit = "N" if study.mechanism.joint[name].type == "prismatic" else "N m"
        axis.plot(study.ideal.time, study.ideal[f"{name}.torque"], color=color, lw=2.6, alpha=0.35)
        axis.plot(study.run.time, study.run[f"{name}.torque"], color=color, lw=0.9, label=f"{name} [{unit}]")
    axis.set_xlabel("time [s]")
    axis.set_ylabel("drive torque (wide, pale: ideal joints)")
    axis.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    return figure
