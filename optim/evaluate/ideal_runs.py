"""Outputs of the linkage without clearance (``ideal.`` names): exact kinematics and inverse dynamics, no run.

A journal with play leans where the force presses it; where the direction of the force turns fast
(``ideal.JOINT.turning_rate``) it loses touch, flies across and strikes.
"""

from __future__ import annotations

import numpy as np

from linkages import AssemblyError, Status, System, ideal
from linkages.mechanics.integrate.peak_search import average
from linkages.results.outputs.columns import Columns
from linkages.results.outputs.registry import IDEAL, TURNING
from optim.evaluate.requests import STATISTICS, Request, Statistics, run_each
from optim.problem.study import Array

#: Samples of a window; extremes are taken from the samples, so windows should not be much longer than a revolution.
SAMPLES = 2001


def run_ideal(request: Request) -> Statistics:
    """Sample the ideal motion of designs in the windows of a request."""
    return run_each(request, lambda _, system: _statistics(request, system))


def _statistics(request: Request, system: System) -> Array:
    """`STATISTICS` of each output in each window, (4, nw, no)."""
    motion = ideal(system, "compiled")
    if motion.status is not Status.OK:
        raise AssemblyError(motion.status, f"ended at t = {motion.time[-1]:.6g} s")
    assert motion.evaluate is not None  # set by every engine
    found = np.empty((len(STATISTICS), len(request.windows), len(request.outputs)))
    for w, (start, end) in enumerate(request.windows):
        times = np.linspace(start, end, SAMPLES)
        columns = motion.evaluate(times)
        for k, name in enumerate(request.outputs):
            y = _signal(columns, times, name.removeprefix(IDEAL))
            found[:, w, k] = y.min(), y.max(), average(times, y, False), average(times, y, True)
    return found


def _signal(columns: Columns, times: Array, name: str) -> Array:
    owner, _, what = name.rpartition(".")
    if what == TURNING:
        return turning_rate(columns[f"{owner}.fx"], columns[f"{owner}.fy"], times)
    return columns[name]


def turning_rate(fx: Array, fy: Array, times: Array) -> Array:
    """Rate of the angle of a vector from samples of its components, by splines; infinite where it vanishes [rad/s]."""
    from scipy.interpolate import CubicSpline  # a tenth of a second, for few studies

    ax, ay = (CubicSpline(times, f)(times, 1) for f in (fx, fy))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((fx * ay - fy * ax) / (fx**2 + fy**2))
