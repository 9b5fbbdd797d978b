"""Linearised equations of motion: derivatives at a state; matrices about a state at rest, with ideal loops closed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.base.kernel import Array, kernel
from linkages.base.kernel.by_reference import reference
from linkages.engines.compiled.run.equations import derivatives, set_state
from linkages.engines.compiled.run.jacobian import jacobian
from linkages.engines.compiled.run.model import Equations
from linkages.engines.compiled.run.runner import Runner
from linkages.mechanics.planar.closure import free_jacobian
from linkages.mechanics.planar.closure_rows import row_acceleration
from linkages.mechanics.planar.composite_inertia import mass_matrix
from linkages.mechanics.planar.kinematics import body_accelerations, body_velocities


class Closure(NamedTuple):
    """Derivatives of the nr closure rows at a state, with nf free coordinates."""

    rows: Array  # change of the rows with the free coordinates, and of their rates with the free rates, (nr, nf)
    turning: Array  # change of the rows' rates with the free coordinates, (nr, nf)
    rank: int  # number of independent rows


class Slopes(NamedTuple):
    """Derivatives of the equations dy/dt = f(t, y) at a state y (ny,), with n coordinates."""

    rates: Array  # f, (ny,)
    jacobian: Array  # df/dy, (ny, ny)
    masses: Array  # mass matrix of all coordinates, (n, n); zero rows and columns for prescribed ones
    closure: Closure


class Linear(NamedTuple):
    """Matrices of M x'' + C x' + K x = 0: ``ways @ x``, with m entries of x, changes the n free coordinates."""

    mass: Array  # (m, m), in SI units of the coordinates: rad, m
    damping: Array
    stiffness: Array
    ways: Array  # orthonormal columns, (n, m)
    masses: Array  # mass matrix of the free coordinates, (n, n)
    acceleration: Array  # of the state itself, zero in equilibrium, (m,)


@kernel
def _fill(equations: Equations, t: float, y: Array, dy: Array, mass: Array, out: Array, masses: Array) -> None:
    derivatives(reference(equations), t, y, dy)
    jacobian(reference(equations), t, y, mass, out)
    mass_matrix(equations.model.bodies, reference(equations.work.dynamics), masses)


@kernel
def _place(equations: Equations, t: float, y: Array) -> None:
    set_state(equations.model, reference(equations.work), t, y)


@kernel(makes_arrays=True)
def _row_curvature(equations: Equations, v: Array, out: Array) -> None:
    """Fill out (nr,) with the accelerations of the closure rows at rates v (n,) and zero accelerations."""
    model, w = equations.model, equations.work.dynamics
    vel, acc = np.zeros_like(w.vel), np.zeros_like(w.acc)
    body_velocities(model.bodies, w.pose, v, vel)
    body_accelerations(model.bodies, w.pose, vel, v, w.zero_force, acc)
    for k in range(len(model.rows)):
        out[k] = row_acceleration(model.rows[k], w.pose, vel, acc)


def slopes(runner: Runner, t: float, y: Array) -> Slopes:
    """Differentiate the equations of motion at a time t [s] and a state y (ny,) of a runner.

    The mechanics are differentiated exactly, the laws of contacts by differences of the fourth order. The runner's
    system has a Jacobian, that is the integrator ``radau_iia_5``. Its contacts must be open or have a film: the copy of
    the equations has no approach speeds.
    """
    equations, model = runner.aside(), runner.model
    n, ny, w = len(model.free), len(y), equations.work.dynamics
    rates, mass, out, masses = np.zeros(ny), np.zeros((ny - n, ny - n)), np.zeros((ny, ny)), np.zeros((len(w.q),) * 2)
    _fill(equations, t, y, rates, mass, out, masses)
    out[n:] = np.linalg.solve(mass, out[n:])
    return Slopes(rates, out, masses, closure_at(runner, t, y))


def closure_at(runner: Runner, t: float, y: Array) -> Closure:
    """Differentiate the closure rows at a state; see `Slopes`."""
    equations, model = runner.aside(), runner.model
    w = equations.work.dynamics
    _place(equations, t, y)
    rows = np.empty((len(model.rows), len(model.free)))
    free_jacobian(model.bodies, model.rows, w.pose, len(w.q), model.free, rows)
    turning, up, down = np.zeros_like(rows), np.zeros(len(rows)), np.zeros(len(rows))
    if len(rows) and w.v.any():
        for k, place in enumerate(model.free):  # the rows' accelerations are quadratic in the rates: polarisation
            unit = np.zeros(len(w.q))
            unit[place] = np.abs(w.v).max()
            _row_curvature(equations, w.v + unit, up)
            _row_curvature(equations, w.v - unit, down)
            turning[:, k] = (up - down) / (4.0 * unit[place])
    return Closure(rows, turning, model.elimination.rank)


def linearised(runner: Runner, t: float) -> Linear:
    """Linearise the equations of motion about the start of a runner's system, which stands still.

    Its loads are those at t [s]. It has no contacts, and is stiff, so that it has a Jacobian. The
    additional states keep their values.
    """
    model, n = runner.model, len(runner.model.free)
    rates, changes, masses, (rows, _, _) = slopes(runner, t, runner.start)
    own = masses[np.ix_(model.free, model.free)]
    ways = np.linalg.svd(rows)[2][model.elimination.rank :].T if len(rows) else np.eye(n)
    pushed = ways.T @ own
    still: Array = np.linalg.solve(pushed @ ways, pushed @ rates[n : 2 * n]).astype(np.float64)
    return Linear(
        pushed @ ways,
        -pushed @ changes[n : 2 * n, n : 2 * n] @ ways,
        -pushed @ changes[n : 2 * n, :n] @ ways,
        ways,
        own,
        still,
    )
