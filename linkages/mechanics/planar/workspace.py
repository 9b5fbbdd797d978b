"""`Workspace`: data that one evaluation of the dynamics fills; the constant model is `Arrays`.

Spatial vectors are those of the plane, with components 0 to 2. A motion is (turn, x, y): the angular velocity and the
velocity of the frame's origin, or their rates. A wrench is (moment, fx, fy): the moment about the frame's origin and
the force. Components are in plane axes at the origin of the body's own frame. Quantities of the shapes of deformable
bodies are entries of generalised vectors (n,). Symbols are those of Featherstone, Rigid Body Dynamics Algorithms, 2008,
ch. 7:

| field                  | symbol    | quantity                                                                     |
|------------------------|-----------|------------------------------------------------------------------------------|
| `inertia`              | I^A       | articulated inertias; composite inertias for the mass matrix                 |
| `joint`                | S, U, D   | motion subspaces of the joints, U = I^A S, 1/D = 1/(S.U), u/D                |
| `bias`, `shape_bias`   | p^A       | bias forces of the frames, and of the shapes                                 |
| `response`, ...        | a'        | changes of accelerations due to the bias forces and the applied forces       |
| `shape`                |           | the same for shapes: they are eliminated between the joint and the frame      |

The shapes of a deformable body have the inertia I_ee and are coupled to its frame by I_er. They are eliminated first,
as joints between the frame and the bodies that its nodes carry: eta'' = z - W a, with a the acceleration of the frame,
W = I_ee^-1 I_er and z = I_ee^-1 (forces on the shapes). The frame keeps the inertia I_rr - I_re W and the force I_re z.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Records, record_type
from linkages.mechanics.planar.bodies import new_poses
from linkages.mechanics.planar.elimination import Pivots, make_pivots

#: Symmetric inertia that takes a motion to a wrench; t: turn about the frame's origin, x and y: translation.
INERTIA = record_type(tt="f8", tx="f8", ty="f8", xx="f8", xy="f8", yy="f8")

#: Joint of a body: S, U = I^A S, 1/D, and u/D = (tau - S.p)/D. S and U are not set where the joint is not free.
ARTICULATION = record_type(
    S_t="f8", S_x="f8", S_y="f8", U_t="f8", U_x="f8", U_y="f8", D_inverse="f8", push="f8"
)  # fmt: skip

#: Entries of a mode that couple it with the frame of its body: I_re, and W = I_ee^-1 I_er.
COUPLING = record_type(I_t="f8", I_x="f8", I_y="f8", W_t="f8", W_x="f8", W_y="f8")


class ShapeInertias(NamedTuple):
    """Articulated inertias of the shapes."""

    coupling: Records  # `COUPLING`, (nb, nm)
    inertia: Array  # I_ee, below and on the diagonal; then its factors L and 1/D of L D L^T, (nb, nm, nm)
    push: Array  # z, (n,)


class Workspace(NamedTuple):
    """Arrays of one evaluation: nb bodies with up to nm shapes each, n coordinates, nr closure rows."""

    q: Array  # coordinates, (n,)
    v: Array  # rates
    a: Array  # accelerations
    tau: Array  # applied generalised forces
    pose: Array  # frames of the bodies, see `linkages.mechanics.planar.bodies.COS`
    vel: Array  # velocities of the frames, (nb, 3)
    acc: Array  # their accelerations, (nb, 3)
    wrench: Array  # applied to the bodies, (nb, 3)
    reaction: Array  # of each closure row, (nr,)
    inertia: Records  # `INERTIA`, (nb,)
    joint: Records  # `ARTICULATION`, (nb,)
    shape: ShapeInertias
    bias: Array  # (nb, 3)
    shape_bias: Array  # (n,)
    response: Array  # change of `acc`, (nb, 3)
    shape_response: Array  # (n,)
    row_force: Array  # forces of a unit reaction of each row on the coordinates, (nr, n); see `eliminate_rows`
    row_push: Array  # accelerations of each coordinate alone due to them, (nr, n)
    row_matrix: Array  # change of each row's acceleration by the same, eliminated, (nr, nr)
    row_error: Array  # of the rows' values, rates or accelerations, (nr,)
    pivots: Pivots  # of `row_matrix`
    zero_velocity: Array  # (nb, 3)
    zero_force: Array  # (n,)
    prescribed: Array  # accelerations of the driven coordinates, kept near a singularity, (n,)
    interpolated: Array  # 1 where the accelerations are interpolated across a singularity, (1,)


def make_workspace(nb: int, n: int, nr: int, nm: int = 0) -> Workspace:
    """Make the arrays, all zero."""
    frames = nb, 3
    shape = ShapeInertias(np.zeros((nb, nm), COUPLING), np.zeros((nb, nm, nm)), np.zeros(n))
    return Workspace(
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n),
        new_poses(nb, nm), np.zeros(frames), np.zeros(frames), np.zeros(frames), np.zeros(nr),
        np.zeros(nb, INERTIA), np.zeros(nb, ARTICULATION), shape,
        np.zeros(frames), np.zeros(n), np.zeros(frames), np.zeros(n),
        np.zeros((nr, n)), np.zeros((nr, n)), np.zeros((nr, nr)), np.zeros(nr), make_pivots(nr),
        np.zeros(frames), np.zeros(n), np.zeros(n), np.zeros(1),
    )  # fmt: skip
