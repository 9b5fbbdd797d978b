"""One attempted step of an implicit Runge-Kutta method by collocation with three stages, such as Radau IIA.

Error estimate: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., section IV.8.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.base.kernel import Array, Indices, kernel
from linkages.base.kernel.simd import lane, lanes
from linkages.mechanics.integrate.controller import ELEMENTARY_3, controller, predictive_limit
from linkages.mechanics.integrate.newton import (
    ITERATIONS,
    Transformation,
    columns,
    end_solver,
    factoriser,
    stage_solver,
    times,
    transformation,
)
from linkages.mechanics.integrate.shifted import solve_both
from linkages.mechanics.integrate.stepper import COUNT, CURRENT, ERROR, INVERTED, LAST, Stepper, root_mean_square
from linkages.mechanics.integrate.tableau import RADAU_IIA_5, Tableau

_KEEP = 1.2  # ratio of step sizes below which the step size and the inverses are kept
_FRESH = 1e-3  # rate of convergence below which the Jacobian is kept
# Rate of convergence up to which steps grow; the rate is taken as proportional to the step size. Tuned: with values
# from 0.1 to 0.15 runs with thin films need the fewest evaluations. Without the limit, at an accuracy of 1e-5, a third
# of the attempts failed and a tenth to a quarter more evaluations were needed.
_RATE = 0.12

_C = RADAU_IIA_5.c


@kernel(makes_arrays=True)
def set_last_step(s: Stepper, now: float, size: float, t: Array, states: Array, points: Indices) -> None:
    """Set the last step, of this size, from the polynomial through up to four known states, for the prediction.

    The derivatives of the states are not used: for stiff equations the smallest error of a state, times the largest
    rate, spoils them.
    """
    weights = np.ones((4, len(points)))
    for row in range(4):
        at = now - size + (size * _C[row] if row < 3 else 0.0)
        for j in range(len(points)):
            for k in range(len(points)):
                if k != j:
                    weights[row, j] *= (at - t[points[k]]) / (t[points[j]] - t[points[k]])
    for i in range(len(s.new)):
        s.last[i] = 0.0
        for j in range(len(points)):
            own = lanes(weights[0, j], weights[1, j], weights[2, j], 0.0) - lanes(1.0, 1.0, 1.0, 0.0) * weights[3, j]
            s.last[i] += own * states[points[j], i]
    s.memory[LAST] = size


def _predictor(tableau: Tableau) -> Any:
    """Make the compiled function that guesses the stages."""
    c, a = tableau.c, tableau.a

    @kernel
    def predict(s: Stepper, h: float) -> None:
        """Extrapolate the last step's collocation polynomial, or the slope, to the stages of the rates.

        The stages of the positions follow from the collocation, as after each iteration.
        """
        n, m, size, z, last, f0 = len(s.new), len(s.new) - len(s.mass), s.memory[LAST], s.z, s.last, s.f0
        at = lanes(c[0], c[1], c[2], 0.0) * h
        if size == 0.0:
            for i in range(m, n):
                z[i] = at * f0[i]
        else:
            x = at / size + 1.0
            l0 = x * (x - c[1]) * (x - c[2]) / (c[0] * (c[0] - c[1]) * (c[0] - c[2]))
            l1 = x * (x - c[0]) * (x - c[2]) / (c[1] * (c[1] - c[0]) * (c[1] - c[2]))
            l2 = x * (x - c[0]) * (x - c[1]) / (c[2] * (c[2] - c[0]) * (c[2] - c[1])) - 1.0
            for i in range(m, n):
                z[i] = l0 * lane(last[i], 0) + l1 * lane(last[i], 1) + l2 * lane(last[i], 2)
        gain = columns(a, h)
        for i in range(m):
            z[i] = times(gain, z[m + i] + f0[i])

    return predict


def _estimator(tableau: Tableau, form: Transformation) -> Any:
    """Make the compiled error estimate."""
    weights, real = tableau.error, form.real

    @kernel
    def estimate(s: Stepper, h: float, f: Array) -> float:
        """Estimate the error relative to the tolerance, from the derivatives f at the start; fill ``error``."""
        n, k, error = len(s.new), len(s.mass), s.error
        m, time, trial = n - k, h / real, s.trial[0]
        for i in range(n):
            z = s.z[i]
            trial[i] = f[i] + (weights[0] * lane(z, 0) + weights[1] * lane(z, 1) + weights[2] * lane(z, 2)) / h
        for i in range(m):
            error[i] = trial[i] * time
        for i in range(k):
            total = 0.0
            for j in range(k):
                total += s.mass[i, j] * trial[m + j]
            for j in range(m):
                total += s.jacobian[m + i, j] * error[j]
            s.shifted.given[i] = lanes(total, 0.0, 0.0, 0.0)
        solve_both(s.shifted)
        square = 0.0
        for i in range(k):
            total = lane(s.shifted.found[i], 0)
            error[m + i] = total
            if i < m:
                error[i] += total * time
        for i in range(n):
            square += (error[i] / s.scale[i]) ** 2
        return root_mean_square(square, n)

    return estimate


def implicit(tableau: Tableau, rhs: Any, residual: Any, jacobian: Any, arrive: Any) -> Any:
    """Make the compiled function ``attempt`` of a tableau of three stages, the last of which is at the end of the step.

    See `linkages.mechanics.integrate.driver`, which explains `rhs` too; f are the derivatives that it fills.

    Parameters
    ----------
    residual : function
        ``residual(problem, t, y, dy, out)`` fills M(t, y) (f(t, y) - y'); `dy` (y') and `out`
        have no positions.
    jacobian : function
        ``jacobian(problem, t, y, mass, out)`` fills M, without positions, unless M is 1, and M df/dy. It is called
        after an evaluation of f at the same state.
    arrive : function
        ``arrive(problem, t, y, dy, out) -> size`` is called at the end of a step with the derivatives y' of the
        collocation, which differ from f by the remaining residual; it may change dy, and it makes the problem ready
        for `jacobian`. It fills `out` as ``residual`` does, and returns its size relative to the problem's own scale.
    """
    form = transformation(tableau)
    factorise_shifted, estimate = factoriser(form), _estimator(tableau, form)
    solve = stage_solver(tableau, form, _predictor(tableau), residual)
    finish, ratio = end_solver(form, factorise_shifted, jacobian, arrive), controller(ELEMENTARY_3)

    @kernel(makes_arrays=True)
    def attempt(problem: Any, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[float, float]:
        """Attempt a step from (t, y), with f0 known; fill new and f1."""
        n = len(y)
        new_jacobian = False
        for trial in range(2):
            if s.memory[INVERTED] == 0.0:
                jacobian(problem, t, y, s.mass, s.jacobian)
                s.memory[CURRENT] = 1.0
                new_jacobian = True
            if s.memory[INVERTED] != h and not factorise_shifted(s, h):
                s.memory[INVERTED] = 0.0
                return math.inf, 0.5
            converged, iterations, rate = solve(problem, s, t, h, y, exact)
            if converged:
                break
            if trial == 0 and not new_jacobian and s.memory[CURRENT] == 0.0:
                s.memory[INVERTED] = 0.0
                continue
            return math.inf, 0.5
        for i in range(n):
            s.new[i] = y[i] + lane(s.z[i], 2)
        if exact:
            finish(problem, s, t, h)
            rhs(problem, t + h, s.new, s.f1)
            s.memory[COUNT] += 1
            return 0.0, 1.0
        error = estimate(s, h, s.f0)
        if error > 1.0:
            for i in range(n):
                s.trial[0, i] = y[i] + s.error[i]
            rhs(problem, t, s.trial[0], s.f1)
            s.memory[COUNT] += 1
            error = estimate(s, h, s.f1)
        if error != error:
            return math.inf, 0.1
        factor = ratio(error, 1.0, 0.9 * (2 * ITERATIONS + 1) / (2 * ITERATIONS + iterations))
        if error > 1.0:
            return error, factor
        if s.memory[LAST] > 0.0 and s.memory[ERROR] > 0.0 and error > 0.0:
            factor = predictive_limit(factor, h, s.memory[LAST], error, s.memory[ERROR])
        if iterations > 1 and rate > 0.0:
            factor = min(factor, max(1.0, _RATE / rate))
        if rate > _RATE or (iterations > 2 and rate > _FRESH):
            s.memory[INVERTED] = 0.0  # a new Jacobian for the next step
        elif 1.0 <= factor < _KEEP:
            factor = 1.0
        finish(problem, s, t, h)
        return error, factor

    return attempt
