"""Kinematics of deformable bodies: nodes and mass points from shape coordinates; see `bodies`."""

from __future__ import annotations

import math
from typing import Any

from linkages.base.kernel import Array, inlined_kernel, lazy_kernel
from linkages.base.kernel.simd import LaneArray, lane, lanes, put_lanes, with_lane
from linkages.mechanics.planar.bodies import (
    COS,
    M_ETA,
    MATRIX,
    MOVE_X,
    MOVE_Y,
    POINTS,
    SHAPE,
    SIN,
    STRAIGHT,
    T_ETA,
    TURN,
    Bodies,
    node_motion,
    point_motion,
    shape_at,
)
from linkages.mechanics.planar.markers import arm, turned
from linkages.mechanics.planar.record_types import NODE

_SMALL = 0.05  # angle up to which the series of cosine and sine are exact to rounding [rad]


@lazy_kernel(makes_arrays=True)
def detached_node_pose(bodies: Bodies, i: int, q: Array, pose: Array) -> None:
    """Fill the pose of node i, which does not follow its parent immediately in the order of bodies."""
    _node_pose(bodies, i, q, pose)


@inlined_kernel
def _node_pose(bodies: Bodies, i: int, q: Array, pose: Array) -> None:
    """Fill the pose of node i from its parent's."""
    node, shapes, p = bodies.records[i], bodies.shapes[i], bodies.records[i].mount.body
    bends, own = bodies.records[p].bends, shape_entries(bodies, p, q)
    ux, uy = turned(pose, p, node.ux, node.uy)
    stretch, deflection, turn = 0.0, 0.0, 0.0
    for k in range(bodies.records[p].shapes):
        shape, eta = shapes[SHAPE, k], own[k]
        psi, b, slope = lane(shape, 0), lane(shape, 1), lane(shape, 2)
        stretch += 0.5 * psi * eta
        for m in range(bends if k < bends else 0):
            psi += lane(shapes[MATRIX + k, m], 0) * own[m]
        stretch += 0.5 * psi * eta
        deflection += b * eta
        turn += slope * eta
        at = shape_at(k)
        pose[i, at + TURN], pose[i, at + MOVE_X], pose[i, at + MOVE_Y] = slope, psi * ux - b * uy, psi * uy + b * ux
    rx, ry = arm(pose, node.mount)
    c, s = _cosine_and_sine(turn)
    pose[i, 0] = pose[p, 0] + rx + (ux * stretch - uy * deflection)
    pose[i, 1] = pose[p, 1] + ry + (uy * stretch + ux * deflection)
    pose[i, 2] = pose[p, 2] + turn
    pose[i, COS] = pose[p, COS] * c - pose[p, SIN] * s
    pose[i, SIN] = pose[p, SIN] * c + pose[p, COS] * s


@inlined_kernel
def _cosine_and_sine(angle: float) -> tuple[float, float]:
    """Cosine and sine of an angle; small ones, the usual case, by their series to the last digit."""
    if abs(angle) > _SMALL:
        return math.cos(angle), math.sin(angle)
    x = angle * angle
    both = lanes(1 / 720, 1 / 120, 0.0, 0.0) - lanes(1 / 40320, 1 / 5040, 0.0, 0.0) * x
    both = lanes(1 / 2, 1.0, 0.0, 0.0) - (lanes(1 / 24, 1 / 6, 0.0, 0.0) - both * x) * x
    return 1.0 - lane(both, 0) * x, lane(both, 1) * angle


@lazy_kernel(makes_arrays=True)
def deformable_pose(bodies: Bodies, i: int, q: Array, pose: Array) -> None:
    """Fill the shape entries of deformable body i's pose, and the poses of the nodes that follow it immediately."""
    body, shapes, own = bodies.records[i], bodies.shapes[i], shape_entries(bodies, i, q)
    places = shapes[STRAIGHT, 0]
    for k in range(body.shapes):
        shape, bent, eta = shapes[SHAPE, k], matrix_product(shapes, k, own), own[k]
        motion = with_lane(with_lane(shape + bent, 1, lane(shape, 1)), 3, lane(shape, 3))
        put_lanes(pose, i, shape_at(k), motion)
        pose[i, shape_at(k) + M_ETA], pose[i, shape_at(k) + T_ETA] = lane(bent, 1), lane(bent, 3)
        places += (shape + motion) * (0.5 * eta)
    put_lanes(pose, i, POINTS, places)
    for j in range(i + 1, len(bodies.records)):
        if bodies.records[j].type != NODE or bodies.records[j].mount.body != i:
            break
        _node_pose(bodies, j, q, pose)


@inlined_kernel
def shape_entries(bodies: Bodies, i: int, x: Array) -> Any:
    """Entries of x (n,) for the shapes of deformable body i: loops over them need not test the signs of indices."""
    body = bodies.records[i]
    return x[body.eta : body.eta + body.shapes]


@inlined_kernel
def matrix_product(shapes: LaneArray, k: int, own: Array) -> Any:
    """Row k of a deformable body's matrices times entries of its shapes (nm,): (-H0 x, M x, -H1 x, T x) in lanes."""
    total = 0.0
    for m in range(len(own)):
        total += shapes[MATRIX + k, m] * own[m]
    return total


@inlined_kernel
def shape_motion(bodies: Bodies, i: int, pose: Array, rates: Any) -> tuple[float, float, float]:
    """Motion of node i relative to its parent's frame (turn, x, y) at shape rates, entries of ``rates`` (n,)."""
    carrier = bodies.records[bodies.records[i].mount.body]
    turn, x, y = 0.0, 0.0, 0.0
    for k in range(carrier.shapes):
        own_turn, own_x, own_y = node_motion(pose, i, k)
        rate = rates[carrier.eta + k]
        turn += own_turn * rate
        x += own_x * rate
        y += own_y * rate
    return turn, x, y


@inlined_kernel
def shortening(bodies: Bodies, i: int, v: Array) -> float:
    """Centripetal part of node i's acceleration towards its parent's origin, v.H v of the shape rates [m/s2]."""
    p, shapes, total = bodies.records[i].mount.body, bodies.shapes[i], 0.0
    own = shape_entries(bodies, p, v)
    for k in range(bodies.records[p].bends):
        for m in range(bodies.records[p].bends):
            total -= own[k] * lane(shapes[MATRIX + k, m], 0) * own[m]
    return total


@inlined_kernel
def add_shape_force(bodies: Bodies, i: int, pose: Array, moment: Any, fx: Any, fy: Any, tau: Any) -> None:
    """Add the generalised forces of a wrench on node i to the entries of its parent's shapes in ``tau`` (n,)."""
    carrier = bodies.records[bodies.records[i].mount.body]
    for k in range(carrier.shapes):
        turn, x, y = node_motion(pose, i, k)
        tau[carrier.eta + k] = tau[carrier.eta + k] + turn * moment + (x * fx + y * fy)


@inlined_kernel
def point_rates(bodies: Bodies, i: int, pose: Array, v: Array) -> Any:
    """Velocities of the two points of deformable body i relative to its frame, along and across the beam, in lanes."""
    first, total = bodies.records[i].eta, 0.0
    for k in range(bodies.records[i].shapes):
        total += point_motion(pose, i, k) * v[first + k]
    return total
