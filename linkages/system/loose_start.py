"""Start of prescribed motions that move loosely coupled joints against each other, within their free travel."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array, Indices, Records
from linkages.base.errors import InputError
from linkages.input.model.experiment import Experiment
from linkages.mechanics.planar.closure import TOLERANCE, jacobian_at
from linkages.mechanics.planar.closure_rows import row_rate
from linkages.mechanics.planar.kinematics import state_tables
from linkages.system.tree import Tree

_ROUNDS = 50  # most steps of the search
_SMALL = 1e-12  # last step of the search [rad, or linkage lengths]
_BEYOND = 1e-9  # relative excess over the free travel that is rounding


def tight_rows(tree: Tree) -> Records:
    """Return the closure rows without the loose couplings."""
    return tree.closure_rows[_tight(tree)]


def settle_within_travel(
    tree: Tree, free: Indices, offset: Array, held: Indices, places: Array, steps: int, q: Array
) -> bool:
    """Move held coordinates from zero to places, and free ones to the middle of the loose couplings, as near as can be.

    All joints stay closed, with the offsets (nr,) of the closure rows. Sets q (n,); returns False if they do not close.
    """
    for k in range(1, steps + 1) if steps else (1,):
        q[held] = (k / steps if steps else 1.0) * places
        for _ in range(_ROUNDS):
            step = _nearest(tree, jacobian_at(tree.bodies, tree.closure_rows, q)[:, free], offset - tree.gaps(q))
            q[free] += step
            if np.abs(step).max(initial=0.0) <= _SMALL * max(1.0, tree.extent):
                break
    open_by = (tree.gaps(q) - offset)[_tight(tree)]
    return bool(np.abs(open_by).max(initial=0.0) <= 1e3 * TOLERANCE * tree.extent)


def settled_rates(tree: Tree, free: Indices, q: Array, v: Array) -> None:
    """Set the free ones of the rates v (n,), with which loose couplings move least within their travel."""
    v[free] = 0.0
    pose, vel = (table[0] for table in state_tables(tree.bodies, q[None], v[None]))
    rates = np.array([row_rate(row, pose, vel) for row in tree.closure_rows])
    v[free] = _nearest(tree, jacobian_at(tree.bodies, tree.closure_rows, q)[:, free], -rates)


def check_within_travel(tree: Tree, experiment: Experiment, q: Array) -> None:
    """Refuse prescribed motions that start beyond the free travel of a loose coupling."""
    gaps = np.abs(np.delete(tree.gaps(q), _tight(tree)))
    for (name, one), gap in zip(tree.loose.items(), gaps.tolist(), strict=True):
        most = 0.5 * (one.width or 0.0)
        if gap > (1.0 + _BEYOND) * most:
            unit = "rad" if tree.mechanism.joint[one.joints[1]].type == "revolute" else "m"
            start = (
                f"start {gap:.4g} {unit} from the middle of the {one.travel} of {name}, which allows {most:.4g} {unit}"
            )
            raise InputError(experiment.source, "drives", f"{start}; change a start, or drive fewer joints")


def _tight(tree: Tree) -> Indices:
    """Return the closure rows of joints and of exact couplings, by index."""
    loose = len(tree.closure_rows) - len(tree.loop_rows) - len(tree.loose)
    return np.delete(np.arange(len(tree.closure_rows)), slice(loose, loose + len(tree.loose)))


def _nearest(tree: Tree, jacobian: Array, wanted: Array) -> Array:
    """Solve the tight rows exactly, and the loose couplings by least squares; the smallest solution."""
    tight = _tight(tree)
    closing, (loose, rest) = jacobian[tight], (np.delete(table, tight, axis=0) for table in (jacobian, wanted))
    exact = np.linalg.lstsq(closing, wanted[tight], rcond=None)[0]
    open_ways = np.linalg.svd(closing)[2][np.linalg.matrix_rank(closing) if closing.size else 0 :].T
    return np.asarray(exact + open_ways @ np.linalg.lstsq(loose @ open_ways, rest - loose @ exact, rcond=None)[0])
