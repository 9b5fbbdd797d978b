"""State of the linkage with every joint ideal, at the time and near the state of a run."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from linkages.kernel import Array, Indices, Records, kernel
from linkages.planar.bodies import Bodies, make_motion, make_pose
from linkages.planar.closure import close, consistent_rates
from linkages.planar.kinematics import body_accelerations, body_states


class Ideal(NamedTuple):
    """Arrays of the ideal linkage: closure rows of all cut joints, and what `ideal_state` fills."""

    rows: Records
    closing: Indices  # coordinates of joints that no drive prescribes
    q: Array
    v: Array
    a: Array
    pose: Array
    vel: Array
    acc: Array


def make_ideal(rows: Records, closing: Indices, bodies: Bodies, n: int) -> Ideal:
    """Make the arrays for n coordinates."""
    parts = make_pose(bodies), make_motion(bodies), make_motion(bodies)
    return Ideal(rows, closing, np.zeros(n), np.zeros(n), np.zeros(n), *parts)


@kernel
def ideal_state(model: Any, dynamics: Any, ideal: Any) -> bool:
    """Fill the ideal linkage's state at the driven coordinates of the run's state, which is the first guess.

    Its links are rigid: modal coordinates are zero.

    Returns False if the loops do not close there.
    """
    bodies, rows = model.bodies, ideal.rows
    for i in range(len(ideal.q)):
        ideal.q[i] = dynamics.q[i]
        ideal.v[i] = dynamics.v[i]
        ideal.a[i] = dynamics.a[i]
    for i in range(len(bodies.records)):
        for k in range(bodies.records[i].modes):
            d = bodies.records[i].eta + k
            ideal.q[d], ideal.v[d], ideal.a[d] = 0.0, 0.0, 0.0
    if not close(bodies, rows, np.zeros(len(rows)), ideal.closing, model.size, ideal.q):
        return False
    consistent_rates(bodies, rows, ideal.closing, ideal.q, ideal.v, ideal.a)
    body_states(bodies, ideal.q, ideal.v, ideal.pose, ideal.vel)
    body_accelerations(bodies, ideal.pose, ideal.vel, ideal.v, ideal.a, ideal.acc)
    return True
