"""Functions of time and of the state for compiled evaluation: piecewise polynomials and formulas.

A formula is a program: each of its instructions (code, first, second) makes a value, with two derivatives, of numbers,
of inputs, or of the values of earlier instructions. Input 0 is the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.dual import room
from linkages.mechanics.planar.jets import CODES, FIRST_BINARY, Jet, binary, unary

#: Functions: breaks (n, ns + 1), coefficients (n, ns, order) and number of segments (n,) of piecewise polynomials. Of a
#: program that number is less than zero, and its instructions are in the first three columns of the coefficients.
Curves = tuple[Array, Array, Indices]


class Pieces(NamedTuple):
    """A piecewise polynomial: the first and last pieces extend to all times."""

    c: Array  # coefficients of powers of the time since each piece's start, highest power first, (order, n)
    x: Array  # breaks between the pieces [s], (n + 1,)


#: Codes of instructions in addition to `linkages.mechanics.planar.jets.CODES`: a number; an input, by its index; a
#: polynomial, by its index, at a value. Indices of values count the instructions of the program.
NUMBER, INPUT, TABLE = 0, 1, 2


#: Instructions whose slope jumps where a number is zero, and how many such numbers each has: the value, the difference
#: of two values, the distances to both ends of a table.
_SWITCHES = {CODES["abs"]: 1, CODES["min"]: 1, CODES["max"]: 1, TABLE: 2}
_ABS, _ADD, _SUB, _MIN, _MAX = (CODES[name] for name in ("abs", "add", "sub", "min", "max"))
_ROUNDING = 1e-14  # of a difference, in parts of its terms: less counts as zero


class Program(NamedTuple):
    """A formula; see the head of the module."""

    steps: Array  # code, first, second; (m, 3)


def constant_rate(start: float, speed: float) -> Pieces:
    """Start + speed * t, for all t."""
    return Pieces(np.array([[speed], [start]]), np.array([0.0, 1.0]))


def ramped_rate(start: float, speed: float, ramp: float) -> Pieces:
    """From rest to a constant speed in the time `ramp` [s], twice differentiable in the speed.

    The speed is speed * (10 s^3 - 15 s^4 + 6 s^5) with s = t/ramp; then it is constant.
    """
    smooth = speed * np.array([6 / ramp**5 / 6, -15 / ramp**4 / 5, 10 / ramp**3 / 4, 0.0, 0.0, 0.0, 0.0])
    smooth[-1] = start
    end = start + 0.5 * speed * ramp
    after = np.array([0.0, 0.0, 0.0, 0.0, 0.0, speed, end])
    return Pieces(np.stack([smooth, after], axis=1), np.array([0.0, ramp, 2.0 * ramp]))


def table(times: Sequence[float], values: Sequence[float]) -> Pieces:
    """Cubic spline through a table (a straight line through two points)."""
    if len(times) < 4:
        slopes = np.diff(values) / np.diff(times)
        return Pieces(np.stack([slopes, np.asarray(values[:-1], float)]), np.asarray(times, float))
    from scipy.interpolate import CubicSpline  # half a second; most experiments have no tables

    spline = CubicSpline(times, values)
    return Pieces(spline.c, spline.x)


def monotone_table(times: Sequence[float], values: Sequence[float]) -> Pieces:
    """Monotone cubic through a table (Fritsch and Butland, 1984): between two values it never leaves their range."""
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(times, values)
    return Pieces(curve.c, curve.x)


def raised(function: Pieces | Program, by: float) -> Pieces | Program:
    """Add a constant to a function."""
    if isinstance(function, Pieces):
        c = function.c.copy()
        c[-1] += by
        return Pieces(c, function.x)
    count = len(function.steps)
    return Program(np.vstack([function.steps, [NUMBER, by, 0.0], [CODES["add"], count - 1, count]]))


class Motions:
    """Several functions packed into arrays for `evaluate_motions` and `function_jet`."""

    def __init__(self, pieces: Sequence[Pieces | Program]) -> None:
        self.pieces = tuple(pieces)
        n = len(self.pieces)
        longest = max((len(p.x) if isinstance(p, Pieces) else len(p.steps) + 1 for p in self.pieces), default=2)
        order = max((len(p.c) if isinstance(p, Pieces) else 3 for p in self.pieces), default=1)
        self.breaks = np.full((n, longest), np.inf)
        self.coefficients = np.zeros((n, longest - 1, order))
        self.segments = np.zeros(n, dtype=np.int64)
        for i, p in enumerate(self.pieces):
            if isinstance(p, Program):
                self.segments[i] = -len(p.steps)
                self.coefficients[i, : len(p.steps), :3] = p.steps
                continue
            self.breaks[i, : len(p.x)] = p.x
            self.segments[i] = len(p.x) - 1
            self.coefficients[i, : len(p.x) - 1, order - len(p.c) :] = p.c.T

    @cached_property
    def start(self) -> tuple[Array, Array]:
        """Values and rates (n,) at t = 0."""
        value, rate, _ = self(np.zeros(1))
        return value[0], rate[0]

    @property
    def arrays(self) -> Curves:
        """The curves for compiled code."""
        return self.breaks, self.coefficients, self.segments

    def __call__(self, times: Array) -> tuple[Array, Array, Array]:
        """Values, rates and second derivatives (nt, n) at the given times."""
        shape = (len(times), len(self.pieces))
        out = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        _tabulate(self.arrays, np.asarray(times, dtype=np.float64), *out)
        return out


@kernel
def _tabulate(curves: Curves, times: Array, value: Array, rate: Array, acceleration: Array) -> None:
    """Fill value, rate and acceleration (nt, n) over time."""
    for k in range(len(times)):
        evaluate_motions(curves, times[k], value[k], rate[k], acceleration[k])


@inlined_kernel
def last_start(starts: Array, n: int, t: float) -> int:
    """Last of n rising starts that is not after t; the first if all are."""
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if starts[middle] <= t:
            low = middle
        else:
            high = middle
    return low


@inlined_kernel
def _polynomial(curves: Curves, i: int, x: float) -> Jet:
    """Value of piecewise polynomial i and its first two derivatives; the first and last pieces extend to all x."""
    breaks, coefficients, segments = curves
    k = last_start(breaks[i], segments[i], x)
    s = x - breaks[i, k]
    p0, p1, p2 = 0.0, 0.0, 0.0
    for m in range(coefficients.shape[2]):
        p2 = p2 * s + 2.0 * p1
        p1 = p1 * s + p0
        p0 = p0 * s + coefficients[i, k, m]
    return p0, p1, p2


@lazy_kernel
def function_jet(curves: Curves, i: int, inputs: Array) -> Jet:
    """Value of function i and its first two derivatives along a line, with inputs (m, 3) and theirs, the time first.

    A piecewise polynomial is a function of time.
    """
    if curves[2][i] < 0:
        return _program_jet(curves, i, inputs)
    p0, p1, p2 = _polynomial(curves, i, inputs[0, 0])
    return p0, p1 * inputs[0, 1], p1 * inputs[0, 2] + p2 * inputs[0, 1] ** 2


@kernel(makes_arrays=True)
def _program_jet(curves: Curves, i: int, inputs: Array) -> Jet:
    """Run program i; see `function_jet`."""
    made = np.zeros((-curves[2][i], 3), inputs.dtype)
    _run_program(curves, i, inputs, made)
    last = len(made) - 1
    return made[last, 0], made[last, 1], made[last, 2]


@kernel
def _run_program(curves: Curves, i: int, inputs: Array, made: Array) -> None:
    """Fill ``made`` (m, 3) with the results of program i's instructions. A table keeps its values beyond its ends."""
    breaks, coefficients, segments = curves
    steps = coefficients[i]
    for k in range(len(made)):
        code, first, second = int(steps[k, 0]), int(steps[k, 1]), int(steps[k, 2])
        if code == NUMBER:
            made[k, 0] = steps[k, 1]
        elif code == INPUT:
            for m in range(3):
                made[k, m] = inputs[first, m]
        elif code == TABLE:
            x, x1, x2 = made[second, 0], made[second, 1], made[second, 2]
            low, high = breaks[first, 0], breaks[first, segments[first]]
            p0, p1, p2 = _polynomial(curves, first, min(max(x, low), high))
            if x < low or x > high:
                p1, p2 = 0.0, 0.0
            made[k, 0], made[k, 1], made[k, 2] = p0, p1 * x1, p1 * x2 + p2 * x1 * x1
        else:
            x = made[first, 0], made[first, 1], made[first, 2]
            if code < FIRST_BINARY:
                found = unary(code, x)
            else:
                found = binary(code, x, (made[second, 0], made[second, 1], made[second, 2]))
            made[k, 0], made[k, 1], made[k, 2] = found


def switch_counts(coefficients: Array, segments: Indices) -> Indices:
    """Return the number of switches of each of some functions (`Curves`), see `fill_switches`."""
    programs = (coefficients[i, : max(-count, 0), 0] for i, count in enumerate(segments))
    return np.array([sum(_SWITCHES.get(int(code), 0) for code in codes) for codes in programs], np.int64)


@lazy_kernel(makes_arrays=True)
def fill_switches(curves: Curves, inputs: Array, first: int, out: Array) -> int:
    """Fill ``out`` from a place on with the switches of all programs; return the place after them.

    A switch is a number at whose zero the slope of a program jumps; it is zero where it is mere rounding.
    """
    breaks, coefficients, segments = curves
    place = first
    for i in range(len(segments)):
        if segments[i] >= 0:
            continue
        made, steps = np.zeros((-segments[i], 3)), coefficients[i]
        _run_program(curves, i, inputs, made)
        for k in range(len(made)):
            code, a, b = int(steps[k, 0]), int(steps[k, 1]), int(steps[k, 2])
            if code == _ABS:
                terms = int(steps[a, 0])
                out[place] = made[a, 0]
                if terms in (_SUB, _ADD):
                    other = made[int(steps[a, 2]), 0]
                    out[place] = _apart(made[int(steps[a, 1]), 0], other if terms == _SUB else -other)
            elif code in (_MIN, _MAX):
                out[place] = _apart(made[a, 0], made[b, 0])
            elif code == TABLE:
                out[place] = _apart(made[b, 0], breaks[a, 0])
                out[place + 1] = _apart(made[b, 0], breaks[a, segments[a]])
                place += 1
            else:
                continue
            place += 1
    return place


@inlined_kernel
def _apart(a: float, b: float) -> float:
    """Difference of two numbers; zero where it is rounding."""
    return a - b if abs(a - b) > _ROUNDING * (abs(a) + abs(b)) else 0.0


@lazy_kernel(makes_arrays=True)
def _over_time(curves: Curves, i: int, t: float) -> Jet:
    """Value of function i of time alone, its rate and second derivative."""
    inputs = room(t, (1, 3))
    inputs[0, 0], inputs[0, 1] = t, 1.0
    return function_jet(curves, i, inputs)


@inlined_kernel
def motions_at(curves: Curves, t: float, value: Array, rate: Array, acceleration: Array) -> None:
    """Fill value, rate and acceleration (n,) at time t of functions of time alone."""
    for i in range(len(curves[2])):
        if curves[2][i] > 0:
            value[i], rate[i], acceleration[i] = _polynomial(curves, i, t)
        else:
            value[i], rate[i], acceleration[i] = _over_time(curves, i, t)


@kernel
def evaluate_motions(curves: Curves, t: float, value: Array, rate: Array, acceleration: Array) -> None:
    """Fill value, rate and acceleration (n,) at time t of functions of time alone, as `motions_at`."""
    motions_at(curves, t, value, rate, acceleration)
