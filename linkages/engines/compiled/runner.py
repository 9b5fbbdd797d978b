"""A system as an object that runs."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

from linkages.engines.compiled.binding import LEFT, OPEN, check, evaluate, run
from linkages.engines.compiled.job import ACCURACY, END, LONGEST, make_given
from linkages.engines.compiled.kinks import kinks
from linkages.engines.compiled.model import Equations, error_scale, make_memory, make_work
from linkages.engines.compiled.replay import Steps
from linkages.engines.methods import expect_run
from linkages.errors import Status
from linkages.integrate.driver import COLLAPSED, DONE, PAUSED, Options, Record
from linkages.integrate.stepper import make_stepper
from linkages.kernel import Array, Indices
from linkages.kernel.by_reference import Packed, packed
from linkages.outputs.registry import pack
from linkages.planar.contacts import WIDTH
from linkages.signals import arrival, deferred
from linkages.system import System

STATUS = {
    DONE: Status.OK,
    COLLAPSED: Status.STEP_SIZE_COLLAPSE,
    LEFT: Status.JOURNAL_LEFT_BEARING,
    OPEN: Status.LOOP_OPEN,
}


def join(records: list[Record]) -> Steps:
    """Join the steps of runs of which each continues the one before."""
    fields = ("times", "states", "observed")
    return Steps(*(np.concatenate([getattr(r, field)[min(k, 1) :] for k, r in enumerate(records)]) for field in fields))


class Runner:
    """A system, ready to run.

    Sections of links on which nothing acts are left out.

    Attributes
    ----------
    system : System
    model : Arrays
    scale : (ny,) array
        Unit of the error of each entry of the state.
    start : (ny,) array
        State at t = 0.
    implicit : bool
        Whether the integration method is implicit.
    tolerance : (ny,) array
        Tolerance of each entry of the state, per step.
    memory, modes : (nc, 2 or more) and (nc,) arrays
        Memory of the contacts, and whether they touch; see `linkages.engines.compiled.model.Work`; `run` keeps both
        up to date.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        given = make_given(system, pack(system, ()), np.zeros((0, 2)))
        self.model, self.start, self.implicit = given.model, given.start, given.implicit
        self.tolerance, self.scale = given.tolerance, error_scale(system)
        expect_run(system, "compiled")
        self._landing, self._limits = given.landing, given.limits
        self._kinks = given.kinks, kinks(system)
        nc = len(self.model.ends)
        self.memory, self.modes = make_memory(self.model), np.full(nc, -1)
        self._stepper = packed(make_stepper(len(self.start), len(self.model.free)))
        self._equations = packed(self._with(self.memory, self.modes))
        self._idle = [(self._equations, self._stepper)]  # on which no thread evaluates

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the system and the contacts' memory; addresses hold in one process only."""
        return _restored, (self.system, self.memory, self.modes)

    def run(
        self, t: float, y: Array, first: float, most: int, end: float | None = None, differentiated: bool = False
    ) -> Record:
        """Run from a state, at most up to the last step with closed loops.

        Parameters
        ----------
        t : float
            Time [s].
        y : (ny,) array
            State.
        first : float
            Step to try [s]; 0 lets the driver choose it, so that a tighter accuracy has a shorter one.
        most : int
            Steps after which the run pauses; it also pauses where a signal arrives.
        end : float, optional
            Default the experiment's duration [s].
        differentiated : bool
            Whether derivatives will be computed: steps end at kinks at any accuracy, and the stages of an implicit
            method are recorded.
        """
        limits, stop = self._limits, np.frombuffer(arrival(), np.int64, 1)
        last, longest, accuracy = (float(limits[k]) for k in (END, LONGEST, ACCURACY))
        end, divisions = last if end is None else end, self._kinks[differentiated]
        options = Options(end, first, longest, most, 0.0, self._landing, divisions, accuracy, stop)
        with deferred():
            record = run(
                self._equations, self._stepper, self.tolerance, t, y, options, differentiated and self.implicit
            )
        if (
            record.status == PAUSED
            and record.steps < most
            and threading.current_thread() is not threading.main_thread()
        ):
            raise KeyboardInterrupt  # in the main thread the signal's handler raises it
        if record.status == OPEN and len(record.times) > 1:
            times, states, observed = record.times[:-1], record.states[:-1], record.observed[:-1]
            return record._replace(times=times, states=states, observed=observed)
        return record

    def evaluate(self, steps: Steps, times: Array) -> tuple[Array, Array, Array, Array]:
        """Coordinates, rates, accelerations (nt, n), and contacts (nt, nc, WIDTH) at times within steps of a run."""
        nt, nc, n = len(times), len(self.model.ends), len(self.model.free) + len(self.model.driven)
        out = np.empty((nt, n)), np.empty((nt, n)), np.empty((nt, n)), np.empty((nt, nc, WIDTH))
        times = np.asarray(times, dtype=np.float64)
        try:
            equations, stepper = self._idle.pop()
        except IndexError:
            equations, stepper = self.aside(), packed(make_stepper(len(self.start), len(self.model.free)))
        work = equations.work
        kept = work.memory.copy(), work.modes.copy()  # of the run
        work.memory[:], work.modes[:], work.solved[:], stepper.memory[:] = 0.0, -1, np.nan, 0.0
        steps = steps if isinstance(steps, Packed) else packed(steps)
        evaluate(equations, stepper, self.tolerance, steps, times, *out)
        (work.memory[:], work.modes[:]), work.solved[:] = kept, np.nan
        self._idle.append((equations, stepper))
        return out

    def status(self, t: float, y: Array) -> Status:
        """Check a state (ny,) at a time: OK if its loops are closed and its journals lie within their films."""
        return STATUS[check(self.aside(), t, y)]

    def aside(self) -> Equations:
        """Return a packed copy of the equations with the contacts' memory reset."""
        return packed(self._with(np.zeros_like(self.memory), np.full_like(self.modes, -1)))

    def _with(self, memory: Array, modes: Indices) -> Equations:
        return Equations(self.model, make_work(self.model, memory, modes), self.implicit)


def _restored(system: System, memory: Array, modes: Indices) -> Runner:
    runner = Runner(system)
    runner.memory[:], runner.modes[:] = memory, modes
    return runner
