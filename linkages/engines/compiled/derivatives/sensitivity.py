"""Derivatives of a finished run with respect to its first state and to values of the system."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from linkages.base.arguments import Dense
from linkages.base.errors import InputError
from linkages.base.kernel import Array, Indices
from linkages.base.kernel.by_reference import packed
from linkages.base.kernel.dual import DIRECTIONS
from linkages.base.kernel.private import OFF
from linkages.base.kernel.simd import WIDTH as LANES
from linkages.elements.analysis import Analysis
from linkages.engines.compiled.derivatives.neighbours import neighbours
from linkages.engines.compiled.derivatives.output_derivatives import IdealMotions, OutputTable
from linkages.engines.compiled.derivatives.run_derivatives import (
    GRAZED,
    KNOWN,
    SINGULAR,
    AtSteps,
    Changes,
    States,
    differentiate_run,
    differentiate_states,
)
from linkages.engines.compiled.derivatives.step_derivatives import Column, Run, find_depths, make_column
from linkages.engines.compiled.derivatives.variation import vary
from linkages.engines.compiled.run.job import make_given
from linkages.engines.compiled.run.kinks import kinks
from linkages.engines.compiled.run.replay import Steps
from linkages.engines.compiled.run.runner import Runner
from linkages.engines.numerics import SENSITIVITY_AT_ONCE, SENSITIVITY_FELT, SENSITIVITY_FINE
from linkages.laws.states import LATCHED
from linkages.mechanics.integrate.stepper import make_stepper
from linkages.mechanics.planar.arrays import size_of
from linkages.mechanics.planar.contacts import WIDTH
from linkages.results.derivatives import GRAZING, HORIZON, OK, STUCK, Derivatives, Direction
from linkages.results.outputs.columns import Columns
from linkages.results.outputs.registry import pack


class Sensitivity(NamedTuple):
    """Derivatives of a run at its steps, see `AtSteps`; NaN where there is none.

    Attributes
    ----------
    status : int
        See `linkages.engines.compiled.derivatives.run_derivatives`.
    known : int
        Number of times with derivatives.
    """

    states: Array
    memory: Array
    event: Indices
    event_times: Array
    changes: Changes
    status: int
    known: int


class Differentiation:
    """A finished run and np values: its derivatives at the steps, and at any times.

    Parameters
    ----------
    runner : Runner
    steps : Steps
        See `linkages.engines.compiled.run.runner.join`. The first time need not be zero.
    values : sequence of str or Direction
        Dotted paths of the values, as for `linkages.System.replaced`, or values that several paths follow.

    Raises
    ------
    InputError
        If a path has no number or no derivative.
    """

    def __init__(self, runner: Runner, steps: Steps, values: Sequence[str | Direction] = ()) -> None:
        if OFF:
            raise InputError("environment", "NUMBA_DISABLE_JIT", "derivatives need the compiler; unset it")
        system = runner.system
        system.check_analysis(Analysis.DERIVATIVES)
        self.runner, self.steps = runner, steps
        self._nearby = neighbours(system, values)
        for path in (path for near in self._nearby for path in near.along if path.endswith(".sample_time")):
            raise InputError("argument", path, "moves the sampling instants: there is no derivative")
        given = make_given(system, pack(system, ()), np.zeros((0, 2)))
        variation, self.start = vary(system, self._nearby, given)
        ny, n = len(runner.start), len(runner.model.free)
        equations = runner.aside()
        stepper = packed(make_stepper(ny, n))
        steps, depths = packed(steps), np.zeros((len(steps.times) * bool(system.touching.any()), len(system.touching)))
        find_depths(equations, steps, depths)
        settings = runner.tolerance, steps, kinks(system), runner.start, depths
        grade = 2.0 if system.settings.accuracy < SENSITIVITY_FINE else 3.0
        self._run = packed(Run(equations, variation, stepper, *settings, grade))
        self._ideals = IdealMotions()

    def _column(self, m: int) -> Column:
        return make_column(len(self.runner.start), self.runner.model, m, self.runner.implicit)

    def _changes(self, nt: int) -> Changes:
        model, count = self.runner.model, len(self._nearby)
        along = -(-count // DIRECTIONS) * DIRECTIONS
        coordinates, rates, accelerations = (np.full((nt, size_of(model), along), np.nan) for _ in range(3))
        return Changes(coordinates, rates, accelerations, np.full((nt, len(model.ends), WIDTH, along), np.nan))

    def at_steps(
        self, start: Array | None = None, remembered: Array | None = None, with_changes: bool = False
    ) -> Sensitivity:
        """Differentiate at the steps; see `differentiate`. With changes of coordinates and contacts if wanted.

        Columns of zeros precede fewer columns than a processor takes together.
        """
        nt, ny, nl = len(self.steps.times), len(self.runner.start), LATCHED * len(self.runner.model.ends)
        first = np.concatenate([np.eye(ny), self.start], axis=1) if start is None else np.asarray(start, np.float64)
        m = max(first.shape[1], LANES)
        column = self._column(m)
        column.before[:, m - first.shape[1] :] = first
        if remembered is not None:
            column.remembered[:, m - first.shape[1] :] = remembered
        out = AtSteps(
            np.full((nt, ny, m), np.nan), np.full((nt, nl, m), np.nan), np.zeros(nt, np.int64),
            np.full((nt, m), np.nan), self._changes(nt if with_changes else 0),
        )  # fmt: skip
        status, known = differentiate_run(self._run, packed(column), packed(out))
        return Sensitivity(*out, status, known)

    @cached_property
    def columns(self) -> Sensitivity:
        """Derivatives at the steps, NaN beyond the horizon: where errors of the run would change the state visibly."""
        found = self.at_steps(with_changes=True)
        ny, scale = len(self.runner.start), self.runner.scale
        own = found.states.shape[2] - len(self._nearby)  # columns of the state itself end there
        growth = np.abs(found.states[:, :, own - ny : own] * scale / scale[:, None]).max(axis=(1, 2), initial=0.0)
        accuracy = self.runner.system.settings.accuracy
        beyond = np.flatnonzero(accuracy * growth[: found.known] > SENSITIVITY_FELT)
        if not len(beyond):
            return found
        found.states[beyond[0] :], found.memory[beyond[0] :] = np.nan, np.nan
        for changes in found.changes:
            changes[beyond[0] :] = np.nan
        return found._replace(known=int(beyond[0]), status=_BEYOND)

    def states_and_changes(self, times: Array) -> tuple[States, Changes]:
        """Return coordinates and contacts at any times of the run, and their derivatives."""
        found, places = self.columns, np.searchsorted(self.steps.times, times, "right") - 1
        if np.array_equal(self.steps.times[places], times):
            states = States._make(self.runner.evaluate(self.steps, times))
            return states, Changes._make(one[places] for one in found.changes)
        states, out = self._states(len(times)), self._changes(len(times))
        column = packed(self._column(max(len(self._nearby), LANES)))
        at_steps = packed(AtSteps(found.states, found.memory, found.event, found.event_times, found.changes))
        given = self._run, column, found.known, at_steps, np.asarray(times, np.float64)
        differentiate_states(*given, packed(states), packed(out))
        return states, out

    def _states(self, nt: int) -> States:
        n, nc = size_of(self.runner.model), len(self.runner.model.ends)
        return States(np.empty((nt, n)), np.empty((nt, n)), np.empty((nt, n)), np.empty((nt, nc, WIDTH)))

    def outputs(self, times: Array, names: Sequence[str] | None = None) -> tuple[Columns, dict[str, Columns]]:
        """Compute outputs at any times of the run, and their derivatives by path."""
        table = OutputTable(self.runner.system, names, self._nearby, self._ideals)
        count = -(-len(times) // SENSITIVITY_AT_ONCE) or 1  # changes of all states take memory
        parts = [table.evaluate(part, *self.states_and_changes(part)) for part in np.array_split(times, count)]
        values = _joined([own for own, _ in parts])
        return values, {near.path: _joined([rates[near.path] for _, rates in parts]) for near in self._nearby}

    def derivatives(self, times: Array, names: Sequence[str] | None = None) -> Derivatives:
        """Return the derivatives of outputs, by default of all, at times of the run."""
        found = self.columns
        until = float(self.steps.times[found.known - 1]) if found.known else -np.inf
        with_values = Dense(partial(self.outputs, names=names), float(times[0]), float(times[-1]))
        return Derivatives(tuple(near.path for near in self._nearby), _STATUS[found.status], until, times, with_values)


def _joined(parts: Sequence[Columns]) -> Columns:
    """Join columns of parts of the times."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


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
        See `linkages.engines.compiled.run.runner.join`. The first time need not be zero.
    paths : sequence of str
        Dotted paths of np values, as for `linkages.System.replaced`.
    start : (ny, m) array, optional
        Derivatives of the first state; the last np columns are those of the values. Default: the identity, and the
        derivatives of the system's own start.
    memory : (nl, m) array, optional
        Derivatives of the latched states of contacts at the first state; default zero.

    Raises
    ------
    InputError
        If a path has no number or no derivative.
    """
    found = Differentiation(runner, steps, paths).at_steps(start, memory)
    m = len(runner.start) + len(paths) if start is None else start.shape[1]
    states, remembered, times = (one[..., -m:] for one in (found.states, found.memory, found.event_times))
    return found._replace(states=states, memory=remembered, event_times=times)
