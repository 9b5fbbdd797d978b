"""Conversion of URDF to SDFormat: the same links, joints and poses, as elements instead of attributes.

Elements without an SDFormat equivalent are passed on unchanged, so that the reader of the model can report them.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

from linkages.errors import InputError
from linkages.files.xml import label


def sdf_of(path: Path, robot: ET.Element) -> ET.Element:
    """Return the ``<model>`` of a ``<robot>``.

    Each link is placed by the joint that carries it. Drake's ``<loop_joint>`` and joints of SDFormat in ``<gazebo>``
    blocks close loops.

    Raises
    ------
    InputError
        If it is xacro, or two joints carry the same link.
    """
    for element in robot.iter():
        if element.tag.startswith("xacro:") or any("${" in value for value in element.attrib.values()):
            problem = f"is xacro, which URDF is made from; run `xacro {path.name} > NAME.urdf`, and import that"
            raise InputError(path, label(element), problem)
    model = ET.Element("model", name=robot.get("name", ""))
    colors = {found.get("name"): found for found in robot.iter("material") if found.find("color") is not None}
    carried: dict[str, str] = {}
    for joint in robot.findall("joint"):
        child = _named(joint, "child")
        if child in carried:
            problem = (
                f'is carried by two joints, "{carried[child]}" and "{joint.get("name")}"; close loops with <loop_joint>'
            )
            raise InputError(path, f'<link name="{child}">', problem)
        carried[child] = joint.get("name", "")
    for element in robot:
        if element.tag == "link" and element.get("name") != "world":
            model.append(_link(element, carried.get(element.get("name", ""), ""), colors))
        elif element.tag == "joint":
            model.append(_joint(element))
        elif element.tag == "loop_joint":
            model.extend(_loop_joint(element))
        elif element.tag == "gazebo" and not element.get("reference"):
            model.extend(copy.deepcopy(part) for part in element)
        elif element.tag not in ("material", "link"):
            model.append(_told(element))
    return model


def _told(element: ET.Element) -> ET.Element:
    """Copy an element of Drake; a text of SDFormat is an attribute "name" or "value" of URDF."""
    copied = copy.deepcopy(element)
    for part in copied if element.tag.startswith("drake:") else ():
        part.text = part.get("name") or part.get("value") or part.text
    return copied


def _link(element: ET.Element, carrier: str, colors: dict[str | None, ET.Element]) -> ET.Element:
    link = ET.Element("link", name=element.get("name", ""))
    if carrier:
        ET.SubElement(link, "pose", relative_to=carrier)
    for part in element:
        if part.tag == "inertial":
            _inertial(link, part)
        elif part.tag == "visual":
            _visual(link, part, colors)
        else:
            link.append(copy.deepcopy(part))
    return link


def _inertial(link: ET.Element, element: ET.Element) -> None:
    inertial = ET.SubElement(link, "inertial")
    _origin(inertial, element)
    for part in element:
        if part.tag == "mass":
            _add(inertial, "mass", part.get("value", ""))
        elif part.tag == "inertia":
            inertial.append(_of_attributes(part))


def _visual(link: ET.Element, element: ET.Element, colors: dict[str | None, ET.Element]) -> None:
    visual = ET.SubElement(link, "visual", name=element.get("name") or f"visual{len(link)}")
    _origin(visual, element)
    for shape in element.iterfind("geometry/*"):
        ET.SubElement(visual, "geometry").append(_of_attributes(shape))
    material = element.find("material")
    color = colors.get(material.get("name"), material).find("color") if material is not None else None
    if color is not None:
        _add(ET.SubElement(visual, "material"), "diffuse", color.get("rgba", ""))


def _joint(element: ET.Element) -> ET.Element:
    joint = ET.Element("joint", name=element.get("name", ""), type=element.get("type", ""))
    parent = _named(element, "parent")
    _origin(joint, element).set("relative_to", parent)
    _add(joint, "parent", parent)
    _add(joint, "child", _named(element, "child"))
    joint.append(_axis(element))
    joint.extend(copy.deepcopy(part) for part in element if part.tag not in ("origin", "parent", "child", *_OF_AXIS))
    return joint


def _loop_joint(element: ET.Element) -> Iterator[ET.Element]:
    """Yield frames on both links, and the joint between them with the first frame's axis."""
    name = element.get("name", "")
    joint = ET.Element("joint", name=name, type=element.get("type", ""))
    for tag, side in (("parent", "link1"), ("child", "link2")):
        _add(joint, tag, f"{name}_{side}")
        end = element.find(side)
        link = end.get("link", "") if end is not None else ""
        frame = ET.Element("frame", name=f"{name}_{side}", attached_to=link)
        if end is not None:
            _pose(frame, end)
        yield frame
    axis = _axis(element)
    axis[0].set("expressed_in", f"{name}_link1")
    joint.append(axis)
    yield joint


_OF_AXIS = ("axis", "limit", "dynamics", "mimic")


def _axis(element: ET.Element) -> ET.Element:
    """Make the <axis> of a joint; URDF has limits and dynamics outside the axis, SDFormat inside."""
    axis = ET.Element("axis")
    own = element.find("axis")
    _add(axis, "xyz", own.get("xyz", "1 0 0") if own is not None else "1 0 0")
    parts = [part for part in element if part.tag in _OF_AXIS[1:]]
    axis.extend(copy.deepcopy(part) if part.tag == "mimic" else _of_attributes(part) for part in parts)
    return axis


def _of_attributes(element: ET.Element) -> ET.Element:
    """Convert attributes to elements."""
    result = ET.Element(element.tag)
    for key, value in element.attrib.items():
        _add(result, key, value)
    return result


def _origin(owner: ET.Element, element: ET.Element) -> ET.Element:
    return _pose(owner, origin if (origin := element.find("origin")) is not None else ET.Element("origin"))


def _pose(owner: ET.Element, origin: ET.Element) -> ET.Element:
    return _add(owner, "pose", f"{origin.get('xyz', '0 0 0')} {origin.get('rpy', '0 0 0')}")


def _named(joint: ET.Element, end: str) -> str:
    found = joint.find(end)
    return found.get("link", "") if found is not None else ""


def _add(owner: ET.Element, tag: str, text: str) -> ET.Element:
    element = ET.SubElement(owner, tag)
    element.text = text
    return element
