"""One assembly followed over time, with folds, singularities and travel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.integrate import trapezoid
from scipy.optimize import brentq

from linkages.errors import RunError, Status
from linkages.flexible import Array
from linkages.three_rrr.direct import assemblies
from linkages.three_rrr.geometry import Geometry
from linkages.three_rrr.kinematics import (
    Motion,
    arms,
    determinants,
    jacobians,
    loop_errors,
    motion,
    newton,
    radius,
    turned,
)

Metric = Literal["path", "rotation", "pivots"]

_TURN = 0.02  # largest step of the fastest drive [rad]
_SHORTEST = 1e-10  # steps below this fraction of the duration: a fold
_NEAR_FOLD = 0.25  # dimensionless |det Jx| below which a branch counts as at its fold
_DRIFT = 0.02  # largest correction of a predicted pose, in rad and in the platform's radius


class BranchError(RunError):
    """A motion that does not exist; `status` says why."""

    def __init__(self, status: Status, detail: str) -> None:
        super().__init__(f"{status.value}: {detail}; {_REMEDY[status]}")
        self.status = status


_REMEDY = {
    Status.NO_ASSEMBLY: "check the lengths and the drives' start angles",
    Status.SINGULAR: "two assemblies meet and vanish: shorten the duration or follow another branch",
}


@dataclass(frozen=True)
class Singularity:
    """A singular pose that a branch passes (type 1) or ends at (type 2, a fold).

    Attributes
    ----------
    type : int
        1: A, B and C of a leg align, the crank is at a limit; 2: the platform is no longer held by the
        drives.
    leg : int
        1, 2 or 3; 0 for type 2.
    time : float
        [s].
    """

    type: int
    leg: int
    time: float


@dataclass(frozen=True)
class Branch:
    """An assembly followed over time with the drives at constant speeds.

    Attributes
    ----------
    times, x : (n,), (n, 3) arrays
        Continuation points: time [s] and platform position.
    status : Status
        OK, or SINGULAR if it ends at a fold before the wanted duration.
    singularities : tuple
        Type-1 singularities passed and the type-2 one that ended it, by time.
    """

    geometry: Geometry
    phi0: Array
    phidot: Array
    times: Array
    x: Array
    status: Status
    singularities: tuple[Singularity, ...]

    def trimmed(self) -> Branch:
        """Return the branch without its last part before a fold.

        There |det Jx| falls below 0.25 (dimensionless), or half its first value: velocities, loads and
        elastic displacements grow without bound, and small-displacement theory ends.
        """
        if self.status is Status.OK:
            return self
        fold, _ = determinants(self.geometry, self.phi0 + self.times[:, None] * self.phidot, self.x)
        least = min(_NEAR_FOLD, 0.5 * abs(float(fold[0])))
        keep = max(int(np.max(np.flatnonzero(np.abs(fold) >= least), initial=0)) + 1, 2)
        return replace(self, times=self.times[:keep], x=self.x[:keep])

    def motion(self, times: Array) -> Motion:
        """Rigid motion at any times within the branch.

        Raises
        ------
        BranchError
            Before the start or beyond the end of the branch.
        """
        times, end = np.asarray(times, dtype=float), float(self.times[-1])
        outside = times[(times < 0.0) | (times > end * (1 + 1e-12))]
        if outside.size:
            raise BranchError(
                Status.SINGULAR, f"t = {outside[-1]:g} s is outside the branch, from 0 to {end:.9g} s"
            )
        near = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        near -= times - self.times[near - 1] < self.times[near] - times
        start = _state(self.geometry, self.phi0, self.phidot, self.times[near], self.x[near])
        step = (times - self.times[near])[:, None]
        guess = start.x + step * (start.dx + 0.5 * step * start.ddx)
        phi = self.phi0 + times[:, None] * self.phidot
        x, error = newton(self.geometry, phi, guess)
        if np.any(error > 1e-12 * self.geometry.size):
            worst = float(times[np.argmax(error)])
            raise BranchError(Status.NO_ASSEMBLY, f"the loops do not close at t = {worst:g} s")
        return _state(self.geometry, self.phi0, self.phidot, times, x)


def follow(geometry: Geometry, phi0: Array, phidot: Array, x0: Array, duration: float) -> Branch:
    """Follow the assembly x0 (3,) for a time [s], by a second-order predictor and Newton's method.

    A step counts only if the corrector moves the prediction little and det Jx keeps its sign, so that the
    branch can neither jump to another one nor pass a fold unseen. At a fold the time is located and the
    branch ends.
    """
    state = _at(geometry, phi0, phidot, 0.0, x0)
    sign = np.sign(_fold(state, geometry))
    longest = _TURN / max(float(np.max(np.abs(phidot))), 1e-12)
    longest = min(longest, duration)
    times, x, step, status = [0.0], [np.array(x0, dtype=float)], longest, Status.OK
    while times[-1] < duration * (1.0 - 1e-14):
        step = min(step, duration - times[-1])
        guess = state.x[0] + step * (state.dx[0] + 0.5 * step * state.ddx[0])
        later = _at(geometry, phi0, phidot, times[-1] + step, guess)
        if _accepted(geometry, later, guess, sign):
            state = later
            times.append(float(later.time[0]))
            x.append(later.x[0])
            step = min(1.5 * step, longest)
            continue
        step *= 0.5
        if step < _SHORTEST * duration:
            status = Status.SINGULAR
            break
    found = _type_one(geometry, phi0, phidot, np.array(times), np.array(x))
    if status is Status.SINGULAR:
        found.append(Singularity(2, 0, times[-1]))
    return Branch(geometry, phi0, phidot, np.array(times), np.array(x), status, tuple(found))


def start_assembly(geometry: Geometry, phi0: Array, theta: float | None = None) -> Array:
    """Choose the assembly (3,) at t = 0 whose platform angle is nearest to theta [rad]; else the first.

    Raises
    ------
    BranchError
        If there is no assembly, or the nearest is more than 30 degrees away.
    """
    found = assemblies(geometry, phi0)
    angles = ", ".join(f"{np.rad2deg(a):.2f}" for a in found.x[:, 0])
    if len(found) == 0:
        degrees = ", ".join(f"{np.rad2deg(p):g}" for p in phi0)
        raise BranchError(Status.NO_ASSEMBLY, f"the robot has no assembly at the crank angles {degrees} deg")
    if theta is None:
        return found.x[0]
    gap = np.abs(np.angle(np.exp(1j * (found.x[:, 0] - theta))))
    if np.min(gap) > np.deg2rad(30.0):
        wanted = f"{np.rad2deg(theta):g}"
        raise BranchError(
            Status.NO_ASSEMBLY, f"no assembly starts near theta = {wanted} deg; there are {angles} deg"
        )
    return found.x[np.argmin(gap)]


def travel(branch: Branch, metric: Metric, points: int = 2001) -> float:
    """Length of a branch's motion.

    ``path``: path of the platform's centre [m]; ``rotation``: integral of |theta_dot| [rad]; ``pivots``:
    mean path of the three pivots C_r [m], which weighs both.
    """
    times = np.linspace(0.0, branch.times[-1], points)
    state = branch.motion(times)
    if metric == "path":
        speed = np.linalg.norm(state.dx[:, 1:], axis=1)
    elif metric == "rotation":
        speed = np.abs(state.dx[:, 0])
    else:
        r = arms(branch.geometry, state.x[:, 0])
        velocity = state.dx[:, None, 1:] + state.dx[:, :1, None] * turned(r)
        speed = np.mean(np.linalg.norm(velocity, axis=-1), axis=1)
    return float(trapezoid(speed, times))


def shortest(geometry: Geometry, phi0: Array, phidot: Array, duration: float, metric: Metric) -> Branch:
    """Follow every assembly at t = 0 and return the one of least travel that lasts for the whole duration.

    Raises
    ------
    BranchError
        If there is none.
    """
    start = assemblies(geometry, phi0)
    if len(start) == 0:
        start_assembly(geometry, phi0)
    branches = [follow(geometry, phi0, phidot, x, duration) for x in start.x]
    whole = [branch for branch in branches if branch.status is Status.OK]
    if not whole:
        last = max(float(branch.times[-1]) for branch in branches)
        raise BranchError(Status.SINGULAR, f"every branch ends at a fold, the last at t = {last:g} s")
    return min(whole, key=lambda branch: travel(branch, metric))


def _state(geometry: Geometry, phi0: Array, phidot: Array, times: Array, x: Array) -> Motion:
    phi = phi0 + times[:, None] * phidot
    return motion(geometry, times, phi, np.broadcast_to(phidot, phi.shape), np.zeros_like(phi), x)


def _at(geometry: Geometry, phi0: Array, phidot: Array, time: float, guess: Array) -> Motion:
    """Motion at one time; not closed if Newton's method fails, with zero rates at a singular pose."""
    phi = (phi0 + time * phidot)[None]
    x, _ = newton(geometry, phi, np.array(guess, dtype=float)[None])
    jx, _ = jacobians(geometry, phi, x)
    if abs(np.linalg.det(jx[0])) < 1e-14 * radius(geometry):
        none = np.zeros((1, 3))
        return Motion(np.array([time]), phi, none, none, x, none, none, none, none, none)
    return _state(geometry, phi0, phidot, np.array([time]), x)


def _fold(state: Motion, geometry: Geometry) -> float:
    return float(determinants(geometry, state.phi, state.x)[0][0])


def _accepted(geometry: Geometry, state: Motion, guess: Array, sign: float) -> bool:
    error = np.max(np.abs(loop_errors(geometry, state.phi, state.x)))
    drift = state.x[0] - guess
    drift[1:] /= radius(geometry)
    closed = error <= 1e-13 * geometry.size
    return bool(closed and np.max(np.abs(drift)) <= _DRIFT and np.sign(_fold(state, geometry)) == sign)


def _type_one(geometry: Geometry, phi0: Array, phidot: Array, times: Array, x: Array) -> list[Singularity]:
    """Locate the times at which a leg aligns between continuation points."""
    _, sine = determinants(geometry, phi0 + times[:, None] * phidot, x)
    found = []
    for leg in range(3):
        for k in np.flatnonzero(sine[:-1, leg] * sine[1:, leg] < 0.0):

            def value(t: float, k: int = int(k), leg: int = leg) -> float:
                weight = (t - times[k]) / (times[k + 1] - times[k])
                phi = (phi0 + t * phidot)[None]
                closed, _ = newton(geometry, phi, ((1.0 - weight) * x[k] + weight * x[k + 1])[None])
                return float(determinants(geometry, phi, closed)[1][0, leg])

            found.append(Singularity(1, leg + 1, float(brentq(value, times[k], times[k + 1], xtol=1e-12))))
    return sorted(found, key=lambda s: s.time)
