"""Outputs of the linkage without clearance: exact kinematics and inverse dynamics, no simulation.

``ideal.COLUMN`` is a column of the ideal motion (see `linkages.outputs.columns`), ``ideal.JOINT.turning_rate`` the rate at
which the direction of the force in a joint turns [rad/s], counterclockwise positive, in plane axes. A journal with
play leans where the force presses it; where the direction turns fast it loses touch, flies across and strikes.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from linkages.engines.study import ideal
from linkages.errors import Status
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Mechanism
from linkages.outputs.columns import Columns
from linkages.system.assembly import AssemblyError
from optim.evaluate.evaluations import OK
from optim.evaluate.requests import Batch, Statistics, run_each
from optim.problem.outputs import IDEAL, TURNING

Array = NDArray[np.float64]

#: Samples of a window; extremes are those of the samples, so windows should not be much longer than a revolution.
SAMPLES = 2001


def run_parts(engine: Callable[[Batch], Statistics], batch: Batch) -> Statistics:
    """Run a batch through an engine, but its ideal outputs without one; designs that have no ideal motion fail."""
    parts = []
    for wanted, run in ((False, engine), (True, run_ideal)):
        columns = [k for k, name in enumerate(batch.outputs) if name.startswith(IDEAL) == wanted]
        if columns:
            outputs = tuple(batch.outputs[k] for k in columns)
            parts.append((columns, run(dataclasses.replace(batch, outputs=outputs))))
    order = np.argsort([k for columns, _ in parts for k in columns])

    def joined(key: str) -> Array:
        return np.concatenate([getattr(found, key) for _, found in parts], axis=2)[:, :, order]

    verdicts = [
        next(((s, r) for s, r in verdict if s != OK), (OK, ""))
        for verdict in zip(*(zip(found.status, found.reason, strict=True) for _, found in parts), strict=True)
    ]
    return Statistics(
        joined("minimum"), joined("maximum"), joined("mean"), joined("rms"),
        [status for status, _ in verdicts], [reason for _, reason in verdicts],
    )  # fmt: skip


def run_ideal(batch: Batch) -> Statistics:
    """Sample the ideal motion of designs in the windows of a batch."""
    return run_each(batch, lambda _, mechanism, experiment: _statistics(batch, mechanism, experiment))


def _statistics(batch: Batch, mechanism: Mechanism, experiment: Experiment) -> Array:
    """Minimum, maximum, mean and rms of each output in each window, (4, nw, no)."""
    motion = ideal(mechanism, experiment, "compiled")
    if motion.status is not Status.OK:
        raise AssemblyError(motion.status, f"ended at t = {motion.time[-1]:.6g} s; {motion.status.remedy}")
    assert motion.evaluate is not None  # what an engine returns has it
    found = np.empty((4, len(batch.windows), len(batch.outputs)))
    for w, (start, end) in enumerate(batch.windows):
        times = np.linspace(start, end, SAMPLES)
        columns = motion.evaluate(times)
        for k, name in enumerate(batch.outputs):
            y = _signal(columns, times, name.removeprefix(IDEAL))
            mean, square = (np.trapezoid(z, times) / (end - start) for z in (y, y**2))
            found[:, w, k] = y.min(), y.max(), mean, np.sqrt(square)
    return found


def _signal(columns: Columns, times: Array, name: str) -> Array:
    owner, _, what = name.rpartition(".")
    return (
        turning_rate(columns[f"{owner}.fx"], columns[f"{owner}.fy"], times)
        if what == TURNING
        else columns[name]
    )


def turning_rate(fx: Array, fy: Array, times: Array) -> Array:
    """Rate of the angle of a vector from samples of its components, by splines; infinite where it vanishes [rad/s]."""
    ax, ay = (CubicSpline(times, f)(times, 1) for f in (fx, fy))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((fx * ay - fy * ax) / (fx**2 + fy**2))
