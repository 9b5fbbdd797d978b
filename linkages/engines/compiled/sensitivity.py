"""Derivatives of a finished run with respect to its first state and to values of the system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.differentiated import differentiate_run, make_column
from linkages.engines.compiled.job import make_given
from linkages.engines.compiled.kinks import kinks
from linkages.engines.compiled.replay import Steps
from linkages.engines.compiled.runner import Runner
from linkages.engines.compiled.variation import vary
from linkages.integrate.stepper import make_stepper
from linkages.kernel import Array, Indices
from linkages.kernel.by_reference import packed
from linkages.outputs.registry import pack


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
    event : (nt,) array of int
        Contact that begins, counted from 1, or ends, less than 0; 0 without.
    event_times : (nt, m) array
        Derivatives of the events' times.
    status : int
        See `linkages.engines.compiled.differentiated`.
    known : int
        Number of times with derivatives.
    """

    times: Array
    states: Array
    memory: Array
    event: Indices
    event_times: Array
    status: int
    known: int


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
        Derivatives of the approach speeds at the first state; default zero, and for a contact that begins at the start
        of a run those of its speed.

    Returns
    -------
    Sensitivity

    Raises
    ------
    InputError
        If a path has no number or no derivative.
    """
    system, model = runner.system, runner.model
    variation, own = vary(system, paths, make_given(system, pack(system, ()), np.zeros((0, 2))))
    ny, nc, nt = len(runner.start), len(model.ends), len(steps.times)
    first = np.concatenate([np.eye(ny), own], axis=1) if start is None else np.asarray(start, dtype=np.float64)
    m = first.shape[1]
    column = make_column(ny, ny - len(model.free), nc, m, runner.implicit)
    column.before[:] = first
    if memory is not None:
        column.remembered[:] = memory
    states, remembered, times = np.full((nt, ny, m), np.nan), np.full((nt, nc, m), np.nan), np.full((nt, m), np.nan)
    event = np.zeros(nt, np.int64)
    status, count = differentiate_run(
        packed(runner.aside()),
        variation,
        packed(make_stepper(ny, len(model.free))),
        runner.tolerance,
        packed(steps),
        runner.landing,
        float(system.motion_rate),
        kinks(system),
        packed(column),
        states,
        remembered,
        event,
        times,
    )
    return Sensitivity(steps.times, states, remembered, event, times, status, count)
