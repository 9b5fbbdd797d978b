"""Finite elements: straight beams, chains of them, and the constant-strain triangle.

A beam element has the displacements (u_1, v_1, w_1, u_2, v_2, w_2) along and across its axis and the
turning of its cross-section, in its own axes: the paper's delta of eq. (8), which writes v_2, v_4 for w_1,
w_2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError

Array = NDArray[np.floating]

_GAUSS = np.polynomial.legendre.leggauss(5)
_AXIAL, _BENDING = [0, 3], [1, 2, 4, 5]


@dataclass(frozen=True)
class Beam:
    """A uniform straight beam.

    Attributes
    ----------
    length : float
        [m].
    axial : float
        E A [N].
    bending : float
        E I [N m2].
    line_density : float
        rho A [kg/m].
    shear : float
        kappa G A [N]; infinite for Euler-Bernoulli's beam.
    rotary : float
        rho I [kg m], rotary inertia; zero for Euler-Bernoulli's beam.
    """

    length: float
    axial: float
    bending: float
    line_density: float
    shear: float = np.inf
    rotary: float = 0.0

    def __post_init__(self) -> None:
        for name in ("length", "axial", "bending", "line_density", "shear"):
            if not getattr(self, name) > 0.0:
                raise InputError("beam", name, f"is {getattr(self, name):g}; it must be positive")
        if self.rotary < 0.0:
            raise InputError("beam", "rotary", f"is {self.rotary:g}; it must not be negative")

    def piece(self, count: int) -> Beam:
        """One of `count` equal parts."""
        return Beam(self.length / count, self.axial, self.bending, self.line_density, self.shear, self.rotary)

    @property
    def shear_ratio(self) -> float:
        """12 E I / (kappa G A L^2), zero for Euler-Bernoulli's beam."""
        return 12.0 * self.bending / (self.shear * self.length**2)

    def shapes(self, s: Array) -> tuple[Array, Array, Array]:
        """Shape functions at s (n,) in [0, 1]: displacements (n, 2, 6), turning and curvature (n, 6) each.

        Without shear Hermite's cubics, whose frequencies converge at fourth order. With shear the cubics of
        Friedman and Kosmatka (1993): exact under end loads and free of locking, uniform shear in an
        element, second order.
        """
        p, length = self.shear_ratio, self.length
        s = np.asarray(s, dtype=float)
        displacement = np.zeros((len(s), 2, 6))
        displacement[:, 0, 0], displacement[:, 0, 3] = 1.0 - s, s
        turning, curvature = np.zeros((len(s), 6)), np.zeros((len(s), 6))
        bubble = 2.0 * s**3 - 3.0 * s**2 - p * s
        displacement[:, 1, 1] = (bubble + 1.0 + p) / (1.0 + p)
        displacement[:, 1, 2] = length * (s**3 - (2.0 + p / 2.0) * s**2 + (1.0 + p / 2.0) * s) / (1.0 + p)
        displacement[:, 1, 4] = -bubble / (1.0 + p)
        displacement[:, 1, 5] = length * (s**3 - (1.0 - p / 2.0) * s**2 - p / 2.0 * s) / (1.0 + p)
        turning[:, 1] = 6.0 * (s**2 - s) / ((1.0 + p) * length)
        turning[:, 2] = (3.0 * s**2 - (4.0 + p) * s + 1.0 + p) / (1.0 + p)
        turning[:, 4] = -turning[:, 1]
        turning[:, 5] = (3.0 * s**2 - (2.0 - p) * s) / (1.0 + p)
        curvature[:, 1] = 6.0 * (2.0 * s - 1.0) / ((1.0 + p) * length**2)
        curvature[:, 2] = (6.0 * s - 4.0 - p) / ((1.0 + p) * length)
        curvature[:, 4] = -curvature[:, 1]
        curvature[:, 5] = (6.0 * s - 2.0 + p) / ((1.0 + p) * length)
        return displacement, turning, curvature

    def quadrature(self) -> tuple[Array, Array]:
        """Gauss points in [0, 1] and weights [m], exact for products of the shape functions."""
        return 0.5 * (_GAUSS[0] + 1.0), 0.5 * self.length * _GAUSS[1]

    def stiffness(self) -> Array:
        """Stiffness matrix (6, 6)."""
        s, weight = self.quadrature()
        _, turning, curvature = self.shapes(s)
        k = self.bending * np.einsum("n,ni,nj->ij", weight, curvature, curvature)
        if np.isfinite(self.shear):
            strain = _slope(self, s) - turning
            k += self.shear * np.einsum("n,ni,nj->ij", weight, strain, strain)
        k[np.ix_(_AXIAL, _AXIAL)] = self.axial / self.length * np.array([[1.0, -1.0], [-1.0, 1.0]])
        return k

    def mass(self) -> Array:
        """Consistent mass matrix (6, 6)."""
        s, weight = self.quadrature()
        displacement, turning, _ = self.shapes(s)
        m = self.line_density * np.einsum("n,nci,ncj->ij", weight, displacement, displacement)
        return m + self.rotary * np.einsum("n,ni,nj->ij", weight, turning, turning)


def _slope(beam: Beam, s: Array) -> Array:
    """Slope dv/dx (n, 6) of the transverse shape functions."""
    p, length = beam.shear_ratio, beam.length
    slope = np.zeros((len(s), 6))
    slope[:, 1] = (6.0 * s**2 - 6.0 * s - p) / ((1.0 + p) * length)
    slope[:, 2] = (3.0 * s**2 - (4.0 + p) * s + 1.0 + p / 2.0) / (1.0 + p)
    slope[:, 4] = -slope[:, 1]
    slope[:, 5] = (3.0 * s**2 - (2.0 - p) * s - p / 2.0) / (1.0 + p)
    return slope


def geometric_stiffness(beam: Beam) -> Array:
    """Geometric stiffness (6, 6) of a unit axial tension [1/m]: integral of v' v'."""
    s, weight = beam.quadrature()
    slope = _slope(beam, s)
    return np.einsum("n,ni,nj->ij", weight, slope, slope)


def chain_dofs(count: int) -> NDArray[np.int64]:
    """Place (count, 6) of each element's displacements in a chain of `count` elements: three to a node."""
    return 3 * np.arange(count)[:, None] + np.arange(6)


def chain(element_matrix: Array, count: int) -> Array:
    """Matrix (3 (count+1), 3 (count+1)) of a straight chain of equal elements."""
    result = np.zeros((3 * count + 3, 3 * count + 3))
    for dofs in chain_dofs(count):
        result[np.ix_(dofs, dofs)] += element_matrix
    return result


@dataclass(frozen=True)
class Triangle:
    """A plate triangle in plane stress with linear displacements: constant strain.

    Its displacements are (u_1, v_1, u_2, v_2, u_3, v_3), eq. (7).

    Attributes
    ----------
    corners : (3, 2) array
        [m].
    thickness, youngs_modulus, poisson, density
        [m, Pa, 1, kg/m3].
    """

    corners: Array
    thickness: float
    youngs_modulus: float
    poisson: float
    density: float

    def __post_init__(self) -> None:
        for name in ("thickness", "youngs_modulus", "density"):
            if not getattr(self, name) > 0.0:
                raise InputError("triangle", name, f"is {getattr(self, name):g}; it must be positive")
        if self.signed_area == 0.0:
            raise InputError("triangle", "corners", "lie on a line; they must span a triangle")

    @property
    def signed_area(self) -> float:
        """Area [m2], positive if the corners are counter-clockwise."""
        (ax, ay), (bx, by) = self.corners[1] - self.corners[0], self.corners[2] - self.corners[0]
        return float(0.5 * (ax * by - ay * bx))

    @property
    def total_mass(self) -> float:
        """Mass [kg]."""
        return self.density * self.thickness * abs(self.signed_area)

    def strain_matrix(self) -> Array:
        """Strains (eps_x, eps_y, gamma_xy) of the displacements: (3, 6)."""
        x, y = self.corners[:, 0], self.corners[:, 1]
        ahead, behind = np.array([1, 2, 0]), np.array([2, 0, 1])
        b = (y[ahead] - y[behind]) / (2.0 * self.signed_area)
        c = (x[behind] - x[ahead]) / (2.0 * self.signed_area)
        matrix = np.zeros((3, 6))
        matrix[0, 0::2], matrix[1, 1::2] = b, c
        matrix[2, 0::2], matrix[2, 1::2] = c, b
        return matrix

    def elasticity(self) -> Array:
        """Plane-stress elasticity (3, 3) [Pa]; shear modulus E/(2 (1 + nu)), misprinted in eq. (14)."""
        nu = self.poisson
        factor = self.youngs_modulus / (1.0 - nu**2)
        return factor * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])

    def stiffness(self) -> Array:
        """Stiffness matrix (6, 6)."""
        b = self.strain_matrix()
        return self.thickness * abs(self.signed_area) * b.T @ self.elasticity() @ b

    def mass(self) -> Array:
        """Consistent mass matrix (6, 6)."""
        return self.total_mass / 12.0 * np.kron(np.ones((3, 3)) + np.eye(3), np.eye(2))
