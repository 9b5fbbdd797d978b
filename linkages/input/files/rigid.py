"""Rigid bodies: move links, merge links that are fixed to each other, mass and inertia that a file leaves out."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.input.files.elements import INERTIA, number, numbers, own_pose, tensor_of, with_pose
from linkages.input.files.raw_model import Pose, RawJoint, RawLink, RawModel
from linkages.input.files.xml import label, parse_xml

_ROUNDED = 1e-3  # excess of the largest principal moment, relative, that rounded digits explain
_WATER = 1000.0  # density that SDFormat takes if none is given [kg/m3]


def without_massless(path: Path, model: RawModel) -> RawModel:
    """Convert massless links that are fixed to another link, or to the world, to frames.

    Links that two or more joints hold stay, such as a block in a slot; InputError for other ones, which could move
    alone.
    """
    while massless := [link for link in model.links if link.mass == 0.0 and not _is_held(model, link.name)]:
        for link in massless:
            joint = next((j for j in model.joints if j.type == "fixed" and link.name in (j.parent, j.child)), None)
            if joint is None:
                fix = "give its mass and inertia, or fix it to the world or a link that has them"
                raise InputError(path, f'<link name="{link.name}">', f"has no <inertial>, or one without mass; {fix}")
            model = fixed_into(path, model, joint, link.name)
            break
    return model


def _is_held(model: RawModel, link: str) -> bool:
    """Tell whether no fixed joint, and two others or more hold a link."""
    kinds = [joint.type for joint in model.joints if link in (joint.parent, joint.child)]
    return len(kinds) > 1 and "fixed" not in kinds


def fixed_into(path: Path, model: RawModel, joint: RawJoint, name: str) -> RawModel:
    """Merge the two links of a fixed joint; the link of this name becomes a frame of the other.

    Joints and frames of the merged link belong to the other link, at the same places. InputError if another joint
    connects the two links.
    """
    stays = joint.parent if joint.child == name else joint.child
    gone = next(link for link in model.links if link.name == name)
    links = tuple(_together(link, gone) if link.name == stays else link for link in model.links if link is not gone)
    joints = []
    for other in model.joints:
        parent, child = (stays if end == name else end for end in (other.parent, other.child))
        moved = replace(other, parent=parent, child=child)
        if moved.parent != moved.child:
            joints.append(moved)
        elif moved.type != "fixed":
            problem = f'joins "{other.parent}" and "{other.child}", which are fixed to each other'
            raise InputError(path, f'<joint name="{other.name}">', problem)
    frames = {key: (stays if link == name else link, pose) for key, (link, pose) in model.frames.items()}
    return replace(model, links=links, joints=tuple(joints), frames={**frames, name: (stays, gone.pose)})


def moved(model: RawModel, moves: Mapping[str, Pose]) -> RawModel:
    """Move links with their joints and frames by displacements from their reference poses, in world axes.

    Other links stay. A joint's axis moves with its parent.
    """

    def move(link: str, place: Array) -> Array:
        pose = moves.get(link, still)
        return pose.rotation @ place + pose.translation

    still = Pose()
    links = []
    for link in model.links:
        at, beam = moves.get(link.name, still) @ link.pose, link.beam
        if beam is not None:
            beam = replace(beam, start=move(link.name, beam.start), end=move(link.name, beam.end))
        links.append(replace(link, rotation=at.rotation, translation=at.translation, beam=beam))
    joints = [
        replace(
            joint,
            position=move(joint.child, joint.position),
            position_on_parent=move(joint.parent, joint.position_on_parent),
            axis=moves.get(joint.parent, still).rotation @ joint.axis,
        )
        for joint in model.joints
    ]
    frames = {name: (link, moves.get(link, still) @ at) for name, (link, at) in model.frames.items()}
    return replace(model, links=tuple(links), joints=tuple(joints), frames=frames)


def combined(bodies: Sequence[tuple[float, Array, Array]]) -> tuple[float, Array, Array]:
    """Return mass, mass centre and inertia tensor about it of bodies given by theirs, in the same axes."""
    mass = sum(body[0] for body in bodies)
    centre = np.sum([part * place for part, place, _ in bodies], axis=0) / mass if mass else bodies[0][1]
    tensor = np.sum([own for _, _, own in bodies], axis=0)
    for part, place, _ in bodies:
        off = place - centre
        tensor += part * (off @ off * np.eye(3) - np.outer(off, off))
    return mass, centre, tensor


def _together(link: RawLink, other: RawLink) -> RawLink:
    """Return a link with the mass, inertia and shapes of another, in the first link's axes."""
    pose = link.pose.inverse() @ other.pose
    turned = pose.rotation @ other.inertia_local @ pose.rotation.T
    added = other.mass, pose.rotation @ other.com_local + pose.translation, turned
    mass, com, inertia = combined([(link.mass, link.com_local, link.inertia_local), added])
    visuals = (*link.visuals, *(_visual_moved(visual, pose, other.name) for visual in other.visuals))
    return replace(link, mass=mass, com_local=com, inertia_local=inertia, visuals=visuals)


def _visual_moved(visual: str, pose: Pose, owner: str) -> str:
    element = parse_xml(Path(owner), visual.encode())
    element.set("name", f"{owner}_{element.get('name', '')}")
    return with_pose(element, pose @ own_pose(Path(owner), element, visual))


# -- inertia that an SDFormat file leaves to its reader ----------------------------------------------------------------


def complete_inertials(path: Path, model: ET.Element) -> list[str]:
    """Add the values that SDFormat defines for links without all of <inertial>, in a model without nested models.

    Returns the links with default values: 1 kg, and 1 kg m2 about each axis.
    """
    completed = []
    for link in model.findall("link"):
        inertial = link.find("inertial")
        if inertial is not None and inertial.get("auto") == "true":
            compute_inertial(path, link, inertial)
        elif link.find("linkages:beam") is None:
            inertial = ET.SubElement(link, "inertial") if inertial is None else inertial
            missing = [tag for tag in ("mass", "inertia") if inertial.find(tag) is None]
            if "mass" in missing:
                ET.SubElement(inertial, "mass").text = "1"
            if "inertia" in missing:
                tensor = ET.SubElement(inertial, "inertia")
                for key in ("ixx", "iyy", "izz"):
                    ET.SubElement(tensor, key).text = "1"
            completed += [link.get("name", "")] if missing else []
    return completed


def correct_rounded(path: Path, model: ET.Element) -> list[str]:
    """Raise the two smaller principal moments of inertia where rounded digits make them impossible, in place.

    The moments of a thin plate obey I_3 = I_1 + I_2, and rounding can make I_3 larger. A motion in the plate's plane
    stays the same. Returns the corrected links.
    """
    corrected = []
    for link in model.findall("link"):
        for element in link.findall("inertial/inertia"):
            moments, axes = np.linalg.eigh(tensor_of(path, element, f"{label(link)}/<inertial>/<inertia>"))
            excess = moments[2] - moments[0] - moments[1]
            if moments[0] >= 0.0 and 1e-9 * moments[2] < excess <= _ROUNDED * moments[2]:
                moments[:2] += 0.5 * excess
                write_tensor(element, axes @ np.diag(moments) @ axes.T)
                corrected.append(link.get("name", ""))
    return corrected


def write_tensor(element: ET.Element, tensor: Array) -> None:
    """Replace the content of an <inertia> by a tensor (3, 3)."""
    element.clear()
    for key, place in INERTIA.items():
        ET.SubElement(element, key).text = repr(float(tensor[place]))


def compute_inertial(path: Path, link: ET.Element, inertial: ET.Element) -> None:
    """Replace an automatic <inertial>: the link's collision shapes of given density, scaled to a given mass."""
    where = f"{label(link)}/<inertial>"
    usual = number(path, inertial, "density", where, _WATER)
    total = number(path, inertial, "mass", where, 0.0)
    bodies = [_body(path, link, collision, usual) for collision in link.findall("collision")]
    if not sum(body[0] for body in bodies) > 0.0:
        raise InputError(path, where, "is automatic, but the link has no <collision> with a volume; write its values")
    mass, centre, tensor = combined(bodies)
    scale = total / mass if total else 1.0
    inertial.clear()
    ET.SubElement(inertial, "pose").text = Pose(np.eye(3), centre).text()
    ET.SubElement(inertial, "mass").text = repr(float(mass * scale))
    write_tensor(ET.SubElement(inertial, "inertia"), tensor * scale)


def _body(path: Path, link: ET.Element, collision: ET.Element, usual: float) -> tuple[float, Array, Array]:
    """Return mass, centre and inertia tensor about it of a collision shape, in link axes."""
    where = f"{label(link)}/{label(collision)}"
    density = number(path, collision, "density", where, usual)
    pose = own_pose(path, collision, where)
    if collision.find("pose[@relative_to]") is not None:
        raise InputError(path, where, "is placed relative to another element; write its <pose> in the link's axes")
    shape = next(iter(collision.iterfind("geometry/*")), ET.Element("geometry"))
    spot = f"{where}/<{shape.tag}>"

    def size(key: str) -> float:
        value = number(path, shape, key, spot)
        if not value > 0.0:
            raise InputError(path, f"{spot}/<{key}>", f"is {value:g} m; it must be positive")
        return value

    def three(key: str) -> Array:
        element = shape.find(key)
        if element is None or (values := numbers(path, element, 3, f"{spot}/<{key}>")).min() <= 0.0:
            raise InputError(path, f"{spot}/<{key}>", "must be three positive lengths")
        return values

    squares: Array  # mean squares of x, y, z over the volume [m2]
    match shape.tag:
        case "box":
            sides = three("size")
            volume, squares = float(np.prod(sides)), sides**2 / 12.0
        case "ellipsoid":
            radii = three("radii")
            volume, squares = 4.0 / 3.0 * math.pi * float(np.prod(radii)), radii**2 / 5.0
        case "sphere":
            r = size("radius")
            volume, squares = 4.0 / 3.0 * math.pi * r**3, np.full(3, r**2 / 5.0)
        case "cylinder" | "capsule":
            r, h = size("radius"), size("length")
            volume = math.pi * r**2 * h
            squares = np.array([r**2 / 4.0, r**2 / 4.0, h**2 / 12.0])
            if shape.tag == "capsule":  # two half spheres have their centres 3 r / 8 beyond the cylinder's ends
                ball = 4.0 / 3.0 * math.pi * r**3
                along = r**2 / 5.0 - (3.0 * r / 8.0) ** 2 + (h / 2.0 + 3.0 * r / 8.0) ** 2
                ends = np.array([r**2 / 5.0, r**2 / 5.0, along])
                squares = (volume * squares + ball * ends) / (volume + ball)
                volume += ball
        case _:
            known = "boxes, cylinders, spheres, capsules and ellipsoids have automatic inertia; write mass and inertia"
            raise InputError(path, spot, known)
    mass = number(path, collision, "mass", where, density * volume)  # MJCF gives masses of shapes
    own = mass * np.diag(squares.sum() - squares)
    return mass, pose.translation, pose.rotation @ own @ pose.rotation.T
