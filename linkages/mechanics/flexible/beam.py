"""The straight beam element, Euler-Bernoulli or Timoshenko, and chains of equal elements.

The element's displacements are (u_1, v_1, w_1, u_2, v_2, w_2): along and across its axis and the rotation of its
cross-section, at its two ends and in its own axes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.mechanics.flexible.rotation import BEAM, rotation_parts

_GAUSS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class Beam:
    """A uniform straight beam."""

    length: float  # [m]
    axial: float  # E A [N]
    bending: float  # E I [N m2]
    line_density: float  # rho A [kg/m]
    shear: float = np.inf  # kappa G A [N]; infinite for Euler-Bernoulli's beam
    rotary: float = 0.0  # rho I [kg m], rotary inertia; zero for Euler-Bernoulli's beam

    def __post_init__(self) -> None:
        for name in ("length", "axial", "bending", "line_density", "shear"):
            if not getattr(self, name) > 0.0:
                raise InputError("beam", name, f"is {getattr(self, name):g}; it must be positive")
        if self.rotary < 0.0:
            raise InputError("beam", "rotary", f"is {self.rotary:g}; it must not be negative")

    @property
    def pinned_frequency(self) -> float:
        """Compute the first bending frequency of the Euler-Bernoulli beam with both ends pinned [rad/s]."""
        return float((np.pi / self.length) ** 2 * np.sqrt(self.bending / self.line_density))

    @property
    def held_frequency(self) -> float:
        """Compute the first axial frequency with one end fixed [rad/s]."""
        return float(0.5 * np.pi / self.length * np.sqrt(self.axial / self.line_density))

    def piece(self, count: int) -> Beam:
        """Return one of `count` equal parts."""
        return replace(self, length=self.length / count)

    @property
    def shear_ratio(self) -> float:
        """12 E I / (kappa G A L^2), zero for Euler-Bernoulli's beam."""
        return 12.0 * self.bending / (self.shear * self.length**2)

    def shapes(self, s: Array) -> tuple[Array, Array, Array]:
        """Shape functions at s (n,) in [0, 1]: displacements (n, 2, 6), rotation and curvature (n, 6) each.

        Without shear these are Hermite's cubics, whose frequencies converge at fourth order. With shear they are
        the cubics of Friedman and Kosmatka (1993): exact under end loads, free of locking, with uniform shear in
        an element, and of second order.
        """
        p, length = self.shear_ratio, self.length
        s = np.asarray(s, dtype=float)
        displacement = np.zeros((len(s), 2, 6))
        displacement[:, 0, 0], displacement[:, 0, 3] = 1.0 - s, s
        rotation, curvature = np.zeros((len(s), 6)), np.zeros((len(s), 6))
        bubble = 2.0 * s**3 - 3.0 * s**2 - p * s
        displacement[:, 1, 1] = (bubble + 1.0 + p) / (1.0 + p)
        displacement[:, 1, 2] = length * (s**3 - (2.0 + p / 2.0) * s**2 + (1.0 + p / 2.0) * s) / (1.0 + p)
        displacement[:, 1, 4] = -bubble / (1.0 + p)
        displacement[:, 1, 5] = length * (s**3 - (1.0 - p / 2.0) * s**2 - p / 2.0 * s) / (1.0 + p)
        rotation[:, 1] = 6.0 * (s**2 - s) / ((1.0 + p) * length)
        rotation[:, 2] = (3.0 * s**2 - (4.0 + p) * s + 1.0 + p) / (1.0 + p)
        rotation[:, 4] = -rotation[:, 1]
        rotation[:, 5] = (3.0 * s**2 - (2.0 - p) * s) / (1.0 + p)
        curvature[:, 1] = 6.0 * (2.0 * s - 1.0) / ((1.0 + p) * length**2)
        curvature[:, 2] = (6.0 * s - 4.0 - p) / ((1.0 + p) * length)
        curvature[:, 4] = -curvature[:, 1]
        curvature[:, 5] = (6.0 * s - 2.0 + p) / ((1.0 + p) * length)
        return displacement, rotation, curvature

    def slope(self, s: Array) -> Array:
        """Slope dv/dx (n, 6) of the shape functions at s (n,) in [0, 1]: rotation and uniform shear."""
        shear = np.array([0.0, 1.0 / self.length, 0.5, 0.0, -1.0 / self.length, 0.5])
        return self.shapes(s)[1] - self.shear_ratio / (1.0 + self.shear_ratio) * shear

    def quadrature(self) -> tuple[Array, Array]:
        """Gauss points in [0, 1] and weights [m], exact for products of the shape functions."""
        return 0.5 * (_GAUSS[0] + 1.0), 0.5 * self.length * _GAUSS[1]

    def stiffness(self) -> Array:
        """Stiffness matrix (6, 6)."""
        s, weight = self.quadrature()
        _, rotation, curvature = self.shapes(s)
        k = self.bending * np.einsum("n,ni,nj->ij", weight, curvature, curvature)
        if np.isfinite(self.shear):
            strain = self.slope(s) - rotation
            k += self.shear * np.einsum("n,ni,nj->ij", weight, strain, strain)
        k[::3, ::3] = self.axial / self.length * np.array([[1.0, -1.0], [-1.0, 1.0]])
        return k

    def mass(self) -> Array:
        """Consistent mass matrix (6, 6)."""
        s, weight = self.quadrature()
        displacement, rotation, _ = self.shapes(s)
        m = self.line_density * np.einsum("n,nci,ncj->ij", weight, displacement, displacement)
        return m + self.rotary * np.einsum("n,ni,nj->ij", weight, rotation, rotation)

    def geometric_stiffness(self) -> Array:
        """Geometric stiffness (6, 6) of a unit axial tension [1/m]: the integral of v' v'."""
        s, weight = self.quadrature()
        slope = self.slope(s)
        return np.einsum("n,ni,nj->ij", weight, slope, slope)

    def velocity_terms(self) -> tuple[Array, Array]:
        """Matrices (6, 6) by which a rotating element's inertia depends on its angular velocity omega [kg].

        The displacement is u = R N R' U, with R the element's rotation, N the shape functions and U the nodal
        displacements in plane axes. Its time derivatives at constant U do not vanish, as axial and transverse shapes
        differ:

            du/dt = omega R A R' U,   d2u/dt2 = R (alpha A + omega^2 B) R' U,
            A = S N + N D,   B = -N + 2 S N D + N D D,

        where S rotates by +90 degrees and D the nodes' displacements by -90 degrees. The equations of motion become M
        U'' + G U' + (K + K_c) U = F with G = 2 omega P and K_c = alpha P + omega^2 Q, in element axes. Returns P and Q:
        the integrals of rho A N' A and rho A N' B.
        """
        s, weight = self.quadrature()
        n = self.shapes(s)[0]
        quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
        _, _, d = rotation_parts(BEAM)
        first = quarter @ n + n @ d
        second = -n + 2.0 * quarter @ n @ d + n @ d @ d
        p, q = (self.line_density * np.einsum("q,qci,qcj->ij", weight, n, part) for part in (first, second))
        return p, q

    def internal_forces(self, u: Array, a: Array, x: Array) -> tuple[Array, Array]:
        """Axial force (..., P) [N], positive in tension, and bending moment E I v'' (..., P) [N m] within the element.

        They follow from equilibrium: the end forces are K u + M a, and the inertia of the acceleration, as the shape
        functions have it, is integrated from the first node. A hinged end has no moment, at rest as in vibration. The
        shape functions' derivatives alone would give a moment that is linear along the element. `u` and `a` (..., 6)
        are the elastic displacements, and the accelerations, rigid and elastic together, in element axes; `x` (P,) are
        distances from the first node [m].
        """
        s, weight = self.quadrature()
        place = x[:, None] * s  # Gauss points between the first node and each x
        displacement, rotation, _ = (
            shape.reshape(*place.shape, -1) for shape in self.shapes((place / self.length).ravel())
        )
        along, across = displacement[..., :6], displacement[..., 6:]
        share = weight / self.length * x[:, None]
        axial = self.line_density * np.einsum("pq,pqi->pi", share, along)
        lever = self.line_density * np.einsum("pq,pqi->pi", share * (x[:, None] - place), across)
        lever -= self.rotary * np.einsum("pq,pqi->pi", share, rotation)
        end = u @ self.stiffness() + a @ self.mass()
        force = a @ axial.T - end[..., 0, None]
        moment = end[..., 1, None] * x - end[..., 2, None] - a @ lever.T
        return force, moment


def chain_dofs(count: int) -> NDArray[np.int64]:
    """Place (count, 6) of each element's displacements in a chain of `count` elements: three to a node."""
    return 3 * np.arange(count)[:, None] + np.arange(6)


def chain(element_matrix: Array, count: int) -> Array:
    """Matrix (3 (count+1), 3 (count+1)) of a straight chain of equal elements."""
    result = np.zeros((3 * count + 3, 3 * count + 3))
    for dofs in chain_dofs(count):
        result[np.ix_(dofs, dofs)] += element_matrix
    return result
