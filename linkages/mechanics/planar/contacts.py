"""Contacts in a tree: from body states to force pairs, by the laws.

A kind of contact (`ContactKind`) is a set of inlined kernels. The loops over its contacts contain them: `acting` and
`knowing` here, the derivatives in `linkages.mechanics.planar.contact_partials`, `.contact_rates`. A machine compiles
the loops of its own kinds, see `linkages.elements.contact_kinds`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from linkages.base.kernel import Array, Records, inlined_kernel
from linkages.laws.journal import ContactResults
from linkages.laws.states import STATES, remembered_of
from linkages.mechanics.planar.workspace import Workspace

if TYPE_CHECKING:
    from linkages.mechanics.planar.arrays import Arrays
    from linkages.mechanics.planar.contact_motions import Inputs

#: Quantities of each contact at a state: eccentricity e [m], force [N] and couple [N m] on the journal, penetration
#: [m], its rate and the sliding speed of the journal's surface [m/s], normal load of the contact without a film's [N].
#: For a point at a wall, e points from the marked point of the wall to this point, where the force acts; for the
#: corner of a block, the wall's point is on the middle line of the slot. For a coordinate at its limit, penetration,
#: its rate and the load are angular, with a base radius along the line of action, and e is zero.
CLEARANCE_OUTPUTS = ("ex", "ey", "fx", "fy", "couple", "penetration", "closing", "sliding", "load")
#: After these, of a film that remembers, and zero of others: film content [1], volume flow out of both ends [m3/s].
#: Then the rates of the contact's states.
WIDTH = len(CLEARANCE_OUTPUTS) + 2 + STATES
EX, EY, FX, FY, COUPLE, PENETRATION, CLOSING, SLIDING, LOAD, CONTENT, FLOW, RATES = range(WIDTH - STATES + 1)

#: Results of a contact's law: its action (3), rates of its states, penetration, its rate, sliding speed, load. The
#: action is force (2) and couple of a journal; load, friction and 0 of a point or a coordinate.
FIRST_RATE = 3
RESULTS = len(get_args(ContactResults))
#: Places of the results after the action in a line of `CLEARANCE_OUTPUTS`, flow and rates.
RESULT_PLACES = (FX, FY, COUPLE, *range(RATES, WIDTH), PENETRATION, CLOSING, SLIDING, LOAD)


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactKind:
    """A kind of contact: its record, and inlined kernels for numbers and duals.

    Attributes
    ----------
    name : str
        Field of its records in the arrays of a machine.
    record : dtype
        Its own numbers, and ``at``, the index of the contact.
    inputs : Inputs
        What its law depends on, its motion.
    frame : kernel
        ``frame(end, record, pose)``: the eccentricity ex, ey first, then what `force` and `add` need.
    motion : kernel
        ``motion(end, record, law, frame, pose, vel)``, the inputs.
    action : kernel
        ``action(law, table, remembered, motion)``, the results.
    action_of_cells : kernel, optional
        ``action_of_cells(law, table, cells, motion)`` of a kind with cells: results, content and flow. They are
        differentiated by differences, for Newton's method alone.
    force : kernel
        ``force(record, frame, results)``: force (2) and couple on the inner body.
    carried : kernel
        ``carried(record, frame, contact)``: the action (3), from a line of `CLEARANCE_OUTPUTS`.
    add : kernel
        ``add(wrench, end, record, pose, frame, fx, fy, couple)`` adds the pair to the bodies' wrenches.
    power : kernel
        ``power(end, record, frame, pose, vel, fx, fy, couple)``, which the pair delivers [W].
    """

    name: str
    record: np.dtype[Any]
    inputs: Inputs
    frame: Callable[..., Any]
    motion: Callable[..., Any]
    action: Callable[..., ContactResults]
    action_of_cells: Callable[..., tuple[ContactResults, float, float]] | None = None
    force: Callable[..., tuple[float, float, float]]
    carried: Callable[..., tuple[float, float, float]]
    add: Callable[..., None]
    power: Callable[..., float]


def whole_action(kind: ContactKind) -> Any:
    """Make the kernel of a kind's results, content and flow, from a line of memory."""
    action, of_cells = kind.action, kind.action_of_cells
    if of_cells is not None:
        return of_cells

    @inlined_kernel
    def whole(law: np.record, table: Array, memory: Array, motion: Any) -> tuple[ContactResults, float, float]:
        return action(law, table, remembered_of(memory), motion), 0.0, 0.0

    return whole


def acting(kind: ContactKind) -> Callable[..., None]:
    """Make the loop that adds the force pairs of contacts to the bodies' wrenches, and fills their lines of ``out``."""
    frame_of, motion_of, act, force_of, add = kind.frame, kind.motion, whole_action(kind), kind.force, kind.add

    def loop(records: Records, model: Arrays, w: Workspace, memory: Array, out: Array) -> None:
        ends, laws, tables, pose, vel, wrench = model.ends, model.laws, model.tables, w.pose, w.vel, w.wrench
        for i in range(len(records)):
            record = records[i]
            k = max(record.at, 0)  # so that no index is tested for its sign
            end, law = ends[k], laws[k]
            frame = frame_of(end, record, pose)
            motion = motion_of(end, record, law, frame, pose, vel)
            found, content, flow = act(law, tables[k], memory[k], motion)
            _, _, _, one, two, three, delta, closing, sliding, load = found
            fx, fy, couple = force_of(record, frame, found)
            add(wrench, end, record, pose, frame, fx, fy, couple)
            out[k, EX], out[k, EY], out[k, FX], out[k, FY], out[k, COUPLE] = frame[0], frame[1], fx, fy, couple
            out[k, PENETRATION], out[k, CLOSING], out[k, SLIDING], out[k, LOAD] = delta, closing, sliding, load
            out[k, CONTENT], out[k, FLOW] = content, flow
            out[k, RATES], out[k, RATES + 1], out[k, RATES + 2] = one, two, three

    return loop


def knowing(kind: ContactKind) -> Callable[..., None]:
    """Make the kernel that adds the force pair of a contact whose `CLEARANCE_OUTPUTS` (nc, WIDTH) are known."""
    frame_of, add = kind.frame, kind.add

    def one(record: np.record, ends: Records, contacts: Array, pose: Array, wrench: Array) -> None:
        k = record.at
        end, frame = ends[k], frame_of(ends[k], record, pose)
        add(wrench, end, record, pose, frame, contacts[k, FX], contacts[k, FY], contacts[k, COUPLE])

    return one


def powering(kind: ContactKind) -> Callable[..., float]:
    """Make the kernel of the power that a contact's known force pair delivers [W]."""
    frame_of, power_of = kind.frame, kind.power

    def one(record: np.record, ends: Records, contacts: Array, pose: Array, vel: Array) -> float:
        k = record.at
        end, frame = ends[k], frame_of(ends[k], record, pose)
        return power_of(end, record, frame, pose, vel, contacts[k, FX], contacts[k, FY], contacts[k, COUPLE])

    return one
