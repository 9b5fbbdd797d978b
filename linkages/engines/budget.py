"""How many steps a run may take: one rule for both engines."""

from __future__ import annotations

#: Steps of one run; a trajectory of more would hardly find room in memory.
MOST = 5_000_000

#: Steps in a row by whose pace a run is judged, and how many times `MOST` it may promise for the whole.
WINDOW, _HOPELESS = 20_000, 1000.0


class Budget:
    """Ends runs that would never end, as of implausible machines: each step is accurate, but the end is out of reach.

    Parameters
    ----------
    duration : float
        Of the run [s].
    """

    def __init__(self, duration: float) -> None:
        self._least = duration * WINDOW / (_HOPELESS * MOST)
        self._steps = self._judged = 0
        self._time = 0.0

    def spent(self, time: float, steps: int = 1) -> bool:
        """Whether the run must end, so many steps further and now at a time [s]."""
        self._steps += steps
        if self._steps - self._judged < WINDOW:
            return False
        advanced, self._judged, self._time = time - self._time, self._steps, time
        return self._steps >= MOST or advanced < self._least
