"""Advance a simulator of a user's diagram that contains linkages."""

from __future__ import annotations

from collections.abc import Iterator

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, EventStatus

from linkages.base.errors import Status
from linkages.engines.budget import Budget
from linkages.engines.drake.drives import Drives
from linkages.engines.drake.steps import StepControl, is_collapse
from linkages.results.trajectory import TimeReport
from linkages.system import System

_FIRST = 1e-3  # first step over the largest step


def advance(
    system: System,
    drives: Drives,
    simulator: Simulator,
    until: float,
    progress: TimeReport | None = None,
    limit: int | None = None,
) -> Status:
    """Advance a simulator to a time; `linkages.engines.drake.Linkage.advance` documents the arguments."""
    ended = [Status.OK]
    linkages = [drives, *(other for other in _linkages(simulator.get_system()) if other is not drives)]
    steps, budget = StepControl(simulator, *(other.system for other in linkages)), Budget(system, limit)

    def look(root: Context) -> EventStatus:
        steps.take(root)
        if progress is not None:
            progress(root.get_time())
        if budget.spent(root.get_time()):
            ended[0], steps.again = Status.TOO_MANY_STEPS, False
            return EventStatus.ReachedTermination(drives, "too many steps")
        if steps.kept and any(other.has_open_loop(root) for other in linkages):
            ended[0], steps.again = Status.LOOP_OPEN, False
            return EventStatus.ReachedTermination(drives, "a loop opened")
        return steps.verdict()

    simulator.set_monitor(look)
    try:
        steps.begin(_FIRST * steps.largest, steps.accuracy)
        steps.advance(until)
    except RuntimeError as problem:
        if not is_collapse(problem):
            raise
        return Status.STEP_SIZE_COLLAPSE
    finally:
        simulator.clear_monitor()
    return ended[0]


def _linkages(diagram: Diagram) -> Iterator[Drives]:
    """Yield the drives of all linkages in a diagram, and in diagrams within it."""
    for system in diagram.GetSystems():
        if isinstance(system, Drives):
            yield system
        elif isinstance(system, Diagram):
            yield from _linkages(system)
