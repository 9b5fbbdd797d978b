"""Kinematics of flexible bodies: sections and mass points from modal coordinates; see `bodies`."""

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
    mode_at,
    point_motion,
    section_motion,
)
from linkages.mechanics.planar.markers import arm, turned
from linkages.mechanics.planar.record_types import SECTION

_SMALL = 0.05  # angle up to which the series of cosine and sine are exact to rounding [rad]


@lazy_kernel(makes_arrays=True)
def detached_section_pose(bodies: Bodies, i: int, q: Array, pose: Array) -> None:
    """Fill the pose of section i, which does not follow its beam immediately in the order of bodies."""
    _section_pose(bodies, i, q, pose)


@inlined_kernel
def _section_pose(bodies: Bodies, i: int, q: Array, pose: Array) -> None:
    """Fill the pose of section i from its beam's."""
    section, shapes, p = bodies.records[i], bodies.shapes[i], bodies.records[i].mount.body
    bends, own = bodies.records[p].bends, modal(bodies, p, q)
    ux, uy = turned(pose, p, section.ux, section.uy)
    stretch, deflection, turn = 0.0, 0.0, 0.0
    for k in range(bodies.records[p].modes):
        shape, eta = shapes[SHAPE, k], own[k]
        psi, b, slope = lane(shape, 0), lane(shape, 1), lane(shape, 2)
        stretch += 0.5 * psi * eta
        for m in range(bends if k < bends else 0):
            psi += lane(shapes[MATRIX + k, m], 0) * own[m]
        stretch += 0.5 * psi * eta
        deflection += b * eta
        turn += slope * eta
        at = mode_at(k)
        pose[i, at + TURN], pose[i, at + MOVE_X], pose[i, at + MOVE_Y] = slope, psi * ux - b * uy, psi * uy + b * ux
    rx, ry = arm(pose, section.mount)
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
def flexible_pose(bodies: Bodies, i: int, q: Array, pose: Array) -> None:
    """Fill the modal entries of flexible body i's pose, and the poses of the sections that follow it immediately."""
    body, shapes, own = bodies.records[i], bodies.shapes[i], modal(bodies, i, q)
    places = shapes[STRAIGHT, 0]
    for k in range(body.modes):
        shape, bent, eta = shapes[SHAPE, k], matrix_product(shapes, k, own), own[k]
        motion = with_lane(with_lane(shape + bent, 1, lane(shape, 1)), 3, lane(shape, 3))
        put_lanes(pose, i, mode_at(k), motion)
        pose[i, mode_at(k) + M_ETA], pose[i, mode_at(k) + T_ETA] = lane(bent, 1), lane(bent, 3)
        places += (shape + motion) * (0.5 * eta)
    put_lanes(pose, i, POINTS, places)
    for j in range(i + 1, len(bodies.records)):
        if bodies.records[j].type != SECTION or bodies.records[j].mount.body != i:
            break
        _section_pose(bodies, j, q, pose)


@inlined_kernel
def modal(bodies: Bodies, i: int, x: Array) -> Any:
    """Entries of x (n,) for the modes of flexible body i: loops over them need not test the signs of indices."""
    body = bodies.records[i]
    return x[body.eta : body.eta + body.modes]


@inlined_kernel
def matrix_product(shapes: LaneArray, k: int, own: Array) -> Any:
    """Row k of a flexible body's matrices times entries of its modes (nm,): (-H0 x, M x, -H1 x, T x) in lanes."""
    total = 0.0
    for m in range(len(own)):
        total += shapes[MATRIX + k, m] * own[m]
    return total


@inlined_kernel
def modal_motion(bodies: Bodies, i: int, pose: Array, rates: Any) -> tuple[float, float, float]:
    """Motion of section i relative to its beam's frame (turn, x, y) at modal rates, entries of ``rates`` (n,)."""
    beam = bodies.records[bodies.records[i].mount.body]
    turn, x, y = 0.0, 0.0, 0.0
    for k in range(beam.modes):
        own_turn, own_x, own_y = section_motion(pose, i, k)
        rate = rates[beam.eta + k]
        turn += own_turn * rate
        x += own_x * rate
        y += own_y * rate
    return turn, x, y


@inlined_kernel
def shortening(bodies: Bodies, i: int, v: Array) -> float:
    """Centripetal part of section i's acceleration towards the beam's origin, v.H v of the modal rates [m/s2]."""
    p, shapes, total = bodies.records[i].mount.body, bodies.shapes[i], 0.0
    own = modal(bodies, p, v)
    for k in range(bodies.records[p].bends):
        for m in range(bodies.records[p].bends):
            total -= own[k] * lane(shapes[MATRIX + k, m], 0) * own[m]
    return total


@inlined_kernel
def add_modal_force(bodies: Bodies, i: int, pose: Array, moment: Any, fx: Any, fy: Any, tau: Any) -> None:
    """Add the generalised forces of a wrench on section i to the entries of its beam's modes in ``tau`` (n,)."""
    beam = bodies.records[bodies.records[i].mount.body]
    for k in range(beam.modes):
        turn, x, y = section_motion(pose, i, k)
        tau[beam.eta + k] = tau[beam.eta + k] + turn * moment + (x * fx + y * fy)


@inlined_kernel
def point_rates(bodies: Bodies, i: int, pose: Array, v: Array) -> Any:
    """Velocities of the two points of flexible body i relative to its frame, along and across the beam, in lanes."""
    first, total = bodies.records[i].eta, 0.0
    for k in range(bodies.records[i].modes):
        total += point_motion(pose, i, k) * v[first + k]
    return total
