"""Start-up of clearance joints: centred journals cross the clearance, and an impact or the film stops them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from linkages.results.impacts import Impact
from linkages.results.trajectory import Trajectory
from linkages.system import System

# difference of a film's force from the force of the ideal joint, in parts of the latter
_CARRIED = 0.1  # within it the film carries the load
_OVERSHOOT = 0.25  # a larger excess before makes a start-up


def startup_end(system: System, contacts: Sequence[Impact], run: Trajectory, ideal: Trajectory) -> float | None:
    """Find the time at which the start-up of a run ends [s]; None if no journal starts with free flight.

    The start-up of a joint that touches ends with the first contact that is longer than the initial flight. A film
    without contacts ends the flight when its force first comes within a tenth of the load, the force of the ideal
    joint. If it then exceeds the load by more than a quarter, the start-up ends where it stays within a tenth of the
    load for longer than the flight. The start-up of the run ends when all these joints have started up and every drive
    has reached its speed; it may last longer than the run.

    Examples
    --------
    >>> import linkages
    >>> from linkages.results.startup import startup_end
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> run, ideal = linkages.simulate(system, "compiled"), linkages.ideal(system)
    >>> contacts = linkages.impacts(run, ["B"])
    >>> contacts[0].start < 0.05 * startup_end(system, contacts, run, ideal)
    True
    """
    end, times = float(run.time[-1]), []
    for joint in system.experiment.play:
        rows = [row for row in contacts if row.joint.partition(".")[0] == joint]
        flight = min((row.start for row in rows), default=0.0)
        if flight > 0.0:
            times.append(min((row.start for row in rows if row.duration > flight), default=end))
        elif not rows and (carried := _carried(run, ideal, f"{joint}.force")) is not None:
            times.append(carried)
    if not times:
        return None
    ramps = [drive.ramp for drive in system.experiment.drives.values()]
    return min(max([*times, *ramps]), end)


def _carried(run: Trajectory, ideal: Trajectory, force: str) -> float | None:
    """Find the time from which a film carries its load [s]; None if its force never overshoots before."""
    times = run.time[run.time <= ideal.time[-1]]
    load = np.interp(times, ideal.time, ideal[force])
    excess = (run[force][: len(times)] - load) / np.maximum(load, np.finfo(float).tiny)
    flight = float(times[np.argmax(excess >= -_CARRIED)])
    edges = np.flatnonzero(np.diff(np.abs(excess) <= _CARRIED, prepend=False, append=False))
    begins, ends = edges[::2], edges[1::2] - 1
    long = begins[times[ends] - times[begins] > flight]
    if flight == 0.0 or not len(long) or excess[: long[0]].max() <= _OVERSHOOT:
        return None
    return float(times[long[0]])
