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


class Bodies(NamedTuple):
    """Bodies for kernels: nb of them, with up to nm modes each."""

    records: Records  # `linkages.planar.record_types.BODY`, (nb,)
    shapes: Array  # see `SHAPES`, (nb, shape_rows(nm), nm)


#: First rows of the shapes of a body that bends: a0, a1, b0, b1, stiffnesses [N/m], dampings [N s/m], and masses that
#: lock modes, 0 where they may move [kg]. Four matrices follow, nm rows each: H0, H1 [1/m]; integrals of a a^T + b b^T
#: and of b a^T - a b^T with the rest of a and b [kg]. The modes that bend come first: H has entries for these alone,
#: the third matrix for two of one kind, the fourth for two of different kinds.
A0, A1, B0, B1, STIFFNESS, DAMPING, LOCK, MATRICES = range(8)
#: Those of a section: a, b, b'; then H.
A, B, SLOPE = range(3)

#: Entries of a pose: x, y [m], angle [rad], its cosine and sine. Of a body that bends there follow, nm each: its modal
#: coordinates, a - H eta of its two points, the products of the last two matrices with eta; then x0, y0, x1, y1, places
#: of its two points along and across it [m]. Of a section: the angle, x and y by which each modal coordinate moves it.
POSE = 5
COLUMNS = 5


def shape_rows(nm: int) -> int:
    """Rows of the shapes of bodies with up to nm modes."""
    return MATRICES + 4 * nm if nm else 0


def make_poses(nb: int, nm: int) -> Array:
    """Make room for the poses of nb bodies, (nb, 5) if none bends."""
    return np.zeros((nb, POSE + (COLUMNS * nm + 4 if nm else 0)))


def make_pose(bodies: Bodies) -> Array:
    """Make room for the poses of all bodies."""
    return new_poses(len(bodies.records), bodies.shapes.shape[2])


def make_motion(bodies: Bodies) -> Array:
    """Make room for velocities, accelerations or wrenches of all bodies, (nb, 3) if none bends."""
    return np.zeros((len(bodies.records), 3 + bodies.shapes.shape[2]))


#: The same for compiled callers.
new_poses = inlined_kernel(make_poses)
new_pose, new_motion = inlined_kernel(make_pose), inlined_kernel(make_motion)
