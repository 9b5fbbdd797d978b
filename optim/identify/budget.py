"""The limit of time of a fit."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

USUAL = 50.0  # most seconds of a fit if the file gives none
_LEAST = 20  # runs that are made then in any case
_SEARCH = 0.7  # part of the time for the search; the rest is for accurate runs at its end


@dataclass
class Budget:
    """Time and runs of a fit; searches end with their best values when it is used up.

    Attributes
    ----------
    end : float
        Time of the clock [s since the epoch].
    least : int
        Runs that are made in any case.
    made : int
        Runs so far.
    begin : float
        Time of the clock [s since the epoch].
    """

    end: float = math.inf
    least: int = 0
    made: int = 0
    begin: float = field(default_factory=time.time)

    @property
    def late(self) -> bool:
        """Whether searches must end."""
        return self.made >= self.least and time.time() > self.end

    @property
    def used(self) -> float:
        """Part of the time that is over."""
        return (time.time() - self.begin) / (self.end - self.begin)


def search_budget(seconds: float | None) -> Budget:
    """Return the budget of the search of a fit with a limit of time [s]."""
    return Budget(time.time() + _SEARCH * (seconds or USUAL), _LEAST if seconds is None else 1)


def extend(budget: Budget, seconds: float | None) -> None:
    """Add the time after the search to a budget."""
    budget.end = max(budget.end, time.time()) + (1.0 - _SEARCH) * (seconds or USUAL)
