"""Figures of a study over time, ideal joints beside real ones; `write_figures` writes these and those of the joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from linkages.files.writing import file_name
from linkages.outputs.registry import unit
from linkages.plots.guides import guides_figure
from linkages.plots.journals import contacts_figure, orbits_figure
from linkages.plots.links import links_figure
from linkages.plots.style import COLORS, add_legend, axis_label, engineering, figure_style
from linkages.results.summary import Study

_RUN, _IDEAL = COLORS[:2]
_SMALL = np.radians(0.1)  # below it angles are in mrad and smaller

# the quantities of a link or frame in words
_LABELS = {
    "x": "position x",
    "y": "position y",
    "angle": "angle",
    "vx": "velocity v$_x$",
    "vy": "velocity v$_y$",
    "omega": "angular velocity",
    "ax": "acceleration a$_x$",
    "ay": "acceleration a$_y$",
    "alpha": "angular acceleration",
    "acceleration": "size of the acceleration",
    "deflection": "deflection",
    "compression": "largest compressive force",
    "bending": "largest bending moment",
    "stress": "largest stress",
    "stress_place": "place of the largest stress",
    "deflection_place": "place of the largest deflection",
}


def write_figures(study: Study, folder: Path) -> list[Path]:
    """Draw all figures of a study as PNG files.

    One for each output, the journals' orbits, blocks in their slots, the contacts where there are any, links that bend,
    the joint forces and the drives' torques.

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
        f"output_{file_name(name)}": partial(output_figure, name=name) for name in study.system.experiment.outputs
    }
    if study.system.tree.journals:
        figures["orbits"] = orbits_figure
    if set(study.system.tree.play) - set(study.system.tree.journals):
        figures["guides"] = guides_figure
    if study.contacts:
        figures["impacts"] = contacts_figure
    if study.system.tree.bent:
        figures["links"] = links_figure
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
    figure = Figure(figsize=(6.3, 4.4), layout="constrained")
    _compare(figure, study, {name: f"{point}: {_LABELS.get(quantity, quantity)}"})
    return figure


def forces_figure(study: Study) -> Figure:
    """Draw the force in each joint with play or, where there is none, in every joint; below each, the difference."""
    names = study.system.tree.play or tuple(study.system.mechanism.joint)
    figure = Figure(figsize=(6.3, 0.8 + 3.0 * len(names)), layout="constrained")
    _compare(figure, study, {f"{name}.force": f"force in {name}" for name in names})
    return figure


def torques_figure(study: Study) -> Figure:
    """Draw the torques of all drives, forces where they drive a prismatic joint; below each, the difference."""
    names = [f"{drive}.torque" for drive in study.system.experiment.drives]
    kinds = {name: "force" if unit(study.system, name) == "N" else "torque" for name in names}
    figure = Figure(figsize=(6.3, 0.8 + 3.0 * len(names)), layout="constrained")
    _compare(figure, study, {name: f"{kind} of {name.removesuffix('.torque')}" for name, kind in kinds.items()})
    return figure


def _compare(figure: Figure, study: Study, labels: Mapping[str, str]) -> None:
    """Draw columns of the ideal motion and of the run, and below each the difference.

    An ideal linkage that is integrated has rigid links, and no column of their bending.
    """
    run, ideal = study.run, study.ideal
    times, both = run.time[run.time <= ideal.time[-1]], [name for name in labels if name in ideal.columns]
    exact = ideal.evaluate(times) if ideal.evaluate else {n: np.interp(times, ideal.time, ideal[n]) for n in both}
    heights = [height for name in labels for height in ((3, 1) if name in both else (3,))]
    axes = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    panels = iter(axes)
    for name, label in labels.items():
        top = next(panels)
        drawn, factor = _shown(study, name, np.concatenate([run[name], ideal[name] if name in both else []]))
        if name in both:
            top.plot(ideal.time, factor * ideal[name], color=_IDEAL, lw=2.2, alpha=0.8, label=_ideal_label(study))
        top.plot(run.time, factor * run[name], color=_RUN, lw=0.9, label=_run_label(study))
        top.set_ylabel(axis_label(label, drawn))
        if name.endswith(".force"):
            top.set_ylim(0.0, None)
        if name not in both:  # a deflection: the links of the ideal motion are rigid
            continue
        bottom = next(panels)
        difference = run[name][: len(times)] - exact[name]
        low, high = _limits_after_start(times, difference)
        drawn, factor = _shown(study, name, np.array([low, high]))
        bottom.plot(times, factor * difference, color="0.25", lw=0.8)
        bottom.set(ylabel=f"difference\n[{drawn}]", ylim=(factor * low, factor * high))
    add_legend(axes[0])
    figure.align_ylabels(axes)
    axes[-1].set_xlabel("time [s]")


def _shown(study: Study, name: str, values: np.ndarray) -> tuple[str, float]:
    """Choose the unit in which values of a column are drawn, and the factor from the SI unit to it."""
    si, largest = unit(study.system, name), float(np.abs(values).max())
    return ("deg", 180.0 / np.pi) if si == "rad" and largest >= _SMALL else engineering(si, largest)


def _ideal_label(study: Study) -> str:
    return "ideal joints, rigid links" if study.system.tree.bent else "ideal joints"


def _run_label(study: Study) -> str:
    """Say what the run has and the ideal motion has not."""
    parts = ["clearance"] if study.system.experiment.play else []
    parts += ["flexible links"] if study.system.tree.bent else []
    return f"with {' and '.join(parts)}" if parts else "integrated"


def _limits_after_start(times: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Limits of an axis that leave out the microseconds in which a centred journal takes up its load."""
    settled = values[times >= times[0] + 0.005 * np.ptp(times)]
    low, high = float(settled.min()), float(settled.max())
    margin = 0.08 * (high - low) or 1.0
    return low - margin, high + margin
