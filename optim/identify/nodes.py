"""Columns of a run at many times: between nodes within each step, where a step has more times than nodes.

Within a step a run is smooth: it ends where a contact, a sample of a controller or a kink begins. A polynomial through
the nodes therefore has the values between them. A step whose polynomial has not converged is halved; a part with few
times is evaluated at these.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from linkages.base.arrays import Array
from optim.identify.numerics import NODES_AT_ONCE, NODES_FINEST, NODES_LAST

NODES = 10  # of a step

#: Chebyshev's nodes of the first kind: inside the step, since columns jump where it begins or ends.
_PLACES = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
_TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_PLACES, NODES - 1))


def between_nodes(steps: Array, times: Array, evaluate: Callable[[Array], Array], tolerance: float) -> Array:
    """Return the rows (nr, nt) of a run at times (nt,), as `evaluate` gives them at times (n,).

    Parameters
    ----------
    steps : (ns,) array
        Times of the run's steps [s].
    times : (nt,) array
        In any order [s].
    evaluate : callable
        Rows (nr, n) at times (n,) within the run.
    tolerance : float
        Error of a row, relative to its root mean square: the accuracy of the run.
    """
    places = np.clip(np.searchsorted(steps, times, "right") - 1, 0, max(len(steps) - 2, 0))
    crowded = np.flatnonzero(np.bincount(places, minlength=len(steps)) > NODES)
    if not len(crowded):
        return evaluate(times)
    starts, sizes = steps[crowded], steps[crowded + 1] - steps[crowded]
    nodes = starts[:, None] + 0.5 * sizes[:, None] * (1.0 + _PLACES)
    coefficients, converged = _polynomials(evaluate(nodes.ravel()), max(tolerance, NODES_FINEST))
    index = np.full(len(steps), -1)
    index[crowded[converged]] = np.flatnonzero(converged)
    inner = index[places] >= 0
    result = np.empty((len(coefficients), len(times)))
    if not inner.all():
        halves = (starts + 0.5 * sizes)[~converged]
        result[:, ~inner] = between_nodes(np.sort(np.append(steps, halves)), times[~inner], evaluate, tolerance)
    of = np.flatnonzero(inner)
    for part in np.array_split(of, -(-len(of) // NODES_AT_ONCE) or 1):
        step = index[places[part]]
        weights = chebyshev.chebvander(2.0 * (times[part] - starts[step]) / sizes[step] - 1.0, NODES - 1)
        for row, own in zip(result, coefficients, strict=True):
            row[part] = np.einsum("tn,tn->t", weights, own[step])
    return result


def _polynomials(values: Array, tolerance: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return Chebyshev coefficients (nr, ns, NODES) of rows at the nodes of steps, and which steps have converged.

    Rows that are not known in a whole step (NaN) are not known between its nodes either.
    """
    table = values.reshape(len(values), -1, NODES)
    unknown = np.isnan(table)
    coefficients = table @ _TO_COEFFICIENTS.T
    size = np.sqrt(np.mean(np.nan_to_num(table) ** 2, axis=(1, 2)))[:, None]
    last = np.max(np.abs(np.nan_to_num(coefficients[:, :, -NODES_LAST:])), axis=2)
    partly = unknown.any(axis=2) & ~unknown.all(axis=2)
    return coefficients, np.all((last <= tolerance * size) & ~partly, axis=0)
