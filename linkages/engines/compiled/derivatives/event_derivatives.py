"""Events, differentiated: the start and the end of a contact, and the samples of states.

A contact has the time of its start or end, its memory, and jumps of derivatives. A sample has none of these: its time
is given, and its formula before the sample determines the derivative of the next value.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.base.kernel import Array, kernel, lazy_kernel
from linkages.base.kernel.dual import DIRECTIONS, seeded, slope, with_number
from linkages.engines.compiled.derivatives.step_derivatives import Column, Run
from linkages.engines.compiled.derivatives.variation import (
    fill_solved,
    first_of,
    set_columns,
    set_over_time,
    set_results,
)
from linkages.engines.compiled.run.binding import next_sample, set_due
from linkages.engines.compiled.run.equations import derivatives
from linkages.engines.compiled.run.jacobian import inertia
from linkages.engines.compiled.run.model import Equations
from linkages.laws.contact.contact_forces import GRAZING
from linkages.laws.states import LATCHED, remembered_of
from linkages.mechanics.integrate.factor import back_substitute, factorise
from linkages.mechanics.planar.arrays import loads_of
from linkages.mechanics.planar.contact_memory import LATCHED_RESULTS, restore_latched
from linkages.mechanics.planar.contact_partials import DELTA, DEPTH_FROM, DEPTH_TO, LEAST, OUTPUTS, deeper
from linkages.mechanics.planar.contacts import (
    CLOSING,
    FIRST_RATE,
    PENETRATION,
    add_contact,
    contact_action,
    contact_motion,
)
from linkages.mechanics.planar.loads import is_due, sample_states
from linkages.mechanics.planar.newton_euler import generalised_force
from linkages.mechanics.planar.reactive_loads import add_efforts


@kernel(makes_arrays=True)
def begin_or_end(run: Run, t: float, y: Array, k: int, begins: bool, memory: Array, c: Column, times: Array) -> bool:
    """Take the columns through the start or end of contact k; fill the derivatives of its time.

    A new contact latches states at its start; ``memory`` is the record that has them. Where its force, and the friction
    in joints with it, or the rate of its states jumps, the columns jump by the difference of the derivatives times the
    change of the time.
    Returns False where a contact begins without speed: its existence then depends on the values.
    """
    equations, v, n, m = run.equations, run.variation, len(y), c.before.shape[1]
    work, w, clearance = equations.work, v.work.dynamics, equations.model.laws[k].clearance
    c.ended[0] = math.nan
    if begins:
        restore_latched(work.memory, memory, k)
        work.solved[0] = math.nan
    derivatives(equations, t, y, c.dy)
    closing, late = work.contacts[k, CLOSING], work.contacts[k, PENETRATION] / work.contacts[k, CLOSING]
    if begins and closing <= GRAZING:
        return False
    if begins:  # the rates before the contact, whose force may jump
        back = late + max(late, LEAST * clearance / closing)
        for i in range(n):
            c.y[i] = y[i] - back * c.dy[i]
        derivatives(equations, t - back, c.y, c.dy)
    efforts = work.reactive.efforts.copy()
    set_over_time(equations, v, t, y, c.dy)
    motion, _ = contact_motion(v.model.ends[k], w.pose, w.vel)
    _hold(equations, k, False)
    set_results(equations, v, k, motion)
    rising = np.zeros(LATCHED)
    for i in range(LATCHED):
        rising[i] = slope(v.work.results[LATCHED_RESULTS[i]], 0)
    derivatives(equations, t, y, c.dy)
    for i in range(len(efforts)):
        efforts[i] = work.reactive.efforts[i] - efforts[i]
    jump, forcing = np.zeros(OUTPUTS), np.zeros((len(c.own), m))
    _set_jump(equations, k, jump)
    _hold(equations, k, True)
    inertia(equations, t, y, c.mass[0])
    if not factorise(c.mass[0], c.pivots):
        return False
    # the state is a little beyond the event: the new forces act for that time already
    for last in range(m, 0, -DIRECTIONS):
        first = first_of(last)
        set_columns(equations, v, t, y, c.before, c.remembered, first, last)
        motion, arms = contact_motion(v.model.ends[k], w.pose, w.vel)
        push = v.work.push
        push[:] = 0.0
        for acts in (False, True):
            _hold(equations, k, acts)
            set_results(equations, v, k, motion)
            for i in range(OUTPUTS):
                push[i] += (late if begins == acts else -late) * v.work.results[i]
        later = with_number(v.work.results[DELTA] * (-1.0 / closing), 0.0)
        for j in range(first, last):
            times[j] = slope(later, j - first)
            if begins:
                for i in range(LATCHED):
                    latched = slope(v.work.results[LATCHED_RESULTS[i]], j - first)
                    c.remembered[k * LATCHED + i, j] = latched + rising[i] * times[j]
        for i in range(OUTPUTS):
            push[i] = with_number(push[i], 0.0) - jump[i] * later
        w.wrench[:] = 0.0
        w.tau[:] = 0.0
        v.work.rows[:] = 0.0
        add_contact(w.wrench, v.model.ends[k], w.pose, motion[0], motion[1], arms, push[0], push[1], push[2])
        for i in range(len(efforts)):
            v.work.reactive.efforts[i] = -efforts[i] * later
        add_efforts(v.model, v.work.reactive.efforts, w)
        generalised_force(v.model.bodies, w.pose, w.wrench, w.tau)
        fill_solved(equations, w.tau, v.work.rows, first, last, forcing)
        states = equations.model.law_states
        for i in range(len(states)):
            if states[i, 0] == k:
                for j in range(first, last):
                    rate = push[FIRST_RATE + states[i, 1]]
                    forcing[len(equations.model.free) + i, j] = slope(rate, j - first)
    for j in range(m):
        for row in range(len(c.own)):
            c.own[row] = forcing[row, j]
        back_substitute(c.mass[0], c.pivots, c.own)
        for i in range(len(c.own)):
            c.before[n - len(c.own) + i, j] += c.own[i]
    return True


@lazy_kernel(makes_arrays=True)
def take_samples(run: Run, k: int, c: Column) -> bool:
    """Take the columns through the samples of states at step k; returns False if there are none."""
    equations, v, steps = run.equations, run.variation, run.steps
    states, t, y, due = v.model.states, steps.times[k], steps.states[k].copy(), equations.work.due
    own, m = len(y) - len(states), c.before.shape[1]
    set_due(equations, steps.times[max(k - 1, 0)], k == 0 and t == 0.0)
    if not is_due(t, next_sample(equations, t)):
        return False
    for i in range(len(states)):
        if is_due(t, due[i]):
            y[own + i] = steps.states[k - 1, own + i] if k > 0 else run.start[own + i]
    w = v.work.dynamics
    for last in range(m, 0, -DIRECTIONS):
        first = first_of(last)
        set_columns(equations, v, t, y, c.before, c.remembered, first, last)
        sample_states(loads_of(v.model), due, seeded(t, -1), w.v, w.pose, w.vel)
        for i in range(len(states)):
            for j in range(first, last):
                c.before[own + i, j] = slope(w.v[len(w.v) - len(states) + i], j - first)
    c.ended[0] = math.nan
    return True


@kernel
def _hold(equations: Equations, k: int, acts: bool) -> None:
    """Hold contact k on the side on which it acts, or on the other."""
    bounds = equations.work.scratch.bounds[k]
    bounds[DEPTH_FROM], bounds[DEPTH_TO] = (0.0, math.inf) if acts else (-math.inf, 0.0)


@kernel
def _set_jump(equations: Equations, k: int, out: Array) -> None:
    """Fill ``out`` with the jump of contact k's action at its start or end, extrapolated to zero penetration."""
    model, work = equations.model, equations.work
    end, law, table, own = model.ends[k], model.laws[k], model.tables[k], work.memory[k]
    motion, _ = contact_motion(end, work.dynamics.pose, work.dynamics.vel)
    beyond = work.contacts[k, PENETRATION]
    depth = math.copysign(max(abs(beyond), LEAST * law.clearance), beyond)
    for place, weight in ((1.0, 2.0), (2.0, -1.0), (-1.0, -2.0), (-2.0, 1.0)):
        moved = deeper(end, motion, place * depth - beyond)
        found = contact_action(end, law, table, remembered_of(own), moved)
        for i in range(OUTPUTS):
            out[i] += weight * found[i]
