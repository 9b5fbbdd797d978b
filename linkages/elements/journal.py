"""A journal in its bearing with clearance: lubricated, dry, or mixed.

`linkages.elements.worn` and `linkages.elements.film_with_history` are other kinds of journals.
"""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, record_type
from linkages.laws.journal import ContactResults, clearance_force
from linkages.laws.states import Remembered
from linkages.mechanics.planar.contact_motions import OF_JOURNALS, ROUND, JournalMotion
from linkages.mechanics.planar.contacts import ContactKind

RECORD = record_type(
    at="i8",
    oriented="i8",  # 1 if the direction of the bearing matters: its film has grooves or a tilt, or it is worn
)


@inlined_kernel
def action(law: np.record, table: Array, remembered: Remembered, motion: JournalMotion) -> ContactResults:
    """Compute force and couple on the journal, and the state of the contact."""
    ex, ey, vx, vy, wb, wj, angle, _ = motion
    return clearance_force(law, table, ex, ey, vx, vy, wb, wj, remembered, angle)


JOURNAL = ContactKind(name="journal", record=RECORD, inputs=ROUND, action=action, **OF_JOURNALS)
