"""A run and its statistics: numbers of one design, and the arrays that the run works on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, Records
from linkages.engines.budget import least_advance, most
from linkages.engines.compiled.run.kinks import kinks
from linkages.engines.compiled.run.model import KINKS, Equations, error_scale, make_work, start_state
from linkages.engines.methods import method
from linkages.engines.numerics import JOB_FEWEST, JOB_TRAVEL
from linkages.input.model.experiment_tables import IMPLICIT
from linkages.mechanics.integrate.stepper import Stepper, make_stepper
from linkages.mechanics.planar.arrays import Arrays, size_of
from linkages.mechanics.planar.contact_memory import make_memory
from linkages.mechanics.planar.workspace import Workspace, make_workspace
from linkages.system import System

#: Accuracy of runs from which on steps may cross kinks if they are not differentiated, and differences of the second
#: order, with errors of 1e-7, are as exact as their derivatives need.
COARSE = 1e-9

#: Indices of `Given.limits`: end of the run [s], longest step [s], accuracy, smallest advance of
#: `linkages.engines.budget.WINDOW` steps [s], most steps.
END, LONGEST, ACCURACY, LEAST, MOST = range(5)


class Given(NamedTuple):
    """All numbers of a design that a run and its statistics read: ny state entries, nw windows, ``no`` outputs."""

    start: Array  # state at t = 0, (ny,)
    tolerance: Array  # of each entry of the state, per step, (ny,)
    kinks: Array  # at which steps end, (nc + nf, KINKS) or none; see `linkages.engines.compiled.run.kinks.kinks`
    limits: Array  # by the indices above, (5,)
    windows: Array  # times [s], (nw, 2)
    outputs: Records  # of `linkages.results.outputs.quantity.OUTPUT`, (no,)
    rows: Records  # closure rows of the linkage with every joint ideal
    closing: Indices  # coordinates of joints that no drive prescribes
    model: Arrays
    implicit: bool  # whether the equations are stiff and Radau IIA is used; else Dormand and Prince's pair
    with_ideal: bool  # whether outputs need the ideal linkage's state
    with_forces: bool  # the forces in joints
    with_loads: bool  # the values of loads


class Job(NamedTuple):
    """`Given`, whose numbers come first and in the same order, and the arrays to work on."""

    start: Array
    tolerance: Array
    kinks: Array
    limits: Array
    windows: Array
    outputs: Records
    rows: Records
    closing: Indices
    equations: Equations
    with_ideal: bool
    with_forces: bool
    with_loads: bool
    stepper: Stepper
    ideal: Workspace  # of the linkage with every joint ideal, of which q, v, a, pose, vel and acc count
    landing: Array  # see `linkages.mechanics.planar.contact_memory.fill_landing`, (nc,)
    y: Array  # a state between steps, (ny,)
    row: Array  # its outputs, (no,)


def make_given(system: System, outputs: Records, windows: Array, steps: int | None = None) -> Given:
    """Collect the numbers of a system, with the model of `model_of`; a run has at most `steps`, default `most`."""
    tree, solver, duration = system.tree, system.settings, system.settings.duration
    model = model_of(system, outputs)
    longest = solver.max_step or _longest(system)
    return Given(
        start_state(system),
        solver.accuracy * error_scale(system),
        kinks(system) if solver.accuracy < COARSE else np.zeros((0, KINKS)),
        np.array([duration, longest, solver.accuracy, least_advance(duration), steps or most(system)]),
        np.minimum(windows, duration),
        outputs,
        tree.closure_rows,
        tree.closing_dofs,
        model,
        method(system, "compiled") in IMPLICIT,
        bool(outputs["jitter"].any()),
        bool(outputs["forces"].any()),
        bool(outputs["loads"].any()),
    )


def model_of(system: System, outputs: Records) -> Arrays:
    """Return a system's arrays without sections of links that neither forces nor outputs need."""
    tree, model = system.tree, system.arrays
    if tree.acting < len(model.bodies.records):
        seen = [outputs["marker"]["body"], outputs["at"], outputs["other"]]
        seen += [model.joints["child"]["body"]] if outputs["forces"].any() else []
        if max(int(part.max(initial=0)) for part in seen) < tree.acting:
            bodies, stiff = (tree.acting_bodies(each) for each in (model.bodies, model.stiff))
            return model._replace(bodies=bodies, stiff=stiff)
    return model


def make_job(given: Given, memory: Array | None = None, modes: Indices | None = None) -> Job:
    """Add the arrays to work on, around what contacts remember and whether they touch; by default they know nothing."""
    model, ny, nc = given.model, len(given.start), len(given.model.ends)
    memory = make_memory(model.ends, model.tables) if memory is None else memory
    work = make_work(model, memory, np.full(nc, -1) if modes is None else modes)
    return Job(
        **{name: getattr(given, name) for name in Job._fields if name in Given._fields},
        equations=Equations(model, work, given.implicit),
        stepper=make_stepper(ny, len(model.free)),
        ideal=make_workspace(len(model.bodies.records), size_of(model), 0, model.bodies.shapes.shape[2]),
        landing=np.zeros(nc),
        y=np.zeros(ny),
        row=np.zeros(len(given.outputs)),
    )


def _longest(system: System) -> float:
    """Longest step [s]: a prescribed motion needs no steps, but extremes are searched for between them."""
    duration = system.settings.duration
    if not system.determinate or system.tree.play or system.tree.deformable:
        return duration
    longest = JOB_TRAVEL * duration / system.drive_travel if system.drive_travel > 0.0 else np.inf
    return min(duration / JOB_FEWEST, longest)
