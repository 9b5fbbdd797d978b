"""Test problems with known optima.

W. Hock, K. Schittkowski, Test Examples for Nonlinear Programming Codes, Lecture Notes in Economics and
Mathematical Systems 187, Springer 1981: number, functions, bounds, start and optimum as printed there. Where
the book gives the optimum in closed form, so does this table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, exp, log, pi, sin, sqrt

import numpy as np

from optim.algorithms.nlp import Problem, Values

INF = np.inf


@dataclass(frozen=True)
class Example:
    """One problem: minimise f subject to g(x) >= 0, h(x) = 0 and bounds.

    `kind` lists its constraints, b(ounds), e(qualities), i(nequalities), and special features of the optimum:
    a v(ertex), where the active constraints leave no freedom; d(egenerate), where their gradients depend on each
    other, a multiplier vanishes, or the reduced Hessian is singular.
    """

    number: int
    kind: str
    f: Callable
    start: Sequence[float]
    optimum: float
    g: Callable = lambda x: ()
    h: Callable = lambda x: ()
    lower: Sequence[float] | float = -INF
    upper: Sequence[float] | float = INF

    @property
    def problem(self) -> Problem:
        n = len(self.start)
        start = np.array(self.start, dtype=float)
        ni, ne = len(self.g(start)), len(self.h(start))

        def evaluate(designs):
            m = len(designs)
            with np.errstate(all="ignore"):
                return Values(
                    np.array([[self.f(x)] for x in designs], dtype=float),
                    -np.array([self.g(x) for x in designs], dtype=float).reshape(m, ni),
                    np.array([self.h(x) for x in designs], dtype=float).reshape(m, ne),
                    np.zeros(m, dtype=bool),
                )

        return Problem(
            np.broadcast_to(np.array(self.lower, dtype=float), n).copy(),
            np.broadcast_to(np.array(self.upper, dtype=float), n).copy(),
            evaluate,
            inequalities=tuple(f"g{i + 1}" for i in range(ni)),
            equalities=tuple(f"h{i + 1}" for i in range(ne)),
            start=start,
        )


def rosenbrock(x):
    return 100.0 * (x[1] - x[0] ** 2) ** 2 + (1.0 - x[0]) ** 2


def five(x):
    """Equalities of problems 78, 80 and 81."""
    return (x @ x - 10.0, x[1] * x[2] - 5.0 * x[3] * x[4], x[0] ** 3 + x[1] ** 3 + 1.0)


def colville_3(x):
    """Inequalities of problem 83."""
    x1, x2, x3, x4, x5 = x
    a = 85.334407 + 0.0056858 * x2 * x5 + 0.0006262 * x1 * x4 - 0.0022053 * x3 * x5
    b = 80.51249 + 0.0071317 * x2 * x5 + 0.0029955 * x1 * x2 + 0.0021813 * x3**2
    c = 9.300961 + 0.0047026 * x3 * x5 + 0.0012547 * x1 * x3 + 0.0019085 * x3 * x4
    return (a, 92.0 - a, b - 90.0, 110.0 - b, c - 20.0, 25.0 - c)


def heat_exchanger_power(x):
    """The two products of problem 93."""
    return x[0] * x[3] * (x[0] + x[1] + x[2]), x[1] * x[2] * (x[0] + 1.57 * x[1] + x[3])


def reactor(x):
    """Objective of problem 104."""
    return 0.4 * (x[0] / x[6]) ** 0.67 + 0.4 * (x[1] / x[7]) ** 0.67 + 10.0 - x[0] - x[1]


def reactor_balance(x):
    """Inequalities of problem 104."""
    return (
        1 - 0.0588 * x[4] * x[6] - 0.1 * x[0],
        1 - 0.0588 * x[5] * x[7] - 0.1 * x[0] - 0.1 * x[1],
        1 - 4 * x[2] / x[4] - 2 * x[2] ** -0.71 / x[4] - 0.0588 * x[2] ** -1.3 * x[6],
        1 - 4 * x[3] / x[5] - 2 * x[3] ** -0.71 / x[5] - 0.0588 * x[3] ** -1.3 * x[7],
        reactor(x) - 1.0,
        4.2 - reactor(x),
    )


EXAMPLES = (
    Example(1, "b", rosenbrock, (-2, 1), 0.0, lower=(-INF, -1.5)),
    Example(3, "b", lambda x: x[1] + 1e-5 * (x[1] - x[0]) ** 2, (10, 1), 0.0, lower=(-INF, 0)),
    Example(4, "bv", lambda x: (x[0] + 1) ** 3 / 3 + x[1], (1.125, 0.125), 8 / 3, lower=(1, 0)),
    Example(
        5, "b", lambda x: sin(x[0] + x[1]) + (x[0] - x[1]) ** 2 - 1.5 * x[0] + 2.5 * x[1] + 1, (0, 0),
        -sqrt(3) / 2 - pi / 3, lower=(-1.5, -3), upper=(4, 3),
    ),
    Example(6, "e", lambda x: (1 - x[0]) ** 2, (-1.2, 1), 0.0, h=lambda x: (10 * (x[1] - x[0] ** 2),)),
    Example(
        7, "e", lambda x: log(1 + x[0] ** 2) - x[1], (2, 2), -sqrt(3),
        h=lambda x: ((1 + x[0] ** 2) ** 2 + x[1] ** 2 - 4,),
    ),
    Example(8, "ev", lambda x: -1.0, (2, 1), -1.0, h=lambda x: (x @ x - 25, x[0] * x[1] - 9)),
    Example(
        9, "e", lambda x: sin(pi * x[0] / 12) * cos(pi * x[1] / 16), (0, 0), -0.5,
        h=lambda x: (4 * x[0] - 3 * x[1],),
    ),
    Example(
        10, "i", lambda x: x[0] - x[1], (-10, 10), -1.0,
        lambda x: (-3 * x[0] ** 2 + 2 * x[0] * x[1] - x[1] ** 2 + 1,),
    ),
    Example(
        11, "i", lambda x: (x[0] - 5) ** 2 + x[1] ** 2 - 25, (4.9, 0.1), -8.498464223,
        lambda x: (-x[0] ** 2 + x[1],),
    ),
    Example(
        12, "i", lambda x: 0.5 * x[0] ** 2 + x[1] ** 2 - x[0] * x[1] - 7 * x[0] - 7 * x[1], (0, 0), -30.0,
        lambda x: (25 - 4 * x[0] ** 2 - x[1] ** 2,),
    ),
    Example(
        14, "iev", lambda x: (x[0] - 2) ** 2 + (x[1] - 1) ** 2, (2, 2), 9 - 2.875 * sqrt(7),
        lambda x: (-0.25 * x[0] ** 2 - x[1] ** 2 + 1,), lambda x: (x[0] - 2 * x[1] + 1,),
    ),
    Example(
        15, "biv", rosenbrock, (-2, 1), 306.5, lambda x: (x[0] * x[1] - 1, x[0] + x[1] ** 2), upper=(0.5, INF)
    ),
    Example(
        17, "bivd", rosenbrock, (-2, 1), 1.0, lambda x: (x[1] ** 2 - x[0], x[0] ** 2 - x[1]),
        lower=(-0.5, -INF), upper=(0.5, 1),
    ),
    Example(
        18, "bi", lambda x: 0.01 * x[0] ** 2 + x[1] ** 2, (2, 2), 5.0,
        lambda x: (x[0] * x[1] - 25, x[0] ** 2 + x[1] ** 2 - 25), lower=(2, 0), upper=50,
    ),
    Example(
        19, "biv", lambda x: (x[0] - 10) ** 3 + (x[1] - 20) ** 3, (20.1, 5.84), -6961.81381,
        lambda x: ((x[0] - 5) ** 2 + (x[1] - 5) ** 2 - 100, -((x[1] - 5) ** 2) - (x[0] - 6) ** 2 + 82.81),
        lower=(13, 0), upper=100,
    ),
    Example(
        21, "bi", lambda x: 0.01 * x[0] ** 2 + x[1] ** 2 - 100, (-1, -1), -99.96,
        lambda x: (10 * x[0] - x[1] - 10,), lower=(2, -50), upper=50,
    ),
    Example(
        22, "iv", lambda x: (x[0] - 2) ** 2 + (x[1] - 1) ** 2, (2, 2), 1.0,
        lambda x: (-x[0] - x[1] + 2, -x[0] ** 2 + x[1]),
    ),
    Example(
        23, "biv", lambda x: x @ x, (3, 1), 2.0,
        lambda x: (
            x[0] + x[1] - 1, x @ x - 1, 9 * x[0] ** 2 + x[1] ** 2 - 9, x[0] ** 2 - x[1], x[1] ** 2 - x[0]
        ),
        lower=-50, upper=50,
    ),
    Example(
        24, "biv", lambda x: ((x[0] - 3) ** 2 - 9) * x[1] ** 3 / (27 * sqrt(3)), (1, 0.5), -1.0,
        lambda x: (x[0] / sqrt(3) - x[1], x[0] + sqrt(3) * x[1], 6 - x[0] - sqrt(3) * x[1]), lower=0,
    ),
    Example(
        26, "ed", lambda x: (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 4, (-2.6, 2, 2), 0.0,
        h=lambda x: ((1 + x[1] ** 2) * x[0] + x[2] ** 4 - 3,),
    ),
    Example(
        27, "e", lambda x: 0.01 * (x[0] - 1) ** 2 + (x[1] - x[0] ** 2) ** 2, (2, 2, 2), 0.04,
        h=lambda x: (x[0] + x[2] ** 2 + 1,),
    ),
    Example(
        28, "e", lambda x: (x[0] + x[1]) ** 2 + (x[1] + x[2]) ** 2, (-4, 1, 1), 0.0,
        h=lambda x: (x[0] + 2 * x[1] + 3 * x[2] - 1,),
    ),
    Example(
        29, "i", lambda x: -x[0] * x[1] * x[2], (1, 1, 1), -16 * sqrt(2),
        lambda x: (-x[0] ** 2 - 2 * x[1] ** 2 - 4 * x[2] ** 2 + 48,),
    ),
    Example(
        30, "bid", lambda x: x @ x, (1, 1, 1), 1.0, lambda x: (x[0] ** 2 + x[1] ** 2 - 1,),
        lower=(1, -10, -10), upper=10,
    ),
    Example(
        31, "bi", lambda x: 9 * x[0] ** 2 + x[1] ** 2 + 9 * x[2] ** 2, (1, 1, 1), 6.0,
        lambda x: (x[0] * x[1] - 1,), lower=(-10, 1, -10), upper=(10, 10, 1),
    ),
    Example(
        32, "biev", lambda x: (x[0] + 3 * x[1] + x[2]) ** 2 + 4 * (x[0] - x[1]) ** 2, (0.1, 0.7, 0.2), 1.0,
        lambda x: (6 * x[1] + 4 * x[2] - x[0] ** 3 - 3,), lambda x: (1 - x[0] - x[1] - x[2],), lower=0,
    ),
    Example(
        34, "biv", lambda x: -x[0], (0, 1.05, 2.9), -log(log(10)),
        lambda x: (x[1] - exp(min(x[0], 300)), x[2] - exp(min(x[1], 300))), lower=0, upper=(100, 100, 10),
    ),
    Example(
        35, "bi",
        lambda x: 9 - 8 * x[0] - 6 * x[1] - 4 * x[2] + 2 * x[0] ** 2 + 2 * x[1] ** 2 + x[2] ** 2
        + 2 * x[0] * x[1] + 2 * x[0] * x[2],
        (0.5, 0.5, 0.5), 1 / 9, lambda x: (3 - x[0] - x[1] - 2 * x[2],), lower=0,
    ),
    Example(
        36, "biv", lambda x: -x[0] * x[1] * x[2], (10, 10, 10), -3300.0,
        lambda x: (72 - x[0] - 2 * x[1] - 2 * x[2],), lower=0, upper=(20, 11, 42),
    ),
    Example(
        37, "bi", lambda x: -x[0] * x[1] * x[2], (10, 10, 10), -3456.0,
        lambda x: (72 - x[0] - 2 * x[1] - 2 * x[2], x[0] + 2 * x[1] + 2 * x[2]), lower=0, upper=42,
    ),
    Example(
        38, "b",
        lambda x: rosenbrock(x) + 90 * (x[3] - x[2] ** 2) ** 2 + (1 - x[2]) ** 2
        + 10.1 * ((x[1] - 1) ** 2 + (x[3] - 1) ** 2) + 19.8 * (x[1] - 1) * (x[3] - 1),
        (-3, -1, -3, -1), 0.0, lower=-10, upper=10,
    ),
    Example(
        39, "e", lambda x: -x[0], (2, 2, 2, 2), -1.0,
        h=lambda x: (x[1] - x[0] ** 3 - x[2] ** 2, x[0] ** 2 - x[1] - x[3] ** 2),
    ),
    Example(
        40, "e", lambda x: -np.prod(x), (0.8, 0.8, 0.8, 0.8), -0.25,
        h=lambda x: (x[0] ** 3 + x[1] ** 2 - 1, x[0] ** 2 * x[3] - x[2], x[3] ** 2 - x[1]),
    ),
    Example(
        41, "be", lambda x: 2 - x[0] * x[1] * x[2], (2, 2, 2, 2), 52 / 27,
        h=lambda x: (x[0] + 2 * x[1] + 2 * x[2] - x[3],), lower=0, upper=(1, 1, 1, 2),
    ),
    Example(
        42, "e", lambda x: (x[0] - 1) ** 2 + (x[1] - 2) ** 2 + (x[2] - 3) ** 2 + (x[3] - 4) ** 2, (1, 1, 1, 1),
        28 - 10 * sqrt(2), h=lambda x: (x[0] - 2, x[2] ** 2 + x[3] ** 2 - 2),
    ),
    Example(
        43, "i",
        lambda x: x[0] ** 2 + x[1] ** 2 + 2 * x[2] ** 2 + x[3] ** 2 - 5 * x[0] - 5 * x[1] - 21 * x[2] + 7 * x[3],
        (0, 0, 0, 0), -44.0,
        lambda x: (
            8 - x @ x - x[0] + x[1] - x[2] + x[3],
            10 - x[0] ** 2 - 2 * x[1] ** 2 - x[2] ** 2 - 2 * x[3] ** 2 + x[0] + x[3],
            5 - 2 * x[0] ** 2 - x[1] ** 2 - x[2] ** 2 - 2 * x[0] + x[1] + x[3],
        ),
    ),
    Example(
        46, "ed", lambda x: (x[0] - x[1]) ** 2 + (x[2] - 1) ** 2 + (x[3] - 1) ** 4 + (x[4] - 1) ** 6,
        (sqrt(2) / 2, 1.75, 0.5, 2, 2), 0.0,
        h=lambda x: (x[0] ** 2 * x[3] + sin(x[3] - x[4]) - 1, x[1] + x[2] ** 4 * x[3] ** 2 - 2),
    ),
    Example(
        48, "e", lambda x: (x[0] - 1) ** 2 + (x[1] - x[2]) ** 2 + (x[3] - x[4]) ** 2, (3, 5, -3, 2, -2), 0.0,
        h=lambda x: (sum(x) - 5, x[2] - 2 * (x[3] + x[4]) + 3),
    ),
    Example(
        49, "ed", lambda x: (x[0] - x[1]) ** 2 + (x[2] - 1) ** 2 + (x[3] - 1) ** 4 + (x[4] - 1) ** 6,
        (10, 7, 2, -3, 0.8), 0.0, h=lambda x: (x[0] + x[1] + x[2] + 4 * x[3] - 7, x[2] + 5 * x[4] - 6),
    ),
    Example(
        50, "e",
        lambda x: (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 2 + (x[2] - x[3]) ** 4 + (x[3] - x[4]) ** 2,
        (35, -31, 11, 5, -5), 0.0,
        h=lambda x: (
            x[0] + 2 * x[1] + 3 * x[2] - 6, x[1] + 2 * x[2] + 3 * x[3] - 6, x[2] + 2 * x[3] + 3 * x[4] - 6
        ),
    ),
    Example(
        51, "e", lambda x: (x[0] - x[1]) ** 2 + (x[1] + x[2] - 2) ** 2 + (x[3] - 1) ** 2 + (x[4] - 1) ** 2,
        (2.5, 0.5, 2, -1, 0.5), 0.0,
        h=lambda x: (x[0] + 3 * x[1] - 4, x[2] + x[3] - 2 * x[4], x[1] - x[4]),
    ),
    Example(
        52, "e", lambda x: (4 * x[0] - x[1]) ** 2 + (x[1] + x[2] - 2) ** 2 + (x[3] - 1) ** 2 + (x[4] - 1) ** 2,
        (2, 2, 2, 2, 2), 1859 / 349, h=lambda x: (x[0] + 3 * x[1], x[2] + x[3] - 2 * x[4], x[1] - x[4]),
    ),
    Example(
        53, "be", lambda x: (x[0] - x[1]) ** 2 + (x[1] + x[2] - 2) ** 2 + (x[3] - 1) ** 2 + (x[4] - 1) ** 2,
        (2, 2, 2, 2, 2), 176 / 43, h=lambda x: (x[0] + 3 * x[1], x[2] + x[3] - 2 * x[4], x[1] - x[4]),
        lower=-10, upper=10,
    ),
    Example(
        60, "be", lambda x: (x[0] - 1) ** 2 + (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 4, (2, 2, 2), 0.03256820025,
        h=lambda x: (x[0] * (1 + x[1] ** 2) + x[2] ** 4 - 4 - 3 * sqrt(2),), lower=-10, upper=10,
    ),
    Example(
        63, "be", lambda x: 1000 - x[0] ** 2 - 2 * x[1] ** 2 - x[2] ** 2 - x[0] * x[1] - x[0] * x[2], (2, 2, 2),
        961.7151721, h=lambda x: (8 * x[0] + 14 * x[1] + 7 * x[2] - 56, x @ x - 25), lower=0,
    ),
    Example(
        64, "bi",
        lambda x: 5 * x[0] + 50000 / x[0] + 20 * x[1] + 72000 / x[1] + 10 * x[2] + 144000 / x[2], (1, 1, 1),
        6299.842428, lambda x: (1 - 4 / x[0] - 32 / x[1] - 120 / x[2],), lower=1e-5,
    ),
    Example(
        65, "bi", lambda x: (x[0] - x[1]) ** 2 + (x[0] + x[1] - 10) ** 2 / 9 + (x[2] - 5) ** 2, (-5, 5, 0),
        0.9535288567, lambda x: (48 - x @ x,), lower=(-4.5, -4.5, -5), upper=(4.5, 4.5, 5),
    ),
    Example(
        66, "bi", lambda x: 0.2 * x[2] - 0.8 * x[0], (0, 1.05, 2.9), 0.5181632741,
        lambda x: (x[1] - exp(min(x[0], 300)), x[2] - exp(min(x[1], 300))), lower=0, upper=(100, 100, 10),
    ),
    Example(
        71, "bie", lambda x: x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2], (1, 5, 5, 1), 17.0140173,
        lambda x: (np.prod(x) - 25,), lambda x: (x @ x - 40,), lower=1, upper=5,
    ),
    Example(
        73, "biev", lambda x: 24.55 * x[0] + 26.75 * x[1] + 39 * x[2] + 40.5 * x[3], (1, 1, 1, 1), 29.894378,
        lambda x: (
            2.3 * x[0] + 5.6 * x[1] + 11.1 * x[2] + 1.3 * x[3] - 5,
            12 * x[0] + 11.9 * x[1] + 41.8 * x[2] + 52.1 * x[3] - 21
            - 1.645 * sqrt(0.28 * x[0] ** 2 + 0.19 * x[1] ** 2 + 20.5 * x[2] ** 2 + 0.62 * x[3] ** 2),
        ),
        lambda x: (sum(x) - 1,), lower=0,
    ),
    Example(
        74, "bie", lambda x: 3 * x[0] + 1e-6 * x[0] ** 3 + 2 * x[1] + 2e-6 / 3 * x[1] ** 3, (0, 0, 0, 0),
        5126.4981, lambda x: (x[3] - x[2] + 0.55, x[2] - x[3] + 0.55),
        lambda x: (
            1000 * sin(-x[2] - 0.25) + 1000 * sin(-x[3] - 0.25) + 894.8 - x[0],
            1000 * sin(x[2] - 0.25) + 1000 * sin(x[2] - x[3] - 0.25) + 894.8 - x[1],
            1000 * sin(x[3] - 0.25) + 1000 * sin(x[3] - x[2] - 0.25) + 1294.8,
        ),
        lower=(0, 0, -0.55, -0.55), upper=(1200, 1200, 0.55, 0.55),
    ),
    Example(
        76, "bi",
        lambda x: x[0] ** 2 + 0.5 * x[1] ** 2 + x[2] ** 2 + 0.5 * x[3] ** 2 - x[0] * x[2] + x[2] * x[3]
        - x[0] - 3 * x[1] + x[2] - x[3],
        (0.5, 0.5, 0.5, 0.5), -4.681818181,
        lambda x: (
            5 - x[0] - 2 * x[1] - x[2] - x[3], 4 - 3 * x[0] - x[1] - 2 * x[2] + x[3], x[1] + 4 * x[2] - 1.5
        ),
        lower=0,
    ),
    Example(
        77, "e",
        lambda x: (x[0] - 1) ** 2 + (x[0] - x[1]) ** 2 + (x[2] - 1) ** 2 + (x[3] - 1) ** 4 + (x[4] - 1) ** 6,
        (2, 2, 2, 2, 2), 0.24150513,
        h=lambda x: (
            x[0] ** 2 * x[3] + sin(x[3] - x[4]) - 2 * sqrt(2), x[1] + x[2] ** 4 * x[3] ** 2 - 8 - sqrt(2)
        ),
    ),
    Example(78, "e", lambda x: np.prod(x), (-2, 1.5, 2, -1, -1), -2.91970041, h=five),
    Example(
        79, "e",
        lambda x: (x[0] - 1) ** 2 + (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 2 + (x[2] - x[3]) ** 4
        + (x[3] - x[4]) ** 4,
        (2, 2, 2, 2, 2), 0.0787768209,
        h=lambda x: (
            x[0] + x[1] ** 2 + x[2] ** 3 - 2 - 3 * sqrt(2), x[1] - x[2] ** 2 + x[3] + 2 - 2 * sqrt(2),
            x[0] * x[4] - 2,
        ),
    ),
    Example(
        80, "be", lambda x: exp(np.prod(x)), (-2, 2, 2, -1, -1), 0.0539498478, h=five,
        lower=(-2.3, -2.3, -3.2, -3.2, -3.2), upper=(2.3, 2.3, 3.2, 3.2, 3.2),
    ),
    Example(
        81, "be", lambda x: exp(np.prod(x)) - 0.5 * (x[0] ** 3 + x[1] ** 3 + 1) ** 2, (-2, 2, 2, -1, -1),
        0.0539498478, h=five, lower=(-2.3, -2.3, -3.2, -3.2, -3.2), upper=(2.3, 2.3, 3.2, 3.2, 3.2),
    ),
    Example(
        83, "biv", lambda x: 5.3578547 * x[2] ** 2 + 0.8356891 * x[0] * x[4] + 37.293239 * x[0] - 40792.141,
        (78, 33, 27, 27, 27), -30665.53867, colville_3, lower=(78, 33, 27, 27, 27), upper=(102, 45, 45, 45, 45),
    ),
    Example(
        93, "bi",
        lambda x: (0.0204 + 0.0607 * x[4] ** 2) * heat_exchanger_power(x)[0]
        + (0.0187 + 0.0437 * x[5] ** 2) * heat_exchanger_power(x)[1],
        (5.54, 4.4, 12.02, 11.82, 0.702, 0.852), 135.075961,
        lambda x: (
            0.001 * np.prod(x) - 2.07,
            1 - 0.00062 * x[4] ** 2 * heat_exchanger_power(x)[0] - 0.00058 * x[5] ** 2 * heat_exchanger_power(x)[1],
        ),
        lower=0,
    ),
    Example(
        100, "i",
        lambda x: (x[0] - 10) ** 2 + 5 * (x[1] - 12) ** 2 + x[2] ** 4 + 3 * (x[3] - 11) ** 2 + 10 * x[4] ** 6
        + 7 * x[5] ** 2 + x[6] ** 4 - 4 * x[5] * x[6] - 10 * x[5] - 8 * x[6],
        (1, 2, 0, 4, 0, 1, 1), 680.6300573,
        lambda x: (
            127 - 2 * x[0] ** 2 - 3 * x[1] ** 4 - x[2] - 4 * x[3] ** 2 - 5 * x[4],
            282 - 7 * x[0] - 3 * x[1] - 10 * x[2] ** 2 - x[3] + x[4],
            196 - 23 * x[0] - x[1] ** 2 - 6 * x[5] ** 2 + 8 * x[6],
            -4 * x[0] ** 2 - x[1] ** 2 + 3 * x[0] * x[1] - 2 * x[2] ** 2 - 5 * x[5] + 11 * x[6],
        ),
    ),
    Example(
        104, "bi", reactor, (6, 3, 0.4, 0.2, 6, 6, 1, 0.5), 3.9511634396, reactor_balance, lower=0.1, upper=10
    ),
    Example(
        110, "b",
        lambda x: sum(log(xi - 2) ** 2 + log(10 - xi) ** 2 for xi in x) - np.prod(x) ** 0.2, (9,) * 10,
        -45.77846971, lower=2.001, upper=9.999,
    ),
    Example(
        113, "i",
        lambda x: x[0] ** 2 + x[1] ** 2 + x[0] * x[1] - 14 * x[0] - 16 * x[1] + (x[2] - 10) ** 2
        + 4 * (x[3] - 5) ** 2 + (x[4] - 3) ** 2 + 2 * (x[5] - 1) ** 2 + 5 * x[6] ** 2 + 7 * (x[7] - 11) ** 2
        + 2 * (x[8] - 10) ** 2 + (x[9] - 7) ** 2 + 45,
        (2, 3, 5, 5, 1, 2, 7, 3, 6, 10), 24.3062091,
        lambda x: (
            105 - 4 * x[0] - 5 * x[1] + 3 * x[6] - 9 * x[7],
            -10 * x[0] + 8 * x[1] + 17 * x[6] - 2 * x[7],
            8 * x[0] - 2 * x[1] - 5 * x[8] + 2 * x[9] + 12,
            -3 * (x[0] - 2) ** 2 - 4 * (x[1] - 3) ** 2 - 2 * x[2] ** 2 + 7 * x[3] + 120,
            -5 * x[0] ** 2 - 8 * x[1] - (x[2] - 6) ** 2 + 2 * x[3] + 40,
            -0.5 * (x[0] - 8) ** 2 - 2 * (x[1] - 4) ** 2 - 3 * x[4] ** 2 + x[5] + 30,
            -(x[0] ** 2) - 2 * (x[1] - 2) ** 2 + 2 * x[0] * x[1] - 14 * x[4] + 6 * x[5],
            3 * x[0] - 6 * x[1] - 12 * (x[8] - 8) ** 2 + 7 * x[9],
        ),
    ),
)  # fmt: skip

#: The printed start leads a local method to another local optimum (20), or to a saddle of the violation (61).
SEVERAL_OPTIMA = (
    Example(
        20, "bi", rosenbrock, (-2, 1), 81.5 - 25 * sqrt(3),
        lambda x: (x[0] + x[1] ** 2, x[0] ** 2 + x[1], x[0] ** 2 + x[1] ** 2 - 1),
        lower=(-0.5, -INF), upper=(0.5, INF),
    ),
    Example(
        61, "e", lambda x: 4 * x[0] ** 2 + 2 * x[1] ** 2 + 2 * x[2] ** 2 - 33 * x[0] + 16 * x[1] - 24 * x[2],
        (0, 0, 0), -143.6461422, h=lambda x: (3 * x[0] - 2 * x[1] ** 2 - 7, 4 * x[0] - x[2] ** 2 - 11),
    ),
)  # fmt: skip

#: No multipliers exist at the optimum: the gradients of the two active constraints point against each other.
NO_MULTIPLIERS = Example(
    13, "bd", lambda x: (x[0] - 2) ** 2 + x[1] ** 2, (-2, -2), 1.0, lambda x: ((1 - x[0]) ** 3 - x[1],), lower=0
)  # fmt: skip
