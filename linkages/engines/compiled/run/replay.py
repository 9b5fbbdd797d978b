"""States between the steps of a run, by stepping there again.

A film's force follows from the last digits of the velocities, so that interpolated states would spoil it. A step from
the one before, of given size, is as accurate as the run. After each step the state is moved back onto closed loops.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, kernel, lazy_kernel
from linkages.engines.compiled.run.equations import derivatives, is_solved, solve_state
from linkages.engines.compiled.run.methods import attempt
from linkages.engines.compiled.run.model import Equations
from linkages.mechanics.integrate.implicit import set_last_step
from linkages.mechanics.integrate.stepper import LAST, OF, Stepper, copy, restart
from linkages.mechanics.planar.contact_memory import restore_memory
from linkages.mechanics.planar.loop_dynamics import project
from linkages.mechanics.planar.motion import last_start

_MOST = 1000  # attempts within one step of a run, where Newton's method does not converge over all of it
_APART = 0.1  # of a step: what others are away, at least, of which states lie on one curve with its own
_CLOSED = 1e-14  # closure error that a projection leaves, in parts of the linkage's length

#: Stages of the implicit method.
STAGES = 3


class Steps(NamedTuple):
    """Steps of a run: times (nt,), states (nt, ny), and memory (nt, nm).

    The memory begins with what contacts remember, see `record_memory`. If requested, increments (ny, STAGES) of the
    stages of the step that ends at each time follow.
    """

    times: Array
    states: Array
    memory: Array


@lazy_kernel
def project_state(equations: Equations, y: Array) -> bool:
    """Move coordinates and rates, in y and in the work, to where the loops are closed; False if they were already.

    The equations are solved at y. Where the accelerations are interpolated near a singularity the state stays as it is:
    the loops determine it there only to digits that it does not have.
    """
    model, w, n = equations.model, equations.work.dynamics, len(equations.model.free)
    if w.interpolated[0] > 0.0 or not project(model.stiff, model.rows, model.elimination, _CLOSED, model.size, w):
        return False
    for i in range(n):
        y[i] = w.q[model.free[i]]
        y[n + i] = w.v[model.free[i]]
    return True


@kernel
def remember(equations: Equations, steps: Steps, k: int) -> None:
    """Restore the contacts' memory after step k; the equations are not solved with it."""
    equations.work.solved[0] = math.nan
    restore_memory(equations.work.memory, steps.memory[k])


@kernel(makes_arrays=True)
def around(times: Array, k: int) -> Indices:
    """Find points for a polynomial over step k: its ends, and the nearest on either side that are not too near."""
    apart = _APART * (times[k + 1] - times[k])
    before, after, last = k - 1, k + 2, len(times) - 1
    while before > 0 and times[k] - times[before] < apart:
        before -= 1
    while after < last and times[after] - times[k + 1] < apart:
        after += 1
    first = 0 if before >= 0 and times[k] - times[before] >= apart else 1
    count = 4 if after <= last and times[after] - times[k + 1] >= apart else 3
    return np.array([before, k, k + 1, after])[first:count]


@kernel
def replay(equations: Equations, s: Stepper, tolerance: Array, steps: Steps, t: float, y: Array) -> int:
    """Fill y with the state at time t of a run, NaN if it cannot be had; leave the equations solved there.

    Returns the number of attempts. After a single one the stepper has the stages of the step to time t.
    """
    k = last_start(steps.times, len(steps.times), t)
    start, attempts = steps.times[k], 0
    remember(equations, steps, k)
    copy(steps.states[k], y)
    if t > start:
        copy(tolerance, s.scale)
        if s.memory[OF] != k + 1.0:  # else Jacobian, rates and prediction are those of this step's start already
            restart(s)
            s.memory[OF] = k + 1.0
            derivatives(equations, start, y, s.f0)
        now, h = start, t - start
        while now + h > now and attempts < _MOST:
            attempts += 1
            if equations.implicit and s.memory[LAST] == 0.0:
                # from states alone: the numbers of a run do not depend on whether its stages were recorded
                set_last_step(s, now, steps.times[k + 1] - start, steps.times, steps.states, around(steps.times, k))
            error, _ = attempt(equations, s, now, h, y, True)
            if not error <= 1.0:  # Newton's method did not converge over so long a step
                h *= 0.5
                continue
            copy(s.new, y)
            now = now + h if h < t - now else t
            h = min(2.0 * h, t - now)
            if h > 0.0:
                copy(s.f1, s.f0)
                restart(s)
        if now < t:  # better no number than a wrong one
            for i in range(len(y)):
                y[i] = np.nan
    if not is_solved(equations.work, t, y):
        solve_state(equations, t, y)
    apart = t > start or len(steps.times) == 1  # loops are closed where the steps of a run end, not in a single state
    if apart and len(equations.model.rows) and project_state(equations, y):
        solve_state(equations, t, y)
    return attempts
