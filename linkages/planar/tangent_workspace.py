"""`Scratch`: the data of a Jacobian and of directional derivatives, in addition to `linkages.planar.workspace`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from linkages.kernel import Array, Records, record_type
from linkages.kernel.simd import LaneArray as Lanes
from linkages.kernel.simd import lane_array
from linkages.planar.contact_partials import INPUTS, OUTPUTS, RESULTS, no_bounds

#: Velocity and acceleration of a section relative to its beam's frame, without turning; v.H v of the modal rates.
SECTION_RATES = record_type(vx="f8", vy="f8", ax="f8", ay="f8", shortening="f8")

#: Entry k of products of the matrices of `linkages.planar.bodies.MATRIX`: H0, H1, T and M with the modal rates, H0, H1
#: and T with the modal accelerations. For a section H takes the place of H0, and the others are not set.
MODE_PRODUCTS = record_type(
    h0_rates="f8", h1_rates="f8", t_rates="f8", m_rates="f8", h0_seconds="f8", h1_seconds="f8", t_seconds="f8"
)  # fmt: skip


#: Numbers of a rigid body that a direction can change: mount x, y, mass, mass centre x, y, moment of inertia.
BODY_NUMBERS = 6


class Scratch(NamedTuple):
    """Arrays of a Jacobian and of `linkages.kernel.simd.WIDTH` directions at a time."""

    partials: Array  # of the contacts, (nc, RESULTS, INPUTS); see `linkages.planar.contact_partials`
    bounds: Array  # of the contacts' speeds, (nc, BOUNDS); see the same, infinite without any
    force: Array  # wrench that each body gets through its joint at the state, (nb, 3)
    mass: Array  # mass matrix of all coordinates, (n, n); rows and columns of driven ones are 0
    changed: Array  # 1 where the directions change a coordinate, (n,)
    touched: Array  # 1 where they move a body, (nb,)
    sections: Records  # `SECTION_RATES`, (nb,)
    products: Records  # `MODE_PRODUCTS` of each body, (nb, nm)
    point_acc: Lanes  # of flexible bodies: accelerations of both points less gravity, (nb,)
    point_vel: Lanes  # and their velocities relative to the frame, (nb,)
    dq: Lanes  # the directions: changes of coordinates, (n,)
    dz: Lanes  # and of the contacts' bristles, (nc,)
    deta: Lanes  # changes of modal coordinates along them, (n,)
    drate: Lanes  # of modal rates, (n,)
    dpose: Lanes  # of poses, as (turn, dx, dy), (nb, 3)
    dvel: Lanes  # of velocities
    dacc: Lanes  # of accelerations
    dbias: Lanes  # of bias forces
    dwrench: Lanes  # of applied wrenches
    dtau: Lanes  # of generalised forces, (n,)
    drows: Lanes  # of the rows' accelerations, (nr,)
    moves: Array  # 1 where the directions change numbers of the model too, (1,)
    dbody: Lanes  # changes of `BODY_NUMBERS` along the directions, (nb, 6)
    dmarker: Lanes  # of the coordinates of a contact's markers in their bodies, (nc, 4)
    dlaw: Lanes  # of a contact's force at a given motion, (nc, OUTPUTS)
    dgravity: Lanes  # (2,)
    ddrive: Lanes  # of rates and accelerations of coordinates, (n, 2)
    tau: Array  # of one direction: changes of generalised forces, accelerations, (n,)
    da: Array
    bias: Array  # zero bias forces, (nb, 3)
    modal_bias: Array  # (n,)
    row_matrix: Array  # for the changes of the rows' reactions, (nr, nr)
    dreaction: Array  # (nr,)
    one: tuple[Array, Array, Array]  # changes of poses, velocities and wrenches along one direction


def make_scratch(nb: int, n: int, nr: int, nc: int, nm: int) -> Scratch:
    """Make the arrays for nb bodies of nm modes, n coordinates, nr rows and nc contacts, all zero, without bounds."""
    tree = nb, 3
    fixed: list[Any] = [np.zeros(shape) for shape in (tree, (n, n), n, nb)]
    laws = np.zeros((nc, RESULTS, INPUTS)), np.tile(no_bounds(), (nc, 1))
    records = np.zeros(nb, SECTION_RATES), np.zeros((nb, nm), MODE_PRODUCTS)
    lanes = (nb,), (nb,), (n,), (nc,), (n,), (n,), tree, tree, tree, tree, tree, (n,), (nr,)
    numbers = (nb, BODY_NUMBERS), (nc, 4), (nc, OUTPUTS), (2,), (n, 2)
    single = (n,), (n,), tree, (n,), (nr, nr), (nr,)
    made = [*laws, *fixed, *records, *(lane_array(*shape) for shape in lanes), np.zeros(1)]
    made += [*(lane_array(*shape) for shape in numbers), *map(np.zeros, single)]
    return Scratch._make([*made, tuple(np.zeros(tree) for _ in range(3))])
