"""Figures of peaks over the values of one variable (small panels) and of two (heat maps with contours)."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm, Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from linkages.base.arrays import Array
from linkages.base.palette import LIMIT, PAPER, SCALE, SOFT, written_on
from linkages.input.model.skeleton import colors_of
from linkages.show.plots.names import name_of_output, name_of_value
from linkages.show.plots.panels import legend_below, make_panels, say
from linkages.show.plots.quantities import quantity
from linkages.show.plots.style import axis_label, color_for, engineering, figure_style, small_text

if TYPE_CHECKING:
    from linkages.explore.grid import Grid
    from linkages.explore.sweep import Sweep
    from linkages.input.model.mechanism import Mechanism

_LEVELS = 8  # contours of a map, about
_INSIDE = 0.47  # of the map's size: distance of labels from its middle
_FLAT = 1e-9  # relative range of peaks below which a map has no contours
_SMOOTH = 12  # values of both variables from which a map has contours
_RATIO = 5.0  # largest over smallest value above which colours are logarithmic
_COLUMNS, _ROWS = 10, 14  # most cells in which values are written
_LETTERS = 22  # of a line of a label
_HEIGHT = 2.2  # of a panel of peaks [in at 9 pt]


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
    x, label = _axis(sweep.path, sweep.unit, [point.value for point in sweep.points])
    colors = None if mechanism is None else colors_of(mechanism)
    with figure_style():
        figure, axes = make_panels(len(sweep.names), _HEIGHT)
        for axis, name in zip(axes, sweep.names, strict=True):
            y = np.array([point.mean_peak(name) for point in sweep.points])
            unit, factor = engineering(units[name], _largest(y))
            axis.plot(x, factor * y, ".-", color=color_for(colors, name), ms=4)
            told = textwrap.fill(f"peak of the {name_of_output(name)}", _LETTERS)
            axis.set(xlabel=label, ylabel=axis_label(told, unit))
            axis.ticklabel_format(useOffset=False)
        say(figure, *extremes(sweep, units))
        return figure


def extremes(sweep: Sweep, units: Mapping[str, str]) -> list[str]:
    """Tell where the peak that changes most is least and largest."""
    peaks = {name: np.array([point.mean_peak(name) for point in sweep.points]) for name in sweep.names}
    known = {name: y for name, y in peaks.items() if np.isfinite(y).any() and _largest(y) > 0.0}
    if not known:
        return []
    name = max(known, key=lambda name: float(np.nanmax(known[name]) - np.nanmin(known[name])) / _largest(known[name]))
    (low, at_low), (high, at_high) = (
        (quantity(float(y), units[name]), quantity(sweep.points[k].value, sweep.unit, 3))
        for y, k in ((known[name][k], k) for k in (int(np.nanargmin(known[name])), int(np.nanargmax(known[name]))))
    )
    return [f"Peak of the {name_of_output(name)}: {low} at {at_low}, {high} at {at_high}"]


def map_figure(grid: Grid, name: str, unit: str, limit: float | None = None) -> Figure:
    """Draw the mean of the revolutions' peaks of an output over two variables: a heat map.

    A coarse map has the value in each cell and hatched cells beyond the limit. From `_SMOOTH` values of both variables
    on it has contours instead, which between few values would contradict the cells.

    Parameters
    ----------
    grid : Grid
        From `linkages.sweep_grid`.
    name : str
        Name of the output.
    unit : str
        Its SI unit.
    limit : float, optional
        Value in the SI unit that should not be exceeded.
    """
    (x, across), (y, up) = map(_axis, grid.paths, grid.units, grid.values)
    peaks = grid.peaks(name).T
    shown, factor = engineering(unit, _largest(peaks))
    z = np.ma.masked_invalid(factor * peaks)
    most = None if limit is None else factor * limit
    with figure_style():
        figure, (axis,) = make_panels(1, 3.7)
        axis.grid(False)
        mesh = axis.pcolormesh(x, y, z, shading="nearest", cmap=SCALE, norm=_norm(z), rasterized=True)
        bar = figure.colorbar(mesh, ax=axis)
        bar.set_label(axis_label(f"peak of the {name_of_output(name)}", shown))
        if isinstance(mesh.norm, LogNorm):
            bar.ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))
        bar.ax.yaxis.set_minor_formatter(NullFormatter())
        marks: list[Any] = []
        if min(z.shape) >= _SMOOTH:
            marks += _contours(axis, x, y, z, most, shown)
        else:
            _values(axis, x, y, z, mesh)
            marks += _beyond(axis, x, y, z, most, shown)
        failed = np.argwhere(np.isnan(peaks))
        if len(failed):
            marks += axis.plot(
                x[failed[:, 1]], y[failed[:, 0]], "x", color=SOFT, ms=4, clip_on=False, label="no result"
            )
        say(figure, *_told(grid, peaks, name, unit, limit))
        if marks:
            legend_below(figure, entries={str(mark.get_label()): mark for mark in marks})
        axis.set(xlabel=across, ylabel=up)
        axis.ticklabel_format(useOffset=False)
        return figure


def _told(grid: Grid, peaks: Array, name: str, unit: str, limit: float | None) -> list[str]:
    """Tell the range of a map, or how many of its cells are beyond the limit."""
    found = peaks[np.isfinite(peaks)]
    if not found.size:
        return []
    low, high = (quantity(float(one), unit) for one in (found.min(), found.max()))
    said = f"Peak of the {name_of_output(name)}: {low} to {high}"
    if limit is None:
        return [said]
    return [f"{said}; {int((found > limit).sum())} of {found.size} cells above {quantity(limit, unit)}"]


def _norm(z: Any) -> Normalize | None:
    """Return logarithmic colours for positive values whose ratio is large; None for linear ones."""
    return LogNorm(z.min(), z.max()) if z.count() and z.max() > _RATIO * z.min() > 0.0 else None


def _contours(axis: Axes, x: Array, y: Array, z: Any, limit: float | None, shown: str) -> list[Line2D]:
    """Draw contours with their values, and the line of the limit; return what the legend has."""
    if not z.count() or float(z.max() - z.min()) <= _FLAT * float(np.abs(z).max()):
        return []
    lines = axis.contour(x, y, z, levels=_LEVELS, colors=PAPER, linewidths=0.7)
    low, size = np.array([x.min(), y.min()]), np.array([np.ptp(x), np.ptp(y)])
    middles = [_middle((max(parts, key=len) - low) / size) for parts in lines.allsegs if any(map(len, parts))]
    places = [low + size * at for at in middles if np.abs(at - 0.5).max() < _INSIDE]
    for text in axis.clabel(lines, fontsize=small_text(), manual=places):
        text.set_path_effects([withStroke(linewidth=1.5, foreground=SOFT)])
    if limit is None or not z.min() < limit < z.max():
        return []
    axis.contour(x, y, z, levels=[limit], colors=LIMIT, linewidths=2.2)
    return [Line2D([], [], color=LIMIT, lw=2.2, label=f"limit {limit:.4g} {shown}")]


def _values(axis: Axes, x: Array, y: Array, z: Any, mesh: QuadMesh) -> None:
    """Write the value into each cell, if the cells have room for it."""
    if len(x) > _COLUMNS or len(y) > _ROWS:
        return
    for (row, column), value in np.ndenumerate(z):
        if value is not np.ma.masked:
            cell = to_hex(np.asarray(mesh.to_rgba(value)).tolist())
            look: dict[str, Any] = {"color": written_on(cell), "ha": "center", "va": "center", "fontsize": small_text()}
            text = axis.text(float(x[column]), float(y[row]), f"{value:.3g}", **look)
            text.set_path_effects([withStroke(linewidth=3.0, foreground=cell)])  # readable on a hatching


def _beyond(axis: Axes, x: Array, y: Array, z: Any, limit: float | None, shown: str) -> list[Rectangle]:
    """Hatch the cells whose values exceed the limit; return what the legend has."""
    marks: list[Rectangle] = []
    look: dict[str, Any] = {"fill": False, "hatch": "////", "edgecolor": LIMIT, "linewidth": 0.0}
    left, below = _edges(x), _edges(y)
    for row, column in np.argwhere((z > limit).filled(False)) if limit is not None else ():
        sides = left[column + 1] - left[column], below[row + 1] - below[row]
        axis.add_patch(Rectangle((left[column], below[row]), *sides, **look))
        marks = marks or [Rectangle((0.0, 0.0), 1.0, 1.0, **look, label=f"above {limit:.4g} {shown}")]
    return marks


def _edges(values: Array) -> Array:
    """Return the edges (n + 1,) of cells around values (n,), halfway between two of them."""
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]])


def _axis(path: str, si: str, values: Sequence[float]) -> tuple[Array, str]:
    """Return the values of a variable in a readable unit, and the label of their axis."""
    unit, factor = engineering(si, max(map(abs, values)))
    return factor * np.array(values), axis_label(name_of_value(path), unit)


def _middle(line: Array) -> Array:
    """Return the point (2,) in the middle of a line (n, 2): its label is on no edge of the map."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    return np.array([np.interp(0.5 * way[-1], way, values) for values in line.T])


def _largest(values: Array) -> float:
    """Return the largest finite magnitude, 0 without any."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
