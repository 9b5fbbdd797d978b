"""Rates of the motion before a run: travel of the drives, rate of a swing."""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.machine import elements_of
from linkages.input.model.experiment import Experiment
from linkages.mechanics.planar.motion import Motions
from linkages.mechanics.planar.record_types import REVOLUTE
from linkages.system.tree import Tree

_UNKNOWN = 1.0  # rate for a linkage without motion and forces at the start [rad/s]
_SAMPLED = 2000  # number of times at which the drives' rates are compared


def drive_travel(motions: Motions, duration: float) -> float:
    """Compute the fastest drive's travel at its largest rate [rad or m]; an oscillation counts as 2 pi.

    The number of oscillations follows from the total variation of the rate: four times its largest value in each. Rates
    and accelerations are sampled at irregular times up to the duration [s], to avoid aliasing.
    """
    between = np.random.default_rng(0).random(_SAMPLED)
    _, *sampled = motions(duration * np.concatenate([[0.0], np.sort(between), [1.0]]))
    rates, accelerations = np.abs(sampled)
    largest = rates.max(axis=0, initial=0.0)
    turns = accelerations.mean(axis=0) / np.where(largest > 0.0, 4.0 * largest, np.inf)
    ways = duration * np.maximum(largest, 2.0 * np.pi * turns)
    return float(ways.max(initial=0.0))


def swing_rate(tree: Tree, mass: float, experiment: Experiment, gravity: Array, rates: Array) -> float:
    """Estimate the rate of the motion of a linkage of a mass [kg] without prescribed motions, before the run [rad/s].

    It is the largest of the rates (n,) at the start [rad/s, m/s] or, if larger, the rate of a swing under the present
    forces: the square root of force over mass and length, for the weight, springs, constant loads and drives by torque
    or force. It does not depend on the duration, because the result of a run must not.
    """
    extent = tree.extent
    sliding = tree.bodies.records["type"] != REVOLUTE
    moved = tree.bodies.records["dof"][sliding]
    scale = np.ones(tree.size)
    scale[moved[moved >= 0]] = 1.0 / extent
    start = np.abs(rates * scale)[tree.joint_dofs]
    forces = [mass * float(np.linalg.norm(gravity))]
    parts = elements_of(experiment.elements)
    forces += [kind.force(keys, tree.mechanism.slides, extent) for kind, _, keys in parts]
    forces += [_magnitude(force.force) for force in experiment.forces.values()]
    forces += [_magnitude(torque.torque) / extent for torque in experiment.torques.values()]
    for drive in experiment.drives.values():
        forces += [_magnitude(drive.torque) / extent, _magnitude(drive.torques) / extent]
        forces += [_magnitude(drive.force), _magnitude(drive.forces)]
    swing = float(np.sqrt(max(forces) / (mass * extent))) if mass > 0.0 else 0.0
    return max(float(start.max(initial=0.0)), swing) or _UNKNOWN


def _magnitude(values: Any) -> float:
    """Return the largest magnitude of a number or list; zero for None."""
    return 0.0 if values is None else float(np.abs(values).max())
