"""Drives, closing joints and applied loads as a Drake system."""

from __future__ import annotations

from functools import partial

import numpy as np
from pydrake.systems.framework import BasicVector, Context, ContinuousState, LeafSystem, OutputPort

from linkages.base.arrays import Array
from linkages.base.kernel import bound
from linkages.engines.drake.joint_forces import Rooms, drive_forces, own_rates, placed
from linkages.engines.drake.plant import StatePlace
from linkages.mechanics.planar.closure import LOOSE, loop_errors
from linkages.mechanics.planar.reactive_loads import is_jammed
from linkages.system import System


class Drives(LeafSystem):
    """Torques of the drives, reactions of the ideal joints that close loops, and applied loads.

    A joint of a continuous plant cannot follow a function of time, and the plant cannot close loops. This system does
    both exactly: the drive torques and loop reactions that keep driven joints at their prescribed accelerations and cut
    joints closed follow from the equations of motion (hybrid articulated-body dynamics, with multipliers for the loops)
    and are applied as generalised forces. A feedback with both roots at `stabilisation` removes drift. The experiment's
    applied loads act here too, so that drives and loops take them into account.

    Ports
    -----
    - ``state``: input, (nx,).
      State [q; v] of the plant.
    - ``applied``: input, (nv + extra,).
        All other generalised forces on the plant, from `ClearanceJoints`, or their sum with a user's forces. Entries
        after the first nv are not read.
    - ``DRIVE.torque``: input, (1,), for each drive by torque.
      Torque [N m] or force [N] added to the drive's; zero if not connected.
    - ``DRIVE.speed``: output, (1,), for each drive.
      Rate of the driven joint [rad/s or m/s].
    - ``generalized_force``: output, (nv,).
      `applied` plus the forces of loads, drives and loops: for the plant's applied generalised forces.
    - ``torques``: output, (nd,).
      Torque [N m] or force [N] of each drive: prescribed ones first, then the powered ones.

    Parameters
    ----------
    system : System
        System with the same gravity as the plant.
    place : StatePlace
        Places of the tree's coordinates in the plant's state.
    extra : int
        Number of entries of `applied` after the forces.

    Attributes
    ----------
    joints : tuple of str
        Names of the drives, in the order of ``torques``.
    """

    def __init__(self, system: System, place: StatePlace, extra: int = 0) -> None:
        super().__init__()
        self.set_name("drives")
        self.system = system
        tree, num_velocities = system.tree, place.num_velocities
        self.joints = (*tree.driven, *tree.powered)
        self._tree = tree
        self._place = place
        self._rooms, self._size = Rooms(system), num_velocities
        self._placed = placed(system, place.positions, place.v, place.velocities, num_velocities)
        nz = len(system.own_states)
        sizes = place.num_states + nz, num_velocities + extra, len(tree.powered), num_velocities, len(self.joints)
        self._drive_forces = bound(
            drive_forces, self._placed, self._rooms.work, self._rooms.reactive, 0.0, *map(np.empty, sizes)
        )
        self._state = self.DeclareVectorInputPort("state", place.num_states)
        self._applied = self.DeclareVectorInputPort("applied", num_velocities + extra)
        powers = [self.DeclareVectorInputPort(f"{name}.torque", 1) for name in tree.powered]
        self._powers, self._nothing = powers, np.empty(0)
        inputs = (self._state, self._applied, *powers)
        if nz:
            self.DeclareContinuousState(nz)
        needs = {self.time_ticket(), self.xc_ticket(), *(self.input_port_ticket(port.get_index()) for port in inputs)}
        self._force = self.DeclareVectorOutputPort("generalized_force", num_velocities, self._give_force, needs)
        self._torques = self.DeclareVectorOutputPort("torques", len(self.joints), self._give_torques, needs)
        dofs = [*tree.driven_dofs, *tree.powered_dofs]
        for name, dof in zip(self.joints, dofs, strict=True):
            give = partial(self._give_speed, place.v[dof])
            self.DeclareVectorOutputPort(f"{name}.speed", 1, give, {self.input_port_ticket(self._state.get_index())})

    def get_force_output_port(self) -> OutputPort:
        """Return the output port ``generalized_force``."""
        return self._force

    def get_torques_output_port(self) -> OutputPort:
        """Return the output port ``torques``."""
        return self._torques

    def has_open_loop(self, root: Context) -> bool:
        """Check for open loops of ideal joints in the context of the whole diagram."""
        if not len(self._tree.loop_rows):
            return False
        q = self._state.Eval(self.GetMyContextFromRoot(root))[self._place.positions]
        error = loop_errors(self._tree.bodies, self._tree.loop_rows, q[None, :])[0]
        return bool(error > LOOSE * self._tree.extent)

    def is_jammed(self) -> bool:
        """Check whether the reactive loads computed last in this thread have no solution."""
        return is_jammed(self._rooms.reactive)

    def _solve(self, context: Context, force: Array) -> Array:
        """Fill in the forces on the plant (nv,), at every evaluation of the derivatives; return the drives' (nd,)."""
        applied, drive, rooms = self._applied.Eval(context), np.empty(len(self.joints)), self._rooms
        added = self._nothing
        if self._powers:
            added = np.array([port.Eval(context)[0] if port.HasValue(context) else 0.0 for port in self._powers])
        t, state = context.get_time(), self._whole_state(context)
        self._drive_forces(self._placed, rooms.work, rooms.reactive, t, state, applied, added, force, drive)
        return drive

    def _whole_state(self, context: Context) -> Array:
        """Return the plant's state, and the additional states."""
        return self._state.Eval(context)

    def _give_speed(self, place: int, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, self._state.Eval(context)[place])

    def _give_force(self, context: Context, output: BasicVector) -> None:
        self._solve(context, output.get_mutable_value())

    def _give_torques(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._solve(context, np.empty(self._size)))


class StatefulDrives(Drives):
    """Drives of an experiment with additional states: a separate class, as in `linkages.engines.drake.clearance`."""

    def begin(self, context: Context) -> None:
        """Set the states at t = 0, before the first samples."""
        context.SetContinuousState(self.system.start_states)

    def sample(self, context: Context, due: Array) -> None:
        """Give the sampled states whose times (nz,) have come their next values."""
        values = context.get_continuous_state_vector().CopyToVector()
        came = context.get_time() >= due
        values[came] = self._rates(context, due)[came]
        context.SetContinuousState(values)

    def _rates(self, context: Context, due: Array) -> Array:
        rates = np.empty(len(due))
        own_rates(self._placed, self._rooms.work, context.get_time(), self._whole_state(context), due, rates)
        return rates

    def _whole_state(self, context: Context) -> Array:
        return np.concatenate([super()._whole_state(context), context.get_continuous_state_vector().CopyToVector()])

    def DoCalcTimeDerivatives(self, context: Context, derivatives: ContinuousState) -> None:  # noqa: N802
        """Compute the rates of the states."""
        derivatives.SetFromVector(self._rates(context, np.full(derivatives.size(), np.inf)))
