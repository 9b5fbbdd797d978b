"""Jacobian of the equations of motion.

The accelerations a(q, v) solve R(q, v, a) = 0, the force residual of the free joints and the accelerations of the
closure rows. So M times their change, with the mass matrix M, is the change of R at fixed a: exact derivatives of the
mechanics (`tangent`), and partial derivatives of the contacts' laws (`partials`). With closure rows it is solved for,
and M is 1.
"""

from __future__ import annotations

import math
from typing import Any

from linkages.engines.compiled.equations import is_solved, solve_state
from linkages.engines.compiled.model import Equations, Work
from linkages.kernel import Array, inlined_kernel, kernel, lazy_kernel
from linkages.kernel.simd import WIDTH, lane, with_lane
from linkages.planar.arrays import Arrays
from linkages.planar.articulated_body import acceleration_response
from linkages.planar.closure_rows import add_row_wrench, row_acceleration
from linkages.planar.composite_inertia import mass_matrix
from linkages.planar.contact_partials import (
    BRISTLE_RATE,
    COUPLE,
    FINE,
    FORCE_X,
    FORCE_Y,
    INPUTS,
    contact_partials,
    exact_partials,
    is_bounded,
)
from linkages.planar.contacts import APPROACH, BRISTLE, FX, FY, contact_motion
from linkages.planar.flexible_tangent import prepare_flexible
from linkages.planar.loads import load_wrenches_tangent
from linkages.planar.loop_dynamics import row_responses, solve_rows
from linkages.planar.markers import add_pair_tangent, both_at_b, gap, gap_rate_tangent, gap_tangent, turned
from linkages.planar.newton_euler import inertial_forces, joint_wrenches
from linkages.planar.record_types import CORNER
from linkages.planar.singularities import solve_neighbour
from linkages.planar.tangent import (
    body_tangents,
    inertial_tangents,
    rate_tangents,
    residual_tangents,
    row_tangents,
    value_tangents,
)
from linkages.planar.tangent_workspace import Scratch
from linkages.planar.workspace import Workspace


@lazy_kernel
def jacobian(equations: Equations, t: float, y: Array, mass: Array, out: Array) -> None:
    """Fill ``mass``, of rates and bristles (ny - n, ny - n), and ``out`` (ny, ny) with its product with df/dy.

    f is `linkages.engines.compiled.equations.derivatives`; lines of positions are those of df/dy. Films are
    differentiated by forward differences, which is enough for Newton's method.
    """
    _fill(equations, t, y, False, mass, out)


@lazy_kernel
def exact_jacobian(equations: Equations, t: float, y: Array, mass: Array, out: Array) -> None:
    """Fill the same as `jacobian`, films with more digits, and `exact_partials` where the bounds say so."""
    _fill(equations, t, y, True, mass, out)


@kernel
def _fill(equations: Equations, t: float, y: Array, exact: bool, mass: Array, out: Array) -> None:
    """Fill the Jacobian."""
    model, work = equations.model, equations.work
    w, n, nz = work.dynamics, len(model.free), len(model.bristles)
    if not is_solved(work, t, y):
        solve_state(equations, t, y)
    s = work.scratch
    for k in range(len(model.ends)):
        motion, _ = contact_motion(model.ends[k], w.pose, w.vel)
        approach, bristle = work.memory[k, APPROACH], work.memory[k, BRISTLE]
        end, law, table = model.ends[k], model.laws[k], model.tables[k]
        if exact and (s.bounds[k, FINE] > 0.0 or is_bounded(s.bounds[k])):
            exact_partials(end, law, table, approach, bristle, motion, s.bounds[k], s.partials[k])
        else:
            contact_partials(end, law, table, work.memory[k], motion, exact, work.contacts[k], s.partials[k])
    if w.interpolated[0] > 0.0:
        solve_neighbour(model.bodies, model.rows, model.rank, model.size, model.gravity, w)
        work.solved[0] = math.nan
    inertial_forces(model.bodies, w, model.gravity, s.force, w.modal_bias)
    for k in range(len(model.rows)):
        add_row_wrench(model.rows[k], w.pose, -w.reaction[k], s.force)
    joint_wrenches(model.bodies, w.pose, s.force)
    mass[:] = 0.0
    for i in range(len(mass)):
        mass[i, i] = 1.0
    if len(model.rows):
        row_responses(model.bodies, model.rows, w)
    else:
        mass_matrix(model.bodies, w, s.mass)
        for i in range(n):
            for j in range(n):
                mass[i, j] = s.mass[model.free[i], model.free[j]]
    if model.bodies.shapes.shape[2] > 0:
        prepare_flexible(model.bodies, model.gravity, w, s)
    out[:] = 0.0
    for first in range(0, n, WIDTH):
        count = min(WIDTH, n - first)
        for k in range(count):
            place = model.free[first + k]
            s.changed[place], s.dq[place] = 1.0, with_lane(s.dq[place], k, 1.0)
        body_tangents(model.bodies, w, s)
        _fill_columns(equations, s, t, first, count, out)
        rate_tangents(model.bodies, s)
        _fill_columns(equations, s, t, n + first, count, out)
        for k in range(count):
            out[first + k, n + first + k] = 1.0
            s.changed[model.free[first + k]], s.dq[model.free[first + k]] = 0.0, 0.0
    for first in range(0, nz, WIDTH):
        count = min(WIDTH, nz - first)
        for k in range(count):
            place = model.bristles[first + k]
            s.dz[place] = with_lane(s.dz[place], k, 1.0)
        body_tangents(model.bodies, w, s)
        _fill_columns(equations, s, t, 2 * n + first, count, out)
        for k in range(count):
            s.dz[model.bristles[first + k]] = 0.0


@kernel
def value_columns(equations: Equations, t: float, count: int, out: Array) -> None:
    """Fill ``out`` (ny, count) with the changes of the residual along numbers of the model, as `exact_jacobian`.

    `exact_jacobian` has been called at this state; the scratch has the changes of the numbers.
    """
    model, s = equations.model, equations.work.scratch
    if s.moves[0] > 0.0:
        value_tangents(model.bodies, equations.work.dynamics, s)
    _fill_columns(equations, s, t, 0, count, out)


@kernel
def _fill_columns(equations: Equations, s: Scratch, t: float, first: int, count: int, out: Array) -> None:
    """Fill the lines of rates and bristles in some columns of the Jacobian, those of the tangents in `s`."""
    model, work = equations.model, equations.work
    w, n, bodies = work.dynamics, len(model.free), model.bodies
    s.dwrench[:] = 0.0
    for k in range(len(model.ends)):
        rate = _contact_tangent(model, work, s, k)
        for m in range(len(model.bristles)):
            if model.bristles[m] == k:
                for column in range(count):
                    out[2 * n + m, first + column] = lane(rate, column)
    if len(model.loads):
        _add_loads_tangent(equations, s, t, count)
    if len(model.rows):
        row_tangents(model.rows, w, s)
    inertial_tangents(bodies, model.gravity, w, s)
    for i in range(len(bodies.records)):
        for k in range(3):
            s.dbias[i, k] -= s.dwrench[i, k]
    residual_tangents(bodies, w, s)
    for column in range(count):
        if len(model.rows):
            _close(model, w, s, column)
        for i in range(n):
            place = model.free[i]
            out[n + i, first + column] = s.da[place] if len(model.rows) else -lane(s.dtau[place], column)


@kernel
def _close(model: Arrays, w: Workspace, s: Scratch, column: int) -> None:
    """Find the changes of accelerations along one of the directions, with loops that stay closed."""
    nr = len(model.rows)
    for i in range(len(s.tau)):
        s.tau[i], s.da[i] = -lane(s.dtau[i], column), 0.0
    s.bias[:] = 0.0
    s.modal_bias[:] = 0.0
    acceleration_response(model.bodies, w, s.bias, s.modal_bias, s.tau, s.da)
    for k in range(nr):
        w.row_error[k] = -row_acceleration(model.rows[k], w.pose, w.zero_velocity, w.response) - lane(
            s.drows[k], column
        )
        for m in range(nr):
            s.row_matrix[k, m] = w.row_matrix[k, m]
    solve_rows(model.rows, model.rank, s.row_matrix, w.row_error, w.pivots, s.dreaction)
    for k in range(nr):
        for i in range(len(s.da)):
            s.da[i] += s.dreaction[k] * w.row_response[k, i]


@kernel
def _add_loads_tangent(equations: Equations, s: Scratch, t: float, count: int) -> None:
    """Add the changes of the applied loads' wrenches, direction by direction: their functions are of numbers."""
    model, w = equations.model, equations.work.dynamics
    tables = (model.loads, model.signals, model.load_t, model.load_c, model.load_n)
    dpose, dvel, dwrench = s.one
    for column in range(count):
        for i in range(len(dpose)):
            for k in range(3):
                dpose[i, k], dvel[i, k] = lane(s.dpose[i, k], column), lane(s.dvel[i, k], column)
                dwrench[i, k] = 0.0
        load_wrenches_tangent(tables, t, w.pose, w.vel, dpose, dvel, dwrench)
        for i in range(len(dpose)):
            for k in range(3):
                s.dwrench[i, k] = with_lane(s.dwrench[i, k], column, lane(s.dwrench[i, k], column) + dwrench[i, k])


@inlined_kernel
def _gap_changes(model: Arrays, w: Workspace, s: Scratch, k: int) -> Any:
    """Compute a contact's gap and the arms of its markers, and the changes of both."""
    end = model.ends[k]
    ex, ey, arms = gap(w.pose, end.bearing, end.journal)
    dex, dey, moved = gap_tangent(s.dpose, end.bearing, end.journal, arms)
    if s.moves[0] > 0.0:
        ax, ay = turned(w.pose, end.bearing.body, s.dmarker[k, 0], s.dmarker[k, 1])
        bx, by = turned(w.pose, end.journal.body, s.dmarker[k, 2], s.dmarker[k, 3])
        dex, dey = dex + bx - ax, dey + by - ay
        moved = moved[0] + ax, moved[1] + ay, moved[2] + bx, moved[3] + by
    return ex, ey, arms, dex, dey, moved


@inlined_kernel
def contact_inputs(model: Arrays, w: Workspace, s: Scratch, k: int) -> Any:
    """Compute the changes of the inputs of `linkages.planar.contact_partials`, in lanes."""
    return _inputs(model, w, s, k, _gap_changes(model, w, s, k))


@inlined_kernel
def _inputs(model: Arrays, w: Workspace, s: Scratch, k: int, changes: Any) -> Any:
    """Compute `contact_inputs` from the changes of the gap."""
    end = model.ends[k]
    b, j = end.bearing.body, end.journal.body
    _, _, arms, dex, dey, moved = changes
    dvx, dvy = gap_rate_tangent(w.vel, s.dvel, end.bearing, end.journal, arms, moved)
    turn = s.dpose[b, 0]
    frame = turn, s.dpose[j, 0]  # change of the last two entries of `ContactMotion`
    if end.kind == CORNER:
        nx, ny = turned(w.pose, b, end.nx, end.ny)
        frame = -turn * ny, turn * nx
    return dex, dey, dvx, dvy, s.dvel[b, 0], s.dvel[j, 0], frame[0], frame[1], s.dz[k]


@kernel
def _contact_tangent(model: Arrays, work: Work, s: Scratch, k: int) -> Any:
    """Add the change of a contact's wrenches; returns the change of its bristles' rate, in lanes."""
    w, end = work.dynamics, model.ends[k]
    b, j = end.bearing.body, end.journal.body
    changes = _gap_changes(model, w, s, k)
    ex, ey, arms, dex, dey, moved = changes
    inputs = _inputs(model, w, s, k, changes)
    dfx, dfy, dcouple, drate = s.dlaw[k, FORCE_X], s.dlaw[k, FORCE_Y], s.dlaw[k, COUPLE], s.dlaw[k, BRISTLE_RATE]
    for i in range(INPUTS):
        dfx += s.partials[k, FORCE_X, i] * inputs[i]
        dfy += s.partials[k, FORCE_Y, i] * inputs[i]
        dcouple += s.partials[k, COUPLE, i] * inputs[i]
        drate += s.partials[k, BRISTLE_RATE, i] * inputs[i]
    # both forces act at the journal's marker
    arms, moved = both_at_b(arms, ex, ey), both_at_b(moved, dex, dey)
    force = work.contacts[k, FX], work.contacts[k, FY]
    add_pair_tangent(s.dwrench, end.bearing, end.journal, arms, moved, force, (dfx, dfy))
    s.dwrench[j, 0] += dcouple
    s.dwrench[b, 0] -= dcouple
    return drate
