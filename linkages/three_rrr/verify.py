"""Comparison of the kinematics and the finite-element model with Drake's rigid plant.

Drake's plant is the mechanism's spanning tree, from the SDFormat file, with the loops' joints cut. Its
loops are closed here with Drake's own positions, Jacobians and bias accelerations, independently of
`linkages.three_rrr.kinematics`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces
from scipy.linalg import subspace_angles

from linkages.base.arrays import Array
from linkages.engines.drake.plant import add_tree
from linkages.input.model.mechanism import load_mechanism
from linkages.system.spanning import spanning_tree
from linkages.three_rrr.finite_elements import FiniteElementModel
from linkages.three_rrr.geometry import LEGS, drawn_angles
from linkages.three_rrr.kinematics import RobotMotion
from linkages.three_rrr.robot import Robot, changed

_V = JacobianWrtVariable.kV
_RANK = 1e-9  # scaled stiffness eigenvalues below this fraction of the largest count as zero
#: Largest differences that are round-off: of the modal quantities, which are ratios, and of the motion and the torques,
#: per unit of the largest magnitude compared where that is above one.
_LIMITS = dict.fromkeys(("zero_eigenvalue", "principal_angle", "mass_error"), 1e-10) | dict.fromkeys(
    ("position", "velocity", "acceleration", "torque"), 1e-9
)
_ZERO_MODES = 3


@dataclass(frozen=True)
class Verification:
    """Largest differences between this package and Drake over some poses."""

    zero_modes: int  # zero modes of the model with free roots; three are right. The worst count over the poses
    # largest |x' K x| of the rigid velocity space over the largest eigenvalue of K (scaled displacements)
    zero_eigenvalue: float
    principal_angle: float  # largest angle between the zero modes and Drake's rigid velocities [rad]
    mass_error: float  # largest relative difference of the projected mass matrices
    position: float  # largest difference, platform and couplers [rad, m]
    velocity: float
    acceleration: float
    torque: float  # of the drives [N m]
    poses: int  # number of poses compared
    # quantities above their limits: one line each, with value and limit; empty if the comparison passes
    failed: tuple[str, ...]


class RigidPlant:
    """Drake's plant of the robot, with the loops closed by Newton's method."""

    def __init__(self, robot: Robot) -> None:
        mechanism = load_mechanism(robot.mechanism_path, robot.rigid_properties())
        drives = [f"A{leg}" for leg in LEGS]
        self.tree = spanning_tree(mechanism, (), drives)
        self.plant: Any = MultibodyPlant(0.0)
        instance = add_tree(self.plant, self.tree)
        self.plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
        self.plant.Finalize()
        self.context: Any = self.plant.CreateDefaultContext()
        joints = [self.plant.GetJointByName(name, instance) for name in self.tree.coordinates]
        self.order = np.array([joint.velocity_start() for joint in joints])
        self.driven = self.order[[self.tree.coordinates.index(name) for name in drives]]
        self.free = np.setdiff1d(np.arange(self.plant.num_velocities()), self.driven)
        self.basis = mechanism.basis
        self.drawn = drawn_angles(mechanism)
        self.link_angle = {link.name: link.angle for link in mechanism.links}
        self.world = self.plant.world_frame()
        joints = [mechanism.joint[name] for name in self.tree.loops]
        self.cuts = [
            ((j.parent, self._point(j.parent, j.on_parent)), (j.child, self._point(j.child, j.on_child)))
            for j in joints
        ]

    def _frame(self, link: str) -> Any:
        return self.plant.world_frame() if link == "world" else self.plant.GetFrameByName(link)

    def _point(self, link: str, drawn: Array) -> Array:
        """Return a drawn point in the link's frame."""
        body = self.tree.links[link]
        return body.rotation.T @ (self.tree.basis[:, :2] @ (drawn - body.origin))

    def position(self, link: str, point: Array) -> Array:
        """Plane position (2,) of a point of a link [m]."""
        where = self.plant.CalcPointsPositions(self.context, self._frame(link), point, self.world)[:, 0]
        return self.basis[:, :2].T @ where

    def jacobian(self, link: str, point: Array) -> Array:
        """Plane velocity of a point of a link and its angular velocity per generalised velocity (3, 7)."""
        frame = self._frame(link)
        j = self.plant.CalcJacobianSpatialVelocity(self.context, _V, frame, point, self.world, self.world)
        return np.vstack([self.basis[:, :2].T @ j[3:], self.basis[:, 2] @ j[:3]])

    def bias(self, link: str, point: Array) -> Array:
        """Plane and angular acceleration (3,) of a point at zero generalised accelerations."""
        frame = self._frame(link)
        a = self.plant.CalcBiasSpatialAcceleration(self.context, _V, frame, point, self.world, self.world)
        return np.append(self.basis[:, :2].T @ a.translational(), self.basis[:, 2] @ a.rotational())

    def angle(self, link: str) -> float:
        """Absolute angle of a link's x axis [rad]."""
        x_axis = self.plant.GetBodyByName(link).EvalPoseInWorld(self.context).rotation().matrix()[:, 0]
        return float(np.arctan2(self.basis[:, 1] @ x_axis, self.basis[:, 0] @ x_axis))

    def _loops(self) -> tuple[Array, Array, Array]:
        """Gaps (m,), their Jacobian (m, 7) and bias accelerations (m,) of the cut joints."""
        gaps = [self.position(*child) - self.position(*parent) for parent, child in self.cuts]
        rows = [(self.jacobian(*child) - self.jacobian(*parent))[:2] for parent, child in self.cuts]
        biases = [(self.bias(*child) - self.bias(*parent))[:2] for parent, child in self.cuts]
        return np.concatenate(gaps), np.vstack(rows), np.concatenate(biases)

    def solve(self, phi: Array, dphi: Array, ddphi: Array, guess: dict[str, float]) -> tuple[Array, Array]:
        """Close the loops; sets the context, returns generalised velocities and accelerations (7,) each.

        Newton's method starts from a guessed angle of each coupler and the platform [rad].
        """
        q = np.zeros(self.plant.num_positions())
        q[self.driven] = phi - self.drawn
        angles = guess | {f"crank{leg}": phi[leg - 1] for leg in LEGS}
        turn = {link: angle - self.link_angle[link] for link, angle in angles.items()}
        for name, place in zip(self.tree.coordinates, self.order, strict=True):
            if place not in self.driven:
                joint = self.tree.joints[name]
                q[place] = joint.sign * (turn[joint.child] - turn[joint.parent])
        for _ in range(20):
            self.plant.SetPositions(self.context, q)
            gap, rows, _ = self._loops()
            step = np.linalg.solve(rows[:, self.free], -gap)
            q[self.free] += step
            if np.max(np.abs(step)) < 1e-15:
                break
        self.plant.SetPositions(self.context, q)
        space = self.velocity_space()
        v, a = space @ dphi, space @ ddphi
        self.plant.SetVelocities(self.context, v)
        _, rows, bias = self._loops()
        a[self.free] -= np.linalg.solve(rows[:, self.free], bias)
        return v, a

    def velocity_space(self) -> Array:
        """Generalised velocities (7, 3) for a unit speed of each drive."""
        _, rows, _ = self._loops()
        space = np.zeros((rows.shape[1], 3))
        space[self.driven] = np.eye(3)
        space[self.free] = np.linalg.solve(rows[:, self.free], -rows[:, self.driven])
        return space

    def drive_torques(self, a: Array) -> Array:
        """Torques (3,) of the drives from Drake's inverse dynamics, the loops' reactions eliminated [N m]."""
        tau = self.plant.CalcInverseDynamics(self.context, a, MultibodyForces(self.plant))
        return self.velocity_space().T @ tau

    def nodal_jacobian(self, model: FiniteElementModel) -> Array:
        """Velocities (full, 7) of the model's nodes per generalised velocity, from Drake's Jacobians."""
        result = np.zeros((model.full, self.plant.num_velocities()))
        joint = self.tree.joints
        for link, length in zip(model.links, model.lengths, strict=True):
            leg, coupler = divmod(link.angle, 2)
            root, end = joint[f"{'AB'[coupler]}{LEGS[leg]}"], joint[f"{'BC'[coupler]}{LEGS[leg]}"]
            start = self._point(link.name, root.on_child)
            axis = (self._point(link.name, end.on_parent) - start) / length
            result[link.dofs[0, 2]] = self.jacobian(link.name, start)[2]
            for node, dofs in enumerate(link.dofs[:, 3:], 1):
                result[dofs] = self.jacobian(link.name, start + axis * length * node / model.count)
        return result


def verify(robot: Robot, state: RobotMotion) -> Verification:
    """Compare with Drake at the given poses; the model is the robot's with free roots."""
    free = changed(robot, drives={"roots": "free"}, model={"platform": "triangle", "beam": "euler-bernoulli"})
    model = FiniteElementModel(free)
    plant = RigidPlant(robot)
    unloaded = FiniteElementModel(changed(free, load={"force": [0.0, 0.0], "moment": 0.0}))
    torques = unloaded.drive_torques(state)
    counts: list[int] = []
    worst: dict[str, float] = {}
    for n in range(len(state)):
        guess = {f"coupler{leg}": float(state.psi[n, leg - 1]) for leg in LEGS}
        guess["platform"] = float(state.x[n, 0])
        v, a = plant.solve(state.phi[n], state.dphi[n], state.ddphi[n], guess)
        found = _kinematics(plant, state, n, v, a)
        found["torque"] = _largest(plant.drive_torques(a) - torques[n])
        count, modal = _modal(plant, model, state.part(slice(n, n + 1)))
        counts.append(count)
        worst = {key: max(worst.get(key, 0.0), value) for key, value in (found | modal).items()}
    count = max(counts, key=lambda c: abs(c - _ZERO_MODES))
    scales = {
        "velocity": max(_largest(state.dx), _largest(state.dpsi)),
        "acceleration": max(_largest(state.ddx), _largest(state.ddpsi)),
        "torque": _largest(torques),
    }
    return Verification(zero_modes=count, poses=len(state), failed=_failures(count, worst, scales), **worst)


def _failures(count: int, worst: dict[str, float], scales: dict[str, float]) -> tuple[str, ...]:
    """List the quantities above their limits; a value that is not a number is above any."""
    limits = {name: limit * max(1.0, scales.get(name, 1.0)) for name, limit in _LIMITS.items()}
    lines = [f"zero_modes is {count}; it must be {_ZERO_MODES}"] if count != _ZERO_MODES else []
    above = [name for name, limit in limits.items() if not worst[name] <= limit]
    return (*lines, *(f"{name} is {worst[name]:.3g}; it must be at most {limits[name]:.3g}" for name in above))


def _kinematics(plant: RigidPlant, state: RobotMotion, n: int, v: Array, a: Array) -> dict[str, float]:
    """Largest differences of position, velocity and acceleration at one pose."""
    links, origin = [*(f"coupler{leg}" for leg in LEGS), "platform"], np.zeros(3)
    jacobians = [plant.jacobian(link, origin) for link in links]
    biases = [plant.bias(link, origin) for link in links]
    rows = np.vstack([*(j[2] for j in jacobians), jacobians[-1][:2]])
    bias = np.array([*(b[2] for b in biases), *biases[-1][:2]])
    angles = [plant.angle(link) for link in links]
    turn = np.angle(np.exp(1j * (angles - np.append(state.psi[n], state.x[n, 0]))))
    return {
        "position": max(_largest(turn), _largest(plant.position("platform", origin) - state.x[n, 1:])),
        "velocity": _largest(rows @ v - np.append(state.dpsi[n], state.dx[n])),
        "acceleration": _largest(rows @ a + bias - np.append(state.ddpsi[n], state.ddx[n])),
    }


def _modal(plant: RigidPlant, model: FiniteElementModel, state: RobotMotion) -> tuple[int, dict[str, float]]:
    """Count the zero modes; stiffness of the rigid space, principal angle and mass error at one pose.

    Displacements are scaled by the square roots of the stiffness diagonal, so that lengths and angles
    compare.
    """
    k, m = (matrix[0] for matrix in model.full_matrices(state))
    scale = 1.0 / np.sqrt(np.diag(k))
    scaled = scale[:, None] * k * scale
    values, vectors = np.linalg.eigh(scaled)
    count = int(np.sum(np.abs(values) < _RANK * values[-1]))
    space = plant.velocity_space()
    rigid = plant.nodal_jacobian(model) @ space
    unit, _ = np.linalg.qr(rigid / scale[:, None])
    softness = _largest(unit.T @ scaled @ unit) / float(values[-1])
    kernel = vectors[:, np.argsort(np.abs(values))[:3]] * scale[:, None]
    energy = np.linalg.cholesky(m).T  # measured by kinetic energy the angle does not depend on units
    angle = float(np.max(subspace_angles(energy @ kernel, energy @ rigid)))
    drake = space.T @ plant.plant.CalcMassMatrix(plant.context) @ space
    mass = _largest(rigid.T @ m @ rigid - drake) / _largest(drake)
    return count, {"zero_eigenvalue": softness, "principal_angle": angle, "mass_error": mass}


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values)))
