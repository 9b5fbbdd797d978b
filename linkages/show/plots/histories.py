"""Figures of an assessment over time, with ideal and real joints; `write_figures` writes all figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.base.palette import EDGE, IDEAL, IDEAL_LINE, MEASURED, SOFT
from linkages.input.files.writing import file_name
from linkages.input.model.skeleton import OTHER
from linkages.results.assessment import Assessment
from linkages.results.outputs.registry import unit
from linkages.show.plots.headlines import first_drawn, headline
from linkages.show.plots.journals import contacts_figure, guides_figure, orbits_figure
from linkages.show.plots.names import name_of_output, sentence
from linkages.show.plots.pages import drawn_errors, resolved
from linkages.show.plots.panels import WIDE, narrow
from linkages.show.plots.quantities import quantity
from linkages.show.plots.shown import ShownFigure
from linkages.show.plots.style import (
    COLORS,
    LEGEND,
    axis_label,
    color_for,
    engineering,
    figure_style,
    needs_height,
    readable,
    small_text,
    stacked_axes,
    write_answer,
    write_figure,
)

_GAP, _SECOND, _LEFT = 0.3, 0.16, 0.8  # room above a panel, for a second line, for the scale at the left [in]
_UNBOUNDED = 1e3  # ideal over actual peak from which the ideal one is not drawn whole


def write_figures(assessment: Assessment, folder: Path, errors: Mapping[str, float | None] | None = None) -> list[Path]:
    """Draw all figures of an assessment into an existing folder, in the format of `presented`, and return their paths.

    The figures are: one for each output, journal orbits, blocks in their slots, contacts, flexible links, joint forces,
    torques of drives and motors; missing ones, and forces and torques of zero throughout, are skipped. Variations below
    the errors of the peaks by key (`linkages.results.summary.judge`) are not drawn.
    """
    least = drawn_errors(errors or {}, assessment.noise)
    figures: dict[str, Callable[[Assessment], Figure]] = {
        f"output_{file_name(name)}": partial(output_figure, name=name, errors=least)
        for name in assessment.system.settings.outputs
    }
    if assessment.measured:
        figures["measured"] = measured_figure
    if assessment.system.tree.journals:
        figures["orbits"] = orbits_figure
    if set(assessment.system.tree.play) - set(assessment.system.tree.journals):
        figures["guides"] = guides_figure
    if assessment.contacts:
        figures["impacts"] = contacts_figure
    if assessment.system.tree.deformable:
        figures["links"] = links_figure
    if _acting(assessment, _forces(assessment), least):
        figures["joint_forces"] = partial(forces_figure, errors=least)
    if _acting(assessment, _torques(assessment), least):
        figures["drive_torques"] = partial(torques_figure, errors=least)
    with figure_style():
        return [write_figure(draw(assessment), folder / name) for name, draw in figures.items()]


def output_figure(assessment: Assessment, name: str, errors: Mapping[str, float] | None = None) -> Figure:
    """Draw an output of a link or frame over time; below, the effect of clearance."""
    return _compare(assessment, {name: name_of_output(name)}, errors, 1.4)


def forces_figure(assessment: Assessment, errors: Mapping[str, float] | None = None) -> Figure:
    """Draw the force in each clearance joint, or else in every joint; below each, the difference.

    Forces that are zero throughout are left out, as in gear pairs, unless all are zero.
    """
    labels = _forces(assessment)
    return _compare(assessment, _acting(assessment, labels, errors) or labels, errors)


def torques_figure(assessment: Assessment, errors: Mapping[str, float] | None = None) -> Figure:
    """Draw the torques of all drives that act and of motors, or forces for prismatic joints; below, the difference.

    Torques that are zero throughout are left out, unless all are zero.
    """
    labels = _torques(assessment)
    return _compare(assessment, _acting(assessment, labels, errors) or labels, errors)


def _forces(assessment: Assessment) -> dict[str, str]:
    """Label the forces of clearance joints, or else of all joints, by column."""
    names = assessment.system.tree.play or tuple(assessment.system.joints)
    return {f"{name}.force": name_of_output(f"{name}.force") for name in names}


def _torques(assessment: Assessment) -> dict[str, str]:
    """Label the torques and forces of actuators, or else of all drives, by column."""
    system, labels = assessment.system, {}
    for name in system.actuators or system.drives:
        kind = "force" if unit(system, f"{name}.torque") == "N" else "torque"
        labels[f"{name}.torque"] = f"{kind} of {name}"
    return labels


def _acting(assessment: Assessment, labels: Mapping[str, str], errors: Mapping[str, float] | None) -> dict[str, str]:
    """Keep the labels of columns that are not zero throughout, within their errors, in the run and the ideal motion."""
    least, motions = errors or assessment.noise, [one for one in (assessment.run, assessment.ideal) if one is not None]
    return {
        name: label
        for name, label in labels.items()
        if any(name in one.columns and resolved(one[name], least.get(name, 0.0)).any() for one in motions)
    }


def measured_figure(assessment: Assessment) -> Figure:
    """Draw each measured curve over the run, and below it the difference."""
    colors = assessment.system.colors
    found = assessment.measured
    figure = ShownFigure(figsize=(WIDE, 0.8 + 3.0 * len(found)))
    axes = stacked_axes(figure, [3, 1] * len(found), _GAP, _LEFT)
    told = []
    for (name, one), top, bottom in zip(found.items(), axes[::2], axes[1::2], strict=True):
        run, (first, last) = assessment.run, one.time[[0, -1]]
        near = (run.time >= first) & (run.time <= last)
        drawn, factor = _shown(assessment, name, np.concatenate([one.values, one.computed]))
        top.plot(one.time, factor * one.values, ".", color=MEASURED, ms=2.5, label="measured")
        color = color_for(colors, name)
        top.plot(run.time[near], factor * run[name][near], color=color, lw=1.2, label="computed")
        top.set_ylabel(f"[{drawn or 1}]")
        si, off = unit(assessment.system, name), float(np.abs(one.residual).max())
        told.append(f"{name_of_output(name)}: off by up to {quantity(off, si, 3)}")
        write_answer(top, told[-1])
        drawn, factor = _shown(assessment, name, one.residual)
        bottom.plot(one.time, factor * one.residual, color=SOFT, lw=0.8)
        bottom.set_ylabel(f"[{drawn or 1}]")
        write_answer(bottom, "", "measured less computed")
    figure.legend(
        *axes[0].get_legend_handles_labels(), ncols=2, loc="lower right", borderaxespad=0.1, fontsize=small_text()
    )
    figure.set_label(". ".join(map(sentence, told)) + ".")
    figure.align_ylabels(axes)
    axes[-1].set_xlabel("time [s]", loc="left")
    return figure


def _compare(
    assessment: Assessment, labels: Mapping[str, str], errors: Mapping[str, float] | None, around: float = 0.8
) -> Figure:
    """Draw columns of the ideal motion and the run, and below each the difference; `around` is for margins [inches].

    An effect that is too small to be seen gets most of the height. A figure for one column of a page has no panels of
    differences: their largest values are in the text. An integrated ideal linkage has rigid links without deformation
    columns.
    """
    figure = ShownFigure(figsize=(WIDE, around + 3.0 * len(labels)))
    errors, small = errors or assessment.noise, narrow()
    told = {name: headline(assessment, name, label, errors.get(name, 0.0)) for name, label in labels.items()}
    both = [name for name in labels if told[name].difference and not small]
    heights = [height for name in labels for height in ((1, 2) if told[name].alike else (3, 1))[: 1 + (name in both)]]
    second = small or any(one.is_long for one in told.values())
    axes = stacked_axes(figure, heights, _GAP + second * _SECOND, _LEFT)
    panels = iter(axes)
    for name in labels:
        top, one = next(panels), told[name]
        _draw_both(assessment, top, name, errors.get(name, 0.0), small)
        write_answer(top, *(one.short if small else one.broken), second)
        if name in both:
            bottom = next(panels)
            late = _draw_difference(assessment, bottom, name, errors.get(name, 0.0))
            write_answer(bottom, "", f"difference from ideal joints {one.difference}{late}")
    handles = axes[0].get_legend_handles_labels()
    legend = figure.legend(*handles, ncols=2, loc="lower right", borderaxespad=0.1, fontsize=small_text())
    if len({color_for(assessment.system.colors, name) for name in labels}) > 1:
        legend.get_lines()[-1].set_color(OTHER)  # of no single link
    figure.align_ylabels(axes)
    axes[-1].set_xlabel("time [s]", loc="left")
    axes[-1].set_xlim(first_drawn(assessment), assessment.run.time[-1])
    figure.set_label(". ".join(sentence(one.answer) for one in told.values()) + ".")
    return figure


def _draw_both(assessment: Assessment, axis: Axes, name: str, error: float, small: bool) -> None:
    """Draw a column of the run, and of the ideal motion behind it."""
    system, run, ideal = assessment.system, assessment.run, assessment.ideal
    late = run.time >= first_drawn(assessment)
    values = resolved(run[name], error)
    compared = ideal is not None and name in ideal.columns
    perfect = resolved(ideal[name], error) if ideal is not None and compared else values
    largest = np.abs(values[late]).max()
    unbounded = np.abs(perfect).max() > _UNBOUNDED * largest > 0.0
    drawn, factor = _shown(assessment, name, values[late] if unbounded else np.concatenate([values[late], perfect]))
    if ideal is not None and compared:
        rigid = "ideal joints, rigid links" if system.tree.deformable and not small else "ideal joints"
        axis.plot(ideal.time, factor * perfect, color=IDEAL, lw=IDEAL_LINE, label=rigid)
    flexible = "flexible" if small else "flexible links"
    imperfect = ["clearance"] * bool(system.play) + [flexible] * bool(system.tree.deformable)
    label = f"with {(', ' if small else ' and ').join(imperfect)}" if imperfect else "integrated"
    axis.plot(run.time, factor * values, color=color_for(system.colors, name), label=label)
    axis.set_ylabel(f"[{drawn or 1}]")
    if unbounded:  # at a dead point of the ideal linkage
        axis.set_ylim(-1.1 * factor * largest, 1.1 * factor * largest)
    elif not late.all():
        seen = np.concatenate(
            [values[late], perfect[ideal.time >= run.time[late][0]] if ideal is not None else perfect]
        )
        axis.set_ylim(*(factor * np.array(_limits(seen))))
    if name.endswith(".force"):
        axis.set_ylim(0.0, None)


def _draw_difference(assessment: Assessment, axis: Axes, name: str, error: float) -> str:
    """Draw the difference from the ideal motion; return its larger value at the start, if there is one."""
    apart = assessment.difference
    difference = resolved(apart[name], error)
    low, high = _limits(difference[apart.time >= max(assessment.counted_from, first_drawn(assessment))])
    drawn, factor = _shown(assessment, name, np.array([low, high]))
    axis.plot(apart.time, factor * difference, color=SOFT, lw=0.8)
    axis.set(ylabel=f"[{drawn or 1}]", ylim=(factor * low, factor * high))
    largest = float(np.abs(difference).max())
    outside = difference.min() < low or difference.max() > high
    return f"; at the start {quantity(largest, unit(assessment.system, name), 3)}" if outside else ""


def _shown(assessment: Assessment, name: str, values: np.ndarray) -> tuple[str, float]:
    """Choose the drawn unit of a column, and the factor from the SI unit."""
    return readable(unit(assessment.system, name), float(np.abs(values).max()))


def _limits(values: np.ndarray) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    margin = 0.08 * (high - low) or 1.0
    return low - margin, high + margin


def links_figure(assessment: Assessment) -> Figure:
    """Draw deflections and the largest stress of each flexible link over time, and the strain energy of all.

    Next to each stress is its place along the link at each time.
    """
    system, run = assessment.system, assessment.run
    names = list(system.tree.deformable)
    figure = ShownFigure(figsize=(WIDE, 0.8 + 3.2 * len(names) + 1.4), layout="constrained")
    small = narrow()
    needs_height(figure, 1.25 * (2 * len(names) + 1))
    grid = figure.add_gridspec(2 * len(names) + 1, 1 if small else 2, width_ratios=[3] if small else [3, 1])
    strain = figure.add_subplot(grid[-1, 0])
    left, told = [strain], []
    for k, name in enumerate(names):
        deflection, stress = (figure.add_subplot(grid[2 * k + row, 0], sharex=strain) for row in (0, 1))
        frames = [frame.name for frame in system.frames if frame.link == name]
        moved, most = {frame: run[f"{frame}.deflection"] for frame in frames}, run[f"{name}.deflection"]
        unit, factor = engineering("m", float(most.max()))
        deflection.plot(run.time, factor * most, color=EDGE, lw=0.9, label="largest")
        for (frame, values), color in zip(moved.items(), COLORS * len(moved), strict=False):
            if np.abs(values).max() > 1e-6 * most.max():  # without the ends, which are on the chord
                deflection.plot(run.time, factor * values, color=color, lw=0.9, label=frame)
        deflection.set_ylabel(axis_label("deflection", unit, "\n"))
        bent = f"{name}: bent by {quantity(float(most.max()), 'm', 3)}"
        told.append(f"{bent}, largest stress {quantity(float(run[f'{name}.stress'].max()), 'Pa')}")
        deflection.set_title(bent, loc="left", fontweight="bold", fontsize="medium")
        deflection.legend(**LEGEND, fontsize=small_text(), handlelength=1.2, columnspacing=1.0)
        values, place, color = run[f"{name}.stress"], run[f"{name}.stress_place"], color_for(system.colors, name)
        unit, factor = engineering("Pa", float(values.max()))
        stress.plot(run.time, factor * values, color=color, lw=1.0)
        stress.set_ylabel(axis_label("largest stress", unit, "\n"))
        top = int(values.argmax())
        stress.plot(run.time[top], factor * values[top], "o", color=OTHER, ms=4)
        left += [deflection, stress]
        if small:
            continue
        where = figure.add_subplot(grid[2 * k + 1, 1], sharey=stress)
        length = sum(piece.ends[1] - piece.ends[0] for piece in system.tree.deformable[name])
        along, scale = engineering("m", length)
        where.plot(scale * place, factor * values, ".", color=color, ms=1.5)
        where.plot(scale * place[top], factor * values[top], "o", color=OTHER, ms=4)
        where.set(xlim=(0.0, scale * length), xlabel=axis_label("place along\nthe beam", along))
        where.tick_params(labelleft=False)
    unit, factor = engineering("J", float(run["strain_energy"].max()))
    strain.plot(run.time, factor * run["strain_energy"], color=OTHER, lw=0.9)
    strain.set(xlabel="time [s]", ylabel=axis_label("strain energy", unit, "\n"))
    figure.align_ylabels(left)
    figure.set_label(". ".join(map(sentence, told)) + ".")
    return figure
