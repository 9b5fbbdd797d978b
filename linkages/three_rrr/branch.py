"""One assembly followed over time, with folds, singularities and travel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.integrate import trapezoid
from scipy.optimize import brentq

from linkages.base.arguments import Vector, fitting, shaped, validated
from linkages.base.arrays import Array
from linkages.base.errors import InputError, RunError, Status
from linkages.three_rrr.direct import assemblies
from linkages.three_rrr.geometry import Geometry
from linkages.three_rrr.kinematics import CrankMotion, RobotMotion, arms, determinants, motion, newton, radius, turned

Metric = Literal["path", "rotation", "pivots"]

_TURN = 0.02  # largest step of the fastest drive [rad]
_SAMPLES = 1001  # times at which its speed is looked for
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
        1: A, B and C of a leg align, the crank is at a limit; 2: the drives no longer hold the platform.
    leg : int
        1, 2 or 3; 0 for type 2.
    time : float
        Time of the pose [s].
    """

    type: int  # 1: A, B and C of a leg align, the crank is at a limit; 2: the drives no longer hold the platform
    leg: int
    time: float


@dataclass(frozen=True)
class AssemblyBranch:
    """An assembly followed over time; made by `follow`.

    Attributes
    ----------
    geometry : Geometry
    cranks : CrankMotion
        Motion of the cranks.
    times : (n,) array
        Times of the continuation points [s].
    x : (n, 3) array
        Platform positions (theta, x, y) at these times [rad, m].
    status : Status
        OK, or SINGULAR if the branch ends at a fold before the wanted duration.
    singularities : tuple of Singularity
        By time: type-1 singularities that it passes, and the type-2 one that ends it.
    """

    geometry: Geometry
    cranks: CrankMotion
    times: Array
    x: Array
    status: Status
    singularities: tuple[Singularity, ...]

    def phi(self, times: Array) -> Array:
        """Crank angles (n, 3) at some times (n,) [rad]."""
        return self.cranks(times)[0]

    def state(self, times: Array, x: Array) -> RobotMotion:
        """Rigid motion at some times (n,) with the closed poses x (n, 3)."""
        return motion(self.geometry, times, *self.cranks(times), x)

    def trimmed(self) -> AssemblyBranch:
        """Return the branch without its last part before a fold.

        There |det Jx| falls below 0.25 (dimensionless), or half its first value: velocities, loads and
        elastic displacements grow without bound, and small-displacement theory ends.
        """
        if self.status is Status.OK:
            return self
        fold, _ = determinants(self.geometry, self.phi(self.times), self.x)
        least = min(_NEAR_FOLD, 0.5 * abs(float(fold[0])))
        keep = max(int(np.max(np.flatnonzero(np.abs(fold) >= least), initial=0)) + 1, 2)
        return replace(self, times=self.times[:keep], x=self.x[:keep])

    @validated
    def motion(self, times: Vector) -> RobotMotion:
        """Rigid motion at any times within the branch; BranchError beyond."""
        end = float(self.times[-1])
        outside = times[(times < 0.0) | (times > end * (1 + 1e-12))]
        if outside.size:
            detail = f"t = {outside[-1]:g} s is outside the branch, from 0 to {end:.9g} s"
            raise BranchError(Status.SINGULAR, detail)
        near = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        near -= times - self.times[near - 1] < self.times[near] - times
        start = self.state(self.times[near], self.x[near])
        step = (times - self.times[near])[:, None]
        guess = start.x + step * (start.dx + 0.5 * step * start.ddx)
        x, error = newton(self.geometry, self.phi(times), guess)
        if np.any(error > 1e-12 * self.geometry.size):
            worst = float(times[np.argmax(error)])
            raise BranchError(Status.NO_ASSEMBLY, f"the loops do not close at t = {worst:g} s")
        return self.state(times, x)


@validated
def follow(geometry: Geometry, cranks: CrankMotion, x0: Vector, duration: float) -> AssemblyBranch:
    """Follow the assembly x0 (3,) for a time [s], by a second-order predictor and Newton's method.

    A step counts only if the cranks turn and the corrector moves the prediction little and det Jx keeps its sign, so
    that the branch can neither jump to another one nor pass a fold unseen. At a fold the time is located and the branch
    ends. `cranks` is any motion of the cranks that starts at x0: `Robot.cranks`, or a function of times (N,) that
    returns angles, rates and accelerations (N, 3), the latter two the derivatives of the first. InputError if a number
    is invalid, or `cranks` returns other arrays.
    """
    fitting(x0, 3, "x0", "coordinates of the platform")
    if not duration > 0.0:
        raise InputError("argument", "duration", f"is {duration:g} s; it must be above zero")
    samples = np.linspace(0.0, duration, _SAMPLES)
    motions = cranks(samples)
    if len(motions) != 3:
        raise InputError(
            "argument", "cranks", f"returned {len(motions)} arrays; it must return angles, rates and accelerations"
        )
    _, rates, _ = (shaped(one, (_SAMPLES, 3), "cranks", "angles, rates or accelerations") for one in motions)
    branch = AssemblyBranch(geometry, cranks, np.zeros(1), x0[None], Status.OK, ())
    state, _, first = _at(branch, 0.0, branch.x)
    fastest = np.max(np.abs(rates))
    longest = min(_TURN / max(float(fastest), 1e-12), duration)
    times, x, step, status = [0.0], [branch.x[0]], longest, Status.OK
    while times[-1] < duration * (1.0 - 1e-14):
        step = min(step, duration - times[-1])
        guess = state.x + step * (state.dx + 0.5 * step * state.ddx)
        later, error, fold = _at(branch, times[-1] + step, guess)
        drift = np.max(np.abs(later.x - guess) / [1.0, radius(geometry), radius(geometry)])
        near = drift <= _DRIFT and np.max(np.abs(later.phi - state.phi)) <= 2.0 * _TURN
        if error <= 1e-13 * geometry.size and near and np.sign(fold) == np.sign(first):
            state = later
            times.append(float(later.time[0]))
            x.append(later.x[0])
            step = min(1.5 * step, longest)
            continue
        step *= 0.5
        if step < _SHORTEST * duration:
            status = Status.SINGULAR
            break
    branch = replace(branch, times=np.array(times), x=np.array(x), status=status)
    found = _type_one(branch)
    if status is Status.SINGULAR:
        found.append(Singularity(2, 0, times[-1]))
    return replace(branch, singularities=tuple(found))


def start_assembly(geometry: Geometry, phi0: Array, theta: float | None = None) -> Array:
    """Choose the assembly (3,) at t = 0 whose platform angle is nearest to theta [rad]; else the first.

    BranchError if there is no assembly, or the nearest is more than 30 degrees away.
    """
    found = assemblies(geometry, phi0)
    if len(found) == 0:
        degrees = ", ".join(f"{np.rad2deg(p):g}" for p in phi0)
        raise BranchError(Status.NO_ASSEMBLY, f"the robot has no assembly at the crank angles {degrees} deg")
    if theta is None:
        return found.x[0]
    gap = np.abs(np.angle(np.exp(1j * (found.x[:, 0] - theta))))
    if np.min(gap) > np.deg2rad(30.0):
        there = ", ".join(f"{np.rad2deg(a):.2f}" for a in found.x[:, 0])
        detail = f"no assembly starts near theta = {np.rad2deg(theta):g} deg; there are {there} deg"
        raise BranchError(Status.NO_ASSEMBLY, detail)
    return found.x[np.argmin(gap)]


def travel(branch: AssemblyBranch, metric: Metric, points: int = 2001) -> float:
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


def _at(branch: AssemblyBranch, time: float, guess: Array) -> tuple[RobotMotion, float, float]:
    """Motion at one time, with zero rates at a singular pose; its loop error [m] and dimensionless det Jx."""
    times = np.array([time])
    phi = branch.phi(times)
    x, error = newton(branch.geometry, phi, guess)
    fold, _ = determinants(branch.geometry, phi, x)
    if abs(fold[0]) < 1e-14:
        none = np.zeros((1, 3))
        state = RobotMotion(times, phi, none, none, x, none, none, none, none, none)
    else:
        state = branch.state(times, x)
    return state, float(error[0]), float(fold[0])


def _type_one(branch: AssemblyBranch) -> list[Singularity]:
    """Locate the times at which a leg aligns between continuation points."""
    times, x = branch.times, branch.x

    def aligned(time: float, k: int, leg: int) -> float:
        weight = (time - times[k]) / (times[k + 1] - times[k])
        phi = branch.phi(np.array([time]))
        closed, _ = newton(branch.geometry, phi, ((1.0 - weight) * x[k] + weight * x[k + 1])[None])
        return float(determinants(branch.geometry, phi, closed)[1][0, leg])

    _, sine = determinants(branch.geometry, branch.phi(times), x)
    found = []
    for k, leg in np.argwhere(sine[:-1] * sine[1:] < 0.0).tolist():
        time = brentq(aligned, times[k], times[k + 1], (k, leg), xtol=1e-12)
        found.append(Singularity(1, leg + 1, float(time)))
    return sorted(found, key=lambda s: s.time)
