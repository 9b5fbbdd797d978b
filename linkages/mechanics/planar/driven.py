"""Forward dynamics with prescribed joints: accelerations, the forces of the drives and the reactions of the loops."""

from __future__ import annotations

from linkages.base.kernel import Array, Records, kernel
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.closure_rows import add_row_wrench
from linkages.mechanics.planar.kinematics import body_states
from linkages.mechanics.planar.newton_euler import generalised_force, inertial_forces
from linkages.mechanics.planar.singularities import stabilised_dynamics
from linkages.mechanics.planar.workspace import Workspace


@kernel
def constrained_dynamics(
    bodies: Bodies,
    rows: Records,
    rank: int,
    size: float,
    stabilisation: float,
    gravity: Array,
    work: Workspace,
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
    work : Workspace
        Its q, v, wrench, tau of the free joints, and a with the prescribed accelerations and zero for free joints; sets
        a, tau of the prescribed joints, and the reactions, which are undefined where accelerations are interpolated
        near a singularity. Uses the other fields.
    loops : (n,) array
        Filled with the generalised forces of the loops, which are defined near a singularity too.
    """
    body_states(bodies, work.q, work.v, work.pose, work.vel)
    stabilised_dynamics(bodies, rows, rank, size, stabilisation, gravity, work)
    needed = work.modal_response
    needed[:] = 0.0
    inertial_forces(bodies, work, gravity, work.bias, needed)
    generalised_force(bodies, work.pose, work.bias, needed)
    work.wrench[:] = 0.0
    for k in range(len(rows)):
        add_row_wrench(rows[k], work.pose, work.reaction[k], work.wrench)
    loops[:] = 0.0
    generalised_force(bodies, work.pose, work.wrench, loops)
    for i in range(len(bodies.records)):
        d = bodies.records[i].dof
        if d >= 0 and bodies.records[i].driven >= 0:
            work.tau[d] = needed[d] - loops[d]
        elif d >= 0 and len(rows):
            loops[d] = needed[d] - work.tau[d]
