"""Runs of many designs, and their statistics: extremes, mean and rms of outputs over windows, values at their ends.

`linkages.results.extremes` gives the same numbers, to the last bit, for a trajectory with the same outputs.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, Indices, kernel
from linkages.base.kernel.by_reference import reference
from linkages.engines.compiled.run.binding import integrate, next_sample, set_due
from linkages.engines.compiled.run.equations import solve_state
from linkages.engines.compiled.run.job import ACCURACY, Job
from linkages.engines.compiled.run.replay import Steps, remember
from linkages.engines.compiled.run.sampling import Sampler, asked, knows_outputs, look, sample, tabulate_run
from linkages.mechanics.integrate import peak_search
from linkages.mechanics.integrate.driver import DONE, PAUSED
from linkages.mechanics.integrate.stepper import copy
from linkages.mechanics.planar.contact_memory import recorded
from linkages.mechanics.planar.loads import is_due

#: Statistics of each window and output. To add one: its name here, at the end, and its formula in `summarise`.
STATISTICS = ("minimum", "maximum", "time_of_minimum", "time_of_maximum", "mean", "rms", "last")

#: Further status of a row, after the ones of `linkages.engines.compiled.run.binding`: the ideal linkage of an output
#: does not close.
NO_IDEAL = 5


@kernel(makes_arrays=True)
def summarise(job: Job, steps: Steps, outputs: Array, valid: float, out: Array) -> bool:
    """Fill `STATISTICS` (nw, no, ns) of a run over the job's windows; returns False if the ideal linkage is open.

    The job's contacts remember nothing. The outputs (nt, no) at the steps are filled here unless `knows_outputs`.
    Windows that do not end before the time `valid` [s] get NaN.
    """
    sampler = reference(Sampler(job, steps))
    if not knows_outputs(job):
        for i in range(len(steps.times)):
            if not asked(job, steps.times[i], valid):
                continue
            remember(job.equations, steps, i)
            solve_state(job.equations, steps.times[i], steps.states[i])
            if not look(job, steps.times[i], outputs[i]):
                return False
    no, search = len(job.outputs), np.empty((3, 3))
    times, values = np.empty(len(steps.times) + 4), np.empty((no, len(steps.times) + 4))
    sides, jumping = np.empty(2 * len(times)), np.empty((no, 2 * len(times)))
    middles = np.empty((no, len(sides)))
    for m in range(len(job.windows)):
        if not job.windows[m, 1] < valid:
            out[m] = math.nan
            continue
        count = _fill(sampler, outputs, job.windows[m, 0], job.windows[m, 1], times, values)
        all_count = _fill_sides(sampler, times[:count], values, sides, jumping) if count > 0 else 0
        if all_count > 0:
            _averages(sampler, sides[:all_count], jumping[:, :all_count], middles[:, : all_count - 1], out[m])
        for k in range(no if all_count > 0 else 0):
            out[m, k, 6] = values[k, count - 1]
        count = _add_middles(sampler, times, values, count)
        if count < 0:
            return False
        for k in range(no):
            line = out[m, k]
            line[0], line[2] = _extreme(sampler, k, -1.0, times[:count], values[k, :count], search)
            line[1], line[3] = _extreme(sampler, k, 1.0, times[:count], values[k, :count], search)
    return True


@kernel
def _fill(sampler: Sampler, outputs: Array, start: float, end: float, times: Array, values: Array) -> int:
    """Fill the samples of a window: outputs (nt, no) at its steps, and those at its ends; return their number n, or -1.

    -1 if the ideal linkage is open.
    """
    grid, count = sampler.steps.times, 0
    begin_at, end_at = np.searchsorted(grid, start), np.searchsorted(grid, end, side="right")
    if begin_at == end_at or grid[begin_at] > start:
        if not _put(sampler, start, times, values, count):
            return -1
        count = 1
    for i in range(begin_at, end_at):
        if count and grid[i] == times[count - 1]:  # an event without a step: the state after it counts
            count -= 1
        times[count] = grid[i]
        copy(outputs[i], values[:, count])
        count += 1
    if times[count - 1] < end:
        if not _put(sampler, end, times, values, count):
            return -1
        count += 1
    return count


@kernel
def _fill_sides(sampler: Sampler, times: Array, values: Array, sides: Array, out: Array) -> int:
    """Fill samples, and those just before the sampling instants of states, where outputs jump; return how many.

    Those before have the times of the instants. -1 if the ideal linkage is open.
    """
    equations, count = sampler.job.equations, 0
    for i in range(len(times)):
        if i > 0 and len(equations.model.states):
            set_due(equations, times[i - 1], False)
            if is_due(times[i], next_sample(equations, times[i])):
                if not _put(sampler, peak_search.BEFORE * times[i], sides, out, count):
                    return -1
                sides[count] = times[i]
                count += 1
        sides[count] = times[i]
        copy(values[:, i], out[:, count])
        count += 1
    return count


@kernel(makes_arrays=True)
def _averages(sampler: Sampler, times: Array, values: Array, middles: Array, out: Array) -> None:
    """Fill mean and root mean square of outputs (no, ns) from samples (n,) and (no, n).

    Outputs in the middle of intervals are computed where one output needs them: ``middles`` (no, n - 1).
    """
    limit, known = sampler.job.limits[ACCURACY], np.zeros(len(times), np.int64)
    marks, more, found = np.empty(len(times) - 1, np.int64), np.empty(4 * len(times)), np.empty(4 * len(times))
    for k in range(len(values)):
        if peak_search.doubtful(times, values[k], limit, marks) > 0:
            _fill_middles(sampler, times, marks, known, middles)
        count = peak_search.add_middles(times, values[k], marks, middles[k], more, found)
        out[k, 4] = peak_search.average(more[:count], found[:count], False)
        out[k, 5] = peak_search.average(more[:count], found[:count], True)


@kernel
def _fill_middles(sampler: Sampler, times: Array, marks: Indices, known: Indices, middles: Array) -> None:
    """Fill the outputs in the middle of the marked intervals that are not known yet; NaN with an open ideal linkage."""
    for i in range(len(marks)):
        if marks[i] == 0 or known[i] == 1:
            continue
        known[i] = 1
        closed = sample(sampler, peak_search.middle(times, i), sampler.job.row)
        for k in range(len(middles)):
            middles[k, i] = sampler.job.row[k] if closed else math.nan


@kernel
def _put(sampler: Sampler, t: float, times: Array, values: Array, place: int) -> bool:
    """Evaluate the outputs at a time, for a place among the samples; returns False with an open ideal linkage."""
    if not sample(sampler, t, sampler.job.row):
        return False
    times[place] = t
    copy(sampler.job.row, values[:, place])
    return True


@kernel
def _add_middles(sampler: Sampler, times: Array, values: Array, count: int) -> int:
    """Add samples in the middle of the last and of the first interval: their maxima have samples on both sides then.

    Returns the number of samples, -1 with an open ideal linkage.
    """
    if count < 2:
        return count
    for place in (count - 1, 1):
        for i in range(count, place, -1):
            times[i] = times[i - 1]
            copy(values[:, i - 1], values[:, i])
        if not _put(sampler, 0.5 * (times[place - 1] + times[place + 1]), times, values, place):
            return -1
        count += 1
    return count


@kernel(makes_arrays=True)
def _extreme(sampler: Sampler, k: int, sign: float, times: Array, values: Array, search: Array) -> tuple[float, float]:
    """Find the extreme of output k, the maximum of sign times it, from its samples; return it and its time."""
    places, tops = np.empty(peak_search.MOST, np.int64), np.empty(peak_search.MOST)
    best = 0
    for i in range(len(times)):
        if sign * values[i] > sign * values[best]:
            best = i
    when, highest, floor = times[best], sign * values[best], -math.inf
    for c in range(peak_search.candidates(times, values, sign, places, tops)):
        if c < peak_search.FEW or tops[c] > highest:
            peak_search.begin(search, times, values, sign, places[c])
            _refine(sampler, k, sign, floor, search)
            if search[peak_search.VALUES, 1] > (peak_search.above(highest) if c else highest):
                when, highest = search[peak_search.TIMES, 1], search[peak_search.VALUES, 1]
            if c == 0:
                floor = peak_search.above(highest)
    return sign * highest, when


@kernel
def _refine(sampler: Sampler, k: int, sign: float, floor: float, search: Array) -> None:
    """Go through the search for a maximum of sign times output k, unless it turns out to be below the floor."""
    t = peak_search.next_time(search, floor)
    while t == t and sample(sampler, t, sampler.job.row):
        peak_search.take(search, t, sign * sampler.job.row[k])
        t = peak_search.next_time(search, floor)


@kernel
def restore(memory: Indices, initial: Indices, columns: Indices, words: Indices) -> None:
    """Restore a `linkages.base.kernel.block.Block`, with these words at some places of its memory."""
    for k in range(len(memory)):
        memory[k] = initial[k]
    for k in range(len(columns)):
        memory[columns[k]] = words[k]


@kernel(makes_arrays=True)
def run_rows(
    job: Job,
    memory: Indices,
    initial: Indices,
    columns: Indices,
    words: Indices,
    stop: Indices,
    times: Array,
    found: Array,
    sampled: Array,
    ended: Array,
) -> None:
    """Run the designs of m rows, until ``stop`` (1,) is set.

    The job is in a `linkages.base.kernel.block.Block`, whose memory and initial memory are (n,) arrays; the designs
    differ at the indices ``columns`` (k,) of it, and have the values ``words`` (m, k). Fills ``found`` (m, nw, no, ns)
    with statistics, NaN for windows of which a failed run did not reach the end; ``sampled`` (m, nt, no) with outputs
    at increasing ``times`` (nt,), NaN at those that it did not reach; ``ended`` (m, 3) with the status of each row, the
    time that the run has reached [s], and the number of steps.
    """
    for i in range(len(words)):
        if stop[0]:
            return
        restore(memory, initial, columns, words[i])
        record = integrate(job, stop, ended[i, 1:2])
        if record.status == PAUSED and stop[0]:
            return
        # what contacts remember, and the outputs: a replay takes further columns for stages of an implicit method
        first, status = recorded(job.equations.work.memory), record.status
        steps, outputs = (
            Steps(record.times, record.states, record.observed[:, :first].copy()),
            record.observed[:, first:],
        )
        end = steps.times[len(steps.times) - 1]
        restore(memory, initial, columns, words[i])
        if not summarise(job, steps, outputs, math.inf if status == DONE else end, found[i]):
            status, end = NO_IDEAL, 0.0
            found[i] = math.nan
        known = np.searchsorted(times, end, side="right")
        sampled[i, known:] = math.nan
        if not tabulate_run(job, steps, times[:known], sampled[i, :known]):
            sampled[i] = math.nan
        ended[i, 0], ended[i, 1], ended[i, 2] = status, end, record.steps
