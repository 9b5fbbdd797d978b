"""What contacts remember: a line of memory for each.

A line has, in this order,

- the latched states, `LATCHED`: the speed of approach, taken when bodies come into contact;
- continuous states of the laws, from `FIRST_STATE` on, which are part of the state vector of a run;
- cells, from `REMEMBERED` on: the content of a film that remembers, which moves from step to step.

A restart needs the latched states and the cells; the state vector has the others.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, Records, inlined_kernel, kernel, lazy_kernel
from linkages.laws.contact.contact_forces import GRAZING
from linkages.laws.film.film_history import STEP, memory_of, recorded_entries
from linkages.laws.film.film_steps import advance_film, longest_step_of, start_film
from linkages.laws.states import LATCHED, LATCHED_NAMES, REMEMBERED
from linkages.mechanics.planar.contacts import CLOSING, PENETRATION, RESULT_PLACES, contact_motion, has_cells
from linkages.mechanics.planar.record_types import REMEMBERING

_APPROACH = LATCHED_NAMES.index("approach")  # place of the speed of approach in a line of memory
_LATCHED_QUANTITIES = (CLOSING,)
#: Places of the quantities that are latched among the results of a contact.
LATCHED_RESULTS = tuple(RESULT_PLACES.index(quantity) for quantity in _LATCHED_QUANTITIES)

_LANDING = 1e-10  # accuracy to which the start and end of a contact are located, in parts of the clearance
_ROUNDING = 4e-16  # lower limit of that accuracy, in parts of the linkage's length


@kernel
def fill_landing(laws: Records, size: float, out: Array) -> None:
    """Fill ``out`` (nc,) with the accuracies to which the start and end of each contact are located [m; stop: rad]."""
    for k in range(len(laws)):
        out[k] = max(_LANDING * laws[k].clearance, _ROUNDING * size)


def make_memory(ends: Records, tables: Array) -> Array:
    """Make the memory of contacts, (nc, `REMEMBERED`), or wider if a film remembers; all zero."""
    films = np.flatnonzero(ends["kind"] == REMEMBERING)
    return np.zeros((len(ends), REMEMBERED + max((memory_of(tables[k]) for k in films), default=0)))


@inlined_kernel
def latch(memory: Array, contact: Array) -> None:
    """Latch what a contact remembers of its start, from its quantities there (WIDTH,)."""
    for i in range(LATCHED):
        memory[i] = contact[_LATCHED_QUANTITIES[i]]


@kernel
def latch_at_start(memory: Array, contact: Array, landing: float) -> None:
    """Latch what a contact remembers of its start at the start of a run.

    A contact begins at the start if the bodies touch and do not separate, or if they overlap and approach faster than
    `GRAZING`. Bodies that overlap otherwise were in contact before: the speed at which that contact began is unknown,
    and an infinite speed gives a contact without damping. So does it where no contact begins. `landing` is the
    contact's accuracy, see `fill_landing`.
    """
    delta, closing = contact[PENETRATION], contact[CLOSING]
    least = GRAZING if delta > landing else -GRAZING
    memory[_APPROACH] = max(closing, 0.0) if delta >= -landing and closing > least else np.inf


@inlined_kernel
def any_cells(memory: Array) -> bool:
    """Whether contacts with this memory can have cells."""
    return memory.shape[1] > REMEMBERED


@inlined_kernel
def _recorded_cells(memory: Array) -> tuple[int, int]:
    """Return the first of the entries of a contact's cells, and their number, that its next step depends on."""
    return REMEMBERED + STEP, recorded_entries(memory.shape[1] - REMEMBERED)


@kernel
def recorded(memory: Array) -> int:
    """Return the number of entries of `record_memory`."""
    return len(memory) * (LATCHED + _recorded_cells(memory)[1])


@kernel
def record_memory(memory: Array, row: Array) -> None:
    """Fill ``row`` with the memory for the step that follows: latched states of all contacts, then cells of each."""
    nc, (first, cells) = len(memory), _recorded_cells(memory)
    for c in range(nc):
        for i in range(LATCHED):
            row[c * LATCHED + i] = memory[c, i]
        for i in range(cells):
            row[nc * LATCHED + c * cells + i] = memory[c, first + i]


@kernel
def restore_memory(memory: Array, row: Array) -> None:
    """Restore the memory from what `record_memory` filled."""
    nc, (first, cells) = len(memory), _recorded_cells(memory)
    for c in range(nc):
        restore_latched(memory, row, c)
        for i in range(cells):
            memory[c, first + i] = row[nc * LATCHED + c * cells + i]


@inlined_kernel
def restore_latched(memory: Array, row: Array, k: int) -> None:
    """Restore the latched states of contact k alone."""
    for i in range(LATCHED):
        memory[k, i] = row[k * LATCHED + i]


@inlined_kernel
def is_latched_anew(row: Array, before: Array, k: int) -> bool:
    """Whether contact k began between two records of the memory."""
    anew = False
    for i in range(k * LATCHED, (k + 1) * LATCHED):
        anew = anew or row[i] != before[i]
    return anew


@lazy_kernel
def start_cells(
    ends: Records, laws: Records, tables: Array, memory: Array, t: float, pose: Array, vel: Array, fresh: bool
) -> None:
    """Set time and place of the cells, and with ``fresh`` their content at the start of a run."""
    for k in range(len(ends)):
        if has_cells(ends[k]):
            ex, ey, _, _, _, _, angle, _ = contact_motion(ends[k], pose, vel)[0]
            start_film(laws[k], tables[k], memory[k, REMEMBERED:], t, ex, ey, angle, fresh)


@lazy_kernel
def advance_cells(
    ends: Records, laws: Records, tables: Array, memory: Array, t: float, pose: Array, vel: Array
) -> None:
    """Move the content of the cells to time t and these states, and choose the next steps of their films."""
    for k in range(len(ends)):
        if has_cells(ends[k]):
            ex, ey, vx, vy, wb, wj, angle, _ = contact_motion(ends[k], pose, vel)[0]
            advance_film(laws[k], tables[k], memory[k, REMEMBERED:], t, ex, ey, vx, vy, wb, wj, angle)


@inlined_kernel
def longest_step(ends: Records, memory: Array) -> float:
    """Return the longest step of a run that the cells allow [s]; infinite without cells."""
    longest = np.inf
    if any_cells(memory):
        for k in range(len(ends)):
            if has_cells(ends[k]):
                longest = min(longest, longest_step_of(memory[k, REMEMBERED:]))
    return longest
