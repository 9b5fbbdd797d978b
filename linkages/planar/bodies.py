"""Bodies of a tree: their records, and the shapes in which those that bend do so.

A body that bends is a straight beam along e1 of its frame, e2 a quarter turn ahead, whose points move by

    rho1 = s + a.eta - eta.H eta/2,   rho2 = b.eta,   turned by b'.eta

where eta are its modal coordinates, a and b the shapes of stretching and bending, and H(s) the integral of b' b'^T from
the frame's origin to s: a bent beam is as long as it was, so a.eta is the true stretch (Kane, Ryan and Banerjee,
Journal of Guidance, Control, and Dynamics 10, 1987, pp. 139-151). Its cross-sections at markers are massless bodies of
the type `SECTION`, carried by it: what attaches there knows nothing of bending.

For the inertia, a, b and H are split over the mass into their mean (0), what is linear in s (1), and the rest:
a = a0 + f a1 + the rest, with f the distance from the middle over the radius of gyration. The first two move as two
points with the beam's whole mass each would; the frame's translation moves the first only. The rest of a and b is
orthogonal to them and has constant integrals. The rest of H, which acts from the third order of eta on, is left out: it
is 4e-6 of the largest deflection of Simeon's slider-crank, where all terms of these orders are 2e-4. Kinetic energy is
that of this motion in all orders of eta, and the equations of motion are those of this energy: none is lost or won.

Velocities, accelerations and wrenches of a body that bends have its modal coordinates after the three of its frame.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.kernel import Array, Records, inlined_kernel
from linkages.kernel.simd import LaneArray, lane_array


class Bodies(NamedTuple):
    """Bodies for kernels: nb of them, with up to nm modes each."""

    records: Records  # `linkages.planar.record_types.BODY`, (nb,)
    shapes: LaneArray  # see `MATRIX`, (nb, 3 + nm, nm)


#: Rows of the shapes, four numbers side by side for each mode. Of a body that bends: (a0, b0, a1, b1); then stiffness
#: [N/m], damping [N s/m], mass that locks the mode, 0 where it may move [kg], 0; then, at the row's begin, the places
#: of the two points of the straight beam (x0, y0, x1, y1) [m]; then one row for each mode, of (-H0 [1/m], M [kg], -H1,
#: T [kg]), with M and T the integrals of a a^T + b b^T and of b a^T - a b^T with the rest of a and b. Of a section:
#: (a, b, b', 0); two rows of 0; then rows of (-H, 0, 0, 0). The modes that bend come first: H has entries for these
#: alone, M for two of one kind, T for two of different kinds.
SHAPE, ELASTIC, STRAIGHT, MATRIX = range(4)
STIFFNESS, DAMPING, LOCK = range(3)  #: within those of `ELASTIC`

#: Entries of a pose: x, y [m], angle [rad], its cosine and sine. Of a body that bends there follow its modal
#: coordinates; from `MOTION` on how each moves its two points along and across it (a0 - H0 eta, b0, a1 - H1 eta, b1);
#: from `REST` on M eta, then T eta; at last, from `POINTS` on, the places of those points, x0, y0, x1, y1 [m]. Those
#: three are times nm. Of a section: the angle, x and y by which each modal coordinate moves it.
POSE = 5
MOTION, REST, POINTS = 1, 5, 7


def make_shapes(nb: int, nm: int) -> LaneArray:
    """Make room for the shapes of nb bodies with up to nm modes."""
    return lane_array(nb, MATRIX + nm, nm)


def make_poses(nb: int, nm: int) -> Array:
    """Make room for the poses of nb bodies, (nb, 5) if none bends."""
    return np.zeros((nb, POSE + (POINTS * nm + 4 if nm else 0)))


def make_pose(bodies: Bodies) -> Array:
    """Make room for the poses of all bodies."""
    return new_poses(len(bodies.records), bodies.shapes.shape[2])


def make_motion(bodies: Bodies) -> Array:
    """Make room for velocities, accelerations or wrenches of all bodies, (nb, 3) if none bends."""
    return np.zeros((len(bodies.records), 3 + bodies.shapes.shape[2]))


#: The same for compiled callers.
new_poses = inlined_kernel(make_poses)
new_pose, new_motion = inlined_kernel(make_pose), inlined_kernel(make_motion)
