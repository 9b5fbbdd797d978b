"""Ends computations whose requests are outdated, or that take too long."""

from __future__ import annotations

import threading
import time as clock
from collections.abc import Callable

import numpy as np

_LOOK = 0.01  # interval between two looks at the request [s]


class OutdatedError(Exception):
    """Raised within a computation for an outdated request."""


class TimeLimitError(Exception):
    """Raised within a run that takes longer than its limit."""


class Watch:
    """Progress of a run, which ends it at once where its request is outdated, or takes longer than a limit [s].

    The time of a `first` run counts from its first progress on: kernels may have been compiled before.
    """

    def __init__(self, limit: float, outdated: Callable[[], bool], first: bool = False) -> None:
        self.stop, self._limit, self._outdated = np.zeros(1, np.int64), limit, outdated
        self._end = np.inf if first else clock.perf_counter() + limit
        self._problem: type[Exception] | None = None
        self._done = threading.Event()

    def __enter__(self) -> Watch:
        """Begin to look at the request and the clock."""
        threading.Thread(target=self._look, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()

    def __call__(self, _: float) -> None:
        """End the computation if it is to end."""
        self._end = min(self._end, clock.perf_counter() + self._limit)
        self._check()
        if self._problem is not None:
            raise self._problem

    def _check(self) -> None:
        if self._outdated():
            self._problem = OutdatedError
        elif clock.perf_counter() > self._end:
            self._problem = TimeLimitError

    def _look(self) -> None:
        while self._problem is None and not self._done.wait(_LOOK):
            self._check()
        self.stop[0] = 1
