"""Figures of nonlinear dynamics: Poincare sections, bifurcation diagrams, exponents, spectra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.explore.lyapunov import Exponent
from linkages.explore.spectra import Spectrum
from linkages.explore.sweep import Sweep
from linkages.plots.style import COLORS, figure_style

Array = NDArray[np.float64]

_POINTS, _MEAN, _THIRD = COLORS[:3]

_SHOWN = {"m": ("mm", 1e3), "1": ("", 1.0), "m/s2": ("m/s²", 1.0)}  # units in figures, and factors
_MANY = 3000  # points, from which on they are drawn smaller


def section_figure(section: Mapping[str, Array], x: str, y: str, units: tuple[str, str]) -> Figure:
    """Draw one column of a Poincare section over another.

    Parameters
    ----------
    section : mapping of str to array
        `linkages.explore.sections.Section.strobe`, or what `crossings` returns.
    x, y : str
        Columns.
    units : (str, str)
        Of x and y.
    """
    with figure_style():
        figure = Figure(figsize=(4.6, 4.2), layout="constrained")
        axis = figure.subplots()
        (unit_x, factor_x), (unit_y, factor_y) = (_SHOWN.get(unit, (unit, 1.0)) for unit in units)
        size = 1.6 if len(section[x]) > _MANY else 3.0
        axis.plot(factor_x * section[x], factor_y * section[y], ".", color=_POINTS, ms=size, mew=0.0)
        axis.set_xlabel(_label(x, unit_x))
        axis.set_ylabel(_label(y, unit_y))
        axis.set_title(f"Poincaré section: {len(section[x])} points", loc="left", fontsize=9)
        return figure


def bifurcation_figure(
    sweep: Sweep,
    units: Mapping[str, str],
    values: str = "",
    panels: Sequence[tuple[str, str]] = (),
    scale: float = 1.0,
    logarithmic: Sequence[str] = (),
) -> Figure:
    """Draw the value at the end of each revolution, or its largest magnitude, over the variable.

    Parameters
    ----------
    sweep : Sweep
    units : mapping of str to str
        Of the columns.
    values : str
        Label of the variable; default: its path.
    panels : sequence of (str, str)
        Column, and "strobe" or "peaks"; default: both of every column.
    scale : float
        The variable is multiplied by it.
    logarithmic : sequence of str
        Columns whose peaks are drawn on a logarithmic axis.
    """
    rows = panels or [(name, kind) for name in sweep.names for kind in ("strobe", "peaks")]
    with figure_style():
        figure = Figure(figsize=(6.3, 0.7 + 2.5 * len(rows)), layout="constrained")
        axes = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (name, kind) in zip(axes, rows, strict=True):
            shown, factor = _SHOWN.get(units[name], (units[name], 1.0))
            _diagram(axis, sweep, name, kind, scale, factor)
            what = "at the end of each revolution" if kind == "strobe" else "peak of each revolution"
            axis.set_ylabel(f"{_label(name, shown)}\n{what}")
            if kind == "peaks" and name in logarithmic:
                axis.set_yscale("log")
        axes[-1].set_xlabel(values or sweep.path)
        figure.align_ylabels(axes)
        return figure


def _diagram(axis: Axes, sweep: Sweep, name: str, kind: str, scale: float, factor: float) -> None:
    x: list[float] = []
    y: list[float] = []
    for point in sweep.points:
        if point.section is not None:
            found = point.section.strobe[name] if kind == "strobe" else point.section.peaks(name)
            x += [scale * point.value] * len(found)
            y += (factor * found).tolist()
    size = 1.6 if len(x) > _MANY else 3.0
    axis.plot(x, y, ".", color=_POINTS, ms=size, mew=0.0, rasterized=True)


def exponent_figure(exponents: Mapping[str, Exponent]) -> Figure:
    """Draw how the largest Lyapunov exponents settle: means up to each revolution, with their standard errors.

    Parameters
    ----------
    exponents : mapping of str to Exponent
        By label.
    """
    colors = (_POINTS, _MEAN, _THIRD)
    with figure_style():
        figure = Figure(figsize=(6.3, 3.2), layout="constrained")
        axis = figure.subplots()
        for k, (label, exponent) in enumerate(exponents.items()):
            turns = np.arange(1, len(exponent.growth) + 1)
            color = colors[k % len(colors)]
            value, error = exponent.per_revolution, exponent.error * exponent.period
            axis.plot(turns, exponent.running * exponent.period, color=color, lw=1.1)
            axis.errorbar(
                turns[-1] * 1.01, value, error, color=color, capsize=3.0, fmt="o", ms=3.0,
                label=f"{label}: {value:.2f} ± {error:.2f}",
            )  # fmt: skip
        axis.axhline(0.0, color="0.3", lw=0.8)
        axis.set_xlabel("revolutions")
        axis.set_ylabel("largest Lyapunov exponent\n[1/revolution]")
        axis.legend(loc="best")
        return figure


def spectrum_figure(spectra: Mapping[str, Spectrum], unit: str, drive: float | None = None) -> Figure:
    """Draw power spectral densities of one quantity.

    Parameters
    ----------
    spectra : mapping of str to Spectrum
        By label.
    unit : str
        Of the column.
    drive : float, optional
        Frequency of the drive, marked with a line [Hz].
    """
    colors = (_POINTS, _MEAN, _THIRD)
    with figure_style():
        figure = Figure(figsize=(6.3, 3.4), layout="constrained")
        axis = figure.subplots()
        for k, (label, found) in enumerate(spectra.items()):
            inner = slice(1, None)  # the mean was removed
            axis.loglog(
                found.frequency[inner],
                found.density[inner],
                color=colors[k % len(colors)],
                lw=0.8,
                label=label,
            )
        if drive is not None:
            axis.axvline(drive, color="0.3", lw=0.8, ls="--", label=f"drive, {drive:.4g} Hz")
        axis.set_xlabel("frequency [Hz]")
        name = next(iter(spectra.values())).name
        shown = unit.replace("s2", "s²")
        axis.set_ylabel(f"{name}: power spectral density\n[({shown})²/Hz]")
        axis.legend(loc="best")
        return figure


def _label(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name
