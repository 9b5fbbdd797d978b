"""Reactions and accelerations of the ideal linkage under its loads and drives."""

from __future__ import annotations

import numpy as np

from linkages.arrays import Array
from linkages.planar.driven import constrained_dynamics
from linkages.planar.kinematics import body_states
from linkages.planar.loads import load_wrenches
from linkages.planar.workspace import Workspace
from linkages.system.unassembled import Unassembled


def ideal_forces(system: Unassembled, t: float, q: Array, v: Array, rank: int) -> Workspace:
    """Solve the ideal linkage at time t [s], coordinates q and rates v (n,), with modes that do not accelerate.

    Parameters
    ----------
    rank : int
        Number of independent closure rows.

    Returns
    -------
    Workspace
        Its pose, vel, a, tau and reaction, see `linkages.planar.driven.constrained_dynamics`.
    """
    tree, at = system.tree, np.array([t])
    work = tree.workspace(tree.closure_rows)
    work.q[:], work.v[:] = q, v
    body_states(tree.bodies, q, v, work.pose, work.vel)
    load_wrenches(system.loads, t, work.pose, work.vel, work.wrench)
    work.tau[tree.powered_dofs] = system.torques(at)[0][0]
    work.a[tree.driven_dofs] = system.motions(at)[2][0]
    constrained_dynamics(
        tree.undeforming_bodies, tree.closure_rows, rank, tree.extent, 0.0, system.gravity, work, np.zeros(tree.size)
    )
    return work
