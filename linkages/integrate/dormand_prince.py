"""Dormand and Prince's explicit pair of orders 5 and 4: one attempt at a step of a non-stiff equation.

Coefficients: Dormand and Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26. Step
control: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed., section II.4.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.integrate.stepper import COUNT, ERROR, LAST, Stepper, copy, root_mean_square
from linkages.kernel import Array, kernel

ORDER = 5

_C = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0])
_A = np.array(
    [
        [0, 0, 0, 0, 0],
        [1 / 5, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
    ]
)
_B = np.array([35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84])
_LEAST = 1e-4  # error that a step is credited with at least, and that of the step before the first
_E = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])


def dormand_prince(rhs: Any) -> Any:
    """Make the method's ``attempt`` for a compiled function ``rhs(problem, t, y, dy)``."""

    @kernel
    def attempt(problem: Any, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[float, float]:
        """Attempt a step from (t, y), with f0 known; fills new and f1. See `linkages.integrate.radau`."""
        n, trial = len(y), s.trial[0]
        copy(s.f0, s.stages[0])
        for stage in range(1, 6):
            for i in range(n):
                total = 0.0
                for k in range(stage):
                    total += _A[stage, k] * s.stages[k, i]
                trial[i] = y[i] + h * total
            rhs(problem, t + _C[stage] * h, trial, s.stages[stage])
        for i in range(n):
            total = 0.0
            for k in range(6):
                total += _B[k] * s.stages[k, i]
            s.new[i] = y[i] + h * total
        rhs(problem, t + h, s.new, s.f1)
        s.memory[COUNT] += 6
        if exact:
            return 0.0, 1.0
        square = 0.0
        for i in range(n):
            total = _E[6] * s.f1[i]
            for k in range(6):
                total += _E[k] * s.stages[k, i]
            square += (h * total / s.scale[i]) ** 2
        error = root_mean_square(square, n)
        if not error < 1e100:
            return math.inf, 0.1
        if error > 1.0:
            return error, max(0.2, 0.9 * error**-0.2)
        before = max(s.memory[ERROR], _LEAST) if s.memory[LAST] > 0.0 else _LEAST
        factor = 0.9 * max(error, 1e-10) ** -0.17 * before**0.04
        return error, min(8.0, max(0.2, factor))

    return attempt
