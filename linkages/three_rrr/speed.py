"""The elastic response against the speed of the drives, until the first resonance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from linkages.base.arguments import Vector, validated
from linkages.base.arrays import Array
from linkages.mechanics.flexible.modes import eigenvalues
from linkages.mechanics.flexible.response import quasi_static as solve
from linkages.three_rrr.branch import AssemblyBranch
from linkages.three_rrr.finite_elements import FiniteElementModel, velocity_terms
from linkages.three_rrr.modes import frequencies
from linkages.three_rrr.response import generalised_alpha, quasi_static
from linkages.three_rrr.robot import Robot, changed

RESONANCE = 1.5  # dynamic over quasi-static peak from which a local maximum counts as a resonance


@dataclass(frozen=True)
class SpeedSweep:
    """Peaks over the motion with drives at `factors` times their speeds; made by `speed_sweep`.

    Attributes
    ----------
    factors : (n,) array
        Factors of the runs: none beyond the first resonance.
    static, dynamic : (n,) arrays
        Largest displacement of the platform's centre, quasi-static and with vibration [m].
    resonance : int or None
        Index of the first resonance among `factors`.
    """

    factors: Array
    static: Array
    dynamic: Array
    resonance: int | None

    @property
    def amplification(self) -> Array:
        """Dynamic over quasi-static peak displacement (n,)."""
        return self.dynamic / self.static


def faster(branch: AssemblyBranch, factor: float) -> AssemblyBranch:
    """Return the same path passed `factor` times as fast."""
    passed = tuple(replace(s, time=s.time / factor) for s in branch.singularities)

    def cranks(times: Array) -> tuple[Array, Array, Array]:
        phi, rate, acceleration = branch.cranks(factor * times)
        return phi, factor * rate, factor**2 * acceleration

    return replace(branch, cranks=cranks, times=branch.times / factor, singularities=passed)


@validated
def speed_sweep(
    robot: Robot,
    branch: AssemblyBranch,
    factors: Vector,
    damping_ratio: float = 0.01,
    steps_per_period: float = 40.0,
    progress: Callable[[float], None] | None = None,
) -> SpeedSweep:
    """Run the whole motion at each speed, starting on the quasi-static solution, until a resonance is passed.

    The first mode has a damping ratio (assumed), proportional to the stiffness; without any, resonances have no height.
    Steps are counted in the shortest period of the first mode over the motion.
    """
    coarse = branch.motion(np.linspace(0.0, branch.times[-1], 181))
    first = float(frequencies(FiniteElementModel(robot), coarse, 1).max())
    damped = changed(robot, damping={"mass": 0.0, "stiffness": damping_ratio / (np.pi * first)})
    model = FiniteElementModel(damped)
    rows = []
    for index, factor in enumerate(factors):
        quick = faster(branch, float(factor))
        steps = int(np.ceil(quick.times[-1] * first * steps_per_period))
        times = np.linspace(0.0, quick.times[-1], max(steps, 200) + 1)
        result = generalised_alpha(model, quick, times, start="quasi-static", radius=0.8)
        still = model.platform_displacement(result.motion, quasi_static(model, result.motion))
        rows.append([_peak(still), _peak(result.platform)])
        static, dynamic = np.array(rows).T
        r = dynamic / static
        inner = range(1, len(r) - 1)
        peak = next((i for i in inner if r[i] >= RESONANCE and r[i - 1] <= r[i] > r[i + 1]), None)
        if progress is not None:
            progress(1.0 if peak is not None else (index + 1) / len(factors))
        if peak is not None:
            break
    return SpeedSweep(np.array(factors[: len(rows)]), static, dynamic, peak)


def _peak(platform: Array) -> float:
    return float(np.max(np.hypot(platform[:, 0], platform[:, 1])))


def velocity_effect(robot: Robot, branch: AssemblyBranch, factors: Array, poses: int = 24) -> tuple[Array, Array]:
    """Measure how much the velocity-dependent terms matter at each speed factor.

    Returns the largest relative changes (n,), over poses along the motion, of the first natural frequency of the
    gyroscopic system and of the quasi-static displacements.
    """
    model = FiniteElementModel(robot)
    state = branch.motion(np.linspace(0.0, branch.times[-1], poses))
    frequency, displacement = [], []
    k, m = model.matrices(state)
    plain = 2.0 * np.pi * frequencies(model, state, 1)[:, 0]
    for factor in factors:
        rates = {name: factor * getattr(state, name) for name in ("dphi", "dx", "dpsi")}
        rates |= {name: factor**2 * getattr(state, name) for name in ("ddphi", "ddx", "ddpsi")}
        fast = replace(state, time=state.time / factor, **rates)
        f = model.load(fast)
        u = solve(k, f)
        gyro, stiff = velocity_terms(model, fast, u)
        u_full = solve(k + stiff, f)
        displacement.append(np.max(np.abs(u_full - u)) / np.max(np.abs(u)))
        change = [
            abs(_first_frequency(*matrices) / p - 1.0) for *matrices, p in zip(m, gyro, k + stiff, plain, strict=True)
        ]
        frequency.append(max(change))
    return np.array(frequency), np.array(displacement)


def _first_frequency(m: Array, g: Array, k: Array) -> float:
    """Smallest |Im s| among the eigenvalues s of M s^2 + G s + K, zeros aside [rad/s]."""
    values = np.abs(eigenvalues(m, g, k).imag)
    return float(np.min(values[values > 1e-9 * np.max(values)]))
