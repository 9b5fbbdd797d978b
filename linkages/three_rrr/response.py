"""Elastic response over the motion: quasi-static, the paper's recursion, generalised-alpha."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.mechanics.flexible import response as flexible
from linkages.mechanics.flexible.modes import continued, dense_modes
from linkages.three_rrr.branch import AssemblyBranch
from linkages.three_rrr.finite_elements import FiniteElementModel, velocity_terms
from linkages.three_rrr.kinematics import RobotMotion
from linkages.three_rrr.modes import DENSE

ResponseStart = Literal["rest", "quasi-static"]


@dataclass(frozen=True)
class Response:
    """Elastic displacements over the rigid motion.

    Attributes
    ----------
    motion : RobotMotion
        The rigid motion at N times.
    u, v, a : (N, size) arrays
        Unknowns of the model, their rates and accelerations [m, rad, s].
    platform : (N, 3) array
        Elastic displacement of the platform: x, y [m], rotation [rad].
    """

    motion: RobotMotion
    u: Array
    v: Array
    a: Array
    platform: Array


def quasi_static(model: FiniteElementModel, state: RobotMotion) -> Array:
    """Displacements (N, size) under the loads of the rigid motion, without vibration.

    InputError if the crank roots are free: nothing holds the mechanism.
    """
    _require_held(model)
    load = model.load(state)
    if model.size > DENSE:
        pairs = zip(model.sparse_matrices(state), load, strict=True)
        return np.array([flexible.quasi_static(k, f) for (k, _), f in pairs])
    result = np.empty_like(load)
    for start in range(0, len(state), flexible.BATCH):
        part = slice(start, start + flexible.BATCH)
        result[part] = flexible.quasi_static(model.matrices(state.part(part))[0], load[part])
    return result


def quasi_static_response(model: FiniteElementModel, state: RobotMotion) -> Response:
    """Quasi-static displacements as a response, without elastic rates."""
    u = quasi_static(model, state)
    none = np.zeros_like(u)
    return Response(state, u, none, none, model.platform_displacement(state, u))


def recursion(model: FiniteElementModel, branch: AssemblyBranch, times: Array, printed: bool = False) -> Response:
    """Response from rest by the paper's recursion, eq. (13): matrices and loads constant over a step, each mode exact.

    With free roots nothing but inertia holds the mechanism: three modes are rigid, and it falls behind its prescribed
    motion. `printed` returns from the modal basis of a step with the basis of the next step, as printed, in which modes
    keep their order and signs; by default the basis is the same both ways.
    """
    state = branch.motion(times)
    rigid = 3 if model.robot.drives.roots == "free" else 0
    u, v, a = np.zeros((3, len(times), model.size))
    alpha, beta = model.robot.damping.mass, model.robot.damping.stiffness
    load = model.load(state)
    for first in range(0, len(times), flexible.BATCH):
        part = slice(first, min(first + flexible.BATCH + 1, len(times)))
        k, m = model.matrices(state.part(part))
        values, shapes = dense_modes(k, m, model.size)
        for i in range(part.stop - part.start):
            n, form = first + i, shapes[i]
            a[n] = np.linalg.solve(m[i], load[n] - k[i] @ u[n] - (alpha * m[i] + beta * k[i]) @ v[n])
            if n + 1 == part.stop:
                break
            into = form.T @ m[i]
            q, dq = flexible.modal_step(
                values[i], alpha, beta, into @ u[n], into @ v[n], form.T @ load[n], times[n + 1] - times[n]
            )
            out = continued(form, shapes[i + 1], m[i + 1], rigid)[1] if printed else form
            u[n + 1], v[n + 1] = out @ q, out @ dq
    return Response(state, u, v, a, model.platform_displacement(state, u))


def generalised_alpha(
    model: FiniteElementModel,
    branch: AssemblyBranch,
    times: Array,
    start: ResponseStart = "rest",
    radius: float = 0.9,
    velocity_dependent: bool = False,
) -> Response:
    """Response by the generalised-alpha method at all times, see `march`."""
    parts = [(r.u, r.v, r.a, r.platform) for r in march(model, branch, times, start, radius, velocity_dependent)]
    return Response(branch.motion(times), *(np.concatenate(column) for column in zip(*parts, strict=True)))


def march(
    model: FiniteElementModel,
    branch: AssemblyBranch,
    times: Array,
    start: ResponseStart = "rest",
    radius: float = 0.9,
    velocity_dependent: bool = False,
) -> Iterator[Response]:
    """Response by the generalised-alpha method, see `generalised_alpha`, part by part.

    The times (N,) are equally spaced [s]; the parts follow each other, together at all of them. The start is "rest" (no
    displacement and no rate) or "quasi-static". The radius is the spectral radius at infinite frequency: 1 keeps all
    energy, 0 damps the highest modes at once. The terms of `linkages.three_rrr.finite_elements` can act. InputError if
    the radius lies outside [0, 1], or the crank roots are free and the start or these terms need the quasi-static
    solution.
    """
    if velocity_dependent:
        _require_held(model)
    alpha, beta = model.robot.damping.mass, model.robot.damping.stiffness

    def matrices(at: Array) -> tuple[Array, Array, Array, Array]:
        state = branch.motion(at)
        k, m = model.matrices(state)
        c = alpha * m + beta * k
        f = model.load(state)
        if velocity_dependent:
            gyro, stiff = velocity_terms(model, state, flexible.quasi_static(k, f))
            c, k = c + gyro, k + stiff
        return m, c, k, f

    done = 0
    for u, v, a in flexible.generalised_alpha(matrices, times, *_start(model, branch, start), radius):
        state = branch.motion(times[done : done + len(u)])
        done += len(u)
        yield Response(state, u, v, a, model.platform_displacement(state, u))


def _start(model: FiniteElementModel, branch: AssemblyBranch, start: ResponseStart) -> tuple[Array, Array]:
    """Displacements and rates (size,) at t = 0."""
    if start == "rest":
        return np.zeros(model.size), np.zeros(model.size)
    step = 1e-3 * float(branch.times[1])
    u = quasi_static(model, branch.motion(step * np.arange(3.0)))
    return u[0], (-1.5 * u[0] + 2.0 * u[1] - 0.5 * u[2]) / step


def _require_held(model: FiniteElementModel) -> None:
    if model.robot.drives.roots == "free":
        problem = 'is "free": nothing holds the mechanism; use "locked" or "servo" for a response'
        raise InputError(model.robot.source, "drives.roots", problem)
