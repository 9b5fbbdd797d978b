"""Derivatives of a step of a Runge-Kutta method, of given size: the step's own equations differentiated.

The state has the order of `linkages.integrate.stepper.make_stepper`: m positions, as many rates, other entries. Columns
are the derivatives of the state with respect to any values. At each stage the derivatives k of rates and other entries
satisfy ``mass @ dk = jacobian @ dy + forcing``, one column for each value.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.integrate.factor import back_substitute, factorise
from linkages.integrate.tableau import Tableau
from linkages.kernel import Array, kernel


def collocation_sensitivity(tableau: Tableau) -> Any:
    """Make the compiled derivative of a collocation step whose last stage is at its end.

    The equations of all stages are differentiated together, by the implicit function theorem: one factorisation for
    all columns. The derivative is that of the exact solution of the stages' equations.
    """
    a, c, back, count = tableau.a, tableau.c, np.linalg.inv(tableau.a), len(tableau.c)

    @kernel
    def differentiate(h: float, mass: Array, jacobian: Array, forcing: Array, before: Array, after: Array) -> bool:
        """Fill ``after`` (n, nc) with the columns at the end of a step; False if the stages' equations are singular.

        Parameters
        ----------
        h : float
            Size of the step.
        mass : (s, k, k) array
            Of each stage.
        jacobian : (s, k, n) array
        forcing : (s, k, nc) array
        before : (n, nc) array
            Columns at the start.
        """
        n, nc, k = before.shape[0], before.shape[1], mass.shape[1]
        m = n - k
        matrix, pivots, x = np.empty((count * k, count * k)), np.empty(count * k, np.int64), np.empty(count * k)
        for i in range(count):
            for j in range(count):
                for row in range(k):
                    for column in range(k):
                        value = back[i, j] / h * mass[i, row, column]
                        if i == j:
                            value -= jacobian[i, row, m + column]
                        if column < m:
                            value -= h * a[i, j] * jacobian[i, row, column]
                        matrix[i * k + row, j * k + column] = value
        if not factorise(matrix, pivots):
            return False
        for column in range(nc):
            for i in range(count):
                for row in range(k):
                    total = forcing[i, row, column]
                    for j in range(m):
                        total += jacobian[i, row, j] * (before[j, column] + h * c[i] * before[m + j, column])
                    for j in range(m, n):
                        total += jacobian[i, row, j] * before[j, column]
                    x[i * k + row] = total
            back_substitute(matrix, pivots, x)
            last = (count - 1) * k
            for j in range(k):
                after[m + j, column] = before[m + j, column] + x[last + j]
            for j in range(m):
                total = before[j, column] + h * before[m + j, column]
                for i in range(count):
                    total += h * a[count - 1, i] * x[i * k + j]
                after[j, column] = total
        return True

    return differentiate


def explicit_sensitivity(tableau: Tableau) -> Any:
    """Make the compiled derivative of a step of an explicit method."""
    a, b, count = tableau.a, tableau.b, len(tableau.c)

    @kernel
    def differentiate(h: float, mass: Array, jacobian: Array, forcing: Array, before: Array, after: Array) -> bool:
        """Fill ``after`` (n, nc) with the columns at the end of a step; arguments as for a collocation step."""
        n, nc, k = before.shape[0], before.shape[1], mass.shape[1]
        m = n - k
        slopes, trial, x = np.empty((count, n, nc)), np.empty((n, nc)), np.empty(k)
        factors, pivots = np.empty((k, k)), np.empty(k, np.int64)
        for i in range(count):
            for row in range(n):
                for column in range(nc):
                    total = 0.0
                    for j in range(i):
                        total += a[i, j] * slopes[j, row, column]
                    trial[row, column] = before[row, column] + h * total
            for row in range(k):
                for column in range(k):
                    factors[row, column] = mass[i, row, column]
            if not factorise(factors, pivots):
                return False
            for column in range(nc):
                for row in range(k):
                    total = forcing[i, row, column]
                    for j in range(n):
                        total += jacobian[i, row, j] * trial[j, column]
                    x[row] = total
                back_substitute(factors, pivots, x)
                for row in range(m):
                    slopes[i, row, column] = trial[m + row, column]
                for row in range(k):
                    slopes[i, m + row, column] = x[row]
        for row in range(n):
            for column in range(nc):
                total = 0.0
                for i in range(count):
                    total += b[i] * slopes[i, row, column]
                after[row, column] = before[row, column] + h * total
        return True

    return differentiate
