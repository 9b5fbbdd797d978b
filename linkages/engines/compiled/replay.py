"""States between the steps of a run, by stepping there again.

A film's force follows from the last digits of the velocities, so that interpolated states would spoil it. A step from
the one before, of given size, is as accurate as the run.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.engines.compiled.entry_points import attempt, project, solve
from linkages.engines.compiled.equations import derivatives
from linkages.engines.compiled.model import Equations
from linkages.integrate.stepper import Stepper, copy, hint, restart
from linkages.kernel import Array, kernel
from linkages.planar.motion import last_start

_TRIES = 30


class Steps(NamedTuple):
    """Steps of a run: times (nt,), states (nt, ny), and the approach speeds that contacts remember (nt, nc)."""

    times: Array
    states: Array
    memory: Array


@kernel
def remember(equations: Equations, steps: Steps, k: int) -> None:
    """Restore what the contacts remember after step k."""
    for c in range(steps.memory.shape[1]):
        equations.work.memory[c, 0] = steps.memory[k, c]


@kernel
def replay(equations: Equations, s: Stepper, tolerance: Array, steps: Steps, t: float, y: Array) -> None:
    """Fill y with the state at time t of a run, NaN if it cannot be had; leave the equations solved there."""
    k = last_start(steps.times, len(steps.times), t)
    start = steps.times[k]
    remember(equations, steps, k)
    copy(steps.states[k], y)
    if t > start:
        end, target = steps.times[k + 1], steps.states[k + 1]
        derivatives(equations, end, target, s.f1)
        slope = s.f1.copy()
        copy(tolerance, s.scale)
        now, h = start, t - start
        for _ in range(_TRIES):
            restart(s)
            derivatives(equations, now, y, s.f0)
            hint(s, y, end - now, target, slope)
            error, _ = attempt(equations, s, now, h, y, True)
            if not error <= 1.0:
                h *= 0.5  # Newton's method did not converge over so long a step
                continue
            copy(s.new, y)
            now += h
            h = t - now
            if h <= 0.0:
                break
        if h > 0.0:  # never seen: better no number than a wrong one
            for i in range(len(y)):
                y[i] = np.nan
    solve(equations, t, y)
    if len(equations.model.rows) and project(equations, y):
        solve(equations, t, y)
