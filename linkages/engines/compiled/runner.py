"""A system as an object that runs."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from linkages.engines.compiled.binding import LEFT, OPEN, evaluate, run
from linkages.engines.compiled.model import Equations, error_scale, make_work, start_state
from linkages.engines.compiled.replay import Steps
from linkages.engines.compiled.statistics import make_sampler, summarise
from linkages.errors import Status
from linkages.integrate.driver import COLLAPSED, DONE, Options, Record
from linkages.integrate.stepper import make_stepper
from linkages.kernel import Array, Indices, Records
from linkages.kernel.by_reference import packed
from linkages.kernel.precompiled import expect
from linkages.model.experiment_tables import IMPLICIT
from linkages.outputs.formulas import OF_FORCES
from linkages.planar.contacts import WIDTH, landing
from linkages.planar.ideal import Ideal
from linkages.signals import deferred
from linkages.system import System

STATUS = {
    DONE: Status.OK,
    COLLAPSED: Status.STEP_SIZE_COLLAPSE,
    LEFT: Status.JOURNAL_LEFT_BEARING,
    OPEN: Status.LOOP_OPEN,
}

_TRAVEL = 0.1  # of the fastest drive in a step of a prescribed motion [rad or m], at most
_FEWEST = 200  # steps of a prescribed motion, as many as the ideal motion has times: its loads may vary faster


def join(records: list[Record]) -> Steps:
    """Join the steps of runs of which each continues the one before."""
    fields = ("times", "states", "observed")
    return Steps(*(np.concatenate([getattr(r, field)[min(k, 1) :] for k, r in enumerate(records)]) for field in fields))


class Runner:
    """A system, ready to run.

    Sections of links on which nothing acts are left out, but for `outputs`, of which `summarise` gives statistics.

    Attributes
    ----------
    system : System
    model : Arrays
    scale : (ny,) array
        What an error of each entry of the state is measured by.
    start : (ny,) array
        State at t = 0.
    implicit : bool
        Whether the equations are stiff and Radau IIA is used; else Dormand and Prince's pair.
    tolerance : (ny,) array
        Tolerance of each entry of the state, per step.
    memory, modes : (nc, 2) and (nc,) arrays
        What the contacts remember and whether they touch, see `linkages.engines.compiled.model.Work`; `run` keeps both
        up to date.
    """

    def __init__(self, system: System, outputs: Records | None = None) -> None:
        self.system, solver, tree = system, system.experiment.solver, system.tree
        self.implicit = system.stiff if solver.integrator is None else solver.integrator in IMPLICIT
        expect("linkages.engines.precompilation:compiled", self.implicit)
        seen = [] if outputs is None else [outputs["marker"]["body"], outputs["at"], outputs["other"]]
        if outputs is not None and np.isin(outputs["kind"], OF_FORCES).any():
            seen.append(system.arrays.joints["child"]["body"])
        everywhere = max((int(part.max(initial=0)) for part in seen), default=0) >= tree.acting
        self.model = system.arrays
        if not everywhere:
            bodies, stiff = (tree.acting_bodies(each) for each in (self.model.bodies, self.model.stiff))
            self.model = self.model._replace(bodies=bodies, stiff=stiff)
        self.start, self.scale = start_state(system), error_scale(system)
        self.tolerance = solver.accuracy * self.scale
        nc = len(self.model.ends)
        self.memory, self.modes = np.zeros((nc, 2)), np.full(nc, -1)
        self._landing = landing(self.model.laws, self.model.size)
        self._stepper = packed(make_stepper(len(self.start), len(self.model.free)))
        self._equations = packed(self._with(self.memory, self.modes))

    def __reduce__(self) -> tuple[Any, ...]:
        """Addresses are those of this process: a copy in another one finds its own."""
        return _restored, (self.system, self.memory, self.modes)

    def run(self, t: float, y: Array, first: float, most: int, end: float | None = None) -> Record:
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
            Steps after which the run pauses.
        end : float, optional
            Default the experiment's duration [s].
        """
        duration, solver = self.system.experiment.duration, self.system.experiment.solver
        largest = solver.max_step or self._longest
        options = Options(duration if end is None else end, first, largest, most, 0.0, self._landing, solver.accuracy)
        with deferred():
            record = run(self._equations, self._stepper, self.tolerance, t, y, options)
        if record.status == OPEN and len(record.times) > 1:
            times, states, observed = record.times[:-1], record.states[:-1], record.observed[:-1]
            return record._replace(times=times, states=states, observed=observed)
        return record

    @cached_property
    def _longest(self) -> float:
        """Longest step [s]: a prescribed motion needs no steps, but extremes are looked for between them."""
        system, duration = self.system, self.system.experiment.duration
        if not system.determinate or system.tree.play or system.tree.bent:
            return duration
        return min(duration / _FEWEST, _TRAVEL * duration / system.drive_way if system.drive_way > 0.0 else np.inf)

    def evaluate(self, steps: Steps, times: Array) -> tuple[Array, Array, Array, Array]:
        """Coordinates, rates, accelerations (nt, n), and contacts (nt, nc, WIDTH) at times within steps of a run."""
        nt, nc, n = len(times), len(self.model.ends), len(self.model.free) + len(self.model.driven)
        out = np.empty((nt, n)), np.empty((nt, n)), np.empty((nt, n)), np.empty((nt, nc, WIDTH))
        times = np.asarray(times, dtype=np.float64)
        equations, stepper = packed(self.aside()), packed(make_stepper(len(self.start), len(self.model.free)))
        evaluate(equations, stepper, self.tolerance, packed(steps), times, *out)
        return out

    def summarise(self, ideal: Ideal, outputs: Records, steps: Steps, windows: Array, out: Array) -> bool:
        """Fill ``out`` (nw, no, ns) with the outputs' `STATISTICS` over windows of a run.

        Returns False if the ideal linkage does not close where it is asked for.
        """
        return summarise(make_sampler(self.aside(), ideal, outputs, self.tolerance, steps), windows, out)

    def aside(self) -> Equations:
        """Return the equations with contacts that remember nothing, so that a run can go on beside."""
        return self._with(np.zeros_like(self.memory), np.full_like(self.modes, -1))

    def _with(self, memory: Array, modes: Indices) -> Equations:
        return Equations(self.model, make_work(self.model, memory, modes), self.implicit)


def _restored(system: System, memory: Array, modes: Indices) -> Runner:
    runner = Runner(system)
    runner.memory[:], runner.modes[:] = memory, modes
    return runner
