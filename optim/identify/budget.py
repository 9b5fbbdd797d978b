"""The limit of time of a fit."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

from optim.identify.numerics import BUDGET_LEAST, BUDGET_SEARCH

USUAL = 50.0  # most seconds of a fit if the file gives none


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
    return Budget(time.time() + BUDGET_SEARCH * (seconds or USUAL), BUDGET_LEAST if seconds is None else 1)


def extend(budget: Budget, seconds: float | None) -> None:
    """Add the time after the search to a budget."""
    budget.end = max(budget.end, time.time()) + (1.0 - BUDGET_SEARCH) * (seconds or USUAL)
