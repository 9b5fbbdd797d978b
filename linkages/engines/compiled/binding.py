"""The integrators bound to the equations of motion: runs, and states between their steps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from linkages.engines.compiled.equations import derivatives, outside, set_state, solve_state
from linkages.engines.compiled.kinks import set_sides, shortened
from linkages.engines.compiled.methods import attempt
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.projection import project_state
from linkages.engines.compiled.replay import STAGES, Steps, record_memory, recorded, replay
from linkages.integrate.driver import DONE, Options, Record, driver
from linkages.integrate.stepper import Stepper, copy
from linkages.kernel import Array, kernel, lazy_kernel
from linkages.kernel.simd import lane
from linkages.planar.closure import LOOSE, loop_error
from linkages.planar.contacts import (
    APPROACH,
    CLOSING,
    PENETRATION,
    advance_films,
    approach_at_start,
    has_history,
    start_films,
)

#: Status of a run whose journal left its film; `linkages.integrate.driver` has the others.
LEFT = 3
#: Status of a run whose loops came apart; its last state is the first one with open loops.
OPEN = 4


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
def settle(equations: Equations, t: float, y: Array, event: int) -> tuple[int, bool]:
    """Latch the approach speed of a contact that starts, close the loops, advance the films, check loops and films."""
    model, work = equations.model, equations.work
    if event >= 0 and work.modes[event] > 0:
        work.memory[event, APPROACH] = work.contacts[event, CLOSING]
    changed = False
    if len(model.rows):
        changed = project_state(equations, y)
        if loop_error(model.rows, work.dynamics.pose) > LOOSE * model.size:
            return OPEN, changed
    if outside(model, work) >= 0:
        return LEFT, changed
    if has_history(work.memory):
        advance_films(model.ends, model.laws, model.tables, work.memory, t, work.dynamics.pose, work.dynamics.vel)
        work.solved[0] = math.nan
        changed = True
    return DONE, changed


@lazy_kernel
def divide(equations: Equations, s: Stepper, t: float, h: float, y: Array, kinks: Array) -> float:
    """Shorten an attempted step to end at its first kink, see `linkages.engines.compiled.kinks`."""
    set_sides(equations, s, t, h, y, kinks)
    return shortened(equations, s, t, h, y, kinks)


@lazy_kernel
def _start_films(equations: Equations, t: float, y: Array) -> None:
    """Set place and time of the films with history at the start of a run, at t = 0 their content too."""
    model, work = equations.model, equations.work
    set_state(model, work, t, y)
    start_films(model.ends, model.laws, model.tables, work.memory, t, work.dynamics.pose, work.dynamics.vel, t == 0.0)


@kernel
def _observe(equations: Equations, stepper: Stepper, t: float, y: Array, row: Array) -> None:
    """Record the contacts' memory and, in a longer row, the increments of the stages of the step that ends here."""
    memory = equations.work.memory
    record_memory(memory, row)
    first = recorded(memory)
    for i in range((len(row) - first) // STAGES):
        for stage in range(STAGES):
            row[first + STAGES * i + stage] = lane(stepper.z[i], stage)


def runner(observe: Any) -> Any:
    """Make the function that runs from (t, y), and keeps the work's memory and modes of the contacts up to date.

    `observe` fills the columns of the record, see `linkages.integrate.driver`.
    """
    drive = driver(derivatives, attempt, signs, settle, observe, divide)

    @kernel
    def run(
        equations: Equations, observer: Any, s: Stepper, tolerance: Array, t: float, y: Array, width: int,
        options: Options,
    ) -> Record:  # fmt: skip
        model, work = equations.model, equations.work
        if has_history(work.memory):
            _start_films(equations, t, y)
        if t == 0.0:
            for k in range(len(model.ends)):
                work.kinked.sides[k] = math.nan
            solve_state(equations, t, y)
            for k in range(len(model.ends)):
                delta, closing = work.contacts[k, PENETRATION], work.contacts[k, CLOSING]
                work.modes[k] = 1 if model.touching[k] and (delta > 0.0 or (delta == 0.0 and closing >= 0.0)) else -1
                if work.modes[k] > 0:
                    work.memory[k, APPROACH] = approach_at_start(delta, closing, options.landing[k])
        return drive(equations, observer, s, tolerance, t, y, work.modes, width, options)

    return run


_run = runner(_observe)


@kernel
def run(
    equations: Equations, stepper: Stepper, tolerance: Array, t: float, y: Array, options: Options, stages: bool
) -> Record:
    """Run from (t, y), and record the contacts' memory; with ``stages``, increments of an implicit method's stages."""
    width = recorded(equations.work.memory) + (STAGES * len(y) if stages else 0)
    return _run(equations, stepper, stepper, tolerance, t, y, width, options)


@kernel
def evaluate(
    equations: Equations,
    stepper: Stepper,
    tolerance: Array,
    steps: Steps,
    times: Array,
    q: Array,
    v: Array,
    a: Array,
    contacts: Array,
) -> None:
    """Fill q, v, a (nt, n) and contacts (nt, nc, WIDTH) at any times of a run."""
    y, w = np.empty(steps.states.shape[1]), equations.work.dynamics
    for i in range(len(times)):
        replay(equations, stepper, tolerance, steps, times[i], y)
        copy(w.q, q[i])
        copy(w.v, v[i])
        copy(w.a, a[i])
        for c in range(contacts.shape[1]):
            copy(equations.work.contacts[c], contacts[i, c])
