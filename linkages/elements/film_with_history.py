"""A journal in a bearing whose film remembers its content, in cells that move with the run."""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, Records, inlined_kernel
from linkages.elements.journal import RECORD, action
from linkages.laws.film.film_history import history_force, memory_of
from linkages.laws.film.film_steps import advance_film, longest_step_of, start_film
from linkages.laws.journal import ContactResults
from linkages.laws.states import REMEMBERED
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.contact_motions import OF_JOURNALS, ROUND, JournalMotion, journal_frame, journal_motion
from linkages.mechanics.planar.contacts import ContactKind
from linkages.mechanics.planar.workspace import Workspace


@inlined_kernel
def action_of_cells(
    law: np.record, table: Array, memory: Array, motion: JournalMotion
) -> tuple[ContactResults, float, float]:
    """Compute force and couple on the journal, film content and flow, from the cells in a line of memory."""
    ex, ey, vx, vy, wb, wj, angle, _ = motion
    fx, fy, couple, delta, closing, sliding, content, flow = history_force(
        law, table, memory[REMEMBERED:], ex, ey, vx, vy, wb, wj, angle
    )
    return (fx, fy, couple, 0.0, 0.0, 0.0, delta, closing, sliding, 0.0), content, flow


FILM_WITH_HISTORY = ContactKind(
    name="film_with_history", record=RECORD, inputs=ROUND, action=action, action_of_cells=action_of_cells, **OF_JOURNALS
)


def cells_of(records: Records, tables: Array) -> int:
    """Return the largest number of entries of the films' memories; 0 without films."""
    return max((memory_of(tables[k]) for k in records["at"]), default=0)


@inlined_kernel
def _motion(record: np.record, model: Arrays, w: Workspace) -> JournalMotion:
    end = model.ends[record.at]
    return journal_motion(end, record, model.laws[record.at], journal_frame(end, record, w.pose), w.pose, w.vel)


def start(records: Records, model: Arrays, w: Workspace, memory: Array, t: float, fresh: bool) -> None:
    """Set time and place of the cells, and with ``fresh`` their content at the start of a run."""
    for i in range(len(records)):
        k = records[i].at
        ex, ey, _, _, _, _, angle, _ = _motion(records[i], model, w)
        start_film(model.laws[k], model.tables[k], memory[k, REMEMBERED:], t, ex, ey, angle, fresh)


def advance(records: Records, model: Arrays, w: Workspace, memory: Array, t: float) -> None:
    """Move the content of the cells to time t and this state, and choose the next steps of the films."""
    for i in range(len(records)):
        k = records[i].at
        ex, ey, vx, vy, wb, wj, angle, _ = _motion(records[i], model, w)
        advance_film(model.laws[k], model.tables[k], memory[k, REMEMBERED:], t, ex, ey, vx, vy, wb, wj, angle)


@inlined_kernel
def longest_step(records: Records, memory: Array) -> float:
    """Return the longest step of a run that the cells allow [s]; infinite without cells."""
    longest = np.inf
    for i in range(len(records)):
        longest = min(longest, longest_step_of(memory[records[i].at, REMEMBERED:]))
    return longest
