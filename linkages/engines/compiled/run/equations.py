"""Equations of motion as an ordinary differential equation in the free coordinates."""

from __future__ import annotations

import math

from linkages.base.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.elements.machine import add_elements
from linkages.engines.compiled.run.model import Equations, Work
from linkages.laws.states import FIRST_STATE
from linkages.mechanics.planar.arrays import Arrays, functions_of, loads_of
from linkages.mechanics.planar.closure_rows import add_row_wrench, row_acceleration
from linkages.mechanics.planar.contacts import EX, EY, FX, FY, RATES, clearance_wrenches
from linkages.mechanics.planar.kinematics import body_accelerations, body_states
from linkages.mechanics.planar.loads import state_rates
from linkages.mechanics.planar.motion import evaluate_motions
from linkages.mechanics.planar.newton_euler import force_residual
from linkages.mechanics.planar.reactive_loads import add_applied
from linkages.mechanics.planar.record_types import REVOLUTE
from linkages.mechanics.planar.singularities import smooth_dynamics
from linkages.mechanics.planar.workspace import Workspace


@inlined_kernel
def set_state(model: Arrays, work: Work, t: float, y: Array) -> None:
    """Fill the work's coordinates, rates, prescribed accelerations, torques, poses and velocities."""
    w, n = work.dynamics, len(model.free)
    work.solved[0] = math.nan
    for i in range(n):
        place = model.free[i]
        w.q[place], w.v[place], w.a[place], w.tau[place] = y[i], y[n + i], 0.0, 0.0
    value, rate, second = work.value, work.rate, work.second
    if len(model.driven):
        evaluate_motions((model.motion, model.motion_c, model.motion_n), t, value, rate, second)
        for k in range(len(model.driven)):
            d = model.driven[k]
            w.q[d], w.v[d], w.a[d], w.tau[d] = value[k], rate[k], second[k], 0.0
    set_drive_forces(model, work, t)
    for k in range(len(model.law_states)):
        work.memory[model.law_states[k, 0], FIRST_STATE + model.law_states[k, 1]] = y[2 * n + k]
    for k in range(len(model.states)):
        w.v[len(w.v) - len(model.states) + k] = y[2 * n + len(model.law_states) + k]
    body_states(model.bodies, w.q, w.v, w.pose, w.vel)


@inlined_kernel
def set_drive_forces(model: Arrays, work: Work, t: float) -> None:
    """Fill the prescribed torques and forces of drives."""
    if len(model.powered):
        evaluate_motions((model.torque, model.torque_c, model.torque_n), t, work.value, work.rate, work.second)
        for k in range(len(model.powered)):
            work.dynamics.tau[model.powered[k]] = work.value[k]


@inlined_kernel
def _add_forces(equations: Equations, t: float) -> None:
    """Fill the wrenches of contacts and applied loads on the bodies, at a state that is set."""
    model, work = equations.model, equations.work
    w = work.dynamics
    w.wrench[:] = 0.0
    clearance_wrenches(model.ends, model.laws, model.tables, work.memory, w.pose, w.vel, w.wrench, work.contacts)
    add_elements(model.elements, functions_of(model), t, w.v, w.pose, w.vel, w.wrench)
    if len(model.loads):
        add_applied(model, t, work.value, w, work.reactive)
    if len(model.states):
        _set_state_rates(model, w, t)


@kernel(makes_arrays=True)
def _set_state_rates(model: Arrays, w: Workspace, t: float) -> None:
    state_rates(loads_of(model), t, w.v, w.pose, w.vel, w.a)


@lazy_kernel
def solve_state(equations: Equations, t: float, y: Array) -> None:
    """Fill the work with everything that is known at a state: accelerations, contacts, loop reactions."""
    model, work = equations.model, equations.work
    set_state(model, work, t, y)
    _add_forces(equations, t)
    w = work.dynamics
    smooth_dynamics(model.bodies, model.rows, model.elimination, model.size, model.gravity, w)
    if len(model.rows):
        body_accelerations(model.bodies, w.pose, w.vel, w.v, w.a, w.acc)
    _mark_solved(work, t, y)


@inlined_kernel
def _mark_solved(work: Work, t: float, y: Array) -> None:
    """Take note that the work belongs to a state."""
    work.solved[0] = t
    for i in range(len(y)):
        work.solved[1 + i] = y[i]


@inlined_kernel
def is_solved(work: Work, t: float, y: Array) -> bool:
    """Whether the work belongs to a state; the contacts' memory changes only where the state is solved again."""
    for i in range(len(y)):
        if work.solved[1 + i] != y[i]:
            return False
    return work.solved[0] == t


@kernel
def derivatives(equations: Equations, t: float, y: Array, dy: Array) -> None:
    """Right-hand side of dy/dt = f(t, y)."""
    solve_state(equations, t, y)
    found_derivatives(equations, y, dy)


@inlined_kernel
def found_derivatives(equations: Equations, y: Array, dy: Array) -> None:
    """Fill the derivatives at the state y that has been solved."""
    model, work = equations.model, equations.work
    n = len(model.free)
    for i in range(n):
        dy[i] = y[n + i]
        dy[n + i] = work.dynamics.a[model.free[i]]
    _fill_others(model, work, dy, 2 * n)


@inlined_kernel
def _fill_others(model: Arrays, work: Work, dy: Array, first: int) -> None:
    """Fill the rates of the laws' states, then of states of the experiment, from a place on."""
    ns, nz, a = len(model.law_states), len(model.states), work.dynamics.a
    for k in range(ns):
        dy[first + k] = work.contacts[model.law_states[k, 0], RATES + model.law_states[k, 1]]
    for k in range(nz):
        dy[first + ns + k] = a[len(a) - nz + k]


@kernel
def arrive(equations: Equations, t: float, y: Array, dy: Array, out: Array) -> float:
    """Fill the work at a state whose derivatives are known, as at the end of a step; see `implicit`.

    Accelerations are therefore not solved for, unless they are interpolated near a singularity. Where loops are closed
    by multipliers the work is not solved, as these are unknown; the state is projected onto the closed loops anyway.

    Returns the largest force residual, see `residual`, in parts of the largest force of a contact; zero where loops are
    closed by multipliers.
    """
    model, work = equations.model, equations.work
    w, n = work.dynamics, len(model.free)
    out[:] = 0.0
    if w.interpolated[0] > 0.0:
        derivatives(equations, t, y, dy)
        return 0.0
    set_state(model, work, t, y)
    _add_forces(equations, t)
    for i in range(n):
        dy[i] = y[n + i]
        w.a[model.free[i]] = dy[n + i]
    left = 0.0 if len(model.rows) else _residual_forces(model, work, out)
    body_accelerations(model.bodies, w.pose, w.vel, w.v, w.a, w.acc)
    _fill_others(model, work, dy, 2 * n)
    if not len(model.rows):
        _mark_solved(work, t, y)
    return left


@inlined_kernel
def _residual_forces(model: Arrays, work: Work, out: Array) -> float:
    """Fill ``out`` with the force residuals of the free coordinates; return the largest.

    It is in parts of the largest force of a contact; moments count by the linkage's length. Leaves tau as it was.
    """
    w, largest, force = work.dynamics, 0.0, 0.0
    force_residual(model.bodies, model.gravity, w)
    for k in range(len(model.driven)):
        w.tau[model.driven[k]] = 0.0
    for k in range(1, len(model.bodies.records)):
        body = model.bodies.records[k]
        if body.moving and body.dof >= 0:
            left = abs(w.tau[body.dof])
            largest = max(largest, left / model.size if body.type == REVOLUTE else left)
    for i in range(len(model.free)):
        out[i] = w.tau[model.free[i]]
        w.tau[model.free[i]] = 0.0
    for k in range(len(model.powered)):
        w.tau[model.powered[k]] = work.value[k]
    for k in range(len(model.ends)):
        force = max(force, math.hypot(work.contacts[k, FX], work.contacts[k, FY]))
    return largest / force if force > 0.0 else 0.0


@inlined_kernel
def rate_residuals(model: Arrays, w: Workspace, dy: Array, out: Array) -> None:
    """Fill ``out`` with the residuals of the rates, at a state and wrenches that are set; see `residual`."""
    if len(model.rows):
        smooth_dynamics(model.bodies, model.rows, model.elimination, model.size, model.gravity, w)
        for i in range(len(model.free)):
            out[i] = w.a[model.free[i]] - dy[i]
    else:
        for i in range(len(model.free)):
            w.a[model.free[i]] = dy[i]
        force_residual(model.bodies, model.gravity, w)
        for i in range(len(model.free)):
            out[i] = w.tau[model.free[i]]


@kernel
def residual(equations: Equations, t: float, y: Array, dy: Array, out: Array) -> None:
    """Fill ``out`` with the residuals of the equations of rates and states for the derivatives ``dy``.

    See `linkages.mechanics.integrate.implicit`. Without loops that are closed by multipliers, the residual of the rates
    is the force residual of the free coordinates [N, N m]: the mass matrix times f - dy, found without the mass matrix.
    """
    model, work = equations.model, equations.work
    n = len(model.free)
    set_state(model, work, t, y)
    _add_forces(equations, t)
    rate_residuals(model, work.dynamics, dy, out)
    _fill_others(model, work, out, n)
    for k in range(n, len(out)):
        out[k] -= dy[k]


@kernel
def set_residuals(model: Arrays, w: Workspace, reaction: Array, rows: Array) -> None:
    """Subtract the forces that the accelerations need from ``tau``; fill ``rows`` (nr,) with those of the closure rows.

    Coordinates, rates, accelerations, poses, velocities and wrenches are set; the reactions (nr,) are added to the
    wrenches. So no system of equations is solved: its solution changes by the change of this residual at fixed
    accelerations and reactions.
    """
    add_reactions(model, w, reaction)
    force_residual(model.bodies, model.gravity, w)
    row_accelerations(model, w, rows)


@inlined_kernel
def add_reactions(model: Arrays, w: Workspace, reaction: Array) -> None:
    """Add the wrenches of the closure rows' reactions (nr,)."""
    for k in range(len(model.rows)):
        add_row_wrench(model.rows[k], w.pose, reaction[k], w.wrench)


@inlined_kernel
def row_accelerations(model: Arrays, w: Workspace, rows: Array) -> None:
    """Fill ``rows`` (nr,) with the accelerations of the closure rows."""
    if len(model.rows):
        body_accelerations(model.bodies, w.pose, w.vel, w.v, w.a, w.acc)
    for k in range(len(model.rows)):
        rows[k] = row_acceleration(model.rows[k], w.pose, w.vel, w.acc)


@kernel
def outside(model: Arrays, work: Work) -> int:
    """Contact whose journal has left its film, or -1."""
    for k in range(len(model.ends)):
        ex, ey = work.contacts[k, EX], work.contacts[k, EY]
        if math.sqrt(ex * ex + ey * ey) >= model.laws[k].clearance * model.limits[k]:
            return k
    return -1
