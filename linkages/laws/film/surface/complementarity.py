"""The film as a complementarity problem: pressure above the cavity's and missing content exclude each other.

With P = p - p_cavity >= 0 and the deficit d >= 0, P d = 0, the balance of volume of all cells is A P + b - B d = 0.
d is 1 - phi and B the transport of content (mass-conserving, after Jakobsson, Floberg, Olsson and Elrod), or d is the
volume that appears from nowhere and B the identity (Reynolds' condition).

Fischer-Burmeister-Newton-Schur (FBNS; Woloszynski, Podsiadlo, Stachowiak, Tribology Letters 58, 2015): Newton's
method on the balance and on P + d - sqrt(P^2 + d^2) = 0. The second equation has a diagonal Jacobian, so in each cell
either P or d is eliminated, and one system of the size of the mesh is left. Its bandwidth is small: lines of cells
around the film are folded, i next to n - 1 - i. The last steps fix which cells cavitate
(a primal-dual active set), so that P d = 0 holds exactly and the balance to round-off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel import Array
from linkages.laws.film.surface.balance import Balance
from linkages.laws.film.surface.elimination import eliminate

Flags = NDArray[np.bool_]

_STEPS = 200
#: Volume that a full cell loses, in parts of the largest flow: a ring that nothing feeds is empty then. Without it the
#: content of such a ring is not unique. Round-off of the balance is larger.
_LEAK = 1e-13
#: Deficit, and pressure in parts of the one that a deficit of 1 takes away, that count as zero: a full film at rest has
#: neither pressure nor deficit, and round-off must not decide where it cavitates.
_NOTHING = 1e-12
_CLOSE = 1e-3  # residual, in parts of its scale, from which on the active set is tried


class Boundary(NamedTuple):
    """Pressures above the cavity's: at the two ends of the bearing, and in the cells of grooves, (n, m)."""

    end: float
    grooves: Array


class State(NamedTuple):
    """A solution: pressure above the cavity's, deficit, and Newton steps."""

    p: Array
    deficit: Array
    steps: int


class _Columns(NamedTuple):
    """Non-zero entries of A and B by column: in the rows of the cell itself, the next and the last one around, ..."""

    a: tuple[Array, Array, Array, Array, Array]  # own, next, last, above (j + 1), below
    b: tuple[Array, Array, Array]  # own, next, last


def solve(balance: Balance, boundary: Boundary, *, rule: str = "mass-conserving", guess: State | None = None) -> State:
    """Solve the film.

    Parameters
    ----------
    balance : Balance
    boundary : Boundary
    rule : str
        mass-conserving; reynolds; guembel: the whole film without a cavity, P can be negative.
    guess : State, optional
        Of a neighbouring film on the same mesh.

    Raises
    ------
    ArithmeticError
        If Newton's method does not converge.
    """
    columns = _columns(balance, rule == "mass-conserving")
    band = _Band(balance.free.shape)
    source = _source(balance)
    if rule == "guembel":
        p, deficit = _fixed(balance, columns, band, source, boundary, np.ones(balance.free.shape, dtype=bool))
        return State(p, deficit, 1)
    p = np.where(balance.free, 1.0, boundary.grooves) if guess is None else guess.p.copy()
    deficit = np.zeros_like(p) if guess is None else guess.deficit.copy()
    p[~balance.free] = boundary.grooves[~balance.free]
    scale = float(np.abs(source).max()) + float((balance.along[:, -1] * boundary.end).max()) + 1e-300
    scale += _NOTHING * float(np.abs(balance.missing).max())
    scale += float((balance.around * np.abs(np.where(balance.free, 0.0, boundary.grooves)).max()).max()) * 1e-3
    diagonal = columns.a[0]
    typical = float(np.median(diagonal[balance.free]))
    unit, nothing = scale / typical, _NOTHING * float(np.abs(balance.missing).max()) / typical
    if guess is not None:
        found = _active_set(balance, columns, band, source, boundary, ~balance.free | (p / unit > deficit), nothing)
        if found is not None:
            return State(*found, 1)
    for step in range(1, _STEPS + 1):
        residual = _residual(balance, columns, source, boundary, p, deficit)
        size = float(np.abs(residual).max()) / scale
        if size < _CLOSE:
            found = _active_set(balance, columns, band, source, boundary, ~balance.free | (p / unit > deficit), nothing)
            if found is not None:
                return State(*found, step)
        root = np.hypot(p / unit, deficit) + 1e-14
        slope_p, slope_d = 1.0 - p / unit / root, 1.0 - deficit / root
        gap = p / unit + deficit - root
        eliminate_p = slope_p > slope_d
        big = np.where(eliminate_p, slope_p, slope_d)
        ratio = np.where(eliminate_p, slope_d, slope_p) / big
        alpha = np.where(eliminate_p, -ratio * unit, 1.0)
        beta = np.where(eliminate_p, 1.0, -ratio / unit)
        fixed = -gap / big
        first = np.where(balance.free & eliminate_p, fixed * unit, 0.0)  # parts of the step that are known
        second = np.where(balance.free & ~eliminate_p, fixed, 0.0)
        right = -residual - _apply(columns, first, second)
        change = band.solve(columns, alpha, beta, right, balance)
        dp = np.where(eliminate_p, first + alpha * change, change)
        dd = np.where(eliminate_p, change, second + beta * change)
        p = np.where(balance.free, np.maximum(p + dp, 0.0), p)
        deficit = np.where(balance.free, np.clip(deficit + dd, 0.0, None), 0.0)
    raise ArithmeticError(f"film: Newton's method did not converge in {_STEPS} steps")


def _active_set(
    balance: Balance, columns: _Columns, band: _Band, source: Array, boundary: Boundary, wet: Flags, nothing: float
) -> tuple[Array, Array] | None:
    """Solve with P = 0 where a cell is not wet and d = 0 where it is; correct the sets a few times."""
    for _ in range(12):
        p, deficit = _fixed(balance, columns, band, source, boundary, wet)
        following = np.where(wet, (p > -nothing) | ~balance.free, deficit < -_NOTHING)
        if np.array_equal(following, wet):
            p, deficit = _fixed(balance, columns, band, source, boundary, wet, (p, deficit))
            return np.maximum(p, 0.0), np.maximum(deficit, 0.0)
        wet = following
    return None


def _fixed(
    balance: Balance,
    columns: _Columns,
    band: _Band,
    source: Array,
    boundary: Boundary,
    wet: Flags,
    near: tuple[Array, Array] | None = None,
) -> tuple[Array, Array]:
    """Solve with P = 0 where a cell is not wet and d = 0 where it is; a near solution gives a balance to round-off."""
    p, deficit = (np.where(balance.free, 0.0, boundary.grooves), np.zeros(wet.shape)) if near is None else near
    residual = _residual(balance, columns, source, boundary, p, deficit)
    x = band.solve(columns, np.where(wet, 1.0, 0.0), np.where(wet, 0.0, 1.0), -residual, balance)
    return np.where(balance.free & wet, p + x, p), np.where(balance.free & ~wet, deficit + x, deficit)


def _source(balance: Balance) -> Array:
    """Outflow of each cell at full content without pressure."""
    out = balance.carried - np.roll(balance.carried, 1, axis=0) + balance.squeeze
    return np.where(balance.free, out + _leak(balance), 0.0)


def _leak(balance: Balance) -> float:
    return _LEAK * float(np.abs(balance.carried).max() + np.abs(balance.squeeze).max())


def _columns(balance: Balance, conserving: bool) -> _Columns:
    around, along, free = balance.around, balance.along, balance.free
    back = np.roll(around, 1, axis=0)
    own = around + back + along
    own[:, 1:] += along[:, :-1]
    own[:, 0] += balance.start
    below = np.zeros_like(along)
    below[:, 1:] = along[:, :-1]
    above = along.copy()
    above[:, -1] = 0.0
    after, before = np.roll(free, -1, axis=0), np.roll(free, 1, axis=0)
    up, down = np.zeros_like(free), np.zeros_like(free)
    up[:, :-1], down[:, 1:] = free[:, 1:], free[:, :-1]
    a = (own, -around * after, -back * before, -above * up, -below * down)
    if not conserving:
        zero = np.zeros_like(own)
        return _Columns(a, (np.ones_like(own), zero, zero))
    forward, backward = np.maximum(balance.carried, 0.0), np.maximum(-np.roll(balance.carried, 1, axis=0), 0.0)
    b = (forward + backward + balance.missing + _leak(balance), -forward * after, -backward * before)
    return _Columns(a, b)


def _apply(columns: _Columns, p: Array, deficit: Array) -> Array:
    """Return A p - B d of vectors that vanish in grooves."""
    own, after, before, above, below = columns.a
    total = own * p
    total += np.roll(after * p, 1, axis=0) + np.roll(before * p, -1, axis=0)
    total[:, 1:] += (above * p)[:, :-1]
    total[:, :-1] += (below * p)[:, 1:]
    b, b_after, b_before = columns.b
    total -= b * deficit + np.roll(b_after * deficit, 1, axis=0) + np.roll(b_before * deficit, -1, axis=0)
    return total


def _residual(
    balance: Balance, columns: _Columns, source: Array, boundary: Boundary, p: Array, deficit: Array
) -> Array:
    """Volume that leaves each cell; zero in grooves."""
    free = balance.free
    total = source + _apply(columns, np.where(free, p, 0.0), deficit)
    known = np.where(free, 0.0, p)
    total -= balance.around * np.roll(known, -1, axis=0) + np.roll(balance.around * known, 1, axis=0)
    total[:, :-1] -= balance.along[:, :-1] * known[:, 1:]
    total[:, 1:] -= balance.along[:, :-1] * known[:, :-1]
    total[:, -1] -= balance.along[:, -1] * boundary.end
    total[:, 0] -= balance.start * boundary.end
    return np.where(free, total, 0.0)


class _Band:
    """Banded matrix of the folded lines of cells."""

    def __init__(self, shape: tuple[int, int]) -> None:
        n, m = shape
        line = np.where(np.arange(n) < (n + 1) // 2, 2 * np.arange(n), 2 * (n - 1 - np.arange(n)) + 1)
        place = (line[:, None] * m + np.arange(m)).astype(np.int64)
        self.width = 2 * m
        self.place, self.size = place, n * m
        rows = [place, np.roll(place, -1, axis=0), np.roll(place, 1, axis=0)]
        inside = [np.ones(shape, dtype=bool)] * 3
        for shift in (1, -1):
            beside = np.zeros(shape, dtype=bool)
            beside[:, : -1 if shift == 1 else None][:, 0 if shift == 1 else 1 :] = True
            rows.append(np.where(beside, place + shift, place))
            inside.append(beside)
        self.entries = [
            (row[chosen], (self.width + place - row)[chosen]) for row, chosen in zip(rows, inside, strict=True)
        ]
        self.inside = inside

    def solve(self, columns: _Columns, alpha: Array, beta: Array, right: Array, balance: Balance) -> Array:
        """Solve with columns alpha*A - beta*B; the result vanishes in grooves."""
        free = balance.free
        matrix = np.zeros((self.size, 2 * self.width + 1))
        for k, entries in enumerate(columns.a):
            values = alpha * entries
            if k < 3:
                values = values - beta * columns.b[k]
            values = np.where(free, values, 1.0 if k == 0 else 0.0)
            matrix[self.entries[k]] = values[self.inside[k]]
        vector = np.empty(self.size)
        vector[self.place] = np.where(free, right, 0.0)
        eliminate(matrix, vector)
        if not np.isfinite(vector).all():
            raise ArithmeticError("film: the system of equations is singular")
        return vector[self.place]
