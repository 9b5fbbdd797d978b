"""Radau IIA of order 5: one attempt at a step of an implicit method for stiff equations.

Three-stage collocation at the Radau points, solved by simplified Newton iterations in the basis that makes the inverse
of the coefficient matrix diagonal: one real and one complex system instead of one of three times the size. Error
estimate and step control as by Hairer and Wanner, Solving Ordinary Differential Equations II, 2nd ed., section IV.8.

The iterations look at M(t, y) (f(t, y) - y'), with any regular matrix M: of a mechanism that is a balance of forces,
which takes less than its accelerations do. Their matrix has the mass M of the Jacobian's state. They are of the rates
alone: positions at the stages follow from these by the collocation.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.integrate.shifted import invert, row_times, swapped
from linkages.integrate.stepper import COUNT, CURRENT, ERROR, INVERTED, LAST, OF, Stepper, root_mean_square
from linkages.kernel import Array, Indices, inlined_kernel, kernel
from linkages.kernel.lanes import lane, lanes

ORDER = 5
_ITERATIONS = 7  # of Newton's method; beyond, a shorter step is cheaper
_EXACT_ITERATIONS = 30  # where a shorter step is no choice
_KEEP = 1.2  # the inverses are kept if the step would not grow by more
_FRESH = 1e-3  # rate of convergence below which the Jacobian is kept
# What Newton's method leaves, in parts of the tolerance, and of a step of given size. Tuned: where masses change within
# the step, 0.01 let the press's energy err four times as much as the steps themselves do, 0.003 and 0.001 did not.
_NEWTON, _REST = 0.003, 1e-5
# What Newton's method leaves at the end of a step, in parts of what the problem compares it with; iterations for that,
# and the rate of their convergence above which they get a new Jacobian.
_LEFT, _FINISHING, _SLOW = 1e-4, 8, 0.1
# Rate of convergence up to which steps grow, as if it grew with them. Tuned: from 0.1 to 0.15 runs with thin films take
# the fewest evaluations, at an accuracy of 1e-5 a tenth to a quarter less than without it, when a third of the attempts
# failed there.
_RATE = 0.12


def _collocation() -> tuple[Array, Array, Array]:
    """Nodes c, coefficients A of the method, weights of the error estimate."""
    root = math.sqrt(6.0)
    c = np.array([(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0])
    powers = np.vander(c, 3, increasing=True)  # A maps c^k to c^(k+1)/(k+1)
    integrals = np.stack([c ** (k + 1) / (k + 1) for k in range(3)], axis=1)
    error = np.array([-13.0 - 7.0 * root, -13.0 + 7.0 * root, -1.0]) / 3.0
    return c, integrals @ np.linalg.inv(powers), error


_C, _A, _ERROR = _collocation()
_SLOPE = np.linalg.inv(_A).astype(np.float64)  # from what stages gain in a step to its size times the slopes there
_values, _vectors = np.linalg.eig(_SLOPE)
_real, _complex = int(np.argmin(np.abs(_values.imag))), int(np.argmax(_values.imag))
_MU = float(_values[_real].real)
_NU = complex(_values[_complex])
_inverse = np.linalg.inv(_vectors)
_turn = _vectors[0, _real]  # any factor serves; this one makes the real pair real
# from the stages to the real number, real and imaginary part of the complex one; and back
_APART = np.stack([(_inverse[_real] * _turn).real, _inverse[_complex].real, _inverse[_complex].imag])
_TOGETHER = np.stack(
    [(_vectors[:, _real] / _turn).real, 2.0 * _vectors[:, _complex].real, -2.0 * _vectors[:, _complex].imag], axis=1
)


@inlined_kernel
def _columns(matrix: Array, factor: float) -> tuple[Any, Any, Any]:
    """Columns of a matrix (3, 3) times a factor, in lanes."""
    return (
        lanes(factor * matrix[0, 0], factor * matrix[1, 0], factor * matrix[2, 0], 0.0),
        lanes(factor * matrix[0, 1], factor * matrix[1, 1], factor * matrix[2, 1], 0.0),
        lanes(factor * matrix[0, 2], factor * matrix[1, 2], factor * matrix[2, 2], 0.0),
    )


@inlined_kernel
def _times(columns: tuple[Any, Any, Any], x: Any) -> Any:
    """Product of a matrix, by its columns, and lanes."""
    return columns[0] * lane(x, 0) + columns[1] * lane(x, 1) + columns[2] * lane(x, 2)


@kernel
def _invert(s: Stepper, h: float) -> bool:
    """Invert M shift - J for both shifts; positions, whose rates are entries of the state, are eliminated."""
    m, k = len(s.new) - len(s.mass), len(s.mass)
    rate, time = _NU * (1.0 / h), h * (1.0 / _NU)
    shift, back = lanes(_MU / h, rate.real, rate.imag, 0.0), lanes(h / _MU, time.real, time.imag, 0.0)
    both = lanes(1.0, 1.0, 0.0, 0.0)
    for i in range(k):
        for j in range(k):
            entry = shift * s.mass[i, j] - both * s.jacobian[m + i, m + j]
            s.inverse[i, j] = entry - back * s.jacobian[m + i, j] if j < m else entry
    s.memory[INVERTED] = h
    return invert(s.inverse, s.cross, s.order)


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
    for i in range(len(s.new)):
        s.last[i] = 0.0
        for j in range(len(points)):
            own = lanes(weights[0, j], weights[1, j], weights[2, j], 0.0) - lanes(1.0, 1.0, 1.0, 0.0) * weights[3, j]
            s.last[i] += own * states[points[j], i]
    s.memory[LAST] = size


@kernel
def _predict(s: Stepper, h: float) -> None:
    """Guess the stages: on the last step's collocation polynomial, or along the slope.

    Those of positions follow from those of rates, as they do after each iteration.
    """
    n, m, size, z, last, f0 = len(s.new), len(s.new) - len(s.mass), s.memory[LAST], s.z, s.last, s.f0
    at = lanes(_C[0], _C[1], _C[2], 0.0) * h
    if size == 0.0:
        for i in range(m, n):
            z[i] = at * f0[i]
    else:
        x = at / size + 1.0
        l0 = x * (x - _C[1]) * (x - _C[2]) / (_C[0] * (_C[0] - _C[1]) * (_C[0] - _C[2]))
        l1 = x * (x - _C[0]) * (x - _C[2]) / (_C[1] * (_C[1] - _C[0]) * (_C[1] - _C[2]))
        l2 = x * (x - _C[0]) * (x - _C[1]) / (_C[2] * (_C[2] - _C[0]) * (_C[2] - _C[1])) - 1.0
        for i in range(m, n):
            z[i] = l0 * lane(last[i], 0) + l1 * lane(last[i], 1) + l2 * lane(last[i], 2)
    gain = _columns(_A, h)
    for i in range(m):
        z[i] = _times(gain, z[m + i] + f0[i])


@kernel
def _estimate(s: Stepper, h: float, f: Array) -> float:
    """Error of the step in parts of the tolerance; leaves it in ``error``."""
    n, k, error = len(s.new), len(s.mass), s.error
    m, time, trial = n - k, h / _MU, s.trial[0]
    for i in range(n):
        z = s.z[i]
        trial[i] = f[i] + (_ERROR[0] * lane(z, 0) + _ERROR[1] * lane(z, 1) + _ERROR[2] * lane(z, 2)) / h
    for i in range(m):
        error[i] = trial[i] * time
    for i in range(k):
        total = 0.0
        for j in range(k):
            total += s.mass[i, j] * trial[m + j]
        for j in range(m):
            total += s.jacobian[m + i, j] * error[j]
        trial[i] = total
    square = 0.0
    for i in range(k):
        total = 0.0
        for j in range(k):
            total += lane(s.inverse[i, j], 0) * trial[j]
        error[m + i] = total
        if i < m:
            error[i] += total * time
    for i in range(n):
        square += (error[i] / s.scale[i]) ** 2
    return root_mean_square(square, n)


def _solver(residual: Any) -> Any:
    """Make the simplified Newton iterations for a problem's compiled residual, see `radau`."""

    @kernel
    def newton(problem: Any, s: Stepper, t: float, h: float, y: Array, exact: bool) -> tuple[bool, int, float]:
        """Solve for the stages; returns whether it converged, the iterations, the rate of convergence."""
        n, m, k = len(y), len(y) - len(s.mass), len(s.mass)
        z, trial, slope, lack, scale, inverse, cross = s.z, s.trial, s.slope, s.lack, s.scale, s.inverse, s.cross
        gain, rates = _columns(_A, h), _columns(_SLOPE, 1.0 / h)
        apart, together = _columns(_APART, 1.0), _columns(_TOGETHER, 1.0)
        _predict(s, h)
        goal = _REST if exact else _NEWTON
        iterations = _EXACT_ITERATIONS if exact else _ITERATIONS
        before, earlier, rate = 0.0, 0.0, 0.0
        for iteration in range(iterations):
            for i in range(n):
                state = z[i] + y[i]
                trial[0, i], trial[1, i], trial[2, i] = lane(state, 0), lane(state, 1), lane(state, 2)
            for i in range(k):
                found = _times(rates, z[m + i])
                slope[0, i], slope[1, i], slope[2, i] = lane(found, 0), lane(found, 1), lane(found, 2)
            for stage in range(3):
                residual(problem, t + _C[stage] * h, trial[stage], slope[stage], lack[stage])
            s.memory[COUNT] += 3
            for i in range(k):
                force = apart[0] * lack[0, i] + apart[1] * lack[1, i] + apart[2] * lack[2, i]
                s.force[i], s.turned[i] = force, swapped(force)
            squares = 0.0
            for i in range(k):
                change = _times(together, row_times(inverse, cross, i, s.force, s.turned))
                z[m + i] += change
                squares += change * change * (1.0 / (scale[m + i] * scale[m + i]))
                if i < m:
                    moved = _times(gain, change)
                    z[i] += moved
                    squares += moved * moved * (1.0 / (scale[i] * scale[i]))
            size = root_mean_square(lane(squares, 0) + lane(squares, 1) + lane(squares, 2), 3 * n)
            if not size < 1e100:
                return False, iteration + 1, 1.0
            if iteration > 0:  # by two at once: stiff directions that turn undo one iteration's gain in the next
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

    return newton


def _finisher(jacobian: Any, arrive: Any) -> Any:
    """Make the iterations at the end of a step for a problem's compiled functions, see `radau`."""

    @kernel
    def finish(problem: Any, s: Stepper, t: float, h: float) -> None:
        """Fill f1 with the derivatives of the collocation, and carry Newton's method on for the state at the end alone.

        Where a problem is stiff, a state within the tolerance may have derivatives far from those of the collocation: a
        film of 0.1 um turns the last digits of a speed into forces a thousand times as large as those that act.
        """
        n, k = len(s.new), len(s.mass)
        m, lack, rates, before, fresh = n - k, s.lack[0], _columns(_SLOPE, 1.0 / h), math.inf, False
        for i in range(n):
            s.f1[i] = lane(_times(rates, s.z[i]), 2)
        for _ in range(_FINISHING):
            left = arrive(problem, t + h, s.new, s.f1, lack)
            s.memory[COUNT] += 1
            if left <= _LEFT or (fresh and not left < before) or not left < math.inf:
                return
            if not left <= _SLOW * before and not fresh:
                jacobian(problem, t + h, s.new, s.mass, s.jacobian)
                s.memory[OF] = 0.0
                fresh = _invert(s, h)
                if not fresh:
                    s.memory[INVERTED] = 0.0
                    return
            before = left
            for i in range(k):
                change = 0.0
                for j in range(k):
                    change += lane(s.inverse[i, j], 0) * lack[j]
                s.new[m + i] += change
                if i < m:
                    s.new[i] += change * h / _MU
        arrive(problem, t + h, s.new, s.f1, lack)
        s.memory[COUNT] += 1

    return finish


def radau(rhs: Any, residual: Any, jacobian: Any, arrive: Any) -> Any:
    """Make the method's ``attempt`` for a problem's compiled functions.

    Parameters
    ----------
    rhs : function
        ``rhs(problem, t, y, dy)`` fills the derivatives f.
    residual : function
        ``residual(problem, t, y, dy, out)`` fills M(t, y) (f(t, y) - y'); y' in `dy`, and `out`, without positions.
    jacobian : function
        ``jacobian(problem, t, y, mass, out)``, called with f known, fills M, without positions, if it is not 1, and
        M df/dy.
    arrive : function
        ``arrive(problem, t, y, dy, out) -> left`` is called at the end of a step with the derivatives y' of its
        collocation, which are f but for what Newton's method left, and makes the problem ready for `jacobian` there; it
        may change dy. It fills `out` as ``residual`` does, and returns its size in parts of what it is small against.
    """
    newton, finish = _solver(residual), _finisher(jacobian, arrive)

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
            if s.memory[INVERTED] == 0.0:
                jacobian(problem, t, y, s.mass, s.jacobian)
                s.memory[CURRENT] = 1.0
                new_jacobian = True
            if s.memory[INVERTED] != h and not _invert(s, h):
                s.memory[INVERTED] = 0.0
                return math.inf, 0.5
            converged, iterations, rate = newton(problem, s, t, h, y, exact)
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
        error = _estimate(s, h, s.f0)
        safety = 0.9 * (2 * _ITERATIONS + 1) / (2 * _ITERATIONS + iterations)
        if error > 1.0:
            for i in range(n):
                s.trial[0, i] = y[i] + s.error[i]
            rhs(problem, t, s.trial[0], s.f1)
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
        if iterations > 1 and rate > 0.0:
            factor = min(factor, max(1.0, _RATE / rate))
        if rate > _RATE or (iterations > 2 and rate > _FRESH):
            s.memory[INVERTED] = 0.0  # the next step gets a new Jacobian
        elif 1.0 <= factor < _KEEP:
            factor = 1.0
        finish(problem, s, t, h)
        return error, factor

    return attempt
