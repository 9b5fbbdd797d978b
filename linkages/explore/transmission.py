"""Transmission angles of linkages with any number of loops.

A linkage is solved dyad by dyad where that is possible. A *dyad* is a pair of links that are joined to each other, and
by one further joint each to links whose motion is known already: the ground, links that the drives move, earlier dyads.
If a pin joins the two links, their *transmission angle* is the acute angle between their lines of force. The line of a
link passes through its two pins; if the outer joint is a slide, it is the normal of the slide. At 90 degrees the pin's
position follows best from the positions of the outer joints; at 0 the dyad is singular. For the coupler and the rocker
of a four-bar, and for the rod and the slider of a slider-crank, this is the angle of the textbooks.

Links that cannot be reached by dyads move together in a larger group, for which no such angle is defined. Nor is it
defined for a dyad whose links slide on each other.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.arrays import Array
from linkages.model.gear import Gear
from linkages.model.mechanism import Joint, Mechanism
from linkages.system import System

_STILL = 1e-6  # of the fastest body, or of the size: slower points, and shorter lines, have no direction


@dataclass(frozen=True)
class Transmission:
    """The transmission angle of a dyad; see the head of this module.

    Attributes
    ----------
    link, other : str
        Links of the dyad. If one of them is joined to the ground, it is the second.
    joint : str
        Pin between the two.
    grounded : bool
        Whether the second link is joined to the ground, so that the first one moves the joint along its path.
    angle : (n,) array
        Transmission angle, from 0 to pi/2 [rad]. NaN where the pins of a link coincide.
    turns : tuple of float
        If `grounded`, values of the drive at which the joint turns back: the dead centres of what it moves [rad or m].
    """

    link: str
    other: str
    joint: str
    grounded: bool
    angle: Array
    turns: tuple[float, ...]


class Dyad(NamedTuple):
    """Two links on links whose motion is known: the joint between them, and the outer joint of each."""

    inner: Joint
    links: tuple[str, str]
    outer: tuple[Joint, Joint]


class Motion(NamedTuple):
    """How a linkage moves with one drive: values of the drive (n,), poses (n, nb, 5) and velocities (n, nb, 3).

    `full` says whether the drive turns fully, `counts` (n,) where velocities count.
    """

    values: Array
    pose: Array
    vel: Array
    full: bool
    counts: NDArray[np.bool_]


def dyads(
    mechanism: Mechanism, driven: Collection[str], gears: Iterable[Gear] = ()
) -> tuple[list[Dyad], tuple[str, ...]]:
    """Divide a linkage into dyads, in the order in which they can be solved.

    Parameters
    ----------
    mechanism : Mechanism
    driven : collection of str
        Driven joints.
    gears : iterable of Gear, optional

    Returns
    -------
    found : list of Dyad
    rest : tuple of str
        Links that no dyad contains and that are not moved by drives, gears or other dyads.
    """
    known = {joint.name for joint in mechanism.joints if joint.type == "fixed" or joint.name in driven}
    pairs = [gear.joints for gear in gears]
    found: list[Dyad] = []
    while True:
        body = _rigid(mechanism, known)
        known |= {joint.name for joint in mechanism.joints if body[joint.parent] == body[joint.child]}
        if geared := {name for pair in pairs for name in pair if known & set(pair)} - known:
            known |= geared
            continue
        outer: dict[str, list[Joint]] = {}
        for joint in mechanism.joints:
            inside = {body[joint.parent], body[joint.child]}
            if body["world"] in inside and len(inside) == 2:
                (moving,) = inside - {body["world"]}
                outer.setdefault(moving, []).append(joint)
        if twice := [joints for joints in outer.values() if len(joints) > 1]:  # a redundant link
            known |= {joint.name for joint in twice[0]}
            continue
        for joint in mechanism.joints:
            ends = body[joint.parent], body[joint.child]
            if ends[0] != ends[1] and all(end in outer for end in ends):
                one, two = (outer[end][0] for end in ends)
                found.append(Dyad(joint, (joint.parent, joint.child), (one, two)))
                known |= {one.name, two.name}
                break
        else:
            return found, tuple(name for name in mechanism.link if body[name] != body["world"])


def _rigid(mechanism: Mechanism, known: Collection[str]) -> dict[str, str]:
    """Name for each link the group of links that it moves with as one body, if these joints are known."""
    group = {name: name for name in ("world", *mechanism.link)}
    for joint in mechanism.joints:
        if joint.name in known:
            old, new = group[joint.child], group[joint.parent]
            group = {link: new if name == old else name for link, name in group.items()}
    return group


def transmissions(system: System, motion: Motion) -> tuple[tuple[Transmission, ...], tuple[str, ...]]:
    """Compute the transmission angles of all dyads along a motion; return also the links that are in none.

    Parameters
    ----------
    system : System
        From `linkages.explore.range_of_motion.movable`.
    motion : Motion
    """
    mechanism, experiment = system.mechanism, system.experiment
    found, rest = dyads(mechanism, list(experiment.drives), experiment.gears.values())
    fixed = _rigid(mechanism, {joint.name for joint in mechanism.joints if joint.type == "fixed"})
    angles = []
    for inner, links, outer in found:
        if inner.type != "revolute":
            continue
        sides = list(zip(links, outer, strict=True))
        grounded = [fixed["world"] in (fixed[joint.parent], fixed[joint.child]) for joint in outer]
        if grounded[0] and not grounded[1]:
            sides.reverse()
        lines = [_line(system, link, joint, inner, motion) for link, joint in sides]
        cosine = np.abs(np.sum(lines[0] * lines[1], axis=1))
        sine = np.abs(lines[0][:, 0] * lines[1][:, 1] - lines[0][:, 1] * lines[1][:, 0])
        angle = np.where(np.hypot(sine, cosine) > 0.0, np.arctan2(sine, cosine), np.nan)
        turns = _dead_centres(system, inner, motion) if any(grounded) else ()
        if not np.isnan(angle).all():
            angles.append(Transmission(sides[0][0], sides[1][0], inner.name, any(grounded), angle, turns))
    return tuple(angles), rest


def _line(system: System, link: str, outer: Joint, inner: Joint, motion: Motion) -> Array:
    """Directions (n, 2) of a link's line of force, of any length; zero where its pins coincide."""
    if outer.type == "prismatic":
        body = system.tree.index[outer.parent]
        cosine, sine = motion.pose[:, body, 3], motion.pose[:, body, 4]
        x, y = outer.direction
        return np.column_stack([-(sine * x + cosine * y), cosine * x - sine * y])
    at = [_followed(system, joint.child, joint.on_child, motion)[0] for joint in (outer, inner)]
    line = at[1] - at[0]
    line[np.linalg.norm(line, axis=1) < _STILL * system.tree.extent] = 0.0
    return line


def _dead_centres(system: System, joint: Joint, motion: Motion) -> tuple[float, ...]:
    """Find where a joint turns back on its path."""
    rate = _followed(system, joint.child, joint.on_child, motion)[1]
    fastest = np.abs(motion.vel[:, :, 1:]).max(axis=(1, 2))
    moves = motion.counts & (np.linalg.norm(rate, axis=1) > _STILL * fastest)
    return _turns_back(motion.values[moves], rate[moves], motion.full) if moves.any() else ()


def _turns_back(values: Array, rate: Array, full: bool) -> tuple[float, ...]:
    """Values at which a point that moves at these rates (n, 2) turns back, over a full turn or between its ends."""
    if full:
        values, rate = np.append(values, values[0] + 2.0 * np.pi), np.append(rate, rate[:1], axis=0)
    speed = np.linalg.norm(rate, axis=1)
    at = values[:-1] + np.diff(values) * speed[:-1] / (speed[:-1] + speed[1:])
    return tuple(map(float, at[np.sum(rate[1:] * rate[:-1], axis=1) < 0.0]))


def _followed(system: System, link: str, point: Array, motion: Motion) -> tuple[Array, Array]:
    """Positions and velocities (n, 2) of a point drawn on a link."""
    body, x, y = system.tree.marker(link, point)
    pose, vel = motion.pose[:, body], motion.vel[:, body]
    cosine, sine = pose[:, 3], pose[:, 4]
    arm = np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
    return pose[:, :2] + arm, vel[:, 1:] + vel[:, :1] * np.column_stack([-arm[:, 1], arm[:, 0]])
