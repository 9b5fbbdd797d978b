"""What the two systems ask of compiled kernels, in one reference: each array that Python hands over costs time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.kernel import Array, Indices, kernel
from linkages.kernel.by_reference import packed
from linkages.planar.arrays import Arrays
from linkages.planar.contacts import clearance_forces
from linkages.planar.driven import driven_forces
from linkages.system import System


class Placed(NamedTuple):
    """A linkage, and where its coordinates stand in a plant's state."""

    model: Arrays
    positions: Indices  # of coordinates in the state, (n,)
    rates: Indices  # of their rates
    into: Indices  # of their generalised forces
    size: int  # number of the plant's generalised forces
    stabilisation: float  # rate at which deviations of drives and loops decay [1/s]


def placed(system: System, positions: Indices, rates: Indices, into: Indices, size: int) -> Placed:
    """Put a system in its place, for `joint_forces` and `drive_forces`."""
    q, v, f = (np.ascontiguousarray(x, dtype=np.int64) for x in (positions, rates, into))
    return packed(Placed(packed(system.arrays), q, v, f, size, system.experiment.solver.stabilisation))


@kernel
def joint_forces(place: Placed, memory: Array, state: Array) -> Array:
    """Compute `linkages.planar.contacts.clearance_forces`."""
    model = place.model
    return clearance_forces(
        model.bodies,
        model.ends,
        model.laws,
        model.tables,
        memory,
        state,
        place.positions,
        place.rates,
        place.into,
        place.size,
    )


@kernel
def drive_forces(place: Placed, t: float, state: Array, applied: Array) -> tuple[Array, Array]:
    """Compute `linkages.planar.driven.driven_forces`."""
    model = place.model
    return driven_forces(
        model.bodies,
        model.rows,
        model.rank,
        model.size,
        place.stabilisation,
        model.gravity,
        model.driven,
        (model.motion, model.motion_c, model.motion_n),
        model.powered,
        (model.torque, model.torque_c, model.torque_n),
        (model.loads, model.signals, model.load_t, model.load_c, model.load_n),
        t,
        state,
        place.positions,
        place.rates,
        applied,
        place.into,
        place.size,
    )
