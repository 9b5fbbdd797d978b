"""Outputs of a job at any times of its run."""

from __future__ import annotations

import math
from typing import NamedTuple

from linkages.base.kernel import Array, kernel
from linkages.base.kernel.by_reference import reference
from linkages.elements.machine import tell_elements
from linkages.engines.compiled.run.job import Job
from linkages.engines.compiled.run.replay import Steps, replay
from linkages.mechanics.integrate.stepper import restart
from linkages.mechanics.planar.arrays import functions_of, loads_of
from linkages.mechanics.planar.closure import ideal_state
from linkages.mechanics.planar.loads import load_outputs
from linkages.mechanics.planar.newton_euler import inertial_forces
from linkages.mechanics.planar.reactions import joint_forces, row_reactions
from linkages.results.outputs.evaluation import output_value
from linkages.results.outputs.quantity import Snapshot


class Sampler(NamedTuple):
    """A run that is evaluated at any time."""

    job: Job
    steps: Steps


@kernel(makes_arrays=True)
def look(job: Job, t: float, out: Array) -> bool:
    """Fill ``out`` (no,) with the outputs of the solved state; returns False if the ideal linkage does not close."""
    ideal, model, work = job.ideal, job.equations.model, job.equations.work
    w = work.dynamics
    if job.with_ideal and not ideal_state(model, w, job.rows, job.closing, ideal):
        return False
    if job.with_loads:
        if len(model.loads):
            load_outputs(loads_of(model), work.reactive.efforts, t, w.v, w.pose, w.vel, work.applied)
        tell_elements(model.elements, functions_of(model), t, w.v, len(model.loads), w.pose, w.vel, work.applied)
    if job.with_forces:
        inertial_forces(model.bodies, w, model.gravity, w.bias, w.shape_bias)
        if w.interpolated[0] > 0.0:  # the reactions belong to a neighbouring state
            row_reactions(model, w)
        joint_forces(model, w, work.contacts, work.forces, work.efforts)
    snapshot = Snapshot(model, w, work.contacts, work.forces, work.efforts, work.applied, work.reactive)
    seen, outputs = reference(snapshot), job.outputs
    for k in range(len(outputs)):
        out[k] = output_value(outputs[k], seen)
        if outputs[k].jitter:
            exact = Snapshot(model, ideal, work.contacts, work.forces, work.efforts, work.applied, work.reactive)
            out[k] -= output_value(outputs[k], reference(exact))
    return True


@kernel
def knows_outputs(job: Job) -> bool:
    """Whether outputs are recorded during the run: the explicit method leaves the equations solved at each state."""
    return not (job.equations.implicit or job.with_ideal)


@kernel
def asked(job: Job, t: float, valid: float) -> bool:
    """Whether a time is in a window that ends before the time `valid`."""
    inside = False
    for m in range(len(job.windows)):
        inside |= job.windows[m, 0] <= t <= job.windows[m, 1] < valid
    return inside


@kernel
def sample(sampler: Sampler, t: float, out: Array) -> bool:
    """Fill ``out`` (no,) with the outputs at time t; returns False if the ideal linkage does not close."""
    job = sampler.job
    replay(job.equations, job.stepper, job.tolerance, sampler.steps, t, job.y)
    return look(job, t, out)


@kernel
def tabulate_run(job: Job, steps: Steps, times: Array, out: Array) -> bool:
    """Fill ``out`` (nt, no) with the outputs at any times of a run; returns False if the ideal linkage is open."""
    sampler = reference(Sampler(job, steps))
    restart(job.stepper)
    job.equations.work.solved[0] = math.nan
    for i in range(len(times)):
        closed = sample(sampler, times[i], out[i])
        if not closed:
            return False
    return True
