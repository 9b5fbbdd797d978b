"""Trace a branch of periodic motions: points, bifurcations between them, and the start of a doubled branch.

The detail of a point has its Floquet `multipliers`, its `monodromy` matrix, and `contacts`: how often each one begins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from linkages.explore.numerics import TRACING_GRAZED, TRACING_LOCATED, TRACING_SMOOTH
from linkages.explore.periodic.continuation import ResidualFunction, Settings, Solution, follow, locate, packed, step
from linkages.explore.periodic.multipliers import FOLD, GRAZING, crossing, kind

LIMIT, CLOSED, MOST, LOST, INTERRUPTED = "limit", "closed", "most", "lost", "interrupted"
#: Why a branch ends.
ENDS = {
    LIMIT: "the value reached a limit of its range",
    CLOSED: "it returned to its first motion",
    MOST: "it has the largest number of motions",
    LOST: "Newton's method found no further motion at the smallest step",
    INTERRUPTED: "the search was interrupted",
}

_STARTS = (1.0, 0.5, 0.25, 0.1, 0.04)  # sizes of the first step on a doubled branch, over the first step of a branch


@dataclass(frozen=True, eq=False)
class Bifurcation:
    """A bifurcation: its kind (see `multipliers`), its point, and the multiplier on the unit circle (NaN: none)."""

    kind: str
    point: Solution
    multiplier: complex


@dataclass(frozen=True, eq=False)
class Trace:
    """A branch in one direction: its points with the first one, its bifurcations in order, and why it ends (`ENDS`)."""

    points: list[Solution]
    bifurcations: list[Bifurcation]
    end: str


def trace(
    equations: ResidualFunction,
    start: Solution,
    limits: tuple[float, float],
    settings: Settings,
    most: int,
    report: Callable[[Solution], None] = lambda point: None,
) -> Trace:
    """Follow a branch from a point along its tangent, and locate the bifurcations between its points.

    It ends at the lowest or highest p of `limits`, after `most` points, or with the last point at `KeyboardInterrupt`.
    `report` is called with each point.
    """
    points, found, end = [start], list[Bifurcation](), LOST
    try:
        for point in follow(equations, start, *limits, settings):
            before = points[-1]
            found += _between(equations, before, point, settings)
            points.append(point)
            report(point)
            end = _ending(start, before, point, limits, settings, len(points) > most)
            if end in (CLOSED, MOST):
                break
    except KeyboardInterrupt:
        end = INTERRUPTED
    return Trace(points, found, end)


def _ending(
    start: Solution, before: Solution, point: Solution, limits: tuple[float, float], settings: Settings, many: bool
) -> str:
    """Return why a branch ends at a point, or would if no further one were found."""
    if _passed(start, before, point, settings):
        return CLOSED
    if point.p in limits:
        return LIMIT
    return MOST if many else LOST


def turned(point: Solution) -> Solution:
    """Return the point with the opposite direction of its branch."""
    return replace(point, tangent=-point.tangent)


def doubled(equations: ResidualFunction, point: Solution, settings: Settings) -> Solution | None:
    """Return the first point of the doubled branch beyond a period doubling; None if no correction converges.

    The equations have motions with twice the period.
    """
    values, vectors = np.linalg.eig(point.detail.monodromy)
    away = vectors[:, np.argmin(np.abs(values + 1.0))].real / settings.scale
    ahead = replace(point, tangent=np.append(away / np.linalg.norm(away), 0.0))
    for size in _STARTS:
        found = step(equations, ahead, size * settings.first, settings)
        if found is not None and found[0].p != point.p:
            return found[0]
    return None


def _between(
    equations: ResidualFunction, point: Solution, ahead: Solution, settings: Settings
) -> Iterator[Bifurcation]:
    """Locate the bifurcations between two neighbours."""
    turns_back = point.tangent[-1] * ahead.tangent[-1] < 0.0
    changed = ahead.detail.contacts
    grazes = point.detail.contacts != changed
    if grazes:
        at = locate(
            equations, point, ahead, lambda p: 1.0 if p.detail.contacts == changed else -1.0, settings, TRACING_GRAZED
        )
        yield Bifurcation(GRAZING, at, complex("nan"))
    if turns_back:
        at = locate(equations, point, ahead, lambda p: float(p.tangent[-1]), settings, TRACING_LOCATED)
        nearest = at.detail.multipliers
        yield Bifurcation(FOLD, at, complex(nearest[np.argmin(np.abs(nearest - 1.0))]))
    k = crossing(point.detail.multipliers, ahead.detail.multipliers)
    if k is None:
        return

    def outside(p: Solution) -> float:
        return float(np.abs(p.detail.multipliers[k])) - 1.0

    at = locate(equations, point, ahead, outside, settings, TRACING_LOCATED)
    multiplier = complex(at.detail.multipliers[k])
    what = kind(multiplier, turns_back)
    if what != FOLD and not (grazes and abs(abs(multiplier) - 1.0) > TRACING_SMOOTH):
        yield Bifurcation(what, at, multiplier)


def _passed(start: Solution, before: Solution, point: Solution, settings: Settings) -> bool:
    """Check whether a branch returned to its start between two points: in the same direction, and near it."""
    behind, ahead = (packed(each, settings) - packed(start, settings) for each in (before, point))
    passes = behind @ start.tangent < 0.0 <= ahead @ start.tangent and point.tangent @ start.tangent > 0.0
    return bool(passes and np.linalg.norm(ahead) <= np.linalg.norm(ahead - behind))
