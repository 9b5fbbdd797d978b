"""The arrays of a Runge-Kutta method: values of the present attempt, and memory of the last accepted step."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, inlined_kernel
from linkages.base.kernel.simd import LaneArray as Lanes
from linkages.base.kernel.simd import lane_array
from linkages.mechanics.integrate.shifted import Shifted, make_shifted


class Stepper(NamedTuple):
    """Arrays of a method for n equations, the same for all methods."""

    new: Array  # state at the end of the attempt, (n,)
    f0: Array  # derivatives at its start
    f1: Array  # derivatives at its end
    scale: Array  # tolerance of each entry of the state
    stages: Array  # derivatives at the stages of an explicit method, (6, n)
    trial: Array  # states at the stages, (3, n)
    error: Array  # estimated error of the new state, (n,)
    z: Lanes  # increments of the stages of an implicit method, (n,)
    last: Lanes  # increments of the stages of the last accepted step, (n,)
    jacobian: Array  # mass matrix times the Jacobian of the derivatives, (n, n)
    mass: Array  # mass matrix of the k entries that are not positions, (k, k)
    slope: Array  # derivatives at the stages, for the residual, (3, k)
    residual: Array  # (3, k)
    shifted: Shifted  # the two systems of the iterations, see `linkages.mechanics.integrate.newton`
    memory: Array  # numbers with the indices below, (6,)


#: Indices of `Stepper.memory`: size of the last accepted step, and step size of the inverses, 0 without; error of the
#: last accepted step, 0 if the state was changed afterwards; whether the Jacobian belongs to the present state; number
#: of evaluations; for a replay of a run, the step at whose start the Jacobian was computed, counted from 1.
LAST, INVERTED, ERROR, CURRENT, COUNT, OF = range(6)


def make_stepper(n: int, positions: int = 0) -> Stepper:
    """Make the arrays for n equations; the first entries may be positions, followed by as many rates."""
    k = n - positions
    return Stepper(
        new=np.zeros(n), f0=np.zeros(n), f1=np.zeros(n), scale=np.zeros(n),
        stages=np.zeros((6, n)), trial=np.zeros((3, n)), error=np.zeros(n), z=lane_array(n), last=lane_array(n),
        jacobian=np.zeros((n, n)), mass=np.eye(k), slope=np.zeros((3, k)), residual=np.zeros((3, k)),
        shifted=make_shifted(k), memory=np.zeros(6),
    )  # fmt: skip


@inlined_kernel
def copy(source: Array | Lanes, target: Array | Lanes) -> None:
    """Copy the entries of a vector; compiles faster than numba's assignment."""
    for i in range(len(source)):
        target[i] = source[i]


@inlined_kernel
def root_mean_square(squares: float, count: int) -> float:
    """Compute the root of the mean of ``count`` squares with this sum; zero without any."""
    return math.sqrt(squares / max(count, 1))


@inlined_kernel
def restart(s: Stepper) -> None:
    """Discard the Jacobian and the last step, after a change of the state."""
    s.memory[LAST], s.memory[INVERTED], s.memory[CURRENT], s.memory[OF] = 0.0, 0.0, 0.0, 0.0


@inlined_kernel
def accept(s: Stepper, h: float, error: float) -> None:
    """Keep the accepted attempt as the last step."""
    copy(s.z, s.last)
    s.memory[LAST] = h
    s.memory[ERROR] = error
    s.memory[CURRENT] = 0.0
    copy(s.f1, s.f0)
