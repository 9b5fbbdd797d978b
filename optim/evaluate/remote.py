"""Requests to other processes: the part that all share is read once by each process, answers are sent by columns."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.engines.parcels import Parcel
from optim.evaluate.evaluations import OK
from optim.evaluate.requests import Request, RequestEngine, Statistics, joined, run_parts
from optim.problem.study import Array

_LEAST = 0.1  # work of a request, whose way there and back takes some milliseconds [s]
_WORK = 0.5  # the same, where there is enough of it [s]


class Answer(NamedTuple):
    """Statistics by columns: a number for the status of each design, texts only for those that failed."""

    values: Array
    states: tuple[str, ...]
    codes: NDArray[np.uint8]  # (m,) places in `states`
    reasons: dict[int, str]
    seconds: float  # that the runs took

    def statistics(self) -> Statistics:
        """Return the statistics by designs."""
        status = [self.states[code] for code in self.codes.tolist()]
        return Statistics(self.values, status, [self.reasons.get(i, "") for i in range(len(status))])


def answer(shared: Parcel, values: Array) -> Answer:
    """Run designs (m, np) in this process; `shared` has the engines, and the request without designs."""
    engines, request = shared.content
    started = time.perf_counter()
    found = run_parts(engines, dataclasses.replace(request, values=values))
    return answered(found, time.perf_counter() - started)


def answered(found: Statistics, seconds: float) -> Answer:
    """Put statistics of runs that took so many seconds into columns."""
    states = tuple(dict.fromkeys([OK, *found.status]))
    codes = np.array([states.index(state) for state in found.status], dtype=np.uint8)
    reasons = {i: reason for i, reason in enumerate(found.reason) if reason}
    return Answer(found.values, states, codes, reasons, seconds)


class Dispatcher:
    """Divides populations into requests of enough work, and sends them to an executor.

    Parameters
    ----------
    executor : Executor
    parts : int or callable
        Requests, at most, that a population is divided into; a callable returns it for the workers there are now.
    """

    def __init__(self, executor: Executor, parts: int | Callable[[], int]) -> None:
        self.executor, self._parts = executor, parts
        self._lasts = math.nan  # time of a design in the last population [s]

    @property
    def parts(self) -> int:
        """Return the number of requests, at most."""
        return max(self._parts() if callable(self._parts) else self._parts, 1)

    def population(self, least: int) -> int:
        """Return the multiple of a number of designs that is work enough for all requests."""
        wanted = 0.0 if math.isnan(self._lasts) else self.parts * _WORK / self._lasts
        return least * max(math.ceil(wanted / least), 1)

    def send(self, shared: Parcel, values: Array) -> list[Future[Answer]]:
        """Send designs (m, np)."""
        count = self.parts if math.isnan(self._lasts) else int(len(values) * self._lasts / _LEAST)
        parts = np.array_split(values, min(max(count, 1), self.parts, len(values)))
        return [self.executor.submit(answer, shared, part) for part in parts]

    def receive(self, sent: Sequence[Sequence[Future[Answer]]]) -> list[Statistics]:
        """Wait for the answers of a population, one sequence for each operating point."""
        answers = [[future.result() for future in point] for point in sent]
        every = [each for point in answers for each in point]
        self._lasts = max(sum(each.seconds for each in every), 1e-9) / sum(len(each.codes) for each in every)
        return [joined([each.statistics() for each in point]) for point in answers]


def shared_part(engines: Mapping[str, RequestEngine], request: Request) -> Parcel:
    """Return the part that all requests at an operating point share: `request` has no designs."""
    return Parcel((engines, request))
