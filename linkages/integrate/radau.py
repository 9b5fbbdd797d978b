"""Radau IIA of order 5: one attempt at a step of an implicit method for stiff equations.

Three-stage collocation at the Radau points, solved by simplified Newton iterations in the basis that makes the inverse
of the coefficient matrix diagonal: one real and one complex system instead of one of three times the size. Error
estimate and step control as by Hairer and Wanner, Solving Ordinary Differential Equations II, 2nd ed., section IV.8.

The iterations look at M(t, y) (f(t, y) - y'), with any regular matrix M: of a mechanism that is a balance of forces,
which takes less than its accelerations do. Their matrix has the mass M of the Jacobian's state.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.integrate.factor import back_substitute, factorise
from linkages.integrate.stepper import COUNT, CURRENT, ERROR, FACTORED, LAST, Stepper
from linkages.kernel import Array, Indices, inlined_kernel, kernel

ORDER = 5
_ITERATIONS = 7  # of Newton's method; beyond, a shorter step is cheaper
_EXACT_ITERATIONS = 30  # where a shorter step is no choice
_KEEP = 1.2  # the factors are kept if the step would not grow by more
_FRESH = 1e-3  # rate of convergence below which the Jacobian is kept
# What Newton's method leaves, in parts of the tolerance, and of a step of given size. Tuned: where masses change within
# the step, 0.01 let the press's energy err four times as much as the steps themselves do, 0.003 and 0.001 did not.
_NEWTON, _REST = 0.003, 1e-5


def _collocation() -> tuple[Array, Array, Array]:
    """Nodes c, coefficients A of the method, weights of the error estimate."""
    root = math.sqrt(6.0)
    c = np.array([(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0])
    powers = np.vander(c, 3, increasing=True)  # A maps c^k to c^(k+1)/(k+1)
    integrals = np.stack([c ** (k + 1) / (k + 1) for k in range(3)], axis=1)
    error = np.array([-13.0 - 7.0 * root, -13.0 + 7.0 * root, -1.0]) / 3.0
    return c, integrals @ np.linalg.inv(powers), error


_C, _A, _ERROR = _collocation()
_values, _vectors = np.linalg.eig(np.linalg.inv(_A))
_real, _complex = int(np.argmin(np.abs(_values.imag))), int(np.argmax(_values.imag))
_MU = float(_values[_real].real)
_NU = complex(_values[_complex])
_inverse = np.linalg.inv(_vectors)
# Z = V1 w1 + 2 Re(V2 w2), w1 = R1 Z, w2 = R2 Z
_turn = _vectors[0, _real]  # any factor serves; this one makes the real pair real
_V1 = np.ascontiguousarray((_vectors[:, _real] / _turn).real)
_R1 = np.ascontiguousarray((_inverse[_real] * _turn).real)
_V2, _R2 = np.ascontiguousarray(_vectors[:, _complex]), np.ascontiguousarray(_inverse[_complex])


@kernel
def _factorise(s: Stepper, h: float) -> bool:
    """Factorise M (shift - J) for both shifts; positions, whose rates are entries of the state, are eliminated."""
    m, k = len(s.new) - len(s.real), len(s.real)
    rate, rate2, time, time2 = _MU / h, _NU * (1.0 / h), h / _MU, h * (1.0 / _NU)
    mass, jacobian, one, two = s.mass, s.jacobian, s.real, s.complex
    for i in range(k):
        for j in range(k):
            known, slope = mass[i, j], jacobian[m + i, m + j]
            first, re, im = rate * known - slope, rate2.real * known - slope, rate2.imag * known
            if j < m:
                slope = jacobian[m + i, j]
                first, re, im = first - slope * time, re - slope * time2.real, im - slope * time2.imag
            one[i, j], two[i, j] = first, complex(re, im)
    s.memory[FACTORED] = h
    return bool(factorise(one, s.pivots) and factorise(two, s.pivots2))


@kernel
def _solve(jacobian: Array, factors: Any, pivots: Any, shift: Any, x: Any) -> None:
    """Solve M (shift - J) x = b, b in place."""
    m, k = len(x) - len(factors), len(factors)
    inverse = 1.0 / shift
    for j in range(m):
        x[j] *= inverse
    for i in range(k):
        total = x[m + i]
        for j in range(m):
            total += jacobian[m + i, j] * x[j]
        x[m + i] = total
    back_substitute(factors, pivots, x[m:])
    for j in range(m):
        x[j] += x[m + j] * inverse


@kernel
def hint(s: Stepper, now: float, size: float, times: Array, states: Array, points: Indices) -> None:
    """Make up a last step, of this size, on the polynomial through up to four of the known states.

    Their derivatives are of no use: where equations are stiff the smallest error of a state, times the largest rate
    there is, spoils them.
    """
    weights = np.ones((4, len(points)))
    for row in range(4):
        at = now - size + (size * _C[row] if row < 3 else 0.0)
        for j in range(len(points)):
            for k in range(len(points)):
                if k != j:
                    weights[row, j] *= (at - times[points[k]]) / (times[points[j]] - times[points[k]])
    for stage in range(3):
        for i in range(len(s.new)):
            s.last[stage, i] = 0.0
            for j in range(len(points)):
                s.last[stage, i] += (weights[stage, j] - weights[3, j]) * states[points[j], i]
    s.memory[LAST] = size


@inlined_kernel
def _combined(weights: Any, f0: float, f1: float, f2: float) -> complex:
    """Sum of three numbers, with complex weights."""
    re = weights[0].real * f0 + weights[1].real * f1 + weights[2].real * f2
    return complex(re, weights[0].imag * f0 + weights[1].imag * f1 + weights[2].imag * f2)


@inlined_kernel
def _spread(stage: int, first: float, second: complex) -> float:
    """Join the parts of the real and of the complex system at a stage."""
    return _V1[stage] * first + 2.0 * (_V2[stage].real * second.real - _V2[stage].imag * second.imag)


@kernel
def _predict(s: Stepper, h: float) -> None:
    """Guess the stages: on the last step's collocation polynomial, or along the slope."""
    n, size, z, last, f0 = len(s.new), s.memory[LAST], s.z, s.last, s.f0
    for stage in range(3):
        if size == 0.0:
            for i in range(n):
                z[stage, i] = _C[stage] * h * f0[i]
            continue
        x = 1.0 + _C[stage] * h / size
        l0 = x * (x - _C[1]) * (x - _C[2]) / (_C[0] * (_C[0] - _C[1]) * (_C[0] - _C[2]))
        l1 = x * (x - _C[0]) * (x - _C[2]) / (_C[1] * (_C[1] - _C[0]) * (_C[1] - _C[2]))
        l2 = x * (x - _C[0]) * (x - _C[1]) / (_C[2] * (_C[2] - _C[0]) * (_C[2] - _C[1]))
        for i in range(n):
            z[stage, i] = l0 * last[0, i] + l1 * last[1, i] + (l2 - 1.0) * last[2, i]


@kernel
def _estimate(s: Stepper, h: float, f: Array) -> float:
    """Error of the step in parts of the tolerance; leaves it in r1."""
    n, k = len(s.new), len(s.real)
    for i in range(n):
        s.trial[i] = f[i] + (_ERROR[0] * s.z[0, i] + _ERROR[1] * s.z[1, i] + _ERROR[2] * s.z[2, i]) / h
        s.r1[i] = s.trial[i]
    for i in range(k):
        total = 0.0
        for j in range(k):
            total += s.mass[i, j] * s.trial[n - k + j]
        s.r1[n - k + i] = total
    _solve(s.jacobian, s.real, s.pivots, _MU / h, s.r1)
    total = 0.0
    for i in range(n):
        total += (s.r1[i] / s.scale[i]) ** 2
    return math.sqrt(total / n)


def radau(rhs: Any, residual: Any, jacobian: Any) -> Any:
    """Make the method's ``attempt`` for a problem's compiled functions.

    Parameters
    ----------
    rhs : function
        ``rhs(problem, t, y, dy)`` fills the derivatives f.
    residual : function
        ``residual(problem, t, y, dy, out)`` fills M(t, y) (f(t, y) - dy), with 1 for M in the lines of positions.
    jacobian : function
        ``jacobian(problem, t, y, mass, out)``, called with f known, fills M, without positions, if it is not 1, and
        M df/dy.
    """

    @kernel
    def newton(problem: Any, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[bool, int, float]:
        """Solve for the stages; returns whether it converged, the iterations, the rate of convergence."""
        n, z, w1, w2, r1, r2 = len(y), s.z, s.w1, s.w2, s.r1, s.r2
        trial, slope, stages, scale = s.trial, s.slope, s.stages, s.scale
        _predict(s, h)
        for i in range(n):
            z0, z1, z2 = z[0, i], z[1, i], z[2, i]
            w1[i] = _R1[0] * z0 + _R1[1] * z1 + _R1[2] * z2
            w2[i] = _combined(_R2, z0, z1, z2)
        goal = _REST if exact else _NEWTON
        iterations = _EXACT_ITERATIONS if exact else _ITERATIONS
        rate1, rate2 = _MU / h, _NU * (1.0 / h)
        before, earlier, rate = 0.0, 0.0, 0.0
        for iteration in range(iterations):
            for i in range(n):
                r1[i] = rate1 * w1[i]
                r2[i] = rate2 * w2[i]
            for stage in range(3):
                for i in range(n):
                    trial[i] = y[i] + z[stage, i]
                    slope[i] = _spread(stage, r1[i], r2[i])
                residual(problem, t + _C[stage] * h, trial, slope, stages[stage])
            s.memory[COUNT] += 3
            for i in range(n):
                f0, f1, f2 = stages[0, i], stages[1, i], stages[2, i]
                r1[i] = _R1[0] * f0 + _R1[1] * f1 + _R1[2] * f2
                r2[i] = _combined(_R2, f0, f1, f2)
            _solve(s.jacobian, s.real, s.pivots, rate1, r1)
            _solve(s.jacobian, s.complex, s.pivots2, rate2, r2)
            total = 0.0
            for i in range(n):
                w1[i] += r1[i]
                w2[i] += r2[i]
                square = 0.0
                for stage in range(3):
                    change = _spread(stage, r1[i], r2[i])
                    z[stage, i] += change
                    square += change * change
                total += square / (scale[i] * scale[i])
            size = math.sqrt(total / (3 * n))
            if not size < 1e100:
                return False, iteration + 1, 1.0
            if (
                iteration > 0
            ):  # of two iterations where there are: stiff directions that turn undo one's gain in the next
                rate = size / before if iteration == 1 else math.sqrt(size / earlier)
            if iteration > 1:
                left = iterations - 1 - iteration
                if rate >= 1.0 and size > goal:  # diverges, or is as good as rounding lets it be
                    return before < _NEWTON, iteration + 1, rate
                if rate < 1.0 and rate**left / (1.0 - rate) * size > goal and size > 1e-10:
                    return False, iteration + 1, rate
            if size == 0.0 or size < 1e-10 or (iteration > 0 and rate < 1.0 and rate / (1.0 - rate) * size < goal):
                return True, iteration + 1, rate
            before, earlier = size, before
        return before < goal, iterations, rate

    @kernel
    def attempt(problem: Any, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[float, float]:
        """Attempt a step from (t, y), with f0 known; fills new and f1.

        Parameters
        ----------
        exact : bool
            Whether the step's size is given: Newton's method is then carried further, and the error is not asked for.

        Returns
        -------
        error : float
            In parts of the tolerance; infinite if Newton's method failed.
        factor : float
            By which the next attempt's step should differ.
        """
        n = len(y)
        new_jacobian = False
        for trial in range(2):
            if s.memory[FACTORED] == 0.0:
                jacobian(problem, t, y, s.mass, s.jacobian)
                s.memory[CURRENT] = 1.0
                new_jacobian = True
            if s.memory[FACTORED] != h and not _factorise(s, h):
                s.memory[FACTORED] = 0.0
                return math.inf, 0.5
            converged, iterations, rate = newton(problem, s, t, h, y, exact)
            if converged:
                break
            if trial == 0 and not new_jacobian and s.memory[CURRENT] == 0.0:
                s.memory[FACTORED] = 0.0
                continue
            return math.inf, 0.5
        for i in range(n):
            s.new[i] = y[i] + s.z[2, i]
        if exact:
            rhs(problem, t + h, s.new, s.f1)
            s.memory[COUNT] += 1
            return 0.0, 1.0
        error = _estimate(s, h, s.f0)
        safety = 0.9 * (2 * _ITERATIONS + 1) / (2 * _ITERATIONS + iterations)
        if error > 1.0:
            for i in range(n):
                s.trial[i] = y[i] + s.r1[i]
            rhs(problem, t, s.trial, s.f1)
            s.memory[COUNT] += 1
            error = _estimate(s, h, s.f1)
        factor = min(8.0, max(0.1, safety * error**-0.25)) if error > 0.0 else 8.0
        if not error <= 1.0:
            if error != error:
                return math.inf, 0.1
            return error, min(factor, 0.9)
        if s.memory[LAST] > 0.0 and s.memory[ERROR] > 0.0 and error > 0.0:  # Gustafsson: the trend of the error
            trend = h / s.memory[LAST] * (s.memory[ERROR] / error) ** 0.25
            factor = min(factor, factor * trend)
        if iterations > 2 and rate > _FRESH:
            s.memory[FACTORED] = 0.0  # the next step gets a new Jacobian
        elif 1.0 <= factor < _KEEP:
            factor = 1.0
        rhs(problem, t + h, s.new, s.f1)
        s.memory[COUNT] += 1
        return error, factor

    return attempt
