"""A system as an object that runs."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np

from linkages.base.errors import AssemblyError, Status
from linkages.base.kernel import Array, Indices
from linkages.base.kernel.by_reference import packed
from linkages.base.signals import arrival, deferred
from linkages.engines.compiled.run.binding import JAMMED, LEFT, OPEN, check, evaluate, run
from linkages.engines.compiled.run.job import END, Given, Job, make_given, make_job
from linkages.engines.compiled.run.kinks import kinks
from linkages.engines.compiled.run.model import Equations, error_scale
from linkages.engines.compiled.run.replay import Steps
from linkages.engines.compiled.run.sampling import tabulate_run
from linkages.engines.methods import expect_run
from linkages.mechanics.integrate.driver import COLLAPSED, DONE, PAUSED, Record
from linkages.mechanics.planar.arrays import size_of
from linkages.mechanics.planar.contact_memory import make_memory
from linkages.mechanics.planar.contacts import WIDTH
from linkages.results.outputs.columns import Columns, whole_columns
from linkages.results.outputs.registry import names as all_names
from linkages.results.outputs.registry import pack
from linkages.system import System
from linkages.system.rigid_segments import Segmented

STATUS = {
    DONE: Status.OK,
    COLLAPSED: Status.STEP_SIZE_COLLAPSE,
    LEFT: Status.JOURNAL_LEFT_BEARING,
    OPEN: Status.LOOP_OPEN,
    JAMMED: Status.JAMMED,
}


def join(records: list[Record]) -> Steps:
    """Join the steps of runs of which each continues the one before."""
    fields = ("times", "states", "observed")
    return Steps(*(np.concatenate([getattr(r, field)[min(k, 1) :] for k, r in enumerate(records)]) for field in fields))


class Runner:
    """A system, ready to run; runs pause as soon as `stop` (1,), by default the mark of a signal, is not zero.

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
    job : Job
        Its numbers (by default without outputs), and the arrays to work on.
    memory, modes : (nc, 2 or more) and (nc,) arrays
        Memory of the contacts, and whether they touch; see `linkages.engines.compiled.run.model.Work`; `run` keeps both
        up to date.
    """

    def __init__(self, system: System, given: Given | None = None, stop: Indices | None = None) -> None:
        self.system, self._stop = system, stop
        self._given = given = given or make_given(system, pack(system, ()), np.zeros((0, 2)))
        self.model, self.start, self.implicit = given.model, given.start, given.implicit
        self.tolerance, self.scale = given.tolerance, error_scale(system)
        expect_run(system, "compiled")
        self._kinks = given.kinks, kinks(system)
        self.memory, self.modes = make_memory(self.model.ends, self.model.tables), np.full(len(self.model.ends), -1)
        self.job = packed(make_job(given, self.memory, self.modes))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the system and the contacts' memory; addresses hold in one process only."""
        return _restored, (self.system, self.memory, self.modes)

    def run(
        self, t: float, y: Array, first: float, most: int, end: float | None = None, differentiated: bool = False
    ) -> Record:
        """Run from a state y (ny,) at t [s], at most up to the last step with closed loops.

        `first` is the step to try [s]; 0 lets the driver choose it, so that a tighter accuracy has a shorter one. The
        run pauses after `most` steps, and at a stop; its end is the experiment's duration by default. If
        it is to be differentiated, steps end at kinks at any accuracy, and the stages of an implicit method are
        recorded.
        """
        stop = np.frombuffer(arrival(), np.int64, 1) if self._stop is None else self._stop
        end = float(self._given.limits[END]) if end is None else end
        with deferred():
            record = run(
                self.job, self._kinks[differentiated], differentiated and self.implicit, t, y, first, most, end, stop
            )
        if (
            record.status == PAUSED
            and record.steps < most
            and self._stop is None
            and threading.current_thread() is not threading.main_thread()
        ):
            raise KeyboardInterrupt  # in the main thread the signal's handler raises it
        return record

    def evaluate(self, steps: Steps, times: Array) -> tuple[Array, Array, Array, Array]:
        """Coordinates, rates, accelerations (nt, n), and contacts (nt, nc, WIDTH) at times within steps of a run.

        Additional states follow the rates, their rates the accelerations, and zeros the coordinates.
        """
        nt, nc, n = len(times), len(self.model.ends), size_of(self.model)
        out = np.empty((nt, n)), np.empty((nt, n)), np.empty((nt, n)), np.empty((nt, nc, WIDTH))
        with _table(self.system, ()).lent() as job:
            evaluate(job, packed(steps), np.asarray(times, dtype=np.float64), *out)
        return out

    def outputs(self, steps: Steps, times: Array, names: Sequence[str] | None = None) -> Columns:
        """Compute outputs at times within steps of a run, as `linkages.results.outputs.columns.columns`.

        AssemblyError if jitter is requested and the ideal linkage does not close.
        """
        if names is None and isinstance(self.system, Segmented):
            return whole_columns(self.system, False, lambda own: self.outputs(steps, times, own))
        table = _table(self.system, None if names is None else tuple(names))
        found = np.empty((len(times), len(table.names)))
        with table.lent() as job:
            if not tabulate_run(job, packed(steps), np.asarray(times, dtype=np.float64), found):
                raise AssemblyError(Status.NO_ASSEMBLY, "the ideal linkage does not close")
        return {"time": times} | dict(zip(table.names, np.ascontiguousarray(found.T), strict=True))

    def status(self, t: float, y: Array) -> Status:
        """Check a state (ny,) at a time: OK if its loops are closed and its journals lie within their films."""
        return STATUS[check(self.aside(), t, y)]

    def aside(self) -> Equations:
        """Return a packed copy of the equations with the contacts' memory reset."""
        return packed(make_job(self._given).equations)


class _Table:
    """Named outputs of a system, and jobs for them."""

    def __init__(self, system: System, names: tuple[str, ...]) -> None:
        self.names = names
        self._given = make_given(system, pack(system, names), np.zeros((0, 2)))
        self._idle: list[Job] = []  # on which no thread evaluates

    @contextmanager
    def lent(self) -> Iterator[Job]:
        """Lend a job, which remembers nothing that counts."""
        try:
            job = self._idle.pop()
        except IndexError:
            job = packed(make_job(self._given))
        yield job
        self._idle.append(job)


@lru_cache(maxsize=32)  # a search for peaks evaluates repeatedly, in each thread
def _table(system: System, names: tuple[str, ...] | None) -> _Table:
    return _Table(system, tuple(all_names(system)) if names is None else names)


def _restored(system: System, memory: Array, modes: Indices) -> Runner:
    runner = Runner(system)
    runner.memory[:], runner.modes[:] = memory, modes
    return runner
