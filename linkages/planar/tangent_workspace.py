"""`Scratch`: the arrays of a Jacobian and of directional derivatives."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from linkages.kernel import Array
from linkages.kernel.simd import LaneArray as Lanes
from linkages.kernel.simd import lane_array
from linkages.planar.contact_partials import INPUTS, OUTPUTS

#: Numbers of a line of ``bent`` (nb, ONCE + 7 nm). Of a section: velocity and acceleration (x, y) that its beam's modes
#: give it, the form eta'.H eta'; then the products of H and the modes' rates, and their accelerations. Of a body that
#: bends: accelerations of its two points less gravity and their velocities in the frame (x0, y0, x1, y1 of each); then
#: products of H0, H1, T and the rates, the same and the accelerations, that of M and the rates.
ONCE = 8


class Scratch(NamedTuple):
    """Arrays of a Jacobian and of a few directions at a time."""

    partials: Array  # of the contacts, (nc, OUTPUTS, INPUTS); see `linkages.planar.contact_partials`
    force: Array  # wrench that each body gets through its joint at the state; see `transmitted`
    bent: Array  # of links that bend, see `linkages.planar.bending_tangent`
    mass: Array  # mass matrix of all coordinates, (n, n); those of driven ones are 0
    changed: Array  # 1 where the directions change a coordinate, (n,)
    touched: Array  # and where they move a body, (nb,)
    dq: Lanes  # the directions: changes of coordinates, (n,)
    dz: Lanes  # and of the contacts' bristles, (nc,)
    dpose: Lanes  # changes along them, each as wide as in a `Workspace`
    dvel: Lanes
    dacc: Lanes
    dload: Lanes
    dwrench: Lanes
    dtau: Lanes  # of generalised forces, (n,)
    drows: Lanes  # of the rows' accelerations, (nr,)
    tau: Array  # of one direction: changes of generalised forces, accelerations, (n,)
    da: Array
    load: Array  # that changes nothing, as wide as in a `Workspace`
    response: Array  # for the changes of the rows' reactions, (nr, nr)
    sizes: Array
    one: tuple[Array, Array, Array]  # changes of poses, velocities and wrenches along it


def make_scratch(nb: int, n: int, nr: int, nc: int, nm: int) -> Scratch:
    """Make the arrays for nb bodies of nm modes, n coordinates, nr closure rows and nc contacts, all zero."""
    tree = nb, 3 + nm
    fixed = (nc, OUTPUTS, INPUTS), tree, (nb, ONCE + 7 * nm), (n, n), (n,), (nb,)
    lanes = (n,), (nc,), tree, tree, tree, tree, tree, (n,), (nr,)
    single = (n,), (n,), tree, (nr, nr), (nr,)
    made: list[Any] = [*map(np.zeros, fixed), *(lane_array(*shape) for shape in lanes), *map(np.zeros, single)]
    made.append(tuple(np.zeros(tree) for _ in range(3)))
    return Scratch(*made)
