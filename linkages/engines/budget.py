"""How many steps a run may take: one rule for both engines."""

from __future__ import annotations

from linkages.outputs.registry import names
from linkages.system import System

#: Steps of one run, and the memory that the columns of its trajectory may take [bytes].
MOST, ROOM = 5_000_000, 2**30

#: Steps in a row by whose pace a run is judged, and how many times `MOST` it may promise for the whole.
WINDOW, _HOPELESS = 20_000, 1000.0


def most(system: System) -> int:
    """Return how many steps a run of a system may take."""
    return min(MOST, ROOM // (8 * (1 + len(names(system)))))


def least_advance(duration: float) -> float:
    """Return the time [s] by which `WINDOW` steps must advance a run of this duration."""
    return duration * WINDOW / (_HOPELESS * MOST)


class Budget:
    """Ends runs that would never end, as of implausible machines: each step is accurate, but the end is out of reach.

    Parameters
    ----------
    system : System
        That runs.
    limit : int, optional
        Of steps, instead of `most` of the system.
    """

    def __init__(self, system: System, limit: int | None = None) -> None:
        self._most = most(system) if limit is None else limit
        self._least = least_advance(system.experiment.duration)
        self._steps = self._judged = 0
        self._time = 0.0

    def spent(self, time: float, steps: int = 1) -> bool:
        """Whether the run must end, so many steps further and now at a time [s]."""
        self._steps += steps
        if self._steps - self._judged < min(WINDOW, self._most):
            return False
        advanced, self._judged, self._time = time - self._time, self._steps, time
        return self._steps >= self._most or advanced < self._least
