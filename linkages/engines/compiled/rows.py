"""Many runs of one linkage in compiled code: numbers are written, the run is integrated and summarised."""

from __future__ import annotations

import math

from linkages.engines.compiled.binding import integrate
from linkages.engines.compiled.job import Job
from linkages.engines.compiled.replay import Steps
from linkages.engines.compiled.statistics import summarise
from linkages.integrate.driver import DONE, PAUSED
from linkages.kernel import Array, Indices, kernel

#: Further status of a row, after the ones of `linkages.engines.compiled.binding`: the ideal linkage of an output does
#: not close.
NO_IDEAL = 5


@kernel
def restore(memory: Indices, initial: Indices, columns: Indices, words: Indices) -> None:
    """Restore a `linkages.kernel.block.Block`, with these words at some places of its memory."""
    for k in range(len(memory)):
        memory[k] = initial[k]
    for k in range(len(columns)):
        memory[columns[k]] = words[k]


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
        record = integrate(job, stop, ended[i, 1:2])
        if record.status == PAUSED and stop[0]:
            return
        steps, status = Steps(record.times, record.states, record.observed), record.status
        end = steps.times[len(steps.times) - 1]
        restore(memory, initial, columns, words[i])
        if not summarise(job, steps, math.inf if status == DONE else end, found[i]):
            status, end = NO_IDEAL, 0.0
            found[i] = math.nan
        ended[i, 0], ended[i, 1], ended[i, 2] = status, end, record.steps
