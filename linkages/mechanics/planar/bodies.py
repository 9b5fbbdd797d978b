"""The bodies of a tree: their records, the shapes of deformable ones, and the layout of poses.

A deformable body is a body with shape coordinates: it lies along e1 of its frame, with e2 a quarter turn ahead, and its
shapes are any functions of the place on it, such as the modes of a beam. Its points move by

    rho1 = s + a.eta - eta.H eta/2,   rho2 = b.eta,   and its cross-sections turn by b'.eta.

Here eta are its shape coordinates, a and b the shapes along and across, and H(s) the integral of b' b'^T from the
frame's origin to s. Bending keeps the length of the axis, so a.eta is the true stretch (Kane, Ryan and Banerjee,
Journal of Guidance, Control, and Dynamics 10, 1987, pp. 139-151). The cross-sections at markers are its nodes: massless
bodies of the type `NODE` that it carries; joints, contacts and loads attach to them as to rigid bodies.

For the inertia, each of a, b and H is split over the mass into its mean (0), a part linear in s (1), and a remainder:
a = a0 + f a1 + remainder, with f the distance from the middle over the radius of gyration. The first two parts move as
two points, each with the whole mass of the beam; the translation of the frame moves only the first point. The
remainders of a and b are orthogonal to both and have constant integrals. The remainder of H, which acts from the third
order of eta on, is omitted: it is 4e-6 of the largest deflection of Simeon's slider-crank, where all terms of these
orders together are 2e-4. The kinetic energy is exact for this motion, in all orders of eta, and the equations of motion
follow from it, so they conserve it.

Quantities of shapes are entries of generalised vectors: shape k of a body has the coordinate ``q[body.eta + k]``, the
rate ``v[body.eta + k]`` and so on.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Array, Records, inlined_kernel
from linkages.base.kernel.simd import LaneArray, lanes_at


class Bodies(NamedTuple):
    """Bodies for kernels: nb of them, with up to nm shapes each."""

    records: Records  # `linkages.mechanics.planar.record_types.BODY`, (nb,)
    shapes: LaneArray  # see `MATRIX`, (nb, 3 + nm, nm)


#: Rows of the shapes; an entry has four lanes, one entry for each shape.
#:
#: - `SHAPE`: deformable body (a0, b0, a1, b1); node (a, b, b', 0).
#: - `ELASTIC`: stiffness [N/m], damping [N s/m], mass that locks the shape, 0 where it may move [kg], 0.
#: - `STRAIGHT`: in its first entry, the places of the two points of the straight beam (x0, y0, x1, y1) [m].
#: - `MATRIX` and on, a row for each shape: deformable body (-H0 [1/m], M [kg], -H1, T [kg]), with M and T the integrals
#:   of a a^T + b b^T and of b a^T - a b^T over the remainders of a and b; node (-H, 0, 0, 0).
#:
#: Shapes across come before those along: H has entries for shapes across alone, M for two shapes of one kind, T for
#: shapes of different kinds.
SHAPE, ELASTIC, STRAIGHT, MATRIX = range(4)
STIFFNESS, DAMPING, LOCK = range(3)  #: lanes of `ELASTIC`

#: Entries of a pose behind x, y [m] and the angle [rad]: the angle's cosine and sine. Where any body is deformable,
#: there follow, for deformable bodies, the places of their two points (`points`), and for each shape, from `shape_at`
#: on, the motion of the points (`point_motion`), `M_ETA` and `T_ETA` (`remainder`); for nodes, for each shape, the
#: motion of the node (`node_motion`).
COS, SIN, POINTS = 3, 4, 5
M_ETA, T_ETA = 4, 5
TURN, MOVE_X, MOVE_Y = 0, 1, 2
_POSE, _SHAPES, _SHAPE = 5, 9, 6


@inlined_kernel
def shape_at(k: int) -> int:
    """First entry of shape k in a pose."""
    return _SHAPES + _SHAPE * k


@inlined_kernel
def points(pose: Array, i: int) -> Any:
    """Places of the two points of deformable body i along and across its beam, (x0, y0, x1, y1) in lanes [m]."""
    return lanes_at(pose, i, POINTS)


@inlined_kernel
def point_motion(pose: Array, i: int, k: int) -> Any:
    """Motion of the two points per unit of shape k, (a0 - H0 eta, b0, a1 - H1 eta, b1) in lanes."""
    return lanes_at(pose, i, shape_at(k))


@inlined_kernel
def remainder(pose: Array, i: int, k: int) -> tuple[float, float]:
    """Entries k of M eta and T eta of deformable body i, with the matrices of `MATRIX` [kg m]."""
    return pose[i, shape_at(k) + M_ETA], pose[i, shape_at(k) + T_ETA]


@inlined_kernel
def node_motion(pose: Array, i: int, k: int) -> tuple[float, float, float]:
    """Motion of node i per unit of its parent's shape k: turn, x, y in plane axes."""
    at = shape_at(k)
    return pose[i, at + TURN], pose[i, at + MOVE_X], pose[i, at + MOVE_Y]


@inlined_kernel(makes_arrays=True)
def new_poses(nb: int, nm: int) -> Array:
    """Make the poses of nb bodies, (nb, 5) if none is deformable."""
    return np.zeros((nb, _SHAPES + _SHAPE * nm if nm else _POSE))


def make_pose(bodies: Bodies) -> Array:
    """Make the poses of all bodies."""
    return new_poses(len(bodies.records), bodies.shapes.shape[2])


def make_motion(bodies: Bodies) -> Array:
    """Make the velocities, accelerations or wrenches (nb, 3) of all bodies."""
    return np.zeros((len(bodies.records), 3))


#: The same for compiled callers.
new_pose, new_motion = inlined_kernel(make_pose), inlined_kernel(make_motion)
