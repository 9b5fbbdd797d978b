"""A run of the compiled engine that can be paused, continued and moved to another state."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, RunError, Status, nearest
from linkages.engines.budget import WINDOW
from linkages.engines.compiled.run.replay import Steps
from linkages.engines.compiled.run.runner import STATUS, Runner, join
from linkages.explore.numerics import FLOW_LOOKS, FLOW_MOST
from linkages.mechanics.integrate.driver import DONE, PAUSED, Record
from linkages.mechanics.planar.contact_memory import record_memory, recorded
from linkages.mechanics.planar.contacts import CLEARANCE_OUTPUTS
from linkages.results.outputs.columns import Columns
from linkages.results.steady_state import drive_period
from linkages.results.trajectory import Trajectory, sample
from linkages.system import System
from linkages.system.ideal_motion import cause


class Flow:
    """A run that can be paused, continued, and moved to another state.

    It has reached the time `t` [s] and the state `y` (ny,): positions and rates of the free coordinates, then other
    states, see `linkages.engines.compiled.run.model`. `scale` (ny,) is the error scale of each entry; the status is OK
    as long as the run can continue. AssemblyError or InputError as `System.assembly`.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.runner = Runner(system)
        self.memory = self.runner.memory  # of the contacts, see `linkages.mechanics.planar.contact_memory`
        self.y, self.scale = self.runner.start, self.runner.scale
        self.t, self.status = 0.0, Status.OK
        self.step = 0.0  # size of the next attempted step [s]
        self._last: Record | None = None

    def advance(self, until: float) -> Steps:
        """Continue up to a time, or until the run fails; return the steps."""
        parts = [self._take(FLOW_MOST, until)]
        while parts[-1].status == PAUSED:
            parts.append(self._take(FLOW_MOST, until))
        return join(parts)

    def reach(self, until: float) -> Steps:
        """Continue up to a time; return the steps. RunError if the run fails."""
        steps = self.advance(until)
        expect_valid(self.status, self.t)
        return steps

    def follow(self, times: Array, names: Sequence[str]) -> Columns:
        """Compute outputs at times, which increase from call to call; NaN after the end of the run.

        Steps are not shortened for these times, and the run pauses where `linkages.simulate` pauses: both give the same
        run.
        """
        pieces = [] if self._last is None else [self._last]
        while self.status is Status.OK and self.t < min(times[-1], self.system.settings.duration):
            self._last = self._take(WINDOW)
            pieces.append(self._last)
        piece = join(pieces)
        reached = times <= self.t
        found = self.columns(piece, times[reached], names)
        rest = np.full(len(times) - np.count_nonzero(reached), np.nan)
        return {name: np.concatenate([found[name], rest]) for name in names}

    def _take(self, most: int, until: float | None = None) -> Record:
        """Take some steps, up to a time or the end of the run."""
        record = self.runner.run(self.t, self.y, self.step, most, until)
        self.t, self.y, self.step = float(record.times[-1]), record.states[-1].copy(), record.next_step
        if record.status not in (DONE, PAUSED):
            self.status, _ = cause(STATUS[record.status], self.system, self.t)
        return record

    def resume(self, t: float, y: Array, memory: Array, step: float) -> None:
        """Set state, contacts' memory and next step of the run; contacts keep their status.

        RunError if a loop is open or a journal lies outside its film.
        """
        runner = self.runner
        expect_valid(runner.status(t, y), t)
        self.t, self.y, self.step, self.status = t, y, step, Status.OK
        runner.memory[:] = memory
        steps = self._resting(t, y)
        record_memory(runner.memory, steps.memory[0])
        contacts = runner.evaluate(steps, steps.times)[3]
        depth = contacts[0, :, CLEARANCE_OUTPUTS.index("penetration")]
        runner.modes[:] = np.where((runner.model.touching == 1) & (depth > 0.0), 1, -1)

    def _resting(self, t: float, y: Array) -> Steps:
        """Return a state as `Steps` whose contacts remember nothing."""
        return Steps(np.array([t]), y[None, :].copy(), np.zeros((1, recorded(self.runner.memory))))

    def closed(self, t: float, y: Array) -> Array:
        """Project a state onto the closed loops at a time."""
        model = self.runner.model
        steps = self._resting(t, y)
        q, v, _, _ = self.runner.evaluate(steps, steps.times)
        return np.concatenate([q[0, model.free], v[0, model.free], y[2 * len(model.free) :]])

    def columns(self, piece: Steps, times: Array, names: Sequence[str] | None = None) -> Columns:
        """Compute all or the named outputs (see `linkages.results.outputs.registry`) at times within `piece`."""
        return self.runner.outputs(piece, times, names)

    def sampled(self, piece: Steps, names: Sequence[str]) -> Trajectory:
        """Return outputs over `piece` as a trajectory."""
        return sample(np.unique(piece.times), partial(self.columns, piece, names=names), Status.OK, {})


def expect_valid(status: Status, t: float) -> None:
    """Raise a RunError with a status and its remedy, unless it is OK."""
    if status is not Status.OK:
        raise RunError(f"{status.value} at t = {t:.6g} s; {status.remedy}")


def period_of(system: System, drive: str | None = None) -> float:
    """Return the time of a revolution, or the period of an oscillating drive [s]; InputError if it is not periodic.

    By default the first drive with constant speed, otherwise the first periodic one.
    """
    moving = {name: d for name, d in system.drives.items() if d.prescribed and (d.speed or d.varies)}
    if drive is not None and drive not in moving:
        raise InputError("argument", "drive", f'"{drive}" has no prescribed motion; {nearest(drive, moving)}')
    for name in sorted(moving, key=lambda name: moving[name].varies) if drive is None else [drive]:
        looks = FLOW_LOOKS if moving[name].formula is not None else 1
        for k in range(looks):
            if (period := drive_period(system, name, system.settings.duration * 2.0**k)) is not None:
                return period
    problem = "does not repeat its motion" if drive else "no drive has constant speed or is periodic"
    raise InputError(
        system.description.source, f"drives.{drive}" if drive else "drives", f"{problem}: there is no revolution"
    )


def lasting(system: System, revolutions: float, drive: str | None = None) -> System:
    """Return the system with a duration of some revolutions (see `period_of`); InputError if a table ends earlier."""
    return system.replaced({"duration": revolutions * period_of(system, drive)})
