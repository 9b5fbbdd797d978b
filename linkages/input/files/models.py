"""The single model of an SDFormat file, without nested models, in the form of SDFormat 1.7 and newer."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

from linkages.base.errors import InputError
from linkages.input.files.xml import label

#: Type of a function that returns the model of an ``<include>``.
Follow = Callable[[ET.Element], ET.Element]

_NAMING = ("relative_to", "attached_to", "expressed_in", "canonical_link")
#: Elements whose text is a name.
_NAMES = (
    *("parent", "child", "parent_link", "linkages:from", "linkages:to", "drake:parent", "drake:child"),
    *(f"drake:{kind}_body_{end}" for kind in ("ball_constraint", "linear_spring_damper") for end in "AB"),
)
MIMICS = ("mimic", "drake:mimic")


def find_model(path: Path, root: ET.Element) -> ET.Element:
    """Find the only ``<model>`` of a file; InputError if there is another count."""
    update(path, root)
    models = root.findall("model")
    if len(models) != 1:
        world = "; `linkages import` takes the model of a world" if root.find("world") is not None else ""
        raise InputError(path, "<sdf>", f"has {len(models)} <model> elements; exactly one is needed{world}")
    return models[0]


def update(path: Path, root: ET.Element) -> None:
    """Convert notations of older versions in place: ``frame`` of poses, axes in the frame of the model."""
    if root.tag == "robot":
        raise InputError(path, "<robot>", f"is URDF; `linkages import {path.name}` converts it to SDFormat")
    if root.tag != "sdf":
        raise InputError(path, f"<{root.tag}>", "is not SDFormat; the root must be <sdf>")
    version = [int(word) if word.isdecimal() else 99 for word in root.get("version", "1.7").split(".")]
    if version >= [1, 7]:
        if root.find(".//pose[@frame]") is not None:
            raise InputError(
                path, "<pose frame>", "belongs to SDFormat before 1.7; write relative_to, or the old version"
            )
        return
    for pose in root.iter("pose"):
        if pose.get("frame"):
            pose.set("relative_to", pose.attrib.pop("frame"))
    for axis in root.iter("axis"):
        told = axis.findtext("use_parent_model_frame", "true" if version < [1, 5] else "false")
        for xyz in axis.findall("xyz") if told == "true" else ():
            xyz.set("expressed_in", "__model__")


def is_static(model: ET.Element) -> bool:
    """Check whether a model is fixed to the world as a whole."""
    return model.findtext("static") == "true"


def flattened(path: Path, model: ET.Element, follow: Follow | None = None) -> ET.Element:
    """Return a copy of a ``<model>`` without nested models; an element of a nested model ``m`` becomes ``m::NAME``.

    `follow` returns the model of an ``<include>``; without it an ``<include>`` is rejected.
    """
    flat = ET.Element("model", model.attrib)
    nested = []
    for element in model:
        if element.tag == "include" and follow is None:
            problem = "included files are not supported here; `linkages import` merges them into one file"
            raise InputError(path, "<include>", problem)
        if element.tag in ("model", "include"):
            nested.append(follow(element) if follow and element.tag == "include" else element)
        else:
            flat.append(copy.deepcopy(element))
    for element in nested:
        flat.extend(_scoped(path, element, flattened(path, element, follow)))
    return flat


def _scoped(path: Path, model: ET.Element, flat: ET.Element) -> list[ET.Element]:
    """Rename the elements of a nested model, and place them relative to a frame with the model's name."""
    name = model.get("name", "")
    if not name:
        raise InputError(path, "<model>", 'has no name; write name="..."')
    if model.get("placement_frame") or model.findtext("placement_frame"):
        raise InputError(path, label(model), "placement frames are not supported; give the pose of the model itself")
    if is_static(model):
        raise InputError(path, label(model), "is static; remove it, or fix its links to the world")

    def scoped(other: str) -> str:
        return other if other == "world" else name if other == "__model__" else f"{name}::{other}"

    links = [element.get("name", "") for element in flat.findall("link")]
    own = ET.Element("frame", name=name)
    own.set("attached_to", scoped(flat.get("canonical_link") or links[0]) if links else "__model__")
    pose = copy.deepcopy(model.find("pose"))
    own.append(ET.Element("pose") if pose is None else pose)
    own[0].set("relative_to", own[0].get("relative_to", "__model__"))
    parts = [element for element in flat if element.tag in ("link", "joint", "frame")]
    for part in flat.iter():
        for key in (*_NAMING, "joint") if part.tag in MIMICS else _NAMING:
            if part.get(key) and part is not flat:
                part.set(key, scoped(part.get(key, "")))
        if part.tag in _NAMES:
            part.text = scoped((part.text or "").strip())
    for element in parts:
        element.set("name", scoped(element.get("name", "")))
        if element.tag == "frame" and not element.get("attached_to"):
            element.set("attached_to", name)
        if element.tag == "link":
            pose = element.find("pose")
            if pose is None:
                pose = ET.SubElement(element, "pose")
            pose.set("relative_to", pose.get("relative_to") or name)
    return [own, *parts, *(part for part in flat if part.tag not in ("link", "joint", "frame", "pose", "static"))]
