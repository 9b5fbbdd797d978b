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

from linkages.flexible import Array
from linkages.flexible.beam import Beam, chain_dofs
from linkages.flexible.rotation import BEAM, TRIANGLE, functions, rotated
from linkages.flexible.triangle import Triangle
from linkages.three_rrr.geometry import LEGS
from linkages.three_rrr.kinematics import Motion, arms, motion, turned, unit
from linkages.three_rrr.robot import KINDS, Kind, Robot

Index = NDArray[np.int64]

_PLATFORM = 6  # place of theta among the seven angles (phi_1, psi_1, phi_2, psi_2, phi_3, psi_3, theta)


@dataclass(frozen=True)
class LinkElements:
    """The equal beam elements of one link.

    Attributes
    ----------
    name : str
        ``crank1`` and so on.
    angle : int
        Which of the seven angles is the link's.
    beam : Beam
        One element.
    dofs : (n, 6) array
        Places of each element's displacements among all of the robot's; -1 where the base holds them.
    """

    name: str
    angle: int
    beam: Beam
    dofs: Index

    def gather(self, full: Array, rotation: Array) -> Array:
        """Displacements (N, n, 6) of each element in its own axes.

        Parameters
        ----------
        full : (N, full) array
            Displacements of the whole robot, or their derivatives, in plane axes.
        rotation : (N, 6, 6) array
            From plane to element axes, see `linkages.flexible.rotation.rotations`.
        """
        return np.einsum("nij,nej->nei", rotation, np.where(self.dofs < 0, 0.0, full[:, self.dofs]))


class FiniteElementModel:
    """Finite-element model of a robot.

    Attributes
    ----------
    full : int
        Number of displacements with free roots: 3 (6 n + 2).
    size : int
        Number of unknowns: without locked roots, and with three for a rigid platform.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.geometry = robot.geometry
        self.count = robot.model.elements
        self.leg = 6 * self.count + 2
        self.full = 3 * self.leg
        self.rigid = robot.model.platform == "rigid"
        self.roots = self.leg * np.arange(3)
        base = self.leg * np.arange(3)[:, None]
        self.b = base + 3 * self.count - 2 + np.array([0, 1])
        self.c = base + 6 * self.count - 1 + np.array([0, 1])
        self.links = tuple(self._link(kind, leg) for leg in range(3) for kind in KINDS)
        material = robot.material
        self.triangle = Triangle(
            self.geometry.platform,
            robot.sections.platform_thickness,
            material.youngs_modulus,
            material.poisson,
            material.density,
        )
        dropped = self.roots if robot.drives.roots == "locked" else np.array([], dtype=int)
        if self.rigid:
            dropped = np.concatenate([dropped, self.c.ravel()])
        self.kept = np.setdiff1d(np.arange(self.full), dropped)
        self.size = len(self.kept) + (3 if self.rigid else 0)

    def _link(self, kind: Kind, leg: int) -> LinkElements:
        robot, n, start = self.robot, self.count, self.leg * leg
        area, inertia = robot.rod(kind)
        e, rho, nu = robot.material.youngs_modulus, robot.material.density, robot.material.poisson
        length = float((self.geometry.crank if kind == "crank" else self.geometry.coupler)[leg])
        shear, rotary = np.inf, 0.0
        if robot.model.beam == "timoshenko":
            kappa = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)  # Cowper's coefficient of a round section
            shear, rotary = kappa * e / (2 + 2 * nu) * area, rho * inertia
        beam = Beam(length, e * area, e * inertia, rho * area, shear, rotary)
        inner = np.arange(3 * n).reshape(n, 3)
        if kind == "crank":
            nodes = np.vstack([[-1, -1, start], start + 1 + inner])
        else:
            end_b = start + 3 * n - 2
            nodes = np.vstack([[end_b, end_b + 1, start + 3 * n + 1], start + 3 * n + 2 + inner])
        dofs = nodes.ravel()[chain_dofs(n)]
        return LinkElements(f"{kind}{LEGS[leg]}", 2 * leg + KINDS.index(kind), beam.piece(n), dofs)

    # -- matrices ----------------------------------------------------------------------------------

    @cached_property
    def _pattern(self) -> tuple[Index, Index, Array, Array]:
        """Rows, columns (sorted) and the coefficients (29, nnz) of K and M on them."""
        entries: list[tuple[Index, Index, int, Array, Array]] = []
        for link in self.links:
            k, m = rotated(link.beam.stiffness(), BEAM), rotated(link.beam.mass(), BEAM)
            for dofs in link.dofs:
                entries.append((*_grid(dofs), link.angle, k.reshape(5, 36), m.reshape(5, 36)))
        k = rotated(self.triangle.stiffness() * (0.0 if self.rigid else 1.0), TRIANGLE)
        m = rotated(self.triangle.mass(), TRIANGLE)
        entries.append((*_grid(self.c.ravel()), _PLATFORM, k.reshape(5, 36), m.reshape(5, 36)))
        key = np.concatenate([np.where((r < 0) | (c < 0), -1, r * self.full + c) for r, c, *_ in entries])
        unique, place = np.unique(key, return_inverse=True)
        k_table, m_table = np.zeros((29, len(unique))), np.zeros((29, len(unique)))
        for index, (_, _, angle, k, m) in enumerate(entries):
            at = place[36 * index : 36 * index + 36]
            rows = np.array([0, 1 + angle, 8 + angle, 15 + angle, 22 + angle])
            np.add.at(k_table, (rows[:, None], at), k)
            np.add.at(m_table, (rows[:, None], at), m)
        keep = unique >= 0
        row, column = np.divmod(unique[keep], self.full)
        k_table, m_table = k_table[:, keep], m_table[:, keep]
        diagonal = np.searchsorted(unique[keep], np.arange(self.full) * (self.full + 1))
        m_table[0, diagonal[self.b.ravel()]] += self.robot.joint_masses.B
        m_table[0, diagonal[self.c.ravel()]] += self.robot.joint_masses.C
        if self.robot.drives.roots == "servo":
            k_table[0, diagonal[self.roots]] += self.robot.drives.servo_stiffness
        return row, column, k_table, m_table

    def full_matrices(self, state: Motion) -> tuple[Array, Array]:
        """Stiffness and mass (N, full, full) with free roots and the platform's corners independent."""
        row, column, *tables = self._pattern
        table = functions(state.angles)
        result = []
        for coefficients in tables:
            matrix = np.zeros((len(state), self.full, self.full))
            matrix[:, row, column] = table @ coefficients
            result.append(matrix)
        return result[0], result[1]

    def matrices(self, state: Motion) -> tuple[Array, Array]:
        """Stiffness and mass (N, size, size), dense."""
        k, m = self.full_matrices(state)
        if self.rigid:
            g = self.reduction(state)
            transposed = np.swapaxes(g, 1, 2)
            return transposed @ k @ g, transposed @ m @ g
        if self.size == self.full:
            return k, m
        grid = np.ix_(np.arange(len(state)), self.kept, self.kept)
        return k[grid], m[grid]

    def sparse_matrices(self, state: Motion) -> Iterator[tuple[sparse.csc_matrix, sparse.csc_matrix]]:
        """Stiffness and mass of each pose as sparse matrices, one pose at a time."""
        row, column, k_table, m_table = self._pattern
        for n in range(len(state)):
            one = state.part(slice(n, n + 1))
            table = functions(one.angles)[0]
            g = sparse.csc_matrix(self.reduction(one)[0])
            pair = []
            for coefficients in (k_table, m_table):
                matrix = sparse.csr_matrix((table @ coefficients, (row, column)), (self.full, self.full))
                pair.append((g.T @ matrix @ g).tocsc())
            yield pair[0], pair[1]

    def reduction(self, state: Motion) -> Array:
        """Matrices (N, full, size) that give all displacements from the unknowns."""
        g = np.zeros((len(state), self.full, self.size))
        g[:, self.kept, np.arange(len(self.kept))] = 1.0
        if self.rigid:
            r = turned(self.platform_arms(state))
            for axis in range(2):
                g[:, self.c[:, axis], -3] = r[..., axis]
                g[:, self.c[:, axis], -2 + axis] = 1.0
        return g

    def platform_arms(self, state: Motion) -> Array:
        """Vectors (N, 3, 2) from the platform's centre to its pivots [m]."""
        r = arms(self.geometry, state.x[:, 0])
        return r - r.mean(axis=1, keepdims=True)

    # -- fields ------------------------------------------------------------------------------------

    def rigid_velocity(self, state: Motion) -> Array:
        """Velocities (N, full) of all nodes in the rigid motion."""
        return self._field(state, state.dphi, state.dpsi)

    def rigid_acceleration(self, state: Motion) -> Array:
        """Accelerations (N, full) of all nodes in the rigid motion."""
        return self._field(state, state.ddphi, state.ddpsi, centripetal=True)

    def _field(self, state: Motion, crank: Array, coupler: Array, centripetal: bool = False) -> Array:
        """Velocities or accelerations of all nodes from the angular ones (N, 3) of cranks and couplers."""
        g, n = self.geometry, self.count
        field = np.zeros((len(state), self.full))
        along = np.arange(1, n + 1) / n
        for r in range(3):
            start = np.zeros((len(state), 2))
            base = self.leg * r
            for length, angle, speed, rate, place in (
                (g.crank[r], state.phi[:, r], state.dphi[:, r], crank[:, r], base),
                (g.coupler[r], state.psi[:, r], state.dpsi[:, r], coupler[:, r], base + 3 * n + 1),
            ):
                e = unit(angle)
                end = length * rate[:, None] * turned(e)
                if centripetal:
                    end = end - length * (speed**2)[:, None] * e
                nodes = np.empty((len(state), n, 3))
                nodes[:, :, :2] = start[:, None] + along[:, None] * end[:, None]
                nodes[:, :, 2] = rate[:, None]
                field[:, place] = rate
                field[:, place + 1 : place + 1 + 3 * n] = nodes.reshape(len(state), -1)
                start = start + end
        return field

    def rigid_modes(self, state: Motion) -> Array:
        """Nodal velocities (N, full, 3) for a unit speed of each crank: the rigid velocity space."""
        columns = []
        for r in range(3):
            speed = np.zeros_like(state.phi)
            speed[:, r] = 1.0
            one = motion(self.geometry, state.time, state.phi, speed, np.zeros_like(speed), state.x)
            columns.append(self.rigid_velocity(one))
        return np.stack(columns, axis=-1)

    def full_load(self, state: Motion) -> Array:
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
        share = force / 3.0 + moment * turned(r) / np.sum(r**2, axis=(1, 2))[:, None, None]
        load[:, self.c.ravel()] += share.reshape(len(state), 6)
        return load

    def load(self, state: Motion) -> Array:
        """Load on the unknowns (N, size)."""
        return self.restrict(state, self.full_load(state))

    def restrict(self, state: Motion, load: Array) -> Array:
        """Load on the unknowns (N, size) from one on all displacements (N, full)."""
        if not self.rigid:
            return load[:, self.kept]
        return np.einsum("nfs,nf->ns", self.reduction(state), load)

    def expand(self, state: Motion, unknowns: Array) -> Array:
        """All displacements (N, full) from the unknowns (N, size)."""
        if not self.rigid:
            result = np.zeros((len(unknowns), self.full))
            result[:, self.kept] = unknowns
            return result
        return np.einsum("nfs,ns->nf", self.reduction(state), unknowns)

    def platform_displacement(self, state: Motion, unknowns: Array) -> Array:
        """Elastic displacement (N, 3) of the platform: x, y of its centre [m], mean rotation [rad]."""
        corners = self.expand(state, unknowns)[:, self.c.ravel()].reshape(-1, 3, 2)
        r = self.platform_arms(state)
        angle = np.sum(turned(r) * corners, axis=(1, 2)) / np.sum(r**2, axis=(1, 2))
        return np.column_stack([corners.mean(axis=1), angle])

    def drive_torques(self, state: Motion) -> Array:
        """Torques (N, 3) of the drives in the rigid motion [N m], by virtual power of the loads."""
        return -np.einsum("nfr,nf->nr", self.rigid_modes(state), self.full_load(state))


def _grid(dofs: Index) -> tuple[Index, Index]:
    row, column = np.meshgrid(dofs, dofs, indexing="ij")
    return row.ravel(), column.ravel()
