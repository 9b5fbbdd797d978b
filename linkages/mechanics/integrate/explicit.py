"""One attempted step of an explicit Runge-Kutta pair whose last derivative is the first of the next step."""

from __future__ import annotations

import math
from typing import Any

from linkages.base.kernel import Array, kernel
from linkages.mechanics.integrate.controller import PI_5_4, controller
from linkages.mechanics.integrate.stepper import COUNT, ERROR, LAST, Stepper, copy, root_mean_square
from linkages.mechanics.integrate.tableau import Tableau

_LEAST_PREVIOUS = 1e-4  # smallest error of the previous step for the controller, and the value for a first step


def explicit(tableau: Tableau, rhs: Any) -> Any:
    """Make the compiled function ``attempt`` of a tableau; see `linkages.mechanics.integrate.driver`."""
    a, b, c, weights, count = tableau.a, tableau.b, tableau.c, tableau.error, len(tableau.c)
    ratio = controller(PI_5_4)

    @kernel(makes_arrays=True)
    def attempt(problem: Any, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[float, float]:
        """Attempt a step from (t, y), with f0 known; fill new and f1."""
        n, trial = len(y), s.trial[0]
        copy(s.f0, s.stages[0])
        for stage in range(1, count):
            for i in range(n):
                total = 0.0
                for k in range(stage):
                    total += a[stage, k] * s.stages[k, i]
                trial[i] = y[i] + h * total
            rhs(problem, t + c[stage] * h, trial, s.stages[stage])
        for i in range(n):
            total = 0.0
            for k in range(count):
                total += b[k] * s.stages[k, i]
            s.new[i] = y[i] + h * total
        rhs(problem, t + h, s.new, s.f1)
        s.memory[COUNT] += count
        if exact:
            return 0.0, 1.0
        square = 0.0
        for i in range(n):
            total = weights[count] * s.f1[i]
            for k in range(count):
                total += weights[k] * s.stages[k, i]
            square += (h * total / s.scale[i]) ** 2
        error = root_mean_square(square, n)
        if not error < 1e100:
            return math.inf, 0.1
        previous = max(s.memory[ERROR], _LEAST_PREVIOUS) if s.memory[LAST] > 0.0 else _LEAST_PREVIOUS
        return error, ratio(error, previous, 0.9)

    return attempt
