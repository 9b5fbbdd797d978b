"""Records of the kernels from applied loads, barriers of coordinates, and points at straight lines.

A barrier of a prismatic joint and a point at a line are corners at a wall, like a block's in its slot; other barriers
are coordinates at a limit. The contact kernels offset slot walls by the clearance. Here this
length only scales depths, and the wall's position compensates for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Records
from linkages.base.errors import InputError
from linkages.elements.contact_tables import ContactTable, FrictionTable
from linkages.elements.coordinates import Barrier, Edge
from linkages.elements.machine import count, elements_of, owner_of, pack_elements, pushes_of, tell_elements
from linkages.input.functions.definitions import (
    TIME,
    Curve,
    Definition,
    Function,
    Quantity,
    inputs_of,
    named,
    program,
    table_over,
)
from linkages.input.model.experiment import Experiment
from linkages.input.model.experiment_tables import JointModel
from linkages.laws.control import CONTROLLERS
from linkages.mechanics.planar import record_types as types
from linkages.mechanics.planar.bodies import make_motion, make_pose
from linkages.mechanics.planar.functions import Functions
from linkages.mechanics.planar.kinematics import body_states
from linkages.mechanics.planar.loads import LOAD_OUTPUTS, VALUE, Array, Loads, state_rates
from linkages.mechanics.planar.motion import Motions, Pieces, Program, constant_rate, monotone_table, raised
from linkages.system.tree import NO_ROW, Tree

#: Scale of contact depths: relative to the linkage's length, for a revolute joint an angle [rad].
REACH = 1e-3
_LOOKS = 501  # number of times at which a drive's formula is checked
_COINCIDENT = 1e-9  # relative to the linkage's size: closer points define no direction


class Packed(NamedTuple):
    """Elements and loads of a machine as records of the kernels, with the functions to which they refer."""

    elements: Any  # `linkages.elements.machine.Elements`
    loads: Loads

    @property
    def functions(self) -> Functions:
        """Return the functions."""
        return self.loads[1:]


def pack_loads(
    tree: Tree, experiment: Experiment, quantities: Mapping[str, Quantity], added: Mapping[int, float] | None = None
) -> Packed:
    """Pack elements and loads, with the functions to which they refer.

    The quantities are the experiment's, with tables for computed ones. `added` has constants to add to functions, by
    the functions' index.
    """
    mechanism = tree.mechanism
    records: Records = np.zeros(len(experiment.loads), types.LOAD)
    records["joint"] = -1
    functions = _Functions(tree, quantities)
    elements = pack_elements(experiment.elements, tree, functions.add)

    for record, push in zip(records, pushes_of(experiment.elements), strict=True):
        record["term"], record["sign"] = tree.coordinate(push.joint)
        record["motion"] = functions.add_definition(push.law)
        if push.share is not None:
            record["joint"] = list(mechanism.joint).index(push.joint)
            record["share"], record["leverage"] = functions.add_definition(push.share), push.leverage
    states: Records = np.array([functions.add_state(one) for one in experiment.own_states.values()], types.STATE)
    for k, value in (added or {}).items():
        functions.made[k] = raised(functions.made[k], value)
    loads = records, functions.signals, states, *Motions(functions.made).arrays
    return Packed(elements, loads)


class _Functions:
    """Collects the functions of elements and loads, and the signals that they depend on."""

    def __init__(self, tree: Tree, quantities: Mapping[str, Quantity]) -> None:
        self.tree, self.quantities = tree, quantities
        self.made: list[Pieces | Program] = []
        states = (name for name, one in quantities.items() if one.is_state)
        self.inputs = {name: k for k, name in enumerate((TIME, *states))}
        self._tables: dict[int, int] = {}
        self._signals: list[tuple[Any, ...]] = []

    @property
    def signals(self) -> Records:
        return np.array(self._signals, types.SIGNAL)

    def add_definition(self, given: Definition) -> int:
        """Add a formula of quantities; returns its index."""
        self.made.append(self._program(given))
        return len(self.made) - 1

    def add_state(self, given: Quantity) -> tuple[Any, ...]:
        """Add the functions of a state; return its `STATE`."""
        if given.call is None:
            return self.add_definition(given.definition), given.period, 0, 0, 0
        first, arguments = len(self.made), given.call.arguments
        for one in arguments:
            self.add_definition(named(one))
        return first, given.period, CONTROLLERS[given.call.function].address, len(arguments), given.call.results

    def _program(self, given: Definition) -> Program:
        """Translate a formula of quantities, and collect its signals."""
        for signal in inputs_of(given, self.quantities):
            self._input(signal)
        return program(given, self.inputs, self.quantities, self._table)

    def _table(self, table: tuple[list[float], list[float]]) -> int:
        """Add a table, once; returns its index."""
        if id(table) not in self._tables:
            self._tables[id(table)] = len(self.made)
            self.made.append(monotone_table(*table))
        return self._tables[id(table)]

    def _input(self, signal: str) -> int:
        """Collect a signal; return its index."""
        if signal not in self.inputs:
            self.inputs[signal] = len(self.inputs)
            self._signals.append(self.tree.signal(signal))
        return self.inputs[signal]

    def add(self, components: Sequence[Function]) -> int:
        """Add the functions of an element, one after the other; return the index of the first."""
        added = [self._function(one) for one in components]  # may add tables
        self.made += added
        return len(self.made) - len(added)

    def _function(self, given: Function) -> Pieces | Program:
        """Translate a function; a curve over a signal becomes a table."""
        if isinstance(given, Definition):
            return self._program(given)
        if not isinstance(given, Curve):
            return constant_rate(given, 0.0)
        if given.over == TIME:
            return given.curve
        self.made.append(given.curve)
        return table_over(self._input(given.over), len(self.made) - 1)


def check_elements(tree: Tree, experiment: Experiment, packed: Packed, q: Array, v: Array) -> None:
    """Reject elements that cannot start at coordinates q and rates v (n,), or whose quantities are not finite there."""
    pose, vel = make_pose(tree.bodies), make_motion(tree.bodies)
    rows = np.empty((count(packed.elements), len(LOAD_OUTPUTS)))
    body_states(tree.bodies, q, v, pose, vel)
    rates = np.concatenate([v, [one.start for one in experiment.own_states.values()]])
    tell_elements(packed.elements, packed.functions, 0.0, rates, 0, pose, vel, rows)
    for (kind, name, keys), row in zip(elements_of(experiment.elements), rows, strict=False):  # then quantities
        if problem := kind.problem_at_start(keys, row, _COINCIDENT * tree.extent):
            raise InputError(experiment.source, f"{kind.table}.{name}", problem)
        if not np.isfinite(row).all():
            raise InputError(experiment.source, f"{kind.table}.{name}.formula", "is not a number at t = 0")
    if experiment.own_states or len(packed.elements.told):
        changes = np.zeros(len(rates))
        state_rates(packed.loads, 0.0, rates, pose, vel, changes)
        _check_quantities(experiment, rows[len(rows) - len(packed.elements.told) :, VALUE], changes[len(v) :])


def check_loads(tree: Tree, experiment: Experiment, packed: Packed, motions: Motions, q: Array, v: Array) -> None:
    """Reject formulas that are not finite: of loads at t = 0, where coordinates and rates are q and v (n,); of drives.

    Drives are checked at any time. See also `check_elements`.
    """
    check_elements(tree, experiment, packed, q, v)
    if not any(isinstance(piece, Program) for piece in motions.pieces):
        return
    times = np.linspace(0.0, experiment.duration, _LOOKS)
    for found in motions(times):
        for name, values in zip(tree.driven, found.T, strict=True):
            if not np.isfinite(values).all():
                when = f"at t = {times[~np.isfinite(values)][0]:.3g} s"
                problem = f"it, its rate or its second derivative is not a number {when}; it must be smooth"
                raise InputError(experiment.source, f"drives.{name}.formula", problem)


def _check_quantities(experiment: Experiment, values: Array, rates: Array) -> None:
    """Reject quantities, and states whose rates, are not finite at t = 0."""
    own = [name for name in experiment.quantities if name not in experiment.values]
    pairs = *zip(own, values, strict=True), *zip(experiment.own_states, rates, strict=True)
    for name, value in pairs:
        if not np.isfinite(value):
            table, _ = owner_of(experiment.elements, name)
            raise InputError(experiment.source, f"{table}.{name}", "its value or its rate is not a number at t = 0")


# -- unilateral contacts -----------------------------------------------------------------------------------------------


def unilateral_models(tree: Tree, experiment: Experiment) -> tuple[JointModel, ...]:
    """Return a dry joint model for each contact of elements."""
    return tuple(_dry(_reach(tree, one), one.contact, one.friction) for one in experiment.touches.values())


def _dry(clearance: float, contact: ContactTable, friction: FrictionTable | None) -> JointModel:
    values = {"model": "dry", "clearance": clearance, "contact": contact, "friction": friction}
    return JointModel.model_validate(values)


def unilateral_ends(tree: Tree, experiment: Experiment) -> Records:
    """Make the records of the two ends of each contact, in the same order."""
    every = experiment.touches.values()
    records = [_at_barrier(tree, one) if isinstance(one, Barrier) else _at_edge(tree, one) for one in every]
    return np.array(records, types.ENDS)


def _at_barrier(tree: Tree, one: Barrier) -> tuple[Any, ...]:
    row, sign = tree.coupled_row(one.other or one.joint, one.joint, one.ratio, 0.0, one.carrier)
    (_, *ends, ux, uy), place = row[0], one.lever * one.side * one.place - _reach(tree, one)
    if one.other is None and not _turns(tree, one.joint):
        return types.CORNER, *ends, one.side * ux, one.side * uy, place, *NO_ROW
    if one.other is not None:
        ends[0] = row[2][2]  # on the child of the other joint: teeth slide by the relative angle of both wheels
    return types.STOP, *ends, one.side * sign, 0.0, place, one.lever, one.arm, row


def _at_edge(tree: Tree, one: Edge) -> tuple[Any, ...]:
    angle = tree.mechanism.point[one.line].angle if isinstance(one.line, str) else one.angle
    into = np.sin(angle), -np.cos(angle)
    ends = tree.marker_of(one.line), tree.named_marker(one.point)
    return types.CORNER, *ends, *into, -_reach(tree, one), *NO_ROW


def _reach(tree: Tree, one: Barrier | Edge) -> float:
    """Return the scale of the depths of a contact."""
    angular = isinstance(one, Barrier) and _turns(tree, one.joint)
    return REACH * (one.lever if isinstance(one, Barrier) and angular else tree.extent)


def _turns(tree: Tree, joint: str) -> bool:
    return tree.mechanism.joint[joint].type == "revolute"
