"""Import of mechanisms of other programs, with a line for every change and omission."""

from __future__ import annotations

import copy
import os
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from linkages.errors import InputError
from linkages.files.constraints import joined
from linkages.files.foreign import Entry, take_foreign
from linkages.files.models import find_model, flattened
from linkages.files.raw_model import Chains, RawJoint, RawModel
from linkages.files.rigid import fixed_into, without_massless
from linkages.files.sdf import read_model
from linkages.files.urdf import sdf_of
from linkages.files.xml import DEEPEST, label, read_xml

_CARRIED = {
    "model": ("link", "joint", "frame", "pose", "static"),
    "link": ("pose", "inertial", "visual", "linkages:beam"),
    "joint": ("pose", "parent", "child", "axis", "linkages:bearing", "linkages:slot"),
    "axis": ("xyz", "use_parent_model_frame"),
    "frame": ("pose",),
}
_WHY = {
    "collision": "links touch each other in clearance joints only",
    "limit": "only stops of the experiment limit a joint",
}
_SHAPES = ("box", "cylinder", "sphere", "capsule", "ellipsoid")
_SAME_PLACE = 1e-6  # relative to the size of the mechanism: closer places coincide


class Imported(NamedTuple):
    """An imported mechanism of another program.

    Attributes
    ----------
    model : RawModel
    limits : dict of str to (float, float)
        Lowest and highest coordinate of a joint, zero in the reference configuration [rad or m].
    notes : list of str
        One line for every change and omission.
    entries : list of Entry
        Entries of the experiment.
    """

    model: RawModel
    limits: dict[str, tuple[float, float]]
    notes: list[str]
    entries: list[Entry]


def import_model(path: Path) -> Imported:
    """Read an SDFormat or URDF file that was written for another program.

    Use `linkages.load_mechanism` for files of this package. Elements that change the motion become joints or entries of
    an experiment, or are rejected. Nested models and included local files become one model. Links that are fixed to
    each other become one link, one link of each floating group is fixed to the world, and revolute joints on one axis
    between the same two links become one joint.

    Raises
    ------
    InputError
        If the file cannot be imported: file, element and reason.
    """
    model = _model(path, ())
    limits = {joint.get("name", ""): ends for joint in model.findall("joint") if (ends := _limits(path, joint))}
    foreign = take_foreign(path, model)
    notes = _leave_out(model)
    raw = joined(foreign, read_model(path, model))
    notes += foreign.notes
    for change in (_on_the_ground, _rigid, _coaxial):
        raw = change(path, raw, notes)
    raw = without_massless(path, raw)
    if not raw.links:
        raise InputError(path, label(model), "has no moving link: every link is fixed to the world")
    names = {joint.name for joint in raw.joints}
    for entry in foreign.entries:
        for name in entry.joints:
            if name not in names:
                problem = f'joint "{name}" was merged with another, or removed; name a joint that is kept'
                raise InputError(path, entry.element, problem)
    return Imported(raw, {name: ends for name, ends in limits.items() if name in names}, notes, foreign.entries)


def _model(path: Path, passed: tuple[Path, ...]) -> ET.Element:
    """Read the single <model> of a file, with its included models."""
    here = path.resolve()
    if here in passed or len(passed) > DEEPEST:
        raise InputError(passed[-1], f"<include> {path.name}", "includes itself; break the circle")

    def follow(include: ET.Element) -> ET.Element:
        model = copy.deepcopy(_model(_included(path, include), (*passed, here)))
        if include.get("merge") in ("true", "1"):
            raise InputError(path, "<include>", "is merged, which is not supported; remove merge")
        model.set("name", include.findtext("name", model.get("name", "")).strip())
        for key in ("pose", "placement_frame", "static"):
            if (own := include.find(key)) is not None:
                for old in model.findall(key):
                    model.remove(old)
                model.append(own)
        return model

    root = read_xml(path)
    if root.tag == "robot":
        return sdf_of(path, root)
    world = root.find("world")
    root.extend(world.findall("model") if world is not None else ())
    model = find_model(path, root)
    for element in world if world is not None else ():
        if element is not model:
            element.tag = f"world/{element.tag}"  # left out, with a note
            model.append(element)
    return flattened(path, model, follow)


def _included(path: Path, include: ET.Element) -> Path:
    """Find the file of an <include>: in the folder of the including file, or in its parent folder."""
    uri = include.findtext("uri", "").strip()
    scheme, _, name = uri.rpartition("://")
    if scheme not in ("", "file", "model", "package") or not name:
        raise InputError(path, f"<include> {uri}", "is not a local file; download it, and write its path")
    for folder in (path.parent, path.parent.parent):
        file = folder / name
        if os.path.isdir(file):  # unlike Path.is_dir, returns False for invalid names
            file = file / "model.sdf"
        if os.path.isfile(file):
            return file
    raise InputError(path, f"<include> {uri}", f"is neither in {path.parent} nor in its parent folder")


def _limits(path: Path, joint: ET.Element) -> tuple[float, float] | None:
    """Read the limits of a joint; None if there are none."""
    limit = joint.find("axis/limit")
    if limit is None or joint.get("type") == "continuous" or not {"lower", "upper"} & {part.tag for part in limit}:
        return None
    words = limit.findtext("lower", "-inf"), limit.findtext("upper", "inf")
    try:
        low, high = map(float, words)
    except ValueError:
        low, high = np.nan, np.nan
    if not low <= high:
        problem = f"from {' to '.join(words)} is not a range; write two numbers, or remove it"
        raise InputError(path, f"{label(joint)}/<axis>/<limit>", problem)
    return low, high


def _leave_out(model: ET.Element) -> list[str]:
    """Remove elements that cannot be converted; return one line per kind."""
    owners: dict[tuple[str, str], list[str]] = {}
    notes = []
    for owner in [model, *model]:
        for holder in (owner, *owner.findall("axis")):
            for element in list(holder):
                if element.tag in _CARRIED.get(holder.tag, (element.tag,)) and not _is_mesh(element):
                    continue
                tag = "mesh" if _is_mesh(element) else element.tag
                name = element.get("name", element.get("reference")) if owner is model else owner.get("name")
                owners.setdefault((owner.tag, tag), []).append(name or "")
                holder.remove(element)
    for (owner_tag, tag), names in owners.items():
        listed = ", ".join(dict.fromkeys(filter(None, names)))
        of = "" if owner_tag == "model" else f"of {owner_tag}{'s' * (len(names) > 1)} "
        why = f": {_WHY[tag]}" if tag in _WHY else ""
        notes.append(" ".join(f"<{tag}> {of}{listed} left out{why}".split()))
    return notes


def _is_mesh(element: ET.Element) -> bool:
    return element.tag == "visual" and not any(element.find(f"geometry/{shape}") is not None for shape in _SHAPES)


def _on_the_ground(path: Path, model: RawModel, notes: list[str]) -> RawModel:
    """Weld one link of each floating group to the world."""
    chains = Chains(link.name for link in model.links)
    for joint in model.joints:
        chains.join(joint.parent, joint.child)
    children = {joint.child for joint in model.joints}
    joints = list(model.joints)
    for link in sorted(model.links, key=lambda link: link.name in children):
        if link.name in chains.of["world"]:
            continue
        nowhere = np.zeros(3)
        ground = RawJoint(f"{link.name} to world", "fixed", "world", link.name, nowhere, nowhere, nowhere, None, None)
        chains.join("world", link.name)
        joints.append(ground)
        notes.append(f"link {link.name} was not connected to the world: fixed to it in the file's pose")
    return replace(model, joints=tuple(joints))


def _rigid(path: Path, model: RawModel, notes: list[str]) -> RawModel:
    """Merge links that are fixed to each other into the parent; the name of the other becomes a frame.

    A link with a beam is kept: links fixed to it move with one of its sections.
    """
    beams = {link.name for link in model.links if link.beam is not None}
    while joint := next((j for j in model.joints if j.type == "fixed" and beams.isdisjoint((j.parent, j.child))), None):
        gone, stays = (joint.parent, joint.child) if joint.child == "world" else (joint.child, joint.parent)
        notes.append(f"link {gone} is fixed to {stays}: merged into it, as a frame of that name")
        model = fixed_into(path, model, joint, gone)
    return model


def _coaxial(path: Path, model: RawModel, notes: list[str]) -> RawModel:
    """Merge revolute joints on one axis between the same two links, which are one joint in the plane."""
    places = np.array([joint.position for joint in model.joints])
    near = _SAME_PLACE * float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0
    kept: list[RawJoint] = []
    for joint in model.joints:
        twin = next((other for other in kept if _same(joint, other, near)), None)
        if twin is None:
            kept.append(joint)
        else:
            notes.append(
                f"joint {joint.name} has the axis of {twin.name} between the same links: merged into {twin.name}"
            )
    return replace(model, joints=tuple(kept))


def _same(joint: RawJoint, other: RawJoint, near: float) -> bool:
    if {joint.type, other.type} != {"revolute"} or {joint.parent, joint.child} != {other.parent, other.child}:
        return False
    ends = (joint.position, joint.position_on_parent)
    if joint.parent != other.parent:
        ends = ends[::-1]
    return all(
        np.linalg.norm(np.cross(place - there, other.axis)) <= near
        for place, there in zip(ends, (other.position, other.position_on_parent), strict=True)
    )
