"""Shooting: a periodic motion with a given period is a fixed point of the return map.

This is a problem of `linkages.explore.periodic.continuation`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from linkages.arrays import Array
from linkages.explore.periodic.continuation import Curve, Residual


class Return(NamedTuple):
    """State after a period (n,), less whole turns; its derivatives with respect to the state before and to p."""

    end: Array
    monodromy: Array
    by_p: Array
    detail: Any = None


def forced(return_map: Callable[[Array, float], Return]) -> Curve:
    """Return the problem of a motion whose period is known: u is the state at the section (n,)."""

    def problem(u: Array, p: float) -> Residual:
        found = return_map(u, p)
        return Residual(found.end - u, found.monodromy - np.eye(len(u)), found.by_p, found)

    return problem
