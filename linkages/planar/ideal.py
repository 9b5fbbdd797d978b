"""State of the linkage with every joint ideal, at the time and near the state of a run."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from linkages.kernel import Array, Records, kernel
from linkages.planar.closure import close, consistent_rates
from linkages.planar.kinematics import body_accelerations, body_positions, body_velocities


class Ideal(NamedTuple):
    """Arrays of the ideal linkage: closure rows of all cut joints, and what `ideal_state` fills."""

    rows: Records
    q: Array
    v: Array
    a: Array
    pose: Array
    vel: Array
    acc: Array


def make_ideal(rows: Records, nb: int, n: int) -> Ideal:
    """Make the arrays for nb bodies and n coordinates."""
    shape = (nb, 3)
    return Ideal(rows, np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((nb, 5)), np.zeros(shape), np.zeros(shape))


@kernel
def ideal_state(model: Any, dynamics: Any, ideal: Any) -> bool:
    """Fill the ideal linkage's state at the driven coordinates of the run's state, which is the first guess.

    Returns False if the loops do not close there.
    """
    bodies, rows = model.bodies, ideal.rows
    for i in range(len(ideal.q)):
        ideal.q[i] = dynamics.q[i]
        ideal.v[i] = dynamics.v[i]
        ideal.a[i] = dynamics.a[i]
    if not close(bodies, rows, np.zeros(len(rows)), model.free, model.size, ideal.q):
        return False
    consistent_rates(bodies, rows, model.free, ideal.q, ideal.v, ideal.a)
    body_positions(bodies, ideal.q, ideal.pose)
    body_velocities(bodies, ideal.pose, ideal.v, ideal.vel)
    body_accelerations(bodies, ideal.pose, ideal.vel, ideal.v, ideal.a, ideal.acc)
    return True
