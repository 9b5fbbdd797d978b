"""What the laws of contacts depend on: the motion of a journal in its bearing, or of a point against a surface.

A journal's motion (`JournalMotion`) is the vector e from the bearing's centre to its own, the rate of e, the angular
velocities of bearing and journal, the angles of both bodies. A point's motion (`PointMotion`) is its depth beyond the
surface, the rate of the depth, the sliding speed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, get_args

import numpy as np

from linkages.base.kernel import Array, inlined_kernel
from linkages.base.kernel.dual import number, seeded, with_number
from linkages.laws.journal import ContactResults, dry_force
from linkages.laws.states import Remembered
from linkages.mechanics.planar.markers import Arms, add_pair, both_at_b, gap, gap_rate

JournalMotion = tuple[float, float, float, float, float, float, float, float]
PointMotion = tuple[float, float, float]
Action = tuple[float, float, float]

_NEAR = 1e-3  # lower limit of the gap that scales a displacement, in parts of the clearance
CENTRE = 1e-12  #: distance from the centre at which a centred contact is differentiated [m]
_SLOW = 1e-9  # smallest speed that scales a velocity, clearances and lengths of 1 m per second


class Inputs(NamedTuple):
    """A form of motion, and inlined kernels for its tuples.

    Attributes
    ----------
    motion : type
        Of the tuples.
    size : int
        Number of inputs.
    speed : int
        The first input that is a speed; the first of all is a displacement.
    numbers : kernel
        ``numbers(motion)`` of duals.
    seeded : kernel
        ``seeded(motion, first)``: duals whose slopes are those along the inputs from this one on.
    with_numbers : kernel
        ``with_numbers(motion, numbers)``: other numbers with the slopes.
    off_centre : kernel
        ``off_centre(motion)``, a motion at which the law is differentiable.
    moved : kernel
        ``moved(motion, change, h)``: h times a change (size,) added.
    shifted : kernel
        ``shifted(motion, depth, closing, sliding)``, with changes of these.
    along : kernel
        ``along(partials, motion)``: the change of a result with its motion, duals, from partial derivatives. The
        changes with the states are not among it, nor is the result itself.
    fill_scales : kernel
        ``fill_scales(law, motion, out)``: changes of the inputs over which a contact's force changes.
    counts : tuple of bool
        Whether differences with respect to the inputs are needed.
    complete : kernel
        ``complete(motion, out)`` fills the derivatives that are not needed, from the others.
    """

    motion: Any
    size: int
    speed: int
    numbers: Callable[[Any], Any]
    seeded: Callable[[Any, int], Any]
    with_numbers: Callable[[Any, Any], Any]
    off_centre: Callable[[Any], Any]
    moved: Callable[[Any, Array, float], Any]
    shifted: Callable[[Any, float, float, float], Any]
    along: Callable[[Array, Any], Any]
    fill_scales: Callable[[np.record, Any, Array], None]
    counts: tuple[bool, ...]
    complete: Callable[[Any, Array], None]


# -- journals ----------------------------------------------------------------------------------------------------------


@inlined_kernel
def journal_frame(end: np.record, record: np.record, pose: Array) -> tuple[float, float, Arms]:
    """Compute the eccentricity of a journal, and the arms of both markers."""
    return gap(pose, end.bearing, end.journal)


@inlined_kernel
def journal_motion(
    end: np.record, record: np.record, law: np.record, frame: tuple[float, float, Arms], pose: Array, vel: Array
) -> JournalMotion:
    """Compute the motion of a journal."""
    ex, ey, arms = frame
    vx, vy = gap_rate(vel, end.bearing, end.journal, arms)
    b, j = end.bearing.body, end.journal.body
    return ex, ey, vx, vy, vel[b, 0], vel[j, 0], pose[b, 2], pose[j, 2]


@inlined_kernel
def journal_action(record: np.record, frame: tuple[float, float, Arms], found: Any) -> Action:
    """Return force and couple, which are the action of a journal."""
    return found[0], found[1], found[2]


@inlined_kernel
def journal_carried(record: np.record, frame: tuple[float, float, Arms], contact: Array) -> Action:
    """Return force and couple of a line of `linkages.mechanics.planar.contacts.CLEARANCE_OUTPUTS`."""
    return contact[2], contact[3], contact[4]


@inlined_kernel
def add_journal(
    wrench: Array, end: np.record, record: np.record, pose: Array, frame: Any, fx: float, fy: float, couple: float
) -> None:
    """Add the force pair of a journal: both forces act at the journal's marker."""
    add_pair(wrench, end.bearing, end.journal, both_at_b(frame[2], frame[0], frame[1]), fx, fy)
    wrench[end.journal.body, 0] += couple
    wrench[end.bearing.body, 0] -= couple


@inlined_kernel
def pair_power(
    end: np.record, record: np.record, frame: Any, pose: Array, vel: Array, fx: float, fy: float, couple: float
) -> float:
    """Compute the power of a force pair at the inner marker, a point of either body, and a couple."""
    vx, vy = gap_rate(vel, end.bearing, end.journal, frame[2])
    wb, wj = vel[end.bearing.body, 0], vel[end.journal.body, 0]
    return fx * (vx + wb * frame[1]) + fy * (vy - wb * frame[0]) + couple * (wj - wb)


@inlined_kernel
def _journal_numbers(motion: JournalMotion) -> JournalMotion:
    ex, ey, vx, vy, wb, wj, b, j = motion
    return number(ex), number(ey), number(vx), number(vy), number(wb), number(wj), number(b), number(j)


@inlined_kernel
def _journal_seeded(motion: JournalMotion, first: int) -> JournalMotion:
    ex, ey, vx, vy, wb, wj, b, j = motion
    return (
        seeded(ex, -first), seeded(ey, 1 - first), seeded(vx, 2 - first), seeded(vy, 3 - first),
        seeded(wb, 4 - first), seeded(wj, 5 - first), seeded(b, 6 - first), seeded(j, 7 - first),
    )  # fmt: skip


@inlined_kernel
def _journal_with_numbers(motion: JournalMotion, held: JournalMotion) -> JournalMotion:
    ex, ey, vx, vy, wb, wj, b, j = motion
    return (
        with_number(ex, held[0]), with_number(ey, held[1]), with_number(vx, held[2]), with_number(vy, held[3]),
        with_number(wb, held[4]), with_number(wj, held[5]), with_number(b, held[6]), with_number(j, held[7]),
    )  # fmt: skip


@inlined_kernel
def _journal_off_centre(motion: JournalMotion) -> JournalMotion:
    ex, ey, vx, vy, wb, wj, b, j = motion
    if ex == 0.0 and ey == 0.0:
        ex = CENTRE
    return ex, ey, vx, vy, wb, wj, b, j


@inlined_kernel
def _journal_moved(motion: JournalMotion, change: Array, h: float) -> JournalMotion:
    ex, ey, vx, vy, wb, wj, b, j = motion
    return (
        ex + h * change[0], ey + h * change[1], vx + h * change[2], vy + h * change[3],
        wb + h * change[4], wj + h * change[5], b + h * change[6], j + h * change[7],
    )  # fmt: skip


@inlined_kernel
def _journal_shifted(motion: JournalMotion, depth: float, closing: float, sliding: float) -> JournalMotion:
    ex, ey, vx, vy, wb, wj, b, j = motion
    distance = math.hypot(ex, ey)
    if distance == 0.0:
        return motion
    x, y = ex / distance, ey / distance
    vx, vy = vx + closing * x - sliding * y, vy + closing * y + sliding * x
    return ex + depth * x, ey + depth * y, vx, vy, wb, wj, b, j


@inlined_kernel
def _along_journal(partials: Array, motion: JournalMotion) -> Any:
    ex, ey, vx, vy, wb, wj, b, j = motion
    p = partials
    return p[0] * ex + p[1] * ey + p[2] * vx + p[3] * vy + p[4] * wb + p[5] * wj + p[6] * b + p[7] * j


@inlined_kernel
def _fill_journal_scales(law: np.record, motion: JournalMotion, out: Array) -> None:
    ex, ey, vx, vy, wb, wj, _, _ = motion
    c = law.clearance
    gap = max(abs(c - math.hypot(ex, ey)), _NEAR * c)
    speed = math.hypot(vx, vy) + c * (abs(wb) + abs(wj)) + _SLOW
    lever = max(law.radius, c)
    spin = abs(wb) + abs(wj) + speed / lever
    out[0], out[1], out[2], out[3], out[4], out[5] = gap, gap, speed, speed, spin, spin
    out[6], out[7] = gap / lever, gap / lever  # on a worn surface


@inlined_kernel
def _fill_own_turn(motion: JournalMotion, out: Array) -> None:
    """Fill the derivatives of a journal's results with respect to its own angular velocity from the others.

    The results are the same for observers who turn at different rates: dF/dw_j = e_y dF/dv_x - e_x dF/dv_y - dF/dw_b.
    """
    ex, ey, _, _, _, _, _, _ = motion
    for k in range(len(out)):
        out[k, 5] = ey * out[k, 2] - ex * out[k, 3] - out[k, 4]


@inlined_kernel
def _fill_nothing(motion: Any, out: Array) -> None:
    """Leave the derivatives as they are."""


_JOURNAL: dict[str, Any] = {
    "motion": JournalMotion, "size": len(get_args(JournalMotion)), "speed": 2,
    "numbers": _journal_numbers, "seeded": _journal_seeded,
    "with_numbers": _journal_with_numbers, "off_centre": _journal_off_centre, "moved": _journal_moved,
    "shifted": _journal_shifted, "along": _along_journal, "fill_scales": _fill_journal_scales,
}  # fmt: skip
#: Of a round journal, whose own angle has no effect, and of one whose angle has.
ROUND = Inputs(**_JOURNAL, counts=(*5 * (True,), False, True, False), complete=_fill_own_turn)
SHAPED = Inputs(**_JOURNAL, counts=8 * (True,), complete=_fill_nothing)
#: Duties of all kinds of journals.
OF_JOURNALS: dict[str, Any] = {
    "frame": journal_frame, "motion": journal_motion, "force": journal_action, "carried": journal_carried,
    "add": add_journal, "power": pair_power,
}  # fmt: skip


# -- points ------------------------------------------------------------------------------------------------------------


@inlined_kernel
def point_action(law: np.record, table: Array, remembered: Remembered, motion: PointMotion) -> ContactResults:
    """Compute the results of a dry contact: its action is the load, and the friction against positive sliding."""
    depth, closing, sliding = motion
    load, drag, a, b, c = dry_force(law, depth, closing, sliding, remembered)
    return load, drag, 0.0, a, b, c, depth, closing, sliding, load


@inlined_kernel
def _point_numbers(motion: PointMotion) -> PointMotion:
    return number(motion[0]), number(motion[1]), number(motion[2])


@inlined_kernel
def _point_seeded(motion: PointMotion, first: int) -> PointMotion:
    return seeded(motion[0], -first), seeded(motion[1], 1 - first), seeded(motion[2], 2 - first)


@inlined_kernel
def _point_with_numbers(motion: PointMotion, held: PointMotion) -> PointMotion:
    return with_number(motion[0], held[0]), with_number(motion[1], held[1]), with_number(motion[2], held[2])


@inlined_kernel
def _point_off_centre(motion: PointMotion) -> PointMotion:
    return motion


@inlined_kernel
def _point_moved(motion: PointMotion, change: Array, h: float) -> PointMotion:
    return motion[0] + h * change[0], motion[1] + h * change[1], motion[2] + h * change[2]


@inlined_kernel
def _point_shifted(motion: PointMotion, depth: float, closing: float, sliding: float) -> PointMotion:
    return motion[0] + depth, motion[1] + closing, motion[2] + sliding


@inlined_kernel
def _along_point(partials: Array, motion: PointMotion) -> Any:
    return partials[0] * motion[0] + partials[1] * motion[1] + partials[2] * motion[2]


@inlined_kernel
def _fill_point_scales(law: np.record, motion: PointMotion, out: Array) -> None:
    depth, closing, sliding = motion
    speed = math.hypot(closing, sliding) + _SLOW
    out[0], out[1], out[2] = max(abs(depth), _NEAR * law.clearance), speed, speed


POINT = Inputs(
    motion=PointMotion, size=len(get_args(PointMotion)), speed=1, numbers=_point_numbers, seeded=_point_seeded,
    with_numbers=_point_with_numbers, off_centre=_point_off_centre, moved=_point_moved, shifted=_point_shifted,
    along=_along_point, fill_scales=_fill_point_scales, counts=3 * (True,), complete=_fill_nothing,
)  # fmt: skip
