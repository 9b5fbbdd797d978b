"""Singular positions on or near a motion: change points and dead points of the closed loops."""

from __future__ import annotations

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


class Passage(NamedTuple):
    """A singular position on the motion, or the closest position to one.

    Attributes
    ----------
    time : float
        Time of the position [s].
    quality : float
        Conditioning: smallest over largest singular value of the closure's Jacobian; zero if singular.
    joints : tuple of str
        Coordinates of the tree that drives and loops leave free there.
    unique : bool
        Whether the linkage has one branch there (a dead point, where a drive cannot continue), or two branches
        cross (a change point).
    """

    time: float
    quality: float
    joints: tuple[str, ...]
    unique: bool


def passages(tree: Tree, arrays: Arrays, motion: Trajectory) -> list[Passage]:
    """Find the singular positions within `NEAR` of a motion, between its samples too.

    A position is singular if the closure rows, in the coordinates without prescribed motion, lose rank: the linkage can
    then move with fixed drives, or reactions exist without a load.

    Parameters
    ----------
    tree : Tree
        Tree of the moving system.
    arrays : Arrays
        `System.arrays`, or `System.ideal_arrays` for the motion with ideal joints.
    motion : Trajectory
        Motion with columns ``q.COORDINATE``.

    Returns
    -------
    list of Passage
        Positions in the order of time.
    """
    if not arrays.rank or len(motion.time) < 2:
        return []
    q = partial(interpolated, motion.time, np.stack([motion[f"q.{name}"] for name in tree.coordinates], axis=1))
    times = motion.time[:: 1 + len(motion.time) // _MOST]
    quality = _qualities(arrays, q(times))
    found: list[Passage] = []
    for k in _candidates(quality):
        low, high = times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)]
        for _ in range(_ZOOMS):
            between = np.linspace(low, high, _POINTS)
            ratios = _qualities(arrays, q(between))
            best = int(np.argmin(ratios))
            low, high = between[max(best - 1, 0)], between[min(best + 1, _POINTS - 1)]
        if ratios[best] < NEAR and (not found or between[best] > found[-1].time):
            there = q(between[best : best + 1])[0]
            unique = bool(_quality(jacobian_at(arrays.bodies, arrays.rows, there), arrays.rank) > NEAR)
            found.append(Passage(float(between[best]), float(ratios[best]), _loose(tree, arrays, there), unique))
    return found


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
