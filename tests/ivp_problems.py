"""Stiff problems of the Test Set for IVP Solvers, with exact Jacobians and published end values.

F. Mazzia and C. Magherini, Test Set for Initial Value Problem Solvers, release 2.4, Department of Mathematics,
University of Bari and INdAM, 2008: problems ROBER, VDPOL, HIRES, OREGO; equations, intervals and reference solutions
(there computed with RADAU in extended precision, tolerance 1.1e-18). Its van der Pol oscillator is the unscaled one,
mu = 1e3; with t/mu as time and mu y2 as speed it is the one with eps = 1e-6.

And small problems of closed form, and the integrators bound to all of them: one right-hand side, so that each method is
compiled once. All compiled code is in this file, so that the compiler's cache notices its edits.

The functions are compiled and share the signature ``rhs(problem, t, y, out)``, ``jacobian(problem, t, y, out)``, where
`problem` is a tuple of arrays, `y` (n,) the state, and `out` (n,) or (n, n) is filled.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from linkages.base.kernel import kernel
from linkages.base.kernel.by_reference import reference
from linkages.mechanics.integrate.driver import DONE, driver
from linkages.mechanics.integrate.explicit import explicit
from linkages.mechanics.integrate.implicit import implicit
from linkages.mechanics.integrate.stepper import accept
from linkages.mechanics.integrate.tableau import DORMAND_PRINCE_5_4, RADAU_IIA_5

EMPTY = (np.zeros(0),)


@dataclass(frozen=True)
class Problem:
    """An initial value problem y' = f(t, y), y(0) = start.

    Attributes
    ----------
    rhs, jacobian : compiled functions
        Signature in the module's docstring.
    problem : tuple of arrays
        First argument of both.
    start, reference : (n,) arrays
        y(0), and the published y(end).
    end : float
    scale : (n,) array
        Size of the smallest values that count, for absolute tolerances.
    """

    rhs: Callable
    jacobian: Callable
    problem: tuple
    start: np.ndarray
    end: float
    reference: np.ndarray
    scale: np.ndarray


@kernel
def robertson(problem, t, y, out):
    """Autocatalytic reaction of Robertson (1966)."""
    slow, fast, faster = 0.04 * y[0], 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    out[0] = -slow + fast
    out[1] = slow - fast - faster
    out[2] = faster


@kernel
def robertson_jacobian(problem, t, y, out):
    out[0, 0], out[0, 1], out[0, 2] = -0.04, 1e4 * y[2], 1e4 * y[1]
    out[1, 0], out[1, 1], out[1, 2] = 0.04, -1e4 * y[2] - 6e7 * y[1], -1e4 * y[1]
    out[2, 0], out[2, 1], out[2, 2] = 0.0, 6e7 * y[1], 0.0


@kernel
def van_der_pol(problem, t, y, out):
    """Van der Pol's oscillator; ``problem[0][0]`` is mu."""
    out[0] = y[1]
    out[1] = problem[0][0] * (1.0 - y[0] ** 2) * y[1] - y[0]


@kernel
def van_der_pol_jacobian(problem, t, y, out):
    mu = problem[0][0]
    out[0, 0], out[0, 1] = 0.0, 1.0
    out[1, 0], out[1, 1] = -2.0 * mu * y[0] * y[1] - 1.0, mu * (1.0 - y[0] ** 2)


@kernel
def hires(problem, t, y, out):
    """High irradiance responses of photomorphogenesis, Schaefer (1975)."""
    bound = 280.0 * y[5] * y[7]
    out[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007
    out[1] = 1.71 * y[0] - 8.75 * y[1]
    out[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4]
    out[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3]
    out[4] = -1.745 * y[4] + 0.43 * y[5] + 0.43 * y[6]
    out[5] = -bound + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6]
    out[6] = bound - 1.81 * y[6]
    out[7] = -bound + 1.81 * y[6]


@kernel
def hires_jacobian(problem, t, y, out):
    out[:] = 0.0
    out[0, 0], out[0, 1], out[0, 2] = -1.71, 0.43, 8.32
    out[1, 0], out[1, 1] = 1.71, -8.75
    out[2, 2], out[2, 3], out[2, 4] = -10.03, 0.43, 0.035
    out[3, 1], out[3, 2], out[3, 3] = 8.32, 1.71, -1.12
    out[4, 4], out[4, 5], out[4, 6] = -1.745, 0.43, 0.43
    out[5, 3], out[5, 4], out[5, 5], out[5, 6] = 0.69, 1.71, -280.0 * y[7] - 0.43, 0.69
    out[5, 7] = -280.0 * y[5]
    out[6, 5], out[6, 6], out[6, 7] = 280.0 * y[7], -1.81, 280.0 * y[5]
    out[7, 5], out[7, 6], out[7, 7] = -280.0 * y[7], 1.81, -280.0 * y[5]


@kernel
def oregonator(problem, t, y, out):
    """Belousov-Zhabotinsky reaction, Field and Noyes (1974)."""
    out[0] = 77.27 * (y[1] + y[0] * (1.0 - 8.375e-6 * y[0] - y[1]))
    out[1] = (y[2] - (1.0 + y[0]) * y[1]) / 77.27
    out[2] = 0.161 * (y[0] - y[2])


@kernel
def oregonator_jacobian(problem, t, y, out):
    out[0, 0], out[0, 1], out[0, 2] = 77.27 * (1.0 - 1.675e-5 * y[0] - y[1]), 77.27 * (1.0 - y[0]), 0.0
    out[1, 0], out[1, 1], out[1, 2] = -y[1] / 77.27, -(1.0 + y[0]) / 77.27, 1.0 / 77.27
    out[2, 0], out[2, 1], out[2, 2] = 0.161, 0.0, -0.161


PROBLEMS = {
    "robertson": Problem(
        robertson,
        robertson_jacobian,
        EMPTY,
        np.array([1.0, 0.0, 0.0]),
        1e11,
        np.array([0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050]),
        np.array([1e-7, 1e-12, 1.0]),
    ),
    "van der pol": Problem(
        van_der_pol,
        van_der_pol_jacobian,
        (np.array([1e3]),),
        np.array([2.0, 0.0]),
        2000.0,
        np.array([0.1706167732170469e1, -0.8928097010248125e-3]),
        np.array([1.0, 1e-3]),
    ),
    "hires": Problem(
        hires,
        hires_jacobian,
        EMPTY,
        np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0057]),
        321.8122,
        np.array(
            [
                0.7371312573325668e-3, 0.1442485726316185e-3, 0.5888729740967575e-4, 0.1175651343283149e-2,
                0.2386356198831331e-2, 0.6238968252742796e-2, 0.2849998395185769e-2, 0.2850001604814231e-2,
            ]
        ),
        np.full(8, 1e-4),
    ),
    "oregonator": Problem(
        oregonator,
        oregonator_jacobian,
        EMPTY,
        np.array([1.0, 2.0, 3.0]),
        360.0,
        np.array([0.1000814870318523e1, 0.1228178521549917e4, 0.1320554942846706e3]),
        np.ones(3),
    ),
}  # fmt: skip


# One right-hand side for all problems, so that each method is compiled once. A problem is (parameters, kind, event):
# `event` (2,) holds the event function and its rate as of the last evaluation.
ROBERTSON, VAN_DER_POL, HIRES, OREGONATOR, SMOOTH, BALL, COSINE, HOLE, POLE, TURNING, WEAKER = range(11)
KINDS = {"robertson": ROBERTSON, "van der pol": VAN_DER_POL, "hires": HIRES, "oregonator": OREGONATOR}


@kernel
def weaker(problem, t):
    rate, when = problem[0]
    return rate if t < when else 0.75 * rate


@kernel
def rhs(problem, t, y, dy):
    parameters, kind, event = problem
    if kind == ROBERTSON:
        robertson(problem, t, y, dy)
    elif kind == VAN_DER_POL:
        van_der_pol(problem, t, y, dy)
    elif kind == HIRES:
        hires(problem, t, y, dy)
    elif kind == OREGONATOR:
        oregonator(problem, t, y, dy)
    elif kind == SMOOTH:  # a pendulum whose clock runs ahead: at t it shows t + t^2/2
        dy[0] = (1.0 + t) * y[1]
        dy[1] = -(1.0 + t) * np.sin(y[0])
    elif kind == BALL:  # gravity, and a spring for y < 0
        dy[0] = y[1]
        dy[1] = -parameters[0] - parameters[1] ** 2 * min(y[0], 0.0)
        event[0], event[1] = y[0], y[1]
    elif kind == COSINE:  # y = cos t
        dy[0] = y[1]
        dy[1] = -y[0]
        event[0], event[1] = y[0] + parameters[0], y[1]
    elif kind == HOLE:  # no value beyond a time
        dy[0] = -y[0] if t < parameters[0] else np.nan
    elif kind == POLE:  # y = 1/(1 - t)
        dy[0] = y[0] ** 2
    elif kind == TURNING:  # pushed along x in a stiff damper across a line that turns: y -> sin t (cos t, sin t)
        across = parameters[0] * (np.cos(t) * y[1] - np.sin(t) * y[0])
        dy[0], dy[1] = 1.0 + np.sin(t) * across, -np.cos(t) * across
    elif kind == WEAKER:  # y = sin t, held by a damper that loses a quarter of its rate once
        dy[0] = np.cos(t) - weaker(problem, t) * (y[0] - np.sin(t))


@kernel
def jacobian(problem, t, y, out):
    parameters, kind, _ = problem
    out[:] = 0.0
    if kind == ROBERTSON:
        robertson_jacobian(problem, t, y, out)
    elif kind == VAN_DER_POL:
        van_der_pol_jacobian(problem, t, y, out)
    elif kind == HIRES:
        hires_jacobian(problem, t, y, out)
    elif kind == OREGONATOR:
        oregonator_jacobian(problem, t, y, out)
    elif kind == SMOOTH:
        out[0, 1], out[1, 0] = 1.0 + t, -(1.0 + t) * np.cos(y[0])
    elif kind == BALL:
        out[0, 1], out[1, 0] = 1.0, -(parameters[1] ** 2) if y[0] < 0.0 else 0.0
    elif kind == COSINE:
        out[0, 1], out[1, 0] = 1.0, -1.0
    elif kind == HOLE:
        out[0, 0] = -1.0 if t < parameters[0] else np.nan
    elif kind == POLE:
        out[0, 0] = 2.0 * y[0]
    elif kind == TURNING:
        out[0, 0], out[0, 1] = -(np.sin(t) ** 2), np.sin(t) * np.cos(t)
        out[1, 0], out[1, 1] = np.sin(t) * np.cos(t), -(np.cos(t) ** 2)
        out *= parameters[0]
    elif kind == WEAKER:
        out[0, 0] = -weaker(problem, t)


@kernel
def residual(problem, t, y, dy, out):
    """Masses are 1 here."""
    rhs(problem, t, y, out)
    out -= dy


@kernel(makes_arrays=True)
def arrive(problem, t, y, dy, out):
    """Fill the event; derivatives stay as the collocation has them, and whatever is left of the equations is small."""
    rhs(problem, t, y, np.empty(len(dy)))
    return 0.0


@kernel
def fill(problem, t, y, mass, out):
    jacobian(problem, t, y, out)


@kernel
def signs(problem, g, dg):
    if len(g):
        g[0], dg[0] = problem[2][0], problem[2][1]


@kernel
def settle(problem, t, y, event):
    return DONE, False


@kernel
def observe(problem, observer, t, y, row):
    pass


@kernel
def never(problem, t):
    return np.inf


@kernel
def unlimited(problem):
    return np.inf


@kernel
def whole(problem, s, t, h, y, divisions):
    return h


IMPLICIT, EXPLICIT = implicit(RADAU_IIA_5, rhs, residual, fill, arrive), explicit(DORMAND_PRINCE_5_4, rhs)
_drive_implicit, _drive_explicit = (
    driver(rhs, attempt, signs, settle, observe, never, unlimited, whole) for attempt in (IMPLICIT, EXPLICIT)
)


@kernel
def drive(implicit, problem, stepper, tolerance, t, y, modes, options):
    s = reference(stepper)
    if implicit:
        return _drive_implicit(problem, None, s, tolerance, t, y, modes, 0, options)
    return _drive_explicit(problem, None, s, tolerance, t, y, modes, 0, options)


def steps_of(attempt):
    """Steps of given sizes, without error control; returns the end, and the estimate of the last step's error."""

    @kernel(makes_arrays=True)
    def steps(problem, s, t, y, sizes, scale, exact):
        state, error = y.copy(), 0.0
        s.scale[:] = scale
        rhs(problem, t, state, s.f0)
        for h in sizes:
            error, _ = attempt(problem, s, t, h, state, exact)
            if not error < np.inf:
                raise RuntimeError("step failed")
            accept(s, h, error)
            state[:] = s.new
            t += h
        return state, error

    return steps


_steps_implicit, _steps_explicit = steps_of(IMPLICIT), steps_of(EXPLICIT)


@kernel
def take_steps(implicit, problem, stepper, t, y, sizes, scale, exact):
    s = reference(stepper)
    if implicit:
        return _steps_implicit(problem, s, t, y, sizes, scale, exact)
    return _steps_explicit(problem, s, t, y, sizes, scale, exact)
