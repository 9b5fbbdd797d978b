"""The film with a history in a machine: its content is a state, and the force a function of state, place and velocity.

Each cell of the bearing's surface has a missing volume D >= 0, the part of its gap W without oil. Its rate is

    dD/dt = m - D/tau,    m = (W/tau + dW/dt) d,    p >= 0,  0 <= d <= 1,  p d = 0,
    div(u (1 - d) h - h^3/12 grad p) + dW/dt + D/tau - m = 0,

the balance of volume over a look ahead by the film step tau: a cell fills in the time tau at the earliest, and
pressure builds up where it would be full then. This is the implicit Euler step over the time tau of
`linkages.laws.film.surface.transient`, as a rate. So the force is a continuous function of D, the place and the
velocity at any instant, which an integrator of any order can use, and D changes by an explicit step h <= tau:

    V(t + h) = (1 - h/tau) V(t) + (h/tau) V_implicit,    V = W - D the oil.

The oil thus stays within 0 and W, and its balance holds to round-off in each step. The error is of first order in tau,
and the film step follows from it, see `linkages.laws.film.film_steps`.

Passivity: in full cells D >= 0 and the flow that arrives is at most the one of a full film. So the sum of
p (div(u h) + dW/dt) over the cells is at most the one of p div(h^3/12 grad p), which is not positive: nor is the power
of the force in the frame of the mean surface velocity, for any content. A supply pressure adds its own power.

Units: lengths of the film in the clearance c, places in R, pressure in mu (R/c)^2 [1/s], volumes in c R^2; the frame is
the bearing's. The mesh is not graded for an eccentricity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.by_reference import reference
from linkages.laws.film.closed_form import EPS_MAX
from linkages.laws.film.film_map import GROOVED_LIMIT
from linkages.laws.film.surface.balance import fill_balance, new_balance
from linkages.laws.film.surface.cavity import settle
from linkages.laws.film.surface.grooves import Groove
from linkages.laws.film.surface.surface_film import integrate_film
from linkages.laws.film.surface.surface_mesh import LINE, surface_mesh
from linkages.laws.journal_motion import polar, sliding_speed
from linkages.laws.parameters import SHEAR

#: Largest eccentricity ratio of these films; the coarse mesh does not resolve thinner ones.
LARGEST = GROOVED_LIMIT
#: Entries of the memory of a film: time of its last step [s], place there (2), its largest force so far [N], the film
#: step [s], and from then on the missing volumes of the cells and, as a guess that no result depends on, the last
#: solution. A state between the steps of a run depends on those from `STEP` on.
TIME, PLACE_X, PLACE_Y, FORCE, STEP, MISSING = range(6)

_LEAST = 1e-6  # part of a gap that stays where it would close within the film step: there is no cavity then
_HEAD = 6  # numbers of a table before its arrays
_NO_SHEAR = SHEAR["none"]


class Sheet(NamedTuple):
    """Cells of a film with history; the first three as of `linkages.laws.film.surface.surface_mesh.SurfaceMesh`."""

    lines: Array
    ends: Array
    zeta: Array
    supply: Array  # pressure of the cells in grooves, over the largest; -1 elsewhere, (n, m)
    longest: float  # longest film step [s]
    content: float  # film content at the start, 0 to 1
    accuracy: float  # permitted error of the force, over the largest one; 0: the film step is the longest one
    least: float  # force that counts as the largest one until a film has a larger one [N]


def history_table(
    slenderness: float,
    grooves: Sequence[Groove],
    cells: tuple[int, int],
    step: float,
    content: float,
    accuracy: float = 0.0,
    least: float = 0.0,
) -> Array:
    """Lay out a film with history as a row of numbers, which `sheet_of` reads.

    From L/D; grooves in the bearing's frame, whose pressures count in parts of the largest; cells around and along half
    the length, to which edges of grooves add some; longest film step [s]; film content at the start, 0 to 1. The film
    step is the longest one, or with an `accuracy` as long as the error of the force is below this part of the largest
    force so far, and of the `least` one [N].
    """
    mesh = surface_mesh(slenderness, grooves, around=cells[0], along=cells[1])
    pressures = np.array([groove.pressure for groove in grooves])
    supply = mesh.pressures(pressures / (pressures.max(initial=0.0) or 1.0))
    numbers = [*supply.shape, step, content, accuracy, least]
    return np.concatenate([numbers, *map(np.ravel, mesh.geometry), supply.ravel()])


@inlined_kernel
def sheet_of(table: Array) -> Sheet:
    """Read a table of `history_table`, without a copy."""
    n, m = int(table[0]), int(table[1])
    ends = _HEAD + LINE * n
    zeta = ends + m + 1
    return Sheet(
        table[_HEAD:ends].reshape(n, LINE),
        table[ends:zeta],
        table[zeta : zeta + m],
        table[zeta + m : zeta + m + n * m].reshape(n, m),
        table[2],
        table[3],
        table[4],
        table[5],
    )


def memory_of(table: Array) -> int:
    """Return the number of entries that a film with this table remembers."""
    return MISSING + 2 * int(table[0]) * int(table[1])


@inlined_kernel
def remembered_cells(entries: int) -> int:
    """Return the number of missing volumes in a memory of so many entries."""
    return max(entries - MISSING, 0) // 2


@inlined_kernel
def recorded_entries(entries: int) -> int:
    """Return the number of entries from `STEP` on that a state depends on, in a memory of so many entries."""
    return remembered_cells(entries) + (MISSING - STEP if entries > MISSING else 0)


@inlined_kernel
def gap_of(sheet: Sheet, i: int, x: float, y: float) -> float:
    """Volume of the gap in a line of cells, over its length."""
    return sheet.lines[i, 0] - x * sheet.lines[i, 1] - y * sheet.lines[i, 2]


@kernel(makes_arrays=True)
def solve_history(
    table: Array, oil: Array, x: float, y: float, vx: float, vy: float, spin: float, supply: float, advance: float = 0.0
) -> tuple[float, float, float, float]:
    """Solve the film of a `history_table` with its memory, in which the solution is kept behind the missing volumes.

    Parameters
    ----------
    table, oil : arrays of float
        The memory has the film step.
    x, y, vx, vy : float
        Eccentricity in the bearing's frame, over the clearance, and its rate there [1/s].
    spin : float
        Angular velocity of the journal relative to the bearing [rad/s].
    supply : float
        Largest pressure of the grooves [1/s].
    advance : float
        Step over which the missing volumes move [s]; 0: they stay as they are.

    Returns
    -------
    fx, fy : float
        Force on the journal in units of mu R^4/c^2, in the bearing's frame.
    shear : float
        Integral of content/h over the surface: torque of a relative speed of 1 in units of mu R^4/c.
    flow : float
        Volume flow out of both ends in units of c R^2.
    """
    sheet = sheet_of(table)
    n, m = sheet.supply.shape
    lines, ends, supplies, often = sheet.lines, sheet.ends, sheet.supply, 1.0 / oil[STEP]
    known = np.empty((n, m))
    balance = new_balance(known)
    missing = oil[MISSING : MISSING + n * m].reshape(n, m)
    z = oil[MISSING + n * m : MISSING + 2 * n * m].reshape(n, m)
    for i in range(n):
        gap = often * gap_of(sheet, i, x, y)
        growth = -vx * lines[i, 1] - vy * lines[i, 2]
        most = max(gap + growth, _LEAST * gap)
        for j in range(m):
            share, length = supplies[i, j], ends[j + 1] - ends[j]
            known[i, j] = supply * share if share >= 0.0 else -1.0
            balance.gain[i, j] = length * growth + often * missing[i, j]
            balance.most[i, j] = length * most
    film = reference(balance)
    fill_balance(lines, ends, sheet.zeta, x, y, 0.0, 0.0, 0.5 * spin, film)
    settle(film, 0.0, True, z)
    fx, fy, _, _, shear, flow = integrate_film(lines, ends, sheet.zeta, film, 0.0, z)
    if advance > 0.0:
        kept = 1.0 - advance / oil[STEP]
        for i in range(n):
            for j in range(m):  # keeps the arrays alive, too
                missing[i, j] = kept * missing[i, j] + advance * balance.most[i, j] * max(-z[i, j], 0.0)
    return fx, fy, shear, flow


@kernel(makes_arrays=True)
def mean_content(table: Array, oil: Array, x: float, y: float) -> float:
    """Return the share of the gap outside of the grooves that is filled with oil."""
    sheet = sheet_of(table)
    n, m = sheet.supply.shape
    gap, missing = 0.0, 0.0
    for i in range(n):
        for j in range(m):
            if sheet.supply[i, j] < 0.0:
                gap += (sheet.ends[j + 1] - sheet.ends[j]) * gap_of(sheet, i, x, y)
                missing += oil[MISSING + i * m + j]
    return 1.0 - missing / gap


@inlined_kernel
def in_bearing(
    joint: np.record, ex: float, ey: float, vx: float, vy: float, omega_b: float, angle: float
) -> tuple[float, float, float, float, float, float]:
    """Return place and rate of a journal in the bearing's frame [1, 1/s], cosine and sine of the bearing's angle."""
    c, s, unit = math.cos(angle), math.sin(angle), 1.0 / joint.clearance
    far = math.sqrt(ex * ex + ey * ey) * unit
    inside = unit * (EPS_MAX / far if far > EPS_MAX else 1.0)
    ux, uy = unit * (vx + omega_b * ey), unit * (vy - omega_b * ex)
    return inside * (c * ex + s * ey), inside * (c * ey - s * ex), c * ux + s * uy, c * uy - s * ux, c, s


@inlined_kernel
def supply_of(joint: np.record) -> float:
    """Return the largest pressure of the grooves in units of mu (R/c)^2."""
    return joint.supply_pressure * (joint.clearance / joint.radius) ** 2 / joint.viscosity


@lazy_kernel
def history_force(
    joint: np.record, table: Array, oil: Array, ex: float, ey: float, vx: float, vy: float, omega_b: float,
    omega_j: float, angle: float,
) -> tuple[float, float, float, float, float, float, float, float]:  # fmt: skip
    """Compute the force (2) and couple on the journal, penetration, its rate, sliding speed, film content, flow [m3/s].

    The couple is the one of `linkages.laws.journal.film_action`.
    """
    e, _, _, v_n, v_t = polar(ex, ey, vx, vy)
    sliding = sliding_speed(joint, e, v_t, omega_b, omega_j)
    x, y, u, v, c, s = in_bearing(joint, ex, ey, vx, vy, omega_b, angle)
    spin = omega_j - omega_b
    fx, fy, shear, flow = solve_history(table, oil, x, y, u, v, spin, supply_of(joint))
    scale = joint.viscosity * joint.radius**4 / joint.clearance**2
    fx, fy = scale * (c * fx - s * fy), scale * (s * fx + c * fy)
    couple = 0.0
    if joint.shear != _NO_SHEAR:
        couple = -joint.clearance * scale * shear * spin - 0.5 * (ex * fy - ey * fx)
    content, flow = mean_content(table, oil, x, y), joint.clearance * joint.radius**2 * flow
    return fx, fy, couple, e - joint.clearance, v_n, sliding, content, flow
