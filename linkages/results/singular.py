"""Singular positions on or near a motion: change points and dead points of the closed loops."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from linkages.arrays import Array
from linkages.planar.arrays import Arrays
from linkages.planar.closure import jacobian_at
from linkages.results.akima import interpolated
from linkages.results.trajectory import Trajectory
from linkages.system.tree import Tree

#: Conditioning (smallest over largest singular value of the closure rows) below which a position counts as singular:
#: reactions are a thousand times larger than elsewhere, and rounding decides on the branch of the linkage.
NEAR = 1e-3

_MOST = 4000  # number of first samples
_ZOOMS, _POINTS = 4, 33  # refinements, and points of each, for the smallest ratio between samples
_TAKES_PART = 0.1  # smallest relative component of a joint in the motion with fixed drives
_NEARBY = 1e-3  # distance of the position at which the tangent of the motion is taken [rad, or linkage lengths]
_STEP = 1e-5  # of differences of the closure's Jacobian
_ALONE = 1e-2  # ratio of singular values of the second-order conditions above which no other branch fulfils them

#: Kinds of singular positions: a drive cannot continue; two branches cross; one branch passes, which the linkage could
#: leave to first order, but redundant loops forbid any other one.
DEAD_POINT, CHANGE_POINT, ONE_BRANCH = "dead point", "change point", "one branch"


class SingularPosition(NamedTuple):
    """A singular position on the motion, or the closest position to one."""

    time: float  # time of the position [s]
    quality: float  # conditioning: smallest over largest singular value of the closure's Jacobian; zero if singular
    joints: tuple[str, ...]  # coordinates of the tree that drives and loops leave free there
    kind: str  # `DEAD_POINT`, `CHANGE_POINT` or `ONE_BRANCH`


def singular_positions(tree: Tree, arrays: Arrays, motion: Trajectory) -> list[SingularPosition]:
    """Find the singular positions within `NEAR` of a motion, between its samples too, in the order of time.

    A position is singular if the closure rows, in the coordinates without prescribed motion, lose rank: the linkage can
    then move with fixed drives, or reactions exist without a load. The arrays are `System.arrays`, or
    `System.ideal_arrays` for the motion with ideal joints.
    """
    if not arrays.rank or len(motion.time) < 2:
        return []
    q = partial(interpolated, motion.time, np.stack([motion[f"q.{name}"] for name in tree.coordinates], axis=1))
    times = motion.time[:: 1 + len(motion.time) // _MOST]
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
            time, kind = float(between[best]), _kind(arrays, q, there, motion.time, between[best])
            found.append(SingularPosition(time, float(ratios[best]), _loose(tree, arrays, there), kind))
    return found


def _kind(arrays: Arrays, q: Callable[[Array], Array], there: Array, times: Array, time: float) -> str:
    """Classify a singular position by the second order of the closure.

    There the rows allow more directions than elsewhere, and have more reactions without load. A direction continues as
    a motion if the curvature of the rows along it is orthogonal to each such reaction. The tangent t of the motion
    fulfils this. With the further direction w, the sum x t + w fulfils it if a linear condition on x holds for each
    reaction. If the conditions contradict each other, there is no other branch.
    """
    rank, jacobian = arrays.rank, jacobian_at(arrays.bodies, arrays.rows, there)
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
        ends = (jacobian_at(arrays.bodies, arrays.rows, there + step * way) for step in (_STEP, -_STEP))
        return np.subtract(*ends) / (2.0 * _STEP)

    (w,) = further
    conditions = np.array([*(2.0 * slope(t) @ w for t in tangent), slope(w) @ w])
    first, *others = np.linalg.svd(conditions @ reactions.T, compute_uv=False)
    return ONE_BRANCH if max(others, default=0.0) > _ALONE * first else CHANGE_POINT


def _regular(q: Callable[[Array], Array], there: Array, times: Array, time: float) -> Array:
    """Return a regular position of the motion near a singular one."""
    ends = times[0] - time, times[-1] - time
    whole = max(ends, key=abs)
    for part in np.geomspace(1e-6, 1.0, 61):
        found = q(np.array([time + part * whole]))[0]
        if np.abs(found - there).max() > _NEARBY:
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
    return _quality(jacobians[:, :, arrays.free], arrays.rank)


def _quality(jacobians: Array, rank: int) -> Any:
    """Return the ratio of last to first of the `rank` largest singular values."""
    values = np.linalg.svd(jacobians, compute_uv=False)
    return values[..., rank - 1] / values[..., 0]


def _loose(tree: Tree, arrays: Arrays, q: Array) -> tuple[str, ...]:
    """Name the coordinates in the motion that drives and loops leave free."""
    direction = np.abs(np.linalg.svd(jacobian_at(arrays.bodies, arrays.rows, q)[:, arrays.free])[2][arrays.rank - 1])
    taking_part = arrays.free[direction > _TAKES_PART * direction.max()]
    return tuple(tree.coordinates[i] for i in taking_part)
