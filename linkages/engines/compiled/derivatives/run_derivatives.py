"""A finished run, differentiated at its steps and at any times."""

from __future__ import annotations

import math
from typing import NamedTuple

from linkages.base.kernel import Array, Indices, kernel
from linkages.base.kernel.dual import DIRECTIONS, put_slopes
from linkages.engines.compiled.derivatives.event_derivatives import begin_or_end, take_samples
from linkages.engines.compiled.derivatives.step_derivatives import Column, Run, advance, close_columns
from linkages.engines.compiled.derivatives.variation import fill_residual, set_columns, set_contacts
from linkages.engines.compiled.run.equations import found_derivatives, solve_state
from linkages.engines.compiled.run.jacobian import inertia
from linkages.engines.compiled.run.kinks import set_bounds, set_sides_here
from linkages.engines.compiled.run.replay import remember, replay
from linkages.mechanics.integrate.factor import back_substitute, factorise
from linkages.mechanics.integrate.stepper import copy, restart
from linkages.mechanics.planar.contact_memory import is_latched_anew
from linkages.mechanics.planar.motion import last_start

#: Status of the columns after a step: known; not known, because a step was singular or Newton's method failed; not
#: known, because a contact began without speed.
KNOWN, SINGULAR, GRAZED = 0, 1, 2


class Changes(NamedTuple):
    """Derivatives of a run at nt times, n coordinates, along np values, in a multiple of `DIRECTIONS`."""

    coordinates: Array  # (nt, n, np)
    rates: Array
    accelerations: Array
    contacts: Array  # (nt, nc, WIDTH, np)


class States(NamedTuple):
    """States of a run at nt times: n coordinates, their rates and accelerations, and contacts."""

    coordinates: Array  # (nt, n)
    rates: Array
    accelerations: Array
    contacts: Array  # (nt, nc, WIDTH)


class AtSteps(NamedTuple):
    """Derivatives of a run at its nt steps: m columns, ny entries of the state, nl latched states.

    Attributes
    ----------
    states : (nt, ny, m) array
        Derivatives of the state at fixed time, after the event or the projection at that time.
    memory : (nt, nl, m) array
        Derivatives of the latched states of contacts.
    event : (nt,) array of int
        Contact that begins, counted from 1, or ends, less than 0; 0 without.
    event_times : (nt, m) array
        Derivatives of the events' times.
    changes : Changes
        Derivatives of coordinates and contacts along the values, if they are wanted; of no time otherwise.
    """

    states: Array
    memory: Array
    event: Indices
    event_times: Array
    changes: Changes


@kernel
def differentiate_run(run: Run, c: Column, out: AtSteps) -> tuple[int, int]:
    """Differentiate a run from the columns at its start in ``before`` and ``remembered``.

    Returns
    -------
    status : int
    count : int
        Number of times at which the columns are known.
    """
    equations, steps = run.equations, run.steps
    nt, nc, model, work = len(steps.times), len(equations.model.ends), equations.model, equations.work
    wanted = len(out.changes.coordinates) == nt
    for k in range(nt):
        t, y = steps.times[k], steps.states[k]
        remember(equations, steps, max(k - 1, 0))
        if k > 0 and not advance(run, c, k - 1, t):
            return SINGULAR, k
        smooth = k > 0 and equations.implicit  # the last stage is at the end
        if len(model.states) and take_samples(run, k, c):
            smooth = False
        if k > 0 and len(model.rows):
            solve_state(equations, t, y)
            if not work.dynamics.interpolated[0] > 0.0:
                close_columns(equations, run.variation, t, y, c)
                smooth = False
        for i in range(nc if k > 0 and len(run.depths) else 0):
            before, now = run.depths[k - 1, i], run.depths[k, i]
            begins = now > 0.0 and (before <= 0.0 or is_latched_anew(steps.memory[k], steps.memory[k - 1], i))
            if begins or now < 0.0 < before:
                if not begin_or_end(run, t, y, i, begins, steps.memory[k], c, out.event_times[k]):
                    return GRAZED, k
                out.event[k] = i + 1 if begins else -i - 1
                smooth = False
        for i in range(len(c.before)):
            copy(c.before[i], out.states[k, i])
        for i in range(len(c.remembered)):
            copy(c.remembered[i], out.memory[k, i])
        if wanted:
            remember(equations, steps, k)
            if not _set_changes(run, t, y, smooth, c, k, out.changes):
                return SINGULAR, k
    return KNOWN, nt


@kernel
def _set_changes(run: Run, t: float, y: Array, is_linear: bool, c: Column, at: int, out: Changes) -> bool:
    """Fill the changes along the values at a state; False if the mass matrix is singular.

    Parameters
    ----------
    is_linear : bool
        Whether the equations have been linearised here, and ``rates`` has the columns' rates.
    """
    equations, v = run.equations, run.variation
    model, n, m, count = equations.model, len(equations.model.free), c.before.shape[1], len(v.unit)
    if not is_linear and not _factorise_here(run, t, y, c):
        return False
    w = v.work.dynamics
    dq, dv, da = out.coordinates[at], out.rates[at], out.accelerations[at]
    for p in range(0, count, DIRECTIONS):
        first, last = m - count + p, min(m - count + p + DIRECTIONS, m)
        set_columns(equations, v, t, y, c.before, c.remembered, first, last)
        set_contacts(equations, v)
        if not is_linear:
            fill_residual(equations, v, t, c.dy[len(y) - len(c.own) :], first, last, c.forcing[0])
            for j in range(first, last):
                for i in range(len(c.own)):
                    c.own[i] = c.forcing[0, i, j]
                back_substitute(c.mass[0], c.pivots, c.own)
                for i in range(len(c.own)):
                    c.rates[i, j] = c.own[i]
        for i in range(len(dq)):
            put_slopes(dq, i, p, w.q[i])
            put_slopes(dv, i, p, w.v[i])
            put_slopes(da, i, p, w.a[i])
        for j in range(first, last):
            for i in range(n):
                da[model.free[i], p + j - first] = c.rates[i, j]
            for k in range(len(model.states)):
                da[len(da) - len(model.states) + k, p + j - first] = c.rates[n + len(model.law_states) + k, j]
        for k in range(len(model.ends)):
            for i in range(out.contacts.shape[2]):
                put_slopes(out.contacts[at, k], i, p, v.work.contacts[k, i])
    return True


@kernel(makes_arrays=True)
def _factorise_here(run: Run, t: float, y: Array, c: Column) -> bool:
    """Find the rates ``dy`` and the factors of the mass matrix at a state; False if it is singular."""
    solve_state(run.equations, t, y)
    if len(run.kinks):
        sides = run.equations.work.kinked.sides
        before = sides.copy()  # the next step goes on from them
        set_sides_here(run.equations, t, run.kinks)
        set_bounds(run.equations, run.kinks)
        for k in range(len(sides)):
            copy(before[k], sides[k])
    found_derivatives(run.equations, y, c.dy)
    inertia(run.equations, t, y, c.mass[0])
    return factorise(c.mass[0], c.pivots)


@kernel(makes_arrays=True)
def differentiate_states(
    run: Run, c: Column, known: int, found: AtSteps, times: Array, states: States, out: Changes
) -> None:
    """Fill a run's coordinates and contacts at any times, and their derivatives where these are known.

    The stages that give a state also give its derivatives, unless the step is divided for these.

    Parameters
    ----------
    c : Column
        Of the last columns of ``found``, those of the values among them.
    known : int
        Number of steps at which the columns are known.
    found : AtSteps
    times : (nt,) array
    states : States
    out : Changes
    """
    equations, steps, y = run.equations, run.steps, c.y.copy()
    closed, w = len(equations.model.rows) == 0, equations.work.dynamics
    restart(run.stepper)
    for i in range(len(times)):
        t = times[i]
        attempts = replay(equations, run.stepper, run.tolerance, steps, t, y)
        copy(w.q, states.coordinates[i])
        copy(w.v, states.rates[i])
        copy(w.a, states.accelerations[i])
        for k in range(states.contacts.shape[1]):
            copy(equations.work.contacts[k], states.contacts[i, k])
        k = last_start(steps.times, len(steps.times), t)
        if k >= known:
            continue
        _take_columns(found, k, c)
        at_hand = attempts == 1 and not len(run.kinks)
        good = advance(run, c, k, t, at_hand)
        if good and not closed:
            close_columns(equations, run.variation, t, y, c)
        if good:
            _set_changes(run, t, y, at_hand and closed and equations.implicit, c, i, out)


@kernel
def _take_columns(found: AtSteps, k: int, c: Column) -> None:
    """Fill the columns at the start of step k with the last ones of those that are known."""
    first = found.states.shape[2] - c.before.shape[1]
    for row in range(len(c.before)):
        copy(found.states[k, row, first:], c.before[row])
    for row in range(len(c.remembered)):
        copy(found.memory[k, row, first:], c.remembered[row])
    c.ended[0] = math.nan
