"""Gears that lock their joints: their ratios contradict each other, or the motion that the loops allow."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from linkages.arrays import Array, Records
from linkages.planar.closure import jacobian_at
from linkages.system.tree import Tree

_STILL = 1e-9  # largest motion of a joint that counts as none, relative to the motion without gears


def locking_gears(tree: Tree, rows: Records, q: Array) -> list[int]:
    """Find the gears that keep joints from moving which loops and fewer gears let move.

    Parameters
    ----------
    tree : Tree
    rows : array
        Closure rows, of the gears last: `Tree.closure_rows`, or `Tree.loop_rows` if joints have clearance.
    q : (n,) array
        Coordinates of a regular position.

    Returns
    -------
    list of int
        Gears by their index in `Tree.gears`; without one of them, another gear's joints could move.
    """
    gears = range(len(tree.gears))
    stuck = [k for k in gears if _moves(tree, rows, q, (), k) and not _moves(tree, rows, q, gears, k)]
    if len(stuck) < 2:
        return stuck
    return [k for k in stuck if any(_moves(tree, rows, q, [i for i in gears if i != k], j) for j in stuck if j != k)]


def _moves(tree: Tree, rows: Records, q: Array, kept: Collection[int], gear: int) -> bool:
    """Tell whether a joint of a gear can move with closed loops and some of the gears."""
    loops = len(rows) - len(tree.gears)
    kept_rows: Sequence[int] = [*range(loops), *(loops + k for k in kept)]
    ends = np.repeat(rows[loops + gear : loops + gear + 1], 2)
    ends["term"][1], ends["ratio"] = ends["other"][1], 0.0
    joints, columns = jacobian_at(tree.bodies, ends, q), tree.joint_dofs
    closed = jacobian_at(tree.bodies, rows[kept_rows], q)[:, columns]
    values, right = np.linalg.svd(closed)[1:] if len(closed) else (np.empty(0), np.eye(len(columns)))
    open_ways = right[int(np.count_nonzero(values > _STILL * values.max(initial=0.0))) :]
    return bool(np.abs(joints[:, columns] @ open_ways.T).max(initial=0.0) > _STILL)
