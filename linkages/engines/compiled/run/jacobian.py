"""Jacobian of the equations of motion.

The accelerations a(q, v) solve R(q, v, a) = 0, the force residual of the free joints and the accelerations of the
closure rows. So M times their change, with the mass matrix M, is the change of R at fixed a and fixed reactions, found
by dual numbers: first the partial derivatives of each contact's force with respect to its motion, within the bounds;
then the mechanics with contacts that are linear in their motion. With closure rows it is solved for, and M is 1.
"""

from __future__ import annotations

import math
from typing import Any

from linkages.base.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.base.kernel.dual import DIRECTIONS, put_slopes, seeded, slope, with_number
from linkages.elements.machine import add_elements
from linkages.engines.compiled.run.equations import add_reactions, is_solved, row_accelerations, solve_state
from linkages.engines.compiled.run.model import Equations, Scratch
from linkages.mechanics.planar.arrays import Arrays, functions_of, loads_of
from linkages.mechanics.planar.articulated_body import acceleration_response
from linkages.mechanics.planar.closure_rows import row_acceleration
from linkages.mechanics.planar.composite_inertia import mass_matrix
from linkages.mechanics.planar.contact_partials import MOTION, along, contact_partials
from linkages.mechanics.planar.contacts import (
    FIRST_RATE,
    FORCE_COUPLE,
    FORCE_X,
    FORCE_Y,
    RESULT_PLACES,
    ContactMotion,
    add_contact,
    contact_motion,
)
from linkages.mechanics.planar.kinematics import body_states, moved_states, moved_velocities
from linkages.mechanics.planar.loads import state_rates
from linkages.mechanics.planar.loop_dynamics import add_reactions_response, eliminate_rows
from linkages.mechanics.planar.newton_euler import force_residual, moved_residual
from linkages.mechanics.planar.reactive_loads import add_applied
from linkages.mechanics.planar.singularities import solve_neighbour
from linkages.mechanics.planar.traversal import MOVED, mark_moved
from linkages.mechanics.planar.workspace import Workspace


@lazy_kernel
def jacobian(equations: Equations, t: float, y: Array, mass: Array, out: Array) -> None:
    """Fill ``mass``, of rates and others (ny - n, ny - n), and ``out`` (ny, ny) with its product with df/dy.

    f is `linkages.engines.compiled.run.equations.derivatives`; lines of positions are those of df/dy.
    """
    model, work = equations.model, equations.work
    w, s, n, ny = work.dynamics, work.scratch, len(model.free), len(y)
    if not is_solved(work, t, y):
        solve_state(equations, t, y)
    for k in range(len(model.ends)):
        motion, _ = contact_motion(model.ends[k], w.pose, w.vel)
        contact_partials(
            model.ends[k], model.laws[k], model.tables[k], work.memory[k], motion, s.bounds[k], s.partials[k]
        )
    _fill_mass(equations, mass)
    out[:] = 0.0
    for i in range(n):
        out[i, n + i] = 1.0
    s.moves[:] = MOVED
    if ny <= DIRECTIONS:
        _fill_moved(equations, t, 0, ny, out)
        return
    for first in range(0, n, DIRECTIONS):
        _fill_moved(equations, t, first, min(DIRECTIONS, n - first), out)
    s.moves[:] = MOVED
    for first in range(n, ny, DIRECTIONS):
        _fill_faster(equations, t, first, min(DIRECTIONS, ny - first), out)


@lazy_kernel
def inertia(equations: Equations, t: float, y: Array, mass: Array) -> None:
    """Fill ``mass``, and what `close` needs, as `jacobian`."""
    if not is_solved(equations.work, t, y):
        solve_state(equations, t, y)
    _fill_mass(equations, mass)


@kernel
def _fill_mass(equations: Equations, mass: Array) -> None:
    """Fill the mass matrix at a solved state; with closure rows, what `close` needs."""
    model, w, s = equations.model, equations.work.dynamics, equations.work.scratch
    if w.interpolated[0] > 0.0:
        solve_neighbour(model.bodies, model.rows, model.elimination, model.size, model.gravity, w)
        equations.work.solved[0] = math.nan
    mass[:] = 0.0
    for i in range(len(mass)):
        mass[i, i] = 1.0
    if len(model.rows):
        eliminate_rows(model.bodies, model.rows, model.elimination, w)
        return
    mass_matrix(model.bodies, w, s.mass)
    for i in range(len(model.free)):
        for j in range(len(model.free)):
            mass[i, j] = s.mass[model.free[i], model.free[j]]


@kernel
def _fill_moved(equations: Equations, t: float, first: int, count: int, out: Array) -> None:
    """Fill columns of the Jacobian, of any kind."""
    model, w, s, n = equations.model, equations.work.dynamics, equations.work.scratch, len(equations.model.free)
    d = s.moved
    for k in range(len(model.driven)):
        place = model.driven[k]
        d.q[place], d.v[place] = w.q[place], w.v[place]
    for i in range(n):
        place = model.free[i]
        d.q[place], d.v[place] = seeded(w.q[place], i - first), seeded(w.v[place], n + i - first)
    _seed_states(model, w, d, 2 * n + len(model.law_states) - first)
    if count == out.shape[0]:
        body_states(model.bodies, d.q, d.v, d.pose, d.vel)
    else:
        _mark(model, s, first, count)
        moved_states(model.bodies, s.moves, d.q, d.v, d.pose, d.vel, w.pose, w.vel)
    _fill_columns(equations, d, t, first, count, out)


@lazy_kernel
def _mark(model: Arrays, s: Scratch, first: int, count: int) -> None:
    """Note which bodies move with so many entries of the state, of positions or of rates."""
    n = len(model.free)
    for i in range(n):
        s.changed[model.free[i]] = first <= i < first + count or first <= n + i < first + count
    mark_moved(model.bodies, s.changed, s.moves)


@lazy_kernel
def _fill_faster(equations: Equations, t: float, first: int, count: int, out: Array) -> None:
    """Fill columns of the Jacobian, of rates and states: the poses do not change."""
    model, w, s, n = equations.model, equations.work.dynamics, equations.work.scratch, len(equations.model.free)
    d = s.faster
    for k in range(len(model.driven)):
        d.v[model.driven[k]] = w.v[model.driven[k]]
    for i in range(n):
        d.v[model.free[i]] = seeded(w.v[model.free[i]], n + i - first)
    _seed_states(model, w, d, 2 * n + len(model.law_states) - first)
    _mark(model, s, first, count)
    moved_velocities(model.bodies, s.moves, d.pose, d.v, d.vel, w.vel)
    _fill_columns(equations, d, t, first, count, out)


@kernel
def _fill_columns(equations: Equations, d: Workspace, t: float, first: int, count: int, out: Array) -> None:
    """Fill columns of the Jacobian, the directions of a dual workspace whose poses and velocities are set."""
    model, work = equations.model, equations.work
    s, n = work.scratch, len(model.free)
    d.tau[:] = 0.0
    d.wrench[:] = 0.0
    for k in range(len(model.ends)):
        motion = _add_linear_contact(equations, d, k, 2 * n - first)
        for m in range(len(model.law_states)):
            if model.law_states[m, 0] == k:
                rate = _linear(equations, k, FIRST_RATE + model.law_states[m, 1], motion, 2 * n - first)
                for j in range(count):
                    out[2 * n + m, first + j] = slope(rate, j)
    if len(model.states):
        fill_states(model, d, t, d.tau, first, first + count, out)
    add_elements(model.elements, functions_of(model), t, d.v, d.pose, d.vel, d.wrench)
    if len(model.loads):
        add_applied(model, t, work.value, d, s.reactive)
    add_reactions(model, d, work.dynamics.reaction)
    if count == out.shape[0]:
        force_residual(model.bodies, model.gravity, d)
    else:
        moved_residual(model.bodies, model.gravity, s.moves, d)
    row_accelerations(model, d, s.rows)
    fill_solved(equations, d.tau, s.rows, first, first + count, out[n:])


@lazy_kernel
def fill_states(model: Arrays, w: Workspace, t: float, rates: Array, first: int, last: int, out: Array) -> None:
    """Fill columns of the last lines of ``out`` with the slopes of the rates of states; ``rates`` (n,) to work in."""
    nz = len(model.states)
    state_rates(loads_of(model), t, w.v, w.pose, w.vel, rates)
    for k in range(nz):
        put(rates[len(rates) - nz + k], len(out) - nz + k, first, last, out)
        rates[len(rates) - nz + k] = 0.0


@kernel
def fill_solved(equations: Equations, tau: Array, rows: Array, first: int, last: int, out: Array) -> None:
    """Fill columns of ``out`` with slopes of the free coordinates' forces; with rows, of accelerations, see `close`."""
    model, s = equations.model, equations.work.scratch
    if not len(model.rows):
        for i in range(len(model.free)):
            put(tau[model.free[i]], i, first, last, out)
        return
    for j in range(first, last):
        close(model, equations.work.dynamics, s, tau, rows, j - first)
        for i in range(len(model.free)):
            out[i, j] = s.a[model.free[i]]


@inlined_kernel
def put(x: float, row: int, first: int, last: int, out: Array) -> None:
    """Put the slopes of a dual into columns of a row."""
    if last - first == DIRECTIONS:
        put_slopes(out, row, first, x)
        return
    for j in range(first, last):
        out[row, j] = slope(x, j - first)


@kernel
def _seed_states(model: Arrays, w: Workspace, d: Workspace, before: int) -> None:
    """Give a dual workspace the states; the slope of the first one has the index `before`."""
    for k in range(len(model.states)):
        place = len(w.v) - len(model.states) + k
        d.v[place] = seeded(w.v[place], before + k)


@inlined_kernel
def _add_linear_contact(equations: Equations, d: Workspace, k: int, before: int) -> ContactMotion:
    """Add the wrenches of contact k, linear in its motion and states, to dual ones; return its motion.

    The slope of the first state of all laws has the index `before`.
    """
    end = equations.model.ends[k]
    motion, arms = contact_motion(end, d.pose, d.vel)
    fx = _linear(equations, k, FORCE_X, motion, before)
    fy = _linear(equations, k, FORCE_Y, motion, before)
    couple = _linear(equations, k, FORCE_COUPLE, motion, before)
    add_contact(d.wrench, end, d.pose, motion[0], motion[1], arms, fx, fy, couple)
    return motion


@inlined_kernel
def _linear(equations: Equations, k: int, i: int, motion: ContactMotion, before: int) -> Any:
    """Return a result of contact k as a dual number that is linear in its motion and its states."""
    partials, states = equations.work.scratch.partials[k, i], equations.model.law_states
    total = along(partials, motion)
    for m in range(len(states)):
        if states[m, 0] == k:
            total += partials[MOTION + states[m, 1]] * seeded(0.0, before + m)
    return with_number(total, equations.work.contacts[k, RESULT_PLACES[i]])


@lazy_kernel
def close(model: Arrays, w: Workspace, s: Scratch, tau: Array, rows: Array, direction: int) -> None:
    """Fill the scratch's ``a`` with the changes of accelerations along one of the directions, with loops kept closed.

    Parameters
    ----------
    tau : (n,) array of duals
        Generalised forces.
    rows : (nr,) array of duals
        Accelerations of the rows, at fixed accelerations of the coordinates.
    """
    s.tau[:] = 0.0
    s.a[:] = 0.0
    w.bias[:] = 0.0
    w.shape_bias[:] = 0.0
    for i in range(len(model.free)):
        s.tau[model.free[i]] = slope(tau[model.free[i]], direction)
    acceleration_response(model.bodies, w, w.bias, w.shape_bias, s.tau, s.a)
    for k in range(len(model.rows)):
        w.row_error[k] = -row_acceleration(model.rows[k], w.pose, w.zero_velocity, w.response)
        w.row_error[k] -= slope(rows[k], direction)
    add_reactions_response(model.bodies, model.rows, model.elimination, w, s.reaction, s.a)
