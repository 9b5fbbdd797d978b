"""Pressure and missing oil of a film with history on its cells; see `linkages.laws.film.film_history`.

Each choice of full cells (d = 0) and cavity cells (p = 0) leaves a matrix with a positive diagonal, no positive entry
elsewhere, and dominant columns. So there is one solution, elimination needs no pivots, and block principal pivoting
ends (Judice and Pires, Computers and Operations Research 21, 1994, 587-596). Lines of cells are folded, i next to
n - 1 - i, for a narrow band.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.kernel import Array, Indices, inlined_kernel, kernel
from linkages.laws.film.history_cells import ALONG, AROUND, NODES, SIDES, groove_share, length_of, line_of
from linkages.laws.film.surface.elimination import eliminate

_NOTHING = 1e-12  # deficit, and pressure over the largest, that count as zero: round-off must not choose the set
_TRIES = 10  # changes of many cells at once that do not reduce the number of wrong ones; then single cells change
_MOST = 10_000  # changes of the set; none is known to need more than 50


class Sheet(NamedTuple):
    """Arrays of one solution; face i is the one after cell i around the film."""

    thickness: Array  # integrals of a line: h^-2 and h^-3 over its halves, h^-1 and h^3 over all of it, (n, 6)
    around: Array  # conductances of the faces around, (n, m)
    carried: Array  # Couette flow through them at full content, signed
    along: Array  # conductances along; the first column is the end at zeta < 0, zero of a mirror, (n, m + 1)
    gain: Array  # volume that a cell takes up without a deficit, (n, m)
    most: Array  # part of it that a deficit of 1 takes away


@inlined_kernel
def new_sheet(table: Array) -> Sheet:
    """Make the arrays."""
    n, m = int(table[AROUND]), int(table[ALONG])
    faces = np.empty((n, m)), np.empty((n, m)), np.empty((n, m + 1))
    return Sheet(np.empty((n, 6)), faces[0], faces[1], faces[2], np.empty((n, m)), np.empty((n, m)))


@kernel
def integrate_thickness(table: Array, x: float, y: float, out: Array) -> None:
    """Fill ``out`` (n, 6): integrals over the halves of a line of h^-2 and h^-3, over all of it of h^-1 and h^3."""
    for i in range(len(out)):
        at = line_of(table, i)
        for k in range(6):
            out[i, k] = 0.0
        for k in range(NODES):
            weight = table[at] * (4.0 if k % 3 == 1 else 2.5) / 18.0
            h = 1.0 - x * table[at + 3 + k] - y * table[at + 3 + NODES + k]
            g = 1.0 / h
            half = 0 if k < 3 else 2
            out[i, half] += weight * g * g
            out[i, half + 1] += weight * g * g * g
            out[i, 4] += weight * g
            out[i, 5] += weight * h * h * h


@kernel
def fill_flows(table: Array, speed: float, sheet: Sheet) -> None:
    """Fill conductances and carried flow for a mean surface speed, from the thickness."""
    thickness, around, carried, along = sheet.thickness, sheet.around, sheet.carried, sheet.along
    n, m = around.shape
    for i in range(n):
        after = (i + 1) % n
        for j in range(m):
            here, there = groove_share(table, i, j) < 0.0, groove_share(table, after, j) < 0.0
            square = (thickness[i, 2] if here else 0.0) + (thickness[after, 0] if there else 0.0)
            cube = (thickness[i, 3] if here else 0.0) + (thickness[after, 1] if there else 0.0)
            around[i, j], carried[i, j] = 0.0, 0.0
            if cube > 0.0:
                around[i, j] = length_of(table, j) / (12.0 * cube)
                carried[i, j] = speed * length_of(table, j) * square / cube
        for j in range(m + 1):
            length = 0.0  # between the centres, without grooves
            if j > 0 and groove_share(table, i, j - 1) < 0.0:
                length += 0.5 * length_of(table, j - 1)
            if j < m and groove_share(table, i, j) < 0.0:
                length += 0.5 * length_of(table, j)
            closed = length == 0.0 or (j == 0 and table[SIDES] == 2.0)
            along[i, j] = 0.0 if closed else thickness[i, 5] / (12.0 * length)


@inlined_kernel
def _row(i: int, j: int, n: int, m: int) -> int:
    """Row of a cell in the banded matrix."""
    return (2 * i if i < (n + 1) // 2 else 2 * (n - 1 - i) + 1) * m + j


@kernel
def _assemble(table: Array, sheet: Sheet, supply: float, wet: Indices, band: Array, right: Array) -> None:
    """Fill the banded matrix and the right-hand side for a set of wet cells; others have the unknown -d.

    Parameters
    ----------
    table : array of float
    sheet : Sheet
    supply : float
        Largest pressure of the grooves.
    wet : (n, m) array of int
        1 full or in a groove, 0 in the cavity.
    band : (n m, 4 m + 1) array
        Entry [r, 2 m + c - r] is the one of row r, column c.
    right : (n m,) array
    """
    around, carried, along, gain, most = sheet.around, sheet.carried, sheet.along, sheet.gain, sheet.most
    n, m = around.shape
    width = 2 * m
    for r in range(n * m):
        for k in range(2 * width + 1):
            band[r, k] = 0.0
    for i in range(n):
        last, after = (i - 1) % n, (i + 1) % n
        for j in range(m):
            r = _row(i, j, n, m)
            if groove_share(table, i, j) >= 0.0:
                band[r, width], right[r] = 1.0, supply * groove_share(table, i, j)
                continue
            inflow, outflow = carried[last, j], carried[i, j]
            right[r] = inflow - outflow - gain[i, j]
            if wet[i, j] == 1:
                band[r, width] = around[i, j] + around[last, j] + along[i, j] + along[i, j + 1]
            else:
                band[r, width] = most[i, j] + max(outflow, 0.0) + max(-inflow, 0.0)
            # the neighbours: conductance, and the flow that they carry into this cell
            _couple(wet, band, r, last, j, around[last, j], max(inflow, 0.0))
            _couple(wet, band, r, after, j, around[i, j], max(-outflow, 0.0))
            if j > 0:
                _couple(wet, band, r, i, j - 1, along[i, j], 0.0)
            if j + 1 < m:
                _couple(wet, band, r, i, j + 1, along[i, j + 1], 0.0)


@inlined_kernel
def _couple(wet: Indices, band: Array, r: int, i: int, j: int, conductance: float, carried: float) -> None:
    """Add the entry of a neighbour."""
    n, m = wet.shape
    band[r, 2 * m + _row(i, j, n, m) - r] -= conductance if wet[i, j] == 1 else carried


@inlined_kernel
def _is_wrong(z: float, wet: int, largest: float) -> bool:
    """Whether an unknown has the wrong sign: a full cell's pressure below the cavity's, or a deficit below zero."""
    return z < -_NOTHING * largest if wet == 1 else z > _NOTHING


@kernel
def settle(table: Array, sheet: Sheet, supply: float, guess: Array) -> None:
    """Solve the complementarity; ``guess`` (n m,) becomes the pressure of full cells, minus the deficit of others.

    Cells of the wrong sign change sides, all at once as long as that reduces their number, else the last one alone.
    """
    n, m = sheet.gain.shape
    wet, band, right = np.empty((n, m), np.int64), np.empty((n * m, 4 * m + 1)), np.empty(n * m)
    for i in range(n):
        for j in range(m):
            wet[i, j] = 1 if guess[i * m + j] >= 0.0 or groove_share(table, i, j) >= 0.0 else 0
    fewest, tries = n * m + 1, _TRIES
    for _ in range(_MOST):
        _assemble(table, sheet, supply, wet, band, right)
        eliminate(band, right)
        largest, wrong, last = 0.0, 0, -1
        for k in range(n * m):
            largest = max(largest, right[k])
        for i in range(n):
            for j in range(m):
                if groove_share(table, i, j) < 0.0 and _is_wrong(right[_row(i, j, n, m)], wet[i, j], largest):
                    wrong, last = wrong + 1, i * m + j
        if wrong == 0:
            break
        if wrong < fewest:
            fewest, tries = wrong, _TRIES
        elif tries > 0:
            tries -= 1
        for i in range(n):
            for j in range(m):
                bad = groove_share(table, i, j) < 0.0 and _is_wrong(right[_row(i, j, n, m)], wet[i, j], largest)
                if bad and (tries > 0 or i * m + j == last):
                    wet[i, j] = 1 - wet[i, j]
    for i in range(n):
        for j in range(m):
            z = right[_row(i, j, n, m)]
            guess[i * m + j] = max(z, 0.0) if wet[i, j] == 1 else min(z, -1e-300)
