"""Senses of drives and directions of loads, for the arrows of a drawing."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from linkages.arrays import Array
from linkages.errors import AssemblyError
from linkages.planar.kinematics import state_tables
from linkages.planar.loads import LOAD_OUTPUTS, load_outputs
from linkages.system import System
from linkages.system.ideal_motion import IdealMotion

_TIMES = 501  # number of sampled times of drives and loads


def senses(system: System) -> dict[str, float]:
    """Find the sense of each drive's first motion or torque: 1 along its coordinate, or -1; idle drives omitted."""
    times = np.linspace(0.0, system.experiment.duration, _TIMES)
    moved = system.motions(times)[0]
    found = dict(zip(system.tree.driven, (moved - moved[:1]).T, strict=True))
    found |= dict(zip(system.tree.powered, system.torques(times)[0].T, strict=True))
    return {name: _first(values) for name, values in found.items() if np.any(values)}


def _first(values: Array) -> float:
    """Return the sign of the first value that is not a rounding error of the others."""
    return float(np.sign(values[np.abs(values) > 1e-9 * np.abs(values).max()][0]))


def strongest(system: System) -> Mapping[str, Array]:
    """Find the largest forces (2,) [N], plane axes, and torques (1,) [N m] in the ideal linkage's motion.

    If the drives do not determine the motion, the values at the start are used; zero loads are omitted.
    """
    ideal = system.ideal()
    if not (ideal.experiment.forces or ideal.experiment.torques):
        return {}
    try:
        times, q, v = _states(ideal)
    except AssemblyError:  # drawn in the file's pose, with gaps in red
        return {}
    pose, vel = state_tables(ideal.tree.bodies, q, v)
    values = np.empty((len(q), len(ideal.experiment.loads), len(LOAD_OUTPUTS)))
    for k, time in enumerate(times):
        load_outputs(ideal.loads, time, pose[k], vel[k], values[k])
    found = {}
    for k, (table, name) in enumerate(ideal.experiment.loads):
        parts = values[:, k, : {"forces": 2, "torques": 1}.get(table, 0)]
        largest = parts[np.linalg.norm(parts, axis=1).argmax()]
        if np.any(largest):
            found[name] = largest
    return found


def _states(ideal: System) -> tuple[Array, Array, Array]:
    """Return times (nt,), coordinates and rates (nt, n) of a linkage with ideal joints."""
    if not ideal.determinate:
        start = ideal.assembly
        return np.zeros(1), start.q[None], start.v[None]
    motion = IdealMotion(ideal)
    times = np.linspace(0.0, motion.times[-1], _TIMES)
    q, v, _ = motion.states(times)
    return times, q, v
