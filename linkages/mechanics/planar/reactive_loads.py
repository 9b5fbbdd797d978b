"""Loads that depend on the forces in joints, as friction does: the forces depend on accelerations, these on the loads.

At given positions and rates the forces F_j in the joints are linear in the frictions T_k along their coordinates:
F_j = F_j0 + sum_k G_jk T_k. The loads are N_j = |F_j|, and T_k = s_k N_k with a share s_k that depends on the rate
alone. So the loads solve N_j = |F_j0 + sum_k G_jk s_k N_k|. The forces without friction and their changes G come from
forward dynamics, the loads from Newton's method. If sum_k |G_jk s_k| < 1 for all joints there is one solution, as the
right-hand side is a contraction. Beyond there may be two, of which one continues the motion without friction, or none
(P. Painleve, Sur les lois du frottement de glissement, C. R. Acad. Sci. 121, 1895). Without a solution the loads are
not a number, and the run ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, Indices, Records, kernel, lazy_kernel
from linkages.mechanics.integrate.factor import back_substitute, factorise
from linkages.mechanics.planar.arrays import Arrays, functions_of, loads_of
from linkages.mechanics.planar.closure_rows import add_row_wrench, add_term_wrench
from linkages.mechanics.planar.functions import given_at, value_of
from linkages.mechanics.planar.kinematics import body_accelerations
from linkages.mechanics.planar.loads import load_wrenches
from linkages.mechanics.planar.loop_dynamics import forward_dynamics
from linkages.mechanics.planar.newton_euler import inertial_forces, joint_wrenches
from linkages.mechanics.planar.reactions import ideal_joint_force
from linkages.mechanics.planar.workspace import Workspace, make_workspace

_STEPS = 40  # largest number of Newton's steps; four are usual
_LEAST_PARTS, _MOST_PARTS = 8, 100  # of the friction
_CLOSE = 1e-13  # error of the loads at which one more step is exact, in parts of the largest load


class ReactiveLoads(NamedTuple):
    """Arrays to find loads that depend on joint forces; of size zero where there are none."""

    state: Workspace
    efforts: Array  # torque [N m] or force [N] of each load along its coordinate, zero for other loads, (nl,)


def make_reactive_loads(model: Arrays, w: Workspace) -> ReactiveLoads:
    """Make the arrays for a model whose workspace is given, all zero."""
    if not (model.loads["joint"] >= 0).any():
        return ReactiveLoads(make_workspace(0, 0, 0), np.zeros(0))
    state = make_workspace(len(w.vel), len(w.q), len(w.reaction), model.bodies.shapes.shape[2])
    return ReactiveLoads(state, np.zeros(len(model.loads)))


@kernel
def is_jammed(work: ReactiveLoads) -> bool:
    """Whether the loads that were computed last have no solution."""
    total = 0.0
    for k in range(len(work.efforts)):
        total += work.efforts[k]
    return math.isnan(total)


@kernel(makes_arrays=True)
def add_applied(model: Arrays, t: float, torques: Array, w: Workspace, work: ReactiveLoads) -> None:
    """Add the wrenches of all loads to the bodies', of those that depend on joint forces too; see `solve_reactive`."""
    load_wrenches(loads_of(model), t, w.v, w.pose, w.vel, w.wrench)
    if len(work.efforts):
        add_reactive(model, t, torques, w, work)


@lazy_kernel
def add_reactive(model: Arrays, t: float, torques: Array, w: Workspace, work: ReactiveLoads) -> None:
    """Add the wrenches of the loads that depend on joint forces to the bodies'; see `solve_reactive`."""
    solve_reactive(model, t, torques, w, work)
    add_efforts(model, work.efforts, w)


@kernel
def add_efforts(model: Arrays, efforts: Array, w: Workspace) -> None:
    """Add the wrenches of the efforts (nl,) of loads that depend on joint forces."""
    for k in range(len(efforts)):
        load = model.loads[k]
        if load.joint >= 0:
            add_term_wrench(load.term, w.pose, load.sign * efforts[k], w.wrench)


@lazy_kernel(makes_arrays=True)
def solve_reactive(model: Arrays, t: float, torques: Array, w: Workspace, work: ReactiveLoads) -> None:
    """Fill the efforts of the loads that depend on joint forces; NaN if there is no solution.

    Takes `w`'s q, v, pose, vel, the wrenches of all other forces, and the accelerations of the driven coordinates.
    ``torques`` (np,) act in the powered drives.
    """
    loads, state, m = model.loads, work.state, 0
    places = np.empty(len(loads), np.int64)
    for k in range(len(loads)):
        if loads[k].joint >= 0:
            places[m] = k
            m += 1
    given = given_at(functions_of(model), t, w.v, w.pose, w.vel)
    none, unit, change = np.zeros((m, 3), w.vel.dtype), np.zeros((m, 3), w.vel.dtype), np.zeros((m, m, 3), w.vel.dtype)
    shares, normal = np.zeros(m, w.vel.dtype), np.zeros(m, w.vel.dtype)
    _enter(w, state)
    _joint_forces(model, torques, w, state, places[:m], none)
    for j in range(m):
        load = loads[places[j]]
        shares[j] = value_of(given, load.share)
        normal[j] = _size(load.leverage, none[j, 0], none[j, 1], none[j, 2])
    for k in range(m):
        load, push = loads[places[k]], normal[k] if normal[k] > 0.0 else 1.0
        _take_wrenches(w, state)
        add_term_wrench(load.term, state.pose, load.sign * push, state.wrench)
        _joint_forces(model, torques, w, state, places[:m], unit)
        for j in range(m):
            for i in range(3):
                change[j, k, i] = (unit[j, i] - none[j, i]) / push * shares[k]
    _solve_loads(loads, places[:m], none, change, normal)
    for k in range(m):
        work.efforts[places[k]] = shares[k] * normal[k]


@kernel
def _enter(w: Workspace, state: Workspace) -> None:
    """Give a workspace the positions, velocities and wrenches of another one."""
    for i in range(len(w.q)):
        state.q[i], state.v[i] = w.q[i], w.v[i]
    for i in range(len(w.vel)):
        for k in range(w.pose.shape[1]):
            state.pose[i, k] = w.pose[i, k]
        for k in range(3):
            state.vel[i, k] = w.vel[i, k]
    _take_wrenches(w, state)


@kernel
def _take_wrenches(w: Workspace, state: Workspace) -> None:
    for i in range(len(w.wrench)):
        for k in range(3):
            state.wrench[i, k] = w.wrench[i, k]


@kernel
def _joint_forces(
    model: Arrays, torques: Array, w: Workspace, state: Workspace, places: Indices, forces: Array
) -> None:
    """Fill ``forces`` (m, 3) with the forces and moments in the joints of some loads, under the state's wrenches."""
    bodies = model.bodies
    state.a[:] = 0.0
    state.tau[:] = 0.0
    for k in range(len(model.driven)):
        state.a[model.driven[k]] = w.a[model.driven[k]]
    for k in range(len(model.powered)):
        state.tau[model.powered[k]] = torques[k]
    forward_dynamics(bodies, model.rows, model.elimination, model.gravity, state)
    body_accelerations(bodies, state.pose, state.vel, state.v, state.a, state.acc)
    inertial_forces(bodies, state, model.gravity, state.bias, state.shape_bias)
    for k in range(len(model.rows)):
        add_row_wrench(model.rows[k], state.pose, -state.reaction[k], state.bias)
    joint_wrenches(bodies, state.pose, state.bias)
    for j in range(len(places)):
        joint = model.joints[model.loads[places[j]].joint]
        fx, fy, moment = ideal_joint_force(joint, state.pose, state.bias, state.reaction)
        forces[j, 0], forces[j, 1], forces[j, 2] = fx, fy, moment


@kernel
def _size(leverage: float, fx: float, fy: float, moment: float) -> float:
    """Load of a joint: its force, or the sum of the forces at both ends of a slider."""
    return max(math.hypot(fx, fy), leverage * abs(moment))


@kernel
def _solve_loads(loads: Records, places: Indices, none: Array, change: Array, normal: Array) -> None:
    """Solve for the loads ``normal`` (m,), from those without friction; NaN if there is no solution.

    Forces are ``none`` (m, 3) plus ``change`` (m, m, 3) per load. Where more than one solution is possible the friction
    grows in parts from zero, so that the solution is the one that continues the motion without friction.
    """
    m, total = len(normal), 0.0
    for j in range(m):
        own = 0.0
        for k in range(m):
            own += _size(loads[places[j]].leverage, change[j, k, 0], change[j, k, 1], change[j, k, 2])
        total = max(total, own)
    parts = 1
    if total >= 1.0:
        parts = _LEAST_PARTS + int(min(total, _MOST_PARTS))
    found = True
    for part in range(1, parts + 1):
        found = found and _step_to(loads, places, none, change, part / parts, normal)
    for j in range(m):
        if not found or not normal[j] >= 0.0:
            normal[j] = math.nan


@kernel(makes_arrays=True)
def _step_to(loads: Records, places: Indices, none: Array, change: Array, part: float, normal: Array) -> bool:
    """Find the loads for a part of the friction by Newton's method, which starts at the loads of a smaller part.

    After they are found a further step is taken, which makes the slopes of duals exact.
    """
    m = len(normal)
    matrix, error, pivots = np.zeros((m, m), normal.dtype), np.zeros(m, normal.dtype), np.zeros(m, np.int64)
    found = False
    for _ in range(_STEPS):
        worst, largest = 0.0, 0.0
        for j in range(m):
            fx, fy, moment = none[j, 0], none[j, 1], none[j, 2]
            for k in range(m):
                fx += part * change[j, k, 0] * normal[k]
                fy += part * change[j, k, 1] * normal[k]
                moment += part * change[j, k, 2] * normal[k]
            leverage = loads[places[j]].leverage
            size, straight = _size(leverage, fx, fy, moment), math.hypot(fx, fy)
            ux, uy, um = 0.0 * fx, 0.0 * fy, math.copysign(leverage, moment)
            if straight >= leverage * abs(moment):
                um = 0.0 * moment
                if straight > 0.0:
                    ux, uy = fx / straight, fy / straight
            for k in range(m):
                slope = ux * change[j, k, 0] + uy * change[j, k, 1] + um * change[j, k, 2]
                matrix[j, k] = (1.0 if j == k else 0.0) - part * slope
            error[j] = size - normal[j]
            worst, largest = max(worst, abs(error[j])), max(largest, abs(size))
        if not factorise(matrix, pivots):
            return False
        back_substitute(matrix, pivots, error)
        for j in range(m):
            normal[j] += error[j]
        if found:
            return True
        found = worst <= _CLOSE * largest
    return False
