"""Newton's method and pseudo-arclength continuation for a system of equations g(u, p) = 0 with one parameter p.

Unknowns and parameter are divided by scales. A point has a unit tangent; the next point lies on the hyperplane normal
to it at the distance of the step. So folds need no special treatment. Keller, Numerical solution of bifurcation and
nonlinear eigenvalue problems, in Applications of Bifurcation Theory, Academic Press 1977, pp. 359-384; Allgower and
Georg, Introduction to Numerical Continuation Methods, SIAM 2003, ch. 6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import RunError
from linkages.explore.numerics import (
    CONTINUATION_BENT,
    CONTINUATION_BISECTIONS,
    CONTINUATION_FAR,
    CONTINUATION_GOOD,
    CONTINUATION_HALVINGS,
    CONTINUATION_ROUNDS,
    CONTINUATION_WIDEST,
)

_GROWTH, _SHRINK = 1.5, 0.5  # factors of the step


class Residual(NamedTuple):
    """Residual g (n,) at u and p, its derivatives dg/du (n, n) and dg/dp (n,), and whatever belongs to the point."""

    value: Array
    by_u: Array
    by_p: Array
    detail: Any = None


#: g(u, p); it raises `RunError` where it does not exist.
ResidualFunction = Callable[[Array, float], Residual]


class Settings(NamedTuple):
    """Scales of unknowns (n,), parameter and residual (n,); tolerance of the residual; steps in scaled arclength."""

    scale: Array
    scale_p: float
    error: Array
    tolerance: float = 1e-9
    first: float = 0.02
    least: float = 1e-5
    most: float = 0.05


@dataclass(frozen=True, eq=False)
class Solution:
    """A solution: u (n,), p, unit tangent (n + 1,) of scaled unknowns, `Residual.detail`, largest residual."""

    u: Array
    p: float
    tangent: Array
    detail: Any
    residual: float


def solve(equations: ResidualFunction, u: Array, p: float, settings: Settings) -> Solution:
    """Solve g(u, p) = 0 at a fixed p by Newton's method; the tangent points to larger p.

    RunError if the method does not converge.
    """
    up = np.append(np.zeros(len(u)), 1.0)
    found = _newton(equations, np.append(u / settings.scale, p / settings.scale_p), up, settings)
    if found is None:
        raise RunError(
            "Newton's method finds no periodic motion from this start; start closer to one (a longer transient)"
        )
    return _point(*found[:2], up, settings)


def rescaled(point: Solution, settings: Settings) -> tuple[Solution, Settings]:
    """Return a point and the settings with larger scales of unknowns that change by more than theirs over a unit of p.

    Otherwise an unknown that changes much along the whole branch, as a speed with that of the drive, would determine
    the steps. Near a fold, where all unknowns change fast with p, scales grow by `CONTINUATION_WIDEST` at most.
    """
    along, by_p = np.abs(point.tangent[:-1]), abs(point.tangent[-1])
    wider = np.clip(along / max(by_p, 1.0 / CONTINUATION_WIDEST), 1.0, CONTINUATION_WIDEST)
    scale, tangent = settings.scale * wider, np.append(point.tangent[:-1] / wider, point.tangent[-1])
    return replace(point, tangent=tangent / np.linalg.norm(tangent)), settings._replace(scale=scale)


def follow(
    equations: ResidualFunction, start: Solution, low: float, high: float, settings: Settings
) -> Iterator[Solution]:
    """Follow a branch from a point along its tangent, up to a limit of p or where the step gets too small.

    The start is not yielded; a point exactly at a limit ends the branch.
    """
    point, size = start, settings.first
    while size >= settings.least:
        found = step(equations, point, size, settings)
        if found is None or found[0].tangent @ point.tangent < CONTINUATION_BENT:
            size *= _SHRINK
            continue
        ahead, rounds = found
        if not low <= ahead.p <= high:
            if low <= point.p <= high and (end := _end(equations, point, ahead, low, high, settings)) is not None:
                yield end
            return
        yield ahead
        point = ahead
        size = min(
            settings.most,
            size * (_GROWTH if rounds < CONTINUATION_GOOD else 1.0 if rounds == CONTINUATION_GOOD else _SHRINK),
        )


def step(equations: ResidualFunction, point: Solution, size: float, settings: Settings) -> tuple[Solution, int] | None:
    """Take a step of a size along the branch; return the point and the number of iterations, or None."""
    guess = packed(point, settings) + size * point.tangent
    found = _newton(equations, guess, point.tangent, settings)
    if found is None or np.linalg.norm(found[0] - guess) > CONTINUATION_FAR * size:
        return None
    return _point(found[0], found[1], point.tangent, settings), found[2]


def locate(
    equations: ResidualFunction,
    point: Solution,
    ahead: Solution,
    test: Callable[[Solution], float],
    settings: Settings,
    tolerance: float,
) -> Solution:
    """Find the point between two neighbours where a test function vanishes, which has opposite signs at them.

    Regula falsi (Illinois) on the step from the first point; it ends when the bracket is smaller than the tolerance in
    scaled arclength. A test function may be discontinuous: then the end with the sign of the second point is returned.
    It ends early where a correction does not converge, as at an impact that grazes.
    """
    low, high = 0.0, float((packed(ahead, settings) - packed(point, settings)) @ point.tangent)
    f_low, f_high, best, side = test(point), test(ahead), ahead, 0
    for k in range(CONTINUATION_BISECTIONS):
        if high - low <= tolerance:
            break
        size = (low * f_high - high * f_low) / (f_high - f_low) if k % 4 != 3 else 0.5 * (low + high)
        if not low < size < high:
            size = 0.5 * (low + high)
        found = step(equations, point, size, settings)
        if found is None:
            return best
        value = test(found[0])
        if value == 0.0:
            return found[0]
        if (value > 0.0) == (f_high > 0.0):
            high, f_high, best = size, value, found[0]
            f_low *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            low, f_low = size, value
            f_high *= 0.5 if side == -1 else 1.0
            side = -1
            if abs(value) < abs(test(best)):
                best = found[0]
    return best


def packed(point: Solution, settings: Settings) -> Array:
    """Return the scaled unknowns and parameter (n + 1,) of a point."""
    return np.append(point.u / settings.scale, point.p / settings.scale_p)


def _newton(
    equations: ResidualFunction, w: Array, normal: Array, settings: Settings
) -> tuple[Array, Residual, int] | None:
    """Solve for scaled unknowns w (n + 1,) on the hyperplane through the first guess; None if it does not converge."""
    residual = _evaluate(equations, w, settings)
    for rounds in range(CONTINUATION_ROUNDS):
        if residual is None:
            return None
        if size_of(residual, settings) <= settings.tolerance:
            return w, residual, rounds
        change = np.linalg.lstsq(
            _bordered(residual, normal, settings), -np.append(residual.value / settings.scale, 0.0), rcond=None
        )[0]
        if not np.isfinite(change).all():
            return None
        for _ in range(CONTINUATION_HALVINGS):
            ahead = _evaluate(equations, w + change, settings)
            if ahead is not None and size_of(ahead, settings) < size_of(residual, settings):
                break
            change *= 0.5
        else:
            return None
        w, residual = w + change, ahead
    return None


def _evaluate(equations: ResidualFunction, w: Array, settings: Settings) -> Residual | None:
    try:
        found = equations(w[:-1] * settings.scale, float(w[-1]) * settings.scale_p)
    except RunError:
        return None
    return found if np.isfinite(found.value).all() and np.isfinite(found.by_u).all() else None


def size_of(residual: Residual, settings: Settings) -> float:
    """Return the largest residual over its scale."""
    return float(np.abs(residual.value / settings.error).max())


def _bordered(residual: Residual, normal: Array, settings: Settings) -> Array:
    """Return the scaled Jacobian (n + 1, n + 1), with the normal of the hyperplane as its last row."""
    by_u = residual.by_u * settings.scale / settings.scale[:, None]
    by_p = residual.by_p * settings.scale_p / settings.scale
    return np.vstack([np.column_stack([by_u, by_p]), normal])


def _point(w: Array, residual: Residual, ahead: Array, settings: Settings) -> Solution:
    """Make the point of a solution, with the tangent along a direction."""
    tangent = np.linalg.svd(_bordered(residual, ahead, settings)[:-1])[2][-1]
    tangent = tangent * (1.0 if tangent @ ahead >= 0.0 else -1.0)
    u, p = w[:-1] * settings.scale, float(w[-1]) * settings.scale_p
    return Solution(u, p, tangent, residual.detail, size_of(residual, settings))


def _end(
    equations: ResidualFunction, point: Solution, ahead: Solution, low: float, high: float, settings: Settings
) -> Solution | None:
    """Find the point at the limit of p between a point and the next one, which is beyond."""
    limit = low if ahead.p < low else high
    share = (limit - point.p) / (ahead.p - point.p)
    guess = (1.0 - share) * packed(point, settings) + share * packed(ahead, settings)
    guess[-1] = limit / settings.scale_p
    found = _newton(equations, guess, np.append(np.zeros(len(point.u)), 1.0), settings)
    if found is None:
        return None
    end = _point(found[0], found[1], point.tangent, settings)
    return Solution(end.u, limit, end.tangent, end.detail, end.residual)
