"""Figures of nonlinear dynamics: Poincaré sections, bifurcation diagrams, branches, Lyapunov exponents, spectra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.base.arrays import Array
from linkages.base.errors import listed
from linkages.base.palette import EDGE, INK, SOFT
from linkages.explore.periodic.multipliers import BRANCH_POINT, DOUBLING, FOLD, GRAZING, NEIMARK_SACKER
from linkages.input.model.skeleton import colors_of
from linkages.show.plots.names import name_of_output, name_of_value
from linkages.show.plots.panels import legend_below, make_panels, say
from linkages.show.plots.quantities import number
from linkages.show.plots.style import COLORS, axis_label, color_for, engineering, figure_style, typeset
from linkages.show.plots.swept import extremes

if TYPE_CHECKING:
    from linkages.explore.lyapunov import Exponent
    from linkages.explore.periodic.branches import Branch, Branches
    from linkages.explore.periodic.motion import PeriodicMotion
    from linkages.explore.spectra import Spectrum
    from linkages.explore.sweep import Sweep
    from linkages.input.model.mechanism import Mechanism

_SIZES = ((3000, 1.6), (300, 4.0), (0, 12.0))  # areas of marks, by the smallest number of marks
#: Mark of each kind of bifurcation.
_MARKS = {FOLD: "o", DOUBLING: "s", NEIMARK_SACKER: "^", GRAZING: "x", BRANCH_POINT: "D"}


def section_figure(section: Mapping[str, Array], x: str, y: str, units: tuple[str, str]) -> Figure:
    """Draw one column of a Poincaré section over another.

    Parameters
    ----------
    section : mapping of str to (n,) array
        `linkages.explore.sections.Section.strobe`, or the result of `linkages.crossings`.
    x, y : str
        Names of the columns.
    units : (str, str)
        SI units of x and y.
    """
    largest = (float(np.abs(section[name]).max(initial=0.0)) for name in (x, y))
    (unit_x, factor_x), (unit_y, factor_y) = map(engineering, units, largest)
    with figure_style():
        figure, (axis,) = make_panels(1, 4.2)
        _draw_points(axis, factor_x * section[x], factor_y * section[y])
        axis.set(xlabel=axis_label(name_of_output(x), unit_x), ylabel=axis_label(name_of_output(y), unit_y))
        say(figure, f"Poincaré section: {len(section[x])} points")
        return figure


def bifurcation_figure(
    sweep: Sweep,
    units: Mapping[str, str],
    label: str = "",
    panels: Sequence[tuple[str, str]] = (),
    scale: float = 1.0,
    logarithmic: Sequence[str] = (),
    mechanism: Mechanism | None = None,
) -> Figure:
    """Draw the value at the end of each revolution, or its largest magnitude, over the variable.

    Parameters
    ----------
    sweep : Sweep
        From `linkages.sweep`.
    units : mapping of str to str
        SI units of the outputs.
    label : str
        Name of the variable; default: its path.
    panels : sequence of (str, str)
        Column, and "strobe" or "peaks"; default: both of every column.
    scale : float
        Factor on the variable.
    logarithmic : sequence of str
        Columns whose peaks are drawn on a logarithmic axis.
    mechanism : Mechanism, optional
        Gives each column the colour of its link.
    """
    colors = None if mechanism is None else colors_of(mechanism)
    rows = panels or [(name, kind) for name in sweep.names for kind in ("strobe", "peaks")]
    with figure_style():
        figure, axes = make_panels(len(rows), 2.3, 1, sharex=True)
        for axis, (name, kind) in zip(axes, rows, strict=True):
            x, y = _swept(sweep, name, kind)
            unit, factor = engineering(units[name], float(np.abs(y).max(initial=0.0)))
            _draw_points(axis, scale * x, factor * y, color_for(colors, name))
            what = "at the end of each revolution" if kind == "strobe" else "peak of each revolution"
            axis.set_ylabel(f"{axis_label(name_of_output(name), unit)}\n{what}")
            if kind == "peaks" and name in logarithmic:
                axis.set_yscale("log")
            else:
                axis.ticklabel_format(axis="y", useOffset=False)
        axes[-1].set_xlabel(label or axis_label(name_of_value(sweep.path), typeset(sweep.unit)))
        figure.align_ylabels(axes)
        say(figure, *extremes(sweep, units))
        return figure


def exponent_figure(exponents: Mapping[str, Exponent]) -> Figure:
    """Draw the convergence of largest Lyapunov exponents: means up to each revolution, with standard errors.

    Parameters
    ----------
    exponents : mapping of str to Exponent
        From `linkages.largest_exponent`, by label.
    """
    with figure_style():
        figure, (axis,) = make_panels(1, 3.0)
        for k, (label, exponent) in enumerate(exponents.items()):
            turns = np.arange(1, len(exponent.growth) + 1)
            color = COLORS[k % len(COLORS)]
            value, error = exponent.per_revolution, exponent.error * exponent.period
            axis.plot(turns, exponent.running * exponent.period, color=color, lw=1.1)
            axis.errorbar(
                turns[-1] * 1.01, value, error, color=color, capsize=3.0, fmt="o", ms=3.0,
                label=f"{label}: {value:.2f} ± {error:.2f}",
            )  # fmt: skip
        axis.axhline(0.0, color=SOFT, lw=0.8)
        axis.set(xlabel="revolutions", ylabel="largest Lyapunov exponent\n[1/revolution]")
        chaotic = [label for label, one in exponents.items() if one.per_revolution > 2.0 * one.error * one.period]
        say(figure, f"Neighbouring motions part: {listed(chaotic)}" if chaotic else "Neighbouring motions do not part")
        legend_below(figure)
        return figure


def spectrum_figure(spectra: Mapping[str, Spectrum], unit: str, drive: float | None = None) -> Figure:
    """Draw power spectral densities of one column.

    Parameters
    ----------
    spectra : mapping of str to Spectrum
        From `linkages.spectrum`, by label.
    unit : str
        SI unit of the output.
    drive : float, optional
        Frequency of the drive, marked with a line [Hz].
    """
    with figure_style():
        figure, (axis,) = make_panels(1, 3.2)
        for k, (label, found) in enumerate(spectra.items()):  # without the zero frequency, as the mean was removed
            color = COLORS[k % len(COLORS)]
            axis.loglog(found.frequency[1:], found.density[1:], color=color, lw=0.8, label=label)
        if drive is not None:
            axis.axvline(drive, color=SOFT, lw=0.8, ls="--", label=f"drive, {drive:.4g} Hz")
        name = next(iter(spectra.values())).name
        axis.set(
            xlabel="frequency [Hz]", ylabel=f"{name_of_output(name)}:\npower spectral density [({typeset(unit)})²/Hz]"
        )
        legend_below(figure)
        return figure


def _loudest(spectra: Mapping[str, Spectrum]) -> list[str]:
    """Tell at which frequency each spectrum is largest."""
    tops = {label: one.frequency[1:][np.argmax(one.density[1:])] for label, one in spectra.items()}
    return [f"Most power at {', '.join(f'{number(float(at), 3)} Hz ({label})' for label, at in tops.items())}"]


def _draw_points(axis: Axes, x: Sequence[float] | Array, y: Sequence[float] | Array, color: str = COLORS[0]) -> None:
    size = next(size for count, size in _SIZES if len(x) >= count)
    axis.plot(x, y, ".", color=color, ms=size, mew=0.0, rasterized=True)


def branches_figure(
    found: Branches, units: Mapping[str, str], label: str = "", scale: float = 1.0, sweep: Sweep | None = None
) -> Figure:
    """Draw the value at the end of each period of the drives, and the largest magnitude in it, over the variable.

    Lines are solid where the motion is stable, dashed where it is not; a sweep over the same variable gives points.
    `units` are the SI units of the outputs, `scale` is a factor on the variable, `label` its name.
    """
    rows = [(name, kind) for name in found.outputs for kind in ("strobe", "peaks")]
    motions = [motion for branch in found.branches for motion in branch.motions]
    with figure_style():
        figure, axes = make_panels(len(rows), 2.3, 1, sharex=True)
        for axis, (name, kind) in zip(axes, rows, strict=True):
            values = [motion.outputs.values(name, kind) for motion in motions if motion.outputs is not None]
            unit, factor = engineering(units[name], max(float(np.abs(part).max()) for part in values))
            if sweep is not None:
                x, y = _swept(sweep, name, kind)
                axis.plot(scale * x, factor * y, ".", color=EDGE, ms=3, zorder=1, label="sweep")
            for k, branch in enumerate(found.branches):
                _draw_branch(axis, branch, name, kind, scale, factor, COLORS[k % len(COLORS)])
            what = "at the end of a period" if kind == "strobe" else "peak in a period"
            axis.set_ylabel(f"{axis_label(name_of_output(name), unit)}\n{what}")
        axes[-1].set_xlabel(label or name_of_value(found.path))
        say(figure, *_events(found))
        legend_below(figure, axes[:1])
        return figure


def _events(found: Branches) -> list[str]:
    """Tell the bifurcations of all branches."""
    kinds = [event.kind for branch in found.branches for event in branch.events]
    told = [f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds)]
    return [f"Bifurcations of the periodic motion: {', '.join(told) or 'none'}"]


def _swept(sweep: Sweep, name: str, kind: str) -> tuple[Array, Array]:
    """Return the values of the variable and of a column of all sections of a sweep."""
    found = [(point.value, point.section.values(name, kind)) for point in sweep.points if point.section is not None]
    x = np.repeat([value for value, _ in found], [len(values) for _, values in found])
    return x, np.concatenate([*(values for _, values in found), np.empty(0)])


def _draw_branch(axis: Axes, branch: Branch, name: str, kind: str, scale: float, factor: float, color: str) -> None:
    """Draw a line for each period of the drives, solid between stable motions, and the bifurcations."""
    motions = _with_events(branch)
    x = scale * np.array([motion.value for motion in motions], dtype=np.float64)
    y = factor * np.array([motion.outputs.values(name, kind) for motion in motions if motion.outputs is not None])
    solid = [all(motion.stable is not False for motion in pair) for pair in pairwise(motions)]
    breaks = [0, *(np.flatnonzero(np.diff(solid)) + 1), len(solid)] if solid else []
    for first, last in pairwise(breaks):
        good = solid[first]
        label = f"{branch.periods} period{'s' if branch.periods > 1 else ''}, {'stable' if good else 'unstable'}"
        for line in y[first : last + 1].T:
            axis.plot(x[first : last + 1], line, color=color, ls="-" if good else "--", lw=1.2, zorder=2, label=label)
    for event in branch.events:
        if event.motion.outputs is None:
            continue
        at = factor * event.motion.outputs.values(name, kind)
        place = np.full(len(at), scale * (event.motion.value or 0.0))
        axis.plot(place, at, _MARKS[event.kind], color=INK, ms=5, mfc="none", zorder=3, ls="", label=event.kind)


def _with_events(branch: Branch) -> list[PeriodicMotion]:
    """Return the motions of a branch with its bifurcations between them."""
    found, rest = [branch.motions[0]], [event for event in branch.events if event.kind != FOLD]
    for motion, ahead in pairwise(branch.motions):
        ends = motion.value or 0.0, ahead.value or 0.0
        while rest and min(ends) <= (rest[0].motion.value or 0.0) <= max(ends):
            found.append(rest.pop(0).motion)
        found.append(ahead)
    return found
