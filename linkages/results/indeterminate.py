"""Joints whose forces the motion does not determine: reactions of redundant loops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.planar.arrays import Arrays
from linkages.planar.bodies import make_pose
from linkages.planar.closure import closure_jacobian
from linkages.planar.contacts import WIDTH
from linkages.planar.dynamics import make_workspace
from linkages.planar.kinematics import body_positions
from linkages.planar.reactions import joint_forces
from linkages.results.trajectory import Trajectory
from linkages.system import System

Array = NDArray[np.float64]

_POSITIONS = 5  # of the motion that are looked at
_NOTHING = 1e-6  # of the largest: part of a joint in a set of reactions that balance by themselves


def indeterminate(system: System, arrays: Arrays, motion: Trajectory) -> tuple[str, ...]:
    """Name the joints and drives whose force or torque is statically indeterminate.

    More closure rows than are independent have reactions that balance by themselves, without any load: the null space
    of the rows' transposed Jacobian. A joint in which such reactions pass has a force that depends on how the links
    were fitted together, and on their elasticity.

    Parameters
    ----------
    system : System
    arrays : Arrays
        `System.arrays`, or `System.ideal_arrays` for the motion with ideal joints.
    motion : Trajectory
        With columns ``q.COORDINATE``.

    Returns
    -------
    tuple of str
        In the order of the mechanism; empty for loops that are not redundant.
    """
    if arrays.rank == len(arrays.rows):
        return ()
    tree = system.tree
    q = np.stack([motion[f"q.{name}"] for name in tree.coordinates], axis=1)
    names = [*(joint.name for joint in system.mechanism.joints), *tree.driven]
    taking_part = np.zeros(len(names), dtype=bool)
    for line in q[np.linspace(0, len(q) - 1, _POSITIONS).astype(int)]:
        for reaction in _self_balanced(arrays, line):
            size = _sizes(arrays, line, reaction)
            taking_part |= size > _NOTHING * size.max()
    return tuple(dict.fromkeys(name for name, part in zip(names, taking_part, strict=True) if part))


def _self_balanced(arrays: Arrays, q: Array) -> Array:
    """Reactions of the rows that load no free coordinate, as lines."""
    pose = make_pose(arrays.bodies)
    body_positions(arrays.bodies, q, pose)
    jacobian = closure_jacobian(arrays.bodies, arrays.rows, pose, len(q))[:, arrays.free]
    return np.linalg.svd(jacobian)[0].T[arrays.rank :]


def _sizes(arrays: Arrays, q: Array, reaction: Array) -> Array:
    """Force in each joint [N], then effort of each prescribed drive over the linkage's length, of reactions alone."""
    work = make_workspace(len(arrays.bodies.records), len(q), len(arrays.rows), arrays.bodies.shapes.shape[2])
    body_positions(arrays.bodies, q, work.pose)
    work.reaction[:] = reaction
    forces, efforts = np.zeros((len(arrays.joints), 3)), np.zeros(len(arrays.driven) + len(arrays.powered))
    joint_forces(arrays, work, np.zeros((len(arrays.ends), WIDTH)), forces, efforts)
    return np.concatenate([np.hypot(*forces[:, :2].T), np.abs(efforts[: len(arrays.driven)]) / arrays.size])
