"""The equations of motion linearised about a state at rest, in coordinates that keep ideal loops closed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.jacobian import jacobian
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.runner import Runner
from linkages.kernel import Array, kernel
from linkages.kernel.by_reference import reference
from linkages.planar.closure import closure_jacobian
from linkages.planar.composite_inertia import mass_matrix


class Linear(NamedTuple):
    """Matrices of M x'' + C x' + K x = 0: ``ways @ x``, with m entries of x, are the changes of the n free coordinates.

    Attributes
    ----------
    mass, damping, stiffness : (m, m) arrays
        SI units of the coordinates: rad, m.
    ways : (n, m) array
        Orthonormal columns.
    masses : (n, n) array
        Mass matrix of the free coordinates.
    acceleration : (m,) array
        Of the state itself; zero in equilibrium.
    """

    mass: Array
    damping: Array
    stiffness: Array
    ways: Array
    masses: Array
    acceleration: Array


@kernel
def _fill(equations: Equations, t: float, y: Array, mass: Array, out: Array, masses: Array) -> None:
    jacobian(reference(equations), t, y, mass, out)
    mass_matrix(equations.model.bodies, reference(equations.work.dynamics), masses)


def linearised(runner: Runner, t: float) -> Linear:
    """Linearise the equations of motion about the start of a runner's system, which stands still.

    Parameters
    ----------
    runner : Runner
        Of a system without contacts; stiff, so that it has a Jacobian.
    t : float
        Time at which loads act [s].
    """
    equations, model, y = runner.aside(), runner.model, runner.start
    n, w = len(model.free), equations.work.dynamics
    mass, out, masses = np.zeros((n, n)), np.zeros((2 * n, 2 * n)), np.zeros((len(w.q), len(w.q)))
    _fill(equations, t, y, mass, out, masses)
    changes = np.linalg.solve(mass, out[n:])  # of accelerations with coordinates, and with rates
    own = masses[np.ix_(model.free, model.free)]
    rows = closure_jacobian(model.bodies, model.rows, w.pose, len(w.q))[:, model.free]
    ways = np.linalg.svd(rows)[2][model.rank :].T if len(rows) else np.eye(n)
    pushed = ways.T @ own
    still: Array = np.linalg.solve(pushed @ ways, pushed @ w.a[model.free]).astype(np.float64)
    return Linear(pushed @ ways, -pushed @ changes[:, n:] @ ways, -pushed @ changes[:, :n] @ ways, ways, own, still)
