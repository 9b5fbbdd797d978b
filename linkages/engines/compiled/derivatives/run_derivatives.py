"""A finished run, differentiated at its steps and at any times."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, kernel
from linkages.engines.compiled.derivatives.contact_changes import gap_laws, result_change
from linkages.engines.compiled.derivatives.event_derivatives import begin_or_end, motions_along
from linkages.engines.compiled.derivatives.step_derivatives import Column, Run, advance, close_columns, linearise
from linkages.engines.compiled.run.equations import solve_state
from linkages.engines.compiled.run.kinks import set_bounds, set_sides_here
from linkages.engines.compiled.run.replay import remember, replay
from linkages.mechanics.integrate.factor import back_substitute, factorise
from linkages.mechanics.integrate.stepper import copy
from linkages.mechanics.planar.contact_partials import RESULT_PLACES, RESULTS
from linkages.mechanics.planar.contacts import EX, EY, PENETRATION
from linkages.mechanics.planar.motion import last_start

#: Status of the columns after a step: known; not known, because a step was singular or Newton's method failed; not
#: known, because a contact began without speed.
KNOWN, SINGULAR, GRAZED = 0, 1, 2


class Changes(NamedTuple):
    """Derivatives of a run along np values at nt times, n coordinates."""

    coordinates: Array  # (np, nt, n)
    rates: Array
    accelerations: Array
    contacts: Array  # (np, nt, nc, WIDTH)


class AtSteps(NamedTuple):
    """Derivatives of a run at its nt steps: m columns, ny entries of the state, nc contacts.

    Attributes
    ----------
    states : (nt, ny, m) array
        Derivatives of the state at fixed time, after the event or the projection at that time.
    memory : (nt, nc, m) array
        Derivatives of the approach speeds that contacts remember.
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
    deep, touches, wanted = np.zeros(nc), model.touching.any(), out.changes.coordinates.shape[1] == nt
    for k in range(nt):
        t, y = steps.times[k], steps.states[k]
        remember(equations, steps, max(k - 1, 0))
        if k > 0 and not advance(run, c, k - 1, t):
            return SINGULAR, k
        smooth = k > 0 and equations.implicit  # the last stage is at the end
        if k > 0 and len(model.rows):
            solve_state(equations, t, y)
            if not work.dynamics.interpolated[0] > 0.0:
                close_columns(equations, run.variation, t, y, c)
                smooth = False
        if touches:
            solve_state(equations, t, y)
        for i in range(nc):
            now = work.contacts[i, PENETRATION] if model.touching[i] else -1.0
            begins = now > 0.0 and (deep[i] <= 0.0 or steps.memory[k, i] != steps.memory[max(k - 1, 0), i])
            if k > 0 and (begins or (now < 0.0 < deep[i])):
                if not begin_or_end(run, t, y, i, begins, steps.memory[k, i], c, out.event_times[k]):
                    return GRAZED, k
                out.event[k] = i + 1 if begins else -i - 1
                solve_state(equations, t, y)
                smooth = False
            deep[i] = now
        for i in range(len(c.before)):
            copy(c.before[i], out.states[k, i])
        for i in range(nc):
            copy(c.remembered[i], out.memory[k, i])
        if wanted:
            remember(equations, steps, k)
            if not smooth and not _linearise_here(run, t, y, c):
                return SINGULAR, k
            _set_changes(run, c, k, out.changes)
    return KNOWN, nt


@kernel
def _linearise_here(run: Run, t: float, y: Array, c: Column) -> bool:
    """Linearise at a state, and fill ``rates`` with those of the columns; False if the mass matrix is singular."""
    if len(run.kinks):
        sides = run.equations.work.kinked.sides
        before = sides.copy()  # the next step goes on from them
        solve_state(run.equations, t, y)
        set_sides_here(run.equations, run.kinks)
        set_bounds(run.equations, run.kinks)
        for k in range(len(sides)):
            copy(before[k], sides[k])
    copy(y, c.y)
    linearise(run.equations, run.variation, t, c, 0)
    if not factorise(c.mass[0], c.pivots):
        return False
    for j in range(c.before.shape[1]):
        for i in range(len(c.own)):
            c.own[i] = c.forcing[0, i, j]
            for column in range(len(y)):
                c.own[i] += c.jacobian[0, i, column] * c.before[column, j]
        back_substitute(c.mass[0], c.pivots, c.own)
        for i in range(len(c.own)):
            c.rates[i, j] = c.own[i]
    return True


@kernel
def _set_changes(run: Run, c: Column, at: int, out: Changes) -> None:
    """Fill the changes along the values at a time, where the equations have been linearised."""
    equations, s = run.equations, c.contacts
    model, n, count, m = equations.model, len(equations.model.free), len(run.variation.unit), c.before.shape[1]
    motions_along(equations, run.variation, c, m - count)
    gap_laws(equations, run.variation, s)
    for p in range(count):
        j = m - count + p
        dq, dv, da = out.coordinates[p, at], out.rates[p, at], out.accelerations[p, at]
        for i in range(n):
            place = model.free[i]
            dq[place], dv[place], da[place] = c.before[i, j], c.before[n + i, j], c.rates[i, j]
        for i in range(len(model.driven)):
            place = model.driven[i]
            dq[place], dv[place], da[place] = s.driven[p, 0, i], s.driven[p, 1, i], s.driven[p, 2, i]
        for k in range(len(model.ends)):
            contact = out.contacts[p, at, k]
            contact[:] = 0.0
            contact[EX], contact[EY] = s.along[j, k, 0], s.along[j, k, 1]
            for result in range(RESULTS):
                contact[RESULT_PLACES[result]] = result_change(equations, s, p, j, k, result)


@kernel
def differentiate_states(run: Run, c: Column, known: int, found: AtSteps, times: Array, out: Changes) -> None:
    """Fill the derivatives of a run's coordinates and contacts at any times, where they are known.

    Parameters
    ----------
    known : int
        Number of steps at which the columns are known.
    found : AtSteps
    times : (nt,) array
    out : Changes
    """
    steps, y = run.steps, c.y.copy()
    for i in range(len(times)):
        t = times[i]
        k = last_start(steps.times, len(steps.times), t)
        if k >= known:
            continue
        for row in range(len(y)):
            copy(found.states[k, row], c.before[row])
        for row in range(len(c.remembered)):
            copy(found.memory[k, row], c.remembered[row])
        c.ended[0] = math.nan
        good = advance(run, c, k, t)
        replay(run.equations, run.stepper, run.tolerance, steps, t, y)
        if good and len(run.equations.model.rows):
            close_columns(run.equations, run.variation, t, y, c)
        if good and _linearise_here(run, t, y, c):
            _set_changes(run, c, i, out)
