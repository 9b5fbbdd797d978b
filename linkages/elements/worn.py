"""A journal in its bearing, of which at least one is worn: their shapes turn with the bodies."""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, inlined_kernel
from linkages.elements.journal import RECORD
from linkages.laws.journal import ContactResults
from linkages.laws.states import Remembered
from linkages.laws.wear.force import call_worn
from linkages.mechanics.planar.contact_motions import OF_JOURNALS, SHAPED, JournalMotion
from linkages.mechanics.planar.contacts import ContactKind


@inlined_kernel
def action(law: np.record, table: Array, remembered: Remembered, motion: JournalMotion) -> ContactResults:
    """Compute force and couple on the journal, and the state of the contact."""
    ex, ey, vx, vy, wb, wj, bearing, journal = motion
    latched, a, b, c = remembered
    return call_worn(law.worn, (law, table, ex, ey, vx, vy, wb, wj, bearing, journal, latched, a, b, c))


WORN = ContactKind(name="worn", record=RECORD, inputs=SHAPED, action=action, **OF_JOURNALS)
