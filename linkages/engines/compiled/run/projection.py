"""Projection of a run's state onto the closure of ideal loops."""

from __future__ import annotations

from linkages.base.kernel import Array, lazy_kernel
from linkages.engines.compiled.run.model import Equations
from linkages.mechanics.planar.loop_dynamics import project

_CLOSED = 1e-14  # closure error that is left, in parts of the linkage's length


@lazy_kernel
def project_state(equations: Equations, y: Array) -> bool:
    """Move coordinates and rates, in y and in the work, to where the loops are closed; False if they were already.

    The equations are solved at y. Where the accelerations are interpolated near a singularity the state stays as it is:
    the loops determine it there only to digits that it does not have.
    """
    model, w, n = equations.model, equations.work.dynamics, len(equations.model.free)
    if w.interpolated[0] > 0.0 or not project(model.stiff, model.rows, model.rank, _CLOSED, model.size, w):
        return False
    for i in range(n):
        y[i] = w.q[model.free[i]]
        y[n + i] = w.v[model.free[i]]
    return True
