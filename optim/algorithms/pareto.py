"""Several objectives: domination, Pareto front, hypervolume, knee."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.base.arguments import Matrix, Vector, fitting, validated
from linkages.base.arrays import Indices
from optim.algorithms.nlp import Array, Values


def ranks(objectives: Array) -> Indices:
    """Sort designs (m, no) into fronts, (m,): 0 for designs that no other dominates, 1 without front 0, and so on.

    K. Deb et al., A fast and elitist multiobjective genetic algorithm: NSGA-II, IEEE Transactions on Evolutionary
    Computation 6 (2002) 182-197, section III A.
    """
    no_worse = _no_worse(objectives, objectives)
    better = no_worse & ~no_worse.T  # whether [i] dominates [j]
    dominators = better.sum(axis=0)
    rank = np.full(len(objectives), -1, dtype=np.intp)
    level = 0
    while np.any(rank < 0):
        front = (rank < 0) & (dominators == 0)
        rank[front] = level
        dominators = dominators - better[front].sum(axis=0)
        level += 1
    return rank


def pareto_front(values: Values, tolerance: float = 0.0, known: int = 0) -> Indices:
    """Find the Pareto front: rows of the feasible designs that no other dominates, by the first objective.

    Of designs with equal objectives only the first is taken; without a feasible design, the one that violates the
    constraints least. The first designs are `known` to be a front.
    """
    if len(values) == 0:
        return np.empty(0, dtype=np.intp)
    feasible, f = np.flatnonzero(values.feasible(tolerance)), values.objectives
    if len(feasible) == 0:
        return np.array([np.argmin(values.violation)])
    old, new = np.split(feasible, [np.searchsorted(feasible, known)])
    # no design dominates the first of a lexicographic order: take it, drop those it dominates or equals, and repeat
    members: list[int] = []
    left = new[np.lexsort(f[new].T[::-1])]
    while len(left):
        members.append(int(left[0]))
        left = left[np.any(f[left] < f[left[0]], axis=1)]
    new = np.array(members, dtype=np.intp)
    new = new[~_covered(f[old], f[new])]
    rows = np.concatenate([old[~_covered(f[new], f[old])], new])
    return rows[np.lexsort(f[rows].T[::-1])]


def _covered(some: Array, others: Array) -> NDArray[np.bool_]:
    """Tell which of the others (m, no) some designs dominate or equal, (m,)."""
    return np.asarray(_no_worse(some, others).any(axis=0))


def _no_worse(some: Array, others: Array) -> NDArray[np.bool_]:
    """Tell whether some designs (m, no) are in no objective worse than others (k, no), (m, k)."""
    return np.logical_and.reduce([one[:, None] <= other for one, other in zip(some.T, others.T, strict=True)])


@validated
def hypervolume(objectives: Matrix, reference: Vector) -> float:
    """Compute the volume that a front dominates, up to a reference point that is worse in every objective.

    By slices along the last objective (E. Zitzler, L. Thiele, Multiobjective evolutionary algorithms, IEEE
    Transactions on Evolutionary Computation 3 (1999) 257-271 define the measure).

    Parameters
    ----------
    objectives : (m, no) array
    reference : (no,) array

    Raises
    ------
    InputError
        If a number is not finite, or the reference has not one number for each objective.

    Examples
    --------
    >>> import numpy as np
    >>> import optim
    >>> optim.hypervolume(np.array([[0.0, 0.5], [0.5, 0.0]]), np.ones(2))
    0.75
    """
    return _dominated(objectives, fitting(reference, objectives.shape[1], "reference", "objectives"))


def _dominated(objectives: Array, reference: Array) -> float:
    inside = objectives[np.all(objectives < reference, axis=1)]
    if len(inside) == 0:
        return 0.0
    if inside.shape[1] == 1:
        return float(reference[0] - inside.min())
    inside = inside[np.argsort(inside[:, -1], kind="stable")]
    heights = np.diff(np.append(inside[:, -1], reference[-1]))
    slices = [(height, inside[: i + 1, :-1]) for i, height in enumerate(heights) if height > 0.0]
    return float(sum(height * _dominated(area, reference[:-1]) for height, area in slices))


@validated
def knee(objectives: Matrix) -> int | None:
    """Find the row of a front that lies farthest from the plane through its extremes, towards the better side.

    Each objective is measured by its range on the front (I. Das, On characterizing the "knee" of the Pareto
    curve, Structural Optimization 18 (1999) 107-115).

    Parameters
    ----------
    objectives : (m, no) array
        Objectives of a front.

    Returns
    -------
    int or None
        None where there is no knee: fewer designs than objectives plus one, an objective that does not vary,
        extremes that do not span a plane, or a front that lies nowhere on the better side.

    Examples
    --------
    >>> import numpy as np
    >>> import optim
    >>> optim.knee(np.array([[0.0, 1.0], [0.1, 0.2], [1.0, 0.0]]))
    1
    """
    m, no = objectives.shape
    if m <= no or np.any((span := np.ptp(objectives, axis=0)) <= 0.0):
        return None
    scaled = (objectives - objectives.min(axis=0)) / span
    # the extreme of an objective is where it is best; of equal ones that with the least sum
    extremes = scaled[[np.lexsort((scaled.sum(axis=1), column))[0] for column in scaled.T]]
    try:
        normal = np.linalg.solve(extremes, np.ones(no))
    except np.linalg.LinAlgError:
        return None
    distance = (1.0 - scaled @ normal) / np.linalg.norm(normal)
    best = int(np.argmax(distance))
    return best if np.all(normal > 0.0) and distance[best] > 1e-9 else None
