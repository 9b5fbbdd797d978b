"""Figures of nonlinear dynamics: Poincaré sections, bifurcation diagrams, Lyapunov exponents, spectra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from linkages.arrays import Array
from linkages.plots.shown import new_figure
from linkages.plots.style import COLORS, axis_label, engineering, figure_style, typeset

if TYPE_CHECKING:
    from linkages.explore.lyapunov import Exponent
    from linkages.explore.spectra import Spectrum
    from linkages.explore.sweep import Sweep


_SIZES = ((3000, 1.6), (300, 4.0), (0, 12.0))  # areas of marks, by the smallest number of marks


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
        figure, axis = new_figure(4.2, width=4.6)
        _draw_points(axis, factor_x * section[x], factor_y * section[y])
        axis.set(xlabel=axis_label(x, unit_x), ylabel=axis_label(y, unit_y))
        axis.set_title(f"Poincaré section: {len(section[x])} points", loc="left", fontsize=9)
        return figure


def bifurcation_figure(
    sweep: Sweep,
    units: Mapping[str, str],
    label: str = "",
    panels: Sequence[tuple[str, str]] = (),
    scale: float = 1.0,
    logarithmic: Sequence[str] = (),
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
    """
    rows = panels or [(name, kind) for name in sweep.names for kind in ("strobe", "peaks")]
    with figure_style():
        figure, axes = new_figure(0.7 + 2.5 * len(rows), len(rows), 1, sharex=True, squeeze=False)
        axes = axes[:, 0]
        for axis, (name, kind) in zip(axes, rows, strict=True):
            done = [(point.value, point.section) for point in sweep.points if point.section is not None]
            found = [section.values(name, kind) for _, section in done]
            x = np.repeat([scale * value for value, _ in done], [len(values) for values in found])
            y = np.concatenate([*found, np.empty(0)])
            unit, factor = engineering(units[name], float(np.abs(y).max(initial=0.0)))
            _draw_points(axis, x, factor * y)
            what = "at the end of each revolution" if kind == "strobe" else "peak of each revolution"
            axis.set_ylabel(f"{axis_label(name, unit)}\n{what}")
            if kind == "peaks" and name in logarithmic:
                axis.set_yscale("log")
            else:
                axis.ticklabel_format(axis="y", useOffset=False)
        axes[-1].set_xlabel(label or sweep.path)
        figure.align_ylabels(axes)
        return figure


def exponent_figure(exponents: Mapping[str, Exponent]) -> Figure:
    """Draw the convergence of largest Lyapunov exponents: means up to each revolution, with standard errors.

    Parameters
    ----------
    exponents : mapping of str to Exponent
        From `linkages.largest_exponent`, by label.
    """
    with figure_style():
        figure, axis = new_figure(3.2)
        for k, (label, exponent) in enumerate(exponents.items()):
            turns = np.arange(1, len(exponent.growth) + 1)
            color = COLORS[k % len(COLORS)]
            value, error = exponent.per_revolution, exponent.error * exponent.period
            axis.plot(turns, exponent.running * exponent.period, color=color, lw=1.1)
            axis.errorbar(
                turns[-1] * 1.01, value, error, color=color, capsize=3.0, fmt="o", ms=3.0,
                label=f"{label}: {value:.2f} ± {error:.2f}",
            )  # fmt: skip
        axis.axhline(0.0, color="0.3", lw=0.8)
        axis.set(xlabel="revolutions", ylabel="largest Lyapunov exponent\n[1/revolution]")
        axis.legend(loc="best")
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
        figure, axis = new_figure(3.4)
        for k, (label, found) in enumerate(spectra.items()):  # without the zero frequency, as the mean was removed
            color = COLORS[k % len(COLORS)]
            axis.loglog(found.frequency[1:], found.density[1:], color=color, lw=0.8, label=label)
        if drive is not None:
            axis.axvline(drive, color="0.3", lw=0.8, ls="--", label=f"drive, {drive:.4g} Hz")
        name = next(iter(spectra.values())).name
        axis.set(xlabel="frequency [Hz]", ylabel=f"{name}: power spectral density\n[({typeset(unit)})²/Hz]")
        axis.legend(loc="best")
        return figure


def _draw_points(axis: Axes, x: Sequence[float] | Array, y: Sequence[float] | Array) -> None:
    size = next(size for count, size in _SIZES if len(x) >= count)
    axis.plot(x, y, ".", color=COLORS[0], ms=size, mew=0.0, rasterized=True)
