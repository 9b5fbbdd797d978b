"""How far a linkage with ideal joints can be moved: its drives' travel, dead points, transmission angles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from linkages.errors import AssemblyError, InputError, Status
from linkages.model.experiment import nothing_done
from linkages.model.gear import Gear
from linkages.model.mechanism import Mechanism
from linkages.model.skeleton import skeleton
from linkages.planar.bodies import make_motion, make_pose
from linkages.planar.kinematics import spread
from linkages.system import System
from linkages.system.assembly import independent
from linkages.system.ideal_motion import IdealMotion

Array = NDArray[np.float64]

_STILL = 1e-6  # of the fastest point: slower ones have no direction


@dataclass(frozen=True)
class Transmission:
    """A link with two pins, which passes a force along itself to a link on the ground, farther from the drive.

    Attributes
    ----------
    link, joint : str
    angle : (n,) array
        Transmission angle: 90 degrees less the angle between the force and the way on which the joint moves; 90
        degrees is best, at 0 the force moves nothing [rad]. NaN where the joint stands still.
    turns : tuple of float
        Values of the drive at which the joint turns back: the dead centres of what it moves [rad or m].
    """

    link: str
    joint: str
    angle: Array
    turns: tuple[float, ...]


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
    """

    drive: str
    values: Array
    pose: Array
    full: bool
    ends: tuple[Status, Status]
    transmissions: tuple[Transmission, ...]


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
    found = tuple(_transmissions(system, drive, values, pose, vel, ends, full))
    return Travel(drive, values, pose, full, ends, found)


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


def _transmissions(
    system: System, drive: str, values: Array, pose: Array, vel: Array, ends: tuple[Status, Status], full: bool
) -> list[Transmission]:
    """Find what links with two pins pass on."""
    mechanism, found = system.mechanism, []
    away = _distances(mechanism, drive)
    grounded = [{joint.parent, joint.child} for joint in mechanism.joints if "world" in (joint.parent, joint.child)]
    guided = set().union(*grounded)  # others go where several links take them
    for link in mechanism.links:
        joints = [joint for joint in mechanism.joints if link.name in (joint.parent, joint.child)]
        beyond = [joint.parent if joint.child == link.name else joint.child for joint in joints]
        if len(joints) != 2 or "world" in beyond or any(joint.type != "revolute" for joint in joints):
            continue
        if len(skeleton(mechanism, link, system.tree.extent).places) != 2:  # it carries a point of its own
            continue
        far, near = (1, 0) if away[beyond[1]] >= away[beyond[0]] else (0, 1)
        if beyond[far] not in guided:
            continue
        places, rates = zip(
            *(_followed(system, joint.child, joint.on_child, pose, vel) for joint in (joints[near], joints[far])),
            strict=True,
        )
        along, rate = places[1] - places[0], rates[1]
        along /= np.linalg.norm(along, axis=1)[:, None]
        speed = np.linalg.norm(rate, axis=1)
        moves = speed > _STILL * np.abs(vel[:, :, 1:]).max()
        if not moves.any():  # another drive holds it
            continue
        angle = np.full(len(values), np.nan)
        part = np.abs(np.sum(along * rate, axis=1)[moves]) / speed[moves]
        angle[moves] = np.arcsin(np.clip(part, 0.0, 1.0))
        moves[[0, -1]] &= [end is not Status.LOCKED for end in ends]  # rates at a dead point have no bound
        moves[-1] &= not full  # the end of the turn is its start
        turns = _turns_back(values[moves], rate[moves], full)
        found.append(Transmission(link.name, joints[far].name, angle, turns))
    return found


def _turns_back(values: Array, rate: Array, full: bool) -> tuple[float, ...]:
    """Values at which a point that moves at these rates (n, 2) turns back, over a full turn or between its ends."""
    if full:
        values, rate = np.append(values, values[0] + 2.0 * np.pi), np.append(rate, rate[:1], axis=0)
    speed = np.linalg.norm(rate, axis=1)
    at = values[:-1] + np.diff(values) * speed[:-1] / (speed[:-1] + speed[1:])
    return tuple(map(float, at[np.sum(rate[1:] * rate[:-1], axis=1) < 0.0]))


def _distances(mechanism: Mechanism, drive: str) -> dict[str, int]:
    """Count the joints between each link and those that the drive moves, not through the ground."""
    joint = mechanism.joint[drive]
    away, front = {"world": 0}, [name for name in (joint.parent, joint.child) if name != "world"]
    away |= dict.fromkeys(front, 0)
    for inner in front:  # which becomes longer meanwhile
        for other in mechanism.joints:
            for one, two in ((other.parent, other.child), (other.child, other.parent)):
                if one == inner and two not in away:
                    away[two] = away[inner] + 1
                    front.append(two)
    return away | {name: len(away) for name in mechanism.link if name not in away}


def _followed(system: System, link: str, point: Array, pose: Array, vel: Array) -> tuple[Array, Array]:
    """Positions and velocities (n, 2) of a point drawn on a link."""
    body, x, y = system.tree.marker(link, point)
    cosine, sine = pose[:, body, 3], pose[:, body, 4]
    arm = np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
    turning = vel[:, body, 0]
    return pose[:, body, :2] + arm, vel[:, body, 1:] + turning[:, None] * np.column_stack([-arm[:, 1], arm[:, 0]])
