"""Elastic response over the motion: quasi-static, the paper's recursion, generalised-alpha."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from linkages.errors import InputError
from linkages.three_rrr.branch import Branch
from linkages.three_rrr.kinematics import Motion
from linkages.three_rrr.model import Model
from linkages.three_rrr.modes import DENSE, dense
from linkages.three_rrr.rotating import velocity_terms

Array = NDArray[np.floating]
Matrices = Callable[[Array], tuple[Array, Array, Array, Array]]
Start = Literal["rest", "quasi-static"]

_BATCH = 256  # poses whose matrices are held at a time


@dataclass(frozen=True)
class Response:
    """Elastic displacements over time.

    Attributes
    ----------
    motion : Motion
        The rigid motion at N times.
    u, v, a : (N, size) arrays
        Unknowns of the model, their rates and accelerations [m, rad].
    platform : (N, 3) array
        Elastic displacement of the platform: x, y [m], turning [rad].
    """

    motion: Motion
    u: Array
    v: Array
    a: Array
    platform: Array


def quasi_static(model: Model, state: Motion) -> Array:
    """Displacements (N, size) under the loads of the rigid motion, without vibration."""
    _require_held(model)
    load = model.load(state)
    if model.size > DENSE:
        return np.array([spsolve(k, f) for (k, _), f in zip(model.sparse_matrices(state), load, strict=True)])
    result = np.empty_like(load)
    for start in range(0, len(state), _BATCH):
        part = slice(start, start + _BATCH)
        k, _ = model.matrices(state.part(part))
        result[part] = np.linalg.solve(k, load[part][..., None])[..., 0]
    return result


def quasi_static_response(model: Model, state: Motion) -> Response:
    """Quasi-static displacements as a response, without elastic rates."""
    u = quasi_static(model, state)
    none = np.zeros_like(u)
    return Response(state, u, none, none, model.platform_displacement(state, u))


def recursion(
    model: Model, branch: Branch, times: Array, start: Start = "rest", printed: bool = False
) -> Response:
    """Run the paper's recursion, eq. (13): matrices and loads constant over each step, each mode exact.

    The state is taken into the modal basis of its own step and back with the *same* basis. The printed
    scheme goes back with the basis of the next step; eigenvectors' signs are arbitrary, so that it feeds
    energy in. `printed` shows it.

    Parameters
    ----------
    times : (N,) array
        Rising times [s].
    start : str
        "rest": no displacement and no rate; "quasi-static": on the quasi-static solution.
    """
    _require_held(model)
    state = branch.motion(times)
    u, v = np.zeros((2, len(times), model.size))
    a = np.zeros_like(u)
    u[0], v[0] = _start(model, branch, start)
    alpha, beta = model.robot.damping.mass, model.robot.damping.stiffness
    load = model.load(state)
    for first in range(0, len(times), _BATCH):
        part = slice(first, min(first + _BATCH + 1, len(times)))
        k, m = model.matrices(state.part(part))
        values, shapes = dense(k, m, model.size)
        for i in range(part.stop - part.start):
            n, form = first + i, shapes[i]
            a[n] = np.linalg.solve(m[i], load[n] - k[i] @ u[n] - (alpha * m[i] + beta * k[i]) @ v[n])
            if n + 1 == part.stop:
                break
            into = form.T @ m[i]
            q, dq = _modal_step(
                values[i], alpha, beta, into @ u[n], into @ v[n], form.T @ load[n], times[n + 1] - times[n]
            )
            out = shapes[i + 1] if printed else form
            u[n + 1], v[n + 1] = out @ q, out @ dq
    return Response(state, u, v, a, model.platform_displacement(state, u))


def _modal_step(
    square: Array, alpha: float, beta: float, q: Array, dq: Array, force: Array, step: float
) -> tuple[Array, Array]:
    """Exact solution of q'' + (alpha + beta p^2) q' + p^2 q = force after a step."""
    decay = 0.5 * (alpha + beta * square)
    inner = np.sqrt((square - decay**2).astype(complex))
    inner = np.where(np.abs(inner) < 1e-12, 1e-12, inner)
    c, s = np.real(np.cos(inner * step)), np.real(np.sin(inner * step) / inner)
    rest, shrink = force / square, np.exp(-decay * step)
    from_rest = q - rest
    return (
        rest + shrink * (from_rest * (c + decay * s) + dq * s),
        shrink * (dq * (c - decay * s) - square * from_rest * s),
    )


def generalised_alpha(
    model: Model,
    branch: Branch,
    times: Array,
    start: Start = "rest",
    radius: float = 0.9,
    velocity_dependent: bool = False,
) -> Response:
    """Response by the generalised-alpha method of Chung and Hulbert (1993), second order in the step.

    Parameters
    ----------
    times : (N,) array
        Equally spaced [s].
    start : str
        As in `recursion`.
    radius : float
        Spectral radius at infinite frequency: 1 keeps all energy, 0 damps the highest modes at once.
    velocity_dependent : bool
        Whether the terms of `linkages.three_rrr.rotating` act.
    """
    _require_held(model)
    alpha, beta = model.robot.damping.mass, model.robot.damping.stiffness

    def matrices(at: Array) -> tuple[Array, Array, Array, Array]:
        state = branch.motion(at)
        k, m = model.matrices(state)
        c = alpha * m + beta * k
        f = model.load(state)
        if velocity_dependent:
            gyro, stiff = velocity_terms(model, state, np.linalg.solve(k, f[..., None])[..., 0])
            c, k = c + gyro, k + stiff
        return m, c, k, f

    u0, v0 = _start(model, branch, start)
    u, v, a = integrate(matrices, times, u0, v0, radius)
    state = branch.motion(times)
    return Response(state, u, v, a, model.platform_displacement(state, u))


def integrate(
    matrices: Matrices, times: Array, u0: Array, v0: Array, radius: float
) -> tuple[Array, Array, Array]:
    """Integrate M(t) u'' + C(t) u' + K(t) u = f(t); returns u, u', u'' (N, size).

    Parameters
    ----------
    matrices : callable
        (M, C, K, f) at any times: (n, size, size) each, and (n, size).
    times : (N,) array
        Equally spaced [s].
    radius : float
        Spectral radius at infinite frequency, in [0, 1].
    """
    if not 0.0 <= radius <= 1.0:
        raise InputError("generalised-alpha", "radius", f"is {radius:g}; it must lie in [0, 1]")
    am, af = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
    gamma = 0.5 - am + af
    beta = 0.25 * (1.0 - am + af) ** 2
    h = float(times[1] - times[0])
    u, v, a = np.zeros((3, len(times), len(u0)))
    u[0], v[0] = u0, v0
    m, c, k, f = (matrix[0] for matrix in matrices(times[:1]))
    a[0] = np.linalg.solve(m, f - k @ u0 - c @ v0)
    for first in range(0, len(times) - 1, _BATCH):
        last = min(first + _BATCH, len(times) - 1)
        m, c, k, f = matrices(times[first:last] + (1.0 - af) * h)
        inverse = np.linalg.inv((1 - am) * m + (1 - af) * h * (gamma * c + beta * h * k))
        for n in range(first, last):
            i = n - first
            drift_u = u[n] + h * v[n] + (0.5 - beta) * h * h * a[n]
            drift_v = v[n] + (1.0 - gamma) * h * a[n]
            held = am * (m[i] @ a[n])
            held += c[i] @ ((1 - af) * drift_v + af * v[n]) + k[i] @ ((1 - af) * drift_u + af * u[n])
            a[n + 1] = inverse[i] @ (f[i] - held)
            u[n + 1] = drift_u + beta * h * h * a[n + 1]
            v[n + 1] = drift_v + gamma * h * a[n + 1]
    return u, v, a


def _start(model: Model, branch: Branch, start: Start) -> tuple[Array, Array]:
    if start == "rest":
        return np.zeros(model.size), np.zeros(model.size)
    step = 1e-3 * float(branch.times[1])
    u = quasi_static(model, branch.motion(step * np.arange(3)))
    return u[0], (-1.5 * u[0] + 2.0 * u[1] - 0.5 * u[2]) / step


def energy(model: Model, response: Response) -> Array:
    """Elastic plus kinetic energy (N,) of the elastic motion [J]."""
    k, m = model.matrices(response.motion)
    strain = np.einsum("ni,nij,nj->n", response.u, k, response.u)
    return 0.5 * (strain + np.einsum("ni,nij,nj->n", response.v, m, response.v))


def _require_held(model: Model) -> None:
    if model.robot.drives.roots == "free":
        problem = 'is "free": nothing holds the mechanism; use "locked" or "servo" for a response'
        raise InputError(model.robot.source, "drives.roots", problem)
