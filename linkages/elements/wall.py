"""A point at a straight wall: a corner of a block in its slot, a point at a line, a block at its limit."""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, record_type
from linkages.base.kernel.dual import number
from linkages.mechanics.planar.contact_motions import POINT, Action, PointMotion, pair_power, point_action
from linkages.mechanics.planar.contacts import FX, FY, LOAD, ContactKind
from linkages.mechanics.planar.markers import Arms, add_pair, both_at_b, gap, gap_rate, turned

RECORD = record_type(
    at="i8",
    nx="f8",  # normal into the wall, in the outer body's frame
    ny="f8",
    place="f8",  # of the wall along the normal, from the outer marker, less the clearance [m]
)

Frame = tuple[float, float, Arms, float, float]  #: from the outer marker to the point, arms of both, normal


@inlined_kernel
def frame(end: np.record, record: np.record, pose: Array) -> Frame:
    """Compute the place of the point, and the normal into the wall."""
    ex, ey, arms = gap(pose, end.bearing, end.journal)
    nx, ny = turned(pose, end.bearing.body, record.nx, record.ny)
    return ex, ey, arms, nx, ny


@inlined_kernel
def motion(end: np.record, record: np.record, law: np.record, at: Frame, pose: Array, vel: Array) -> PointMotion:
    """Compute depth and speeds relative to the wall's own material."""
    ex, ey, arms, nx, ny = at
    vx, vy = gap_rate(vel, end.bearing, end.journal, arms)
    wb = vel[end.bearing.body, 0]
    vx, vy = vx + wb * ey, vy - wb * ex
    return ex * nx + ey * ny - record.place - law.clearance, vx * nx + vy * ny, vy * nx - vx * ny


@inlined_kernel
def force(record: np.record, at: Frame, found: Action) -> Action:
    """Compute the force on the point, from load and friction."""
    nx, ny = at[3], at[4]
    return -found[0] * nx + found[1] * ny, -found[0] * ny - found[1] * nx, 0.0


@inlined_kernel
def carried(record: np.record, at: Frame, contact: Array) -> Action:
    """Return load and friction of a known force."""
    return contact[LOAD], contact[FX] * number(at[4]) - contact[FY] * number(at[3]), 0.0


@inlined_kernel
def add(
    wrench: Array, end: np.record, record: np.record, pose: Array, at: Frame, fx: float, fy: float, couple: float
) -> None:
    """Add the force pair at the point."""
    add_pair(wrench, end.bearing, end.journal, both_at_b(at[2], at[0], at[1]), fx, fy)


WALL = ContactKind(
    name="wall",
    record=RECORD,
    inputs=POINT,
    frame=frame,
    motion=motion,
    action=point_action,
    force=force,
    carried=carried,
    add=add,
    power=pair_power,
)
