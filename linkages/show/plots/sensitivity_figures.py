"""The matrix of a run's sensitivities, and the sentences about the largest of them."""

from __future__ import annotations

import math
import textwrap
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from linkages.base.arrays import Array
from linkages.base.palette import GRID_LINE, LINE, shade, written_on
from linkages.explore.sensitivity import Sensitivities
from linkages.show.plots.names import name_of_number, name_of_output, name_of_value, sentence
from linkages.show.plots.panels import make_panels, narrow, note, say
from linkages.show.plots.quantities import number
from linkages.show.plots.style import figure_style, small_text

_LEAST = 1e-4  # change with 1 % of a value below which a cell is empty
_TOLD = 5e-4  # change with 1 % of a value from which a sentence tells it
_COLUMNS = 12, 6  # most columns of a matrix, and in one column of a page
_FLAT = 5, 3  # most columns whose headings are horizontal
_ROW, _HEAD = 0.24, 1.1  # height of a row and of the headings [in at 9 pt]
_LETTERS = 18, 24  # of a line of a heading, of a row's name


class Matrix(NamedTuple):
    """Names of rows and of columns, and changes (rows, columns) with 1 % of a value; NaN where none is predicted."""

    rows: list[str]
    columns: list[str]
    changes: Array


def strongest(found: Sensitivities) -> list[str]:
    """Tell for each peak the value that changes it most, the largest change first; small changes are not told."""
    best = []
    for key in found.times:
        shares = {path: share for path in found.values if (share := found.per_cent(path, key)) is not None}
        if shares:
            path = max(shares, key=lambda path: abs(shares[path]))
            best.append((abs(shares[path]), key, path, shares[path]))
    told = [
        f"1 % more {name_of_value(path)} changes the {name_of_number(key)} by {_signed(share)} %"
        for size, key, path, share in sorted(best, reverse=True)
        if size >= _TOLD
    ]
    if not best:
        return ["No derivative predicts the change of a peak with 1 % of a value"]
    return told or [f"No peak changes by {number(100.0 * _TOLD)} % with 1 % of a value"]


def matrix_of(found: Sensitivities) -> Matrix:
    """Arrange the changes of the peaks with 1 % of each value; the longer list is in rows, the strongest first."""
    keys = [key for key in found.times if found.numbers[key] != 0.0]
    given = [[found.per_cent(path, key) for key in keys] for path in found.values]
    changes = np.array([[np.nan if one is None else one for one in line] for line in given]).reshape(-1, len(keys))
    order = np.argsort(-np.nan_to_num(np.abs(changes)).max(axis=1, initial=0.0), kind="stable")
    paths = [name_of_value(list(found.values)[k]) for k in order]
    outputs = [name_of_output(key.removesuffix(".peak")) for key in keys]
    table = Matrix(paths, outputs, changes[order])
    return table if len(paths) > len(keys) else Matrix(outputs, paths, table.changes.T)


def cell(share: float) -> str:
    """Write a change in per cent for a cell: "-" if it is small, "?" if it is not predicted."""
    return "?" if math.isnan(share) else "-" if abs(share) < _LEAST else _signed(share)


def matrix_figure(found: Sensitivities) -> Figure:
    """Draw the changes of all peaks with 1 % of each value as one matrix: cells in per cent, coloured by size."""
    table = matrix_of(found)
    with figure_style():
        most = _COLUMNS[narrow()]
        parts = [range(k, min(k + most, len(table.columns))) for k in range(0, len(table.columns), most)]
        figure, axes = make_panels(max(len(parts), 1), _HEAD + _ROW * len(table.rows), 1)
        largest = float(np.nanmax(np.abs(table.changes), initial=_LEAST))
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
    """Return the signed part of a change on a logarithmic scale from `_LEAST` to the largest one, for its colour."""
    if not abs(share) >= _LEAST:
        return 0.0
    part = math.log(abs(share) / _LEAST) / max(math.log(largest / _LEAST), 1e-9)
    return math.copysign(0.1 + 0.9 * min(part, 1.0), share)


def _signed(share: float) -> str:
    return f"{'+' if share > 0.0 else ''}{number(100.0 * share, 2)}"
