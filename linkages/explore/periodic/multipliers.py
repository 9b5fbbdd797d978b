"""Floquet multipliers: stability of a periodic motion, and the kinds of its bifurcations.

The multipliers are the eigenvalues of the monodromy matrix, the derivative of the state after a period with respect to
the state before it. A motion is stable if all of them lie inside the unit circle. Along a branch, a bifurcation is a
point where one multiplier, or a complex pair, crosses the circle:

==================== ==========================================================================================
kind                 rule
==================== ==========================================================================================
fold                 the branch turns back: its parameter has an extremum; a real multiplier crosses +1
branch point         a real multiplier crosses +1, and the branch does not turn back
period doubling      a real multiplier crosses -1
Neimark-Sacker       a complex pair crosses the circle
grazing              the sequence of contacts in a period changes: a contact begins or ends to exist
==================== ==========================================================================================
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array

FOLD, BRANCH_POINT, DOUBLING, NEIMARK_SACKER, GRAZING = (
    "fold", "branch point", "period doubling", "Neimark-Sacker", "grazing",
)  # fmt: skip

Multipliers = NDArray[np.complex128]


def multipliers(monodromy: Array) -> Multipliers:
    """Compute the Floquet multipliers (n,) of a monodromy matrix (n, n), the largest magnitude first; NaN if it is."""
    if not np.isfinite(monodromy).all():
        return np.full(len(monodromy), np.nan + 0j)
    found = np.linalg.eigvals(monodromy).astype(np.complex128)
    return found[np.lexsort((-found.imag, -np.abs(found)))]


def unstable(found: Multipliers) -> int:
    """Count the multipliers outside the unit circle."""
    return int(np.count_nonzero(np.abs(found) > 1.0))


def crossing(before: Multipliers, after: Multipliers) -> int | None:
    """Return the index of a multiplier, in order of magnitude, that crosses the circle between two points; else None.

    If several cross, it is the one that leaves the circle last.
    """
    fewer, more = sorted((unstable(before), unstable(after)))
    return None if fewer == more else fewer


def kind(at_circle: complex, turns_back: bool) -> str:
    """Classify a bifurcation by the multiplier on the circle, and by whether the branch turns back there."""
    if at_circle.imag != 0.0:
        return NEIMARK_SACKER
    if at_circle.real < 0.0:
        return DOUBLING
    return FOLD if turns_back else BRANCH_POINT
