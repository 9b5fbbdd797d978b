"""Forward dynamics with prescribed joints: accelerations, the forces of the drives and the reactions of the loops."""

from __future__ import annotations

import numpy as np

from linkages.kernel import Array, Records, clear, kernel
from linkages.kernel.by_reference import reference
from linkages.planar.bodies import Bodies
from linkages.planar.closure_rows import add_row_wrench
from linkages.planar.kinematics import body_states
from linkages.planar.newton_euler import generalised_force, inertial_forces
from linkages.planar.singularities import stabilised_dynamics
from linkages.planar.workspace import workspace


@kernel
def constrained_dynamics(
    bodies: Bodies,
    rows: Records,
    rank: int,
    size: float,
    stabilisation: float,
    gravity: Array,
    q: Array,
    v: Array,
    wrench: Array,
    tau: Array,
    acceleration: Array,
    reaction: Array,
    loops: Array,
) -> None:
    """Find accelerations, drive forces and loop reactions at a state; see `stabilised_dynamics`.

    Parameters
    ----------
    rank : int
        Number of independent rows where the linkage is not singular.
    size : float
        Length of the linkage [m].
    stabilisation : float
        Rate at which deviations of loops decay [1/s].
    wrench : (nb, 3) array
        Applied wrenches on the bodies.
    tau : (n,) array
        Applied generalised forces of free joints; on return, of prescribed joints, the force they need.
    acceleration : (n,) array
        Prescribed accelerations; on return all of them.
    reaction : (nr,) array
        Filled with the reaction of each row; undefined where accelerations are interpolated near a singularity.
    loops : (n,) array
        Filled with the generalised forces of the loops, which are defined there too.
    """
    arrays = workspace(len(bodies.records), len(q), len(rows), bodies.shapes.shape[2])
    work = reference(arrays)
    work.q[:] = q
    work.v[:] = v
    work.tau[:] = tau
    work.wrench[:] = wrench
    for i in range(len(bodies.records)):
        if bodies.records[i].driven >= 0:
            work.a[bodies.records[i].dof] = acceleration[bodies.records[i].dof]
    body_states(bodies, q, v, work.pose, work.vel)
    stabilised_dynamics(bodies, rows, rank, size, stabilisation, gravity, work)
    needed = np.zeros(len(q))
    inertial_forces(bodies, work, gravity, work.bias, needed)
    generalised_force(bodies, work.pose, work.bias, needed)
    clear(work.wrench)
    for k in range(len(rows)):
        add_row_wrench(rows[k], work.pose, work.reaction[k], work.wrench)
    loops[:] = 0.0
    generalised_force(bodies, work.pose, work.wrench, loops)
    acceleration[:] = arrays.a
    reaction[:] = arrays.reaction
    for i in range(len(bodies.records)):
        d = bodies.records[i].dof
        if d >= 0 and bodies.records[i].driven >= 0:
            tau[d] = needed[d] - loops[d]
        elif d >= 0 and len(rows):
            loops[d] = needed[d] - tau[d]
