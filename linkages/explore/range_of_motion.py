"""How far a linkage with ideal joints can be moved: travel of its drives, dead points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from linkages.arrays import Array
from linkages.errors import AssemblyError, InputError, Status
from linkages.explore.transmission import Motion, Transmission, transmissions
from linkages.model.experiment import nothing_done
from linkages.model.gear import Gear
from linkages.model.mechanism import Mechanism
from linkages.planar.bodies import make_motion, make_pose
from linkages.planar.kinematics import spread
from linkages.system import System
from linkages.system.assembly import independent
from linkages.system.ideal_motion import IdealMotion


@dataclass(frozen=True)
class Travel:
    """The way of one drive, the others at rest where they start.

    Attributes
    ----------
    drive : str
        The joint.
    values : (n,) array
        Its coordinate, rising from one end of its way to the other [rad or m].
    pose : (n, nb, 5) array
        Poses of the bodies of the system's tree, as `linkages.planar.kinematics.body_positions` has them.
    full : bool
        Whether it turns fully.
    ends : (Status, Status)
        Why it ends below and above: LOCKED at a dead point, OK where it was not followed further.
    transmissions : tuple of Transmission
        Of the dyads, in the order in which they are solved.
    together : tuple of str
        Links that move in a larger group, for which no transmission angle is defined.
    """

    drive: str
    values: Array
    pose: Array
    full: bool
    ends: tuple[Status, Status]
    transmissions: tuple[Transmission, ...]
    together: tuple[str, ...]


def movable(mechanism: Mechanism, starts: Mapping[str, float], gears: Mapping[str, Gear] | None = None) -> System:
    """Make a system whose drives determine the motion of the machine with ideal joints.

    Parameters
    ----------
    mechanism : Mechanism
    starts : mapping of str to float
        Joints that are driven, with their coordinates [rad or m]; those that the others already move are left out.
        Where they are too few, further joints are driven from the drawn pose: such as turn fully before others, joints
        on the ground before others, revolute ones before prismatic ones.
    gears : mapping of str to Gear, optional
        Gears and belts between joints.

    Returns
    -------
    System
        Without loads; its drives are at rest.

    Raises
    ------
    AssemblyError
        If the loops do not close as drawn.
    """
    held = partial(_held, mechanism, gears or {})
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
    """Move one drive of a system as far as it goes, at most once around or twice the linkage's size either way.

    Parameters
    ----------
    system : System
        From `movable`.
    drive : str

    Raises
    ------
    AssemblyError
        If the loops do not close where the drives start.
    """
    turns = system.mechanism.joint[drive].type == "revolute"
    reach = 2.0 * np.pi if turns else 2.0 * system.tree.extent
    start = system.experiment.drives[drive].angle
    up = _way(system, drive, reach)
    full = turns and up.status is Status.OK
    ways = [(up, 1.0)] if full else [(_way(system, drive, -reach), -1.0), (up, 1.0)]
    parts = [slice(None, 0, -1) if sign < 0.0 else slice(None) for _, sign in ways]  # the start once
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
    bodies = system.tree.bodies
    pose, vel, acc = (np.empty((len(q), *one(bodies).shape)) for one in (make_pose, make_motion, make_motion))
    spread(bodies, q, v, np.zeros_like(q), pose, vel, acc)
    ends = ways[0][0].status, up.status
    counts = np.ones(len(values), dtype=bool)
    counts[[0, -1]] = [end is not Status.LOCKED for end in ends]  # rates at a dead point have no bound
    counts[-1] &= not full  # the end of the turn is its start
    return Travel(drive, values, pose, full, ends, *transmissions(system, Motion(values, pose, vel, full, counts)))


def _held(mechanism: Mechanism, gears: Mapping[str, Gear], starts: Mapping[str, float]) -> System:
    return System(mechanism, nothing_done(mechanism.source, drives=starts, gears=gears))


def _candidates(mechanism: Mechanism) -> list[str]:
    """Joints that can be driven, the likeliest first."""
    joints = [joint for joint in mechanism.joints if joint.type != "fixed"]
    rank = {joint.name: ("world" not in (joint.parent, joint.child), joint.type != "revolute") for joint in joints}
    return sorted(rank, key=lambda name: rank[name])


def _turns_fully(system: System, name: str) -> bool:
    if system.mechanism.joint[name].type != "revolute":
        return False
    try:
        return system.determinate and _way(system, name, 2.0 * np.pi).status is Status.OK
    except (AssemblyError, InputError):
        return False


def _independent(system: System) -> bool:
    """Whether none of the driven joints is moved by the others."""
    try:
        tree, q = system.tree, system.assembly.q
    except (AssemblyError, InputError):
        return False
    rows = tree.closure_rows
    return independent(tree, rows, q, tree.closing_dofs) == independent(tree, rows, q)


def _way(system: System, drive: str, speed: float) -> IdealMotion:
    """Follow a drive for a second at a speed [rad/s or m/s]."""
    return IdealMotion(system.replaced({f"drives.{drive}.speed": speed}))
