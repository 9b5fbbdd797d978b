"""Mass and stiffness matrices of the flexible robot for any pose, and the loads of its rigid motion.

With n elements in a link each leg has 6 n + 2 displacements: the rotation of the crank's root, (x, y, rotation) of the
crank's nodes, the coupler's rotation at B, (x, y, rotation) of the coupler's nodes. B is a node of the crank, C of the
coupler. With n = 1 these are the paper's eight (rotation at A; x and y of B; rotations of crank and coupler at B; x and
y of C; rotation at C), and the whole robot has its 24.

Every matrix is a sum of constant matrices times 1, cos, sin, cos^2 and cos sin of the seven body angles, so
matrices for many poses are one product of a table of these functions with a table of coefficients on the
sparsity pattern.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from linkages.base.arrays import Array
from linkages.mechanics.flexible.beam import Beam, chain_dofs
from linkages.mechanics.flexible.rotation import BEAM, TRIANGLE, functions, rotated, rotations
from linkages.mechanics.flexible.triangle import Triangle
from linkages.three_rrr.geometry import LEGS
from linkages.three_rrr.kinematics import RobotMotion, arms, legwise, motion, turned, unit
from linkages.three_rrr.robot import KINDS, Kind, Robot

Index = NDArray[np.int64]

_PLATFORM = 6  # place of theta among the seven angles (phi_1, psi_1, phi_2, psi_2, phi_3, psi_3, theta)


@dataclass(frozen=True)
class LinkElements:
    """The equal beam elements of one link."""

    name: str  # ``crank1`` and so on
    angle: int  # which of the seven angles is the link's
    beam: Beam  # one element
    dofs: Index  # (n, 6) places of each element's displacements among all of the robot's; -1 where the base holds them

    def gather(self, full: Array, rotation: Array) -> Array:
        """Displacements (N, n, 6) of each element in its own axes, from the robot's (N, full) in plane axes.

        The rotations (N, 6, 6) are from plane to element axes, see `linkages.mechanics.flexible.rotation.rotations`.
        """
        return np.einsum("nij,nej->nei", rotation, np.where(self.dofs < 0, 0.0, full[:, self.dofs]))


class FiniteElementModel:
    """Finite-element model of a robot, with n elements in a link; the unknowns are displacements [m, rad].

    Parameters
    ----------
    robot : Robot

    Attributes
    ----------
    geometry : Geometry
    count, leg, full : int
        Elements in a link, n; displacements of a leg, 6 n + 2; displacements with free roots, 3 (6 n + 2).
    size : int
        Number of unknowns: without locked roots, and with three for a rigid platform.
    kept : array of int
        Displacements among the unknowns.
    rigid : bool
        Whether the platform is rigid.
    roots, b, c : (3,), (3, 2), (3, 2) arrays of int
        Displacements of each leg: rotation of the root at A; x and y of B and of C.
    lengths : (6,) array
        Lengths of the links [m].
    links : tuple of LinkElements
        crank1, coupler1, and so on.
    triangle : Triangle
        Element of the platform.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.geometry = robot.geometry
        self.count = robot.model.elements
        self.leg = 6 * self.count + 2
        self.full = 3 * self.leg
        self.rigid = robot.model.platform == "rigid"
        self.roots = self.leg * np.arange(3)
        self.b = self.roots[:, None] + 3 * self.count - 2 + np.arange(2)
        self.c = self.roots[:, None] + 6 * self.count - 1 + np.arange(2)
        self.lengths = np.column_stack([self.geometry.crank, self.geometry.coupler]).ravel()
        self.links = tuple(self._link(kind, leg) for leg in range(3) for kind in KINDS)
        thickness, m = robot.sections.platform_thickness, robot.material
        self.triangle = Triangle(self.geometry.platform, thickness, m.youngs_modulus, m.poisson, m.density)
        dropped = self.roots if robot.drives.roots == "locked" else np.array([], dtype=int)
        if self.rigid:
            dropped = np.concatenate([dropped, self.c.ravel()])
        self.kept = np.setdiff1d(np.arange(self.full), dropped)
        self.size = len(self.kept) + (3 if self.rigid else 0)

    def _link(self, kind: Kind, leg: int) -> LinkElements:
        robot, n, start = self.robot, self.count, self.leg * leg
        area, inertia = robot.rod(kind)
        e, rho, nu = robot.material.youngs_modulus, robot.material.density, robot.material.poisson
        angle = 2 * leg + KINDS.index(kind)
        shear, rotary = np.inf, 0.0
        if robot.model.beam == "timoshenko":
            kappa = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)  # Cowper's coefficient of a round section
            shear, rotary = kappa * e / (2 + 2 * nu) * area, rho * inertia
        beam = Beam(float(self.lengths[angle]), e * area, e * inertia, rho * area, shear, rotary)
        first = [-1, -1, start] if kind == "crank" else [*self.b[leg], start + 3 * n + 1]
        dofs = np.append(first, first[2] + 1 + np.arange(3 * n))[chain_dofs(n)]
        return LinkElements(f"{kind}{LEGS[leg]}", angle, beam.piece(n), dofs)

    @cached_property
    def _pattern(self) -> tuple[Index, Index, Array, Array]:
        """Rows, columns (sorted) and the coefficients (29, nnz) of K and M on them."""
        bodies: list[tuple[Index, int, tuple[int, ...], Array, Array]] = [
            (link.dofs, link.angle, BEAM, link.beam.stiffness(), link.beam.mass()) for link in self.links
        ]
        stiffness = np.zeros((6, 6)) if self.rigid else self.triangle.stiffness()
        bodies.append((self.c.reshape(1, 6), _PLATFORM, TRIANGLE, stiffness, self.triangle.mass()))
        pairs = [np.broadcast_arrays(dofs[:, :, None], dofs[:, None]) for dofs, *_ in bodies]
        keys = [np.where((r < 0) | (c < 0), -1, r * self.full + c).reshape(-1, 36) for r, c in pairs]
        unique = np.unique(np.concatenate(keys))
        k_table, m_table = np.zeros((2, 29, len(unique)))
        for key, (_, angle, turning, k, m) in zip(keys, bodies, strict=True):
            rows = np.array([0, 1 + angle, 8 + angle, 15 + angle, 22 + angle])[:, None, None]
            at = rows, np.searchsorted(unique, key)
            np.add.at(k_table, at, rotated(k, turning).reshape(5, 1, 36))
            np.add.at(m_table, at, rotated(m, turning).reshape(5, 1, 36))
        keep = unique >= 0
        row, column = np.divmod(unique[keep], self.full)
        k_table, m_table = k_table[:, keep], m_table[:, keep]
        diagonal = np.searchsorted(unique[keep], np.arange(self.full) * (self.full + 1))
        m_table[0, diagonal[self.b.ravel()]] += self.robot.joint_masses.B
        m_table[0, diagonal[self.c.ravel()]] += self.robot.joint_masses.C
        if self.robot.drives.roots == "servo":
            k_table[0, diagonal[self.roots]] += self.robot.drives.servo_stiffness
        return row, column, k_table, m_table

    def full_matrices(self, state: RobotMotion) -> tuple[Array, Array]:
        """Stiffness and mass (N, full, full) with free roots and the platform's corners independent."""
        row, column, k_table, m_table = self._pattern
        table = functions(state.angles)
        k, m = np.zeros((2, len(state), self.full, self.full))
        k[:, row, column], m[:, row, column] = table @ k_table, table @ m_table
        return k, m

    def matrices(self, state: RobotMotion) -> tuple[Array, Array]:
        """Stiffness and mass (N, size, size), dense."""
        k, m = self.full_matrices(state)
        if self.rigid:
            g = self.reduction(state)
            transposed = np.swapaxes(g, 1, 2)
            return transposed @ k @ g, transposed @ m @ g
        grid = np.ix_(np.arange(len(state)), self.kept, self.kept)
        return k[grid], m[grid]

    def sparse_matrices(self, state: RobotMotion) -> Iterator[tuple[sparse.csc_matrix, sparse.csc_matrix]]:
        """Stiffness and mass of each pose as sparse matrices, one pose at a time."""
        row, column, k_table, m_table = self._pattern
        for n in range(len(state)):
            one = state.part(slice(n, n + 1))
            table = functions(one.angles)[0]
            g = sparse.csc_matrix(self.reduction(one)[0])
            k, m = (
                sparse.csr_matrix((table @ part, (row, column)), (self.full, self.full)) for part in (k_table, m_table)
            )
            yield (g.T @ k @ g).tocsc(), (g.T @ m @ g).tocsc()

    def reduction(self, state: RobotMotion) -> Array:
        """Matrices (N, full, size) that give all displacements from the unknowns."""
        g = np.zeros((len(state), self.full, self.size))
        g[:, self.kept, np.arange(len(self.kept))] = 1.0
        if self.rigid:
            r = turned(self.platform_arms(state))
            g[:, self.c, -3] = r
            g[:, self.c, [-2, -1]] = 1.0
        return g

    def platform_arms(self, state: RobotMotion) -> Array:
        """Vectors (N, 3, 2) from the platform's centre to its pivots [m]."""
        r = arms(self.geometry, state.x[:, 0])
        return r - r.mean(axis=1, keepdims=True)

    def rigid_velocity(self, state: RobotMotion) -> Array:
        """Velocities (N, full) of all nodes in the rigid motion."""
        return self._field(state, legwise(state.dphi, state.dpsi), np.zeros((len(state), 6)))

    def rigid_acceleration(self, state: RobotMotion) -> Array:
        """Accelerations (N, full) of all nodes in the rigid motion."""
        squares = legwise(state.dphi, state.dpsi) ** 2
        return self._field(state, legwise(state.ddphi, state.ddpsi), squares)

    def _field(self, state: RobotMotion, rates: Array, squares: Array) -> Array:
        """Velocities or accelerations of nodes, from the links' angular ones and squared speeds (N, 6)."""
        field, end = np.zeros((len(state), self.full)), np.zeros((len(state), 2))
        along = np.arange(1, self.count + 1)[:, None] / self.count
        for link, length in zip(self.links, self.lengths, strict=True):
            e, rate = unit(state.angles[:, link.angle]), rates[:, link.angle, None]
            start = end if link.angle % 2 else np.zeros_like(end)
            grown = length * (rate * turned(e) - squares[:, link.angle, None] * e)
            end = start + grown
            field[:, link.dofs[0, 2]] = rate[:, 0]
            field[:, link.dofs[:, 3:5]] = start[:, None] + along * grown[:, None]
            field[:, link.dofs[:, 5]] = rate
        return field

    def rigid_modes(self, state: RobotMotion) -> Array:
        """Nodal velocities (N, full, 3) for a unit speed of each crank: the rigid velocity space."""
        g, still = self.geometry, np.zeros_like(state.phi)
        motions = [motion(g, state.time, state.phi, still + speed, still, state.x) for speed in np.eye(3)]
        return np.stack([self.rigid_velocity(one) for one in motions], axis=-1)

    def full_load(self, state: RobotMotion) -> Array:
        """Inertia load -M a of the rigid motion and the platform's load, on all displacements (N, full).

        The rigid acceleration is linear along each rod and over the platform, which the shape functions
        represent exactly, so that the consistent load is the consistent mass times the nodal accelerations. The
        platform's translation and the sign are misprinted in section 2.2.
        """
        row, column, _, m_table = self._pattern
        data = (functions(state.angles) @ m_table) * self.rigid_acceleration(state)[:, column]
        starts = np.searchsorted(row, np.arange(self.full))
        load = -np.add.reduceat(data, starts, axis=1)
        force, moment = np.array(self.robot.load.force), self.robot.load.moment
        r = self.platform_arms(state)
        share = self._at() * force + moment * turned(r) / np.sum(r**2, axis=(1, 2))[:, None, None]
        load[:, self.c.ravel()] += share.reshape(len(state), 6)
        return load

    def _at(self) -> Array:
        """Shape functions (3, 1) of the triangle where the platform's force acts."""
        point = self.robot.load.at
        corners = self.geometry.platform
        place = corners.mean(axis=0) if point is None else np.array(point)
        return np.linalg.solve(np.vstack([np.ones(3), corners.T]), np.append(1.0, place))[:, None]

    def load(self, state: RobotMotion) -> Array:
        """Load on the unknowns (N, size)."""
        load = self.full_load(state)
        if not self.rigid:
            return load[:, self.kept]
        return np.einsum("nfs,nf->ns", self.reduction(state), load)

    def expand(self, state: RobotMotion, unknowns: Array) -> Array:
        """All displacements (N, full) from the unknowns (N, size)."""
        if not self.rigid:
            result = np.zeros((len(unknowns), self.full))
            result[:, self.kept] = unknowns
            return result
        return np.einsum("nfs,ns->nf", self.reduction(state), unknowns)

    def platform_displacement(self, state: RobotMotion, unknowns: Array) -> Array:
        """Elastic displacement (N, 3) of the platform: x, y of its centre [m], mean rotation [rad]."""
        corners = self.expand(state, unknowns)[:, self.c.ravel()].reshape(-1, 3, 2)
        r = self.platform_arms(state)
        angle = np.sum(turned(r) * corners, axis=(1, 2)) / np.sum(r**2, axis=(1, 2))
        return np.column_stack([corners.mean(axis=1), angle])

    def drive_torques(self, state: RobotMotion) -> Array:
        """Torques (N, 3) of the drives in the rigid motion [N m], by virtual power of the loads."""
        return -np.einsum("nfr,nf->nr", self.rigid_modes(state), self.full_load(state))


def velocity_terms(
    model: FiniteElementModel, state: RobotMotion, tension_from: Array | None = None
) -> tuple[Array, Array]:
    """Matrices G and K_c + K_g (N, size, size) of M U'' + G U' + (K + K_c + K_g) U = F; the paper has none of them.

    G, gyroscopic, and K_c, centrifugal, come from the rotation of the rods, see
    `linkages.mechanics.flexible.beam.Beam.velocity_terms`. The triangle's shapes are alike along x and y: it has no
    such terms. The geometric stiffness K_g follows from the axial forces of displacements (N, size), usually the
    quasi-static ones; without them it is left out.
    """
    count = len(state)
    gyro, stiff = np.zeros((2, count, model.full, model.full))
    speed, rate = legwise(state.dphi, state.dpsi), legwise(state.ddphi, state.ddpsi)
    full = None if tension_from is None else model.expand(state, tension_from)
    for link in model.links:
        rotation = rotations(state.angles[:, link.angle])
        back = np.swapaxes(rotation, 1, 2)
        once, twice = (back @ matrix @ rotation for matrix in link.beam.velocity_terms())
        omega, alpha = speed[:, link.angle, None, None], rate[:, link.angle, None, None]
        stretch = back @ link.beam.geometric_stiffness() @ rotation
        u = None if full is None else link.gather(full, rotation)
        for index, dofs in enumerate(link.dofs):
            held = dofs >= 0
            at = np.ix_(np.arange(count), dofs[held], dofs[held])
            inside = np.ix_(np.arange(count), held, held)
            gyro[at] += (2.0 * omega * once)[inside]
            stiff[at] += (alpha * once + omega**2 * twice)[inside]
            if u is not None:
                tension = link.beam.axial / link.beam.length * (u[:, index, 3] - u[:, index, 0])
                stiff[at] += (tension[:, None, None] * stretch)[inside]
    return _reduced(model, state, gyro, stiff)


def _reduced(model: FiniteElementModel, state: RobotMotion, gyro: Array, stiff: Array) -> tuple[Array, Array]:
    """Assemble the matrices of the unknowns; the arms of a rigid platform rotate with it and add terms."""
    if not model.rigid:
        grid = np.ix_(np.arange(len(state)), model.kept, model.kept)
        return gyro[grid], stiff[grid]
    _, mass = model.full_matrices(state)
    g = model.reduction(state)
    r = model.platform_arms(state)
    once, twice = np.zeros_like(g), np.zeros_like(g)
    once[:, model.c, -3] = -r
    twice[:, model.c, -3] = -turned(r)
    omega, alpha = state.dx[:, 0, None, None], state.ddx[:, 0, None, None]
    back = np.swapaxes(g, 1, 2)
    first, second = omega * once, alpha * once + omega**2 * twice
    return back @ (2.0 * mass @ first + gyro @ g), back @ (mass @ second + gyro @ first + stiff @ g)
