"""The second-order condition at a stationary point: a maximum or a saddle is left, a minimum is kept.

The curvature of the Lagrangian along the constraints is measured by second differences, in the directions in which the
search has made no step: along a step the objective has fallen until the slope vanished.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import null_space

from optim.algorithms.line_search import Restored, search
from optim.algorithms.nlp import Array
from optim.algorithms.standard_form import PUSH, Phase, ScaledSlopes, StandardForm

#: Distance from a bound, and length of a step that stays within the bounds, both scaled, that count as zero.
AT_BOUND, SHORTEST = 1e-6, 1e-4
#: Part of a direction in earlier steps, of length one, above which it is explored.
EXPLORED = 0.1


def escape(
    form: StandardForm,
    slopes: ScaledSlopes,
    at: Restored,
    phase: Phase,
    steps: Sequence[Array],
    tolerance: float,
    feasibility: float,
) -> tuple[Restored, int] | None:
    """Leave a stationary point along the direction in which the objective bends downwards most.

    `steps` are the earlier ones of the variables, (n,) each. Returns the better point and the number of trials, as
    `search`; None if the objective falls in no direction by more than the tolerance, relative to 1 + |objective|.
    """
    directions = _unexplored(form, slopes, at, phase, steps)
    if not directions.shape[1]:
        return None
    bend, direction = _lowest(form, slopes, at, phase, directions)
    if -0.5 * bend <= tolerance * (1.0 + abs(at.f)):
        return None
    for step in (direction, -direction):
        room = np.minimum(at.y + step - phase.low, phase.high - at.y - step)
        partition = at.partition.improved(slopes.A, room)
        found = search(form, slopes.A, at, partition, step, 0.5 * bend, phase, feasibility)
        if found is not None and found[0].f < at.f:
            return found
    return None


def _unexplored(form: StandardForm, slopes: ScaledSlopes, at: Restored, phase: Phase, steps: Sequence[Array]) -> Array:
    """Return steps (n + m, k) along the constraints and off the bounds, perpendicular to each other and to `steps`.

    Their length is `PUSH`, less near bounds.
    """
    Z = at.partition.tangents(slopes.A)
    gaps = _gaps(at, phase)
    free = gaps >= AT_BOUND
    within = Z @ null_space(Z[~free])
    if within.shape[1]:
        basis, triangle = np.linalg.qr(within[: form.n])
        within = np.linalg.solve(triangle.T, within.T).T
        parts = [basis.T @ step / np.linalg.norm(step) for step in steps if step.any()]
        if parts:
            sides, sizes, _ = np.linalg.svd(np.array(parts).T)
            within = within @ sides[:, int((sizes > EXPLORED).sum()) :]
    with np.errstate(divide="ignore"):
        room = (gaps[free, None] / np.abs(within[free])).min(axis=0, initial=np.inf)
    lengths = np.minimum(PUSH, 0.5 * room)  # of two directions together too
    return np.asarray((lengths * within)[:, lengths > SHORTEST])


def _gaps(at: Restored, phase: Phase) -> Array:
    """Return the distances of variables and slacks from their nearer bounds, (n + m,)."""
    return np.minimum(at.y - phase.low, phase.high - at.y)


def _lowest(
    form: StandardForm, slopes: ScaledSlopes, at: Restored, phase: Phase, directions: Array
) -> tuple[float, Array]:
    """Return the lowest second difference of the Lagrangian, and its direction (n + m,), as a sum of `directions`."""
    count, free = directions.shape[1], _gaps(at, phase) >= AT_BOUND
    multipliers = np.linalg.lstsq(slopes.A[:, free].T, phase.gradient[free])[0]
    pairs = [(i, k) for i in range(count) for k in range(i)]
    offsets = [*directions.T, *-directions.T, *(directions[:, i] + directions[:, k] for i, k in pairs)]
    points = [at.y, *(at.y + offset for offset in offsets)]
    form.evaluate_all([y[: form.n] for y in points])

    def lagrangian(y: Array) -> float:
        f, c = form.evaluate(y[: form.n])
        return f - float(multipliers @ (c + y[form.n :])) if np.isfinite(f) else np.nan

    here, *values = map(lagrangian, points)
    ahead, behind, both = np.split(np.array(values) - here, [count, 2 * count])
    bends = np.diag(np.nan_to_num(ahead + behind))  # no value: no bend is known
    for (i, k), value in zip(pairs, both, strict=True):
        bends[i, k] = bends[k, i] = np.nan_to_num(value - ahead[i] - ahead[k])
    sizes, ways = np.linalg.eigh(bends)
    return float(sizes[0]), directions @ ways[:, 0]
