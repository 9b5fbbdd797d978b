"""Shapes of MJCF: the inertia of a body, given or computed of its geoms, and its visuals."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.input.files.mjcf_defaults import Defaults, Mjcf, turned_to
from linkages.input.files.raw_model import Pose
from linkages.input.files.rigid import compute_inertial, write_tensor
from linkages.input.files.xml import label

_DENSITY = "1000"  # MuJoCo's usual one [kg/m3]
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}


def add_shapes(file: Mjcf, body: ET.Element, link: ET.Element, usual: Defaults) -> None:
    """Add <inertial> and <visual> elements of a body to a link."""
    geoms = []
    for element in body.findall("geom"):
        geom = usual.of(element)
        if geom.get("type") is None:
            geom.set("type", "mesh" if geom.get("mesh") else "sphere")
        geoms.append(geom)
    given = body.find("inertial")
    if given is not None and file.from_shapes != "true":
        _given(file, given, link)
    else:
        _computed(file, geoms, body, link)
    for k, geom in enumerate(geoms):
        if geom.get("type") in _SIZES:
            visual = ET.SubElement(link, "visual", name=f"{geom.get('name') or 'visual'}{k}")
            _shape(file, geom, visual)


def _given(file: Mjcf, given: ET.Element, link: ET.Element) -> None:
    """Write mass, mass centre and inertia about it in the body's axes."""
    inertial = ET.SubElement(link, "inertial")
    _text(inertial, "pose", Pose(np.eye(3), file.numbers(given, "pos", 3, "0 0 0")).text())
    _text(inertial, "mass", repr(float(file.numbers(given, "mass", 1)[0])))
    if given.get("fullinertia") is not None:
        xx, yy, zz, xy, xz, yz = file.numbers(given, "fullinertia", 6)
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        turned = file.rotation(given)
        tensor = turned @ np.diag(file.numbers(given, "diaginertia", 3)) @ turned.T
    write_tensor(ET.SubElement(inertial, "inertia"), tensor)


def _computed(file: Mjcf, geoms: list[ET.Element], body: ET.Element, link: ET.Element) -> None:
    """Compute the inertia of all shapes with mass; without one, the link is massless."""
    inertial, parts = ET.SubElement(link, "inertial"), 0
    for geom in geoms:
        if not any(file.numbers(geom, "mass" if geom.get("mass") else "density", 1, _DENSITY)):
            continue
        kind = geom.get("type", "")
        if kind in ("plane", "hfield"):
            continue
        if kind not in _SIZES:
            problem = f"is a {kind}, whose inertia is not computed; write <inertial>, or mass 0"
            raise InputError(file.path, f"{label(body)}/{label(geom)}", problem)
        if geom.get("shellinertia") == "true":
            raise InputError(file.path, f"{label(body)}/{label(geom)}", "is a shell; write <inertial>")
        collision = ET.SubElement(link, "collision", name=f"part{parts}")
        _shape(file, geom, collision)
        key = "mass" if geom.get("mass") else "density"
        _text(collision, key, repr(float(file.numbers(geom, key, 1, _DENSITY)[0])))
        parts += 1
    if parts:
        compute_inertial(file.path, link, inertial)
    else:
        _text(inertial, "mass", "0")
        write_tensor(ET.SubElement(inertial, "inertia"), np.zeros((3, 3)))
    for collision in link.findall("collision"):
        link.remove(collision)


def _shape(file: Mjcf, geom: ET.Element, owner: ET.Element) -> None:
    """Write pose and geometry of a geom, whose sizes are half those of SDFormat."""
    kind = geom.get("type", "")
    ends = geom.get("fromto")
    needed = 1 if ends is not None else _SIZES[kind]
    size = file.numbers(geom, "size")
    if len(size) < needed:
        raise InputError(file.path, f"{label(geom)} size", f"has {len(size)} numbers; a {kind} needs {needed}")
    if ends is not None:
        first, last = file.numbers(geom, "fromto", 6).reshape(2, 3)
        pose, half = Pose(turned_to(last - first), 0.5 * (first + last)), 0.5 * float(np.linalg.norm(last - first))
        size = np.array([size[0], half] if kind in ("capsule", "cylinder") else [size[0], size[0], half])
    else:
        pose = file.pose(geom)
    _text(owner, "pose", pose.text())
    shape = ET.SubElement(ET.SubElement(owner, "geometry"), kind)
    _sizes(shape, kind, size)


def _sizes(shape: ET.Element, kind: str, size: Array) -> None:
    if kind == "box":
        _text(shape, "size", " ".join(repr(float(2.0 * x)) for x in size[:3]))
    elif kind == "ellipsoid":
        _text(shape, "radii", " ".join(repr(float(x)) for x in size[:3]))
    else:
        _text(shape, "radius", repr(float(size[0])))
        if kind != "sphere":
            _text(shape, "length", repr(float(2.0 * size[1])))


def _text(owner: ET.Element, tag: str, text: str) -> None:
    ET.SubElement(owner, tag).text = text
