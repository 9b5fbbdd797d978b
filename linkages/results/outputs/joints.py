"""Outputs of forces: in joints, of drives, applied loads and gears."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from linkages.elements.element import Element, Quantities
from linkages.elements.machine import KINDS, elements_of
from linkages.mechanics.planar.closure_rows import term_rate
from linkages.mechanics.planar.loads import POWER, SECOND, VALUE
from linkages.results.outputs.quantity import Declaration, OutputPlace, Owner, Snapshot, formula, quantities, quantity
from linkages.system import System


@formula("forces")
def _joint_force(output: np.record, seen: Snapshot) -> float:
    force = seen.forces[output.at]
    return (force[0], force[1], math.hypot(force[0], force[1]), force[2])[output.column]


@formula("forces")
def _drive(output: np.record, seen: Snapshot) -> float:
    effort, rate = seen.efforts[output.at], seen.state.v[output.other]
    return (effort, rate, effort * rate)[output.column]


@formula("forces")
def _gearbox(output: np.record, seen: Snapshot) -> float:
    k, driven, vel = output.at, seen.model.driven, seen.state.vel
    wheel = driven[k] if k < len(driven) else seen.model.powered[k - len(driven)]
    rate = output.constant * (vel[output.other, 0] - vel[output.marker.body, 0])
    return (seen.efforts[k], rate, seen.efforts[k] * seen.state.v[wheel])[output.column]


@formula("loads")
def load_value(output: np.record, seen: Snapshot) -> float:
    """Read a value of an applied load."""
    return seen.loads[output.at, output.column]


@formula("loads")
def _size(output: np.record, seen: Snapshot) -> float:
    return math.hypot(seen.loads[output.at, VALUE], seen.loads[output.at, SECOND])


@formula("forces")
def _gear(output: np.record, seen: Snapshot) -> float:
    k = len(seen.model.rows) + output.at
    reaction = seen.state.reaction[k]
    if output.column == 0:
        return output.constant * reaction
    return reaction * term_rate(seen.model.rows[k].term, seen.state.pose, seen.state.vel)


_OF_JOINT = quantities(
    _joint_force,
    fx="force on the joint's child along x_P, without the drive's [N]",
    fy="force on the joint's child along y_P, without the drive's [N]",
    force="magnitude of the force [N]",
    moment="moment on the child about the joint, without the drive's [N m]",
)
_OF_DRIVE = quantities(
    _drive,
    torque="torque (prismatic joint: force) of the drive along the joint's coordinate; JOINT.force excludes it"
    " [N m or N]",
    rate="rate of the joint's coordinate [rad/s or m/s]",
    power="power delivered by the drive [W]",
)
_OF_GEARBOX = quantities(
    _gearbox,
    torque="torque of the drive on the output wheel of its gearbox, along the joint's coordinate [N m]",
    rate="rate of the joint's coordinate; the wheel has another one [rad/s]",
    power="power delivered by the drive [W]",
)
_POWER = {"power": quantity("power that the load delivers to the linkage [W]", load_value, POWER)}
_OF_FRICTION = "friction in an ideal joint, along its coordinate"


def _values(**texts: str) -> dict[str, Declaration]:
    """Make the quantities of a load: its value, a second one if any, its power."""
    return quantities(load_value, **texts) | _POWER


def _passed(name: str, unit: str) -> dict[str, Declaration]:
    """Make the quantities of a gear."""
    text = f"{name} on the second joint, along its coordinate [{unit}]"
    return quantities(_gear, **{name: text, "power": "power transmitted to the second joint [W]"})


def turns(system: System, table: str, name: str) -> bool:
    """Tell whether a stop, friction or gear gives a torque; the second joint of a gear or coupling counts."""
    element = getattr(system.experiment, table)[name]
    joint = element.joints[1] if table in ("gears", "couplings", "meshes", "slack") else element.joint
    return not system.mechanism.slides(joint)


def of_joints(table: str, turning: bool) -> Callable[[System], Iterable[str]]:
    """List the stops, frictions, gears and couplings (meshes) that give a torque, or a force."""
    return lambda system: [name for name in getattr(system.experiment, table) if turns(system, table, name) is turning]


def _at_joint(system: System, name: str) -> OutputPlace:
    return OutputPlace(list(system.mechanism.joint).index(name))


def _drives(system: System) -> tuple[str, ...]:
    return (*system.tree.driven, *system.tree.powered)


def _at_drive(system: System, name: str) -> OutputPlace:
    k, tree = _drives(system).index(name), system.tree
    return OutputPlace(k, int(np.concatenate([tree.driven_dofs, tree.powered_dofs])[k]))


def _at_gearbox(system: System, name: str) -> OutputPlace:
    (_, parent, child, _, _), sign = system.tree.coordinate(name)
    return OutputPlace(_drives(system).index(name), child[0], parent, sign)


def _at_load(system: System, name: str) -> OutputPlace:
    return OutputPlace([load for _, load in system.experiment.loads].index(name))


def _at_element(system: System, name: str) -> OutputPlace:
    names = [name for _, name, _ in elements_of(system.experiment.elements)]
    return OutputPlace(len(system.loads[0]) + names.index(name))


def _of_sort(kind: Element[Any], outputs: Quantities) -> Owner:
    """Make the owner of the outputs of the elements of a kind that have these."""

    def names(system: System) -> Iterable[str]:
        named, slides = getattr(system.experiment, kind.table), system.mechanism.slides
        return [name for name, keys in named.items() if kind.outputs_of(keys, slides) is outputs]

    sizes = {name: quantity(text, _size) for name, text in outputs.size.items()}
    return Owner(outputs.label, names, _at_element, quantities(load_value, **outputs.texts) | sizes | _POWER)


#: The elements of `linkages.elements`.
OF_ELEMENTS = tuple(_of_sort(kind, outputs) for kind in KINDS for outputs in kind.outputs)


def _at_gear(system: System, name: str) -> OutputPlace:
    experiment, tree = system.experiment, system.tree  # with backlash: row of the ideal linkage
    gears, after = (experiment.closed, 0) if name in experiment.closed else (experiment.slack, len(tree.loop_rows))
    sign = tree.seen_coordinate(gears[name].joints[1], gears[name].carrier)[1]
    return OutputPlace(list(gears).index(name) - len(gears) - after, constant=sign)


#: Joints, drives, applied loads, gears and couplings.
FORCES = (
    Owner("JOINT", lambda system: system.mechanism.joint, _at_joint, _OF_JOINT),
    Owner(
        "DRIVE", lambda system: [name for name in _drives(system) if name not in system.experiment.gearboxes],
        _at_drive, _OF_DRIVE,
    ),
    Owner("DRIVE (backlash)", lambda system: system.experiment.gearboxes, _at_gearbox, _OF_GEARBOX),
    *OF_ELEMENTS,
    Owner("FRICTION (revolute)", of_joints("frictions", True), _at_load, _values(torque=f"{_OF_FRICTION} [N m]")),
    Owner("FRICTION (prismatic)", of_joints("frictions", False), _at_load, _values(force=f"{_OF_FRICTION} [N]")),
    Owner("GEAR (revolute)", of_joints("meshes", True), _at_gear, _passed("torque", "N m")),
    Owner("GEAR (prismatic)", of_joints("meshes", False), _at_gear, _passed("force", "N")),
)  # fmt: skip
