"""Outputs of forces: in joints; formulas of those of drives and applied loads."""

from __future__ import annotations

import math

import numpy as np

from linkages.mechanics.planar.loads import SECOND, VALUE
from linkages.results.outputs.quantity import OutputPlace, Owner, Snapshot, formula, quantities
from linkages.system import System


@formula("forces")
def _joint_force(output: np.record, seen: Snapshot) -> float:
    force = seen.forces[output.at]
    return (force[0], force[1], math.hypot(force[0], force[1]), force[2])[output.column]


@formula("forces")
def effort(output: np.record, seen: Snapshot) -> float:
    """Return the effort of a drive, the rate of its joint, or its power."""
    effort, rate = seen.efforts[output.at], seen.state.v[output.other]
    return (effort, rate, effort * rate)[output.column]


@formula("forces")
def effort_on_wheel(output: np.record, seen: Snapshot) -> float:
    """Return the effort of a drive on its gearbox' output wheel, the rate of its joint, or its power."""
    k, driven, vel = output.at, seen.model.driven, seen.state.vel
    wheel = driven[k] if k < len(driven) else seen.model.powered[k - len(driven)]
    rate = output.constant * (vel[output.other, 0] - vel[output.marker.body, 0])
    return (seen.efforts[k], rate, seen.efforts[k] * seen.state.v[wheel])[output.column]


@formula("loads")
def load_value(output: np.record, seen: Snapshot) -> float:
    """Read a value of an applied load."""
    return seen.loads[output.at, output.column]


@formula("loads")
def load_size(output: np.record, seen: Snapshot) -> float:
    """Return the magnitude of a load's two values."""
    return math.hypot(seen.loads[output.at, VALUE], seen.loads[output.at, SECOND])


_OF_JOINT = quantities(
    _joint_force,
    fx="force on the joint's child along x_P, without the drive's [N]",
    fy="force on the joint's child along y_P, without the drive's [N]",
    force="magnitude of the force [N]",
    moment="moment on the child about the joint, without the drive's [N m]",
)


def _at_joint(system: System, name: str) -> OutputPlace:
    return OutputPlace(list(system.joints).index(name))


def _drives(system: System) -> tuple[str, ...]:
    return (*system.tree.driven, *system.tree.powered)


def at_drive(system: System, name: str) -> OutputPlace:
    """Return the numbers of a drive: its index, and its coordinate."""
    k, tree = _drives(system).index(name), system.tree
    return OutputPlace(k, int(np.concatenate([tree.driven_dofs, tree.powered_dofs])[k]))


def at_wheel(system: System, name: str) -> OutputPlace:
    """Return the numbers of a drive with a gearbox: its index, and the bodies of its joint."""
    (_, parent, child, _, _), sign = system.tree.coordinate(name)
    return OutputPlace(_drives(system).index(name), child[0], parent, sign)


#: Joints.
FORCES = (Owner("JOINT", lambda system: system.joints, _at_joint, _OF_JOINT),)
