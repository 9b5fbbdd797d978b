"""Range of motion of a linkage with ideal joints: limits of its drives, dead points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, InputError, Status
from linkages.explore.numerics import RANGE_OF_MOTION_BESIDE
from linkages.explore.transmission import DrivenMotion, Transmission, transmissions
from linkages.input.model.experiment import nothing_done
from linkages.input.model.mechanism import Mechanism
from linkages.mechanics.planar.kinematics import state_tables
from linkages.system import System
from linkages.system.assembly import independent
from linkages.system.ideal_motion import IdealMotion


@dataclass(frozen=True)
class Travel:
    """The range of motion of one drive, with the other drives at their start."""

    drive: str  # name of the driven joint
    values: Array  # (n,) increasing coordinate of the drive over its range of motion [rad or m]
    # (n, nb, 5) poses of the bodies of the system's tree, as in `linkages.mechanics.planar.kinematics.body_positions`
    pose: Array
    full: bool  # whether the drive turns fully
    ends: tuple[Status, Status]  # reasons of both ends: LOCKED at a dead point, OK at the limit of the search
    transmissions: tuple[Transmission, ...]  # transmission angles of the dyads, in the order of their solution
    together: tuple[str, ...]  # links in a larger group, without a defined transmission angle


def movable(mechanism: Mechanism, starts: Mapping[str, float], tables: Mapping[str, Any] | None = None) -> System:
    """Make a system with ideal joints whose drives determine the motion, without loads, with drives at rest.

    `tables` are those of the elements that couple coordinates. `starts` are coordinates of driven joints [rad or m]; a
    joint that the others already move is dropped. If they are too few, further joints are driven from the reference
    configuration, in the order: fully turning, on the ground, revolute, prismatic. AssemblyError if the loops do not
    close there.
    """
    held = partial(_held, mechanism, tables or {})
    mobility = held({}).assembly.mobility
    wanted = list(starts)
    if mobility == 1 and not wanted:
        wanted = [name for name in _candidates(mechanism) if _turns_fully(held({name: 0.0}), name)][:1]
    chosen: dict[str, float] = {}
    for name in dict.fromkeys([*wanted, *_candidates(mechanism)]):
        if len(chosen) == mobility:
            break
        if _independent(held({**dict.fromkeys(chosen, 0.0), name: 0.0})):
            chosen[name] = starts.get(name, 0.0)
    return held(chosen)


def travel(system: System, drive: str) -> Travel:
    """Move one drive of `movable` to its limits, at most one revolution or twice the linkage's size either way."""
    turns = system.joints[drive].type == "revolute"
    reach = 2.0 * np.pi if turns else 2.0 * system.tree.extent
    start = system.drives[drive].angle
    up = _way(system, drive, reach)
    full = turns and up.status is Status.OK
    ways = [(up, 1.0)] if full else [(_way(system, drive, -reach), -1.0), (up, 1.0)]
    parts = [slice(None, 0, -1) if sign < 0.0 else slice(None) for _, sign in ways]  # without repeating the start
    values, q, v = (
        np.concatenate(tables)
        for tables in zip(
            *(
                (start + sign * reach * way.times[part], way.q[part], sign * way.v[part])
                for (way, sign), part in zip(ways, parts, strict=True)
            ),
            strict=True,
        )
    )
    pose, vel = state_tables(system.tree.bodies, q, v)
    ends = ways[0][0].status, up.status
    counts = np.ones(len(values), dtype=bool)
    for end, status in zip(values[[0, -1]], ends, strict=True):
        if status is Status.LOCKED:  # rates near a dead point are unbounded, and mere rounding next to it
            counts &= np.abs(values - end) > RANGE_OF_MOTION_BESIDE * reach
    counts[-1] &= not full  # the end of a revolution is its start
    return Travel(
        drive, values, pose, full, ends, *transmissions(system, DrivenMotion(values, pose, vel, full, counts))
    )


def _held(mechanism: Mechanism, tables: Mapping[str, Any], starts: Mapping[str, float]) -> System:
    still = {name: {"angle": float(angle), "speed": 0.0} for name, angle in starts.items()}
    return System(mechanism, nothing_done(mechanism.source, {"drives": still, **tables}))


def _candidates(mechanism: Mechanism) -> list[str]:
    """List the joints that can be driven, best candidates first."""
    joints = [joint for joint in mechanism.joints if joint.type != "fixed"]
    rank = {joint.name: ("world" not in (joint.parent, joint.child), joint.type != "revolute") for joint in joints}
    return sorted(rank, key=lambda name: rank[name])


def _turns_fully(system: System, name: str) -> bool:
    if system.joints[name].type != "revolute":
        return False
    try:
        return system.determinate and _way(system, name, 2.0 * np.pi).status is Status.OK
    except (AssemblyError, InputError):
        return False


def _independent(system: System) -> bool:
    """Check that no driven joint is moved by the others."""
    try:
        tree, q = system.tree, system.assembly.q
    except (AssemblyError, InputError):
        return False
    rows = tree.closure_rows
    return independent(tree, rows, q, tree.closing_dofs) == independent(tree, rows, q)


def _way(system: System, drive: str, speed: float) -> IdealMotion:
    """Follow a drive for a second at a speed [rad/s or m/s]."""
    return IdealMotion(system.replaced({f"drives.{drive}.speed": speed}))
