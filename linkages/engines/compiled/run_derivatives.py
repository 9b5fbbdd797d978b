"""A finished run, differentiated at its steps and at any times."""

from __future__ import annotations

import math

import numpy as np

from linkages.engines.compiled.contact_changes import law_change, note_contacts
from linkages.engines.compiled.equations import solve_state
from linkages.engines.compiled.event_derivatives import begin_or_end, motions_along
from linkages.engines.compiled.forcing import drive_changes
from linkages.engines.compiled.jacobian import exact_jacobian
from linkages.engines.compiled.kinks import set_bounds, set_sides_here
from linkages.engines.compiled.model import Equations
from linkages.engines.compiled.replay import Steps, remember, replay
from linkages.engines.compiled.step_derivatives import Column, advance, close_columns, linearise
from linkages.engines.compiled.variation import Variation
from linkages.integrate.factor import back_substitute, factorise
from linkages.integrate.stepper import Stepper, copy
from linkages.kernel import Array, Indices, clear, kernel
from linkages.planar.contact_partials import APPROACHING, INPUTS, RESULT_PLACES, RESULTS
from linkages.planar.contacts import EX, EY, PENETRATION
from linkages.planar.motion import last_start

#: Status of the columns after a step: known; not known, because a step was singular or Newton's method failed; not
#: known, because a contact began without speed.
KNOWN, SINGULAR, GRAZED = 0, 1, 2


@kernel
def differentiate_run(
    equations: Equations,
    variation: Variation,
    s: Stepper,
    tolerance: Array,
    steps: Steps,
    rate: float,
    limits: Array,
    c: Column,
    states: Array,
    memory: Array,
    rates: Array,
    contacts: Array,
    event: Indices,
    times: Array,
) -> tuple[int, int]:
    """Differentiate a run.

    Parameters
    ----------
    rate : float
        Rate of the motion [rad/s].
    limits : (nc, KINKS) array
        See `linkages.engines.compiled.kinks.kinks`.
    c : Column
        With the columns at the start in ``before`` and ``remembered``.
    states, memory : (nt, ny, m), (nt, nc, m) arrays
        Filled with the columns after each step.
    rates : (nt, k, m) array
        Filled with the rates of the columns where the last stage gives them, NaN elsewhere.
    contacts : (np, nt, nc, WIDTH) array
        Filled with the changes of the contacts along the values there, unless contacts can touch.
    event : (nt,) array of int
        Filled with the contact that begins (k + 1) or ends (-k - 1) at each time; 0 without.
    times : (nt, m) array
        Filled with the derivatives of the events' times.

    Returns
    -------
    status : int
    count : int
        Number of times at which the columns are known.
    """
    nt, nc, model, work = len(steps.times), len(equations.model.ends), equations.model, equations.work
    deep, touches = np.zeros(nc), model.touching.any()
    for k in range(nt):
        t, y = steps.times[k], steps.states[k]
        remember(equations, steps, max(k - 1, 0))
        if k > 0 and not advance(equations, variation, s, tolerance, steps, k - 1, t, limits, c):
            return SINGULAR, k
        smooth = k > 0 and equations.implicit and c.ended[0] == t
        if k > 0 and len(model.rows):
            solve_state(equations, t, y)
            if not work.dynamics.interpolated[0] > 0.0:
                close_columns(equations, variation, t, y, c)
                smooth = False
        if touches:
            solve_state(equations, t, y)
        for i in range(nc):
            now = work.contacts[i, PENETRATION] if model.touching[i] else -1.0
            begins = now > 0.0 and (deep[i] <= 0.0 or steps.memory[k, i] != steps.memory[max(k - 1, 0), i])
            if k > 0 and (begins or (now < 0.0 < deep[i])):
                fine = begin_or_end(equations, variation, t, y, i, begins, steps.memory[k, i], rate, c, times[k])
                if not fine:
                    return GRAZED, k
                event[k] = i + 1 if begins else -i - 1
                solve_state(equations, t, y)
                smooth = False
            deep[i] = now
        for i in range(len(c.rates)):
            for j in range(c.rates.shape[1]):
                rates[k, i, j] = c.rates[i, j] if smooth else math.nan
        if smooth and not len(limits) and not work.dynamics.interpolated[0] > 0.0:
            _contacts_along(equations, variation, t, c, k, contacts)
        for i in range(len(c.before)):
            copy(c.before[i], states[k, i])
        for i in range(nc):
            copy(c.remembered[i], memory[k, i])
    return KNOWN, nt


@kernel
def _column_rates(equations: Equations, variation: Variation, t: float, y: Array, c: Column) -> bool:
    """Fill ``rates`` with those of the columns ``before`` at a state; False if the mass matrix is singular."""
    copy(y, c.y)
    linearise(equations, variation, t, c, 0)
    c.ended[0] = math.nan
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
    solve_state(equations, t, y)
    return True


@kernel
def _contacts_along(equations: Equations, variation: Variation, t: float, c: Column, step: int, out: Array) -> None:
    """Fill ``out`` (np, nt, nc, WIDTH) with the changes of the contacts at the last stage of a linearised step."""
    s, partials, first = c.contacts, equations.work.scratch.partials, c.before.shape[1] - len(variation.unit)
    motions_along(equations, variation, t, c.y, c.before, first, c.direction)
    for p in range(len(out)):
        for k in range(out.shape[2]):
            along = c.direction[first + p, k]
            out[p, step, k, EX], out[p, step, k, EY] = along[0], along[1]
            for result in range(RESULTS):
                total = s.laws[p, k, result]
                for i in range(INPUTS):
                    total += partials[k, result, i] * along[i]
                out[p, step, k, RESULT_PLACES[result]] = total


@kernel
def _set_changes(
    equations: Equations, variation: Variation, p: int, j: int, t: float, columns: Array, rates: Array, drive: Array,
    dq: Array, dv: Array, da: Array,
) -> None:  # fmt: skip
    """Fill the changes of coordinates, rates and accelerations along column j, with known rates, and value p."""
    model, n = equations.model, len(equations.model.free)
    for i in range(n):
        place = model.free[i]
        dq[place], dv[place], da[place] = columns[i, j], columns[n + i, j], rates[i, j]
    clear(drive)
    if variation.drives[p]:
        drive_changes(variation, p, t, drive)
    for i in range(len(model.driven)):
        place = model.driven[i]
        dq[place], dv[place], da[place] = drive[0, i], drive[1, i], drive[2, i]


@kernel
def _set_contacts(equations: Equations, variation: Variation, p: int, j: int, c: Column, contacts: Array) -> None:
    """Fill the changes of contacts along column j, whose ``direction`` belongs to a solved state, and value p."""
    for i in range(len(equations.model.ends)):
        copy(c.direction[j, i], c.contacts.change)
        c.contacts.change[APPROACHING] = c.remembered[i, j]
        law_change(equations, variation, p, i, c.contacts)
        contacts[i, EX], contacts[i, EY] = c.direction[j, i, 0], c.direction[j, i, 1]
        for result in range(RESULTS):
            contacts[i, RESULT_PLACES[result]] = c.contacts.found[result]


@kernel
def differentiate_states(
    equations: Equations, variation: Variation, s: Stepper, tolerance: Array, steps: Steps, limits: Array, c: Column,
    states: Array, memory: Array, rates: Array, noted: Array, count: int, times: Array, dq: Array, dv: Array, da: Array,
    contacts: Array,
) -> None:  # fmt: skip
    """Fill the derivatives of a run's coordinates and contacts at any times with respect to np values.

    Parameters
    ----------
    states, memory, rates, noted : arrays
        From `differentiate_run`.
    count : int
        Number of steps at which the columns are known.
    times : (nt,) array
    dq, dv, da : (np, nt, n) arrays
    contacts : (np, nt, nc, WIDTH) array
    """
    nv, m, n = len(variation.unit), c.before.shape[1], len(c.y)
    y = np.empty(n)
    for i in range(len(times)):
        t = times[i]
        k = last_start(steps.times, len(steps.times), t)
        known, first, drive = k < count, m - nv, c.contacts.drive
        at_step = known and t == steps.times[k] and rates.size > 0 and rates[k, 0, 0] == rates[k, 0, 0]
        if at_step and not len(limits) and nv > 0 and (noted.shape[2] == 0 or noted[0, k, 0, 0] == noted[0, k, 0, 0]):
            for p in range(nv):
                _set_changes(
                    equations, variation, p, first + p, t, states[k], rates[k], drive, dq[p, i], dv[p, i], da[p, i]
                )
                for contact in range(noted.shape[2]):
                    copy(noted[p, k, contact], contacts[p, i, contact])
            continue
        for row in range(n):
            copy(states[k, row], c.before[row])
        for row in range(c.remembered.shape[0]):
            copy(memory[k, row], c.remembered[row])
        if at_step:
            for row in range(rates.shape[1]):
                copy(rates[k, row], c.rates[row])
        if known:
            known = advance(equations, variation, s, tolerance, steps, k, t, limits, c)
        replay(equations, s, tolerance, steps, t, y)
        if known and t > steps.times[k] and len(equations.model.rows):
            close_columns(equations, variation, t, y, c)
            solve_state(equations, t, y)
        if known and len(limits):
            set_sides_here(equations, limits)
            set_bounds(equations, limits)
        if at_step:
            note_contacts(equations, c.contacts)
            exact_jacobian(equations, t, y, c.mass[0], c.full)
        elif known:
            known = _column_rates(equations, variation, t, y, c)
        if known:
            motions_along(equations, variation, t, y, c.before, first, c.direction)
        for p in range(nv):
            if known:
                _set_changes(
                    equations, variation, p, first + p, t, c.before, c.rates, drive, dq[p, i], dv[p, i], da[p, i]
                )
                _set_contacts(equations, variation, p, first + p, c, contacts[p, i])
            else:
                for q in range(dq.shape[2]):
                    dq[p, i, q], dv[p, i, q], da[p, i, q] = math.nan, math.nan, math.nan
                for q in range(contacts.shape[2]):
                    for r in range(contacts.shape[3]):
                        contacts[p, i, q, r] = math.nan
