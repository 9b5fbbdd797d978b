"""The film with a history in a machine: its content is a state, and the force a function of state, place and velocity.

Each cell of the bearing's surface has a missing volume D >= 0, the part of its gap W without oil. Its rate is

    dD/dt = m - D/tau,    m = (W/tau + dW/dt) d,    p >= 0,  0 <= d <= 1,  p d = 0,
    div(u (1 - d) h - h^3/12 grad p) + dW/dt + D/tau - m = 0,

the balance of volume over a look ahead by the film step tau: a cell fills in the time tau at the earliest, and
pressure builds up where it would be full then. This is the implicit Euler step over the time tau of
`linkages.laws.film.surface.transient`, as a rate. So the force is a continuous function of D, the place and the
velocity at any instant, which an integrator of any order can use, and D changes by an explicit step h <= tau:

    V(t + h) = (1 - h/tau) V(t) + (h/tau) V_implicit,    V = W - D the oil.

The oil thus stays within 0 and W, and its balance holds to round-off in each step. The error is of first order in tau.

Passivity: in full cells D >= 0 and the flow that arrives is at most the one of a full film. So the sum of
p (div(u h) + dW/dt) over the cells is at most the one of p div(h^3/12 grad p), which is not positive: nor is the power
of the force in the frame of the mean surface velocity, for any content. A supply pressure adds its own power.

Units: lengths of the film in the clearance c, places in R, pressure in mu (R/c)^2 [1/s], volumes in c R^2; the frame is
the bearing's. The mesh is not graded for an eccentricity.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.kernel.by_reference import reference
from linkages.laws.film.closed_form import EPS_MAX
from linkages.laws.film.film_map import GROOVED_LIMIT
from linkages.laws.film.history_cells import (
    ALONG,
    AROUND,
    CONTENT,
    MISSING,
    PLACE_X,
    PLACE_Y,
    SIDES,
    STEP,
    TIME,
    gap_volume,
    groove_share,
    length_of,
    line_of,
)
from linkages.laws.film.history_solver import Sheet, fill_flows, integrate_thickness, new_sheet, settle
from linkages.laws.parameters import SHEAR

#: Largest eccentricity ratio of these films; the coarse mesh does not resolve thinner ones.
LARGEST = GROOVED_LIMIT

_NO_SHEAR = SHEAR["none"]
_LEAST = 1e-6  # part of a gap that stays where it would close within the film step: there is no cavity then


@kernel
def _solve(
    table: Array, oil: Array, x: float, y: float, vx: float, vy: float, spin: float, supply: float, sheet: Sheet
) -> None:
    """Solve the film at a place and velocity; leave the solution in the memory ``oil``, behind the missing volumes."""
    n, m = sheet.gain.shape
    step, first = table[STEP], MISSING + n * m
    integrate_thickness(table, x, y, sheet.thickness)
    fill_flows(table, 0.5 * spin, sheet)
    for i in range(n):
        at = line_of(table, i)
        for j in range(m):
            growth = -length_of(table, j) * (vx * table[at + 1] + vy * table[at + 2])
            rate = gap_volume(table, i, j, x, y) / step
            sheet.gain[i, j] = growth + oil[MISSING + i * m + j] / step
            sheet.most[i, j] = max(rate + growth, _LEAST * rate)
    settle(table, sheet, supply, oil[first : first + n * m])


@kernel
def solve_history(
    table: Array, oil: Array, x: float, y: float, vx: float, vy: float, spin: float, supply: float
) -> tuple[float, float, float, float]:
    """Solve the film with history.

    Parameters
    ----------
    table : array of float
        From `history_table`.
    oil : (`memory_of`,) array
        Its memory; the missing volumes stay as they are.
    x, y, vx, vy : float
        Eccentricity in the bearing's frame, over the clearance, and its rate there [1/s].
    spin : float
        Angular velocity of the journal relative to the bearing [rad/s].
    supply : float
        Largest pressure of the grooves [1/s].

    Returns
    -------
    fx, fy : float
        Force on the journal in units of mu R^4/c^2, in the bearing's frame.
    shear : float
        Integral of content/h over the surface: torque of a relative speed of 1 in units of mu R^4/c.
    flow : float
        Volume flow out of both ends in units of c R^2.
    """
    sheet = new_sheet(table)
    _solve(table, oil, x, y, vx, vy, spin, supply, reference(sheet))
    carried, along = sheet.carried, sheet.along
    n, m = carried.shape
    first = MISSING + n * m
    fx, fy, shear, flow = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        at, last = line_of(table, i), (i - 1) % n
        for j in range(m):
            z, area = oil[first + i * m + j], length_of(table, j)
            p = max(z, 0.0)
            fx, fy = fx - p * area * table[at + 1], fy - p * area * table[at + 2]
            content = 1.0
            if z < 0.0:  # at the middle of the cell: the mean of what its faces carry
                inflow, outflow = abs(carried[last, j]), abs(carried[i, j])
                before, after = oil[first + last * m + j], oil[first + (i + 1) % n * m + j]
                own, other = min(z, 0.0), min(before if carried[i, j] >= 0.0 else after, 0.0)
                up, down = (inflow, outflow) if carried[i, j] >= 0.0 else (outflow, inflow)
                content += (up * other + down * own) / (up + down) if up + down > 0.0 else own
            shear += content * area * sheet.thickness[i, 4]
        flow += along[i, m] * max(oil[first + i * m + m - 1], 0.0) + along[i, 0] * max(oil[first + i * m], 0.0)
    sides = table[SIDES]
    return sides * fx, sides * fy, sides * shear, sides * flow


@kernel
def advance_history(table: Array, oil: Array, t: float, x: float, y: float, spin: float, supply: float) -> None:
    """Move the missing volumes from the last step to time t, at which the journal is at a place.

    Arguments as for `solve_history`. The volumes of the gap change by their true amounts: the oil is balanced.
    """
    sheet = new_sheet(table)
    n, m = sheet.most.shape
    h, first = t - oil[TIME], MISSING + n * m
    vx, vy = (x - oil[PLACE_X]) / h, (y - oil[PLACE_Y]) / h
    _solve(table, oil, x, y, vx, vy, spin, supply, reference(sheet))
    kept = 1.0 - h / table[STEP]
    for i in range(n):
        for j in range(m):
            k = i * m + j
            deficit = max(-oil[first + k], 0.0)
            oil[MISSING + k] = kept * oil[MISSING + k] + h * sheet.most[i, j] * deficit
    oil[TIME], oil[PLACE_X], oil[PLACE_Y] = t, x, y


@kernel
def start_history(table: Array, oil: Array, t: float, x: float, y: float, fresh: bool) -> None:
    """Set time and place of a film's last step, and with ``fresh`` its content to the one at the start of a run."""
    n, m = int(table[AROUND]), int(table[ALONG])
    for i in range(n if fresh else 0):
        for j in range(m):
            missing = (1.0 - table[CONTENT]) * gap_volume(table, i, j, x, y)
            oil[MISSING + i * m + j] = missing if groove_share(table, i, j) < 0.0 else 0.0
            oil[MISSING + n * m + i * m + j] = 0.0
    oil[TIME], oil[PLACE_X], oil[PLACE_Y] = t, x, y


@kernel
def mean_content(table: Array, oil: Array, x: float, y: float) -> float:
    """Return the share of the gap outside of the grooves that is filled with oil."""
    n, m = int(table[AROUND]), int(table[ALONG])
    gap, missing = 0.0, 0.0
    for i in range(n):
        for j in range(m):
            if groove_share(table, i, j) < 0.0:
                gap += gap_volume(table, i, j, x, y)
                missing += oil[MISSING + i * m + j]
    return 1.0 - missing / gap


#: Place and rate of the journal in the bearing's frame [1, 1/s], cosine and sine of the bearing's angle.
Seen = tuple[float, float, float, float, float, float]


@inlined_kernel
def in_bearing(joint: np.record, ex: float, ey: float, vx: float, vy: float, omega_b: float, angle: float) -> Seen:
    """Turn the motion of a journal into the bearing's frame; arguments of `linkages.laws.journal.clearance_force`."""
    c, s, unit = math.cos(angle), math.sin(angle), 1.0 / joint.clearance
    far = math.sqrt(ex * ex + ey * ey) * unit
    inside = unit * (EPS_MAX / far if far > EPS_MAX else 1.0)
    ux, uy = unit * (vx + omega_b * ey), unit * (vy - omega_b * ex)
    return inside * (c * ex + s * ey), inside * (c * ey - s * ex), c * ux + s * uy, c * uy - s * ux, c, s


@inlined_kernel
def _supply(joint: np.record) -> float:
    """Return the largest pressure of the grooves in units of mu (R/c)^2."""
    return joint.supply_pressure * (joint.clearance / joint.radius) ** 2 / joint.viscosity


@kernel
def film_with_history(
    joint: np.record, table: Array, oil: Array, ex: float, ey: float, vx: float, vy: float, omega_b: float,
    omega_j: float, angle: float,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """Force (2) and couple on the journal, film content, flow out of both ends [m3/s].

    Parameters
    ----------
    joint : record of `linkages.laws.PARAMETERS`
    table, oil : arrays of float
        See `solve_history`.
    ex, ey, vx, vy, omega_b, omega_j, angle
        As for `linkages.laws.journal.clearance_force`.

    Notes
    -----
    The couple is the one of `linkages.laws.journal.film_action`.
    """
    x, y, u, v, c, s = in_bearing(joint, ex, ey, vx, vy, omega_b, angle)
    spin = omega_j - omega_b
    fx, fy, shear, flow = solve_history(table, oil, x, y, u, v, spin, _supply(joint))
    scale = joint.viscosity * joint.radius**4 / joint.clearance**2
    fx, fy = scale * (c * fx - s * fy), scale * (s * fx + c * fy)
    couple = 0.0
    if joint.shear != _NO_SHEAR:
        couple = -joint.clearance * scale * shear * spin - 0.5 * (ex * fy - ey * fx)
    return fx, fy, couple, mean_content(table, oil, x, y), joint.clearance * joint.radius**2 * flow


@lazy_kernel
def advance_film(
    joint: np.record, table: Array, oil: Array, t: float, ex: float, ey: float, omega_b: float, omega_j: float,
    angle: float,
) -> None:  # fmt: skip
    """Move the content of a film to time t, see `advance_history`."""
    x, y, _, _, _, _ = in_bearing(joint, ex, ey, 0.0, 0.0, omega_b, angle)
    if t > oil[TIME]:
        advance_history(table, oil, t, x, y, omega_j - omega_b, _supply(joint))


@lazy_kernel
def start_film(
    joint: np.record, table: Array, oil: Array, t: float, ex: float, ey: float, angle: float, fresh: bool
) -> None:
    """Set time and place of a film's last step, see `start_history`."""
    x, y, _, _, _, _ = in_bearing(joint, ex, ey, 0.0, 0.0, 0.0, angle)
    start_history(table, oil, t, x, y, fresh)
