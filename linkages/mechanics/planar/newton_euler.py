"""Inverse dynamics: the recursive Newton-Euler algorithm (Featherstone, 2008, ch. 5), and the force residual.

The algorithm's steps are here functions of their own: `linkages.mechanics.planar.kinematics` has the accelerations of
the bodies, `inertial_forces` the forces that these need, `generalised_force` projects forces onto the coordinates.
Spatial vectors are described in `linkages.mechanics.planar.workspace`.
"""

from __future__ import annotations

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel, lazy_kernel
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.deformable_dynamics import deformable_inertial_force
from linkages.mechanics.planar.kinematics import add_to_parent, body_acceleration, joint_force, propagate_force
from linkages.mechanics.planar.markers import turned
from linkages.mechanics.planar.record_types import NODE
from linkages.mechanics.planar.traversal import MOVED, STILL, backward, forward
from linkages.mechanics.planar.workspace import Workspace


@kernel
def generalised_force(bodies: Bodies, pose: Array, wrench: Array, tau: Array) -> None:
    """Add J^T w of the bodies' wrenches (nb, 3) to the generalised forces ``tau`` (n,); ``wrench`` is used up."""
    _project(bodies, pose, wrench, tau)


@inlined_kernel
def _project_wrench(bodies: Bodies, i: int, pose: Array, wrench: Array, tau: Array) -> None:
    """Add the force of body i's wrench along its joint, and pass the wrench on to the parent."""
    body = bodies.records[i]
    if body.dof >= 0:
        tau[body.dof] += joint_force(body, pose, wrench[i])
    propagate_force(bodies, i, pose, wrench, tau)


_project = backward(_project_wrench, moving=False)


@kernel
def joint_wrenches(bodies: Bodies, pose: Array, wrench: Array) -> None:
    """Turn the forces that each body needs (nb, 3), in place, into the wrenches that it gets through its joint."""
    _accumulate(bodies, pose, wrench)


_accumulate = backward(add_to_parent, moving=False)


@kernel
def inertial_forces(bodies: Bodies, work: Workspace, gravity: Array, bias: Array, shape_bias: Array) -> None:
    """Set the forces that the motion of each body needs: rate of change of momentum less gravity and applied wrenches.

    Takes `work`'s q, v, a, pose, vel, acc and wrench. Fills ``bias`` with the wrenches on the frames, and the entries
    of shapes in ``shape_bias`` (n,) with their generalised forces, elastic ones included.
    """
    _set_inertial_forces(bodies, work, gravity, bias, shape_bias)


@inlined_kernel
def body_inertial_force(
    bodies: Bodies, i: int, work: Workspace, gravity: Array, bias: Array, shape_bias: Array
) -> None:
    """Set the force that the motion of body i needs."""
    body, vel, acc, wrench = bodies.records[i], work.vel, work.acc, work.wrench
    if body.shapes > 0:
        deformable_inertial_force(bodies, i, work, gravity, bias, shape_bias)
        for k in range(3):
            bias[i, k] -= wrench[i, k]
        return
    if body.type == NODE:  # without mass
        bias[i, 0], bias[i, 1], bias[i, 2] = -wrench[i, 0], -wrench[i, 1], -wrench[i, 2]
        return
    cx, cy = turned(work.pose, i, body.cx, body.cy)
    m, alpha, square = body.mass, acc[i, 0], vel[i, 0] * vel[i, 0]
    fx = m * (acc[i, 1] - alpha * cy - square * cx - gravity[0])
    fy = m * (acc[i, 2] + alpha * cx - square * cy - gravity[1])
    bias[i, 0] = body.inertia * alpha + cx * fy - cy * fx - wrench[i, 0]
    bias[i, 1] = fx - wrench[i, 1]
    bias[i, 2] = fy - wrench[i, 2]


_set_inertial_forces = forward(body_inertial_force, moving=False)


@kernel
def force_residual(bodies: Bodies, gravity: Array, work: Workspace) -> None:
    """Subtract the generalised forces that the accelerations ``a`` of all coordinates need from ``tau``.

    Takes `work`'s q, v, a, pose, vel and wrench; uses acc, bias and shape_bias. The residual in the entries of free
    coordinates is the mass matrix times the error of their accelerations.
    """
    _needed_forces(bodies, work, gravity)
    _subtract(bodies, work)


@inlined_kernel
def _needed_force(bodies: Bodies, i: int, work: Workspace, gravity: Array) -> None:
    """Set the acceleration of body i and, if it moves, the force that it needs."""
    body = bodies.records[i]
    if body.type != NODE or body.carries:  # nodes have no mass
        body_acceleration(bodies, i, work.pose, work.vel, work.v, work.a, work.acc)
    if body.moving:
        body_inertial_force(bodies, i, work, gravity, work.bias, work.shape_bias)


@inlined_kernel
def _subtract_force(bodies: Bodies, i: int, work: Workspace) -> None:
    """Subtract the force along the coordinates of body i, and pass the wrench on to the parent."""
    body, bias, shape_bias, tau = bodies.records[i], work.bias, work.shape_bias, work.tau
    if body.dof >= 0:
        tau[body.dof] -= joint_force(body, work.pose, bias[i])
    for k in range(body.eta, body.eta + body.shapes):
        tau[k] -= shape_bias[k]
    propagate_force(bodies, i, work.pose, bias, shape_bias)


@lazy_kernel
def moved_residual(bodies: Bodies, gravity: Array, moves: Indices, work: Workspace) -> None:
    """Do the same as `force_residual` for duals; only the slopes of the result are right.

    Bodies that the change of no coordinate moves need no inertial forces, see
    `linkages.mechanics.planar.traversal.mark_moved`.
    """
    _changed_forces(bodies, moves, work, gravity)
    _subtract(bodies, work)


@inlined_kernel
def _changed_force(bodies: Bodies, i: int, moves: Indices, work: Workspace, gravity: Array) -> None:
    """Set the acceleration of body i, and the change of the force that it needs."""
    body, bias, wrench = bodies.records[i], work.bias, work.wrench
    if moves[i] != STILL and (body.type != NODE or body.carries):
        body_acceleration(bodies, i, work.pose, work.vel, work.v, work.a, work.acc)
    if moves[i] == MOVED and body.moving:
        body_inertial_force(bodies, i, work, gravity, bias, work.shape_bias)
        return
    for k in range(body.eta, body.eta + body.shapes):
        work.shape_bias[k] = 0.0
    bias[i, 0], bias[i, 1], bias[i, 2] = -wrench[i, 0], -wrench[i, 1], -wrench[i, 2]


_needed_forces, _changed_forces = (forward(step, moving=False) for step in (_needed_force, _changed_force))
_subtract = backward(_subtract_force)
