"""Figures of peaks over the values of one variable (small panels) and of two (heat maps with contours)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from linkages.base.arrays import Array
from linkages.input.model.skeleton import colors_of
from linkages.show.plots.shown import new_figure
from linkages.show.plots.style import COLORS, LEGEND, axis_label, color_for, engineering, figure_style

if TYPE_CHECKING:
    from linkages.explore.grid import Grid
    from linkages.explore.sweep import Sweep
    from linkages.input.model.mechanism import Mechanism

_LEVELS = 8  # contours of a map, about
_INSIDE = 0.47  # of the map's size: distance of labels from its middle
_FLAT = 1e-9  # relative range of peaks below which a map has no contours
_PANEL = 3.15, 2.3  # width and height of a panel of peaks [in]


def peaks_figure(sweep: Sweep, units: Mapping[str, str], mechanism: Mechanism | None = None) -> Figure:
    """Draw the mean of the revolutions' peaks over the variable, a small panel for each output.

    Parameters
    ----------
    sweep : Sweep
        From `linkages.sweep`.
    units : mapping of str to str
        SI units of the outputs.
    mechanism : Mechanism, optional
        Gives each output the colour of its link.
    """
    columns = min(len(sweep.names), 2)
    rows = -(-len(sweep.names) // columns)
    x, label = _axis(sweep.path, sweep.unit, [point.value for point in sweep.points])
    colors = None if mechanism is None else colors_of(mechanism)
    with figure_style():
        height, width = 0.3 + _PANEL[1] * rows, _PANEL[0] * columns
        figure, axes = new_figure(height, rows, columns, width, squeeze=False)
        for axis in axes.flat[len(sweep.names) :]:
            axis.set_visible(False)
        for axis, name in zip(axes.flat, sweep.names, strict=False):
            y = np.array([point.mean_peak(name) for point in sweep.points])
            unit, factor = engineering(units[name], _largest(y))
            axis.plot(x, factor * y, ".-", color=color_for(colors, name), lw=1.1, ms=4)
            axis.set(xlabel=label, ylabel=f"{name}\n{axis_label('peak', unit)}")
            axis.ticklabel_format(useOffset=False)
        return figure


def map_figure(grid: Grid, name: str, unit: str, limit: float | None = None) -> Figure:
    """Draw the mean of the revolutions' peaks of an output over two variables: a heat map with contours.

    Parameters
    ----------
    grid : Grid
        From `linkages.sweep_grid`.
    name : str
        Name of the output.
    unit : str
        Its SI unit.
    limit : float, optional
        Value in the SI unit whose line is drawn.
    """
    (x, across), (y, up) = map(_axis, grid.paths, grid.units, grid.values)
    peaks = grid.peaks(name).T
    shown, factor = engineering(unit, _largest(peaks))
    z = np.ma.masked_invalid(factor * peaks)
    with figure_style():
        figure, axis = new_figure(3.9, width=5.4)
        axis.grid(False)
        mesh = axis.pcolormesh(x, y, z, shading="nearest", cmap="viridis", rasterized=True)
        bar = figure.colorbar(mesh, ax=axis)
        bar.set_label(f"peak of {axis_label(name, shown)}")
        bar.ax.ticklabel_format(useOffset=False)
        if varies := bool(z.count()) and float(z.max() - z.min()) > _FLAT * _largest(peaks) * factor:
            lines = axis.contour(x, y, z, levels=_LEVELS, colors="white", linewidths=0.7)
            low, size = np.array([x.min(), y.min()]), np.array([np.ptp(x), np.ptp(y)])
            middles = [_middle((max(parts, key=len) - low) / size) for parts in lines.allsegs if any(map(len, parts))]
            places = [low + size * at for at in middles if np.abs(at - 0.5).max() < _INSIDE]
            for text in axis.clabel(lines, fontsize="small", manual=places):
                text.set_path_effects([withStroke(linewidth=1.5, foreground="0.3")])
        marks = []
        if limit is not None and varies and z.min() < factor * limit < z.max():
            axis.contour(x, y, z, levels=[factor * limit], colors=COLORS[1], linewidths=2.2)
            marks.append(Line2D([], [], color=COLORS[1], lw=2.2, label=f"limit {factor * limit:.5g} {shown}"))
        failed = np.argwhere(np.isnan(peaks))
        if len(failed):
            marks += axis.plot(
                x[failed[:, 1]], y[failed[:, 0]], "x", color="0.4", ms=4, clip_on=False, label="no result"
            )
        if marks:
            axis.legend(handles=marks, **LEGEND)
        axis.set(xlabel=across, ylabel=up, xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
        axis.ticklabel_format(useOffset=False)
        return figure


def _axis(path: str, si: str, values: Sequence[float]) -> tuple[Array, str]:
    """Return the values of a variable in a readable unit, and the label of their axis."""
    unit, factor = engineering(si, max(map(abs, values)))
    return factor * np.array(values), axis_label(path, unit)


def _middle(line: Array) -> Array:
    """Return the point (2,) in the middle of a line (n, 2): its label is on no edge of the map."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    return np.array([np.interp(0.5 * way[-1], way, values) for values in line.T])


def _largest(values: Array) -> float:
    """Return the largest finite magnitude, 0 without any."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
