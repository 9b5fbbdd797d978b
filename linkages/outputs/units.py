"""Units of the columns of a run."""

from __future__ import annotations

from linkages.model.experiment import QUANTITIES
from linkages.model.mechanism import Mechanism

_UNITS = {name: meaning.rpartition("[")[2].rstrip("]") for name, meaning in QUANTITIES.items()} | {
    "fx": "N",
    "fy": "N",
    "force": "N",
    "moment": "N m",
    "torque": "N m",
    "ex": "m",
    "ey": "m",
    "eccentricity_ratio": "1",
    "penetration": "m",
    "closing": "m/s",
    "sliding": "m/s",
    "offset": "m",
    "tilt": "rad",
    "length": "m",
    "power": "W",
    "rate": "rad/s",
    "kinetic_energy": "J",
    "potential_energy": "J",
    "time": "s",
}


def unit(name: str, mechanism: Mechanism) -> str:
    """SI unit of a column (see `linkages.outputs.columns`); empty where the name does not tell it."""
    owner, _, quantity = name.rpartition(".")
    if owner in mechanism.joint and mechanism.joint[owner].type == "prismatic":
        prismatic = {"torque": "N", "rate": "m/s"}
        if quantity in prismatic:
            return prismatic[quantity]
    return _UNITS.get(quantity, "")
