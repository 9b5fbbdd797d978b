"""Where numbers of a motion have no meaning: near singular positions, and where reactions are indeterminate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.closure import jacobian_at
from linkages.mechanics.planar.contacts import WIDTH
from linkages.mechanics.planar.kinematics import body_positions
from linkages.mechanics.planar.reactions import joint_forces
from linkages.mechanics.planar.workspace import make_workspace
from linkages.results import numerics
from linkages.results.akima import interpolated
from linkages.results.characteristics import effort_of
from linkages.results.trajectory import Trajectory
from linkages.system import System
from linkages.system.rigid_segments import system_of

#: Conditioning (smallest over largest singular value of the closure rows) below which a position counts as singular:
#: reactions are a thousand times larger than elsewhere, and rounding decides on the branch of the linkage.
NEAR = 1e-3

_ZOOMS, _POINTS = 4, 33  # refinements, and points of each, for the smallest ratio between samples

#: Kinds of singular positions: a drive cannot continue; two branches cross; one branch passes, which the linkage could
#: leave to first order, but redundant loops forbid any other one.
DEAD_POINT, CHANGE_POINT, ONE_BRANCH = "dead point", "change point", "one branch"
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
        """Return the singular positions within `NEAR` of the motion, between its samples too, in the order of time.

        A position is singular if the closure rows, in the coordinates without prescribed motion, lose rank: the linkage
        can then move with fixed drives, or reactions exist without a load.
        """
        arrays, tree, motion = self.arrays, self.system.tree, self.motion
        if not arrays.elimination.rank or len(motion.time) < 2:
            return []
        q = partial(interpolated, motion.time, np.stack([motion[f"q.{name}"] for name in tree.coordinates], axis=1))
        times = motion.time[:: 1 + len(motion.time) // numerics.SOUNDNESS_MOST]
        quality = _qualities(arrays, q(times))
        found: list[SingularPosition] = []
        for k in _candidates(quality):
            low, high = times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)]
            for _ in range(_ZOOMS):
                between = np.linspace(low, high, _POINTS)
                ratios = _qualities(arrays, q(between))
                best = int(np.argmin(ratios))
                low, high = between[max(best - 1, 0)], between[min(best + 1, _POINTS - 1)]
            if ratios[best] < NEAR and (not found or between[best] > found[-1].time):
                there = q(between[best : best + 1])[0]
                jacobian = jacobian_at(arrays.bodies, arrays.rows, there)[:, arrays.free]
                way = np.abs(np.linalg.svd(jacobian)[2][arrays.elimination.rank - 1])
                loose = tuple(tree.coordinates[i] for i in arrays.free[way > numerics.SOUNDNESS_TAKES_PART * way.max()])
                kind = _kind(arrays, q, there, motion.time, between[best])
                found.append(SingularPosition(float(between[best]), float(ratios[best]), loose, kind))
        return found

    @cached_property
    def indeterminate(self) -> tuple[str, ...]:
        """Name the columns whose values are statically indeterminate.

        If there are more closure rows than independent ones, some reactions balance each other without any load: the
        null space of the rows' transposed Jacobian. A quantity with a part in such reactions depends on assembly
        tolerances and on elasticity. These are columns of joints (``P.force``, ``P.fx``, ``P.fy``, ``P.moment``),
        drives and couplings (``mesh.torque``, ``mesh.power``).
        """
        arrays, motion = self.arrays, self.motion
        if arrays.elimination.rank == len(arrays.rows):
            return ()
        q = np.stack([motion[f"q.{name}"] for name in self.system.tree.coordinates], axis=1)
        found: dict[str, bool] = {}
        for line in q[np.linspace(0, len(q) - 1, numerics.SOUNDNESS_LOOKS).astype(int)]:
            jacobian = jacobian_at(arrays.bodies, arrays.rows, line)[:, arrays.free]
            for reaction in np.linalg.svd(jacobian)[0].T[
                arrays.elimination.rank :
            ]:  # self-balanced: loads no free coordinate
                sizes = _sizes(self.system, arrays, line, reaction)
                least = numerics.SOUNDNESS_NOTHING * max(sizes.values())
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
        drives = self.system.drives if kinds == {ONE_BRANCH} else ()
        along = {f"{name}.{quantity}" for name in drives for quantity in ("torque", "power")}
        unbounded = {name for name in names if not name.startswith("q.") and name.rpartition(".")[2] not in bounded}
        return frozenset((unbounded - along).union(self.indeterminate))


def _sizes(system: System, arrays: Arrays, q: Array, reaction: Array) -> Mapping[str, float]:
    """Compute each column's magnitude under reactions alone [N]; moments over the linkage's length."""
    coupled = system.tree.coupled
    tables = {name: table for table, name in system.acting}
    work = make_workspace(len(arrays.bodies.records), len(q), len(arrays.rows), arrays.bodies.shapes.shape[2])
    body_positions(arrays.bodies, q, work.pose)
    work.reaction[:] = reaction
    forces, efforts = np.zeros((len(arrays.joints), 3)), np.zeros(len(arrays.driven) + len(arrays.powered))
    joint_forces(arrays, work, np.zeros((len(arrays.ends), WIDTH)), forces, efforts)
    sizes: dict[str, float] = {}
    for joint, (fx, fy, moment) in zip(system.joints, np.abs(forces).tolist(), strict=True):
        each = {"fx": fx, "fy": fy, "force": math.hypot(fx, fy), "moment": moment / arrays.size}
        sizes |= {f"{joint}.{quantity}": size for quantity, size in each.items()}
    for name, effort in zip(system.tree.driven, np.abs(efforts).tolist(), strict=False):
        size = effort / arrays.size if system.joints[name].type == "revolute" else effort
        sizes |= {f"{name}.torque": size, f"{name}.power": size}
    for name, effort in zip(coupled, np.abs(reaction[len(reaction) - len(coupled) :]).tolist(), strict=True):
        quantity = effort_of(system, tables[name], name)
        size = effort / arrays.size if quantity == "torque" else effort
        sizes |= {f"{name}.{quantity}": size, f"{name}.power": size}
    return sizes


class SingularPosition(NamedTuple):
    """A singular position on the motion, or the closest position to one."""

    time: float  # time of the position [s]
    quality: float  # conditioning: smallest over largest singular value of the closure's Jacobian; zero if singular
    joints: tuple[str, ...]  # coordinates of the tree that drives and loops leave free there
    kind: str  # `DEAD_POINT`, `CHANGE_POINT` or `ONE_BRANCH`


def _kind(arrays: Arrays, q: Callable[[Array], Array], there: Array, times: Array, time: float) -> str:
    """Classify a singular position by the second order of the closure.

    There the rows allow more directions than elsewhere, and have more reactions without load. A direction continues as
    a motion if the curvature of the rows along it is orthogonal to each such reaction. The tangent t of the motion
    fulfils this. With the further direction w, the sum x t + w fulfils it if a linear condition on x holds for each
    reaction. If the conditions contradict each other, there is no other branch.
    """
    rank, jacobian = arrays.elimination.rank, jacobian_at(arrays.bodies, arrays.rows, there)
    left, values, right = np.linalg.svd(jacobian)
    here = int(np.count_nonzero(values > NEAR * values[0]))
    if here >= rank:
        return DEAD_POINT
    kernel, reactions = right[here:], left.T[here:]
    regular = _regular(q, there, times, time)
    tangent = np.linalg.svd(jacobian_at(arrays.bodies, arrays.rows, regular))[2][rank:]
    inner, _, outer = np.linalg.svd(tangent @ kernel.T)
    tangent, further = outer[: len(inner)] @ kernel, outer[len(inner) :] @ kernel
    if len(further) != 1:
        return CHANGE_POINT
    driven = np.setdiff1d(np.arange(len(there)), arrays.free)
    if len(driven) and _quality(tangent[:, driven].T, len(driven)) < NEAR:
        return DEAD_POINT

    def slope(way: Array) -> Array:
        ends = (
            jacobian_at(arrays.bodies, arrays.rows, there + step * way)
            for step in (numerics.SOUNDNESS_STEP, -numerics.SOUNDNESS_STEP)
        )
        return np.subtract(*ends) / (2.0 * numerics.SOUNDNESS_STEP)

    (w,) = further
    conditions = np.array([*(2.0 * slope(t) @ w for t in tangent), slope(w) @ w])
    first, *others = np.linalg.svd(conditions @ reactions.T, compute_uv=False)
    return ONE_BRANCH if max(others, default=0.0) > numerics.SOUNDNESS_ALONE * first else CHANGE_POINT


def _regular(q: Callable[[Array], Array], there: Array, times: Array, time: float) -> Array:
    """Return a regular position of the motion near a singular one."""
    ends = times[0] - time, times[-1] - time
    whole = max(ends, key=abs)
    for part in np.geomspace(1e-6, 1.0, 61):
        found = q(np.array([time + part * whole]))[0]
        if np.abs(found - there).max() > numerics.SOUNDNESS_NEARBY:
            return found
    return there


def _candidates(quality: Array) -> list[int]:
    """Find the samples near which the conditioning can reach zero: local minima, extrapolated by the slope."""
    left = np.concatenate([[np.inf], quality[:-1]])
    right = np.concatenate([quality[1:], [np.inf]])
    lowest = (quality <= left) & (quality < right) | (quality < NEAR)
    fall = np.maximum(*(np.where(np.isfinite(x), x - quality, 0.0) for x in (left, right)))
    near = np.flatnonzero(lowest & (quality - 2.0 * fall < NEAR))
    # one of each group of neighbours
    return [
        int(run[np.argmin(quality[run])]) for run in np.split(near, np.flatnonzero(np.diff(near) > 1) + 1) if len(run)
    ]


def _qualities(arrays: Arrays, q: Array) -> Array:
    """Compute the conditioning of the closure's Jacobian in free coordinates at each line of q."""
    jacobians = np.stack([jacobian_at(arrays.bodies, arrays.rows, line) for line in q])
    return _quality(jacobians[:, :, arrays.free], arrays.elimination.rank)


def _quality(jacobians: Array, rank: int) -> Any:
    """Return the ratio of last to first of the `rank` largest singular values."""
    values = np.linalg.svd(jacobians, compute_uv=False)
    return values[..., rank - 1] / values[..., 0]
