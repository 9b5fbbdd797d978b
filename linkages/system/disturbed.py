"""A system with constants added to its drives' torques and to its applied loads: the inputs of a linearisation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from linkages.planar.loads import Loads
from linkages.planar.motion import Motions, raised
from linkages.system.load_records import pack_loads
from linkages.system.system import System


@dataclass(frozen=True, eq=False, repr=False)
class Disturbed(System):
    """A system with changed inputs; made by `disturbed`.

    Added are efforts of powered joints by their index, and values by the index of the loads' function [N m, N].
    """

    efforts: Mapping[int, float] = field(kw_only=True)
    applied: Mapping[int, float] = field(kw_only=True)

    @cached_property
    def torques(self) -> Motions:
        """Return the torque histories of the powered joints."""
        pieces = super().torques.pieces
        return Motions([raised(piece, self.efforts.get(k, 0.0)) for k, piece in enumerate(pieces)])

    @cached_property
    def loads(self) -> Loads:
        """Return the applied loads as records of the kernels."""
        return pack_loads(self.tree, self.experiment, self.applied)


def inputs(system: System) -> dict[str, tuple[str, str, int]]:
    """List the inputs of a system: name, then unit, field of `Disturbed`, and index there.

    They are the torques (prismatic joints: forces) of drives without prescribed motion, ``DRIVE.torque``, and applied
    loads: ``TORQUE.torque``, ``FORCE.fx`` and ``FORCE.fy``, the components in the force's own axes.
    """
    joints = system.mechanism.joint
    found = {
        f"{name}.torque": ("N m" if joints[name].type == "revolute" else "N", "efforts", k)
        for k, name in enumerate(system.tree.powered)
    }
    for (table, name), record in zip(system.experiment.loads, system.loads[0], strict=True):
        if table == "forces":
            for k, axis in enumerate("xy"):
                found[f"{name}.f{axis}"] = ("N", "applied", int(record["motion"]) + k)
        elif table == "torques":
            found[f"{name}.torque"] = ("N m", "applied", int(record["motion"]))
    return found


def disturbed(system: System, name: str, value: float) -> Disturbed:
    """Add a constant to an input of `inputs`; the state at t = 0 stays the system's."""
    _, table, k = inputs(system)[name]
    changed: dict[str, dict[int, float]] = {"efforts": {}, "applied": {}}
    changed[table][k] = value
    return Disturbed(
        system.mechanism, system.experiment, system, efforts=changed["efforts"], applied=changed["applied"]
    )
