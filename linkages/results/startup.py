"""Start-up of joints with contact: centred journals fly across the clearance, hit the bearing and rebound."""

from __future__ import annotations

from collections.abc import Sequence

from linkages.results.impacts import Impact
from linkages.system import System


def startup_end(system: System, contacts: Sequence[Impact], end: float) -> float | None:
    """Find the time at which the start-up of a run ends [s].

    The start-up of a joint with clearance ends with the first contact that is longer than the initial flight. The
    start-up of the run ends when all touching joints have started up and every drive has reached its speed.

    Parameters
    ----------
    system : System
    contacts : sequence of Impact
        All contacts of the run.
    end : float
        End of the run [s].

    Returns
    -------
    float or None
        `end` if the start-up lasts longer than the run; None if no journal starts with free flight.

    Examples
    --------
    >>> import linkages
    >>> from linkages.results.startup import startup_end
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"))
    >>> contacts = linkages.impacts(linkages.simulate(system, "compiled"), ["B"])
    >>> contacts[0].start < 0.05 * startup_end(system, contacts, 0.024)
    True
    """
    times = []
    for joint in system.experiment.play:
        rows = [row for row in contacts if row.joint.partition(".")[0] == joint]
        flight = min((row.start for row in rows), default=0.0)
        if flight > 0.0:
            times.append(min((row.start for row in rows if row.duration > flight), default=end))
    if not times:
        return None
    ramps = [drive.ramp for drive in system.experiment.drives.values()]
    return min(max([*times, *ramps]), end)
