"""Constraints and springs of other programs between links, converted to joints, frames and entries of an experiment."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.input.files.elements import number, numbers
from linkages.input.files.foreign import Entry, Foreign
from linkages.input.files.raw_model import Pose, RawJoint, RawModel
from linkages.input.files.rigid import moved
from linkages.input.files.xml import label

_NEAR = 1e-9  # gap [m] or rotation [rad] below which frames coincide


def joined(foreign: Foreign, raw: RawModel) -> RawModel:
    """Return the mechanism with joints and frames for its constraints and springs; adds entries and notes."""
    for element in foreign.constraints:
        raw = _MADE[element.tag](foreign, raw, element)
    return raw


def _weld(foreign: Foreign, raw: RawModel, element: ET.Element) -> RawModel:
    """Fix two links together so that two frames coincide; the second moves with all links fixed to it."""
    path, where = foreign.path, label(element)
    poses = {"world": ("world", Pose())} | {link.name: (link.name, link.pose) for link in raw.links} | raw.frames
    (one, to), (other, of) = (poses[name] for name in _named(path, element, ("parent", "child"), poses))
    way = to @ of.inverse()
    chains = raw.chains("fixed")
    apart = max(np.abs(way.translation).max(), np.abs(way.rotation - np.eye(3)).max()) > _NEAR
    if other in chains.of[one]:
        if apart:
            raise InputError(path, where, f'cannot hold: "{one}" and "{other}" are fixed to one another elsewhere')
        return raw
    if apart:
        if "world" in chains.of[other]:
            one, other, way = other, one, way.inverse()
        group = chains.of[other]
        for joint in raw.joints:
            crossing = (joint.parent in group) != (joint.child in group)
            if crossing and joint.type == "revolute" and np.abs(way.rotation @ joint.axis - joint.axis).max() > _NEAR:
                raise InputError(path, where, f'rotates "{other}" out of the plane of joint "{joint.name}"')
        raw = moved(raw, dict.fromkeys(group, way))
    foreign.notes.append(f"{where}: {other} is fixed to {one}")
    return replace(raw, joints=(*raw.joints, RawJoint.fixed(raw.free_name("weld_constraint"), one, other)))


def _ball(foreign: Foreign, raw: RawModel, element: ET.Element) -> RawModel:
    """Join two points by a revolute joint, the planar equivalent of a ball joint."""
    (one, at), (other, here) = _points(foreign.path, raw, element)
    name, normal = raw.free_name(element.get("name") or "ball_constraint"), _normal(foreign.path, raw, element)
    where = "loop" if element.get("name") else label(element)
    foreign.notes.append(f"{where}: revolute joint {name} between {one} and {other}")
    joint = RawJoint(name, "revolute", one, other, normal, here, at, None, None)
    return replace(raw, joints=(*raw.joints, joint))


def _spring(foreign: Foreign, raw: RawModel, element: ET.Element) -> RawModel:
    """Put a frame at each end of a spring; the spring becomes an entry of the experiment."""
    path, where = foreign.path, label(element)
    ends, normal = _points(path, raw, element), _normal(path, raw, element)
    if abs((ends[1][1] - ends[0][1]) @ normal) > _NEAR:
        raise InputError(path, where, "has its ends in two planes; a planar linkage has one")
    name = raw.free_name("linear_spring_damper")
    frames = {f"{name}_{end}": (link, Pose(np.eye(3), at)) for end, (link, at) in zip("AB", ends, strict=True)}
    values: dict[str, Any] = dict(zip(("point", "to"), frames, strict=True))
    for key in ("stiffness", "free_length", "damping"):
        values[key] = number(path, element, f"{element.tag}_{key}", where)
    foreign.entries.append(Entry(where, "springs", name, values))
    return replace(raw, frames=raw.frames | frames)


#: Elements between links, and the function that adds each to a machine.
_MADE: dict[str, Callable[[Foreign, RawModel, ET.Element], RawModel]] = {
    "drake:weld_constraint": _weld,
    "drake:ball_constraint": _ball,
    "drake:linear_spring_damper": _spring,
}


def _named(path: Path, element: ET.Element, keys: tuple[str, ...], known: Mapping[str, object]) -> Iterator[str]:
    """Read the names in children of an element, with or without the prefix of Drake."""
    for key in keys:
        name = (element.findtext(key) or element.findtext(f"drake:{key}") or "").strip()
        if name not in known:
            raise InputError(path, label(element), f'its <{key}> is "{name}"; {nearest(name, known)}')
        yield name


def _points(path: Path, raw: RawModel, element: ET.Element) -> list[tuple[str, Array]]:
    """Read the two links of a constraint, and the reference positions of its points in the world [m]."""
    poses = {"world": Pose()} | {link.name: link.pose for link in raw.links}
    found = []
    for body, point in (("body_A", "p_AP"), ("body_B", "p_BQ")):
        (name,) = _named(path, element, (f"{element.tag}_{body}",), poses)
        place, where = element.find(f"{element.tag}_{point}"), f"{label(element)}/<{element.tag}_{point}>"
        if place is None:
            raise InputError(path, where, "is missing; give x y z")
        found.append((name, poses[name].rotation @ numbers(path, place, 3, where) + poses[name].translation))
    return found


def _normal(path: Path, raw: RawModel, element: ET.Element) -> Array:
    """Return the axis of the first revolute joint, which is the plane's normal."""
    for joint in raw.joints:
        if joint.type == "revolute":
            return joint.axis
    raise InputError(path, label(element), "is in a mechanism without revolute joints, so its plane is unknown")
