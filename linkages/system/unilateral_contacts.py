"""Records of unilateral contacts other than clearance joints: limit stops, and points at straight lines.

Each is a corner at a wall, like a block's in its slot, or for a revolute joint an angle at a limit. The contact kernels
offset slot walls by the clearance. Here this length only scales depths, and the wall's position compensates for it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.arrays import Records
from linkages.model.experiment import Experiment
from linkages.model.experiment_tables import ContactTable, FrictionTable, JointModel
from linkages.planar.record_types import CORNER, ENDS, STOP
from linkages.system.tree import Tree

#: Scale of contact depths: relative to the linkage's length, for a revolute joint an angle [rad].
REACH = 1e-3


def unilateral_models(tree: Tree, experiment: Experiment) -> tuple[JointModel, ...]:
    """Return dry joint models for each stop, then for each point at a line."""
    models = [
        _dry(REACH * (1.0 if _turns(tree, stop.joint) else tree.extent), stop.contact, None)
        for stop in experiment.stops.values()
    ]
    models += [_dry(REACH * tree.extent, touch.contact, touch.friction) for touch in experiment.contacts.values()]
    return tuple(models)


def _dry(clearance: float, contact: ContactTable, friction: FrictionTable | None) -> JointModel:
    values = {"model": "dry", "clearance": clearance, "contact": contact, "friction": friction}
    return JointModel.model_validate(values)


def unilateral_ends(tree: Tree, experiment: Experiment) -> Records:
    """Make the records of the two ends of each contact, in the same order."""
    records: list[tuple[Any, ...]] = []
    for stop in experiment.stops.values():
        joint, side = tree.mechanism.joint[stop.joint], 1.0 if stop.side == "upper" else -1.0
        ends = tree.marker(joint.parent, joint.on_parent), tree.marker(joint.child, joint.on_child)
        if _turns(tree, stop.joint):
            records.append((STOP, *ends, side * joint.sign, 0.0, side * stop.limit - REACH))
        else:
            records.append((CORNER, *ends, *(side * joint.direction), side * stop.limit - REACH * tree.extent))
    for touch in experiment.contacts.values():
        if touch.line is not None:
            frame = tree.mechanism.point[touch.line]
            line, angle = tree.named_marker(touch.line), frame.angle
        else:
            line, angle = (0, *(touch.anchor or ())), touch.angle
        into = np.sin(angle), -np.cos(angle)
        records.append((CORNER, line, tree.named_marker(touch.point), *into, -REACH * tree.extent))
    return np.array(records, ENDS)


def _turns(tree: Tree, joint: str) -> bool:
    return tree.mechanism.joint[joint].type == "revolute"
