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
from numpy.typing import NDArray

from linkages.kernel import Array
from linkages.laws.film.surface.surface_mesh import SurfaceMesh

_GAUSS = math.sqrt(0.6)  # nodes of the rule of three points in [-1, 1]; weights 5/9, 8/9, 5/9


class Thickness(NamedTuple):
    """Film between a journal and its bearing: h = 1 - (x + tilt_x zeta) cos(theta) - (y + tilt_y zeta) sin(theta).

    Lengths are in units of the clearance, zeta = z/R.
    """

    x: float
    y: float
    tilt_x: float = 0.0
    tilt_y: float = 0.0

    def at(self, theta: Array, zeta: Array) -> Array:
        """Thickness at points."""
        x, y = self.x + self.tilt_x * zeta, self.y + self.tilt_y * zeta
        return np.asarray(1.0 - x * np.cos(theta) - y * np.sin(theta))

    def least(self, slenderness: float) -> float:
        """Smallest thickness, which is at an end of the bearing."""
        ends = [(self.x + s * self.tilt_x, self.y + s * self.tilt_y) for s in (-slenderness, slenderness)]
        return 1.0 - max(math.hypot(*end) for end in ends)


class Balance(NamedTuple):
    """Coefficients of the volume balance; all arrays (n, m), face i is the one after cell i around the film."""

    around: Array  # conductance of face i, between cells i and i + 1 (cyclic)
    carried: Array  # Couette flow through face i at full content, signed
    along: Array  # conductance between cells j and j + 1; the last column is the end at zeta > 0
    start: Array  # conductance of the end at zeta < 0, (n,); zero of a mirror
    squeeze: Array  # volume that a full cell takes up: integral of dh/dt over it
    missing: Array  # factor of the missing content in what the cell takes up: squeeze of a film without history
    free: NDArray[np.bool_]  # cells that are not in a groove


def make_balance(
    mesh: SurfaceMesh, film: Thickness, velocity: tuple[float, float] = (0.0, 0.0), speed: float = 0.5
) -> Balance:
    """Integrate the film over cells and faces.

    Parameters
    ----------
    mesh : SurfaceMesh
    film : Thickness
    velocity : (float, float)
        Of the journal's centre in the bearing's frame, in units of c*omega.
    speed : float
        Mean surface speed over R*omega: half of the journal's in the bearing's frame.
    """
    theta, zeta = mesh.theta[:, None], mesh.zeta
    low, high = mesh.faces[:-1, None], mesh.faces[1:, None]
    free = mesh.groove < 0
    left, right = (_powers(film, a, b, zeta) for a, b in ((low, theta), (theta, high)))
    # in a groove the pressure is known up to its edge
    left, right = left * free, right * free
    cube = right[1] + np.roll(left[1], -1, axis=0)
    square = right[0] + np.roll(left[0], -1, axis=0)
    open_face = cube > 0.0
    safe = np.where(open_face, cube, 1.0)
    around = np.where(open_face, mesh.height / (12.0 * safe), 0.0)
    carried = np.where(open_face, speed * mesh.height * square / safe, 0.0)
    vx, vy = velocity
    sines, cosines = np.sin(mesh.faces), np.cos(mesh.faces)
    rate = -vx * np.diff(sines) + vy * np.diff(cosines)
    squeeze = rate[:, None] * mesh.height * np.ones_like(around)
    return Balance(around, carried, *_axial(mesh, film, free), squeeze=squeeze, missing=squeeze, free=free)


def cell_volumes(mesh: SurfaceMesh, film: Thickness) -> Array:
    """Volumes of the gap in the cells: exact around, where the middle of a cell stands for its length."""
    sines, cosines = np.diff(np.sin(mesh.faces))[:, None], -np.diff(np.cos(mesh.faces))[:, None]
    x, y = film.x + film.tilt_x * mesh.zeta, film.y + film.tilt_y * mesh.zeta
    return np.asarray((mesh.width[:, None] - x * sines - y * cosines) * mesh.height)


def with_history(balance: Balance, volumes: Array, oil: Array, time: float) -> Balance:
    """Replace the squeeze of a balance by the change of the oil in the cells over a step of time (implicit Euler).

    Parameters
    ----------
    balance : Balance
        At the end of the step.
    volumes : (n, m) array
        Of the gap in the cells at the end of the step.
    oil : (n, m) array
        Volume of oil in the cells at the beginning.
    time : float
        Length of the step in units of 1/omega.
    """
    return balance._replace(squeeze=(volumes - oil) / time, missing=volumes / time)


def _powers(film: Thickness, low: Array, high: Array, zeta: Array) -> Array:
    """Integrals of h^-2 and h^-3 from low to high, (2, n, m)."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    total = np.zeros((2, *np.broadcast_shapes(middle.shape, zeta.shape)))
    for node, weight in ((-_GAUSS, 5.0 / 9.0), (0.0, 8.0 / 9.0), (_GAUSS, 5.0 / 9.0)):
        h = film.at(middle + node * half, zeta)
        total += weight * half * np.stack([h**-2, h**-3])
    return total


def _axial(mesh: SurfaceMesh, film: Thickness, free: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Conductances along the bearing, and of its end at zeta < 0."""
    shape = free.shape
    resistance = []
    for low, high in ((mesh.ends[:-1], mesh.zeta), (mesh.zeta, mesh.ends[1:])):
        middle, half = mesh.theta[:, None], 0.5 * mesh.width[:, None]
        cube = np.zeros(shape)
        for node, weight in ((-_GAUSS, 5.0 / 9.0), (0.0, 8.0 / 9.0), (_GAUSS, 5.0 / 9.0)):
            cube += weight * half * film.at(middle + node * half, 0.5 * (low + high)) ** 3
        resistance.append(np.where(free, 12.0 * (high - low) / cube, 0.0))
    lower, upper = resistance
    between = upper.copy()
    between[:, :-1] += lower[:, 1:]
    along = np.where(between > 0.0, 1.0 / np.where(between > 0.0, between, 1.0), 0.0)
    along[:, -1] *= free[:, -1]  # a groove is closed at the bearing's end
    start = np.zeros(shape[0])
    if not mesh.half:
        start = np.where(free[:, 0], 1.0 / np.where(free[:, 0], lower[:, 0], 1.0), 0.0)
    return along, start
