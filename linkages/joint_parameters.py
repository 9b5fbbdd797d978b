"""From an experiment's joint models to the records that the force laws read."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.experiment import Experiment, JointModel
from linkages.laws import FILMS, PARAMETERS
from linkages.laws.parameters import SHEAR
from linkages.mechanism import Bearing
from linkages.planar.topology import Tree


def law_parameters(tree: Tree, experiment: Experiment) -> NDArray[np.record]:
    """One record of `PARAMETERS` for each clearance joint of the tree."""
    records: NDArray[np.record] = np.zeros(len(tree.play), PARAMETERS)
    for record, name in zip(records, tree.play, strict=True):
        bearing = tree.mechanism.joint[name].bearing
        if bearing is None:
            raise ValueError(f"joint {name} has no bearing")
        _fill(record, experiment.joints[name], bearing)
    return records


def _fill(record: Any, joint: JointModel, bearing: Bearing) -> None:
    record["clearance"] = joint.clearance
    record["radius"], record["length"] = bearing.radius, bearing.length
    record["film"] = FILMS[joint.film].code
    record["viscosity"] = joint.viscosity
    record["shear"] = SHEAR[joint.shear_film if joint.shear_torque else "none"]
    if joint.small_eccentricity is not None:
        record["small_eps"] = joint.small_eccentricity.ratio
        record["small_power"] = joint.small_eccentricity.power
