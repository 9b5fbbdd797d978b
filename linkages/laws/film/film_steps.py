"""The steps of a film with history: its content moves with a run, which chooses the film step.

The film step tau follows from the error of the force: a film that builds up pressure too early is a cushion that takes
the peak of an impact on the edge of the oil. After each step of a run the forces at the film steps 2 tau and tau are
compared. Since a step is at most tau/4, the first one shows the oil ahead before the second one feels it. A constant
film step has errors that no comparison of neighbouring film steps shows, as long as both are longer than the impact.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.laws.film.film_history import (
    FORCE,
    MISSING,
    PLACE_X,
    PLACE_Y,
    STEP,
    TIME,
    gap_of,
    in_bearing,
    sheet_of,
    solve_history,
    supply_of,
)

_EASY = 0.3  # of the permitted error, below which the film step doubles, which about doubles the error
_SHORTEST = 2.0**-16  # film step over the longest one: jumps where a cell fills have errors at any film step
# Longest step of a run over the film step: the content changes between steps; with whole film steps a journal that
# crosses the cavity overshoots the oil.
_OF_STEP = 0.25


@inlined_kernel
def longest_step_of(oil: Array) -> float:
    """Return the longest step of a run with the film step in a film's memory [s]."""
    return _OF_STEP * oil[STEP]


@kernel(makes_arrays=True)
def _choose_step(
    joint: np.record, table: Array, oil: Array, place: tuple[float, float, float, float, float, float], spin: float
) -> None:
    """Set the film step for the next step of a run: halve it until the error of the force is permitted, or double it.

    From the results of `in_bearing`. The change of the force at half the film step is its error, to first order.
    """
    x, y, u, v, _, _ = place
    sheet, supply = sheet_of(table), supply_of(joint)
    scale = joint.viscosity * joint.radius**4 / joint.clearance**2
    step, shortest = oil[STEP], _SHORTEST * sheet.longest
    oil[STEP] = 2.0 * step
    ahead_x, ahead_y, _, _ = solve_history(table, oil, x, y, u, v, spin, supply)
    while True:
        oil[STEP] = step
        fx, fy, _, _ = solve_history(table, oil, x, y, u, v, spin, supply)
        oil[FORCE] = max(oil[FORCE], scale * math.hypot(fx, fy))
        error = scale * math.hypot(fx - ahead_x, fy - ahead_y)
        permitted = sheet.accuracy * max(oil[FORCE], sheet.least)
        if error <= permitted or step <= shortest:
            break
        step *= 0.5
        ahead_x, ahead_y = fx, fy
    if error < _EASY * permitted:
        oil[STEP] = min(2.0 * step, sheet.longest)


@lazy_kernel(makes_arrays=True)
def advance_film(
    joint: np.record, table: Array, oil: Array, t: float, ex: float, ey: float, vx: float, vy: float, omega_b: float,
    omega_j: float, angle: float,
) -> None:  # fmt: skip
    """Move the missing volumes of a film from the last step to time t and a state, and choose the next film step.

    Arguments of `history_force`. The volumes of the gap change by their true amounts: the oil is
    balanced.
    """
    place = in_bearing(joint, ex, ey, vx, vy, omega_b, angle)
    x, y, _, _, _, _ = place
    h, spin = t - oil[TIME], omega_j - omega_b
    if h > 0.0:
        u, v = (x - oil[PLACE_X]) / h, (y - oil[PLACE_Y]) / h
        solve_history(table, oil, x, y, u, v, spin, supply_of(joint), h)
        oil[TIME], oil[PLACE_X], oil[PLACE_Y] = t, x, y
    if sheet_of(table).accuracy > 0.0:
        _choose_step(joint, table, oil, place, spin)


@lazy_kernel(makes_arrays=True)
def start_film(
    joint: np.record, table: Array, oil: Array, t: float, ex: float, ey: float, angle: float, fresh: bool
) -> None:
    """Set time and place of a film's last step, and with ``fresh`` content and film step to those at a run's start."""
    x, y, _, _, _, _ = in_bearing(joint, ex, ey, 0.0, 0.0, 0.0, angle)
    sheet = sheet_of(table)
    n, m = sheet.supply.shape
    if fresh:
        oil[FORCE], oil[STEP] = 0.0, sheet.longest
    for i in range(n if fresh else 0):
        for j in range(m):
            missing = (1.0 - sheet.content) * ((sheet.ends[j + 1] - sheet.ends[j]) * gap_of(sheet, i, x, y))
            oil[MISSING + i * m + j] = missing if sheet.supply[i, j] < 0.0 else 0.0
            oil[MISSING + n * m + i * m + j] = 0.0
    oil[TIME], oil[PLACE_X], oil[PLACE_Y] = t, x, y
