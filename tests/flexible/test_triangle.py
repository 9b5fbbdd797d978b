"""The triangle: the patch test, inertia, Hooke's law."""

from __future__ import annotations

import numpy as np
import pytest

from linkages.mechanics.flexible.triangle import Triangle

E, RHO, NU = 2.06e11, 7850.0, 0.3


def mesh() -> tuple[np.ndarray, np.ndarray]:
    """Return a square of irregular triangles about one inner node, and two more."""
    nodes = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.43, 0.61], [0.7, 0.2]], dtype=float)
    return nodes, np.array([[0, 1, 5], [1, 2, 5], [5, 2, 4], [2, 3, 4], [3, 0, 4], [0, 5, 4]])


def test_triangle_patch_test() -> None:
    """A linear displacement on the border gives the linear displacement and uniform strain inside."""
    nodes, triangles = mesh()
    gradient, shift = np.array([[2e-4, -1e-4], [3e-4, 5e-4]]), np.array([1e-3, -2e-3])
    exact = (nodes @ gradient.T + shift).ravel()
    k = np.zeros((12, 12))
    for corners in triangles:
        dofs = np.array([[2 * c, 2 * c + 1] for c in corners]).ravel()
        k[np.ix_(dofs, dofs)] += Triangle(nodes[corners], 0.01, E, NU, RHO).stiffness()
    inner, border = np.arange(8, 12), np.arange(8)
    u = exact.copy()
    u[inner] = np.linalg.solve(k[np.ix_(inner, inner)], -k[np.ix_(inner, border)] @ exact[border])
    np.testing.assert_allclose(u, exact, rtol=0, atol=1e-15)
    for corners in triangles:
        strain = Triangle(nodes[corners], 0.01, E, NU, RHO).strain_matrix() @ u.reshape(-1, 2)[corners].ravel()
        np.testing.assert_allclose(strain, [2e-4, 5e-4, 2e-4], atol=1e-15)


def test_triangle_inertia_and_orientation() -> None:
    corners = np.array([[0.0, 0.0], [0.36, 0.0], [0.18, 0.36 * np.sqrt(3) / 2]])
    plate = Triangle(corners, 0.025, E, NU, RHO)
    r = corners - corners.mean(0)
    turn = np.column_stack([-r[:, 1], r[:, 0]]).ravel()
    mass = RHO * 0.025 * 0.36**2 * np.sqrt(3) / 4
    assert turn @ plate.mass() @ turn == pytest.approx(mass * 0.36**2 / 12, rel=1e-12)
    back = Triangle(corners[[0, 2, 1]], 0.025, E, NU, RHO)
    place = [0, 1, 4, 5, 2, 3]
    np.testing.assert_allclose(back.stiffness()[np.ix_(place, place)], plate.stiffness(), rtol=1e-12, atol=1e-3)


def test_triangle_under_tension_and_shear_obeys_hooke() -> None:
    plate = Triangle(np.array([[0.0, 0.0], [1.0, 0.1], [0.2, 0.9]]), 0.01, E, NU, RHO)
    for strain, stress in (([1 / E, -NU / E, 0.0], [1.0, 0.0, 0.0]), ([0.0, 0.0, 2 * (1 + NU) / E], [0.0, 0.0, 1.0])):
        np.testing.assert_allclose(plate.elasticity() @ strain, stress, atol=1e-12)
