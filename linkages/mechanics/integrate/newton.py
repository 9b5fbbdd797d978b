"""Simplified Newton iterations for the stages of an implicit method with three stages.

The basis in which the inverse of the coefficient matrix is diagonal replaces one system of three times the size by a
real and a complex system (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., section IV.8).

The residual is M(t, y) (f(t, y) - y') with any regular matrix M: for a mechanism the residual is a balance of forces,
which costs less than the accelerations. The iterations use the mass matrix M of the state at which the Jacobian was
computed, and solve for the increments of the rates; the increments of the positions follow from the collocation.

Both systems are solved together, see `linkages.mechanics.integrate.shifted`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from linkages.base.kernel import Array, inlined_kernel, kernel
from linkages.base.kernel.simd import lane, lanes
from linkages.mechanics.integrate.shifted import factorise_both, solve_both
from linkages.mechanics.integrate.stepper import COUNT, INVERTED, OF, Stepper, root_mean_square
from linkages.mechanics.integrate.tableau import Tableau

ITERATIONS = 7  # at most; beyond, a shorter step is cheaper
_EXACT_ITERATIONS = 30  # at most, for a step of fixed size
# Remaining change of the stages relative to the tolerance, in general and for a step of fixed size. Tuned: where masses
# change within the step, 0.01 increased the error of the press's energy fourfold, 0.003 and 0.001 did not.
_GOAL, _EXACT_GOAL = 0.003, 1e-5
# Residual at the end of a step, relative to the problem's own scale; iterations for it, and the rate of convergence
# above which they get a new Jacobian.
_END_GOAL, _END_ITERATIONS, _SLOW = 1e-4, 8, 0.1


class Transformation(NamedTuple):
    """Real forms of a method's matrices: inverse coefficients, its real and complex eigenvalue, change of the basis."""

    inverse: Array  # maps increments of the stages to the step size times the slopes there, (3, 3)
    real: float
    other: complex
    apart: Array  # from the stages to the real number, real and imaginary part of the complex number, (3, 3)
    together: Array  # from these three numbers to the stages, (3, 3)


def transformation(tableau: Tableau) -> Transformation:
    """Diagonalise the inverse of the coefficient matrix (3, 3)."""
    slope = np.linalg.inv(tableau.a).astype(np.float64)
    values, vectors = np.linalg.eig(slope)
    real, other = int(np.argmin(np.abs(values.imag))), int(np.argmax(values.imag))
    inverse = np.linalg.inv(vectors)
    turn = vectors[0, real]  # any factor is correct; this one makes the vectors of the real eigenvalue real
    apart = np.stack([(inverse[real] * turn).real, inverse[other].real, inverse[other].imag])
    together = np.stack(
        [(vectors[:, real] / turn).real, 2.0 * vectors[:, other].real, -2.0 * vectors[:, other].imag], axis=1
    )
    return Transformation(slope, float(values[real].real), complex(values[other]), apart, together)


@inlined_kernel
def columns(matrix: Array, factor: float) -> tuple[Any, Any, Any]:
    """Fill lanes with the columns of a matrix (3, 3) times a factor."""
    return (
        lanes(factor * matrix[0, 0], factor * matrix[1, 0], factor * matrix[2, 0], 0.0),
        lanes(factor * matrix[0, 1], factor * matrix[1, 1], factor * matrix[2, 1], 0.0),
        lanes(factor * matrix[0, 2], factor * matrix[1, 2], factor * matrix[2, 2], 0.0),
    )


@inlined_kernel
def times(matrix: tuple[Any, Any, Any], x: Any) -> Any:
    """Multiply a matrix, given by its `columns`, by lanes."""
    return matrix[0] * lane(x, 0) + matrix[1] * lane(x, 1) + matrix[2] * lane(x, 2)


def factoriser(form: Transformation) -> Any:
    """Make the compiled function that factorises the matrices of the iterations."""
    real, other = form.real, form.other

    @kernel
    def factorise_shifted(s: Stepper, h: float) -> bool:
        """Factorise M shift - J for both shifts, with the positions eliminated; False if a matrix is singular."""
        m, k = len(s.new) - len(s.mass), len(s.mass)
        rate, time = other * (1.0 / h), h * (1.0 / other)
        shift, back = lanes(real / h, rate.real, rate.imag, 0.0), lanes(h / real, time.real, time.imag, 0.0)
        both = lanes(1.0, 1.0, 0.0, 0.0)
        for i in range(k):
            for j in range(k):
                entry = shift * s.mass[i, j] - both * s.jacobian[m + i, m + j]
                s.shifted.matrix[i, j] = entry - back * s.jacobian[m + i, j] if j < m else entry
        s.memory[INVERTED] = h
        return factorise_both(s.shifted)

    return factorise_shifted


def stage_solver(tableau: Tableau, form: Transformation, predict: Any, residual: Any) -> Any:
    """Make the compiled function that solves for the stages; see `linkages.mechanics.integrate.implicit`."""
    c, a, slopes, basis, back = tableau.c, tableau.a, form.inverse, form.apart, form.together

    @kernel(makes_arrays=True)
    def solve(problem: Any, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[bool, int, float]:
        """Solve for the stages; return whether it converged, the iterations, the rate of convergence."""
        n, m, k = len(y), len(y) - len(s.mass), len(s.mass)
        z, trial, slope, left, scale, both = s.z, s.trial, s.slope, s.residual, s.scale, s.shifted
        gain, rates = columns(a, h), columns(slopes, 1.0 / h)
        apart, together = columns(basis, 1.0), columns(back, 1.0)
        predict(s, h)
        goal = _EXACT_GOAL if exact else _GOAL
        iterations = _EXACT_ITERATIONS if exact else ITERATIONS
        before, earlier, rate = 0.0, 0.0, 0.0
        for iteration in range(iterations):
            for i in range(n):
                state = z[i] + y[i]
                trial[0, i], trial[1, i], trial[2, i] = lane(state, 0), lane(state, 1), lane(state, 2)
            for i in range(k):
                found = times(rates, z[m + i])
                slope[0, i], slope[1, i], slope[2, i] = lane(found, 0), lane(found, 1), lane(found, 2)
            for stage in range(3):
                residual(problem, t + c[stage] * h, trial[stage], slope[stage], left[stage])
            s.memory[COUNT] += 3
            for i in range(k):
                both.given[i] = apart[0] * left[0, i] + apart[1] * left[1, i] + apart[2] * left[2, i]
            solve_both(both)
            squares = 0.0
            for i in range(k):
                change = times(together, both.found[i])
                z[m + i] += change
                squares += change * change * (1.0 / (scale[m + i] * scale[m + i]))
                if i < m:
                    moved = times(gain, change)
                    z[i] += moved
                    squares += moved * moved * (1.0 / (scale[i] * scale[i]))
            size = root_mean_square(lane(squares, 0) + lane(squares, 1) + lane(squares, 2), 3 * n)
            if not size < 1e100:
                return False, iteration + 1, 1.0
            if iteration > 0:  # over two iterations: a stiff direction that rotates can undo the gain of a single one
                rate = size / before if iteration == 1 else math.sqrt(size / earlier)
            if iteration > 1:
                rest = iterations - 1 - iteration
                if rate >= 1.0 and size > goal:  # diverges, or has reached rounding errors
                    return before < _GOAL, iteration + 1, rate
                if rate < 1.0 and rate**rest / (1.0 - rate) * size > goal and size > 1e-10:
                    return False, iteration + 1, rate
            if size == 0.0 or size < 1e-10 or (iteration > 0 and rate < 1.0 and rate / (1.0 - rate) * size < goal):
                return True, iteration + 1, rate
            before, earlier = size, before
        return before < goal, iterations, rate

    return solve


def end_solver(form: Transformation, factorise_shifted: Any, jacobian: Any, arrive: Any) -> Any:
    """Make the compiled iterations at the end of a step; see `linkages.mechanics.integrate.implicit`."""
    slopes, real = form.inverse, form.real

    @kernel
    def finish(problem: Any, s: Stepper, t: float, h: float) -> None:
        """Fill f1 with the derivatives of the collocation, and iterate further for the state at the end alone.

        For a stiff problem, a state within the tolerance may have derivatives far from those of the collocation: in a
        film of 0.1 um, rounding errors of a speed change the forces by a thousand times their magnitude.
        """
        n, k = len(s.new), len(s.mass)
        m, left, rates, before, fresh = n - k, s.residual[0], columns(slopes, 1.0 / h), math.inf, False
        for i in range(n):
            s.f1[i] = lane(times(rates, s.z[i]), 2)
        for _ in range(_END_ITERATIONS):
            size = arrive(problem, t + h, s.new, s.f1, left)
            s.memory[COUNT] += 1
            if size <= _END_GOAL or (fresh and not size < before) or not size < math.inf:
                return
            if not size <= _SLOW * before and not fresh:
                jacobian(problem, t + h, s.new, s.mass, s.jacobian)
                s.memory[OF] = 0.0
                fresh = factorise_shifted(s, h)
                if not fresh:
                    s.memory[INVERTED] = 0.0
                    return
            before = size
            for i in range(k):
                s.shifted.given[i] = lanes(left[i], 0.0, 0.0, 0.0)
            solve_both(s.shifted)
            for i in range(k):
                change = lane(s.shifted.found[i], 0)
                s.new[m + i] += change
                if i < m:
                    s.new[i] += change * h / real
        arrive(problem, t + h, s.new, s.f1, left)
        s.memory[COUNT] += 1

    return finish
