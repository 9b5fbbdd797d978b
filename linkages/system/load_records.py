"""Records of the load kernels from the applied loads of an experiment."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from linkages.arrays import Records
from linkages.errors import InputError
from linkages.files.formula import Formula
from linkages.model.experiment import Experiment
from linkages.model.functions import TIME, program, table_over
from linkages.model.load_tables import LoadFunction
from linkages.planar.bodies import make_motion, make_pose
from linkages.planar.kinematics import body_states, poses_at
from linkages.planar.loads import LOAD_OUTPUTS, Array, Loads, load_outputs
from linkages.planar.motion import Motions, Pieces, Program, constant_rate, monotone_table, raised
from linkages.planar.record_types import ANGLE, COORDINATE_SPRING, FORCE, LOAD, PUSH, SIGNAL, SPRING
from linkages.system.tree import Tree

_LOOKS = 501  # number of times at which a drive's formula is checked
_COINCIDENT = 1e-9  # relative to the linkage's size: closer points define no direction


def pack_loads(tree: Tree, experiment: Experiment, added: Mapping[int, float] | None = None) -> Loads:
    """Pack the loads for `linkages.planar.loads`: records, signals, and the functions of forces and torques.

    `added` has constants to add to functions, by the functions' index (`LOAD` has it as ``motion``).
    """
    mechanism = tree.mechanism
    records: Records = np.zeros(len(experiment.loads), LOAD)
    following = iter(records)
    functions = _Functions(tree)

    for force in experiment.forces.values():
        record, frame = next(following), mechanism.point[force.point]
        angle = frame.angle if force.axes == "body" else 0.0
        record["kind"], record["turns"] = FORCE, force.axes == "body"
        record["ux"], record["uy"] = np.cos(angle), np.sin(angle)
        record["a"] = tree.named_marker(force.point)
        record["motion"] = functions.add(force, force.force, force.forces)
    for torque in experiment.torques.values():
        record = next(following)
        record["kind"] = PUSH
        record["term"], record["sign"] = _coordinate(tree, torque.joint, ("world", torque.link))
        constant, values = torque.torque, [[value] for value in torque.torques or []]
        record["motion"] = functions.add(torque, None if constant is None else [constant], values or None)
    for spring in experiment.springs.values():
        record = next(following)
        record["kind"], record["motion"] = SPRING, -1
        record["a"] = tree.named_marker(spring.point)
        record["b"] = tree.named_marker(spring.to) if spring.to is not None else (0, *(spring.anchor or ()))
        record["stiffness"], record["free"] = spring.stiffness, spring.free_length
        record["damping"] = spring.damping
    for torsion in experiment.torsion_springs.values():
        record = next(following)
        record["kind"], record["motion"] = COORDINATE_SPRING, -1
        record["term"], record["sign"] = _coordinate(tree, torsion.joint, torsion.links or ())
        record["stiffness"], record["free"] = torsion.stiffness, torsion.free_angle
        record["damping"] = torsion.damping
    for friction in experiment.frictions.values():
        record, rate = next(following), f"{friction.joint}.rate"
        record["kind"] = PUSH
        record["term"], record["sign"] = tree.coordinate(friction.joint)
        record["motion"] = functions.add_formula(friction.law, {"v": rate})
    for k, value in (added or {}).items():
        functions.made[k] = raised(functions.made[k], value)
    return records, functions.signals, *Motions(functions.made).arrays


def _coordinate(tree: Tree, joint: str | None, links: Iterable[str | None]) -> tuple[tuple[Any, ...], float]:
    """Return the term of a joint's coordinate, or of the angle of the second of two links, and its sign."""
    if joint is not None:
        return tree.coordinate(joint)
    ends = ((0, 0.0, 0.0) if link in (None, "world") else tree.named_marker(str(link)) for link in links)
    return (ANGLE, *ends, 0.0, 0.0), 1.0


class _Functions:
    """Collects the functions of the loads, and the signals that they depend on."""

    def __init__(self, tree: Tree) -> None:
        self.tree = tree
        self.made: list[Pieces | Program] = []
        self.inputs = {TIME: 0}
        self._signals: list[tuple[Any, ...]] = []

    @property
    def signals(self) -> Records:
        """Return all collected signals."""
        return np.array(self._signals, SIGNAL)

    def add_formula(self, given: Formula, names: Mapping[str, str]) -> int:
        """Add a formula whose names stand for signals; returns its index."""
        self.made.append(program(given, {name: self._input(signal) for name, signal in names.items()}))
        return len(self.made) - 1

    def _input(self, signal: str) -> int:
        """Collect a signal; return its index."""
        if signal not in self.inputs:
            self.inputs[signal] = len(self.inputs)
            self._signals.append(self.tree.signal(signal))
        return self.inputs[signal]

    def add(
        self, load: LoadFunction, constant: Sequence[float] | None, values: Sequence[Sequence[float]] | None
    ) -> int:
        """Add the components of a load; returns the index of the first."""
        for name in load.signals:
            self._input(name)
        components: list[Pieces | Program] = [program(text, self.inputs) for text in load.formulas]
        if constant is not None:
            components = [constant_rate(value, 0.0) for value in constant]
        places = getattr(load, "times", None) or getattr(load, "at", None)
        if values is not None and places is not None:
            components = [monotone_table(places, part) for part in zip(*values, strict=True)]
        first = len(self.made)
        self.made += components
        over = getattr(load, "over", None)
        if over is not None:
            first, tables = len(self.made), range(first, len(self.made))
            self.made += [table_over(self.inputs[over], table) for table in tables]
        return first


def check_lengths(tree: Tree, experiment: Experiment, loads: Loads, q: Array) -> None:
    """Reject springs with a free length that have no direction at t = 0, where the coordinates are q (n,)."""
    if not experiment.springs:
        return
    names = experiment.loads
    outputs = np.empty((len(names), len(LOAD_OUTPUTS)))
    load_outputs(loads, 0.0, poses_at(tree.bodies, q), make_motion(tree.bodies), outputs)
    for (table, name), length in zip(names, outputs[:, 1], strict=True):
        if table != "springs" or experiment.springs[name].free_length == 0.0:
            continue
        if length <= _COINCIDENT * tree.extent:
            problem = "its points coincide at t = 0, where a spring with a free length has no direction;"
            remedy = "set free_length = 0 or start elsewhere"
            raise InputError(experiment.source, f"springs.{name}", f"{problem} {remedy}")


def check_functions(tree: Tree, experiment: Experiment, loads: Loads, motions: Motions, q: Array, v: Array) -> None:
    """Reject non-finite formulas: loads' at t = 0 with coordinates and rates q, v (n,); drives' at any time."""
    if experiment.loads:
        pose, vel = make_pose(tree.bodies), make_motion(tree.bodies)
        outputs = np.empty((len(loads[0]), len(LOAD_OUTPUTS)))
        body_states(tree.bodies, q, v, pose, vel)
        load_outputs(loads, 0.0, pose, vel, outputs)
        for (table, name), values in zip(experiment.loads, outputs, strict=True):
            if not np.isfinite(values).all():
                raise InputError(experiment.source, f"{table}.{name}.formula", "is not a number at t = 0")
    if not any(isinstance(piece, Program) for piece in motions.pieces):
        return
    times = np.linspace(0.0, experiment.duration, _LOOKS)
    for found in motions(times):
        for name, values in zip(tree.driven, found.T, strict=True):
            if not np.isfinite(values).all():
                when = f"at t = {times[~np.isfinite(values)][0]:.3g} s"
                problem = f"it, its rate or its second derivative is not a number {when}; it must be smooth"
                raise InputError(experiment.source, f"drives.{name}.formula", problem)
