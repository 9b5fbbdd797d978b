"""The clearance joints as a Drake system."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    ContinuousState,
    DiscreteValues,
    EventStatus,
    LeafSystem,
    OutputPort,
    State,
    UnrestrictedUpdateEvent,
    WitnessFunction,
    WitnessFunctionDirection,
)

from linkages.base.arrays import Array
from linkages.base.kernel import bound
from linkages.engines.drake.joint_forces import Rooms, joint_forces, move_cells, placed
from linkages.engines.drake.plant import StatePlace
from linkages.laws.states import FIRST_STATE, LATCHED
from linkages.mechanics.planar.contact_memory import (
    any_cells,
    fill_landing,
    latch,
    latch_at_start,
    longest_step,
    make_memory,
)
from linkages.mechanics.planar.contacts import CLEARANCE_OUTPUTS, CLOSING, PENETRATION, RATES, WIDTH
from linkages.mechanics.planar.record_types import WORN
from linkages.system import System

#: Entries of each contact's block of the output port "joints": `CLEARANCE_OUTPUTS`, and quantities derived from them.
JOINT_OUTPUTS = {
    "ex": "eccentricity vector, from the bearing's centre to the journal's, along x_P [m]",
    "ey": "eccentricity vector along y_P [m]",
    "fx": "force on the journal along x_P [N]",
    "fy": "force on the journal along y_P [N]",
    "couple": "moment on the journal [N m]",
    "penetration": "overlap of journal and bearing, negative: their gap [m]",
    "closing": "rate of the penetration [m/s]",
    "sliding": "sliding speed of the journal's surface [m/s]",
    "load": "normal load of the contact, without the film force [N]",
    "eccentricity_ratio": "length of the eccentricity vector over the radial clearance [1]",
    "attitude": "angle of the eccentricity vector [rad]",
}


class ClearanceJoints(LeafSystem):
    """Forces of all clearance joints, from the plant's state.

    Ports
    -----
    - ``state``: input, (nx,).
      State [q; v] of the plant.
    - ``evaluation``: output, (nv + WIDTH nc,).
      Generalised forces, then `CLEARANCE_OUTPUTS` and others of each contact (a journal has one, a guide four): for
      `Drives`, a callback cheaper than `generalized_force`.
    - ``generalized_force``: output, (nv,).
      For the plant's applied generalised forces [N m, N].
    - ``joints``: output, (len(JOINT_OUTPUTS) nc,).
      `JOINT_OUTPUTS` of each contact.

    The laws are evaluated once for each state: the other ports read the cached value of ``evaluation``.

    State
    -----
    Joints with contact: the approach speed of the present contact is discrete state, latched by an event that witness
    functions locate at the contact's start (set the context's accuracy for this). Each start and end of a contact is an
    event, so that no integration step crosses it. Between contacts the approach speed is infinite: a trial step across
    a start then evaluates the law without damping; any other approach speed could make the damping arbitrarily large.
    `begin` latches the speeds of contacts that start with the run, because no witness function changes its sign there.
    States of laws are continuous state. Films that remember: their content is discrete state too, which an event at the
    start of each step moves to its time; `limit_step` is told how long this step may be.

    Parameters
    ----------
    system : System
    place : StatePlace
        Places of the tree's coordinates in the plant's state.

    Attributes
    ----------
    joints : tuple of str
        Names of the contacts, in the order of the ports' entries.
    replaying : bool
        Whether steps of a run are repeated with the content of films that they had.
    limit_step : callable
        Called at the start of each step with its longest permitted size [s], if films remember.
    """

    def __init__(self, system: System, place: StatePlace) -> None:
        super().__init__()
        self.set_name("clearance_joints")
        tree, laws, num_velocities = system.tree, system.laws, place.num_velocities
        self.joints = tuple(label for _, label in system.contacts)
        self._ends, self._laws = system.ends, laws
        self._rooms = Rooms(system)
        self._placed = placed(system, place.positions, place.v, place.velocities, num_velocities)
        self._landing = np.zeros(len(laws))
        fill_landing(laws, tree.extent, self._landing)
        self._size, self._beside = num_velocities, len(tree.contacts)
        self._touching, self._law_states = np.flatnonzero(system.touching), system.law_states.places
        self._memory = make_memory(system.ends, system.tables)
        self._memory[:, :LATCHED] = np.inf  # no contact yet, hence no damping
        state, forces = np.empty(place.num_states), np.empty(num_velocities + WIDTH * len(laws))
        self._joint_forces = bound(joint_forces, self._placed, self._rooms.work, self._memory, state, forces)
        self._state = self.DeclareVectorInputPort("state", place.num_states)
        needs = {self.input_port_ticket(self._state.get_index())}
        if len(self._touching) or any_cells(self._memory):
            self.DeclareDiscreteState(self._memory.ravel())
            needs.add(self.xd_ticket())
        if len(self._law_states):
            self.DeclareContinuousState(BasicVector(system.law_states.starts))
            needs.add(self.xc_ticket())
        self.replaying = False
        self.limit_step: Callable[[float], None] = lambda longest: None
        if any_cells(self._memory):
            self.DeclarePerStepDiscreteUpdateEvent(update=self._advance_cells)
        self._witnesses = [self._witness(int(k)) for k in self._touching]
        self._evaluation = self.DeclareVectorOutputPort(
            "evaluation", num_velocities + WIDTH * len(laws), self._evaluate, needs
        )
        self._force = self.DeclareVectorOutputPort("generalized_force", num_velocities, self._give_force, needs)
        self._joints = self.DeclareVectorOutputPort("joints", len(JOINT_OUTPUTS) * len(laws), self._give_joints, needs)

    def get_force_output_port(self) -> OutputPort:
        """Return the output port `generalized_force`."""
        return self._force

    def get_joints_output_port(self) -> OutputPort:
        """Return the output port ``joints``."""
        return self._joints

    def evaluate(self, context: Context) -> Array:
        """Compute ``CLEARANCE_OUTPUTS`` and others of each contact, (nc, WIDTH)."""
        joints: Array = self._evaluation.Eval(context)[self._size :].reshape(-1, WIDTH)
        return joints

    # -- events and states -------------------------------------------------------------------------

    def begin(self, context: Context) -> None:
        """Latch the approach speeds of contacts that exist at the state of a context, the start of a run."""
        memory = self._remembered(context)
        if any_cells(memory):
            move_cells(self._placed, self._rooms.work, memory, context.get_time(), self._state.Eval(context), True)
        joints = self.evaluate(context)
        for k in self._touching:
            latch_at_start(memory[k], joints[k], self._landing[k])
        if context.num_discrete_state_groups():
            context.SetDiscreteState(memory.ravel())

    def DoGetWitnessFunctions(self, context: Context) -> list[WitnessFunction]:  # noqa: N802
        """Return the witness functions; Drake calls this after every step."""
        return self._witnesses

    def _advance_cells(self, context: Context, memory: DiscreteValues) -> EventStatus:
        """Move the content of the contacts' cells to the start of the step."""
        if not self.replaying:
            moved = self._remembered(context)
            move_cells(self._placed, self._rooms.work, moved, context.get_time(), self._state.Eval(context), False)
            memory.set_value(moved.ravel())
            self.limit_step(longest_step(self._ends, moved))
        return EventStatus.Succeeded()

    def _witness(self, k: int) -> WitnessFunction:
        width = self._memory.shape[1]

        def penetration(context: Context) -> float:
            return float(self.evaluate(context)[k, PENETRATION])

        def begin(system: LeafSystem, context: Context, event: UnrestrictedUpdateEvent, state: State) -> EventStatus:
            touch = self.evaluate(context)[k]
            latched = np.full(LATCHED, np.inf)
            if (touch[PENETRATION], touch[CLOSING]) > (0.0, 0.0):
                latch(latched, touch)
            for place, value in enumerate(latched, k * width):
                state.get_mutable_discrete_state(0).SetAtIndex(place, value)
            return EventStatus.Succeeded()

        return self.MakeWitnessFunction(
            f"{self.joints[k]} starts or ends contact",
            WitnessFunctionDirection.kCrossesZero,
            penetration,
            UnrestrictedUpdateEvent(system_callback=begin),
        )

    def _remembered(self, context: Context) -> Array:
        """Return the memory of the contacts, see `linkages.mechanics.planar.contact_memory`."""
        if not context.num_discrete_state_groups():
            return self._memory
        memory: Array = context.get_discrete_state(0).get_value().reshape(self._memory.shape).copy()
        if len(self._law_states):
            contact, place = self._law_states.T
            memory[contact, FIRST_STATE + place] = context.get_continuous_state_vector().CopyToVector()
        return memory

    # -- outputs -----------------------------------------------------------------------------------

    def _evaluate(self, context: Context, output: BasicVector) -> None:
        memory, state, forces = self._remembered(context), self._state.Eval(context), output.get_mutable_value()
        self._joint_forces(self._placed, self._rooms.work, memory, state, forces)

    def _give_force(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._evaluation.Eval(context)[: self._size])

    def _give_joints(self, context: Context, output: BasicVector) -> None:
        joints = self.evaluate(context)
        depth = joints[:, PENETRATION] + self._laws["clearance"]
        length = np.where(self._ends["kind"] == WORN, np.hypot(joints[:, 0], joints[:, 1]), depth)
        ratio = length / self._laws["clearance"]
        extra = np.array([ratio, np.arctan2(joints[:, 1], joints[:, 0])])
        extra[:, self._beside :] = np.nan  # not defined for stops and points at lines
        output.SetFromVector(np.column_stack([joints[:, : len(CLEARANCE_OUTPUTS)], *extra]).ravel())


class JointsWithStates(ClearanceJoints):
    """Clearance joints whose laws have states: a separate class, as Drake evaluates declared derivatives slowly."""

    def DoCalcTimeDerivatives(self, context: Context, derivatives: ContinuousState) -> None:  # noqa: N802
        """Compute the rates of the states of laws."""
        contact, place = self._law_states.T
        derivatives.SetFromVector(self.evaluate(context)[contact, RATES + place])
