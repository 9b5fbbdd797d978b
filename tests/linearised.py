"""The compiled engine's equations of motion at a state: Jacobian and residual, as in the method."""

from __future__ import annotations

import numpy as np

from linkages.base.kernel import kernel
from linkages.base.kernel.by_reference import reference
from linkages.engines.compiled.run.equations import derivatives, residual
from linkages.engines.compiled.run.jacobian import jacobian


@kernel
def _fill(problem, t, y, mass, out):
    jacobian(reference(problem), t, y, mass, out)


@kernel
def _leave(problem, t, y, dy, out):
    residual(reference(problem), t, y, dy, out)


@kernel
def right_hand_side(problem, t, y, dy):
    """Fill dy with f(t, y)."""
    derivatives(reference(problem), t, y, dy)


def slope(problem, t, y):
    """Jacobian df/dy (ny, ny) of equations (see `Runner.aside`), solved for, and the mass matrix of the last entries."""
    ny = len(y)
    k = ny - len(problem.model.free)
    mass, out = np.zeros((k, k)), np.zeros((ny, ny))
    _fill(problem, t, y, mass, out)
    out[ny - k :] = np.linalg.solve(mass, out[ny - k :])
    return out, mass


def left(problem, t, y, dy):
    """Residual of the rates and the following entries for the derivatives dy (ny,)."""
    dy = dy[len(problem.model.free) :]
    out = np.zeros(len(dy))
    _leave(problem, t, y, dy, out)
    return out
