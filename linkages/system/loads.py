"""From an experiment's applied loads to the records that the kernels read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError
from linkages.model.experiment import Experiment
from linkages.model.load_tables import Force
from linkages.planar.kinematics import body_positions
from linkages.planar.loads import LOAD_OUTPUTS, Array, Loads, load_outputs
from linkages.planar.motion import Motions, Pieces
from linkages.planar.record_types import FORCE, LOAD, SPRING, TORQUE, TORSION
from linkages.system.tree import Tree

_COINCIDENT = 1e-9  # of the linkage's size: points closer than this have no direction between them


def pack_loads(tree: Tree, experiment: Experiment) -> Loads:
    """Pack the loads for `linkages.planar.loads`: records, and the values of forces and torques over time."""
    mechanism = tree.mechanism
    records: NDArray[np.record] = np.zeros(len(experiment.loads), LOAD)
    following = iter(records)
    motions: list[Pieces] = []

    for force in experiment.forces.values():
        record = next(following)
        record["kind"], record["turns"], record["motion"] = FORCE, force.axes == "body", len(motions)
        record["a"] = tree.named_marker(force.point)
        motions += _turned(force, mechanism.point[force.point].angle if force.axes == "body" else 0.0)
    for torque in experiment.torques.values():
        record = next(following)
        record["kind"], record["a"]["body"], record["motion"] = TORQUE, tree.index[torque.link], len(motions)
        motions.append(torque.history())
    for spring in experiment.springs.values():
        record = next(following)
        record["kind"], record["motion"] = SPRING, -1
        record["a"] = tree.named_marker(spring.point)
        record["b"] = tree.named_marker(spring.to) if spring.to is not None else (0, *(spring.anchor or ()))
        record["stiffness"], record["free"] = spring.stiffness, spring.free_length
        record["damping"] = spring.damping
    for torsion in experiment.torsion_springs.values():
        record = next(following)
        record["kind"], record["motion"] = TORSION, -1
        links, record["sign"] = torsion.links or [], 1.0
        if torsion.joint is not None:
            joint = mechanism.joint[torsion.joint]
            links, record["sign"] = [joint.parent, joint.child], joint.sign
        record["a"]["body"], record["b"]["body"] = (tree.index[link] for link in links)
        record["stiffness"], record["free"] = torsion.stiffness, torsion.free_angle
        record["damping"] = torsion.damping
    return records, *Motions(motions).arrays


def _turned(force: Force, angle: float) -> tuple[Pieces, Pieces]:
    """Components over time, turned by an angle."""
    x, y = force.components()
    c, s = np.cos(angle), np.sin(angle)
    return Pieces(c * x.c - s * y.c, x.x), Pieces(s * x.c + c * y.c, y.x)


def check_lengths(tree: Tree, experiment: Experiment, loads: Loads, q: Array) -> None:
    """Refuse springs with a free length that have no direction at t = 0, where the coordinates are q (n,)."""
    if not experiment.springs:
        return
    nb, names = len(tree.bodies), experiment.loads
    pose, outputs = np.empty((nb, 5)), np.empty((len(names), len(LOAD_OUTPUTS)))
    body_positions(tree.bodies, q, pose)
    load_outputs(loads, 0.0, pose, np.zeros((nb, 3)), outputs)
    for (table, name), length in zip(names, outputs[:, 1], strict=True):
        if table != "springs" or experiment.springs[name].free_length == 0.0:
            continue
        if length <= _COINCIDENT * tree.extent:
            problem = "its points coincide at t = 0, where a spring with a free length has no direction;"
            remedy = "set free_length = 0 or start elsewhere"
            raise InputError(experiment.source, f"springs.{name}", f"{problem} {remedy}")
