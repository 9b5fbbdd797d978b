"""Conversion of URDF to SDFormat: the same links, joints and poses, as elements instead of attributes.

Elements without an SDFormat equivalent are passed on unchanged, so that the reader of the model can report them.
"""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

from linkages.base.errors import InputError
from linkages.input.files.foreign import add_mimic, deep, joint_of
from linkages.input.files.magnitudes import decimal_or_nan
from linkages.input.files.xml import label


def sdf_of(path: Path, robot: ET.Element) -> ET.Element:
    """Return the ``<model>`` of a ``<robot>``.

    Each link is placed by the joint that carries it. ``<loop_joint>`` (Drake, Isaac), ``<loop>`` (URDF+), joints of
    SDFormat in ``<gazebo>`` blocks, and links ``closing_NAME_1`` and ``closing_NAME_2`` (onshape-to-robot) close loops.
    Elements of a ``<gazebo reference>`` block become elements of their
    link or joint; ``<coupling>`` (URDF+) and joints that mimic others in ``<ros2_control>`` become ``<mimic>``.
    """
    model = ET.Element("model", name=robot.get("name", ""), notation="URDF")
    colors = {found.get("name"): found for found in robot.iter("material") if found.find("color") is not None}
    carried: dict[str, ET.Element] = {}
    for joint in robot.findall("joint"):
        for origin in joint.iterfind("origin"):
            _check_origin(path, joint, origin)
        child = _named(joint, "child")
        if child == "world":
            raise InputError(path, label(joint), "has the child world; make world the parent")
        if child in carried:
            both = f'"{carried[child].get("name")}" and "{joint.get("name")}"'
            problem = f"is carried by two joints, {both}; close loops with <loop_joint>"
            raise InputError(path, f'<link name="{child}">', problem)
        carried[child] = joint
    for element in robot:
        _check_flat(path, element)
        if element.tag == "link" and element.get("name") != "world":
            for origin in element.iter("origin"):
                _check_origin(path, element, origin)
            carrier = carried.get(element.get("name", ""))
            model.append(_link(element, carrier.get("name", "") if carrier is not None else "", colors))
        elif element.tag == "joint":
            model.append(_joint(element))
        elif element.tag in _LOOPS:
            model.extend(list(_loop(path, element)))
        elif element.tag == "gazebo" and not element.get("reference"):
            model.extend(copy.deepcopy(part) for part in element)
        elif element.tag not in ("material", "link", "gazebo", "coupling"):
            model.append(told := copy.deepcopy(element))
            for part in told if element.tag.startswith("drake:") else ():  # a text of SDFormat is an attribute of URDF
                part.text = part.get("name") or part.get("value") or part.text
    links = {link.get("name", "") for link in robot.findall("link")}
    for first in sorted(links):
        name = first.removesuffix("_1")  # as onshape-to-robot closes loops
        if first.startswith("closing_") and f"{name}_2" in links - {first}:
            model.append(_ball(name, (first, "0 0 0"), (f"{name}_2", "0 0 0")))
    for element in robot:
        if element.tag == "gazebo" and element.get("reference"):
            _of_gazebo(model, element)
        elif element.tag == "coupling":
            add_mimic(path, model, label(element), _coupled(path, carried, element))
        for joint in element.findall("joint") if element.tag == "ros2_control" else ():
            name, given = joint.get("name", ""), {part.get("name"): part.text or "" for part in joint.findall("param")}
            if "mimic" in given:
                values = name, given["mimic"], given.get("multiplier", "1"), given.get("offset", "0")
                add_mimic(path, model, label(joint), values)
            start = joint.find("state_interface[@name='position']/param[@name='initial_value']")
            if start is not None:
                deep(joint_of(path, model, label(joint), name), "axis/initial_position").text = start.text
    return model


def _check_flat(path: Path, owner: ET.Element) -> None:
    """Reject elements inside elements of which URDF reads attributes only."""
    for element in owner.iter() if owner.tag in ("link", "joint") else ():
        if element.tag in _FLAT and len(element):
            inner = element[0].tag
            problem = f"contains <{inner}>, which URDF does not read; write the attribute {inner}"
            raise InputError(path, f"{label(owner)}/<{element.tag}>", problem)


def _check_origin(path: Path, owner: ET.Element, origin: ET.Element) -> None:
    """Reject an <origin> without three numbers in each attribute."""
    where = f"{label(owner)}/<{origin.tag}>"
    if origin.get("quat_xyzw") is not None:
        raise InputError(path, where, "has quat_xyzw; write the angles as rpy")
    for key in ("xyz", "rpy"):
        text = origin.get(key, "0 0 0")
        values = [decimal_or_nan(word) for word in text.split()]
        if len(values) != 3 or any(map(math.isnan, values)):
            raise InputError(path, where, f'its {key} is "{text}"; give three numbers')


_FLAT = ("origin", "mass", "inertia", "axis", "limit", "dynamics", "mimic")
#: Elements of ``<gazebo reference>``: their places in a link or joint of SDFormat.
_OF_GAZEBO = {
    "turnGravityOff": "gravity",
    "dampingFactor": "velocity_decay/linear",
    "springStiffness": "axis/dynamics/spring_stiffness",
    "springReference": "axis/dynamics/spring_reference",
    "initialJointPosition": "axis/initial_position",
}


def _of_gazebo(model: ET.Element, element: ET.Element) -> None:
    """Move the elements of a <gazebo reference> into the link or joint that it names."""
    name = element.get("reference")
    owner = next((part for part in model if part.tag in ("link", "joint") and part.get("name") == name), None)
    if owner is None:
        model.append(copy.deepcopy(element))
        return
    for part in element:
        text = (part.text or part.get("value") or "").strip()
        if part.tag == "turnGravityOff":
            text = "false" if text.lower() in ("true", "1") else "true"
        if part.tag in _OF_GAZEBO:
            deep(owner, _OF_GAZEBO[part.tag]).text = text
        else:
            owner.append(copy.deepcopy(part))


def _coupled(path: Path, carried: dict[str, ET.Element], element: ET.Element) -> tuple[str, str, str, str]:
    """Return follower, leader, ratio and offset of a <coupling>; paths lead from the common ancestor of its links."""
    chains = []
    for end in ("predecessor", "successor"):
        link, chain = _named(element, end), dict[str, str]()
        while link in carried and link not in chain:
            joint = carried[link]
            if joint.get("type") != "fixed":
                chain[link] = joint.get("name", "")
            link = _named(joint, "parent")
        chains.append(chain)
    pairs = chains, chains[::-1]
    one, two = ([joint for link, joint in chain.items() if link not in other] for chain, other in pairs)
    if len(one) != 1 or len(two) != 1:
        problem = f"couples {len(one)} joints to {len(two)}; one joint on each side is supported"
        raise InputError(path, label(element), problem)
    ratio = element.find("ratio")
    return two[0], one[0], ratio.get("value", "1") if ratio is not None else "1", "0"


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
    if link.find("inertial") is None:  # SDFormat would take 1 kg
        inertial = ET.SubElement(link, "inertial")
        _add(inertial, "mass", "0")
        inertial.append(_of_attributes(ET.Element("inertia", dict.fromkeys(("ixx", "iyy", "izz"), "0"))))
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


#: Elements that close loops, and the elements of their two links.
_LOOPS = {"loop_joint": ("link1", "link2"), "loop": ("predecessor", "successor")}


def _loop(path: Path, element: ET.Element) -> Iterator[ET.Element]:
    """Yield frames on both links, and the joint between them with the first frame's axis.

    A ball joint becomes Drake's ball constraint, which is a revolute joint in the plane.
    """
    name, kind, sides = element.get("name", ""), element.get("type", ""), _LOOPS[element.tag]
    ends = [end if (end := element.find(side)) is not None else ET.Element(side) for side in sides]
    places = [origin if (origin := end.find("origin")) is not None else end for end in ends]
    for place in places:
        _check_origin(path, element, place)
    links = [end.get("link", end.get("name", "")) for end in ends]
    if kind in ("ball", "spherical"):
        yield _ball(name, *((link, place.get("xyz", "0 0 0")) for link, place in zip(links, places, strict=True)))
        return
    joint = ET.Element("joint", name=name, type=kind)
    for tag, side, link, place in zip(("parent", "child"), sides, links, places, strict=True):
        _add(joint, tag, f"{name}_{side}")
        frame = ET.Element("frame", name=f"{name}_{side}", attached_to=link)
        _pose(frame, place)
        yield frame
    axis = _axis(element)
    axis[0].set("expressed_in", f"{name}_{sides[0]}")
    joint.append(axis)
    yield joint


def _ball(name: str, *ends: tuple[str, str]) -> ET.Element:
    """Make a ball constraint between two points: link, and place in its frame."""
    ball = ET.Element("drake:ball_constraint", name=name)
    for body, point, (link, place) in zip(("body_A", "body_B"), ("p_AP", "p_BQ"), ends, strict=True):
        _add(ball, f"drake:ball_constraint_{body}", link)
        _add(ball, f"drake:ball_constraint_{point}", place)
    return ball


_OF_AXIS = ("axis", "limit", "dynamics", "mimic", "joint_properties")  # the last is an old name of <dynamics>


def _axis(element: ET.Element) -> ET.Element:
    """Make the <axis> of a joint; URDF has limits and dynamics outside the axis, SDFormat inside."""
    axis = ET.Element("axis")
    own = element.find("axis")
    _add(axis, "xyz", own.get("xyz", "1 0 0") if own is not None else "1 0 0")
    for part in (part for part in element if part.tag in _OF_AXIS[1:]):
        axis.append(copy.deepcopy(part) if part.tag == "mimic" else _of_attributes(part))
        if part.tag == "joint_properties":
            axis[-1].tag = "dynamics"
    return axis


def _of_attributes(element: ET.Element) -> ET.Element:
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
