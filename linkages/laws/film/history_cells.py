"""Cells of a film with history, its table, and its memory; see `linkages.laws.film.film_history`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from linkages.kernel import Array, inlined_kernel
from linkages.laws.film.surface.grooves import Groove
from linkages.laws.film.surface.surface_mesh import surface_mesh

#: Entries of the memory of a film: time of its last step [s], place there (2), and from then on the missing volumes of
#: the cells and, as a guess that no result depends on, the last solution.
TIME, PLACE_X, PLACE_Y, MISSING = range(4)
#: Gauss points of a cell around, three in each half.
NODES = 6

_ROOT = math.sqrt(0.6)
# Places in a table of `history_table`: cells around and along, factor for a mirrored half, film step [s], content at
# the start; then for each line its width, the differences of -sin and cos at its faces, cosines and sines at its
# Gauss points; lengths of the cells along; pressure of the cells in grooves, over the largest, -1 elsewhere.
AROUND, ALONG, SIDES, STEP, CONTENT, _HEAD = range(6)
_LINE = 3 + 2 * NODES


def history_table(
    slenderness: float, grooves: Sequence[Groove], cells: tuple[int, int], step: float, content: float
) -> Array:
    """Lay out the cells of a film with history.

    Parameters
    ----------
    slenderness : float
        L/D.
    grooves : sequence of Groove
        In the bearing's frame; their pressures count in parts of the largest.
    cells : (int, int)
        Around, and along half the length; edges of grooves add some.
    step : float
        Film step tau [s].
    content : float
        Film content at the start, 0 to 1.

    Returns
    -------
    table : array of float
        For `film_with_history`.
    """
    mesh = surface_mesh(slenderness, grooves, around=cells[0], along=cells[1])
    largest = max((groove.pressure for groove in grooves), default=0.0) or 1.0
    shares = np.array([*(groove.pressure / largest for groove in grooves), -1.0])
    inner = np.array([-_ROOT, 0.0, _ROOT])
    places = 0.25 * np.concatenate([inner - 1.0, inner + 1.0])  # from the middle, in widths
    nodes = mesh.theta[:, None] + mesh.width[:, None] * places
    sines, cosines = np.diff(np.sin(mesh.faces)), -np.diff(np.cos(mesh.faces))
    lines = np.column_stack([mesh.width, sines, cosines, np.cos(nodes), np.sin(nodes)])
    head = [len(mesh.theta), len(mesh.zeta), 2.0 if mesh.half else 1.0, step, content]
    return np.concatenate([head, lines.ravel(), mesh.height, shares[mesh.groove].ravel()])


@inlined_kernel
def cells_of(table: Array) -> int:
    """Return the number of cells of a table."""
    return int(table[AROUND]) * int(table[ALONG])


def memory_of(table: Array) -> int:
    """Return the number of entries that a film with this table remembers."""
    return MISSING + 2 * cells_of(table)


@inlined_kernel
def remembered_cells(entries: int) -> int:
    """Return the number of missing volumes in a memory of so many entries."""
    return max(entries - MISSING, 0) // 2


@inlined_kernel
def line_of(table: Array, i: int) -> int:
    """First entry of a line of cells."""
    return _HEAD + i * _LINE


@inlined_kernel
def length_of(table: Array, j: int) -> float:
    """Length of the cells j along, in R."""
    return table[_HEAD + int(table[AROUND]) * _LINE + j]


@inlined_kernel
def groove_share(table: Array, i: int, j: int) -> float:
    """Share of a groove's pressure in the largest one; -1 for a cell that is in none."""
    n, m = int(table[AROUND]), int(table[ALONG])
    return table[_HEAD + n * _LINE + m + i * m + j]


@inlined_kernel
def gap_volume(table: Array, i: int, j: int, x: float, y: float) -> float:
    """Volume of the gap in a cell."""
    at = line_of(table, i)
    return length_of(table, j) * (table[at] - x * table[at + 1] - y * table[at + 2])
