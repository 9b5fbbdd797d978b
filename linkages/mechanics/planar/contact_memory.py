"""What contacts remember: a line of memory for each.

A line has, in this order,

- the latched states, `LATCHED`: the speed of approach, taken when bodies come into contact;
- continuous states of the laws, from `FIRST_STATE` on, which are part of the state vector of a run;
- cells, from `REMEMBERED` on: the content of a film that remembers, which moves from step to step.

A restart needs the latched states and the cells; the state vector has the others.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, Records, inlined_kernel, kernel
from linkages.laws.contact.contact_forces import GRAZING
from linkages.laws.film.film_history import STEP, recorded_entries
from linkages.laws.states import BEGAN, LATCHED, REMEMBERED
from linkages.mechanics.planar.contacts import CLOSING, PENETRATION, RESULT_PLACES

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


@inlined_kernel
def latch(memory: Array, contact: Array) -> None:
    """Latch a contact's memory of its start, from its quantities there (WIDTH,)."""
    for i in range(LATCHED):
        memory[i] = contact[_LATCHED_QUANTITIES[i]]


@kernel
def latch_at_start(memory: Array, contact: Array, landing: float) -> None:
    """Latch a contact's memory of its start at the start of a run.

    A contact begins at the start if the bodies touch and do not separate, or if they overlap and approach faster than
    `GRAZING`. Bodies that overlap otherwise were in contact before: the speed at which that contact began is unknown,
    and an infinite speed gives a contact without damping. So does it where no contact begins. `landing` is the
    contact's accuracy, see `fill_landing`.
    """
    delta, closing = contact[PENETRATION], contact[CLOSING]
    least = GRAZING if delta > landing else -GRAZING
    memory[BEGAN] = max(closing, 0.0) if delta >= -landing and closing > least else np.inf


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
