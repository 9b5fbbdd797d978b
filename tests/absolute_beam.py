"""A geometrically exact Euler-Bernoulli beam in absolute nodal coordinates: it shares nothing with the package.

Nodes have position and gradient (x, y, x', y'); between them both components are Hermite's cubics of the arc length s of
the straight beam. The mass matrix is constant, so is the matrix of any pin. Strain |r'| - 1 and curvature r' x r'' / |r'|^2
are exact for slopes of any size (J. Gerstmayr and H. Irschik, On the correct representation of bending and axial
deformation in the absolute nodal coordinate formulation with an elastic line approach, J. Sound Vib. 318, 2008). Neither
shear nor rotary inertia; damping is Kelvin and Voigt's, sigma = E (eps + beta eps').
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

_GAUSS = np.polynomial.legendre.leggauss(5)


@dataclass
class AbsoluteBeam:
    """A uniform beam of equal elements, along x when undeformed.

    `length` [m], `axial` E A [N], `bending` E I [N m2], `line_density` [kg/m], `damping` beta [s].
    """

    length: float
    axial: float
    bending: float
    line_density: float
    elements: int
    damping: float = 0.0

    def __post_init__(self) -> None:
        h, x = self.length / self.elements, 0.5 * (_GAUSS[0] + 1.0)
        one = np.ones_like(x)
        self.weight = 0.5 * h * _GAUSS[1]
        shape = np.array([1 - 3 * x**2 + 2 * x**3, h * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, h * (x**3 - x**2)])
        first = np.array([6 * x**2 - 6 * x, h * (1 - 4 * x + 3 * x**2), 6 * x - 6 * x**2, h * (3 * x**2 - 2 * x)]) / h
        second = np.array([12 * x - 6 * one, h * (6 * x - 4 * one), 6 * one - 12 * x, h * (6 * x - 2 * one)]) / h**2
        # (Gauss point, direction, displacement of an element)
        self.first, self.second = (np.einsum("iq,cd->qcid", f, np.eye(2)).reshape(5, 2, 8) for f in (first, second))
        self.dofs = 4 * np.arange(self.elements)[:, None] + np.arange(8)
        self.size = 4 * (self.elements + 1)
        one_element = self.line_density * np.kron(np.einsum("q,iq,jq->ij", self.weight, shape, shape), np.eye(2))
        self.mass = self.assembled(np.broadcast_to(one_element, (self.elements, 8, 8)))

    def straight(self, origin: np.ndarray, angle: float = 0.0) -> np.ndarray:
        """Coordinates (size,) of the undeformed beam."""
        axis = np.array([np.cos(angle), np.sin(angle)])
        s = np.linspace(0.0, self.length, self.elements + 1)
        return np.hstack([origin + s[:, None] * axis, np.broadcast_to(axis, (len(s), 2))]).ravel()

    def assembled(self, parts: np.ndarray) -> np.ndarray:
        """Sum of elements' vectors (elements, 8) or matrices (elements, 8, 8)."""
        total = np.zeros((self.size,) * (parts.ndim - 1))
        np.add.at(total, self.dofs if parts.ndim == 2 else (self.dofs[:, :, None], self.dofs[:, None]), parts)
        return total

    def strains(self, q: np.ndarray) -> tuple[np.ndarray, ...]:
        """Strain and curvature (elements, 5), and their derivatives (elements, 5, 8)."""
        p, c = self.first @ q[self.dofs][:, None, :, None], self.second @ q[self.dofs][:, None, :, None]
        p, c = p[..., 0], c[..., 0]
        stretch = np.linalg.norm(p, axis=-1)
        curvature = (p[..., 0] * c[..., 1] - p[..., 1] * c[..., 0]) / stretch**2
        by_p = np.stack([c[..., 1], -c[..., 0]], -1) / stretch[..., None] ** 2
        by_p -= 2.0 * (curvature / stretch**2)[..., None] * p
        by_c = np.stack([-p[..., 1], p[..., 0]], -1) / stretch[..., None] ** 2
        d_strain = np.einsum("eqc,qci->eqi", p / stretch[..., None], self.first)
        d_curvature = np.einsum("eqc,qci->eqi", by_p, self.first) + np.einsum("eqc,qci->eqi", by_c, self.second)
        return stretch - 1.0, curvature, d_strain, d_curvature

    def forces(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Elastic and damping forces (size,) that act on the coordinates."""
        strain, curvature, d_strain, d_curvature = self.strains(q)
        rate = v[self.dofs][:, None, :, None]
        normal = self.axial * (strain + self.damping * (d_strain[..., None, :] @ rate)[..., 0, 0])
        moment = self.bending * (curvature + self.damping * (d_curvature[..., None, :] @ rate)[..., 0, 0])
        parts = normal[..., None] * d_strain + moment[..., None] * d_curvature
        return -self.assembled(np.einsum("q,eqi->ei", self.weight, parts))

    def stiffness(self, q: np.ndarray) -> np.ndarray:
        """Its stiffness (size, size) without the part of the stresses, for Newton's method."""
        _, _, d_strain, d_curvature = self.strains(q)
        k = self.axial * np.einsum("q,eqi,eqj->eij", self.weight, d_strain, d_strain)
        return self.assembled(k + self.bending * np.einsum("q,eqi,eqj->eij", self.weight, d_curvature, d_curvature))


def deflection(beam: AbsoluteBeam, q: np.ndarray) -> np.ndarray:
    """Distance of the middle from the chord between the ends, positive along z x chord: q (..., size), even elements."""
    nodes = q.reshape(*q.shape[:-1], -1, 4)[..., :2]
    chord, middle = nodes[..., -1, :] - nodes[..., 0, :], nodes[..., beam.elements // 2, :] - nodes[..., 0, :]
    return (chord[..., 0] * middle[..., 1] - chord[..., 1] * middle[..., 0]) / np.linalg.norm(chord, axis=-1)


def motion(
    beam: AbsoluteBeam,
    start: tuple[np.ndarray, np.ndarray],
    held: list[int],
    path: Callable[[float], np.ndarray],
    times: np.ndarray,
    point_masses: dict[int, float] | None = None,
    rtol: float = 1e-8,
) -> np.ndarray:
    """Coordinates (len(times), size) over time.

    Parameters
    ----------
    beam : AbsoluteBeam
    start : (size,), (size,) arrays
        Coordinates and rates at the first time.
    held : list of int
        Coordinates that are prescribed.
    path : callable
        Their values, rates and accelerations (3, len(held)) at a time.
    times : (n,) array
    point_masses : dict, optional
        Masses on single coordinates [kg].
    rtol : float
        Of the integrator; lengths and gradients are of order 0.1 to 1.
    """
    mass = beam.mass.copy()
    for place, value in (point_masses or {}).items():
        mass[place, place] += value
    free = np.setdiff1d(np.arange(beam.size), held)
    inverse = np.linalg.inv(mass[np.ix_(free, free)])
    coupling = inverse @ mass[np.ix_(free, held)]
    n = len(free)

    def whole(t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        q, v = np.empty(beam.size), np.empty(beam.size)
        q[free], v[free] = y[:n], y[n:]
        q[held], v[held], acceleration = path(t)
        return q, v, acceleration

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        q, v, acceleration = whole(t, y)
        return np.concatenate([y[n:], inverse @ beam.forces(q, v)[free] - coupling @ acceleration])

    def jacobian(t: float, y: np.ndarray) -> np.ndarray:
        k = -inverse @ beam.stiffness(whole(t, y)[0])[np.ix_(free, free)]
        return np.block([[np.zeros((n, n)), np.eye(n)], [k, beam.damping * k]])

    y0 = np.concatenate([part[free] for part in start])
    found = solve_ivp(
        rates, times[[0, -1]], y0, "Radau", times, jac=jacobian, rtol=rtol, atol=rtol * np.repeat([1e-2, 1.0], n)
    )
    return np.array([whole(t, y)[0] for t, y in zip(found.t, found.y.T, strict=True)])
