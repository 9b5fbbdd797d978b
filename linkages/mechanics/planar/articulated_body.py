"""Forward dynamics of the tree: the articulated-body algorithm (Featherstone, 2008, ch. 7).

The first pass finds the accelerations that the bodies would have if no free coordinate accelerated, so velocity terms
and prescribed joints are in them; the rest is linear. The shapes of a deformable body are eliminated before its joint.
Bodies that no free coordinate moves take no part in the other passes. The cost is linear in the number of bodies.
Symbols and spatial vectors are described in `linkages.mechanics.planar.workspace`.
"""

from __future__ import annotations

from linkages.base.kernel import Array, inlined_kernel, kernel
from linkages.mechanics.planar.bodies import Bodies
from linkages.mechanics.planar.composite_inertia import body_inertia, propagate_inertia
from linkages.mechanics.planar.deformable_dynamics import (
    add_node_inertia,
    eliminate_shapes,
    shape_backward_pass,
    shape_forward_pass,
)
from linkages.mechanics.planar.kinematics import body_acceleration, propagate_force, shape_motion
from linkages.mechanics.planar.markers import offset, turned
from linkages.mechanics.planar.newton_euler import body_inertial_force
from linkages.mechanics.planar.record_types import NODE, PRISMATIC, REVOLUTE
from linkages.mechanics.planar.traversal import backward, forward
from linkages.mechanics.planar.workspace import Workspace


@kernel
def articulated_inertias(bodies: Bodies, work: Workspace) -> None:
    """Set the articulated inertias and joints of the moving bodies at `work`'s q and pose."""
    _inertias(bodies, work)
    _articulate(bodies, work)


@kernel(makes_arrays=True)
def tree_dynamics(bodies: Bodies, gravity: Array, work: Workspace) -> None:
    """Find the accelerations of the free coordinates and of the bodies, without the reactions of cut joints.

    Takes `work`'s q, v, pose, vel, wrench, tau, and a with the prescribed accelerations and zero for free coordinates;
    sets a, acc, inertia, joint and shape; uses bias and response.
    """
    _velocity_terms(bodies, work, gravity)
    _reduce(bodies, work)
    _accelerate(bodies, work)


@kernel
def acceleration_response(
    bodies: Bodies, work: Workspace, bias: Array, shape_bias: Array, tau: Array, a: Array
) -> None:
    """Add the change of the accelerations due to given forces to ``a``; branches without forces cost next to nothing.

    Takes `work`'s pose, and inertia, joint and shape from `articulated_inertias`; sets the response. The wrenches
    ``bias`` and their shape entries ``shape_bias`` (n,) oppose the motion, and are used up.
    """
    _backward_pass(bodies, work, bias, shape_bias, tau)
    response_pass(bodies, work, a)


@inlined_kernel
def _is_nonzero(vectors: Array, i: int) -> bool:
    """Whether the spatial vector of body i differs from zero."""
    return vectors[i, 0] != 0.0 or vectors[i, 1] != 0.0 or vectors[i, 2] != 0.0


@inlined_kernel
def _velocity_term(bodies: Bodies, i: int, work: Workspace, gravity: Array) -> None:
    """Set the acceleration of body i without free accelerations and, if it moves, its inertia and bias force."""
    body_acceleration(bodies, i, work.pose, work.vel, work.v, work.a, work.acc)
    if bodies.records[i].moving:
        body_inertia(bodies, i, work)
        body_inertial_force(bodies, i, work, gravity, work.bias, work.shape_bias)


@inlined_kernel
def _articulated_inertia(bodies: Bodies, i: int, work: Workspace) -> None:
    """Eliminate the coordinates of body i from its inertia, and add the rest to the parent's."""
    body, inertia, joint = bodies.records[i], work.inertia[i], work.joint[i]
    if body.shapes > 0:
        eliminate_shapes(bodies, i, work)
    elif body.type == NODE:
        add_node_inertia(bodies, i, work)
    tt, tx, ty, xx, xy, yy = inertia.tt, inertia.tx, inertia.ty, inertia.xx, inertia.xy, inertia.yy
    if body.dof >= 0 and body.driven < 0:
        s_t, s_x, s_y = 0.0, 0.0, 0.0
        if body.type == REVOLUTE:
            s_t = body.sign
            u_t, u_x, u_y, d = tt * s_t, tx * s_t, ty * s_t, tt
            tt, tx, ty = 0.0, 0.0, 0.0
        else:
            s_x, s_y = turned(work.pose, body.mount.body, body.ux, body.uy)
            u_t, u_x, u_y = tx * s_x + ty * s_y, xx * s_x + xy * s_y, xy * s_x + yy * s_y
            d = s_x * u_x + s_y * u_y
        inverse = 1.0 / d
        if body.type == PRISMATIC:
            tt, tx, ty = tt - u_t * u_t * inverse, tx - u_t * u_x * inverse, ty - u_t * u_y * inverse
        xx, xy, yy = xx - u_x * u_x * inverse, xy - u_x * u_y * inverse, yy - u_y * u_y * inverse
        joint.S_t, joint.S_x, joint.S_y = s_t, s_x, s_y
        joint.U_t, joint.U_x, joint.U_y, joint.D_inverse = u_t, u_x, u_y, inverse
    propagate_inertia(bodies, i, work, (tt, tx, ty, xx, xy, yy))


@inlined_kernel
def bias_force(bodies: Bodies, i: int, work: Workspace, bias: Array, shape_bias: Array, tau: Array) -> None:
    """Find the effect of the forces on body i, if any, on its coordinates, and pass the rest on to its parent."""
    body, joint, p = bodies.records[i], work.joint[i], bodies.records[i].mount.body
    free = body.dof >= 0 and body.driven < 0
    if body.shapes > 0:
        shape_backward_pass(bodies, i, work, bias, shape_bias, tau)
    joint.push = 0.0
    if not (_is_nonzero(bias, i) or (free and tau[body.dof] != 0.0)):
        return
    if free:
        moment, fx, fy = bias[i, 0], bias[i, 1], bias[i, 2]
        push = (tau[body.dof] - (joint.S_t * moment + joint.S_x * fx + joint.S_y * fy)) * joint.D_inverse
        joint.push = push
        bias[i, 0] = body.sign * tau[body.dof] if body.type == REVOLUTE else moment + joint.U_t * push
        bias[i, 1], bias[i, 2] = fx + joint.U_x * push, fy + joint.U_y * push
    if bodies.records[p].moving:
        propagate_force(bodies, i, work.pose, bias, shape_bias)


@inlined_kernel
def _response(bodies: Bodies, i: int, work: Workspace, a: Array) -> None:
    """Set the response of body i; it is zero if neither its parent nor its coordinates respond."""
    body, joint, response = bodies.records[i], work.joint[i], work.response
    p = body.mount.body
    if not (joint.push != 0.0 or body.shapes > 0 or body.type == NODE or _is_nonzero(response, p)):
        response[i, 0], response[i, 1], response[i, 2] = 0.0, 0.0, 0.0
        return
    rx, ry = offset(work.pose, p, i)
    turn, x, y = response[p, 0], response[p, 1] - response[p, 0] * ry, response[p, 2] + response[p, 0] * rx
    if body.type == NODE:
        own_turn, own_x, own_y = shape_motion(bodies, i, work.pose, work.shape_response)
        turn, x, y = turn + own_turn, x + own_x, y + own_y
    if body.dof >= 0 and body.driven < 0:
        second = joint.push - joint.D_inverse * (joint.U_t * turn + joint.U_x * x + joint.U_y * y)
        a[body.dof] += second
        turn, x, y = turn + joint.S_t * second, x + joint.S_x * second, y + joint.S_y * second
    response[i, 0], response[i, 1], response[i, 2] = turn, x, y
    if body.shapes > 0:
        shape_forward_pass(bodies, i, work, a)


@inlined_kernel
def _reduce_body(bodies: Bodies, i: int, work: Workspace) -> None:
    """Eliminate the coordinates of body i from its inertia and its bias force."""
    _articulated_inertia(bodies, i, work)
    bias_force(bodies, i, work, work.bias, work.shape_bias, work.tau)


@inlined_kernel
def _accelerate_body(bodies: Bodies, i: int, work: Workspace) -> None:
    """Add the response of body i to its acceleration."""
    _response(bodies, i, work, work.a)
    for k in range(3):
        work.acc[i, k] += work.response[i, k]


_inertias = forward(body_inertia)
_articulate = backward(_articulated_inertia)
_velocity_terms = forward(_velocity_term, moving=False)
_reduce = backward(_reduce_body)
_accelerate = forward(_accelerate_body)
_backward_pass = backward(bias_force)
#: ``response_pass(bodies, work, a)`` does the second half of `acceleration_response`: it takes the pushes of the joints
#: and shapes, u/D and z.
response_pass = forward(_response)
