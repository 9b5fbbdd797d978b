"""Places of imported joints: their own poses, or the frames that the file names as their parents."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from linkages.input.files.foreign import MARK
from linkages.input.files.raw_model import RawJoint, RawModel

_SAME_PLACE = 1e-6  # relative to the size of the mechanism: closer places coincide
_BOTH_FRAMES = "drake:parent_frame", "drake:child_frame"


def take_joint_frames(model: ET.Element) -> set[str]:
    """Convert Drake's joints that name a frame on each link, which replace the joint's pose; return their names."""
    found = set()
    for joint in model.findall("joint"):
        frames = [joint.find(tag) for tag in _BOTH_FRAMES]
        for end, frame in zip(("parent", "child"), frames if None not in frames else (), strict=False):
            if frame is not None and (link := joint.find(end)) is not None:
                link.text = frame.text
                joint.remove(frame)
                found.add(joint.get("name", ""))
        if joint.get("name", "") in found:
            for pose in joint.findall("pose"):
                joint.remove(pose)
    return found


def placed(raw: RawModel, two_places: Collection[str], at_parent: bool, notes: list[str]) -> RawModel:
    """Place the joints of an SDFormat file on their parents; adds notes about joints that lie elsewhere.

    In SDFormat a <parent> that names a frame names the frame's link only: the joint is at its own pose on both links.
    The joints with `two_places`, or all `at_parent`, are at the frame instead.
    """
    apart = {joint.name: way for joint in raw.joints if (way := _way(raw, joint)) > _near(raw)}
    fixed = {joint.name for joint in raw.joints if joint.type == "fixed"}
    moved = {name for name in apart.keys() - fixed if at_parent or name in two_places}
    stay = {name: way for name, way in apart.items() if name not in moved and (name not in fixed or at_parent)}
    if stay:
        remedy = "" if at_parent else "; --joints-at-parent places them at these frames"
        said = f"lie {_far(stay)} from the joints' own poses, where SDFormat places them{remedy}"
        notes.append(f"{MARK}{_named(stay)}: the frames named as parents {said}")
    if moved:
        ways = {name: way for name, way in apart.items() if name in moved}
        notes.append(
            f"{_named(ways)}: placed at the frames named as parents, {_far(ways)} from their places on the children"
        )
    if at_parent and not moved:
        notes.append("--joints-at-parent changes nothing: no joint that moves names a frame elsewhere as its parent")
    return replace(
        raw,
        joints=tuple(
            joint if joint.name in moved else replace(joint, position_on_parent=joint.position) for joint in raw.joints
        ),
    )


def _way(raw: RawModel, joint: RawJoint) -> float:
    """Compute the distance between both places of a joint in the plane, whose normal a revolute joint tells [m]."""
    way = joint.position_on_parent - joint.position
    normal = next((one.axis for one in raw.joints if one.type == "revolute"), None)
    return float(np.linalg.norm(way if normal is None else np.cross(way, normal)))


def _near(raw: RawModel) -> float:
    places = np.array([place for joint in raw.joints for place in (joint.position, joint.position_on_parent)])
    return _SAME_PLACE * float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0


def _named(names: Collection[str]) -> str:
    return f"joint{'s' * (len(names) > 1)} {', '.join(names)}"


def _far(ways: dict[str, float]) -> str:
    return f"{'up to ' * (len(ways) > 1)}{max(ways.values()):.3g} m"
