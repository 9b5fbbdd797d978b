"""The integrators bound to the equations of motion: runs, and states between their steps."""

from __future__ import annotations

import math

from linkages.base.kernel import Array, Indices, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.simd import lane
from linkages.engines.budget import WINDOW
from linkages.engines.compiled.run.equations import derivatives, is_solved, outside, set_state, solve_state
from linkages.engines.compiled.run.job import ACCURACY, END, LEAST, LONGEST, MOST, Job
from linkages.engines.compiled.run.kinks import set_sides, shortened
from linkages.engines.compiled.run.methods import attempt
from linkages.engines.compiled.run.model import Equations
from linkages.engines.compiled.run.replay import STAGES, Steps, project_state, replay
from linkages.engines.compiled.run.sampling import asked, knows_outputs, look
from linkages.mechanics.integrate.driver import DONE, PAUSED, Options, Record, driver, joined, with_status, without_last
from linkages.mechanics.integrate.stepper import Stepper, copy, restart
from linkages.mechanics.planar.arrays import loads_of
from linkages.mechanics.planar.closure import LOOSE, loop_error
from linkages.mechanics.planar.contact_memory import (
    advance_cells,
    any_cells,
    fill_landing,
    latch,
    latch_at_start,
    longest_step,
    record_memory,
    recorded,
    start_cells,
)
from linkages.mechanics.planar.contacts import CLOSING, PENETRATION
from linkages.mechanics.planar.loads import is_due, next_due, sample_states
from linkages.mechanics.planar.reactive_loads import is_jammed

#: Status of a run whose journal left its film; `linkages.mechanics.integrate.driver` has the others.
LEFT = 3
#: Status of a run whose loops came apart; its last state is the first one with open loops.
OPEN = 4
#: Status of a run that ends where loads that depend on joint forces have no solution.
JAMMED = 5


@kernel
def signs(equations: Equations, g: Array, dg: Array) -> None:
    """Event functions: the penetrations of contacts that can touch."""
    model, work = equations.model, equations.work
    for k in range(len(model.ends)):
        g[k], dg[k] = -1.0, 0.0
        if model.touching[k]:
            g[k] = work.contacts[k, PENETRATION]
            dg[k] = work.contacts[k, CLOSING]


@kernel
def verdict(equations: Equations) -> int:
    """Check the state of the work: DONE, OPEN with open loops, LEFT with a journal outside its film."""
    model, work = equations.model, equations.work
    if len(model.rows) and loop_error(model.rows, work.dynamics.pose) > LOOSE * model.size:
        return OPEN
    return LEFT if outside(model, work) >= 0 else DONE


@lazy_kernel
def check(equations: Equations, t: float, y: Array) -> int:
    """Check a state; see `verdict`."""
    solve_state(equations, t, y)
    return verdict(equations)


@kernel
def settle(equations: Equations, t: float, y: Array, event: int) -> tuple[int, bool]:
    """Latch states of a contact that starts, sample states, close loops, check the state, advance cells of contacts."""
    model, work = equations.model, equations.work
    if event >= 0 and work.modes[event] > 0:
        latch(work.memory[event], work.contacts[event])
    changed = False
    if is_due(t, next_sample(equations, t)):
        _sample(equations, t, y)
        changed = True
    if len(model.rows):
        changed = project_state(equations, y) or changed
    status = verdict(equations)
    if status != DONE:
        return status, changed
    if any_cells(work.memory):
        advance_cells(model.ends, model.laws, model.tables, work.memory, t, work.dynamics.pose, work.dynamics.vel)
        work.solved[0] = math.nan
        changed = True
    return DONE, changed


@inlined_kernel
def next_sample(equations: Equations, t: float) -> float:
    """Return the time of the next sample of a state; infinite without sampled states."""
    earliest = math.inf
    for due in equations.work.due:
        earliest = min(earliest, due)
    return earliest


@inlined_kernel
def _longest_step(equations: Equations) -> float:
    """Return the longest next step that the cells of contacts allow [s]; infinite without them."""
    return longest_step(equations.model.ends, equations.work.memory)


@lazy_kernel
def _sample(equations: Equations, t: float, y: Array) -> None:
    """Give the states that are due at time t their next values, and solve the equations with these."""
    model, work = equations.model, equations.work
    w, nz = work.dynamics, len(model.states)
    solve_state(equations, t, y)
    sample_states(loads_of(model), work.due, t, w.v, w.pose, w.vel)
    for k in range(nz):
        y[len(y) - nz + k] = w.v[len(w.v) - nz + k]
    set_due(equations, t, False)
    solve_state(equations, t, y)


@lazy_kernel
def set_due(equations: Equations, t: float, at_start: bool) -> None:
    """Set the times of the next samples after time t; at the start of a run the first ones are at t = 0."""
    states, due = equations.model.states, equations.work.due
    for k in range(len(states)):
        period = states[k].period
        if period > 0.0:
            due[k] = 0.0 if at_start else next_due(t, period)


@lazy_kernel
def divide(equations: Equations, s: Stepper, t: float, h: float, y: Array, kinks: Array) -> float:
    """Shorten an attempted step to end at its first kink, see `linkages.engines.compiled.run.kinks`."""
    set_sides(equations, s, t, h, y, kinks)
    return shortened(equations, s, t, h, y, kinks)


@lazy_kernel
def _start_cells(equations: Equations, t: float, y: Array) -> None:
    """Set place and time of the cells of contacts at the start of a run, at t = 0 their content too."""
    model, work = equations.model, equations.work
    set_state(model, work, t, y)
    start_cells(model.ends, model.laws, model.tables, work.memory, t, work.dynamics.pose, work.dynamics.vel, t == 0.0)


@kernel
def _observe(equations: Equations, job: Job, t: float, y: Array, row: Array) -> None:
    """Record the contacts' memory; then the outputs, or increments of the stages of the step that ends here.

    Outputs are recorded at times within windows, if they are known during the run.
    """
    memory = equations.work.memory
    record_memory(memory, row)
    first = recorded(memory)
    if len(job.outputs):
        _observe_outputs(job, t, y, row[first:])
        return
    for i in range((len(row) - first) // STAGES):
        for stage in range(STAGES):
            row[first + STAGES * i + stage] = lane(job.stepper.z[i], stage)


@kernel
def _observe_outputs(job: Job, t: float, y: Array, out: Array) -> None:
    """Fill the outputs, if they are known during the run and their time is within a window."""
    if knows_outputs(job) and asked(job, t, math.inf):
        if not is_solved(job.equations.work, t, y):
            solve_state(job.equations, t, y)
        look(job, t, out)


_drive = driver(derivatives, attempt, signs, settle, _observe, next_sample, _longest_step, divide)


@kernel
def run(
    job: Job, kinks: Array, stages: bool, t: float, y: Array, first: float, most: int, end: float, stop: Indices
) -> Record:
    """Run from (t, y), at most up to the last step with closed loops; keep the contacts' memory and modes up to date.

    ``kinks`` (nc + nf, KINKS), or none, are those at which steps end. With `stages` the increments of an implicit
    method's stages are recorded, for a job without outputs. The first step to try [s] is 0 if the driver is to choose
    it. The run pauses after so many steps, or after the present one as soon as ``stop`` (1,) is not zero.
    """
    equations, limits = job.equations, job.limits
    model, work = equations.model, equations.work
    fill_landing(model.laws, model.size, job.landing)
    if any_cells(work.memory):
        _start_cells(equations, t, y)
    if len(model.states):
        set_due(equations, t, t == 0.0)
    if t == 0.0:
        work.kinked.sides[:] = math.nan
        solve_state(equations, t, y)
        for k in range(len(model.ends)):
            delta, closing = work.contacts[k, PENETRATION], work.contacts[k, CLOSING]
            work.modes[k] = 1 if model.touching[k] and (delta > 0.0 or (delta == 0.0 and closing >= 0.0)) else -1
            if work.modes[k] > 0:
                latch_at_start(work.memory[k], work.contacts[k], job.landing[k])
    width = recorded(work.memory) + len(job.outputs) + (STAGES * len(y) if stages else 0)
    options = Options(end, first, limits[LONGEST], most, 0.0, job.landing, kinks, limits[ACCURACY], stop)
    record = _drive(equations, job, job.stepper, job.tolerance, t, y, work.modes, width, options)
    if record.status != PAUSED and is_jammed(work.reactive):
        return with_status(record, JAMMED)
    return without_last(record) if record.status == OPEN and len(record.times) > 1 else record


@kernel
def integrate(job: Job, stop: Indices, reached: Array) -> Record:
    """Run a job from its start, as `linkages.engines.compiled.simulation.simulate` does.

    The run pauses after every `WINDOW` steps, or fewer if it may have fewer: it writes the time into ``reached`` (1,),
    and ends there, as paused, if its steps are spent. It ends after the present step as soon as ``stop`` (1,) is set.
    """
    limits, before = job.limits, 0.0
    window = min(WINDOW, int(limits[MOST]))
    record = run(job, job.kinks, False, 0.0, job.start, 0.0, window, limits[END], stop)
    while record.status == PAUSED and not stop[0]:
        last = len(record.times) - 1
        t, y = record.times[last], record.states[last]
        if record.steps >= limits[MOST] or t - before < limits[LEAST]:
            break
        before = reached[0] = t
        record = joined(record, run(job, job.kinks, False, t, y, record.next_step, window, limits[END], stop))
    return record


@kernel
def evaluate(job: Job, steps: Steps, times: Array, q: Array, v: Array, a: Array, contacts: Array) -> None:
    """Fill q, v, a (nt, n) and contacts (nt, nc, WIDTH) at any times of a run."""
    equations, y, w = job.equations, job.y, job.equations.work.dynamics
    restart(job.stepper)
    for i in range(len(times)):
        replay(equations, job.stepper, job.tolerance, steps, times[i], y)
        copy(w.q, q[i])
        copy(w.v, v[i])
        copy(w.a, a[i])
        for c in range(contacts.shape[1]):
            copy(equations.work.contacts[c], contacts[i, c])
