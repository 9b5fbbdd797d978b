"""A coordinate at its limit: a joint's at a stop, or the closure error of a gear at a flank of its teeth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.base.kernel import Array, Records, inlined_kernel, record_type
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_rate, row_value
from linkages.mechanics.planar.contact_motions import POINT, Action, PointMotion, point_action
from linkages.mechanics.planar.contacts import FX, LOAD, ContactKind
from linkages.mechanics.planar.record_types import ANGLE, ROW

RECORD = record_type(
    at="i8",
    row=ROW,  # its value is limited: an angle between bodies, or a closure error
    side="f8",  # +1 if a growing value meets the limit, else -1
    place="f8",  # side times the place of the limit, less the clearance
    lever="f8",  # of depth and place over the value: 1, or the base radius of a wheel [m]
    arm="f8",  # sliding speed over the angular velocity of the inner body relative to the outer one [m]
)

Frame = tuple[float, float]  #: zeros


@inlined_kernel
def frame(end: np.record, record: np.record, pose: Array) -> Frame:
    """Return no eccentricity."""
    return 0.0, 0.0


@inlined_kernel
def motion(end: np.record, record: np.record, law: np.record, at: Frame, pose: Array, vel: Array) -> PointMotion:
    """Compute the depth of the value beyond its limit, and the speed at which teeth slide."""
    along, turn = record.side * record.lever, vel[end.journal.body, 0] - vel[end.bearing.body, 0]
    depth = along * row_value(record.row, pose) - record.place - law.clearance
    return depth, along * row_rate(record.row, pose, vel), record.arm * turn


@inlined_kernel
def force(record: np.record, at: Frame, found: Action) -> Action:
    """Compute the couple of the friction, 0, and the effort on the row, from load and friction."""
    return -record.arm * found[1], 0.0, -record.side * record.lever * found[0]


@inlined_kernel
def carried(record: np.record, at: Frame, contact: Array) -> Action:
    """Return load and friction of known efforts."""
    return contact[LOAD], -contact[FX] / record.arm if record.arm > 0.0 else 0.0, 0.0


@inlined_kernel
def add(
    wrench: Array, end: np.record, record: np.record, pose: Array, at: Frame, fx: float, fy: float, couple: float
) -> None:
    """Add the effort on the row, and the couple of the friction."""
    add_row_wrench(record.row, pose, couple, wrench)
    wrench[end.journal.body, 0] += fx
    wrench[end.bearing.body, 0] -= fx


@inlined_kernel
def power(
    end: np.record, record: np.record, at: Frame, pose: Array, vel: Array, fx: float, fy: float, couple: float
) -> float:
    """Compute the power of both."""
    return fx * (vel[end.journal.body, 0] - vel[end.bearing.body, 0]) + couple * row_rate(record.row, pose, vel)


LIMIT = ContactKind(
    name="limit",
    record=RECORD,
    inputs=POINT,
    frame=frame,
    motion=motion,
    action=point_action,
    force=force,
    carried=carried,
    add=add,
    power=power,
)


def levers(records: Records, count: int) -> tuple[NDArray[np.bool_], Array]:
    """Return which of so many contacts limit an angle, and the depth of each per angle, (nc,)."""
    turns, lever = np.zeros(count, bool), np.ones(count)
    turns[records["at"]], lever[records["at"]] = records["row"]["term"]["kind"] == ANGLE, records["lever"]
    return turns, lever
