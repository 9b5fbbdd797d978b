"""The constant-strain triangle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError


def signed_area(corners: Array) -> float:
    """Area of a triangle with corners (3, 2), positive if they are counter-clockwise."""
    (ax, ay), (bx, by) = corners[1] - corners[0], corners[2] - corners[0]
    return float(0.5 * (ax * by - ay * bx))


@dataclass(frozen=True)
class Triangle:
    """A triangular plate in plane stress with linear displacements (u_1, v_1, u_2, v_2, u_3, v_3)."""

    corners: Array  # (3, 2) [m]
    thickness: float  # [m]
    youngs_modulus: float  # [Pa]
    poisson: float
    density: float  # [kg/m3]

    def __post_init__(self) -> None:
        for name in ("thickness", "youngs_modulus", "density"):
            if not getattr(self, name) > 0.0:
                raise InputError("triangle", name, f"is {getattr(self, name):g}; it must be positive")
        if self.signed_area == 0.0:
            raise InputError("triangle", "corners", "lie on a line; they must span a triangle")

    @property
    def signed_area(self) -> float:
        """Area [m2], positive if the corners are counter-clockwise."""
        return signed_area(self.corners)

    @property
    def total_mass(self) -> float:
        """Mass [kg]."""
        return self.density * self.thickness * abs(self.signed_area)

    def strain_matrix(self) -> Array:
        """Strains (eps_x, eps_y, gamma_xy) per displacement (3, 6) [1/m]."""
        x, y = self.corners[:, 0], self.corners[:, 1]
        ahead, behind = np.array([1, 2, 0]), np.array([2, 0, 1])
        b = (y[ahead] - y[behind]) / (2.0 * self.signed_area)
        c = (x[behind] - x[ahead]) / (2.0 * self.signed_area)
        matrix = np.zeros((3, 6))
        matrix[0, 0::2], matrix[1, 1::2] = b, c
        matrix[2, 0::2], matrix[2, 1::2] = c, b
        return matrix

    def elasticity(self) -> Array:
        """Plane-stress elasticity (3, 3) [Pa], with the shear modulus E/(2 (1 + nu))."""
        nu = self.poisson
        factor = self.youngs_modulus / (1.0 - nu**2)
        return factor * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])

    def stiffness(self) -> Array:
        """Stiffness matrix (6, 6)."""
        b = self.strain_matrix()
        return self.thickness * abs(self.signed_area) * b.T @ self.elasticity() @ b

    def mass(self) -> Array:
        """Consistent mass matrix (6, 6)."""
        pattern = np.asarray(np.kron(np.ones((3, 3)) + np.eye(3), np.eye(2)), float)
        return self.total_mass / 12.0 * pattern
