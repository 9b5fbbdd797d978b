"""The start-up of a run: journals that start in the middle cross their clearances, and films take up their loads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from linkages.base.arrays import Array
from linkages.results import numerics
from linkages.results.impacts import Impact
from linkages.results.trajectory import Trajectory
from linkages.system import System


def start_up(system: System, run: Trajectory, ideal: Trajectory | None, contacts: Sequence[Impact]) -> float | None:
    """Return the time at which the start-up of a run ends [s]; None if no journal starts with free flight.

    The start-up of a joint that touches ends with the first contact that is longer than the initial flight. A film
    without contacts ends the flight when its force first comes within a tenth of the load, the force of the ideal
    joint. If it then exceeds the load by more than a quarter, the start-up ends where it stays within a tenth of the
    load for longer than the flight. If instead another joint has its peak before, as flexible links start with the
    shapes that the load gives them, it ends after three flights. The start-up of the run ends when all these joints
    have started up and every drive has reached its speed; it may last longer than the run.

    Parameters
    ----------
    system : System
    run, ideal : Trajectory
        The run, and the motion of the linkage with ideal joints (None: it has no such motion).
    contacts : sequence of Impact
        All contacts of the run.
    """
    end, times = float(run.time[-1]), list[float]()
    for joint in system.play:
        rows = [row for row in contacts if row.owner == joint]
        flight = min((row.start for row in rows), default=0.0)
        if flight > 0.0:
            times.append(min((row.start for row in rows if row.duration > flight), default=end))
        elif not rows and ideal is not None:
            times += _after_overshoot(run, ideal, joint) or _after_release(system, run, ideal, joint)
    return min(max(*times, system.ramp), end) if times else None


def _excess(run: Trajectory, ideal: Trajectory, joint: str) -> tuple[Array, Array]:
    """Return the steps that both runs have [s], and the part of the load by which a joint's force exceeds it there."""
    times = run.time[run.time <= ideal.time[-1]]
    load = np.interp(times, ideal.time, ideal[f"{joint}.force"])
    return times, (run[f"{joint}.force"][: len(times)] - load) / np.maximum(load, np.finfo(float).tiny)


def _flight(times: Array, excess: Array) -> float:
    """Return the time at which the force of a film first comes near its load [s]; 0 if never."""
    return float(times[np.argmax(excess >= -numerics.START_UP_CARRIED)])


def _after_overshoot(run: Trajectory, ideal: Trajectory, joint: str) -> list[float]:
    """Find the time from which a film carries its load [s]; none if its force never overshoots before."""
    times, excess = _excess(run, ideal, joint)
    flight = _flight(times, excess)
    edges = np.flatnonzero(np.diff(np.abs(excess) <= numerics.START_UP_CARRIED, prepend=False, append=False))
    begins, ends = edges[::2], edges[1::2] - 1
    long = begins[times[ends] - times[begins] > flight]
    if flight == 0.0 or not len(long) or excess[: long[0]].max() <= numerics.START_UP_OVERSHOOT:
        return []
    return [float(times[long[0]])]


def _after_release(system: System, run: Trajectory, ideal: Trajectory, joint: str) -> list[float]:
    """Find the time from which a film is loaded [s]; none if no joint's peak, above its ideal one, lies before.

    What the film lacks of its load falls exponentially: to a tenth in the flight, to a thousandth in three.
    """
    loaded = numerics.START_UP_LOADED * _flight(*_excess(run, ideal, joint))
    early = run.time < loaded
    if not early.any() or early.all():
        return []
    names = [name for one in system.joints.values() if (name := f"{one.name}.force") in run and name in ideal]
    peaks = [(run[name][early].max(), max(run[name][~early].max(), ideal[name].max())) for name in names]
    return [loaded] if any(first > (1.0 + numerics.START_UP_CARRIED) * later for first, later in peaks) else []
