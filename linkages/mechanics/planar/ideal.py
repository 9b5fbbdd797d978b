"""State of the linkage with every joint ideal, at the time and near the state of a run."""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.base.kernel import Indices, Records, kernel
from linkages.mechanics.planar.closure import close, consistent_rates
from linkages.mechanics.planar.kinematics import body_accelerations, body_states


@kernel
def ideal_state(model: Any, dynamics: Any, rows: Records, closing: Indices, ideal: Any) -> bool:
    """Fill the ideal linkage's state at the driven coordinates of the run's state, which is the first guess.

    Its links are rigid: modal coordinates are zero.

    Parameters
    ----------
    model, dynamics
        Of the run; see `linkages.mechanics.planar.arrays` and `linkages.mechanics.planar.workspace`.
    rows : array of ROW
        Closure rows of all cut joints.
    closing : array of int
        Coordinates of joints that no drive prescribes.
    ideal : Workspace
        Its q, v, a, pose, vel and acc are filled.

    Returns
    -------
    bool
        False if the loops do not close there.
    """
    bodies = model.bodies
    for i in range(len(ideal.q)):
        ideal.q[i] = dynamics.q[i]
        ideal.v[i] = dynamics.v[i]
        ideal.a[i] = dynamics.a[i]
    for i in range(len(bodies.records)):
        for k in range(bodies.records[i].modes):
            d = bodies.records[i].eta + k
            ideal.q[d], ideal.v[d], ideal.a[d] = 0.0, 0.0, 0.0
    if not close(bodies, rows, np.zeros(len(rows)), closing, model.size, ideal.q):
        return False
    consistent_rates(bodies, rows, closing, ideal.q, ideal.v, ideal.a)
    body_states(bodies, ideal.q, ideal.v, ideal.pose, ideal.vel)
    body_accelerations(bodies, ideal.pose, ideal.vel, ideal.v, ideal.a, ideal.acc)
    return True
