"""The matrix of a run's sensitivities as a figure."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from linkages.base.palette import GRID_LINE, LINE, shade, written_on
from linkages.explore.sensitivity import Sensitivities
from linkages.show.plots.changes import LEAST, Matrix, cell, matrix_of, strongest
from linkages.show.plots.names import sentence
from linkages.show.plots.panels import make_panels, narrow, note, say
from linkages.show.plots.style import figure_style, small_text

_COLUMNS = 12, 6  # most columns of a matrix, and in one column of a page
_FLAT = 5, 3  # most columns whose headings are horizontal
_ROW, _HEAD = 0.24, 1.1  # height of a row and of the headings [in at 9 pt]
_LETTERS = 18, 24  # of a line of a heading, of a row's name


def matrix_figure(found: Sensitivities) -> Figure:
    """Draw the changes of all peaks with 1 % of each value as one matrix: cells in per cent, coloured by size."""
    table = matrix_of(found)
    with figure_style():
        most = _COLUMNS[narrow()]
        parts = [range(k, min(k + most, len(table.columns))) for k in range(0, len(table.columns), most)]
        figure, axes = make_panels(max(len(parts), 1), _HEAD + _ROW * len(table.rows), 1)
        largest = float(np.nanmax(np.abs(table.changes), initial=LEAST))
        for axis, part in zip(axes, parts, strict=False):
            _draw(axis, table, part, largest, most)
        say(figure, sentence(strongest(found)[0]))
        note(figure, "Change of peaks with 1 % of each value [%]. -: below 0.01 %, ?: no statement about 1 %.")
        return figure


def _draw(axis: Axes, table: Matrix, part: range, largest: float, most: int) -> None:
    """Draw some columns of a matrix."""
    for row, column in np.ndindex(len(table.rows), len(part)):
        share = float(table.changes[row, part[column]])
        color = shade(_size(share, largest))
        axis.add_patch(Rectangle((column, row), 1.0, 1.0, fc=color, ec=LINE, lw=GRID_LINE))
        look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": small_text(), "color": written_on(color)}
        axis.text(column + 0.5, row + 0.5, cell(share), **look)
    few = len(part) <= _FLAT[narrow()]
    heads = [textwrap.fill(table.columns[k], _LETTERS[0] - 6 * few) for k in part]
    names = [textwrap.fill(one, _LETTERS[1]) if narrow() else one for one in table.rows]
    axis.set(xlim=(0.0, max(len(part), min(most, 4))), ylim=(len(table.rows), 0.0))
    axis.set_xticks(np.arange(len(part)) + 0.5, heads, rotation=0 if few else 90, fontsize=small_text())
    axis.set_yticks(np.arange(len(names)) + 0.5, names, fontsize=small_text())
    axis.tick_params(top=False, labeltop=True, bottom=False, labelbottom=False, left=False)
    axis.grid(False)
    for side in axis.spines.values():
        side.set_visible(False)


def _size(share: float, largest: float) -> float:
    """Return the signed part of a change on a logarithmic scale from `LEAST` to the largest one, for its colour."""
    if not abs(share) >= LEAST:
        return 0.0
    part = math.log(abs(share) / LEAST) / max(math.log(largest / LEAST), 1e-9)
    return math.copysign(0.1 + 0.9 * min(part, 1.0), share)
