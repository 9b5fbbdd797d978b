"""Transmission angles of linkages with any number of loops.

A linkage is solved dyad by dyad if possible. A *dyad* is a pair of links that are joined to each other, and by one
further joint each to links with known motion: the ground, driven links, earlier dyads. If a pin joins the two links,
their *transmission angle* is the acute angle between their lines of force. The line of force of a link passes through
its two pins; if the outer joint is prismatic, it is the normal of the slide. At 90 degrees the pin's position depends
least on errors of the outer joints; at 0 the dyad is singular. For coupler and rocker of a four-bar, and for rod and
slider of a slider-crank, this is the textbook angle.

Links that cannot be reached by dyads move in a larger group, for which the angle is not defined. It is also undefined
for a dyad whose links slide on each other.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array
from linkages.elements.coordinates import Coupled
from linkages.explore.numerics import TRANSMISSION_STILL
from linkages.input.model.mechanism import Joint, Mechanism
from linkages.mechanics.integrate.peak_search import parabola_top
from linkages.system import System


@dataclass(frozen=True)
class Transmission:
    """The transmission angle of a dyad; see the module's docstring."""

    link: str  # links of the dyad; a link joined to the ground is the second
    other: str
    joint: str  # pin between the links
    grounded: bool  # whether the second link is joined to the ground, so that the joint has a fixed path
    angle: Array  # (n,) transmission angle, from 0 to pi/2 [rad]. NaN if the pins of a link coincide
    # drive value [rad or m] and transmission angle [rad] of the extreme angles, between the samples
    least: tuple[float, float]
    most: tuple[float, float]
    turns: tuple[float, ...]  # if `grounded`: drive values at which the joint reverses, its dead centres [rad or m]


class Dyad(NamedTuple):
    """Two links on links with known motion: the joint between them, and the outer joint of each."""

    inner: Joint
    links: tuple[str, str]
    outer: tuple[Joint, Joint]


class DrivenMotion(NamedTuple):
    """Motion of a linkage with one drive: drive values (n,), poses (n, nb, 5) and velocities (n, nb, 3).

    `full`: the drive turns fully; `counts` (n,): the velocities are valid.
    """

    values: Array
    pose: Array
    vel: Array
    full: bool
    counts: NDArray[np.bool_]


def dyads(
    mechanism: Mechanism, driven: Collection[str], coupled: Collection[Coupled] = ()
) -> tuple[list[Dyad], tuple[str, ...]]:
    """Divide a linkage into dyads, in the order in which they can be solved.

    Also returns the links that are neither in a dyad nor moved by driven joints, couplings or dyads.
    """
    known = {joint.name for joint in mechanism.joints if joint.type == "fixed" or joint.name in driven}
    found: list[Dyad] = []
    while True:
        body = mechanism.rigid_groups(known)
        known |= {joint.name for joint in mechanism.joints if body[joint.parent] == body[joint.child]}
        pairs = [one.joints for one in coupled if _is_seen(mechanism, one, body)]
        if moved := {name for pair in pairs for name in pair if known & set(pair)} - known:
            known |= moved
            continue
        outer: dict[str, list[Joint]] = {}
        for joint in mechanism.joints:
            inside = {body[joint.parent], body[joint.child]}
            if body["world"] in inside and len(inside) == 2:
                (moving,) = inside - {body["world"]}
                outer.setdefault(moving, []).append(joint)
        if twice := [joints for joints in outer.values() if len(joints) > 1]:  # redundant link
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


def _is_seen(mechanism: Mechanism, pair: Coupled, body: Mapping[str, str]) -> bool:
    """Tell whether the motion of a coupling's carrier relative to both joints is known; `body`: groups of links."""
    joints = [mechanism.joint[name] for name in pair.joints]
    return pair.carrier is None or all(
        pair.carrier in (joint.parent, joint.child) or body[pair.carrier] == body[joint.parent] for joint in joints
    )


def transmissions(system: System, motion: DrivenMotion) -> tuple[tuple[Transmission, ...], tuple[str, ...]]:
    """Compute the transmission angles of all dyads along a motion; also return the remaining links.

    The system is from `linkages.explore.range_of_motion.movable`.
    """
    mechanism = system.mechanism
    found, rest = dyads(mechanism, list(system.drives), [*system.tree.coupled.values(), *system.tree.loose.values()])
    fixed = mechanism.rigid_groups({joint.name for joint in mechanism.joints if joint.type == "fixed"})
    angles = []
    for inner, links, outer in found:
        if inner.type != "revolute":
            continue
        sides = list(zip(links, outer, strict=True))
        grounded = [fixed["world"] in (fixed[joint.parent], fixed[joint.child]) for joint in outer]
        if grounded[0] and not grounded[1]:
            sides.reverse()
        lines = [_line(system, link, joint, inner, motion) for link, joint in sides]
        cosine = np.sum(lines[0] * lines[1], axis=1)
        sine = lines[0][:, 0] * lines[1][:, 1] - lines[0][:, 1] * lines[1][:, 0]
        between = np.where(np.hypot(sine, cosine) > 0.0, np.arctan2(sine, cosine), np.nan)
        turns = _dead_centres(system, inner, motion) if any(grounded) else ()
        if not np.isnan(between).all():
            least, most = (_extreme(motion, between, sign) for sign in (-1.0, 1.0))
            names = sides[0][0], sides[1][0], inner.name
            angles.append(Transmission(*names, any(grounded), np.abs(_acute(between)), least, most, turns))
    return tuple(angles), rest


def _acute(between: Array) -> Array:
    """Reduce angles of directed lines to angles of undirected lines, from -pi/2 to pi/2."""
    return np.asarray(between - np.pi * np.round(between / np.pi))


def _extreme(motion: DrivenMotion, between: Array, sign: float) -> tuple[float, float]:
    """Find the drive value and the angle at which sign times the acute angle is largest, by a parabola."""
    values = motion.values
    if motion.full:  # a revolution has no ends
        values = np.concatenate([[values[-2] - 2.0 * np.pi], values, [values[1] + 2.0 * np.pi]])
        between = np.concatenate([[between[-2]], between, [between[1]]])
    acute = np.abs(_acute(between))
    inner = slice(1, -1) if motion.full else slice(None)
    best = int(np.nanargmax(sign * acute[inner])) + motion.full
    at, angle = float(values[best]), float(acute[best])
    if not 0 < best < len(values) - 1 or np.isnan(acute[best - 1 : best + 2]).any():
        return at, angle
    near, window = np.unwrap(between[best - 1 : best + 2], period=np.pi), values[best - 1 : best + 2]
    near = (near - np.pi * np.round(near[1] / np.pi)) * (1.0 if _acute(near)[1] >= 0.0 else -1.0)
    limit = 0.5 * np.pi if sign > 0.0 else 0.0  # which the acute angle reaches and leaves with a kink
    if (sign * (near - limit)).max() >= 0.0:
        order = np.argsort(near)
        return float(np.interp(limit, near[order], window[order])), limit
    at, height = parabola_top(*window, *(sign * near))
    return (at % (2.0 * np.pi) if motion.full else at), sign * height


def _line(system: System, link: str, outer: Joint, inner: Joint, motion: DrivenMotion) -> Array:
    """Compute directions (n, 2) of a link's line of force, not normalised; zero if its pins coincide."""
    if outer.type == "prismatic":
        body = system.tree.index[outer.parent]
        cosine, sine = motion.pose[:, body, 3], motion.pose[:, body, 4]
        x, y = outer.direction
        return np.column_stack([-(sine * x + cosine * y), cosine * x - sine * y])
    at = [_followed(system, joint.child, joint.on_child, motion)[0] for joint in (outer, inner)]
    line = at[1] - at[0]
    line[np.linalg.norm(line, axis=1) < TRANSMISSION_STILL * system.tree.extent] = 0.0
    return line


def _dead_centres(system: System, joint: Joint, motion: DrivenMotion) -> tuple[float, ...]:
    """Find the drive values at which a joint reverses on its path."""
    rate = _followed(system, joint.child, joint.on_child, motion)[1]
    fastest = np.abs(motion.vel[:, :, 1:]).max(axis=(1, 2))
    moves = motion.counts & (np.linalg.norm(rate, axis=1) > TRANSMISSION_STILL * fastest)
    values, rate = motion.values[moves], rate[moves]
    if motion.full and moves.any():
        values, rate = np.append(values, values[0] + 2.0 * np.pi), np.append(rate, rate[:1], axis=0)
    speed = np.linalg.norm(rate, axis=1)
    at = values[:-1] + np.diff(values) * speed[:-1] / (speed[:-1] + speed[1:])
    return tuple(map(float, at[np.sum(rate[1:] * rate[:-1], axis=1) < 0.0]))


def _followed(system: System, link: str, point: Array, motion: DrivenMotion) -> tuple[Array, Array]:
    """Compute positions and velocities (n, 2) of a reference point on a link."""
    body, x, y = system.tree.marker(link, point)
    pose, vel = motion.pose[:, body], motion.vel[:, body]
    cosine, sine = pose[:, 3], pose[:, 4]
    arm = np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
    return pose[:, :2] + arm, vel[:, 1:] + vel[:, :1] * np.column_stack([-arm[:, 1], arm[:, 0]])
