"""A system that stands still in a pose, its prescribed joints held and every joint ideal: what modes are those of."""

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

#: Tables of an experiment that a standing linkage is without: none of them acts linearly.
LEFT_OUT = ("frictions", "stops", "contacts")


@dataclass(frozen=True, eq=False)
class Standing(System):
    """A linkage in a pose; make it by `standing`.

    Attributes
    ----------
    pose : Assembly
        With links as they are before loads bend them.
    time : float
        At which loads act [s].
    """

    pose: Assembly = field(kw_only=True)
    time: float = field(kw_only=True)

    @cached_property
    def assembly(self) -> Assembly:
        """The pose, with links whose start is quasi-static bent by the loads at rest.

        Raises
        ------
        InputError
            If the loads are beyond those that buckle a link.
        """
        return deflected(self, self.pose, self.time) if self.tree.bent else self.pose


def standing(system: System, times: Sequence[float]) -> list[Standing]:
    """Hold a linkage in the poses of its drives at some times.

    Joints with clearance are ideal, links that bend stay so, and loads are those of the times. Frictions, stops and
    contacts are left out.

    Parameters
    ----------
    system : System
    times : sequence of float
        [s]; 0 alone where the prescribed drives do not determine the motion.

    Raises
    ------
    InputError
        If the motion is not determined at other times than 0.
    AssemblyError
        If the linkage cannot be assembled in one of the poses.
    """
    experiment = system.experiment
    plain: dict[str, object] = {f"joints.{name}": {"model": "ideal"} for name in experiment.joints}
    plain |= {table: {} for table in LEFT_OUT if getattr(experiment, table)}
    plain |= {"start": "centred", "solver.integrator": "radau3", "duration": max(experiment.duration, *times, 0.0)}
    ideal = system.replaced(plain)
    at = np.array(times, dtype=np.float64)
    if ideal.determinate and ideal.tree.driven:
        poses = IdealMotion(ideal).states(at)[0]
    elif at.any():
        raise InputError(experiment.source, "drives", "do not determine the motion; its poses are known at t = 0 alone")
    else:
        poses = np.repeat(ideal.assembly.q[None], len(at), axis=0)
    return [_held(ideal, q, float(t)) for q, t in zip(poses, at, strict=True)]


def _held(ideal: System, q: Array, time: float) -> Standing:
    """Return a linkage with ideal joints that stands at coordinates (n,)."""
    tree, start = ideal.tree, ideal.assembly
    still = {
        f"drives.{name}": {"angle": float(q[dof]), "speed": 0.0}
        for name, dof in zip(tree.driven, tree.driven_dofs, strict=True)
    }
    held = ideal.replaced(still)
    pose = Assembly(q, np.zeros(len(q)), start.mobility, start.quality)
    return Standing(held.mechanism, held.experiment, pose=pose, time=time)
