"""What a method keeps between two attempts at a step, and what a driver tells it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.kernel import Array, Indices, inlined_kernel
from linkages.kernel.lanes import LaneArray as Lanes
from linkages.kernel.lanes import lane_array


class Stepper(NamedTuple):
    """Arrays of a method for n equations, the same for all methods."""

    new: Array  # state at the attempt's end, (n,)
    f0: Array  # derivatives at its start
    f1: Array  # derivatives at its end
    scale: Array  # what an error of 1 is, for each entry
    stages: Array  # derivatives at the stages of an explicit method, (6, n)
    trial: Array  # states at stages, (3, n)
    error: Array  # of the state at the end, (n,)
    z: Lanes  # from here on: for an implicit method. Stages less the state at the step's start, (n,)
    last: Lanes  # the same of the last step
    jacobian: Array  # of the mass times the derivatives, (n, n)
    mass: Array  # of the k rates and all that follows them, (k, k)
    slope: Array  # their derivatives at the stages from which an iteration comes, (3, k)
    lack: Array  # and what it finds there
    inverse: Lanes  # of the iteration's matrices, without positions, (k, k): see `linkages.integrate.shifted`
    cross: Lanes
    order: Indices  # of their rows, (k,)
    force: Lanes  # what is found at the stages, for both systems, (k,)
    turned: Lanes
    memory: Array  # by the indices below, (6,)


#: Indices of `Stepper.memory`: sizes of the last accepted step, and of the step of the inverses, 0 if there are none;
#: error of the last accepted step, 0 if its end was moved afterwards; whether the Jacobian is of the present state;
#: evaluations; for who steps again through a run, the step whose start has the Jacobian, counted from 1.
LAST, INVERTED, ERROR, CURRENT, COUNT, OF = range(6)


def make_stepper(n: int, positions: int = 0) -> Stepper:
    """Make the arrays for n equations; the first ones may be positions, of which as many rates follow: q' = v."""
    k = n - positions
    return Stepper(
        new=np.zeros(n), f0=np.zeros(n), f1=np.zeros(n), scale=np.zeros(n),
        stages=np.zeros((6, n)), trial=np.zeros((3, n)), error=np.zeros(n), z=lane_array(n), last=lane_array(n),
        jacobian=np.zeros((n, n)), mass=np.eye(k), slope=np.zeros((3, k)), lack=np.zeros((3, k)),
        inverse=lane_array(k, k), cross=lane_array(k, k), order=np.zeros(k, np.int64),
        force=lane_array(k), turned=lane_array(k), memory=np.zeros(6),
    )  # fmt: skip


@inlined_kernel
def copy(source: Array | Lanes, target: Array | Lanes) -> None:
    """Copy the entries of a vector; compiles in a fraction of the time that numba's assignment takes."""
    for i in range(len(source)):
        target[i] = source[i]


@inlined_kernel
def root_mean_square(squares: float, count: int) -> float:
    """Root of the mean of ``count`` squares with this sum; zero if there are none: no state can err then."""
    return math.sqrt(squares / max(count, 1))


@inlined_kernel
def restart(s: Stepper) -> None:
    """Forget what belongs to another state: Jacobian and prediction."""
    s.memory[LAST], s.memory[INVERTED], s.memory[CURRENT], s.memory[OF] = 0.0, 0.0, 0.0, 0.0


@inlined_kernel
def accept(s: Stepper, h: float, error: float) -> None:
    """Take note that the attempt was accepted."""
    copy(s.z, s.last)
    s.memory[LAST] = h
    s.memory[ERROR] = error
    s.memory[CURRENT] = 0.0
    copy(s.f1, s.f0)
