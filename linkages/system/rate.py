"""Time scale of a linkage without prescribed motions, known before the run: the error tolerance of rates refers to it.

It must not depend on the duration of a run, because the result of the run must not.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.arrays import Array
from linkages.planar.record_types import REVOLUTE
from linkages.system.unassembled import Unassembled

_UNKNOWN = 1.0  # rate for a linkage without motion and forces at the start [rad/s]


def motion_rate(system: Unassembled, rates: Array) -> float:
    """Estimate the rate of the motion of a linkage without prescribed motions [rad/s].

    It is the largest rate at the start or, if larger, the rate of a swing under the present forces: the square root of
    force over mass and length, for the weight, springs, constant loads and drives by torque or force.

    Parameters
    ----------
    system : Unassembled
    rates : (n,) array
        Rates of the tree's coordinates at the start [rad/s, m/s].
    """
    extent, experiment = system.tree.extent, system.experiment
    mass = sum(link.mass for link in system.mechanism.links)
    sliding = system.tree.bodies.records["type"] != REVOLUTE
    moved = system.tree.bodies.records["dof"][sliding]
    scale = np.ones(system.tree.size)
    scale[moved[moved >= 0]] = 1.0 / extent
    start = np.abs(rates * scale)[system.tree.joint_dofs]
    forces = [mass * float(np.linalg.norm(system.gravity))]
    forces += [spring.stiffness * extent for spring in experiment.springs.values()]
    for torsion in experiment.torsion_springs.values():
        slides = torsion.joint is not None and system.mechanism.joint[torsion.joint].type == "prismatic"
        forces.append(torsion.stiffness * extent if slides else torsion.stiffness / extent)
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
