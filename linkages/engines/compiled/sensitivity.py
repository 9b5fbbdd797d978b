"""Derivatives of a finished run with respect to its first state and to values of the system."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from linkages.arguments import Dense
from linkages.engines.compiled.job import COARSE, make_given
from linkages.engines.compiled.kinks import friction_speeds, kinks
from linkages.engines.compiled.neighbours import neighbours
from linkages.engines.compiled.output_derivatives import IdealMotions, OutputTable
from linkages.engines.compiled.replay import Steps
from linkages.engines.compiled.run_derivatives import GRAZED, KNOWN, SINGULAR, differentiate_run, differentiate_states
from linkages.engines.compiled.runner import Runner
from linkages.engines.compiled.step_derivatives import Column, make_column
from linkages.engines.compiled.variation import vary
from linkages.integrate.stepper import make_stepper
from linkages.kernel import Array, Indices
from linkages.kernel.by_reference import packed
from linkages.model.capabilities import Analysis
from linkages.outputs.columns import Columns
from linkages.outputs.registry import pack
from linkages.planar.contact_partials import FINE, FRICTION_SPEED
from linkages.planar.contacts import WIDTH
from linkages.results.derivatives import GRAZING, HORIZON, OK, STUCK, Derivatives, Direction

_FELT = 0.01  # part of its scale by which an error of a run may change the state while derivatives have a meaning


class Sensitivity(NamedTuple):
    """Derivatives of a run with nt steps: m columns, ny entries of the state, nc contacts. NaN where there is none.

    Attributes
    ----------
    times : (nt,) array
        Of the steps [s].
    states : (nt, ny, m) array
        Derivatives of the state at fixed time, after the event or the projection at that time.
    memory : (nt, nc, m) array
        Derivatives of the approach speeds that contacts remember.
    rates : (nt, k, m) array
        Rates of the derivatives of rates and other entries; NaN where the end of the step does not give them.
    contacts : (np, nt, nc, WIDTH) array
        Derivatives of the contacts along the values; the first of a step is NaN where its end does not give them.
    event : (nt,) array of int
        Contact that begins, counted from 1, or ends, less than 0; 0 without.
    event_times : (nt, m) array
        Derivatives of the events' times.
    status : int
        See `linkages.engines.compiled.run_derivatives`.
    known : int
        Number of times with derivatives.
    """

    times: Array
    states: Array
    memory: Array
    rates: Array
    contacts: Array
    event: Indices
    event_times: Array
    status: int
    known: int


class Differentiation:
    """A finished run and np values: its derivatives at the steps, and at any times.

    Parameters
    ----------
    runner : Runner
    steps : Steps
        See `linkages.engines.compiled.runner.join`. The first time need not be zero.
    values : sequence of str or Direction
        Dotted paths of the values, as for `linkages.System.replaced`, or values that several paths follow.

    Raises
    ------
    InputError
        If a path has no number or no derivative.
    """

    def __init__(self, runner: Runner, steps: Steps, values: Sequence[str | Direction] = ()) -> None:
        system = runner.system
        system.check_analysis(Analysis.DERIVATIVES)
        self.runner, self.steps = runner, steps
        self._nearby = neighbours(system, values)
        given = make_given(system, pack(system, ()), np.zeros((0, 2)))
        self._variation, self.start = vary(system, self._nearby, given)
        ny, n = len(runner.start), len(runner.model.free)
        equations = runner.aside()
        bounds = equations.work.scratch.bounds
        bounds[:, FRICTION_SPEED] = friction_speeds(system)
        bounds[:, FINE] = system.experiment.solver.accuracy < COARSE
        self._numbers = packed(equations), self._variation, packed(make_stepper(ny, n)), runner.tolerance
        self._kinks, self._ideals = kinks(system), IdealMotions()

    def _column(self, m: int) -> Column:
        return make_column(len(self.runner.start), self.runner.model, m, len(self._nearby), self.runner.implicit)

    def at_steps(self, start: Array | None = None, remembered: Array | None = None) -> Sensitivity:
        """Differentiate at the steps; see `differentiate`."""
        runner, nt, ny = self.runner, len(self.steps.times), len(self.runner.start)
        first = np.concatenate([np.eye(ny), self.start], axis=1) if start is None else np.asarray(start, np.float64)
        m, nc = first.shape[1], len(runner.model.ends)
        column = self._column(m)
        column.before[:] = first
        if remembered is not None:
            column.remembered[:] = remembered
        k = ny - len(runner.model.free)
        states, memory, rates = (np.empty((nt, size, m)) for size in (ny, nc, k))
        contacts = np.zeros((len(self._nearby), nt, nc, WIDTH))
        contacts[:, :, :1, 0] = np.nan
        event, times, rate = np.zeros(nt, np.int64), np.full((nt, m), np.nan), float(runner.system.motion_rate)
        status, known = differentiate_run(
            *self._numbers, packed(self.steps), rate, self._kinks, packed(column), states, memory, rates, contacts,
            event, times,
        )  # fmt: skip
        states[known:], memory[known:], rates[known:] = np.nan, np.nan, np.nan
        return Sensitivity(self.steps.times, states, memory, rates, contacts, event, times, status, known)

    @cached_property
    def columns(self) -> Sensitivity:
        """Derivatives at the steps, NaN beyond the horizon: where errors of the run would change the state visibly."""
        found = self.at_steps()
        ny, scale = len(self.runner.start), self.runner.scale
        growth = np.abs(found.states[:, :, :ny] * scale / scale[:, None]).max(axis=(1, 2), initial=0.0)
        accuracy = self.runner.system.experiment.solver.accuracy
        beyond = np.flatnonzero(accuracy * growth[: found.known] > _FELT)
        if not len(beyond):
            return found
        found.states[beyond[0] :], found.memory[beyond[0] :] = np.nan, np.nan
        return found._replace(known=int(beyond[0]), status=_BEYOND)

    def changes(self, times: Array) -> tuple[Array, Array, Array, Array]:
        """Differentiate coordinates, rates, accelerations (np, nt, n) and contacts (np, nt, nc, WIDTH)."""
        model, count, nt, found = self.runner.model, len(self._nearby), len(times), self.columns
        n, nc = len(model.free) + len(model.driven), len(model.ends)
        dq, dv, da = (np.empty((count, nt, n)) for _ in range(3))
        noted = found.contacts if np.array_equal(times, self.steps.times) else np.zeros((count, nt, nc, WIDTH))
        out = dq, dv, da, noted
        differentiate_states(
            *self._numbers, packed(self.steps), self._kinks, packed(self._column(found.states.shape[2])), found.states,
            found.memory, found.rates, found.contacts, found.known, np.asarray(times, dtype=np.float64), *out,
        )  # fmt: skip
        return out

    def outputs(
        self, times: Array, names: Sequence[str] | None = None, states: Sequence[Array] | None = None
    ) -> dict[str, Columns]:
        """Compute the derivatives of outputs at any times of the run, by path; with the states there if known."""
        table = OutputTable(self.runner.system, names, self._ideals)
        state, changes = states or self.runner.evaluate(self.steps, times), self.changes(times)
        return {
            near.path: table.derivatives(near, times, state, change, self.runner.model)
            for near, *change in zip(self._nearby, *changes, strict=True)
        }

    def derivatives(
        self, times: Array, names: Sequence[str] | None = None, states: Sequence[Array] | None = None
    ) -> Derivatives:
        """Return the derivatives of outputs, by default of all, at times of the run; with the states there if known."""
        found = self.columns
        until = float(self.steps.times[found.known - 1]) if found.known else -np.inf
        evaluate = Dense(partial(self.outputs, names=names), float(times[0]), float(times[-1]))
        return Derivatives(self.outputs(times, names, states), _STATUS[found.status], until, evaluate)


_BEYOND = 3
_STATUS = {KNOWN: OK, SINGULAR: STUCK, GRAZED: GRAZING, _BEYOND: HORIZON}


def differentiate(
    runner: Runner, steps: Steps, paths: Sequence[str] = (), start: Array | None = None, memory: Array | None = None
) -> Sensitivity:
    """Differentiate a finished run. The runner stays as it is.

    Parameters
    ----------
    runner : Runner
    steps : Steps
        See `linkages.engines.compiled.runner.join`. The first time need not be zero.
    paths : sequence of str
        Dotted paths of np values, as for `linkages.System.replaced`.
    start : (ny, m) array, optional
        Derivatives of the first state; the last np columns are those of the values. Default: the identity, and the
        derivatives of the system's own start.
    memory : (nc, m) array, optional
        Derivatives of the approach speeds at the first state; default zero.

    Raises
    ------
    InputError
        If a path has no number or no derivative.
    """
    return Differentiation(runner, steps, paths).at_steps(start, memory)
