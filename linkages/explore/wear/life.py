"""Wear over a machine's life: jumps of second order from block to block.

With s the profiles and H(s) the loads that a block with them gives, a jump of m cycles from s_n is

    s_half = s_n worn by m/2 cycles of the last block,   s_(n+1) = s_n worn by m cycles of H(s_half):

one block for each jump. The last block is at most as far away as the last jump was long, so that s_half is wrong by
O(m^2) and s_(n+1) by O(m^3). What the last block alone would have given is wrong by O(m^2): the difference of the two
depths is kept below the tolerance by the size of the jump. In it the scatter of a chaotic motion counts too.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, Status
from linkages.explore.wear.jump import deepest, difference, mean_work, worn
from linkages.explore.wear.measure import Block, Removed, Wearing, check_wears, wearing
from linkages.explore.wear.stages import Life, Stage
from linkages.explore.wear.store import Store
from linkages.laws.wear.profile import removed_of
from linkages.model.check import DEEPEST
from linkages.system import System

Array = NDArray[np.float64]

#: Default tolerance of the depth in a jump, in parts of the smallest clearance.
TOLERANCE = 0.02
#: Default standard error of the mean work of a block.
SCATTER = 0.01

_FIRST = 5.0  # depth of the first jump, in tolerances
_ROUGH = 4.0  # scatter of the first block, from which only the middle of the first jump is predicted, in that of others
_SHORTER, _LONGER, _SAFETY = 0.2, 5.0, 0.9


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
    joints = check_wears(system, drive)
    if tolerance is None:
        tolerance = TOLERANCE * min(joint.clearance for joint in joints)
    for name, number in (("cycles", cycles), ("tolerance", tolerance), ("scatter", scatter)):
        if not number > 0:
            raise InputError("argument", name, f"is {number:g}; it must be above zero")
    store = Store(system, folder)
    removed = _new(system)
    stages: list[Stage] = []
    status, simulated, rejected, jump = Status.OK, 0, 0, 1

    def so_far() -> Life:
        return Life(system, tuple(stages), status, simulated, rejected, tolerance, scatter)

    try:
        block = store.measure(removed, None, scatter if every_cycle else _ROUGH * scatter, drive)
        simulated, status = block.cycles, block.status
        stages.append(Stage(0, removed, {joint.name: 0.0 for joint in joints}, 0.0, block, 0.0))
        if not every_cycle and status is Status.OK:
            jump = _first_jump(joints, removed, block, tolerance)
        while status is Status.OK and stages[-1].cycles < cycles:
            last = stages[-1]
            jump = 1 if every_cycle else min(jump, cycles - last.cycles)
            half = last.removed if every_cycle else worn(joints, last.removed, block, 0.5 * jump)
            if deepest(joints, half) > DEEPEST:
                status = Status.WORN_OUT
                break
            middle = store.measure(half, block.end, 0.0 if every_cycle else scatter, drive, every_cycle)
            simulated, status = simulated + middle.cycles, middle.status
            if status is not Status.OK:
                break
            found = worn(joints, last.removed, middle, jump)
            error = 0.0
            if not every_cycle:
                error = difference(joints, found, worn(joints, last.removed, block, jump))
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
    rate = difference(joints, worn(joints, removed, block, 1.0), removed)
    return max(1, int(min(_FIRST * tolerance / rate, 1e9))) if rate > 0.0 else 10**9
