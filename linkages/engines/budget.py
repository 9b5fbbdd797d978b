"""Largest number of steps of a run: one rule for both engines."""

from __future__ import annotations

from functools import lru_cache

from linkages.results.outputs.registry import names
from linkages.system import System

#: Most steps of one run, and largest memory of the trajectory's columns [bytes].
MOST, ROOM = 5_000_000, 2**30

#: Steps over which the pace of a run is measured, and largest extrapolated number of steps over `MOST`.
WINDOW, _HOPELESS = 20_000, 1000.0


@lru_cache(maxsize=8)  # a run asks twice
def most(system: System) -> int:
    """Return the largest number of steps of a run of a system."""
    return min(system.settings.max_steps or MOST, ROOM // (8 * (1 + len(names(system)))))


def least_advance(duration: float) -> float:
    """Return the time [s] by which `WINDOW` steps must advance a run of this duration."""
    return duration * WINDOW / (_HOPELESS * MOST)


class Budget:
    """Ends runs whose accurate steps are too short to reach the end, as with implausible values.

    `limit` is the largest number of steps, default `most` of the run's system.
    """

    def __init__(self, system: System, limit: int | None = None) -> None:
        self._most = most(system) if limit is None else limit
        self._least = least_advance(system.settings.duration)
        self._steps = self._judged = 0
        self._time = 0.0

    def spent(self, time: float, steps: int = 1) -> bool:
        """Add steps at a time [s]; return True if the budget is exhausted."""
        self._steps += steps
        if self._steps - self._judged < min(WINDOW, self._most):
            return False
        advanced, self._judged, self._time = time - self._time, self._steps, time
        return self._steps >= self._most or advanced < self._least
