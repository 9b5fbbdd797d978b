"""Many runs of one linkage in compiled code: numbers are written, the run is integrated and summarised."""

from __future__ import annotations

import math

import numpy as np

from linkages.engines.budget import WINDOW
from linkages.engines.compiled.binding import OPEN, runner
from linkages.engines.compiled.equations import is_solved, solve_state
from linkages.engines.compiled.job import ACCURACY, END, LEAST, LONGEST, MOST, Job
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.replay import Steps, record_memory, recorded
from linkages.engines.compiled.statistics import asked, knows_outputs, look, summarise
from linkages.integrate.driver import DONE, PAUSED, Options, Record
from linkages.integrate.stepper import copy
from linkages.kernel import Array, Indices, kernel

#: Further statuses of a row, after the ones of `linkages.engines.compiled.binding`: the ideal linkage of an output does
#: not close; the batch was interrupted.
NO_IDEAL, STOPPED = 5, 6


@kernel
def restore(memory: Indices, initial: Indices, columns: Indices, words: Indices) -> None:
    """Restore a `linkages.kernel.block.Block`, with these words at some places of its memory."""
    for k in range(len(memory)):
        memory[k] = initial[k]
    for k in range(len(columns)):
        memory[columns[k]] = words[k]


@kernel
def _observe(equations: Equations, job: Job, t: float, y: Array, row: Array) -> None:
    """Record the contacts' memory, and the outputs of the state where they can be known."""
    record_memory(equations.work.memory, row)
    if knows_outputs(job) and asked(job, t, math.inf):
        if not is_solved(equations.work, t, y):
            solve_state(equations, t, y)
        look(job, t, row[recorded(equations.work.memory) :])


_run = runner(_observe)


@kernel
def _joined(before: Steps, table: Array, record: Record, count: int) -> tuple[Steps, Array]:
    """Append the first steps of a record, whose first state is the last one before, and their outputs."""
    n, first = len(before.times), min(len(before.times), 1)
    total = n + count - first
    times = np.empty(total)
    nm, states = before.memory.shape[1], np.empty((total, record.states.shape[1]))
    memory, outputs = np.empty((total, nm)), np.empty((total, table.shape[1]))
    for i in range(n):
        times[i] = before.times[i]
        copy(before.states[i], states[i])
        copy(before.memory[i], memory[i])
        copy(table[i], outputs[i])
    for i in range(first, count):
        k = n + i - first
        times[k] = record.times[i]
        copy(record.states[i], states[k])
        copy(record.observed[i, :nm], memory[k])
        copy(record.observed[i, nm:], outputs[k])
    return Steps(times, states, memory), outputs


@kernel
def integrate(job: Job, stop: Indices, reached: Array) -> tuple[Steps, Array, int, int]:
    """Run a job as `linkages.engines.compiled.simulation.simulate` does.

    Returns steps, outputs at them (nt, no) where they are known during the run, status and number of steps.

    The run pauses after every `WINDOW` steps: it writes the time into ``reached`` (1,), and ends there if its steps are
    spent. It ends after the present step as soon as ``stop`` (1,) is set.
    """
    limits, nm, no = job.limits, recorded(job.equations.work.memory), len(job.outputs)
    steps, table = Steps(np.empty(0), np.empty((0, len(job.start))), np.empty((0, nm))), np.empty((0, no))
    y, t, before, first, total = job.start, 0.0, 0.0, 0.0, 0
    while True:
        options = Options(
            limits[END], first, limits[LONGEST], WINDOW, 0.0, job.landing, job.kinks, limits[ACCURACY], stop
        )
        record = _run(job.equations, job, job.stepper, job.tolerance, t, y, nm + no, options)
        count = len(record.times)
        if record.status == OPEN and count > 1:
            count -= 1
        steps, table = _joined(steps, table, record, count)
        total += record.steps
        t, y, first = record.times[count - 1], record.states[count - 1], record.next_step
        if record.status == PAUSED and stop[0]:
            return steps, table, STOPPED, total
        if record.status != PAUSED or total >= limits[MOST] or t - before < limits[LEAST]:
            return steps, table, record.status, total
        before = reached[0] = t


@kernel
def run_rows(
    job: Job,
    memory: Indices,
    initial: Indices,
    columns: Indices,
    words: Indices,
    stop: Indices,
    found: Array,
    ended: Array,
) -> None:
    """Run the designs of some rows.

    Parameters
    ----------
    job : Job
        In a `linkages.kernel.block.Block`.
    memory, initial : (n,) arrays
        Of the block.
    columns : (k,) array
        Indices of the memory at which the designs differ.
    words : (m, k) array
        Their values in each row.
    stop : (1,) array
        Not zero as soon as the batch is to end.
    found : (m, nw, no, ns) array
        Filled with statistics; NaN for windows of which a failed run did not reach the end.
    ended : (m, 3) array
        Filled with the status of each row, the time that the run has reached [s], and the number of steps.
    """
    for i in range(len(words)):
        if stop[0]:
            return
        restore(memory, initial, columns, words[i])
        steps, table, status, total = integrate(job, stop, ended[i, 1:2])
        if status == STOPPED:
            return
        end = steps.times[len(steps.times) - 1]
        restore(memory, initial, columns, words[i])
        if not summarise(job, steps, table, math.inf if status == DONE else end, found[i]):
            status, end = NO_IDEAL, 0.0
            found[i] = math.nan
        ended[i, 1], ended[i, 2] = end, total
        ended[i, 0] = status
