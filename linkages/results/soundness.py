"""Where numbers of a motion have no meaning: near singular positions, and where reactions are indeterminate."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from linkages.arrays import Array
from linkages.planar.arrays import Arrays
from linkages.planar.closure import jacobian_at
from linkages.planar.contacts import WIDTH
from linkages.planar.kinematics import body_positions
from linkages.planar.reactions import joint_forces
from linkages.planar.workspace import make_workspace
from linkages.results.characteristics import effort_of
from linkages.results.singular import CHANGE_POINT, DEAD_POINT, ONE_BRANCH, SingularPosition, singular_positions
from linkages.results.trajectory import Trajectory
from linkages.system import System
from linkages.system.rigid_segments import system_of

_LOOKS = 5  # number of examined positions of the motion
_NOTHING = 1e-6  # relative threshold of a quantity in self-balanced reactions
_POSITIONS = frozenset({"x", "y", "angle", "eccentricity_ratio"})
_VELOCITIES = frozenset({"vx", "vy", "omega", "rate"})
#: Outputs that stay bounded at a singular position, by its kind, the worst first.
BOUNDED = {
    DEAD_POINT: _POSITIONS,
    CHANGE_POINT: _POSITIONS | _VELOCITIES,
    ONE_BRANCH: _POSITIONS | _VELOCITIES | {"ax", "ay", "alpha"},
}


@dataclass(frozen=True, eq=False)
class Soundness:
    """Singular positions and indeterminate columns of one motion."""

    system: System  # system with the motion's coordinates
    arrays: Arrays  # its arrays, or `System.ideal_arrays` for the motion with ideal joints
    motion: Trajectory

    @classmethod
    def of_run(cls, system: System, run: Trajectory) -> Soundness:
        """Examine a run of a system."""
        moved = system_of(system, run.columns)
        return cls(moved, moved.arrays, run)

    @classmethod
    def of_ideal(cls, system: System, motion: Trajectory) -> Soundness:
        """Examine the motion of a system with ideal joints."""
        if system.determinate:
            return cls(system, system.ideal_arrays, motion)
        return cls.of_run(system.ideal(), motion)

    @cached_property
    def singular(self) -> list[SingularPosition]:
        """Return the singular positions of the closed loops on or near the motion."""
        return singular_positions(self.system.tree, self.arrays, self.motion)

    @cached_property
    def indeterminate(self) -> tuple[str, ...]:
        """Name the columns whose values are statically indeterminate.

        If there are more closure rows than independent ones, some reactions balance each other without any load: the
        null space of the rows' transposed Jacobian. A quantity with a part in such reactions depends on assembly
        tolerances and on elasticity. These are columns of joints (``P.force``, ``P.fx``, ``P.fy``, ``P.moment``),
        drives and gears (``mesh.torque``, ``mesh.power``).
        """
        arrays, motion = self.arrays, self.motion
        if arrays.rank == len(arrays.rows):
            return ()
        q = np.stack([motion[f"q.{name}"] for name in self.system.tree.coordinates], axis=1)
        found: dict[str, bool] = {}
        for line in q[np.linspace(0, len(q) - 1, _LOOKS).astype(int)]:
            jacobian = jacobian_at(arrays.bodies, arrays.rows, line)[:, arrays.free]
            for reaction in np.linalg.svd(jacobian)[0].T[arrays.rank :]:  # self-balanced: loads no free coordinate
                sizes = _sizes(self.system, arrays, line, reaction)
                least = _NOTHING * max(sizes.values())
                found |= {column: found.get(column, False) or size > least for column, size in sizes.items()}
        return tuple(column for column, takes_part in found.items() if takes_part)

    def meaningless(self, names: Iterable[str]) -> frozenset[str]:
        """Select the columns with meaningless peaks, and all that are statically indeterminate.

        A column is unbounded at a singular position unless its quantity is listed in `BOUNDED`. The torques of the
        drives are bounded where one branch passes, as they move the linkage along it.
        """
        kinds = {position.kind for position in self.singular}
        if not kinds:
            return frozenset(self.indeterminate)
        bounded = frozenset.intersection(*(frozenset(BOUNDED[kind]) for kind in kinds))
        drives = self.system.experiment.drives if kinds == {ONE_BRANCH} else ()
        along = {f"{name}.{quantity}" for name in drives for quantity in ("torque", "power")}
        unbounded = {name for name in names if not name.startswith("q.") and name.rpartition(".")[2] not in bounded}
        return frozenset((unbounded - along).union(self.indeterminate))


def _sizes(system: System, arrays: Arrays, q: Array, reaction: Array) -> Mapping[str, float]:
    """Compute each column's magnitude under reactions alone [N]; moments over the linkage's length."""
    mechanism, gears = system.mechanism, system.experiment.gears
    work = make_workspace(len(arrays.bodies.records), len(q), len(arrays.rows), arrays.bodies.shapes.shape[2])
    body_positions(arrays.bodies, q, work.pose)
    work.reaction[:] = reaction
    forces, efforts = np.zeros((len(arrays.joints), 3)), np.zeros(len(arrays.driven) + len(arrays.powered))
    joint_forces(arrays, work, np.zeros((len(arrays.ends), WIDTH)), forces, efforts)
    sizes: dict[str, float] = {}
    for joint, (fx, fy, moment) in zip(mechanism.joints, np.abs(forces).tolist(), strict=True):
        each = {"fx": fx, "fy": fy, "force": math.hypot(fx, fy), "moment": moment / arrays.size}
        sizes |= {f"{joint.name}.{quantity}": size for quantity, size in each.items()}
    for name, effort in zip(system.tree.driven, np.abs(efforts).tolist(), strict=False):
        size = effort / arrays.size if mechanism.joint[name].type == "revolute" else effort
        sizes |= {f"{name}.torque": size, f"{name}.power": size}
    for name, effort in zip(gears, np.abs(reaction[len(reaction) - len(gears) :]).tolist(), strict=True):
        quantity = effort_of(system, "gears", name)
        size = effort / arrays.size if quantity == "torque" else effort
        sizes |= {f"{name}.{quantity}": size, f"{name}.power": size}
    return sizes
