"""The clearance joints as a Drake system."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, LeafSystem, OutputPort

from linkages.planar.dynamics import CLEARANCE_OUTPUTS, clearance_forces
from linkages.planar.topology import Tree

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Entries of each joint's block of the output port "joints".
JOINT_OUTPUTS = (*CLEARANCE_OUTPUTS, "eccentricity_ratio", "attitude")


class ClearanceJoints(LeafSystem):
    """Forces of all clearance joints, from the plant's state.

    Ports
    -----
    state : input, (nx,)
        State [q; v] of the plant.
    generalized_force : output, (nv,)
        For the plant's applied generalised forces [N m, N].
    joints : output, (7 nj,)
        For each joint `JOINT_OUTPUTS`: eccentricity vector ex, ey [m]; force on the journal fx, fy [N] and
        couple on it [N m]; eccentricity ratio [1]; attitude angle of the eccentricity [rad]. Plane axes.

    evaluation : output, (nv + 5 nj,)
        Generalised forces, then `CLEARANCE_OUTPUTS` of each joint: what `Drives` reads, a callback cheaper than
        ``generalized_force``.

    The laws are evaluated once for each state: the other ports read the cached value of ``evaluation``.

    Parameters
    ----------
    tree : Tree
    laws : array of `linkages.laws.PARAMETERS`
        One record for each joint of ``tree.play``.
    positions, velocities : arrays of int
        Where the tree's coordinates stand in the plant's state; see `linkages.drake.plant.state_indices`.
    num_positions, num_velocities : int
        Of the whole plant.
    """

    def __init__(
        self,
        tree: Tree,
        laws: NDArray[np.record],
        positions: Indices,
        velocities: Indices,
        num_positions: int,
        num_velocities: int,
    ) -> None:
        super().__init__()
        self.set_name("clearance_joints")
        self.joints = tree.play
        self._bodies, self._ends, self._laws = tree.bodies, tree.ends, laws
        self._q, self._v, self._into = positions, num_positions + velocities, velocities
        self._size = num_velocities
        self._state = self.DeclareVectorInputPort("state", num_positions + num_velocities)
        needs = {self.input_port_ticket(self._state.get_index())}
        self._evaluation = self.DeclareVectorOutputPort(
            "evaluation",
            num_velocities + len(CLEARANCE_OUTPUTS) * len(tree.play),
            self._evaluate,
            needs,
        )
        self._force = self.DeclareVectorOutputPort(
            "generalized_force", num_velocities, self._give_force, needs
        )
        self._joints = self.DeclareVectorOutputPort(
            "joints", len(JOINT_OUTPUTS) * len(tree.play), self._give_joints, needs
        )

    def get_evaluation_output_port(self) -> OutputPort:
        """Output port ``evaluation``."""
        return self._evaluation

    def get_force_output_port(self) -> OutputPort:
        """Output port ``generalized_force``."""
        return self._force

    def get_joints_output_port(self) -> OutputPort:
        """Output port ``joints``."""
        return self._joints

    def evaluate(self, context: Context) -> Array:
        """``CLEARANCE_OUTPUTS`` of each joint, (nj, 5)."""
        joints: Array = self._evaluation.Eval(context)[self._size :].reshape(-1, len(CLEARANCE_OUTPUTS))
        return joints

    def _evaluate(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(
            clearance_forces(
                self._bodies,
                self._ends,
                self._laws,
                self._state.Eval(context),
                self._q,
                self._v,
                self._into,
                self._size,
            )
        )

    def _give_force(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._evaluation.Eval(context)[: self._size])

    def _give_joints(self, context: Context, output: BasicVector) -> None:
        joints = self.evaluate(context)
        eccentricity = np.hypot(joints[:, 0], joints[:, 1])
        extra = eccentricity / self._laws["clearance"], np.arctan2(joints[:, 1], joints[:, 0])
        output.SetFromVector(np.column_stack([joints, *extra]).ravel())
