"""Service lives of designs (``life.`` names): cycles of wear until a quantity exceeds a limit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from linkages import AssemblyError, Status, System, wear_life
from optim.evaluate.requests import STATISTICS, Request, Statistics, run_each
from optim.problem.schema import LIFE, ServiceLife
from optim.problem.study import Array


def run_lives(request: Request, lives: Mapping[str, ServiceLife]) -> Statistics:
    """Wear the designs of a request, each by its own jumps; KeyboardInterrupt if a computation was interrupted.

    A service life, of `lives` by name, is one number: each of `STATISTICS`, in each window.
    """
    wanted = [lives[name.removeprefix(LIFE)] for name in request.outputs]

    def statistics(_: int, system: System) -> Array:
        numbers = np.array([cycles_of(system, life) for life in wanted])
        return np.broadcast_to(numbers, (len(STATISTICS), len(request.windows), len(wanted)))

    return run_each(request, statistics)


def cycles_of(system: System, life: ServiceLife) -> float:
    """Compute the service life, at most the limit of simulated cycles; AssemblyError if a block failed before."""
    found = wear_life(
        system,
        int(life.cycles),
        life.tolerance,
        life.scatter,
        life.drive,
        enough=lambda so_far: so_far.history(life.until)[1][-1] > life.limit,
    )
    if found.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    until = found.cycles_until(life.until, life.limit)
    if until == float("inf") and found.status is not Status.OK:
        raise AssemblyError(found.status, f"ended after {found.cycles[-1]:,} cycles")
    return min(until, life.cycles)
