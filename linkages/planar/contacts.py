"""Clearance joints in a tree: from body states to force pairs, by the laws."""

from __future__ import annotations

import numpy as np

from linkages.kernel import Array, Indices, Records, inlined_kernel, kernel
from linkages.laws.contact.contact_forces import GRAZING
from linkages.laws.journal import clearance_force, dry_force
from linkages.laws.wear.force import call_worn
from linkages.planar.bodies import Bodies, new_motion, new_pose
from linkages.planar.dynamics import generalized_force
from linkages.planar.kinematics import body_states
from linkages.planar.markers import Arms, add_pair, both_at_b, gap, gap_rate, turned
from linkages.planar.record_types import CORNER, STOP, WORN

#: What is known of each contact at a state: e [m], force on the journal [N], couple on it [N m], penetration [m],
#: its rate and the sliding speed of the journal's surface [m/s], normal load of the contact without that of a film [N],
#: rate of LuGre's bristles [m/s]. For the corner of a block e points from the slot's marked point, on its middle line,
#: to the corner, and the force acts at the corner. Of a stop penetration, its rate and the load are those of turning.
CLEARANCE_OUTPUTS = ("ex", "ey", "fx", "fy", "couple", "penetration", "closing", "sliding", "load", "bristle_rate")
WIDTH = len(CLEARANCE_OUTPUTS)

#: Motion of a contact, see `contact_motion`.
Motion = tuple[float, float, float, float, float, float, float, float]

#: What each joint remembers: the speed at which its contact began [m/s], LuGre's bristle state [m].
MEMORY = ("approach", "bristle")

_LANDING = 1e-10  # how close to touching the start and the end of a contact are located, in parts of the clearance
_ROUNDING = 4e-16  # the same in parts of the linkage's length


def landing(laws: Records, size: float) -> Array:
    """Return how close to touching the start and the end of each contact are located, (nc,) [m; stop: rad]."""
    return np.maximum(_LANDING * laws["clearance"], _ROUNDING * size)


@kernel
def approach_at_start(delta: float, closing: float, landing: float) -> float:
    """Return the approach speed of a contact at the start of a run; infinite where no contact begins there.

    A contact begins at the start if the bodies touch and do not part, or overlap and close in faster than `GRAZING`.
    Bodies that overlap otherwise were in contact before: the speed at which that contact began is not known, and an
    infinite one leaves it without damping.

    Parameters
    ----------
    delta, closing : float
        Penetration [m] and its rate [m/s] at the start.
    landing : float
        Of the contact, from `landing`.
    """
    least = GRAZING if delta > landing else -GRAZING
    return max(closing, 0.0) if delta >= -landing and closing > least else np.inf


@kernel
def clearance_wrenches(
    ends: Records, laws: Records, tables: Array, memory: Array, pose: Array, vel: Array, wrench: Array, out: Array
) -> None:
    """Add the force pair of every clearance joint to the bodies' wrenches.

    Parameters
    ----------
    ends : array of ENDS
    laws : array of `linkages.laws.PARAMETERS`
    tables : (nj, nt) array
        Map of each joint's finite film; of a worn joint, at the line's end, its profiles, see
        `linkages.laws.wear.force.place_of`.
    memory : (nj, 2) array
        `MEMORY` of each joint.
    pose, vel : (nb, 5), (nb, 3) arrays
    wrench : (nb, 3) array
        Added to.
    out : (nj, WIDTH) array
        Filled with `CLEARANCE_OUTPUTS`.
    """
    for k in range(len(ends)):
        end = ends[k]
        motion, arms = contact_motion(end, pose, vel)
        ex, ey = motion[0], motion[1]
        fx, fy, couple, rate, delta, closing, sliding, load = contact_action(
            end, laws[k], tables[k], memory[k, 0], memory[k, 1], motion
        )
        add_contact(wrench, end, ex, ey, arms, fx, fy, couple)
        out[k, 0], out[k, 1], out[k, 2], out[k, 3], out[k, 4] = ex, ey, fx, fy, couple
        out[k, 5], out[k, 6], out[k, 7], out[k, 8], out[k, 9] = delta, closing, sliding, load, rate


@inlined_kernel
def add_contact(
    wrench: Array, end: np.record, ex: float, ey: float, arms: Arms, fx: float, fy: float, couple: float
) -> None:
    """Add a contact's force pair to the bodies' wrenches: both forces act at the journal's marker."""
    add_pair(wrench, end.bearing, end.journal, both_at_b(arms, ex, ey), fx, fy)
    wrench[end.journal.body, 0] += couple
    wrench[end.bearing.body, 0] -= couple


@inlined_kernel
def contact_motion(end: np.record, pose: Array, vel: Array) -> tuple[Motion, Arms]:
    """Motion of a contact's inner end relative to its outer end, and where they are.

    Returns
    -------
    motion : tuple
        Vector e between the ends, its rate, angular velocities of outer and inner body; corner: normal into the wall;
        worn, stop: angles of outer and inner body.
    arms : tuple
        From the origin of the outer body's frame to its end, and of the inner's.
    """
    ex, ey, arms = gap(pose, end.bearing, end.journal)
    vx, vy = gap_rate(vel, end.bearing, end.journal, arms)
    nx, ny = 0.0, 0.0
    if end.kind == CORNER:
        nx, ny = turned(pose, end.bearing.body, end.nx, end.ny)
    elif end.kind == WORN or end.kind == STOP:
        nx, ny = pose[end.bearing.body, 2], pose[end.journal.body, 2]
    return (ex, ey, vx, vy, vel[end.bearing.body, 0], vel[end.journal.body, 0], nx, ny), arms


@kernel
def contact_action(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: Motion
) -> tuple[float, float, float, float, float, float, float, float]:
    """Force and couple on the inner body, rate of the bristles; penetration, its rate, sliding speed; normal load.

    `motion` is that of `contact_motion`.
    """
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    if end.kind == CORNER:
        vx, vy = vx + wb * ey, vy - wb * ex  # relative to the wall's own material
        delta = ex * nx + ey * ny - end.half - law.clearance
        closing, sliding = vx * nx + vy * ny, vy * nx - vx * ny
        load, drag, rate = dry_force(law, delta, closing, sliding, approach, bristle)
        return -load * nx + drag * ny, -load * ny - drag * nx, 0.0, rate, delta, closing, sliding, load
    if end.kind == STOP:
        delta, closing = end.nx * (ny - nx) - end.half - law.clearance, end.nx * (wj - wb)
        load, _, _ = dry_force(law, delta, closing, 0.0, approach, 0.0)
        return 0.0, 0.0, -end.nx * load, 0.0, delta, closing, 0.0, load
    if end.kind == WORN:
        return call_worn(law.worn, (law, table, ex, ey, vx, vy, wb, wj, nx, ny, approach, bristle))
    return clearance_force(law, table, ex, ey, vx, vy, wb, wj, approach, bristle)


@kernel
def clearance_forces(
    bodies: Bodies,
    ends: Records,
    laws: Records,
    tables: Array,
    memory: Array,
    state: Array,
    positions: Indices,
    rates: Indices,
    into: Indices,
    size: int,
) -> Array:
    """Generalised force of all clearance joints, from and to vectors that are ordered otherwise.

    Parameters
    ----------
    ends, laws, tables, memory
        As for `clearance_wrenches`.
    state : (nx,) array
        Holds coordinate i at ``positions[i]`` and its rate at ``rates[i]``.
    into : (n,) array of int
        Where coordinate i stands in the result's first `size` entries.

    Returns
    -------
    (size + WIDTH nj,) array
        Generalised forces, then `CLEARANCE_OUTPUTS` of each joint.
    """
    nj = len(ends)
    pose, vel, wrench, tau = new_pose(bodies), new_motion(bodies), new_motion(bodies), np.zeros(len(into))
    body_states(bodies, state[positions], state[rates], pose, vel)
    result = np.zeros(size + WIDTH * nj)
    clearance_wrenches(ends, laws, tables, memory, pose, vel, wrench, result[size:].reshape(nj, WIDTH))
    generalized_force(bodies, pose, wrench, tau)
    result[into] = tau
    return result
