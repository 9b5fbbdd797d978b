"""Pressure and cavity of a film: a cell that is full has a pressure above the cavity's, another one a deficit of oil.

With P = p - p_cavity >= 0 and the deficit d >= 0, P d = 0, the balance of volume of all cells is A P + b - B d = 0.
d is 1 - phi and B the transport of content (mass-conserving, after Jakobsson, Floberg, Olsson and Elrod), or d is a
volume that appears from nowhere and B is diagonal (Reynolds' condition).

Each choice of full cells (d = 0) and cavity cells (P = 0) leaves a matrix with a positive diagonal, no positive entry
elsewhere, and dominant columns. So there is one solution, elimination needs no pivots, and block principal pivoting
ends (Judice and Pires, Computers and Operations Research 21, 1994, 587-596). The balance holds to round-off.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.by_reference import packed
from linkages.laws.film.surface.balance import Balance

#: Rules of cavitation. guembel: the whole film, whose pressure below the cavity's is dropped.
RULES = ("guembel", "reynolds", "mass-conserving")

_NOTHING = 1e-12  # deficit, and pressure over the largest, that count as zero: round-off must not choose the set
_MOST = 10_000  # changes of the set

Full = NDArray[np.bool_]


def solve(balance: Balance, end: float = 0.0, *, rule: str = "mass-conserving", guess: Array | None = None) -> Array:
    """Solve the film by one of the `RULES`, with a pressure above the cavity's at the ends of the bearing.

    Return the pressure above the cavity's of full cells, minus the deficit of others, (n, m); all pressures with
    guembel. A guess is the solution of a neighbouring film on the same mesh. ArithmeticError if the set of full cells
    does not settle (none is known to fail).
    """
    if rule == "reynolds":
        loss = balance.carried - np.roll(balance.carried, 1, axis=0) + balance.gain
        unit = np.full_like(loss, np.abs(loss[balance.known < 0.0]).max(initial=1e-300))
        balance = balance._replace(carried=np.zeros_like(loss), gain=loss, most=unit)
    z = np.ones_like(balance.known) if guess is None else guess.copy()
    if settle(packed(balance), end, rule != "guembel", z) < 0 or not np.isfinite(z).all():
        raise ArithmeticError("film: the cells that are full do not settle")
    return z


@lazy_kernel(makes_arrays=True)
def settle(balance: Balance, end: float, cavitates: bool, z: Array) -> int:
    """Solve the complementarity for `solve`, from a guess ``z`` (n, m); return the solved systems of equations, or -1.

    Cells of the wrong sign change sides, all at once as long as that reduces their number now and then, else the last
    one alone.
    """
    known = balance.known
    n, m = known.shape
    full, place = np.empty((n, m), np.bool_), np.empty(n, np.int64)
    band, right = np.empty((n * m, 4 * m + 1)), np.empty(n * m)
    for i in range(n):
        for j in range(m):
            full[i, j] = known[i, j] >= 0.0 or z[i, j] >= 0.0 or not cavitates
    fewest, tries = n * m + 1, n + m
    for count in range(1, _MOST):
        width = _order(balance, full, place)
        _assemble(balance, end, full, place, width, band, right)
        eliminate(band, right, width)
        largest, wrong, last = 0.0, 0, -1
        for k in range(n * m):
            largest = max(largest, right[k])
        for i in range(n):
            for j in range(m):
                z[i, j] = right[place[i] * m + j]
                if cavitates and known[i, j] < 0.0 and _is_wrong(z[i, j], full[i, j], largest):
                    wrong, last = wrong + 1, i * m + j
        if wrong == 0:
            if cavitates:
                for i in range(n):
                    for j in range(m):
                        z[i, j] = max(z[i, j], 0.0) if full[i, j] else min(z[i, j], -1e-300)
            return count
        if wrong < fewest:
            fewest, tries = wrong, n + m
        else:
            tries -= 1
        for i in range(n):
            for j in range(m):
                if known[i, j] < 0.0 and (tries > 0 or i * m + j == last):
                    full[i, j] ^= _is_wrong(z[i, j], full[i, j], largest)
    return -1


@inlined_kernel
def _is_wrong(z: float, full: bool, largest: float) -> bool:
    """Whether an unknown has the wrong sign: a full cell's pressure below the cavity's, or a deficit below zero."""
    return z < -_NOTHING * largest if full else z > _NOTHING


@kernel
def _order(balance: Balance, full: Full, place: Indices) -> int:
    """Place the lines of cells from one that does not depend on the line before, or fold the ring; return the width."""
    known, carried = balance.known, balance.carried
    n, m = full.shape
    for first in range(n):
        apart = True
        for j in range(m):
            here, before = known[first, j] < 0.0, known[first - 1, j] < 0.0
            if here and before and (full[first, j] or full[first - 1, j] or carried[first - 1, j] != 0.0):
                apart = False
                break
        if apart:
            for k in range(n):
                place[(first + k) % n] = k
            return m
    for i in range(n):
        place[i] = folded(i, n)
    return 2 * m


@inlined_kernel
def folded(i: int, n: int) -> int:
    """Place of line i of a ring of n that is folded: next to line n - 1 - i."""
    return 2 * i if i < (n + 1) // 2 else 2 * (n - 1 - i) + 1


@kernel
def _assemble(balance: Balance, end: float, full: Full, place: Indices, width: int, band: Array, right: Array) -> None:
    """Fill the banded matrix and the right-hand side for a set of full cells; others have the unknown -d."""
    around, carried, along, known = balance.around, balance.carried, balance.along, balance.known
    gain, most = balance.gain, balance.most
    n, m = known.shape
    for i in range(n):
        last, after = i - 1 if i > 0 else n - 1, i + 1 if i + 1 < n else 0
        for j in range(m):
            r = place[i] * m + j
            for k in range(2 * width + 1):
                band[r, k] = 0.0
            if known[i, j] >= 0.0:
                band[r, width], right[r] = 1.0, known[i, j]
                continue
            inflow, outflow = carried[last, j], carried[i, j]
            right[r] = inflow - outflow - gain[i, j]
            if full[i, j]:
                band[r, width] = around[i, j] + around[last, j] + along[i, j] + along[i, j + 1]
            else:
                band[r, width] = most[i, j] + max(outflow, 0.0) + max(-inflow, 0.0)
            # the neighbours: conductance, and the flow that they carry into this cell
            before, behind = width + (place[last] - place[i]) * m, width + (place[after] - place[i]) * m
            _couple(known, full, band, right, r, before, last, j, around[last, j], max(inflow, 0.0))
            _couple(known, full, band, right, r, behind, after, j, around[i, j], max(-outflow, 0.0))
            if j > 0:
                _couple(known, full, band, right, r, width - 1, i, j - 1, along[i, j], 0.0)
            else:
                right[r] += along[i, 0] * end
            if j + 1 < m:
                _couple(known, full, band, right, r, width + 1, i, j + 1, along[i, j + 1], 0.0)
            else:
                right[r] += along[i, m] * end


@inlined_kernel
def _couple(
    known: Array, full: Full, band: Array, right: Array, r: int, k: int, i: int, j: int, conductance: float,
    carried: float,
) -> None:  # fmt: skip
    """Add the entry of a neighbour (i, j) to column k of row r, or its known pressure to the right-hand side."""
    if known[i, j] >= 0.0:
        right[r] += conductance * known[i, j]
    else:
        entry = conductance if full[i, j] else carried
        if entry != 0.0:
            band[r, k] -= entry


@kernel
def eliminate(band: Array, right: Array, width: int) -> None:
    """Solve a banded system in place, without pivots: its columns are diagonally dominant.

    Entry [r, width + c - r] of ``band`` (n, 2 width + 1 or more) is the one of row r, column c; it is overwritten. The
    right-hand side (n,) becomes the solution, not finite if the matrix is singular. Compiled, in one thread: LAPACK's
    solver takes up to 20 times as long where BLAS divides its small blocks among threads.
    """
    count = len(right)
    for k in range(count):
        last = min(width, count - 1 - k)
        pivot = 1.0 / band[k, width]
        upper = band[k, width + 1 : width + 1 + last]
        for d in range(1, last + 1):
            factor = band[k + d, width - d] * pivot
            if factor != 0.0:
                row = band[k + d, width - d + 1 : width - d + 1 + last]
                for e in range(last):
                    row[e] -= factor * upper[e]
                right[k + d] -= factor * right[k]
    for k in range(count - 1, -1, -1):
        total = right[k]
        for d in range(1, min(width, count - 1 - k) + 1):
            total -= band[k, width + d] * right[k + d]
        right[k] = total / band[k, width]
