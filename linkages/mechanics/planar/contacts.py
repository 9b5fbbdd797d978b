"""Clearance joints in a tree: from body states to force pairs, by the laws."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.base.kernel import Array, Records, inlined_kernel, kernel, lazy_kernel
from linkages.laws.contact.contact_forces import GRAZING
from linkages.laws.film.film_history import STEP, history_force, memory_of, recorded_entries
from linkages.laws.film.film_steps import advance_film, longest_step_of, start_film
from linkages.laws.journal import clearance_force, dry_force
from linkages.laws.wear.force import call_worn
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_rate, row_value
from linkages.mechanics.planar.markers import Arms, add_pair, both_at_b, gap, gap_rate, turned
from linkages.mechanics.planar.record_types import CORNER, JOURNAL, REMEMBERING, STOP, WORN

#: Quantities of each contact at a state: eccentricity e [m], force [N] and couple [N m] on the journal, penetration
#: [m], its rate and the sliding speed of the journal's surface [m/s], normal load of the contact without a film's [N],
#: rate of LuGre's bristles [m/s]. For the corner of a block, e points from the slot's marked point, on its middle line,
#: to the corner, and the force acts at the corner. For a stop, penetration, its rate and the load are angular; for
#: the flank of a gear with a base radius they are along its line of action.
CLEARANCE_OUTPUTS = ("ex", "ey", "fx", "fy", "couple", "penetration", "closing", "sliding", "load", "bristle_rate")
#: After these, of a film that remembers, and zero of others: film content [1], volume flow out of both ends [m3/s].
WIDTH = len(CLEARANCE_OUTPUTS) + 2
EX, EY, FX, FY, COUPLE, PENETRATION, CLOSING, SLIDING, LOAD, BRISTLE_RATE, CONTENT, FLOW = range(WIDTH)

#: Motion of a contact, see `contact_motion`.
ContactMotion = tuple[float, float, float, float, float, float, float, float]

#: Memory of each contact: the speed at which it began [m/s], LuGre's bristle state [m]; from `OIL` on what its film
#: remembers, see `linkages.laws.film.film_history`.
APPROACH, BRISTLE, OIL = 0, 1, 2

_LANDING = 1e-10  # accuracy to which the start and end of a contact are located, in parts of the clearance
_ROUNDING = 4e-16  # lower limit of that accuracy, in parts of the linkage's length


@kernel
def fill_landing(laws: Records, size: float, out: Array) -> None:
    """Fill ``out`` (nc,) with the accuracies to which the start and end of each contact are located [m; stop: rad]."""
    for k in range(len(laws)):
        out[k] = max(_LANDING * laws[k].clearance, _ROUNDING * size)


def make_memory(ends: Records, tables: Array) -> Array:
    """Make the memory of contacts, (nc, 2), or wider if a film remembers; all zero."""
    films = np.flatnonzero(ends["kind"] == REMEMBERING)
    return np.zeros((len(ends), OIL + max((memory_of(tables[k]) for k in films), default=0)))


def limits_a_row(ends: Records) -> NDArray[np.bool_]:
    """Return which contacts limit the value of a row, (nc,)."""
    return np.asarray(ends["kind"] == STOP)


@inlined_kernel
def has_films(memory: Array) -> bool:
    """Whether contacts with this memory can have films that remember."""
    return memory.shape[1] > OIL


@inlined_kernel
def recorded_part(memory: Array) -> tuple[int, int]:
    """Return the first of the entries of a film, and their number, that its next step depends on."""
    return OIL + STEP, recorded_entries(memory.shape[1] - OIL)


@kernel
def approach_at_start(delta: float, closing: float, landing: float) -> float:
    """Return the approach speed of a contact at the start of a run; infinite where no contact begins there.

    A contact begins at the start if the bodies touch and do not separate, or if they overlap and approach faster than
    `GRAZING`. Bodies that overlap otherwise were in contact before: the speed at which that contact began is unknown,
    and an infinite speed gives a contact without damping. `delta` and `closing` are the penetration [m] and its rate
    [m/s], `landing` is the contact's, see above.
    """
    least = GRAZING if delta > landing else -GRAZING
    return max(closing, 0.0) if delta >= -landing and closing > least else np.inf


@inlined_kernel
def clearance_wrenches(
    ends: Records, laws: Records, tables: Array, memory: Array, pose: Array, vel: Array, wrench: Array, out: Array
) -> None:
    """Add the force pair of every clearance joint to the bodies' wrenches.

    ``tables`` (nc, nt) have the map of each contact's finite film, or its cells if it remembers; of a worn joint, at
    the line's end, its profiles, see `linkages.laws.wear.force.place_of`. ``memory`` has `APPROACH`, `BRISTLE` and
    `OIL` of each contact. ``out`` (nc, WIDTH) is filled with `CLEARANCE_OUTPUTS`, content and flow.
    """
    for k in range(len(ends)):
        end = ends[k]
        motion, arms = contact_motion(end, pose, vel)
        ex, ey, _, _, _, _, _, _ = motion
        fx, fy, couple, rate, delta, closing, sliding, load, content, flow = remembered_action(
            end, laws[k], tables[k], memory[k], memory[k, BRISTLE], motion
        )
        add_contact(wrench, end, pose, ex, ey, arms, fx, fy, couple)
        out[k, EX], out[k, EY], out[k, FX], out[k, FY], out[k, COUPLE] = ex, ey, fx, fy, couple
        out[k, PENETRATION], out[k, CLOSING], out[k, SLIDING] = delta, closing, sliding
        out[k, LOAD], out[k, BRISTLE_RATE], out[k, CONTENT], out[k, FLOW] = load, rate, content, flow


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
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: ContactMotion
) -> tuple[float, float, float, float, float, float, float, float]:
    """Compute the force (2) and couple on the inner body, and the state of the contact, from `contact_motion`.

    Stop: the friction's couple, 0, and the effort on the row. The state is the rate of the bristles, penetration, its
    rate, sliding speed, normal load.
    """
    return _action(end, law, table, approach, bristle, motion)


@inlined_kernel
def _action(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: ContactMotion
) -> tuple[float, float, float, float, float, float, float, float]:
    """Compute `contact_action` within its caller: the call costs a tenth of a run."""
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if end.kind == CORNER:
        vx, vy = vx + wb * ey, vy - wb * ex  # relative to the wall's own material
        delta = ex * nx + ey * ny - end.half - law.clearance
        closing, sliding = vx * nx + vy * ny, vy * nx - vx * ny
        load, drag, rate = dry_force(law, delta, closing, sliding, approach, bristle)
        return -load * nx + drag * ny, -load * ny - drag * nx, 0.0, rate, delta, closing, sliding, load
    if end.kind == STOP:
        along = end.nx * end.lever
        delta, closing = along * ny - end.half - law.clearance, along * wj
        load, drag, rate = dry_force(law, delta, closing, end.arm * vx, approach, bristle)
        return -end.arm * drag, 0.0, -along * load, rate, delta, closing, end.arm * vx, load
    if end.kind == WORN:
        return call_worn(law.worn, (law, table, ex, ey, vx, vy, wb, wj, nx, ny, approach, bristle))
    return clearance_force(law, table, ex, ey, vx, vy, wb, wj, approach, bristle, nx)


@inlined_kernel
def remembered_action(
    end: np.record, law: np.record, table: Array, memory: Array, bristle: float, motion: ContactMotion
) -> tuple[float, float, float, float, float, float, float, float, float, float]:
    """Compute the results of `contact_action` with a contact's memory, then film content and flow."""
    if end.kind == REMEMBERING:
        ex, ey, vx, vy, wb, wj, angle, _ = motion
        return history_force(law, table, memory[OIL:], ex, ey, vx, vy, wb, wj, angle)
    fx, fy, couple, rate, delta, closing, sliding, load = _action(end, law, table, memory[APPROACH], bristle, motion)
    return fx, fy, couple, rate, delta, closing, sliding, load, 0.0, 0.0


@lazy_kernel
def start_films(
    ends: Records, laws: Records, tables: Array, memory: Array, t: float, pose: Array, vel: Array, fresh: bool
) -> None:
    """Set time and place of the films that remember, and with ``fresh`` their content at the start of a run."""
    for k in range(len(ends)):
        if ends[k].kind == REMEMBERING:
            ex, ey, _, _, _, _, angle, _ = contact_motion(ends[k], pose, vel)[0]
            start_film(laws[k], tables[k], memory[k, OIL:], t, ex, ey, angle, fresh)


@lazy_kernel
def advance_films(
    ends: Records, laws: Records, tables: Array, memory: Array, t: float, pose: Array, vel: Array
) -> None:
    """Move the content of the films that remember to time t and these states, and choose their film steps."""
    for k in range(len(ends)):
        if ends[k].kind == REMEMBERING:
            ex, ey, vx, vy, wb, wj, angle, _ = contact_motion(ends[k], pose, vel)[0]
            advance_film(laws[k], tables[k], memory[k, OIL:], t, ex, ey, vx, vy, wb, wj, angle)


@inlined_kernel
def longest_film_step(ends: Records, memory: Array) -> float:
    """Return the longest step of a run that its films allow [s]; infinite without films that remember."""
    longest = np.inf
    if has_films(memory):
        for k in range(len(ends)):
            if ends[k].kind == REMEMBERING:
                longest = min(longest, longest_step_of(memory[k, OIL:]))
    return longest
