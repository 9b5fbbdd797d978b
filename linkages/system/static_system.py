"""A linkage with ideal joints held at zero velocity in a pose: the system whose natural modes are computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from linkages.arrays import Array
from linkages.errors import InputError
from linkages.system.assembly import Assembly
from linkages.system.deflection import deflected
from linkages.system.ideal_motion import IdealMotion
from linkages.system.system import System

#: Tables of an experiment that a static linkage omits, because their laws are not linear.
LEFT_OUT = ("frictions", "stops", "contacts")


@dataclass(frozen=True, eq=False)
class StaticSystem(System):
    """A linkage held in a pose of undeformed links, with its loads at a time [s]; made by `static_systems`."""

    pose: Assembly = field(kw_only=True)
    time: float = field(kw_only=True)

    @cached_property
    def assembly(self) -> Assembly:
        """Assemble in the pose; links with a quasi-static start are deflected by the loads at zero velocity."""
        return deflected(self, self.pose, self.time) if self.tree.flexible else self.pose


def static_systems(system: System, times: Sequence[float]) -> list[StaticSystem]:
    """Hold a linkage in the poses of its drives at some times.

    Joints with clearance become ideal, flexible links stay flexible, and loads are evaluated at these times. Friction,
    stops and unilateral contacts are omitted. InputError if a time [s] other than 0 is given and the prescribed drives
    do not determine the motion; AssemblyError if the linkage cannot be assembled in one of the poses.
    """
    experiment = system.experiment
    plain: dict[str, object] = {f"joints.{name}": {"model": "ideal"} for name in experiment.joints}
    plain |= {table: {} for table in LEFT_OUT if getattr(experiment, table)}
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
