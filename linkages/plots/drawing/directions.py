"""Which way drives go and loads act: signs and directions of a drawing's arrows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from linkages.arrays import Array
from linkages.errors import AssemblyError
from linkages.planar.bodies import make_motion, make_pose
from linkages.planar.kinematics import spread
from linkages.planar.loads import LOAD_OUTPUTS, load_outputs
from linkages.system import System
from linkages.system.ideal_motion import IdealMotion

_TIMES = 501  # at which drives and loads are looked at


def senses(system: System) -> dict[str, float]:
    """Find which way each drive goes first, or pushes: 1 as its coordinate, or -1; drives that do nothing are left out.

    Parameters
    ----------
    system : System
    """
    times = np.linspace(0.0, system.experiment.duration, _TIMES)
    moved = system.motions(times)[0]
    found = dict(zip(system.tree.driven, (moved - moved[:1]).T, strict=True))
    found |= dict(zip(system.tree.powered, system.torques(times)[0].T, strict=True))
    return {name: _first(values) for name, values in found.items() if np.any(values)}


def _first(values: Array) -> float:
    """Sign of the first of some values that is not a rounding error of the others."""
    return float(np.sign(values[np.abs(values) > 1e-9 * np.abs(values).max()][0]))


def strongest(system: System) -> Mapping[str, Array]:
    """Find forces (2,) [N], plane axes, and torques (1,) [N m] where they are largest in the ideal linkage's motion.

    Where its drives do not determine the motion those of the start are taken; what is zero is left out.

    Parameters
    ----------
    system : System
    """
    ideal = system.ideal()
    if not (ideal.experiment.forces or ideal.experiment.torques):
        return {}
    try:
        times, q, v = _states(ideal)
    except AssemblyError:  # it is drawn as it is, its gaps in red
        return {}
    bodies = ideal.tree.bodies
    pose, vel, acc = (np.empty((len(q), *one(bodies).shape)) for one in (make_pose, make_motion, make_motion))
    spread(bodies, q, v, np.zeros_like(q), pose, vel, acc)
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
