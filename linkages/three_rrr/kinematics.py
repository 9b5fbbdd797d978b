"""Rigid kinematics of the 3-RRR robot, vectorised over poses.

Velocities and accelerations come from one row for each leg, d . (Cdot - Bdot) = 0 with d the unit vector
along the coupler. Unlike the paper's eq. (3), which inverts the Jacobian of each leg, the rows stay regular
where A, B and C align.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.three_rrr.geometry import Geometry

#: Crank angles, their rates and accelerations (N, 3) [rad, rad/s, rad/s2] at times (N,) [s].
CrankMotion = Callable[[Any], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class RobotMotion:
    """Rigid motion at N poses.

    Attributes
    ----------
    time : (N,) array
        Times [s].
    phi, dphi, ddphi : (N, 3) arrays
        Crank angles and their derivatives [rad, s].
    x, dx, ddx : (N, 3) arrays
        Platform (theta, x, y) and its derivatives [rad, m, s].
    psi, dpsi, ddpsi : (N, 3) arrays
        Coupler angles and their derivatives [rad, s].
    """

    time: Array
    phi: Array
    dphi: Array
    ddphi: Array
    x: Array
    dx: Array
    ddx: Array
    psi: Array
    dpsi: Array
    ddpsi: Array

    def __len__(self) -> int:
        return len(self.time)

    @property
    def angles(self) -> Array:
        """Angles (N, 7) of the bodies: phi_1, psi_1, phi_2, psi_2, phi_3, psi_3, theta [rad]."""
        return np.concatenate([legwise(self.phi, self.psi), self.x[:, :1]], axis=1)

    def part(self, index: slice | NDArray[np.int64]) -> RobotMotion:
        """Return the motion at some of its poses."""
        return RobotMotion(**{name: getattr(self, name)[index] for name in self.__dataclass_fields__})


def legwise(crank: Array, coupler: Array) -> Array:
    """Interleave values (N, 3) of the cranks and of the couplers, leg by leg: (N, 6)."""
    return np.stack([crank, coupler], axis=-1).reshape(len(crank), 6)


def turned(v: Array) -> Array:
    """Vectors (..., 2) turned by +90 degrees."""
    return np.stack([-v[..., 1], v[..., 0]], axis=-1)


def unit(angle: Array) -> Array:
    """Return unit vectors (..., 2) at the given angles."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def arms(geometry: Geometry, theta: Array) -> Array:
    """Vectors (N, 3, 2) from the platform's origin to C_r in plane axes [m]."""
    c, s = np.cos(theta)[:, None], np.sin(theta)[:, None]
    px, py = geometry.platform[:, 0], geometry.platform[:, 1]
    return np.stack([c * px - s * py, s * px + c * py], axis=-1)


def pivots(geometry: Geometry, phi: Array, x: Array) -> tuple[Array, Array]:
    """Positions (N, 3, 2) of B_r and C_r [m] for crank angles (N, 3) and platform positions (N, 3)."""
    b = geometry.base + geometry.crank[:, None] * unit(phi)
    return b, x[:, None, 1:] + arms(geometry, x[:, 0])


def loop_errors(geometry: Geometry, phi: Array, x: Array) -> Array:
    """Coupler lengths less their nominal values (N, 3) [m]: eq. (1), in metres."""
    b, c = pivots(geometry, phi, x)
    return np.linalg.norm(c - b, axis=-1) - geometry.coupler


def jacobians(geometry: Geometry, phi: Array, x: Array) -> tuple[Array, Array]:
    """Jacobians of the loops: Jx (N, 3, 3) and the diagonal Jq (N, 3) with Jx dx = Jq dphi.

    Jq_r = 0 is a type-1 singularity (A, B, C of leg r align), det Jx = 0 one of type 2.
    """
    b, c = pivots(geometry, phi, x)
    d = c - b
    d /= np.linalg.norm(d, axis=-1)[..., None]
    r = arms(geometry, x[:, 0])
    jx = np.concatenate([np.sum(d * turned(r), axis=-1)[..., None], d], axis=-1)
    jq = geometry.crank * np.sum(d * turned(unit(phi)), axis=-1)
    return jx, jq


def determinants(geometry: Geometry, phi: Array, x: Array) -> tuple[Array, Array]:
    """Return the dimensionless singularity measures: type 2 (N,) and type 1 (N, 3).

    Type 2 is det Jx over the platform's radius of gyration of pivots, type 1 the sine of the angle between
    crank and coupler; both lie in about [-1, 1] and vanish at the singularity.
    """
    jx, jq = jacobians(geometry, phi, x)
    return np.linalg.det(jx) / radius(geometry), jq / geometry.crank


def radius(geometry: Geometry) -> float:
    """Root mean square distance of the platform's pivots from their centroid [m]."""
    return float(np.sqrt(np.mean(np.sum((geometry.platform - geometry.platform.mean(0)) ** 2, axis=1))))


def newton(geometry: Geometry, phi: Array, x: Array, iterations: int = 12) -> tuple[Array, Array]:
    """Close the loops by Newton's method from a guess; returns x (N, 3), largest loop error (N,) [m]."""
    x = x.copy()
    best, error = x.copy(), np.full(len(x), np.inf)
    for _ in range(iterations):
        residual = loop_errors(geometry, phi, x)
        size = np.max(np.abs(residual), axis=1)
        better = size < error
        best[better], error[better] = x[better], size[better]
        if np.all(error <= 2e-16 * geometry.size) or not np.any(better):
            break
        jx, _ = jacobians(geometry, phi, x)
        x = x - solve_rows(jx, residual)
    return best, error


def solve_rows(matrix: Array, rhs: Array) -> Array:
    """Solve N systems of three by Cramer's rule; a singular one gives a long step, not an exception."""
    minors = np.stack([np.cross(matrix[:, (i + 1) % 3], matrix[:, (i + 2) % 3]) for i in range(3)], axis=-1)
    det = np.sum(matrix[:, 0] * minors[:, :, 0], axis=-1)
    det = np.where(np.abs(det) < 1e-300, 1e-300, det)
    return np.einsum("nij,nj->ni", minors, rhs) / det[:, None]


def motion(geometry: Geometry, time: Array, phi: Array, dphi: Array, ddphi: Array, x: Array) -> RobotMotion:
    """Complete motion for closed poses x (N, 3) and given drives (N, 3).

    Accelerations follow from d . (Cddot - Bddot) = -|Cdot - Bdot|^2 / l2 for each leg.
    """
    jx, jq = jacobians(geometry, phi, x)
    b, c = pivots(geometry, phi, x)
    d = c - b
    psi = np.arctan2(d[..., 1], d[..., 0])
    r, e, f = arms(geometry, x[:, 0]), unit(phi), unit(psi)

    def relative(platform: Array, crank: Array) -> Array:
        """Compute the velocity of C_r relative to B_r, or the tangential part of the acceleration."""
        moved = platform[:, None, 1:] + platform[:, :1, None] * turned(r)
        return moved - (geometry.crank * crank)[..., None] * turned(e)

    dx = np.asarray(np.linalg.solve(jx, (jq * dphi)[..., None])[..., 0], float)
    speed = relative(dx, dphi)
    centripetal = (geometry.crank * dphi**2)[..., None] * e - dx[:, :1, None] ** 2 * r
    bias = np.sum(speed**2, axis=-1) / geometry.coupler + np.sum(f * centripetal, axis=-1)
    ddx = np.asarray(np.linalg.solve(jx, (jq * ddphi - bias)[..., None])[..., 0], float)
    dpsi = np.sum(turned(f) * speed, axis=-1) / geometry.coupler
    ddpsi = np.sum(turned(f) * (relative(ddx, ddphi) + centripetal), axis=-1) / geometry.coupler
    return RobotMotion(time, phi, dphi, ddphi, x, dx, ddx, psi, dpsi, ddpsi)


def inverse(geometry: Geometry, x: Array, elbow: Array) -> Array:
    """Crank angles (N, 3) for platform positions (N, 3); NaN where a leg cannot reach.

    The elbows (3,) are +1 if B_r lies counter-clockwise of the line A_r C_r, else -1.
    """
    reach = x[:, None, 1:] + arms(geometry, x[:, 0]) - geometry.base
    distance = np.linalg.norm(reach, axis=-1)
    cosine = (distance**2 + geometry.crank**2 - geometry.coupler**2) / (2.0 * distance * geometry.crank)
    offset = np.arccos(np.where(np.abs(cosine) <= 1.0, cosine, np.nan))
    return np.arctan2(reach[..., 1], reach[..., 0]) + elbow * offset
