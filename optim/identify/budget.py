"""The limit of time of a fit."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

from optim.identify.numerics import BUDGET_SEARCH

USUAL = 50.0  # most seconds of a fit if the file gives none


def clock() -> float:
    """Return the time [s since the epoch], which processes share."""
    return time.time()


@dataclass
class Budget:
    """Time of a fit, as a clock on the wall tells it: searches end with their best values when it is over.

    Each run begins in time, so that a fit ends at most one run after the limit, however busy the machine is.

    Attributes
    ----------
    seconds : float
        The limit [s].
    part : float
        Part of the time that may be used now.
    begin : float
        Time of the clock [s since the epoch].
    """

    seconds: float = math.inf
    part: float = 1.0
    begin: float = field(default_factory=lambda: clock())

    @property
    def late(self) -> bool:
        """Whether searches must end."""
        return self.used > 1.0

    @property
    def used(self) -> float:
        """Part of the present time that is over."""
        return (clock() - self.begin) / (self.part * self.seconds)


def search_budget(seconds: float | None) -> Budget:
    """Return the budget of the search of a fit with a limit of time [s]."""
    return Budget(seconds or USUAL, BUDGET_SEARCH)


def extend(budget: Budget) -> None:
    """Add the time after the search to a budget."""
    budget.part = 1.0
