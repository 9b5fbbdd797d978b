"""Temperature of the oil as the equilibrium of a cycle: runs are repeated until power and removed heat are equal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from linkages.base.errors import RunError, Status
from linkages.laws.heat import NEAR
from linkages.results.assessment import Assessment
from linkages.results.films import heated, joint_heat
from linkages.results.trajectory import Trajectory
from linkages.system import System

#: Most runs for one equilibrium, and the origin of the temperatures that it sets.
_MOST, _ORIGIN = 12, "heat balance"


def settle(assessment: Assessment, rerun: Callable[[System, str], Trajectory]) -> Assessment:
    """Repeat a run until the temperatures of its oil change by less than `linkages.laws.heat.NEAR`.

    Each run's motion gives the power and flow of a cycle (`linkages.results.films`). The next temperature is the
    one at which this motion would be in balance; the power is taken as proportional to the viscosity. The temperature
    that settles has no approximation left.

    Parameters
    ----------
    assessment : Assessment
        Of a run at the first guess of the temperatures.
    rerun : callable
        Runs a system; its second argument names the run.

    Returns
    -------
    Assessment
        Of the system with the last temperatures, and its `heat`; without it if a run fails.

    Raises
    ------
    RunError
        If no temperature balances.
    """
    names = heated(assessment.system)
    for count in range(1, _MOST + 1):
        if not names or assessment.run.status is not Status.OK:
            return assessment
        try:
            heats = {name: joint_heat(assessment.system, assessment.run, name, *_cycle(assessment)) for name in names}
        except ArithmeticError as problem:
            raise RunError(f"{problem}; the joints are {', '.join(names)}") from None
        if count == _MOST or all(abs(heat.change) < NEAR for heat in heats.values()):
            return replace(assessment, heat=heats)
        values = {f"joints.{name}.oil.temperature": heat.balanced for name, heat in heats.items()}
        system = assessment.system.replaced(values, _ORIGIN)
        assessment = replace(assessment, system=system, run=rerun(system, f"run {count + 1}, oil temperature"))
    raise AssertionError("the loop returns at its last round")


def _cycle(assessment: Assessment) -> tuple[tuple[float, float], bool]:
    """Return the last period of the motion, or the reported part of a run without one; whether the motion repeats."""
    motion, end = assessment.motion, float(assessment.run.time[-1])
    if motion.cycle is not None:
        return motion.cycle, True
    if motion.period is not None and motion.period <= end:
        return (end - motion.period, end), False
    return assessment.windows.get(assessment.reported, (float(assessment.run.time[0]), end)), False
