"""Reads the part of SDFormat 1.7+ that describes a mechanism: links, joints, frames and their poses.

Poses follow the standard: ``relative_to`` names any link, joint or frame of the model (nested to any
depth); by default a link's pose is relative to the model, a frame's to what it is attached to and a
joint's to its child. What cannot be honoured is refused, never ignored silently, except elements that
only a picture or a contact sensor needs.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from linkages.errors import InputError, nearest, unreadable

Array = NDArray[np.float64]

#: Joint types of the standard that a planar linkage can have.
JOINT_TYPES = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}
_POSE_KEYS = ("x", "y", "z", "roll", "pitch", "yaw")
#: What this package adds to a joint, and the two lengths of each.
_ANNOTATIONS = {"bearing": ("radius", "length"), "slot": ("length", "height")}


@dataclass(frozen=True)
class Pose:
    """A rigid transform: rotation matrix (3, 3) and translation (3,) [m]."""

    rotation: Array = field(default_factory=lambda: np.eye(3))
    translation: Array = field(default_factory=lambda: np.zeros(3))

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.rotation @ other.rotation, self.rotation @ other.translation + self.translation)


@dataclass(frozen=True)
class RawLink:
    """A link as written: inertia (3, 3) about the mass centre in link axes, visuals as XML text."""

    pose: Pose
    mass: float
    com: Array
    inertia: Array
    visuals: tuple[str, ...]


@dataclass(frozen=True)
class RawJoint:
    """A joint as written: where it sits on each body, its axis [world], its bearing (R, L) or slot (l, h)."""

    type: str
    parent: str
    child: str
    on_parent: Array
    on_child: Array
    axis: Array
    bearing: tuple[float, float] | None
    slot: tuple[float, float] | None


@dataclass(frozen=True)
class RawFrame:
    """A named frame and the link that carries it."""

    link: str
    pose: Pose


@dataclass(frozen=True)
class RawModel:
    """Everything the file says, resolved into world coordinates of the drawn configuration.

    `values` are its numbers by the dotted paths that `read_sdf` replaces, as written.
    """

    name: str
    links: dict[str, RawLink]
    joints: dict[str, RawJoint]
    frames: dict[str, RawFrame]
    values: dict[str, float]


def read_sdf(path: Path, overrides: Mapping[str, float] | None = None) -> RawModel:
    """Read one SDFormat file.

    Parameters
    ----------
    path : Path
        The file.
    overrides : mapping of str to float, optional
        Values that replace those of the file, by dotted path: ``links.NAME.mass`` [kg],
        ``links.NAME.com.x|y|z`` [m], ``links|joints|frames.NAME.pose.x|y|z|roll|pitch|yaw`` [m, rad],
        ``joints.NAME.bearing.radius|length`` and ``joints.NAME.slot.length|height`` [m].

    Raises
    ------
    InputError
        With file, element and reason.
    """
    return _Reader(path, overrides or {}).read()


class _Reader:
    def __init__(self, path: Path, overrides: Mapping[str, float]) -> None:
        self.path = path
        self.model = _find_model(path)
        self.elements: dict[str, ET.Element] = {}
        for element in self.model:
            if element.tag in ("link", "joint", "frame"):
                self._declare(element)
            elif element.tag in ("include", "model"):
                raise self.error(_label(element), "nested models are not supported; write the links out")
        static = self.model.findtext("static", "false").strip()
        if static in ("true", "1"):
            raise self.error("<static>", "a static model cannot move; remove it or set it to false")
        self.places = {
            f"{element.tag}s.{name}.{key}": place
            for name, element in self.elements.items()
            for key, place in _places(element)
        }
        for key, value in overrides.items():
            self.place(key).put(value)
        self.resolved: dict[str, Pose] = {}
        self.resolving: list[str] = []

    def error(self, where: str, problem: str) -> InputError:
        return InputError(self.path, where, problem)

    def read(self) -> RawModel:
        links = {n: self._link(e) for n, e in self.elements.items() if e.tag == "link"}
        if not links:
            raise self.error(_label(self.model), "has no <link>; a mechanism needs at least one")
        joints = {n: self._joint(e) for n, e in self.elements.items() if e.tag == "joint"}
        frames = {
            n: RawFrame(self._carrier(n, e), self._pose(n))
            for n, e in self.elements.items()
            if e.tag == "frame"
        }
        values = {path: place.value for path, place in self.places.items()}
        return RawModel(self.model.get("name", ""), links, joints, frames, values)

    def place(self, path: str) -> _Place:
        """Find the number at a dotted path."""
        if path in self.places:
            return self.places[path]
        kind, _, rest = path.partition(".")
        kinds = ("links", "joints", "frames")
        if kind not in kinds:
            raise self.error(
                f"sdf.{path}", f'"{kind}" is unknown; paths start with links., joints. or frames.'
            )
        name, _, key = rest.partition(".")
        names = [n for n, e in self.elements.items() if e.tag == kind.removesuffix("s")]
        if name not in names:
            raise self.error(
                f"sdf.{path}", f'there is no {kind.removesuffix("s")} "{name}"; {nearest(name, names)}'
            )
        start = f"{kind}.{name}."
        known = [other.removeprefix(start) for other in self.places if other.startswith(start)]
        raise self.error(f"sdf.{path}", f'"{key}" is unknown; {nearest(key, known)}')

    # -- names and poses ---------------------------------------------------------------------------

    def _declare(self, element: ET.Element) -> None:
        name = element.get("name", "")
        if not name:
            raise self.error(f"<{element.tag}>", 'has no name; write name="..."')
        if name == "world" or (name.startswith("__") and name.endswith("__")):
            raise self.error(_label(element), "is a reserved name; choose another")
        if name in self.elements:
            other = self.elements[name].tag
            raise self.error(_label(element), f"is defined twice (also as a <{other}>); names must be unique")
        self.elements[name] = element

    def _pose(self, name: str, asked_by: str = "") -> Pose:
        """World pose of a link, joint or frame, of the model, or of the world."""
        if name == "world":
            return Pose()
        if name == "__model__":
            return self._own_pose(self.model, _label(self.model))
        if name in self.resolved:
            return self.resolved[name]
        if name not in self.elements:
            raise self.error(asked_by, f'names "{name}", which does not exist; {self._suggest(name)}')
        element = self.elements[name]
        where = _label(element)
        if name in self.resolving:
            chain = " -> ".join([*self.resolving[self.resolving.index(name) :], name])
            raise self.error(where, f"its pose is relative to itself ({chain}); break the circle")
        self.resolving.append(name)
        pose = element.find("pose")
        base = pose.get("relative_to", "") if pose is not None else ""
        if not base:
            default = {
                "link": "__model__",
                "frame": element.get("attached_to") or "__model__",
                "joint": element.findtext("child", "").strip(),
            }
            base = default[element.tag]
        result = self._pose(base, where) @ self._own_pose(element, where)
        self.resolving.pop()
        self.resolved[name] = result
        return result

    def _own_pose(self, element: ET.Element, where: str) -> Pose:
        pose = element.find("pose")
        if pose is None or not (pose.text or "").strip():
            return Pose()
        quaternion = pose.get("rotation_format", "euler_rpy") == "quat_xyzw"
        values = self._numbers(pose, 7 if quaternion else 6, f"{where}/<pose>")
        if quaternion:
            if abs(np.linalg.norm(values[3:]) - 1.0) > 1e-6:
                raise self.error(f"{where}/<pose>", "its quaternion is not of length one")
            rotation = Rotation.from_quat(values[3:])
        else:
            degrees = pose.get("degrees", "false") in ("true", "1")
            rotation = Rotation.from_euler("xyz", values[3:], degrees=degrees)
        return Pose(rotation.as_matrix(), values[:3])

    def _carrier(self, name: str, element: ET.Element) -> str:
        """Name of the link that a link, frame or joint name stands for."""
        seen: list[str] = []
        asked_by = _label(element)
        while True:
            if name == "world":
                return name
            if name == "__model__":
                return next(n for n, e in self.elements.items() if e.tag == "link")
            if name not in self.elements:
                raise self.error(asked_by, f'names "{name}", which does not exist; {self._suggest(name)}')
            found = self.elements[name]
            if found.tag == "link":
                return name
            if name in seen:
                raise self.error(_label(found), "is attached to itself; break the circle")
            seen.append(name)
            asked_by = _label(found)
            if found.tag == "frame":
                name = found.get("attached_to") or "__model__"
            else:
                name = found.findtext("child", "").strip()

    def _suggest(self, name: str) -> str:
        return nearest(name, [*self.elements, "world"])

    # -- elements ----------------------------------------------------------------------------------

    def _link(self, element: ET.Element) -> RawLink:
        where = _label(element)
        inertial = element.find("inertial")
        if inertial is None:
            raise self.error(where, "has no <inertial>; give its mass and inertia")
        mass = self._number(inertial, "mass", f"{where}/<inertial>")
        if mass <= 0.0:
            raise self.error(f"{where}/<inertial>/<mass>", f"is {mass:g} kg; it must be positive")
        centre = self._own_pose(inertial, f"{where}/<inertial>")
        tensor = inertial.find("inertia")
        if tensor is None:
            raise self.error(f"{where}/<inertial>", "has no <inertia>; give ixx, iyy, izz")
        spot = f"{where}/<inertial>/<inertia>"
        xx, yy, zz = (self._number(tensor, key, spot) for key in ("ixx", "iyy", "izz"))
        xy, xz, yz = (self._number(tensor, key, spot, 0.0) for key in ("ixy", "ixz", "iyz"))
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        principal = np.linalg.eigvalsh(matrix)
        slack = 1e-9 * max(abs(principal[-1]), 1e-300)
        if principal[0] < -slack or principal[-1] > principal[0] + principal[1] + slack:
            raise self.error(
                spot,
                f"no body has the principal moments {principal[0]:g}, {principal[1]:g}, {principal[2]:g} kg m2;"
                " none may be negative and none larger than the sum of the others",
            )
        rotated = centre.rotation @ matrix @ centre.rotation.T
        visuals = tuple(ET.tostring(v, encoding="unicode") for v in element.findall("visual"))
        name = element.attrib["name"]
        return RawLink(self._pose(name), mass, centre.translation, rotated, visuals)

    def _joint(self, element: ET.Element) -> RawJoint:
        where = _label(element)
        kind = element.get("type", "")
        if kind not in JOINT_TYPES:
            raise self.error(
                where,
                f'type "{kind}" is not supported; a planar linkage has revolute, prismatic and fixed joints',
            )
        ends = {}
        for end in ("parent", "child"):
            ends[end] = element.findtext(end, "").strip()
            if not ends[end]:
                raise self.error(where, f"has no <{end}>; name a link or a frame")
        bodies = {end: self._carrier(name, element) for end, name in ends.items()}
        if bodies["parent"] == bodies["child"]:
            raise self.error(where, f'joins "{bodies["parent"]}" to itself; parent and child must differ')
        pose = self._pose(element.attrib["name"])
        on_child = pose.translation
        # A parent given as a *frame* says where the joint sits on the parent; the standard's own
        # reading (the joint's drawn position) is the same thing whenever the drawing closes.
        named_frame = ends["parent"] in self.elements and self.elements[ends["parent"]].tag == "frame"
        on_parent = self._pose(ends["parent"]).translation if named_frame else on_child
        axis = np.zeros(3)
        if JOINT_TYPES[kind] != "fixed":
            axis = self._axis(element, where, pose)
        return RawJoint(
            JOINT_TYPES[kind],
            bodies["parent"],
            bodies["child"],
            on_parent,
            on_child,
            axis,
            self._annotation(element, "bearing"),
            self._annotation(element, "slot"),
        )

    def _axis(self, element: ET.Element, where: str, pose: Pose) -> Array:
        axis = element.find("axis")
        xyz = axis.find("xyz") if axis is not None else None
        if axis is None or xyz is None:
            raise self.error(where, "has no <axis><xyz>; give the direction of motion")
        direction = self._numbers(xyz, 3, f"{where}/<axis>/<xyz>")
        length = float(np.linalg.norm(direction))
        if length < 1e-9:
            raise self.error(f"{where}/<axis>/<xyz>", "has no length; give a direction")
        for key in ("damping", "friction", "spring_stiffness"):
            text = axis.findtext(f"dynamics/{key}", "0")
            if float(text) != 0.0:
                raise self.error(
                    f"{where}/<axis>/<dynamics>/<{key}>", "is not supported; remove it or set it to 0"
                )
        base = xyz.get("expressed_in", "")
        rotation = self._pose(base, where).rotation if base else pose.rotation
        return rotation @ (direction / length)

    def _annotation(self, element: ET.Element, tag: str) -> tuple[float, float] | None:
        """Read the two lengths of <linkages:bearing> or <linkages:slot>."""
        keys = _ANNOTATIONS[tag]
        found = [child for child in element if child.tag.startswith("{") and child.tag.endswith("}" + tag)]
        if not found:
            return None
        where = f"{_label(element)}/<linkages:{tag}>"
        values = {child.tag.split("}")[-1]: child for child in found[0]}
        for key, child in values.items():
            if key not in keys:
                raise self.error(where, f"<{key}> is unknown; {nearest(key, keys)}")
            if not child.tag.startswith("{"):
                raise self.error(where, f"write <linkages:{key}>, not <{key}>")
        numbers = []
        for key in keys:
            if key not in values:
                raise self.error(where, f"has no <linkages:{key}>; give it in metres")
            value = float(self._numbers(values[key], 1, f"{where}/<linkages:{key}>")[0])
            if value <= 0.0:
                raise self.error(f"{where}/<linkages:{key}>", f"is {value:g} m; it must be positive")
            numbers.append(value)
        return numbers[0], numbers[1]

    # -- numbers -----------------------------------------------------------------------------------

    def _numbers(self, element: ET.Element, count: int, where: str) -> Array:
        words = (element.text or "").split()
        try:
            values = np.array([float(word) for word in words])
        except ValueError:
            raise self.error(where, f'"{" ".join(words)}" is not {_count(count)}') from None
        if len(values) != count:
            raise self.error(where, f"has {_count(len(values))}; {count} are needed")
        if not np.all(np.isfinite(values)):
            raise self.error(where, "must be finite")
        return values

    def _number(self, parent: ET.Element, key: str, where: str, default: float | None = None) -> float:
        element = parent.find(key)
        if element is None:
            if default is None:
                raise self.error(where, f"has no <{key}>")
            return default
        return float(self._numbers(element, 1, f"{where}/<{key}>")[0])


@dataclass(frozen=True)
class _Place:
    """Where a number stands in the file: alone in an element, or as one of those of a <pose>, which may be left out."""

    holder: ET.Element
    index: int | None = None

    @property
    def value(self) -> float:
        """The number, angles in radians; NaN where the text is none."""
        pose = self.holder.find("pose")
        text = self.holder.text if self.index is None else pose.text if pose is not None else ""
        words = (text or "").split() or ["0"] * 6
        try:
            number = float(words[self.index or 0])
        except (ValueError, IndexError):
            return math.nan
        return math.radians(number) if pose is not None and self._in_degrees(pose) else number

    def put(self, value: float) -> None:
        """Replace the number."""
        if self.index is None:
            self.holder.text = repr(value)
            return
        pose = self.holder.find("pose")
        if pose is None:
            pose = ET.SubElement(self.holder, "pose")
        words = (pose.text or "").split() or ["0"] * 6
        words[self.index] = repr(math.degrees(value) if self._in_degrees(pose) else value)
        pose.text = " ".join(words)

    def _in_degrees(self, pose: ET.Element) -> bool:
        return self.index is not None and self.index >= 3 and pose.get("degrees", "false") in ("true", "1")


def _places(element: ET.Element) -> Iterator[tuple[str, _Place]]:
    """Find every number of a link, joint or frame that a dotted path can name."""
    inertial = element.find("inertial")
    for holder, prefix, keys in ((element, "pose", _POSE_KEYS), (inertial, "com", _POSE_KEYS[:3])):
        if holder is None:
            continue
        pose = holder.find("pose")
        quaternion = pose is not None and pose.get("rotation_format", "euler_rpy") == "quat_xyzw"
        for index, key in enumerate(keys[:3] if quaternion else keys):
            yield f"{prefix}.{key}", _Place(holder, index)
    mass = element.find("inertial/mass")
    if mass is not None:
        yield "mass", _Place(mass)
    for annotation in element:
        kind = annotation.tag.rpartition("}")[2]
        if annotation.tag.startswith("{") and kind in _ANNOTATIONS:
            for number in annotation:
                yield f"{kind}.{number.tag.rpartition('}')[2]}", _Place(number)


def _find_model(path: Path) -> ET.Element:
    try:
        text = path.read_bytes()
    except OSError as problem:
        raise unreadable(path, problem) from None

    def refuse(*_: object) -> None:
        raise InputError(
            path, "<!DOCTYPE>", "document types and entities are refused; remove the declaration"
        )

    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text, True)
        root = ET.fromstring(text)
    except (expat.ExpatError, ET.ParseError) as problem:
        hint = ""
        if "unbound prefix" in str(problem):
            hint = '; declare xmlns:linkages="urn:linkages:sdf" on <sdf>'
        raise InputError(path, "", f"is not well-formed XML: {problem}{hint}") from None
    if root.tag != "sdf":
        raise InputError(path, f"<{root.tag}>", "is not SDFormat; the root must be <sdf>")
    models = root.findall("model")
    if len(models) != 1:
        raise InputError(path, "<sdf>", f"has {len(models)} <model> elements; exactly one is needed")
    return models[0]


def _label(element: ET.Element) -> str:
    name = element.get("name")
    return f'<{element.tag} name="{name}">' if name else f"<{element.tag}>"


def _count(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"
