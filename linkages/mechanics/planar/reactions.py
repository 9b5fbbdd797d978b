"""Forces in all joints and efforts of all drives, from the motion and the applied loads."""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import Array, Records, kernel, lazy_kernel
from linkages.mechanics.planar.arrays import Arrays
from linkages.mechanics.planar.closure import closure_jacobian, free_jacobian, solve_columns
from linkages.mechanics.planar.closure_rows import add_row_wrench
from linkages.mechanics.planar.contacts import COUPLE, FX, FY, add_contact
from linkages.mechanics.planar.elimination import factorise_rows, set_row_matrix, solve_rows
from linkages.mechanics.planar.kinematics import joint_force
from linkages.mechanics.planar.markers import arm, gap, turned
from linkages.mechanics.planar.newton_euler import generalised_force, joint_wrenches
from linkages.mechanics.planar.record_types import FIXED, OF_JOURNAL, OF_ROWS, OF_TREE, PRISMATIC, REVOLUTE
from linkages.mechanics.planar.workspace import Workspace

_CORNERS = 4


@kernel
def add_known_contacts(ends: Records, contacts: Array, pose: Array, wrench: Array) -> None:
    """Add the force pairs of contacts whose `CLEARANCE_OUTPUTS` (nc, WIDTH) are known."""
    for k in range(len(ends)):
        ex, ey, arms = gap(pose, ends[k].bearing, ends[k].journal)
        add_contact(wrench, ends[k], pose, ex, ey, arms, contacts[k, FX], contacts[k, FY], contacts[k, COUPLE])


@lazy_kernel(makes_arrays=True)
def row_reactions(model: Arrays, work: Workspace) -> None:
    """Find the reactions of the closure rows for which the free coordinates need no other force.

    Takes `work`'s pose, tau, and bias and shape_bias of `linkages.mechanics.planar.newton_euler.inertial_forces`; sets
    the reactions. Statically indeterminate reactions are one solution of many, see `linkages.results.soundness`.
    """
    bodies, rows, free, n = model.bodies, model.rows, model.free, len(work.tau)
    needed, used = work.shape_bias.copy(), work.bias.copy()
    generalised_force(bodies, work.pose, used, needed)
    for i in range(n):
        needed[i] -= work.tau[i]
    nr = len(rows)
    if nr == len(free) == model.elimination.rank:
        jacobian, across, rhs = np.empty((nr, nr)), np.empty((nr, nr)), np.empty(nr)
        free_jacobian(bodies, rows, work.pose, n, free, jacobian)
        for i in range(nr):
            rhs[i] = needed[free[i]]
            for k in range(nr):
                across[i, k] = jacobian[k, i]
        solve_columns(across, rhs, work.reaction)
        return
    closure_jacobian(bodies, rows, work.pose, work.row_force)  # least squares: as many equations as coordinates
    coordinates = model.elimination.coordinates
    for k in range(nr):
        work.row_error[k] = 0.0
        for place in range(coordinates.first[k], coordinates.first[k + 1]):
            i = coordinates.entries[place]
            work.row_error[k] += work.row_force[k, i] * needed[i]
    set_row_matrix(rows, model.elimination, work.row_force, work.row_force, work.row_matrix, work.pivots)
    factorise_rows(model.elimination, work.row_matrix, work.pivots)
    solve_rows(rows, work.row_matrix, work.pivots, work.row_error, work.reaction)


@kernel
def ideal_joint_force(joint: np.record, pose: Array, load: Array, reaction: Array) -> tuple[float, float, float]:
    """Force [N] and moment about the joint [N m] on the child of an ideal joint, its drive's effort left out.

    ``load`` (nb, 3) are the wrenches that bodies get through their joints, ``reaction`` (nr,) the rows' reactions.
    """
    at = joint.at
    if joint.source == OF_ROWS:
        fx, fy, moment = reaction[at], reaction[at + 1], 0.0
        if joint.type == PRISMATIC:
            nx, ny = turned(pose, joint.parent, -joint.uy, joint.ux)
            return reaction[at] * nx, reaction[at] * ny, reaction[at + 1]
        if joint.type == FIXED:
            return fx, fy, reaction[at + 2]
        return fx, fy, moment
    rx, ry = arm(pose, joint.child)
    b = joint.child.body
    ox, oy = pose[at, 0] - pose[b, 0] - rx, pose[at, 1] - pose[b, 1] - ry
    fx, fy = load[at, 1], load[at, 2]
    moment = load[at, 0] + ox * fy - oy * fx
    if joint.reversed:
        fx, fy, moment = -fx, -fy, -moment
    if joint.type == REVOLUTE:  # the moment is its drive's
        return fx, fy, 0.0
    if joint.type == PRISMATIC:
        ux, uy = turned(pose, joint.parent, joint.ux, joint.uy)
        free = fx * ux + fy * uy
        return fx - free * ux, fy - free * uy, moment
    return fx, fy, moment


@kernel
def joint_forces(model: Arrays, work: Workspace, contacts: Array, forces: Array, efforts: Array) -> None:
    """Fill the forces in all joints and the efforts of all drives.

    Takes `work`'s pose, tau, reaction, and bias of `linkages.mechanics.planar.newton_euler.inertial_forces`; on return
    the bias is the wrench that each body gets through its joint. Fills ``forces`` (nj, 3) with fx, fy [N] and moment
    about the joint [N m] on each joint's child, its drive's effort left out, and ``efforts`` (nd,) with the torque [N
    m] or force [N] of each drive, prescribed ones first.
    """
    bodies, rows, ends, joints = model.bodies, model.rows, model.ends, model.joints
    pose, load, reaction = work.pose, work.bias, work.reaction
    driven, powered = model.driven_bodies, model.powered_bodies
    for k in range(len(rows)):
        add_row_wrench(rows[k], pose, -reaction[k], load)
    joint_wrenches(bodies, pose, load)
    for k in range(len(joints)):
        joint = joints[k]
        at = joint.at
        fx, fy, moment = 0.0, 0.0, 0.0
        if joint.source == OF_TREE or joint.source == OF_ROWS:
            fx, fy, moment = ideal_joint_force(joint, pose, load, reaction)
        elif joint.source == OF_JOURNAL:
            fx, fy, moment = contacts[at, FX], contacts[at, FY], contacts[at, COUPLE]
        else:
            cx, cy = arm(pose, joint.child)
            for i in range(at, at + _CORNERS):
                rx, ry = arm(pose, ends[i].journal)
                fx += contacts[i, FX]
                fy += contacts[i, FY]
                moment += (rx - cx) * contacts[i, FY] - (ry - cy) * contacts[i, FX]
        forces[k, 0], forces[k, 1], forces[k, 2] = fx, fy, moment
    for k in range(len(driven)):
        efforts[k] = joint_force(bodies.records[driven[k]], pose, load[driven[k]])
    for k in range(len(powered)):
        efforts[len(driven) + k] = work.tau[bodies.records[powered[k]].dof]
