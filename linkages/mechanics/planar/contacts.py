"""Clearance joints in a tree: from body states to force pairs, by the laws."""

from __future__ import annotations

from typing import get_args

import numpy as np
from numpy.typing import NDArray

from linkages.base.kernel import Array, Records, inlined_kernel, kernel
from linkages.laws.film.film_history import history_force
from linkages.laws.journal import ContactResults, clearance_force, dry_force
from linkages.laws.states import REMEMBERED, STATES, Remembered, remembered_of
from linkages.laws.wear.force import call_worn
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_rate, row_value
from linkages.mechanics.planar.markers import Arms, add_pair, both_at_b, gap, gap_rate, turned
from linkages.mechanics.planar.record_types import CORNER, JOURNAL, REMEMBERING, STOP, WORN

#: Quantities of each contact at a state: eccentricity e [m], force [N] and couple [N m] on the journal, penetration
#: [m], its rate and the sliding speed of the journal's surface [m/s], normal load of the contact without a film's [N].
#: For the corner of a block, e points from the slot's marked point, on its middle line, to the corner, and the force
#: acts at the corner. For a stop, penetration, its rate and the load are angular; for the flank of a gear with a base
#: radius they are along its line of action.
CLEARANCE_OUTPUTS = ("ex", "ey", "fx", "fy", "couple", "penetration", "closing", "sliding", "load")
#: After these, of a film that remembers, and zero of others: film content [1], volume flow out of both ends [m3/s].
#: Then the rates of the contact's states.
WIDTH = len(CLEARANCE_OUTPUTS) + 2 + STATES
EX, EY, FX, FY, COUPLE, PENETRATION, CLOSING, SLIDING, LOAD, CONTENT, FLOW, RATES = range(WIDTH - STATES + 1)

#: Motion of a contact, see `contact_motion`.
ContactMotion = tuple[float, float, float, float, float, float, float, float]

#: Results of a contact's law: force (2) and couple, rates of its states, penetration, its rate, sliding speed, load.
FORCE_X, FORCE_Y, FORCE_COUPLE, FIRST_RATE = range(4)
RESULTS = len(get_args(ContactResults))
#: Their places in a line of `CLEARANCE_OUTPUTS`, flow and rates.
RESULT_PLACES = (FX, FY, COUPLE, *range(RATES, WIDTH), PENETRATION, CLOSING, SLIDING, LOAD)


def limits_a_row(ends: Records) -> NDArray[np.bool_]:
    """Return which contacts limit the value of a row, (nc,)."""
    return np.asarray(ends["kind"] == STOP)


@inlined_kernel
def clearance_wrenches(
    ends: Records, laws: Records, tables: Array, memory: Array, pose: Array, vel: Array, wrench: Array, out: Array
) -> None:
    """Add the force pair of every clearance joint to the bodies' wrenches.

    ``tables`` (nc, nt) have the map of each contact's finite film, or its cells if it remembers; of a worn joint, at
    the line's end, its profiles, see `linkages.laws.wear.force.place_of`. ``memory`` is the one of each contact, see
    `linkages.mechanics.planar.contact_memory`. ``out`` (nc, WIDTH) is filled with `CLEARANCE_OUTPUTS`, content and
    flow, rates of the states.
    """
    for k in range(len(ends)):
        end = ends[k]
        motion, arms = contact_motion(end, pose, vel)
        found, content, flow = remembered_action(end, laws[k], tables[k], memory[k], remembered_of(memory[k]), motion)
        fx, fy, couple, one, two, three, delta, closing, sliding, load = found
        add_contact(wrench, end, pose, motion[0], motion[1], arms, fx, fy, couple)
        out[k, EX], out[k, EY], out[k, FX], out[k, FY], out[k, COUPLE] = motion[0], motion[1], fx, fy, couple
        out[k, PENETRATION], out[k, CLOSING], out[k, SLIDING], out[k, LOAD] = delta, closing, sliding, load
        out[k, CONTENT], out[k, FLOW] = content, flow
        out[k, RATES], out[k, RATES + 1], out[k, RATES + 2] = one, two, three


@inlined_kernel
def add_contact(
    wrench: Array, end: np.record, pose: Array, ex: float, ey: float, arms: Arms, fx: float, fy: float, couple: float
) -> None:
    """Add a contact's force pair to the bodies' wrenches: both forces act at the journal's marker."""
    if end.kind == STOP:
        add_row_wrench(end.row, pose, couple, wrench)
        couple = fx
    else:
        add_pair(wrench, end.bearing, end.journal, both_at_b(arms, ex, ey), fx, fy)
    wrench[end.journal.body, 0] += couple
    wrench[end.bearing.body, 0] -= couple


@inlined_kernel
def contact_motion(end: np.record, pose: Array, vel: Array) -> tuple[ContactMotion, Arms]:
    """Compute the motion of a contact's inner end relative to its outer end, and the arms of both.

    The motion is the vector e between the ends, its rate, the angular velocities of outer and inner body; corner: the
    normal into the wall; worn, grooved, remembering: the angles of outer and inner body. Stop: the first rate is the
    angular velocity of the inner body relative to the outer one, and rate and value of the row are the last angular
    velocity and angle.
    """
    ex, ey, arms = gap(pose, end.bearing, end.journal)
    vx, vy = gap_rate(vel, end.bearing, end.journal, arms)
    nx, ny, wb, wj = 0.0, 0.0, vel[end.bearing.body, 0], vel[end.journal.body, 0]
    if end.kind == CORNER:
        nx, ny = turned(pose, end.bearing.body, end.nx, end.ny)
    elif end.kind == STOP:
        ny, vx, vy = row_value(end.row, pose), wj - wb, 0.0
        wb, wj = 0.0, row_rate(end.row, pose, vel)
    elif end.kind != JOURNAL:
        nx, ny = pose[end.bearing.body, 2], pose[end.journal.body, 2]
    return (ex, ey, vx, vy, wb, wj, nx, ny), arms


@kernel
def contact_action(
    end: np.record, law: np.record, table: Array, remembered: Remembered, motion: ContactMotion
) -> ContactResults:
    """Compute the force (2) and couple on the inner body, and the state of the contact, from `contact_motion`.

    Stop: the friction's couple, 0, and the effort on the row. The state is the rates of what the contact remembers,
    penetration, its rate, sliding speed, normal load.
    """
    return _action(end, law, table, remembered, motion)


@inlined_kernel
def _action(
    end: np.record, law: np.record, table: Array, remembered: Remembered, motion: ContactMotion
) -> ContactResults:
    """Compute `contact_action` within its caller: the call costs a tenth of a run."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if end.kind == CORNER:
        vx, vy = vx + wb * ey, vy - wb * ex  # relative to the wall's own material
        delta = ex * nx + ey * ny - end.half - law.clearance
        closing, sliding = vx * nx + vy * ny, vy * nx - vx * ny
        load, drag, a, b, c = dry_force(law, delta, closing, sliding, remembered)
        return -load * nx + drag * ny, -load * ny - drag * nx, 0.0, a, b, c, delta, closing, sliding, load
    if end.kind == STOP:
        along = end.nx * end.lever
        delta, closing = along * ny - end.half - law.clearance, along * wj
        load, drag, a, b, c = dry_force(law, delta, closing, end.arm * vx, remembered)
        return -end.arm * drag, 0.0, -along * load, a, b, c, delta, closing, end.arm * vx, load
    if end.kind == WORN:
        latched, a, b, c = remembered
        return call_worn(law.worn, (law, table, ex, ey, vx, vy, wb, wj, nx, ny, latched, a, b, c))
    return clearance_force(law, table, ex, ey, vx, vy, wb, wj, remembered, nx)


@inlined_kernel
def has_cells(end: np.record) -> bool:
    """Whether a contact remembers cells, so that differences give its derivatives."""
    return bool(end.kind == REMEMBERING)


@inlined_kernel
def remembered_action(
    end: np.record, law: np.record, table: Array, memory: Array, remembered: Remembered, motion: ContactMotion
) -> tuple[ContactResults, float, float]:
    """Compute the results of `contact_action` with a contact's memory, then film content and flow."""
    if has_cells(end):
        ex, ey, vx, vy, wb, wj, angle, _ = motion
        fx, fy, couple, delta, closing, sliding, content, flow = history_force(
            law, table, memory[REMEMBERED:], ex, ey, vx, vy, wb, wj, angle
        )
        return (fx, fy, couple, 0.0, 0.0, 0.0, delta, closing, sliding, 0.0), content, flow
    return _action(end, law, table, remembered, motion), 0.0, 0.0
