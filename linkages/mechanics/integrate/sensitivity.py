"""Derivatives of a step of a Runge-Kutta method, of given size: the step's own equations differentiated.

Both makers return a function with the same parameters, see `collocation_sensitivity`.

The state has the order of `linkages.mechanics.integrate.stepper.make_stepper`: m positions, as many rates, other
entries. Columns are the derivatives of the state with respect to any values. At each stage the derivatives k of rates
and other entries satisfy ``mass @ dk = jacobian @ dy + forcing``, one column for each value, at least `WIDTH` columns.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.base.kernel import Array, kernel
from linkages.base.kernel.simd import WIDTH, lanes_at, put_lanes
from linkages.base.kernel.simd import LaneArray as Lanes
from linkages.mechanics.integrate.factor import back_substitute, factorise
from linkages.mechanics.integrate.tableau import Tableau


def collocation_sensitivity(tableau: Tableau) -> Any:
    """Make the compiled derivative of a collocation step whose last stage is at its end.

    The equations of all stages are differentiated together, by the implicit function theorem: one factorisation for
    all columns. The derivative belongs to the exact solution of the stages' equations.
    """
    a, c, back, count = tableau.a, tableau.c, np.linalg.inv(tableau.a), len(tableau.c)

    @kernel(makes_arrays=True)
    def differentiate(
        h: float, mass: Array, jacobian: Array, forcing: Array, before: Array, after: Array, rates: Array,
        start: Lanes, x: Lanes,
    ) -> bool:  # fmt: skip
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
        rates : (k, nc) array
            Filled with the rates of the columns' last k entries at the end.
        start, x : (n,) and (s n,) lanes
            To work in.
        """
        n, nc, k = before.shape[0], before.shape[1], mass.shape[1]
        m = n - k
        matrix, pivots = np.empty((count * k, count * k)), np.empty(count * k, np.int64)
        for i in range(count):
            for j in range(count):
                shift, gain = back[i, j] / h, h * a[i, j]
                for row in range(k):
                    line = matrix[i * k + row, j * k : (j + 1) * k]
                    for column in range(k):
                        line[column] = shift * mass[i, row, column]
                    if i == j:
                        for column in range(k):
                            line[column] -= jacobian[i, row, m + column]
                    for column in range(m):
                        line[column] -= gain * jacobian[i, row, column]
        if not factorise(matrix, pivots):
            return False
        last = (count - 1) * k
        for end in range(nc, 0, -WIDTH):
            first = max(end - WIDTH, 0)
            for j in range(n):
                start[j] = lanes_at(before, j, first)
            for i in range(count):
                for row in range(k):
                    total = lanes_at(forcing[i], row, first)
                    for j in range(m):
                        total += jacobian[i, row, j] * (start[j] + h * c[i] * start[m + j])
                    for j in range(m, n):
                        total += jacobian[i, row, j] * start[j]
                    x[i * k + row] = total
            back_substitute(matrix, pivots, x[: count * k])
            for j in range(k):
                put_lanes(after, m + j, first, start[m + j] + x[last + j])
                total = back[count - 1, 0] / h * x[j]
                for i in range(1, count):
                    total += back[count - 1, i] / h * x[i * k + j]
                put_lanes(rates, j, first, total)
            for j in range(m):
                total = start[j] + h * start[m + j]
                for i in range(count):
                    total += h * a[count - 1, i] * x[i * k + j]
                put_lanes(after, j, first, total)
        return True

    return differentiate


def explicit_sensitivity(tableau: Tableau) -> Any:
    """Make the compiled derivative of a step of an explicit method; it does not fill ``rates``."""
    a, b, count = tableau.a, tableau.b, len(tableau.c)

    @kernel(makes_arrays=True)
    def differentiate(
        h: float, mass: Array, jacobian: Array, forcing: Array, before: Array, after: Array, rates: Array,
        start: Lanes, x: Lanes,
    ) -> bool:  # fmt: skip
        """Fill ``after`` (n, nc) with the columns at the end of a step; False if a mass matrix is singular.

        Overwrites ``mass`` by its factors. ``x`` (s n,) are the rates of the columns at the stages.
        """
        n, nc, k = before.shape[0], before.shape[1], mass.shape[1]
        m, pivots = n - k, np.empty((count, k), np.int64)
        for i in range(count):
            if not factorise(mass[i], pivots[i]):
                return False
        for end in range(nc, 0, -WIDTH):
            first = max(end - WIDTH, 0)
            for i in range(count):
                for j in range(n):
                    start[j] = lanes_at(before, j, first)
                    for stage in range(i):
                        start[j] += h * a[i, stage] * x[stage * n + j]
                for j in range(m):
                    x[i * n + j] = start[m + j]
                for row in range(k):
                    total = lanes_at(forcing[i], row, first)
                    for j in range(n):
                        total += jacobian[i, row, j] * start[j]
                    x[i * n + m + row] = total
                back_substitute(mass[i], pivots[i], x[i * n + m : (i + 1) * n])
            for j in range(n):
                total = lanes_at(before, j, first)
                for i in range(count):
                    total += h * b[i] * x[i * n + j]
                put_lanes(after, j, first, total)
        return True

    return differentiate
