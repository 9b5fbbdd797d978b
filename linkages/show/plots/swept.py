"""Figures of peaks over the values of one variable (small panels) and of two (heat maps with contours)."""

from __future__ import annotations

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
from linkages.base.palette import LIMIT, written_on
from linkages.input.model.skeleton import colors_of
from linkages.show.plots.shown import new_figure
from linkages.show.plots.style import LEGEND, axis_label, color_for, engineering, figure_style

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
        figure, axis = new_figure(3.9, width=5.4)
        axis.grid(False)
        mesh = axis.pcolormesh(x, y, z, shading="nearest", cmap="viridis", norm=_norm(z), rasterized=True)
        bar = figure.colorbar(mesh, ax=axis)
        bar.set_label(f"peak of {axis_label(name, shown)}")
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
                x[failed[:, 1]], y[failed[:, 0]], "x", color="0.4", ms=4, clip_on=False, label="no result"
            )
        if marks:
            axis.legend(handles=marks, **LEGEND)
        axis.set(xlabel=across, ylabel=up)
        axis.ticklabel_format(useOffset=False)
        return figure


def _norm(z: Any) -> Normalize | None:
    """Return logarithmic colours for positive values whose ratio is large; None for linear ones."""
    return LogNorm(z.min(), z.max()) if z.count() and z.max() > _RATIO * z.min() > 0.0 else None


def _contours(axis: Axes, x: Array, y: Array, z: Any, limit: float | None, shown: str) -> list[Line2D]:
    """Draw contours with their values, and the line of the limit; return what the legend has."""
    if not z.count() or float(z.max() - z.min()) <= _FLAT * float(np.abs(z).max()):
        return []
    lines = axis.contour(x, y, z, levels=_LEVELS, colors="white", linewidths=0.7)
    low, size = np.array([x.min(), y.min()]), np.array([np.ptp(x), np.ptp(y)])
    middles = [_middle((max(parts, key=len) - low) / size) for parts in lines.allsegs if any(map(len, parts))]
    places = [low + size * at for at in middles if np.abs(at - 0.5).max() < _INSIDE]
    for text in axis.clabel(lines, fontsize="small", manual=places):
        text.set_path_effects([withStroke(linewidth=1.5, foreground="0.3")])
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
            look: dict[str, Any] = {"color": written_on(cell), "ha": "center", "va": "center", "fontsize": "small"}
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
    return factor * np.array(values), axis_label(path, unit)


def _middle(line: Array) -> Array:
    """Return the point (2,) in the middle of a line (n, 2): its label is on no edge of the map."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    return np.array([np.interp(0.5 * way[-1], way, values) for values in line.T])


def _largest(values: Array) -> float:
    """Return the largest finite magnitude, 0 without any."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
