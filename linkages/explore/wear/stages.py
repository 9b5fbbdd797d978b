"""Service life with wear: jumps of many cycles, stages, the time to reach a limit; content of ``wear.json``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError, RunError, Status, nearest
from linkages.explore.numerics import STAGES_CLOSE, STAGES_MISSED
from linkages.explore.wear.measure import (
    CycleBlock,
    LoadSamples,
    Removed,
    Wearing,
    check_wears,
    depths_of,
    equal_works,
    watched,
    wearing,
)
from linkages.input.files.versions import versions
from linkages.laws.wear.archard import FRACTION, wear_away
from linkages.laws.wear.profile import node_depths, volume_of
from linkages.results.outputs.registry import unit
from linkages.system import System

SIDES = ("bearing", "journal")
#: Measures of a wearing joint: largest depth, mean radial clearance.
SIZES = ("depth", "play")

_SWEEPS = (1, 1000)


def between(before: LoadSamples, after: LoadSamples, part: float) -> dict[str, Array]:
    """Mix the loads of two blocks: a fraction `part` of the cycles is like the second."""
    found = {}
    for name in after:
        lines = np.concatenate([before[name], after[name]])
        lines[:, 6] *= np.repeat([1.0 - part, part], [len(before[name]), len(after[name])])
        found[name] = equal_works(lines[lines[:, 6] > 0.0])
    return found


def worn(joints: tuple[Wearing, ...], removed: Removed, loads: LoadSamples, cycles: float) -> dict[str, Array]:
    """Compute the profiles after `cycles` cycles of a block's loads; RunError if no journal positions are found."""
    result = {}
    for joint in joints:
        lost, samples = removed[joint.name].copy(), loads[joint.name].copy()
        result[joint.name] = lost
        if len(samples) == 0:
            continue
        k = np.array(joint.coefficients) * cycles
        # repetitions such that deposits are small against their overlaps, except for a tenth of the work
        parts = (
            k.sum() * samples[:, 6] / (FRACTION * joint.radius * joint.length * np.hypot(samples[:, 4], samples[:, 5]))
        )
        order = np.argsort(parts)
        reached = np.cumsum(samples[order, 6])
        sweeps = int(np.clip(parts[order][np.searchsorted(reached, 0.9 * reached[-1])], *_SWEEPS)) + 1
        journal = joint.radius - joint.clearance
        missed = wear_away(samples, joint.reach, (joint.radius, journal), joint.length, (k[0], k[1]), sweeps, lost)
        if missed > STAGES_MISSED:
            raise RunError(f"joint {joint.name}: no position found for {missed:.0%} of its loads; use more nodes")
    return result


def difference(joints: tuple[Wearing, ...], one: Removed, other: Removed) -> float:
    """Compute the largest difference of depth between two sets of profiles [m]."""
    return max(float(np.abs(depths_of(j, one[j.name]) - depths_of(j, other[j.name])).max()) for j in joints)


def deepest(joints: tuple[Wearing, ...], removed: Removed) -> float:
    """Compute the largest depth over the bearing's radius."""
    return max(float(depths_of(joint, removed[joint.name]).max()) / joint.radius for joint in joints)


@dataclass(frozen=True)
class Stage:
    """A stage of the service life; the last jump leads to it.

    Attributes
    ----------
    cycles : int
        Cycles up to this stage.
    removed : dict of (2, n) arrays
        Area per angle over the radius, bearing then journal, by joint [m].
    work : dict of str to float
        Integral of N |v_t| dt up to this stage, by joint [N m].
    middle : float
        Cycle of the block.
    block : CycleBlock
        Measurements of the last jump.
    loads : dict of (m, 7) arrays
        Loads of the last jump: the block's, or interpolated with the previous block's.
    error : float
        Largest difference of depth between first and second order in the last jump [m].
    rejected : int
        Number of rejected longer jumps.
    """

    cycles: int
    removed: dict[str, Array]
    work: dict[str, float]
    middle: float
    block: CycleBlock
    loads: LoadSamples
    error: float = 0.0
    rejected: int = 0


@dataclass(frozen=True, repr=False)
class Life(Brief):
    """Wear of a linkage over its service life; made by `wear_life`.

    Attributes
    ----------
    system : System
        The system before wear.
    stages : tuple of Stage
        The first is the initial one.
    status : Status
    tolerance : float
        Largest difference of depth between a jump's first and second order [m].
    scatter : float
        Relative standard error of the work at which a block of cycles ends [1].
    """

    system: System
    stages: tuple[Stage, ...]
    status: Status
    tolerance: float
    scatter: float

    def _facts(self) -> tuple[str, dict[str, str]]:
        joints = {one.name: f"depth {1e6 * self.depths(one.name)[-1].max():.4g} µm" for one in self.joints}
        cycles = counted(int(self.cycles[-1]), "cycle")
        return f"{cycles}, {counted(len(self.stages), 'stage')}, {self.status.value}", joints

    @property
    def joints(self) -> tuple[Wearing, ...]:
        """Return the wearing joints."""
        return wearing(self.system)

    @property
    def cycles(self) -> Array:
        """Return the cycles at each stage, (ns,)."""
        return np.array([stage.cycles for stage in self.stages])

    @property
    def simulated(self) -> int:
        """Return the number of simulated cycles."""
        return sum(stage.block.cycles for stage in self.stages)

    @property
    def rejected(self) -> int:
        """Return the number of rejected jumps."""
        return sum(stage.rejected for stage in self.stages)

    def profiles(self, joint: str) -> Array:
        """Return the depths of bearing and journal at their nodes at each stage [m], (ns, 2, n)."""
        return np.array([self._nodes(joint, stage.removed) for stage in self.stages])

    def volumes(self, joint: str) -> Array:
        """Return the worn volume of bearing and journal at each stage [m3], (ns, 2)."""
        owner = self._joint(joint)
        rows = [zip(stage.removed[joint], owner.radii, strict=True) for stage in self.stages]
        return np.array([[volume_of(lost, radius, owner.length) for lost, radius in row] for row in rows])

    def depths(self, joint: str) -> Array:
        """Return the largest depth of either part at each stage [m], (ns,)."""
        return self._size(joint, "depth", self.profiles(joint))

    def play(self, joint: str) -> Array:
        """Return the mean radial clearance at each stage [m], (ns,): half the mean free path through the centre."""
        return self._size(joint, "play", self.profiles(joint))

    def peaks(self, output: str) -> tuple[Array, Array]:
        """Return the largest magnitude of an output in each block, and the blocks' cycles; see `CycleBlock.peaks`."""
        at = [stage.middle for stage in self.stages]
        return np.array([stage.block.peaks[output] for stage in self.stages]), np.array(at)

    def cycles_until(self, quantity: str, limit: float) -> float:
        """Compute the cycles until a quantity first exceeds a limit; inf if it never does. InputError if it is unknown.

        The quantity is ``JOINT.depth`` or ``JOINT.play`` [m], or an output with recorded peaks, in its unit:
        ``JOINT.force``, ``DRIVE.torque``, ``OUTPUT.jitter`` (of a point), ``OUTPUT``. Within a jump depth and clearance
        follow from its loads; peaks of outputs are interpolated linearly.
        """
        cycles, values = self.history(quantity)
        above = np.flatnonzero(values > limit)
        if len(above) == 0:
            return float("inf")
        k = int(above[0])
        if k == 0:
            return 0.0
        joint, _, what = quantity.rpartition(".")
        if what not in SIZES:
            return float(np.interp(limit, values[k - 1 : k + 1], cycles[k - 1 : k + 1]))
        before, loads = self.stages[k - 1].removed, self.stages[k].loads

        def excess(jump: float) -> float:
            lost = worn((self._joint(joint),), before, loads, jump)
            return float(self._size(joint, what, self._nodes(joint, lost)[None])[0]) - limit

        jump = float(cycles[k] - cycles[k - 1])
        return float(cycles[k - 1]) + (brentq(excess, 0.0, jump, xtol=STAGES_CLOSE * jump) if jump > 1.0 else 1.0)

    def history(self, quantity: str) -> tuple[Array, Array]:
        """Return cycles and values of a quantity of `cycles_until`."""
        check_life(self.system, quantity)
        name, _, what = quantity.rpartition(".")
        if what in SIZES:
            return self.cycles.astype(float), self._size(name, what, self.profiles(name))
        values, at = self.peaks(quantity)
        return at, values

    def _nodes(self, joint: str, removed: Removed) -> Array:
        """Compute the depths of bearing and journal at their nodes [m], (2, n)."""
        return np.array([node_depths(side) for side in depths_of(self._joint(joint), removed[joint])])

    def _size(self, joint: str, what: str, profiles: Array) -> Array:
        """Compute one of `SIZES` for profiles (ns, 2, n) [m], (ns,)."""
        if what == "depth":
            return np.asarray(profiles.max(axis=(1, 2)))
        return self._joint(joint).clearance + profiles.mean(axis=2).sum(axis=1)

    def _joint(self, name: str) -> Wearing:
        return next(joint for joint in self.joints if joint.name == name)


def check_life(system: System, quantity: str, drive: str | None = None) -> None:
    """Check that a system has wearing joints, a periodic drive, and this quantity of `Life.cycles_until`."""
    known = [f"{joint.name}.{what}" for joint in check_wears(system, drive) for what in SIZES] + watched(system)
    if quantity not in known:
        raise InputError("argument", quantity, f"is unknown; {nearest(quantity, known)}")


def content(life: Life) -> dict[str, Any]:
    """Make the content of ``wear.json``: final wear, and all stages, in SI units.

    ``joints`` by name: ``volume`` [m3], largest ``depth`` [m], ``play`` [m] (mean radial clearance), ``load_distance``,
    the integral of N |v_t| dt [N m], ``coefficient`` [m2/N], and for `bearing` and `journal` their parts with
    ``profile``, pairs of angle [rad] and depth [m]; ``profile`` of the joint belongs to the wearing part (to the
    bearing if both wear). ``blocks`` has an entry for each stage: ``cycles``, ``error`` of the depth in the jump [m],
    measured work per cycle, volumes, depths, clearances, profiles; ``peaks`` at the cycle ``middle``, in the ``units``.
    """
    joints = {joint.name: _joint(life, joint.name, -1) for joint in life.joints}
    blocks = []
    for k, stage in enumerate(life.stages):
        measured = {}
        for name, work in stage.block.work.items():
            deviation = float(np.std(work, ddof=1)) if len(work) > 1 else None
            measured[name] = {"cycles": len(work), "work": float(work.mean()), "deviation": deviation}
        blocks.append(
            {
                "cycles": stage.cycles,
                "middle": stage.middle,
                "error": stage.error,
                "simulated": stage.block.cycles,
                "measured": measured,
                "peaks": stage.block.peaks,
                "joints": {name: _joint(life, name, k) for name in joints},
            }
        )
    return {
        "cycles": int(life.cycles[-1]),
        "status": life.status.value,
        "joints": joints,
        "units": {name: unit(life.system, name) for name in life.stages[0].block.peaks},
        "blocks": blocks,
        "simulated_cycles": life.simulated,
        "rejected_jumps": life.rejected,
        "tolerance": life.tolerance,
        "scatter": life.scatter,
        "title": life.system.description.title,
        "experiment": life.system.description.source.name,
        "provenance": {"versions": versions()},
    }


def _joint(life: Life, name: str, k: int) -> dict[str, Any]:
    profiles, volumes = life.profiles(name)[k], life.volumes(name)[k]
    owner = next(joint for joint in life.joints if joint.name == name)
    angles = 2.0 * np.pi * np.arange(profiles.shape[1]) / profiles.shape[1]
    parts = {
        side: {
            "coefficient": coefficient,
            "volume": float(volume),
            "depth": float(profile.max()),
            "profile": np.column_stack([angles, profile]).tolist(),
        }
        for side, coefficient, volume, profile in zip(SIDES, owner.coefficients, volumes, profiles, strict=True)
        if coefficient > 0.0 or profile.any()
    }
    return {
        "volume": float(volumes.sum()),
        "depth": float(profiles.max()),
        "play": float(life.play(name)[k]),
        "clearance": owner.clearance,
        "radius": owner.radius,
        "coefficient": sum(owner.coefficients),
        "load_distance": life.stages[k].work[name],
        "profile": next(iter(parts.values()))["profile"],
        **parts,
    }
