"""Motion of a journal in its bearing; arguments as in `linkages.laws.journal.clearance_force`."""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import inlined_kernel


@inlined_kernel
def polar(ex: float, ey: float, vx: float, vy: float) -> tuple[float, float, float, float, float]:
    """Length and direction of the eccentricity, and the velocity along and across it."""
    e = math.sqrt(ex * ex + ey * ey)
    nx, ny = 1.0, 0.0  # the force does not depend on the direction at the centre
    if e > 0.0:
        nx, ny = ex / e, ey / e
    return e, nx, ny, vx * nx + vy * ny, vy * nx - vx * ny


@inlined_kernel
def sliding_speed(joint: np.record, e: float, v_t: float, omega_b: float, omega_j: float) -> float:
    """Sliding speed of the journal's surface on the bearing's, at an eccentricity e [m/s]."""
    radius = joint.radius - joint.clearance
    return v_t + omega_j * radius - omega_b * (e + radius)
