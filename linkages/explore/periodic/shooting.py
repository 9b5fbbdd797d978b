"""Shooting: periodic motions as solutions of a system of equations.

A motion with a given period is a fixed point of the return map; one of an autonomous system has an unknown period, and
a phase condition fixes its state along the orbit. Both are problems of `linkages.explore.periodic.continuation`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from linkages.arrays import Array
from linkages.explore.periodic.continuation import Problem, Residual


class Return(NamedTuple):
    """State after a period (n,), less whole turns; its derivatives with respect to the state before and to p.

    `rate` (n,) is the time derivative at the end, which an unknown period needs.
    """

    end: Array
    monodromy: Array
    by_p: Array
    rate: Array | None = None
    detail: Any = None


def forced(return_map: Callable[[Array, float], Return]) -> Problem:
    """Return the problem of a motion whose period is known: u is the state at the section (n,)."""

    def problem(u: Array, p: float) -> Residual:
        found = return_map(u, p)
        return Residual(found.end - u, found.monodromy - np.eye(len(u)), found.by_p, found)

    return problem


def autonomous(flow: Callable[[Array, float, float], Return], anchor: Array, along: Array) -> Problem:
    """Return the problem of a motion with an unknown period: u is the state and the period (n + 1,).

    Parameters
    ----------
    flow : callable
        ``flow(state, duration, p)``.
    anchor, along : (n,) arrays
        The state lies on the plane through `anchor` normal to `along`, which is close to the flow's direction there.
    """

    def problem(u: Array, p: float) -> Residual:
        state, n = u[:-1], len(u) - 1
        found = flow(state, float(u[-1]), p)
        if found.rate is None:
            raise AssertionError("an unknown period needs the rate")
        by_u = np.zeros((n + 1, n + 1))
        by_u[:n, :n] = found.monodromy - np.eye(n)
        by_u[:n, n], by_u[n, :n] = found.rate, along
        value = np.append(found.end - state, along @ (state - anchor))
        return Residual(value, by_u, np.append(found.by_p, 0.0), found)

    return problem
