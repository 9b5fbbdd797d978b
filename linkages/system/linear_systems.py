"""Systems whose linear models are computed: held at zero velocity in a pose, or with changed inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.elements.machine import KINDS, all_elements_of, record_of
from linkages.mechanics.planar.motion import Motions, raised
from linkages.system.assembly import Assembly
from linkages.system.deflection import deflected
from linkages.system.feedforward import with_feedforward
from linkages.system.ideal_motion import IdealMotion
from linkages.system.load_records import Packed, pack_loads
from linkages.system.system import System

#: Tables of an experiment that a static linkage omits, because their laws are not linear.
LEFT_OUT = tuple(kind.table for kind in KINDS if not kind.linear)


@dataclass(frozen=True, eq=False)
class StaticSystem(System):
    """A linkage held in a pose of undeformed links; made by `static_systems`.

    Attributes
    ----------
    pose : Assembly
    time : float
        Time of its loads [s].
    """

    pose: Assembly = field(kw_only=True)
    time: float = field(kw_only=True)

    @cached_property
    def assembly(self) -> Assembly:
        """Assemble in the pose; links with a quasi-static start are deflected by the loads at zero velocity."""
        return deflected(self.ideal_linkage, self.pose, self.experiment.source, self.time)


def static_systems(system: System, times: Sequence[float]) -> list[StaticSystem]:
    """Hold a linkage in the poses of its drives at some times.

    Joints with clearance and gears with backlash become ideal, flexible links stay flexible, and loads are evaluated at
    these times. Friction, stops and unilateral contacts are omitted. InputError if a time [s] other than 0 is given and
    the prescribed drives do not determine the motion; AssemblyError if the linkage cannot be assembled in one of the
    poses.
    """
    experiment = system.experiment
    plain: dict[str, object] = {f"joints.{name}": {"model": "ideal"} for name in experiment.joints}
    plain |= {table: {} for table in LEFT_OUT if getattr(experiment, table)} | experiment.perfected(rigid=False)
    plain |= {"start": "centred", "solver.integrator": "radau_iia_5", "duration": max(experiment.duration, *times, 0.0)}
    ideal = system.replaced(plain)
    at = np.array(times, dtype=np.float64)
    if ideal.determinate and ideal.tree.driven:
        poses = IdealMotion(ideal).states(at)[0]
    elif at.any():
        raise InputError(experiment.source, "drives", "do not determine the motion; only the pose at t = 0 is known")
    else:
        poses = np.repeat(ideal.assembly.q[None], len(at), axis=0)
    return [_held(ideal, q, float(t)) for q, t in zip(poses, at, strict=True)]


def _held(ideal: System, q: Array, time: float) -> StaticSystem:
    """Return a linkage with ideal joints held at coordinates (n,)."""
    tree, start = ideal.tree, ideal.assembly
    still = {
        f"drives.{name}": {"angle": float(q[dof]), "speed": 0.0}
        for name, dof in zip(tree.driven, tree.driven_dofs, strict=True)
    }
    held = ideal.replaced(still)
    pose = Assembly(q, np.zeros(len(q)), start.mobility, start.quality)
    return StaticSystem(held.mechanism, held.experiment, pose=pose, time=time)


# -- inputs ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, repr=False)
class Disturbed(System):
    """A system with changed inputs; made by `disturbed`.

    Added are efforts of powered joints by their index, and values by the index of an element's function [N m, N].
    """

    efforts: Mapping[int, float] = field(kw_only=True)
    applied: Mapping[int, float] = field(kw_only=True)
    _differs_in_laws_alone = False

    @cached_property
    def torques(self) -> Motions:
        """Return the torque histories of the powered joints."""
        pieces = super().torques.pieces
        return Motions([raised(piece, self.efforts.get(k, 0.0)) for k, piece in enumerate(pieces)])

    @cached_property
    def packed(self) -> Packed:
        """Return elements and applied loads as records of the kernels."""
        return pack_loads(self.tree, self.experiment, with_feedforward(self.mechanism, self.experiment), self.applied)


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
    tables = system.experiment.elements
    for kind, name, _ in all_elements_of(tables):
        if (applied := kind.applied) is not None:
            first = int(record_of(system.elements, tables, kind.table, name)[applied.field])
            units = enumerate(applied.units.items(), first)
            found |= {f"{name}.{key}": (unit, "applied", k) for k, (key, unit) in units}
    return found


def disturbed(system: System, name: str, value: float) -> Disturbed:
    """Add a constant to an input of `inputs`; the state at t = 0 stays the system's."""
    _, table, k = inputs(system)[name]
    changed: dict[str, dict[int, float]] = {"efforts": {}, "applied": {}}
    changed[table][k] = value
    return Disturbed(
        system.mechanism, system.experiment, system, efforts=changed["efforts"], applied=changed["applied"]
    )
