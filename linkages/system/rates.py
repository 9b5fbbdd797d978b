"""Rates of the motion before a run: of the drives, and of a linkage without prescribed motions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.machine import all_elements_of
from linkages.input.model.experiment import Experiment
from linkages.mechanics.planar.record_types import REVOLUTE
from linkages.system.tree import Tree

_UNKNOWN = 1.0  # rate for a linkage without motion and forces at the start [rad/s]


def drive_rate(tree: Tree, experiment: Experiment) -> float:
    """Return the largest rate of a prescribed motion [rad/s or m/s]; zero without drives."""
    drives = [experiment.drives[name] for name in tree.driven]
    return max((drive.largest_rate(experiment.duration, experiment.values) for drive in drives), default=0.0)


def swing_rate(tree: Tree, experiment: Experiment, mass: float, gravity: Array, rates: Array) -> float:
    """Estimate the rate of the motion of a linkage without prescribed motions, before the run [rad/s].

    It is the largest of the rates (n,) at the start [rad/s, m/s] or, if larger, the rate of a swing under the present
    forces: the square root of force over mass [kg] and length, for the weight (gravity (2,) [m/s2]), springs, constant
    loads and drives by torque or force. It does not depend on the duration, because the result of a run must not.
    """
    forces = [mass * float(np.linalg.norm(gravity)), *_forces(tree, experiment)]
    swing = float(np.sqrt(max(forces) / (mass * tree.extent))) if mass > 0.0 else 0.0
    return max(_largest(tree, rates), swing) or _UNKNOWN


def _largest(tree: Tree, rates: Array) -> float:
    """Return the largest of the rates (n,) of joints, of slides over the linkage's length [rad/s]."""
    sliding = tree.bodies.records["type"] != REVOLUTE
    moved = tree.bodies.records["dof"][sliding]
    scale = np.ones(tree.size)
    scale[moved[moved >= 0]] = 1.0 / tree.extent
    return float(np.abs(rates * scale)[tree.joint_dofs].max(initial=0.0))


def _forces(tree: Tree, experiment: Experiment) -> Iterable[float]:
    """Yield the forces of elements and of drives by torque or force [N]."""
    for kind, _, keys in all_elements_of(experiment.elements):
        yield kind.force(keys, tree.mechanism.slides, tree.extent)
    for drive in experiment.drives.values():
        yield from (_magnitude(each) / tree.extent for each in (drive.torque, drive.torques))
        yield from map(_magnitude, (drive.force, drive.forces))


def _magnitude(values: Any) -> float:
    """Return the largest magnitude of a number or list; zero for None."""
    return 0.0 if values is None else float(np.abs(values).max())
