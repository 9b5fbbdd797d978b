"""Butcher tableaus: the coefficients of the Runge-Kutta methods, as data."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array


class Tableau(NamedTuple):
    """Coefficients of a Runge-Kutta method with s stages.

    An explicit method estimates its error from the derivatives at the stages and at the end of the step, an implicit
    one from the stages' increments, divided by the step size.
    """

    name: str  # in experiments and results
    order: int  # of the solution: a step of size h has an error of h^(order + 1)
    c: Array  # nodes: times of the stages, relative to the step, (s,)
    a: Array  # stage coefficients, lower triangular for an explicit method, (s, s)
    b: Array  # weights of the solution, (s,)
    error: Array  # weights of the error estimate: (s + 1,) of an explicit method, (s,) of an implicit one


def _radau_iia_5() -> Tableau:
    """Compute the coefficients of the collocation at the three Radau points."""
    root = math.sqrt(6.0)
    c = np.array([(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0])
    powers = np.vander(c, 3, increasing=True)  # A maps c^k to c^(k+1)/(k+1)
    integrals = np.stack([c ** (k + 1) / (k + 1) for k in range(3)], axis=1)
    a = integrals @ np.linalg.inv(powers)
    error = np.array([-13.0 - 7.0 * root, -13.0 + 7.0 * root, -1.0]) / 3.0
    return Tableau("radau_iia_5", 5, c, a, a[2], error)


#: Radau IIA method of order 5, stiffly accurate. Error estimate of order 3: E. Hairer, G. Wanner, Solving Ordinary
#: Differential Equations II, 2nd ed., section IV.8.
RADAU_IIA_5 = _radau_iia_5()

#: Explicit pair of orders 5 and 4, whose last derivative is the first of the next step. J. R. Dormand, P. J. Prince, A
#: family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19-26.
DORMAND_PRINCE_5_4 = Tableau(
    "dormand_prince_5_4",
    5,
    np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0]),
    np.array(
        [
            [0, 0, 0, 0, 0, 0],
            [1 / 5, 0, 0, 0, 0, 0],
            [3 / 40, 9 / 40, 0, 0, 0, 0],
            [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
            [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
            [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        ]
    ),
    np.array([35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84]),
    np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40]),
)
