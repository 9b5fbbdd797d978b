"""Wear over a machine's life: jumps of second order from block to block.

With s the profiles and H(s) the loads that a block with them gives, a jump of m cycles from s_n is

    s_half = s_n worn by m/2 cycles of the last block,   s_(n+1) = s_n worn by m cycles of H(s_half):

one block for each jump. The last block is at most as far away as the last jump was long, so that s_half is wrong by
O(m^2) and s_(n+1) by O(m^3). What the last block alone would have given is wrong by O(m^2): the difference of the two
depths is kept below the tolerance by the size of the jump. In it the scatter of a chaotic motion counts too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, RunError, Status
from linkages.explore.flow import period_of
from linkages.explore.wear.measure import Block, Removed, Wearing, depths_of, wearing
from linkages.explore.wear.store import Store
from linkages.laws.wear.archard import FRACTION, wear_away
from linkages.laws.wear.profile import node_depths, removed_of, volume_of
from linkages.model.check import DEEPEST
from linkages.system import System

Array = NDArray[np.float64]

SIDES = ("bearing", "journal")
#: Default tolerance of the depth in a jump, in parts of the smallest clearance.
TOLERANCE = 0.02
#: Default standard error of the mean work of a block.
SCATTER = 0.01

_FIRST = 5.0  # depth of the first jump, in tolerances
_SHORTER, _LONGER, _SAFETY = 0.2, 5.0, 0.9
_SWEEPS = (4, 1000)
_MISSED = 0.01  # part of the work that may be left without a place


@dataclass(frozen=True)
class Stage:
    """Where a life has got to.

    Attributes
    ----------
    cycles : int
    removed : dict of (2, n) arrays
        Area per angle over the radius [m], bearing then journal, by joint.
    work : dict of float
        Integral of N |v_t| dt so far [N m], by joint.
    middle : float
        Cycle to which the block belongs.
    block : Block
        What was measured in the jump that led here.
    error : float
        Largest difference of depth between first and second order in it [m].
    """

    cycles: int
    removed: dict[str, Array]
    work: dict[str, float]
    middle: float
    block: Block
    error: float


@dataclass(frozen=True)
class Life:
    """How a machine wears.

    Attributes
    ----------
    system : System
        As it was new.
    stages : tuple of Stage
        The first is the new machine.
    status : Status
    simulated : int
        Cycles that were simulated.
    rejected : int
        Jumps that were not accurate enough.
    tolerance, scatter : float
        See `wear_life`.
    """

    system: System
    stages: tuple[Stage, ...]
    status: Status
    simulated: int
    rejected: int
    tolerance: float
    scatter: float

    @property
    def joints(self) -> tuple[Wearing, ...]:
        """Joints that wear."""
        return wearing(self.system)

    @property
    def cycles(self) -> Array:
        """Cycles at each stage, (ns,)."""
        return np.array([stage.cycles for stage in self.stages])

    def profiles(self, joint: str) -> Array:
        """Depths of bearing and journal at their nodes at each stage [m], (ns, 2, n)."""
        owner = self._joint(joint)
        depths = [depths_of(owner, stage.removed[joint]) for stage in self.stages]
        return np.array([[node_depths(side) for side in both] for both in depths])

    def volumes(self, joint: str) -> Array:
        """Volume removed from bearing and journal at each stage [m3], (ns, 2)."""
        owner = self._joint(joint)
        rows = [zip(stage.removed[joint], owner.radii, strict=True) for stage in self.stages]
        return np.array([[volume_of(lost, radius, owner.length) for lost, radius in row] for row in rows])

    def depths(self, joint: str) -> Array:
        """Largest depth of either part at each stage [m], (ns,)."""
        return np.asarray(self.profiles(joint).max(axis=(1, 2)))

    def play(self, joint: str) -> Array:
        """Mean radial clearance at each stage [m], (ns,): half the journal's mean path through the bearing's centre."""
        return self._joint(joint).clearance + self.profiles(joint).mean(axis=2).sum(axis=1)

    def peaks(self, output: str) -> tuple[Array, Array]:
        """Largest magnitude of an output in each block, and the cycles to which they belong; see `Block.peaks`."""
        at = [stage.middle for stage in self.stages]
        return np.array([stage.block.peaks[output] for stage in self.stages]), np.array(at)

    def cycles_until(self, quantity: str, limit: float) -> float:
        """Cycles until a quantity first exceeds a limit, by straight lines between stages; inf if it never does.

        Parameters
        ----------
        quantity : str
            ``JOINT.depth`` or ``JOINT.play`` [m], or an output that the blocks have the peaks of, in its unit:
            ``JOINT.force``, ``DRIVE.torque``, ``OUTPUT.jitter``.
        limit : float

        Raises
        ------
        InputError
            If there is no such quantity.
        """
        cycles, values = self.history(quantity)
        above = np.flatnonzero(values > limit)
        if len(above) == 0:
            return float("inf")
        k = int(above[0])
        if k == 0:
            return 0.0
        return float(np.interp(limit, values[k - 1 : k + 1], cycles[k - 1 : k + 1]))

    def history(self, quantity: str) -> tuple[Array, Array]:
        """Cycles and values of a quantity of `cycles_until`."""
        name, _, what = quantity.rpartition(".")
        if what in ("depth", "play") and name in {joint.name for joint in self.joints}:
            return self.cycles.astype(float), (self.depths if what == "depth" else self.play)(name)
        known = self.stages[0].block.peaks
        if quantity not in known:
            ours = [f"{joint.name}.{what}" for joint in self.joints for what in ("depth", "play")]
            raise InputError("argument", quantity, f"is unknown; known are {', '.join([*ours, *known])}")
        values, at = self.peaks(quantity)
        return at, values

    def _joint(self, name: str) -> Wearing:
        return next(joint for joint in self.joints if joint.name == name)


def wear_life(
    system: System,
    cycles: int,
    tolerance: float | None = None,
    scatter: float = SCATTER,
    drive: str | None = None,
    folder: Path | None = None,
    every_cycle: bool = False,
    enough: Callable[[Life], bool] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Life:
    """Wear a machine over many cycles.

    Parameters
    ----------
    system : System
        With ``joints.J.wear`` of at least one joint.
    cycles : int
        Revolutions of the drive.
    tolerance : float, optional
        Largest difference of depth between a jump's first and second order [m]; default 0.02 of the smallest clearance.
    scatter : float
        Relative standard error of the mean work in a block at which it has cycles enough.
    drive : str, optional
        Whose revolutions; default the first of constant speed.
    folder : Path, optional
        Where blocks are kept: a life that was killed goes on from them, and gives the same bytes.
    every_cycle : bool
        Simulate every cycle and never jump: to check the jumps.
    enough : callable, optional
        From the life so far to whether it can end before its cycles.
    progress : callable, optional
        Called with the cycles done.

    Returns
    -------
    Life
        Up to the last cycle, or to where a block failed or was interrupted.

    Raises
    ------
    InputError
        If no joint wears, or a number is not valid.
    AssemblyError
        If the linkage cannot be assembled.

    Examples
    --------
    >>> import linkages
    >>> wear = {"joints.B.wear.coefficient": 1e-13, "joints.B.wear.nodes": 120}
    >>> system = linkages.load(linkages.find_file("slider_crank_dry.toml"), wear)
    >>> life = linkages.wear_life(system, 1000, scatter=0.05)
    >>> life.status.value, int(life.cycles[-1])
    ('ok', 1000)
    """
    joints = wearing(system)
    source = system.experiment.source
    if not joints:
        raise InputError(source, "joints", "none wears; give one a table [joints.NAME.wear]")
    if tolerance is None:
        tolerance = TOLERANCE * min(joint.clearance for joint in joints)
    for name, number in (("cycles", cycles), ("tolerance", tolerance), ("scatter", scatter)):
        if not number > 0:
            raise InputError("argument", name, f"is {number:g}; it must be above zero")
    period_of(system.experiment, drive)
    store = Store(system, folder)
    removed = _new(system)
    stages: list[Stage] = []
    status, simulated, rejected, jump = Status.OK, 0, 0, 1

    def so_far() -> Life:
        return Life(system, tuple(stages), status, simulated, rejected, tolerance, scatter)

    try:
        block = store.measure(removed, None, scatter if every_cycle else 2.0 * scatter, drive)
        simulated, status = block.cycles, block.status
        stages.append(Stage(0, removed, {joint.name: 0.0 for joint in joints}, 0.0, block, 0.0))
        if not every_cycle and status is Status.OK:
            jump = _first_jump(joints, removed, block, tolerance)
        while status is Status.OK and stages[-1].cycles < cycles:
            last = stages[-1]
            jump = 1 if every_cycle else min(jump, cycles - last.cycles)
            half = last.removed if every_cycle else worn(joints, last.removed, block, 0.5 * jump)
            if _deepest(joints, half) > DEEPEST:
                status = Status.WORN_OUT
                break
            middle = store.measure(half, block.end, 0.0 if every_cycle else scatter, drive, every_cycle)
            simulated, status = simulated + middle.cycles, middle.status
            if status is not Status.OK:
                break
            found = worn(joints, last.removed, middle, jump)
            error = 0.0
            if not every_cycle:
                error = _difference(joints, found, worn(joints, last.removed, block, jump))
            block = middle
            if error <= tolerance or jump == 1:
                work = {name: done + jump * mean_work(block, name) for name, done in last.work.items()}
                stages.append(Stage(last.cycles + jump, found, work, last.cycles + 0.5 * jump, block, error))
                if progress is not None:
                    progress(stages[-1].cycles)
                if enough is not None and enough(so_far()):
                    break
            else:
                rejected += 1
            factor = _SAFETY * np.sqrt(tolerance / error) if error > 0.0 else _LONGER
            jump = max(1, int(jump * min(max(factor, _SHORTER), _LONGER)))
    except KeyboardInterrupt:
        if not stages:
            raise
        status = Status.INTERRUPTED
    return so_far()


def mean_work(block: Block, joint: str) -> float:
    """Integral of N |v_t| dt over a mean cycle of a block [N m]."""
    return float(block.samples[joint][:, -1].sum()) if joint in block.samples else 0.0


def worn(joints: tuple[Wearing, ...], removed: Removed, block: Block, cycles: float) -> dict[str, Array]:
    """Profiles after so many cycles of a block's loads.

    Raises
    ------
    RunError
        If the places of the journals could not be found.
    """
    result = {}
    for joint in joints:
        lost, samples = removed[joint.name].copy(), block.samples[joint.name].copy()
        result[joint.name] = lost
        if len(samples) == 0:
            continue
        k = np.array(joint.coefficients) * cycles
        # repetitions in which no deposit is more than a part of its overlap, but for a tenth of the work
        parts = (
            k.sum() * samples[:, 6] / (FRACTION * joint.radius * joint.length * np.hypot(samples[:, 4], samples[:, 5]))
        )
        order = np.argsort(parts)
        reached = np.cumsum(samples[order, 6])
        sweeps = int(np.clip(parts[order][np.searchsorted(reached, 0.9 * reached[-1])], *_SWEEPS)) + 1
        journal = joint.radius - joint.clearance
        missed = wear_away(samples, joint.reach, (joint.radius, journal), joint.length, (k[0], k[1]), sweeps, lost)
        if missed > _MISSED:
            raise RunError(f"joint {joint.name}: no place found for {missed:.0%} of its loads; try more nodes")
    return result


def _new(system: System) -> dict[str, Array]:
    """Profiles as the experiment gives them."""
    models = dict(zip((name for name, _ in system.tree.contacts), system.models, strict=True))
    found = {}
    for joint in wearing(system):
        wear = models[joint.name].wear
        assert wear is not None
        lines = [np.array(depths or [0.0] * wear.nodes) for depths in wear.depths]
        found[joint.name] = np.array([removed_of(line, r) for line, r in zip(lines, joint.radii, strict=True)])
    return found


def _first_jump(joints: tuple[Wearing, ...], removed: Removed, block: Block, tolerance: float) -> int:
    """Cycles in which the loads of the first block wear some tolerances away, at the rate of one cycle."""
    rate = _difference(joints, worn(joints, removed, block, 1.0), removed)
    return max(1, int(min(_FIRST * tolerance / rate, 1e9))) if rate > 0.0 else 10**9


def _difference(joints: tuple[Wearing, ...], one: Removed, other: Removed) -> float:
    """Largest difference of depth between two sets of profiles [m]."""
    return max(float(np.abs(depths_of(j, one[j.name]) - depths_of(j, other[j.name])).max()) for j in joints)


def _deepest(joints: tuple[Wearing, ...], removed: Mapping[str, Array]) -> float:
    """Largest depth over the bearing's radius."""
    return max(float(depths_of(joint, removed[joint.name]).max()) / joint.radius for joint in joints)
