"""Figures of a study over time, ideal joints beside real ones; `write_figures` writes these and those of `journals`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.outputs.registry import unit
from linkages.plots.journals import contacts_figure, orbits_figure
from linkages.plots.style import COLORS, add_legend, axis_label, figure_style, shown
from linkages.results.summary import Study

_RUN, _IDEAL = COLORS[:2]

# the quantities of a link or frame in words
_LABELS = {
    "x": "displacement x",
    "y": "displacement y",
    "angle": "angle",
    "vx": "velocity v$_x$",
    "vy": "velocity v$_y$",
    "omega": "angular velocity",
    "ax": "acceleration a$_x$",
    "ay": "acceleration a$_y$",
    "alpha": "angular acceleration",
}


def write_figures(study: Study, folder: Path) -> list[Path]:
    """Draw all figures of a study as PNG files.

    One for each output, the journals' orbits, the contacts where there are any, the joint forces and the drives'
    torques.

    Parameters
    ----------
    study : Study
        From `linkages.study`.
    folder : Path
        It must exist.

    Returns
    -------
    list of Path
        The files written.
    """
    figures: dict[str, Callable[[Study], Figure]] = {
        f"output_{name}": partial(output_figure, name=name) for name in study.system.experiment.outputs
    }
    if study.system.tree.journals:
        figures["orbits"] = orbits_figure
    if study.contacts:
        figures["impacts"] = contacts_figure
    figures["joint_forces"] = forces_figure
    if study.system.experiment.drives:
        figures["drive_torques"] = torques_figure
    with figure_style():
        for name, draw in figures.items():
            draw(study).savefig(folder / f"{name}.png")
    return [folder / f"{name}.png" for name in figures]


def output_figure(study: Study, name: str) -> Figure:
    """Draw an output of a link or frame over time; below, the difference that clearance makes."""
    point, _, quantity = name.rpartition(".")
    si = unit(study.system, name)
    drawn, factor = ("deg", 180.0 / np.pi) if si == "rad" else shown(si)
    run, ideal = study.run, study.ideal
    figure = Figure(figsize=(6.3, 4.4), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    _draw_both(top, study, name, factor)
    top.set_ylabel(axis_label(f"{point}: {_LABELS[quantity]}", drawn))
    add_legend(top)
    times = run.time[run.time <= ideal.time[-1]]
    exact = ideal.evaluate(times)[name] if ideal.evaluate else np.interp(times, ideal.time, ideal[name])
    difference = factor * (run[name][: len(times)] - exact)
    if drawn == "mm":
        drawn, difference = "µm", 1e3 * difference
    bottom.plot(times, difference, color="0.25", lw=0.8)
    limits = _limits_after_start(times, difference)
    bottom.set(xlabel="time [s]", ylabel=f"difference\n[{drawn}]", ylim=limits)
    return figure


def forces_figure(study: Study) -> Figure:
    """Draw the force in each joint with play, or, where there is none, in every joint."""
    names = study.system.tree.play or tuple(study.system.mechanism.joint)
    figure = Figure(figsize=(6.3, 0.8 + 2.0 * len(names)), layout="constrained")
    axes = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for axis, name in zip(axes, names, strict=True):
        _draw_both(axis, study, f"{name}.force")
        axis.set(ylabel=f"force in {name} [N]", ylim=(0.0, None))
    add_legend(axes[0])
    axes[-1].set_xlabel("time [s]")
    return figure


def torques_figure(study: Study) -> Figure:
    """Draw the torques of all drives, forces where they drive a prismatic joint."""
    drives = study.system.experiment.drives
    kinds = {unit(study.system, f"{drive}.torque") for drive in drives}
    effort = " or ".join(name for name, kind in (("torque", "N m"), ("force", "N")) if kind in kinds)
    figure = Figure(figsize=(6.3, 3.2), layout="constrained")
    axis = figure.subplots()
    for k, drive in enumerate(drives):
        name, color = f"{drive}.torque", COLORS[k % len(COLORS)]
        axis.plot(study.ideal.time, study.ideal[name], color=color, lw=2.6, alpha=0.35)
        label = axis_label(drive, unit(study.system, name))
        axis.plot(study.run.time, study.run[name], color=color, lw=0.9, label=label)
    axis.set(xlabel="time [s]", ylabel=f"drive {effort} (wide, pale: ideal joints)")
    add_legend(axis)
    return figure


def _draw_both(axis: Axes, study: Study, name: str, factor: float = 1.0) -> None:
    """Draw a column of the ideal motion and of the run."""
    run, ideal = study.run, study.ideal
    label = "with clearance" if study.system.experiment.play else "integrated"
    axis.plot(ideal.time, factor * ideal[name], color=_IDEAL, lw=2.2, alpha=0.8, label="ideal joints")
    axis.plot(run.time, factor * run[name], color=_RUN, lw=0.9, label=label)


def _limits_after_start(times: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Limits of an axis that leave out the microseconds in which a centred journal takes up its load."""
    settled = values[times >= times[0] + 0.005 * np.ptp(times)]
    low, high = float(settled.min()), float(settled.max())
    margin = 0.08 * (high - low) or 1.0
    return low - margin, high + margin
