"""Closure rows: values, rates and accelerations of their terms, and the wrenches of their reactions.

A row (`linkages.mechanics.planar.record_types.ROW`) is a scalar closure equation of one or two terms: displacements or
angles between two markers.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel
from linkages.mechanics.planar.markers import add_pair, both_at_b, gap, gap_acceleration, gap_rate, turned
from linkages.mechanics.planar.record_types import ALONG_BODY, ANGLE


@kernel
def term_value(term: np.record, pose: Array) -> float:
    """Displacement or angle between the two markers of a term [m, rad]."""
    if term.kind == ANGLE:
        return pose[term.b.body, 2] - pose[term.a.body, 2]
    dx, dy, _ = gap(pose, term.a, term.b)
    ux, uy = term_direction(term, pose)
    return dx * ux + dy * uy


@inlined_kernel
def term_direction(term: np.record, pose: Array) -> tuple[float, float]:
    """Direction of a term in plane axes."""
    if term.kind == ALONG_BODY:
        return turned(pose, term.a.body, term.ux, term.uy)
    return term.ux, term.uy


@kernel
def term_rate(term: np.record, pose: Array, vel: Array) -> float:
    """Time derivative of `term_value`."""
    if term.kind == ANGLE:
        return vel[term.b.body, 0] - vel[term.a.body, 0]
    dx, dy, arms = gap(pose, term.a, term.b)
    vx, vy = gap_rate(vel, term.a, term.b, arms)
    ux, uy = term_direction(term, pose)
    rate = vx * ux + vy * uy
    if term.kind == ALONG_BODY:
        rate += vel[term.a.body, 0] * (dy * ux - dx * uy)
    return rate


@kernel
def term_acceleration(term: np.record, pose: Array, vel: Array, acc: Array) -> float:
    """Second time derivative of `term_value`."""
    if term.kind == ANGLE:
        return acc[term.b.body, 0] - acc[term.a.body, 0]
    dx, dy, arms = gap(pose, term.a, term.b)
    ax, ay = gap_acceleration(vel, acc, term.a, term.b, arms)
    ux, uy = term_direction(term, pose)
    second = ax * ux + ay * uy
    if term.kind == ALONG_BODY:
        w, alpha = vel[term.a.body, 0], acc[term.a.body, 0]
        vx, vy = gap_rate(vel, term.a, term.b, arms)
        turn = alpha * (dy * ux - dx * uy) - w * w * (dx * ux + dy * uy)
        second += 2.0 * w * (vy * ux - vx * uy) + turn
    return second


@kernel
def add_term_wrench(term: np.record, pose: Array, size: float, wrench: Array) -> None:
    """Add the wrenches of a term's reaction of this size [N, N m]: on body b, and the opposite on body a."""
    if term.kind == ANGLE:
        wrench[term.b.body, 0] += size
        wrench[term.a.body, 0] -= size
        return
    dx, dy, arms = gap(pose, term.a, term.b)
    ux, uy = term_direction(term, pose)
    if term.kind == ALONG_BODY:  # the force on body a acts at marker b too
        arms = both_at_b(arms, dx, dy)
    add_pair(wrench, term.a, term.b, arms, size * ux, size * uy)


@kernel
def row_value(row: np.record, pose: Array) -> float:
    """Closure error of one row [m, rad]; zero when the joint is closed."""
    value = term_value(row.term, pose)
    return value if row.ratio == 0.0 else value - row.ratio * term_value(row.other, pose) - row.offset


@kernel
def row_rate(row: np.record, pose: Array, vel: Array) -> float:
    """Time derivative of `row_value`."""
    rate = term_rate(row.term, pose, vel)
    return rate if row.ratio == 0.0 else rate - row.ratio * term_rate(row.other, pose, vel)


@kernel
def row_acceleration(row: np.record, pose: Array, vel: Array, acc: Array) -> float:
    """Second time derivative of `row_value`."""
    second = term_acceleration(row.term, pose, vel, acc)
    return second if row.ratio == 0.0 else second - row.ratio * term_acceleration(row.other, pose, vel, acc)


@kernel
def add_row_wrench(row: np.record, pose: Array, size: float, wrench: Array) -> None:
    """Add the wrenches of a row's reaction of this size [N, N m]."""
    if row.ratio != 0.0:
        add_term_wrench(row.other, pose, -row.ratio * size, wrench)
    add_term_wrench(row.term, pose, size, wrench)
