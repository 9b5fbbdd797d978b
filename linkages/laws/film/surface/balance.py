"""Balance of volume of the film on each cell of a surface: conductances and capacities of its faces.

With h in units of the clearance c, velocities in c*omega, pressure in mu*omega*(R/c)^2 and volume flow in c*R^2*omega,
the film content phi in [0, 1] and u = 1/2 times the surface speed over R*omega,

    d/dtheta (u phi h - h^3/12 dp/dtheta) + d/dzeta (- h^3/12 dp/dzeta) + phi dh/dt = 0.

Between two centres with the flow q the pressure falls by the integral of 12 q/h^3 - 12 u/h^2, so that
q = u*I2/I3 - (p_right - p_left)/(12*I3), In the integral of dtheta/h^n: exact in one dimension, also where h jumps at a
face. A face carries the content of the cell upstream.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.by_reference import packed
from linkages.laws.film.surface.surface_mesh import NODES, SurfaceMesh

#: Volume that a full cell loses, in parts of the largest flow: a ring that nothing feeds is empty then. Without it the
#: content of such a ring is not unique. Round-off of the balance is larger.
_LEAK = 1e-13


class Thickness(NamedTuple):
    """Film between a journal and its bearing: h = 1 - (x + tilt_x zeta) cos(theta) - (y + tilt_y zeta) sin(theta).

    Lengths are in units of the clearance, zeta = z/R.

    Attributes
    ----------
    x, y : float
        Eccentricity in the bearing's middle.
    tilt_x, tilt_y : float
        Its change per unit of zeta.
    """

    x: float
    y: float
    tilt_x: float = 0.0
    tilt_y: float = 0.0

    def least(self, slenderness: float) -> float:
        """Smallest thickness, which is at an end of the bearing."""
        ends = [(self.x + s * self.tilt_x, self.y + s * self.tilt_y) for s in (-slenderness, slenderness)]
        return 1.0 - max(math.hypot(*end) for end in ends)


class Balance(NamedTuple):
    """Coefficients of the volume balance, (n, m) arrays; face i is the one after cell i around the film."""

    around: Array  # conductance of face i, between cells i and i + 1 (cyclic)
    carried: Array  # Couette flow through face i at full content, signed
    along: Array  # conductances along; the first and last column are the ends, zero of a mirror, (n, m + 1)
    inverse: Array  # integral of dtheta/h over the width of a cell
    gain: Array  # volume that a full cell takes up
    most: Array  # part of it that a deficit of 1 takes away
    known: Array  # pressure above the cavity's in the cells of grooves; -1 elsewhere


@inlined_kernel(makes_arrays=True)
def new_balance(known: Array) -> Balance:
    """Make the arrays."""
    n, m = known.shape
    around, carried, along = np.empty((n, m)), np.empty((n, m)), np.empty((n, m + 1))
    return Balance(around, carried, along, np.empty((n, m)), np.empty((n, m)), np.empty((n, m)), known)


def make_balance(
    mesh: SurfaceMesh, film: Thickness, velocity: tuple[float, float] = (0.0, 0.0), speed: float = 0.5
) -> Balance:
    """Integrate the film over cells and faces; grooves are at the cavity's pressure, the content is a steady one.

    Parameters
    ----------
    mesh : SurfaceMesh
    film : Thickness
    velocity : (float, float)
        Of the journal's centre in the bearing's frame, in units of c*omega.
    speed : float
        Mean surface speed over R*omega: half of the journal's in the bearing's frame.
    """
    n, m = mesh.groove.shape  # without `new_balance`, whose compilation takes half a second
    around, carried, inverse, later = np.empty((4, n, m))
    known = np.where(mesh.groove < 0, -1.0, 0.0)
    balance = Balance(around, carried, np.empty((n, m + 1)), inverse, later, later, known)
    fill_balance(*mesh.geometry, *film, speed, packed(balance))
    rate = -velocity[0] * mesh.lines[:, 1] - velocity[1] * mesh.lines[:, 2]
    squeeze = np.outer(rate, mesh.height)
    squeeze += _LEAK * (np.abs(balance.carried).max() + np.abs(squeeze).max())
    return balance._replace(gain=squeeze, most=squeeze)


def cell_volumes(mesh: SurfaceMesh, film: Thickness) -> Array:
    """Volumes of the gap in the cells: exact around, where the middle of a cell stands for its length."""
    width, sines, cosines = mesh.lines[:, :3].T
    x, y = film.x + film.tilt_x * mesh.zeta, film.y + film.tilt_y * mesh.zeta
    return np.asarray((width[:, None] - np.outer(sines, x) - np.outer(cosines, y)) * mesh.height)


@lazy_kernel(makes_arrays=True)
def fill_balance(
    lines: Array, ends: Array, zeta: Array, x: float, y: float, tilt_x: float, tilt_y: float, speed: float,
    balance: Balance,
) -> None:  # fmt: skip
    """Fill conductances, carried flow and the integral of 1/h of a balance with `known`; see `make_balance`.

    The arrays of a `SurfaceMesh` are of the bearing's half where the ends begin at 0.
    """
    around, carried, along, known = balance.around, balance.carried, balance.along, balance.known
    inverse, (n, m) = balance.inverse, known.shape
    powers, tilted = np.empty((n, NODES)), tilt_x != 0.0 or tilt_y != 0.0
    along[:] = 0.0
    for j in range(m):
        middle, length = zeta[j], ends[j + 1] - ends[j]
        if j == 0 or tilted:
            _integrate(lines, x + tilt_x * middle, y + tilt_y * middle, powers)
        for i in range(n):
            after = (i + 1) % n
            square, cube = 0.0, 0.0  # in a groove the pressure is known up to its edge
            if known[i, j] < 0.0:
                square, cube = powers[i, 2], powers[i, 3]
            if known[after, j] < 0.0:
                square, cube = square + powers[after, 0], cube + powers[after, 1]
            inverse[i, j] = powers[i, 4]
            around[i, j], carried[i, j] = 0.0, 0.0
            if cube > 0.0:
                around[i, j] = length / (12.0 * cube)
                carried[i, j] = speed * length * square / cube
        for side in range(2):  # resistances of the halves along, first
            if tilted:
                place = 0.5 * (middle + ends[j + side])
                _integrate(lines, x + tilt_x * place, y + tilt_y * place, powers)
            for i in range(n):
                if known[i, j] < 0.0:
                    along[i, j + side] += abs(ends[j + side] - middle) * powers[i, 5]
    for i in range(n):
        if ends[0] == 0.0:
            along[i, 0] = 0.0
        for j in range(m + 1):
            along[i, j] = 1.0 / along[i, j] if along[i, j] > 0.0 else 0.0  # a groove is closed at the bearing's end


@kernel
def _integrate(lines: Array, x: float, y: float, out: Array) -> None:
    """Fill ``out`` (n, 6): integrals over the halves of lines of h^-2 and h^-3, over all of h^-1, 12/that of h^3."""
    for i in range(len(out)):
        for k in range(NODES):
            out[i, k] = 0.0
        for k in range(NODES):
            weight = lines[i, 0] * (4.0 if k % 3 == 1 else 2.5) / 18.0
            h = 1.0 - x * lines[i, 3 + k] - y * lines[i, 3 + NODES + k]
            g = 1.0 / h
            half = 0 if k < 3 else 2
            out[i, half] += weight * g * g
            out[i, half + 1] += weight * g * g * g
            out[i, 4] += weight * g
            out[i, 5] += weight * h * h * h
        out[i, 5] = 12.0 / out[i, 5]


@lazy_kernel
def fill_contents(balance: Balance, z: Array, out: Array) -> None:
    """Fill ``out`` (n, m) with the content at the centres of cells, the mean of what the faces carry.

    ``z``, of `linkages.laws.film.surface.cavity.solve`, has for each cell the content at its face downstream.
    """
    carried, (n, m) = balance.carried, z.shape
    for i in range(n):
        for j in range(m):
            out[i, j] = 1.0
            if z[i, j] < 0.0:
                inflow, outflow = abs(carried[i - 1, j]), abs(carried[i, j])
                forward = carried[i, j] >= 0.0
                other = min(z[i - 1, j] if forward else z[(i + 1) % n, j], 0.0)
                up, down = (inflow, outflow) if forward else (outflow, inflow)
                out[i, j] += (up * other + down * z[i, j]) / (up + down) if up + down > 0.0 else z[i, j]
