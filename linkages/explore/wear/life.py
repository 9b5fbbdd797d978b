"""Wear over the service life: jumps of second order from block to block.

With s the profiles and H(s) the loads that a block with them gives, a jump of m cycles from s_n is

    s_half = s_n worn by m/2 cycles of the last block,   s_(n+1) = s_n worn by m cycles of H(s_half):

with one block per jump. The last block is at most one jump length away, so that s_half has an error O(m^2) and s_(n+1)
an error O(m^3). The result of the last block alone has an error O(m^2): the jump length keeps the difference of the two
depths below the tolerance. The difference includes the scatter of a chaotic motion. A jump with a larger error is
repeated with a shorter length, with loads interpolated between the two blocks.

Many jumps with few cycles each give the mean of a chaotic motion as accurately as few jumps with many cycles, and
follow its change better. Errors of blocks are independent: a block of a short jump may have a larger relative error.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from linkages.base.arguments import Count, validated
from linkages.base.arrays import Array
from linkages.base.errors import InputError, Status
from linkages.explore.numerics import LIFE_FIRST, LIFE_ROUGH
from linkages.explore.wear.block_store import BlockStore
from linkages.explore.wear.measure import CycleBlock, LoadSamples, Removed, Wearing, check_wears, wearing
from linkages.explore.wear.stages import Life, Stage, between, deepest, difference, worn
from linkages.input.model.check import DEEPEST
from linkages.laws.wear.profile import removed_of
from linkages.system import System

Joints = tuple[Wearing, ...]
#: Function that adds a stage; returns True if the calculation can end.
Add = Callable[[Stage], bool]

#: Default tolerance of the depth in a jump over the smallest clearance.
TOLERANCE = 0.01
#: Default relative standard error of the work of all cycles.
SCATTER = 0.02

_SHORTER, _LONGER, _SAFETY = 0.2, 5.0, 0.9


@validated
def wear_life(
    system: System,
    cycles: Count,
    tolerance: float | None = None,
    scatter: float | None = None,
    drive: str | None = None,
    folder: Path | None = None,
    every_cycle: bool = False,
    enough: Callable[[Life], bool] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Life:
    """Compute the wear of joints over many cycles.

    Parameters
    ----------
    system : System
        System with ``joints.J.wear`` of at least one joint.
    cycles : int
        Revolutions of the drive.
    tolerance : float, optional
        Largest difference of depth between a jump's first and second order [m]; default 0.01 of the smallest clearance.
    scatter : float, optional
        Relative standard error of the work of all cycles at which a block ends, default 0.02; for the work of a
        single jump the error may be larger, by the square root of all cycles over the jump's.
    drive : str, optional
        Drive that defines a cycle; default: see `linkages.explore.flow.period_of`.
    folder : Path, optional
        Folder of the blocks: an interrupted calculation continues from them, with identical results.
    every_cycle : bool
        Simulate every cycle without jumps, to check the jumps.
    enough : callable, optional
        Function of the present life that returns True to end the calculation early.
    progress : callable, optional
        Called with the finished cycles.

    Returns
    -------
    Life
        Stages up to the last cycle, or until a block failed or was interrupted.

    Raises
    ------
    InputError
        If no joint wears, a model does not support it, or a value is not valid.
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
    joints = check_wears(system, drive)
    if tolerance is None:
        tolerance = TOLERANCE * min(joint.clearance for joint in joints)
    if scatter is None:
        scatter = SCATTER
    for name, number in (("cycles", cycles), ("tolerance", tolerance), ("scatter", scatter)):
        if not number > 0:
            raise InputError("argument", name, f"is {number:g}; it must be above zero")
    stages: list[Stage] = []

    def so_far(status: Status) -> Life:
        return Life(system, tuple(stages), status, tolerance, scatter)

    def add(stage: Stage) -> bool:
        stages.append(stage)
        if progress is not None:
            progress(stage.cycles)
        return enough is not None and enough(so_far(Status.OK))

    store = BlockStore(system, drive, folder)
    try:
        removed = _new(system)
        block = store.measure(removed, None, scatter if every_cycle else LIFE_ROUGH * scatter)
        first = Stage(0, removed, {joint.name: 0.0 for joint in joints}, 0.0, block, block.loads)
        if add(first) or block.status is not Status.OK:
            return so_far(block.status)
        if every_cycle:
            return so_far(_every_cycle(joints, first, store, cycles, add))
        return so_far(_jumps(joints, first, store, cycles, tolerance, scatter, add))
    except KeyboardInterrupt:
        if not stages:
            raise
        return so_far(Status.INTERRUPTED)


def _every_cycle(joints: Joints, last: Stage, store: BlockStore, cycles: int, add: Add) -> Status:
    """Simulate every cycle up to the last one, until `add` returns True, or until a run fails."""
    while last.cycles < cycles:
        if deepest(joints, last.removed) > DEEPEST:
            return Status.WORN_OUT
        block = store.measure(last.removed, last.block.end, 0.0, single=True)
        if block.status is not Status.OK:
            return block.status
        found = worn(joints, last.removed, block.loads, 1)
        last = _reached(last, 1, found, block, block.loads, last.cycles + 0.5)
        if add(last):
            break
    return Status.OK


def _jumps(
    joints: Joints, last: Stage, store: BlockStore, cycles: int, tolerance: float, scatter: float, add: Add
) -> Status:
    """Jump from block to block up to the last cycle, until `add` returns True, or until a block fails."""
    rate = difference(joints, worn(joints, last.removed, last.block.loads, 1.0), last.removed)
    jump = max(1, int(min(LIFE_FIRST * tolerance / rate, 1e9))) if rate > 0.0 else 10**9
    while last.cycles < cycles:
        jump = min(jump, cycles - last.cycles)
        ahead = worn(joints, last.removed, last.block.loads, jump)
        while deepest(joints, ahead) > DEEPEST:
            if jump == 1 or difference(joints, ahead, last.removed) <= tolerance:
                return Status.WORN_OUT
            jump //= 2
            ahead = worn(joints, last.removed, last.block.loads, jump)
        half = worn(joints, last.removed, last.block.loads, 0.5 * jump)
        # errors of jumps are independent: the limit applies to the error of their sum
        block = store.measure(half, last.block.end, scatter * np.sqrt((last.cycles + jump) / jump))
        if block.status is not Status.OK:
            return block.status
        last, jump = _jumped(joints, last, block, jump, ahead, tolerance)
        if add(last):
            break
    return Status.OK


def _jumped(
    joints: Joints, last: Stage, block: CycleBlock, jump: int, ahead: Removed, tolerance: float
) -> tuple[Stage, int]:
    """Jump with a block measured with the profiles at the jump's middle; return also the next jump length.

    `ahead` are the profiles predicted from the last block's loads. A jump with a large error is repeated with a shorter
    length, with loads interpolated between the two blocks, so that no measurement is lost.
    """
    middle, rejected = last.cycles + 0.5 * jump, 0
    apart = middle - last.middle
    while True:
        part = (last.cycles + 0.5 * jump - last.middle) / apart if apart > 0.0 else 1.0
        loads = between(last.block.loads, block.loads, min(max(part, 0.0), 1.0))
        found = worn(joints, last.removed, loads, jump)
        error = difference(joints, found, ahead)
        factor = _SAFETY * np.sqrt(tolerance / error) if error > 0.0 else _LONGER
        following = max(1, int(jump * min(max(factor, _SHORTER), _LONGER)))
        if error <= tolerance or jump == 1:
            return _reached(last, jump, found, block, loads, middle, error, rejected), following
        jump, rejected = following, rejected + 1
        ahead = worn(joints, last.removed, last.block.loads, jump)


def _reached(
    last: Stage,
    jump: int,
    removed: dict[str, Array],
    block: CycleBlock,
    loads: LoadSamples,
    middle: float,
    error: float = 0.0,
    rejected: int = 0,
) -> Stage:
    """Make the stage some cycles after the last one."""
    work = {name: done + jump * float(loads[name][:, 6].sum()) for name, done in last.work.items()}
    return Stage(last.cycles + jump, removed, work, middle, block, loads, error, rejected)


def _new(system: System) -> dict[str, Array]:
    """Return the initial profiles of the experiment."""
    models = dict(zip((name for name, _ in system.contacts), system.models, strict=True))
    found = {}
    for joint in wearing(system):
        wear = models[joint.name].wear
        assert wear is not None
        lines = [np.array(depths or [0.0] * wear.nodes) for depths in wear.depths]
        found[joint.name] = np.array([removed_of(line, r) for line, r in zip(lines, joint.radii, strict=True)])
    return found
