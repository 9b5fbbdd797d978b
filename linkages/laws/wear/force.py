"""The force pair of a joint of which journal or bearing is worn; see the head of `linkages.laws.wear`."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
from numba import types

from linkages.base.kernel import Array, address, caller, kernel
from linkages.base.kernel.dual import room
from linkages.laws.journal import ContactResults, dry_force, film_action
from linkages.laws.journal_motion import polar
from linkages.laws.mixed import asperity_force, joined
from linkages.laws.parameters import MODELS, RECORD
from linkages.laws.states import REMEMBERED
from linkages.laws.wear.overlap import Place, overlap, round_depth
from linkages.laws.wear.profile import depth_at

_DRY = MODELS["dry"]
_RESULT = types.UniTuple(types.float64, len(get_args(ContactResults)))
_SIGNATURE = _RESULT(RECORD, types.float64[::1], *(8 + REMEMBERED) * (types.float64,))

#: ``call_worn(law.worn, (law, ...))`` with the arguments of `worn_force`: round joints do without compiling it.
call_worn = caller(_RESULT)


def worn_address() -> int:
    """Address of `worn_force`, compiled, in this process."""
    return address(worn_force, _SIGNATURE)


@kernel
def place_of(law: np.record, table: Array, ex: float, ey: float, bearing_angle: float, journal_angle: float) -> Place:
    """Place of a journal in a worn joint.

    Parameters
    ----------
    law : record of `linkages.laws.PARAMETERS`
    table : array
        Ends with the control depths of the bearing's and of the journal's profile [m].
    ex, ey : float
        Eccentricity vector [m].
    bearing_angle, journal_angle : float
        Of the two parts' frames [rad].
    """
    end, c = len(table), law.clearance
    middle = end - law.journal_nodes
    bearing, journal = table[middle - law.bearing_nodes : middle], table[middle:end]
    return Place(ex, ey, bearing_angle, journal_angle, c, law.radius - c, bearing, journal)


@kernel(makes_arrays=True)
def worn_force(
    law: np.record,
    table: Array,
    ex: float,
    ey: float,
    vx: float,
    vy: float,
    omega_b: float,
    omega_j: float,
    bearing_angle: float,
    journal_angle: float,
    latched: float,
    first: float,
    second: float,
    third: float,
) -> ContactResults:
    """Force and couple on the journal, with the angles of the parts' frames.

    The normal load acts along I = grad U; the journal's profile gives its moment on the journal. Friction acts across I
    at the journal's surface. A film is evaluated at the clearance plus the depth of both profiles in the direction of
    the eccentricity: its smallest gap is correct, the effect of the profile's shape on the pressure is neglected.

    The last four arguments are what the contact remembers, see `linkages.laws.states`.

    Returns
    -------
    fx, fy, couple, rates (3), penetration, closing, sliding, load : float
        As `linkages.laws.journal.clearance_force`.
    """
    place = place_of(law, table, ex, ey, bearing_angle, journal_angle)
    found = overlap(place, room(ex, 0), room(ex, 0))
    size = math.hypot(found.ix, found.iy)
    depth, gain, nx, ny, lever = found.peak, 1.0, found.peak_x, found.peak_y, found.peak_turn
    if found.energy > 0.0 and size > 0.0:
        depth, slope = round_depth(found.energy, place.clearance, place.journal_radius)
        gain, nx, ny, lever = size / slope, found.ix / size, found.iy / size, found.turn / size
    else:
        depth = min(depth, 0.0)
        length = math.hypot(nx, ny)
        nx, ny = nx / length, ny / length
    # rates relative to the bearing: a common rotation of both parts has no effect
    wx, wy, spin = vx + omega_b * ey, vy - omega_b * ex, omega_j - omega_b
    speed = wx * nx + wy * ny + lever * spin
    closing = wx * found.peak_x + wy * found.peak_y + found.peak_turn * spin
    sliding = wy * nx - wx * ny + place.journal_radius * spin
    fx, fy, couple, extra = 0.0, 0.0, 0.0, 0.0
    if law.model != _DRY:
        e, rx, ry, v_n, v_t = polar(ex, ey, vx, vy)
        toward = math.atan2(ey, ex)
        c = law.clearance + depth_at(place.bearing, toward - bearing_angle)[0]
        c += depth_at(place.journal, toward - journal_angle)[0]
        alpha = toward - bearing_angle - law.groove_angle
        f_n, f_t, couple = film_action(law, table, c, e, v_n, v_t, omega_b, omega_j, alpha)
        fx, fy = f_n * rx - f_t * ry, f_n * ry + f_t * rx
        if law.transition == 0.0:
            extra = asperity_force(e / c, c, law.radius, law.length, law.roughness, law.asperity_pressure)
    remembered = latched, first, second, third
    load, drag, one, two, three = dry_force(law, depth, speed, sliding, remembered, extra, gain)
    dry = -load * nx + drag * ny, -load * ny - drag * nx, -load * lever - place.journal_radius * drag
    fx, fy, couple, load = joined(law, (fx, fy, couple), dry, found.peak, load)
    return fx, fy, couple, one, two, three, found.peak, closing, sliding, load
