"""What a method keeps between two attempts at a step, and what a driver tells it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel import Array, Indices, inlined_kernel


class Stepper(NamedTuple):
    """Arrays of a method for n equations, the same for all methods."""

    new: Array  # state at the attempt's end, (n,)
    f0: Array  # derivatives at its start
    f1: Array  # derivatives at its end
    scale: Array  # what an error of 1 is, for each entry
    stages: Array  # derivatives at the stages, or what an implicit method's iteration looks at there, (6, n)
    trial: Array  # state at a stage, (n,)
    slope: Array  # derivatives there that the iteration comes from, (n,)
    z: Array  # stages less the state at the step's start, (3, n)
    last: Array  # the same of the last step, (3, n)
    w1: Array  # from here on: for an implicit method's Newton iteration
    w2: NDArray[np.complex128]
    jacobian: Array  # of the mass times the derivatives
    mass: Array  # of rates and all that follows them
    real: Array  # without the lines of positions, see `make_stepper`
    complex: NDArray[np.complex128]
    pivots: Indices
    pivots2: Indices
    r1: Array
    r2: NDArray[np.complex128]
    memory: Array  # by the indices below, (6,)


#: Indices of `Stepper.memory`: sizes of the last accepted step, and of the step of the factors, 0 if there are none;
#: error of the last accepted step, 0 if its end was moved afterwards; whether the Jacobian is of the present state;
#: evaluations; for who steps again through a run, the step whose start has the Jacobian, counted from 1.
LAST, FACTORED, ERROR, CURRENT, COUNT, OF = range(6)


def make_stepper(n: int, positions: int = 0) -> Stepper:
    """Make the arrays for n equations; the first ones may be positions, of which as many rates follow: q' = v."""
    k = n - positions
    return Stepper(
        new=np.zeros(n), f0=np.zeros(n), f1=np.zeros(n), scale=np.zeros(n),
        stages=np.zeros((6, n)), trial=np.zeros(n), slope=np.zeros(n), z=np.zeros((3, n)), last=np.zeros((3, n)),
        w1=np.zeros(n), w2=np.zeros(n, np.complex128),
        jacobian=np.zeros((n, n)), mass=np.eye(k), real=np.zeros((k, k)), complex=np.zeros((k, k), np.complex128),
        pivots=np.zeros(k, np.int64), pivots2=np.zeros(k, np.int64),
        r1=np.zeros(n), r2=np.zeros(n, np.complex128), memory=np.zeros(6),
    )  # fmt: skip


@inlined_kernel
def copy(source: Array, target: Array) -> None:
    """Copy the entries of a vector; compiles in a fraction of the time that numba's assignment takes."""
    for i in range(len(source)):
        target[i] = source[i]


@inlined_kernel
def restart(s: Stepper) -> None:
    """Forget what belongs to another state: Jacobian and prediction."""
    s.memory[LAST], s.memory[FACTORED], s.memory[CURRENT], s.memory[OF] = 0.0, 0.0, 0.0, 0.0


@inlined_kernel
def accept(s: Stepper, h: float, error: float) -> None:
    """Take note that the attempt was accepted."""
    for stage in range(3):
        copy(s.z[stage], s.last[stage])
    s.memory[LAST] = h
    s.memory[ERROR] = error
    s.memory[CURRENT] = 0.0
    copy(s.f1, s.f0)
