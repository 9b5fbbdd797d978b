"""`Workspace`: the arrays of one evaluation of the dynamics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.kernel import Array, Indices, kernel
from linkages.planar.bodies import new_poses


class Workspace(NamedTuple):
    """Arrays of one evaluation of the dynamics: nb bodies, n coordinates, nr closure rows.

    Where bodies bend those with a line for each body are wider, see `linkages.planar.bodies`.
    """

    q: Array  # coordinates, (n,)
    v: Array  # rates
    a: Array  # accelerations
    tau: Array  # applied generalised forces of the free joints
    pose: Array  # (nb, 5)
    vel: Array  # (nb, 3)
    acc: Array
    wrench: Array  # applied to the bodies
    reaction: Array  # size of each row's reaction, (nr,)
    inertia: Array
    axis: Array
    load: Array
    change: Array
    still: Array
    rest: Array
    error: Array
    response: Array
    row_a: Array
    room: Indices  # for `solve_rows`, (2, nr)
    given: Array  # prescribed accelerations, while others are found, (n,)
    passing: Array  # 1 where accelerations are those of a singular position that is passed, (1,)


def make_workspace(nb: int, n: int, nr: int, nm: int = 0) -> Workspace:
    """Make the arrays, all zero, in the order of the attributes; nm: most modes of a body."""
    wide = nb, 3 + nm
    return Workspace(
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n),
        new_poses(nb, nm), np.zeros(wide), np.zeros(wide), np.zeros(wide), np.zeros(nr),
        np.zeros((nb, 6 + 3 * nm + nm * nm)), np.zeros((nb, 8 + 4 * nm)),
        np.zeros(wide), np.zeros(wide), np.zeros(wide),
        np.zeros(n), np.zeros(nr), np.zeros((nr, nr)), np.zeros((nr, n)), np.zeros((2, nr), np.int64),
        np.zeros(n), np.zeros(1),
    )  # fmt: skip


#: The same for compiled callers.
workspace = kernel(make_workspace)
