"""Partial derivatives of a contact's force with respect to its motion."""

from __future__ import annotations

import math

import numpy as np

from linkages.kernel import Array, clear, kernel
from linkages.planar.contacts import Motion, contact_action
from linkages.planar.record_types import CORNER, JOURNAL, STOP

#: Inputs: e (2), its rate (2), angular velocities (2), normal into the wall or worn parts' angles (2), bristle state.
INPUTS = 9
#: Outputs: force on the inner body, couple on it, rate of the bristles.
FORCE_X, FORCE_Y, COUPLE, BRISTLE_RATE = range(4)
OUTPUTS = 4

_STEP = 6e-6  # in parts of an input's scale: the cube root of the rounding error minimises the error of the differences
_NEAR = 1e-3  # lower limit of the gap that scales a displacement, in parts of the clearance
_SLOW = 1e-9  # smallest speed that scales a velocity, clearances and lengths of 1 m per second


@kernel
def contact_partials(
    end: np.record, law: np.record, table: Array, approach: float, bristle: float, motion: Motion, out: Array
) -> None:
    """Fill ``out`` (OUTPUTS, INPUTS) with the partial derivatives of `contact_action`.

    Central differences, with a step for each input. A law is a smooth function of a few well-scaled inputs, so the
    differences are accurate to 1e-7 of its largest change (measured: films 5e-8, contact 6e-8, both together 1.4e-7),
    and laws need not supply derivatives. The rest of the Jacobian is exact.
    """
    ex, ey, vx, vy, wb, wj, nx, ny = motion
    corner = end.kind == CORNER
    c = law.clearance
    distance = math.hypot(ex, ey)
    open_by = c + end.half - ex * nx - ey * ny if corner else c - distance
    if end.kind == STOP:
        open_by = c + end.half - end.nx * (ny - nx)
    gap = max(abs(open_by), _NEAR * c)
    speed = math.hypot(vx, vy) + c * (abs(wb) + abs(wj)) + _SLOW
    lever = max(law.radius, c)
    spin = abs(wb) + abs(wj) + speed / lever
    turn = gap / (distance if corner else lever)  # by the gap, seen from the corner or on a worn surface
    if end.kind == STOP:
        turn = gap
    scales = (gap, gap, speed, speed, spin, spin, turn, turn, law.bristle_scale)
    clear(out)
    for i in range(INPUTS):
        if 6 <= i < 8 and end.kind == JOURNAL:
            continue
        if i == 8 and law.bristle_scale == 0.0:  # no bristles
            continue
        h = _STEP * scales[i]
        for side in (1.0, -1.0):
            s = side * h
            moved = (
                ex + (s if i == 0 else 0.0),
                ey + (s if i == 1 else 0.0),
                vx + (s if i == 2 else 0.0),
                vy + (s if i == 3 else 0.0),
                wb + (s if i == 4 else 0.0),
                wj + (s if i == 5 else 0.0),
                nx + (s if i == 6 else 0.0),
                ny + (s if i == 7 else 0.0),
            )
            z = bristle + (s if i == 8 else 0.0)
            fx, fy, couple, rate, _, _, _, _ = contact_action(end, law, table, approach, z, moved)
            out[FORCE_X, i] += side * fx
            out[FORCE_Y, i] += side * fy
            out[COUPLE, i] += side * couple
            out[BRISTLE_RATE, i] += side * rate
        for k in range(OUTPUTS):
            out[k, i] /= 2.0 * h
