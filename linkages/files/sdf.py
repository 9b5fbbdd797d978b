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
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TypeVar
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from linkages.errors import InputError, nearest, unreadable
from linkages.files.numbers import implausible

Array = NDArray[np.float64]

#: Joint types of the standard that a planar linkage can have.
JOINT_TYPES = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}
_POSE_KEYS = ("x", "y", "z", "roll", "pitch", "yaw")
_ENCODINGS = ("utf-8", "utf-16", "us-ascii", "iso-8859-1")  # that every XML reader knows, or their common part
_DEEPEST = 100  # levels of elements, and poses relative to one another: reading recurses


@dataclass(frozen=True)
class Pose:
    """A rigid transform: rotation matrix (3, 3) and translation (3,) [m]."""

    rotation: Array = field(default_factory=lambda: np.eye(3))
    translation: Array = field(default_factory=lambda: np.zeros(3))

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.rotation @ other.rotation, self.rotation @ other.translation + self.translation)


@dataclass(frozen=True)
class Bearing:
    """A journal bearing; the joint's parent carries the bearing, its child the journal. Lengths in m."""

    radius: float
    length: float


@dataclass(frozen=True)
class Slot:
    """A block in a slot; the joint's parent carries the slot, its child the block. Size of the block in m."""

    length: float
    height: float


Part = TypeVar("Part", Bearing, Slot)


@dataclass(frozen=True)
class RawLink:
    """A rigid body as written.

    Attributes
    ----------
    mass : float
        [kg]
    rotation, translation : (3, 3), (3,) arrays
        Drawn pose of the link frame in the world [m].
    com_local, inertia_local : (3,), (3, 3) arrays
        Mass centre [m] and inertia tensor about it [kg m2], in link axes.
    visuals : tuple of str
        ``<visual>`` elements, as written.
    """

    name: str
    mass: float
    rotation: Array
    translation: Array
    com_local: Array
    inertia_local: Array
    visuals: tuple[str, ...]


@dataclass(frozen=True)
class RawJoint:
    """A joint as written.

    Attributes
    ----------
    type : str
        "revolute", "prismatic" or "fixed".
    parent, child : str
        Link names, or "world".
    axis, position, position_on_parent : (3,) arrays
        Drawn axis, and position on the child and on the parent, in the world [m].
    bearing : Bearing or None
    slot : Slot or None
        What a revolute, or a prismatic, joint is made of if it may have play.
    """

    name: str
    type: str
    parent: str
    child: str
    axis: Array
    position: Array
    position_on_parent: Array
    bearing: Bearing | None
    slot: Slot | None


@dataclass(frozen=True)
class RawModel:
    """Everything the file says, resolved into world coordinates of the drawn configuration.

    `frames` has the link that carries each named frame, and its pose; `values` the numbers as written, by the
    dotted paths that `read_sdf` replaces.
    """

    name: str
    links: tuple[RawLink, ...]
    joints: tuple[RawJoint, ...]
    frames: dict[str, tuple[str, Pose]]
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
        if self.model.findtext("static", "false").strip() in ("true", "1"):
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
        links = tuple(self._link(name, element) for name, element in self._tagged("link").items())
        if not links:
            raise self.error(_label(self.model), "has no <link>; a mechanism needs at least one")
        joints = tuple(self._joint(name, element) for name, element in self._tagged("joint").items())
        frames = {name: (self._carrier(name), self._pose(name)) for name in self._tagged("frame")}
        values = {path: place.value for path, place in self.places.items()}
        return RawModel(self.model.get("name", ""), links, joints, frames, values)

    def place(self, path: str) -> _Place:
        """Find the number at a dotted path."""
        if path in self.places:
            return self.places[path]
        where = f"sdf.{path}"
        kind, _, rest = path.partition(".")
        if kind not in ("links", "joints", "frames"):
            raise self.error(where, f'"{kind}" is unknown; paths start with links., joints. or frames.')
        name, _, key = rest.partition(".")
        tag = kind.removesuffix("s")
        names = self._tagged(tag)
        if name not in names:
            raise self.error(where, f'there is no {tag} "{name}"; {nearest(name, names)}')
        start = f"{kind}.{name}."
        known = [other.removeprefix(start) for other in self.places if other.startswith(start)]
        raise self.error(where, f'"{key}" is unknown; {nearest(key, known)}')

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

    def _tagged(self, tag: str) -> dict[str, ET.Element]:
        return {name: element for name, element in self.elements.items() if element.tag == tag}

    def _find(self, name: str, asked_by: str) -> ET.Element:
        if name not in self.elements:
            known = nearest(name, [*self.elements, "world"])
            raise self.error(asked_by, f'names "{name}", which does not exist; {known}')
        return self.elements[name]

    def _pose(self, name: str, asked_by: str = "") -> Pose:
        """World pose of a link, joint or frame, of the model, or of the world."""
        if name == "world":
            return Pose()
        if name == "__model__":
            return self._own_pose(self.model, _label(self.model))
        if name in self.resolved:
            return self.resolved[name]
        element = self._find(name, asked_by)
        where = _label(element)
        if name in self.resolving:
            chain = " -> ".join([*self.resolving[self.resolving.index(name) :], name])
            raise self.error(where, f"its pose is relative to itself ({chain}); break the circle")
        if len(self.resolving) == _DEEPEST:
            raise self.error(where, f"its pose is the last of more than {_DEEPEST} relative to one another")
        self.resolving.append(name)
        pose = element.find("pose")
        base = pose.get("relative_to", "") if pose is not None else ""
        result = self._pose(base or _attached_to(element), where) @ self._own_pose(element, where)
        self.resolving.pop()
        self.resolved[name] = result
        return result

    def _own_pose(self, element: ET.Element, where: str) -> Pose:
        pose = element.find("pose")
        if pose is None or not (pose.text or "").strip():
            return Pose()
        quaternion = _is_quaternion(pose)
        values = self._numbers(pose, 7 if quaternion else 6, f"{where}/<pose>")
        if quaternion:
            if abs(np.linalg.norm(values[3:]) - 1.0) > 1e-6:
                raise self.error(f"{where}/<pose>", "its quaternion is not of length one")
            rotation = Rotation.from_quat(values[3:])
        else:
            rotation = Rotation.from_euler("xyz", values[3:], degrees=_is_in_degrees(pose))
        return Pose(rotation.as_matrix(), values[:3])

    def _carrier(self, name: str, asked_by: str = "", passed: tuple[str, ...] = ()) -> str:
        """Name of the link that a link, frame or joint name stands for."""
        if name == "world":
            return name
        if name == "__model__":
            return next(iter(self._tagged("link")))
        found = self._find(name, asked_by)
        if found.tag == "link":
            return name
        if name in passed:
            raise self.error(_label(found), "is attached to itself; break the circle")
        if len(passed) == _DEEPEST:
            raise self.error(_label(found), f"is the last of more than {_DEEPEST} attached to one another")
        return self._carrier(_attached_to(found), _label(found), (*passed, name))

    # -- elements ----------------------------------------------------------------------------------

    def _link(self, name: str, element: ET.Element) -> RawLink:
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
            moments = ", ".join(f"{moment:g}" for moment in principal)
            rule = "none may be negative and none larger than the sum of the others"
            raise self.error(spot, f"no body has the principal moments {moments} kg m2; {rule}")
        rotated = centre.rotation @ matrix @ centre.rotation.T
        visuals = tuple(ET.tostring(v, encoding="unicode") for v in element.findall("visual"))
        pose = self._pose(name)
        return RawLink(name, mass, pose.rotation, pose.translation, centre.translation, rotated, visuals)

    def _joint(self, name: str, element: ET.Element) -> RawJoint:
        where = _label(element)
        kind = element.get("type", "")
        if kind not in JOINT_TYPES:
            known = "a planar linkage has revolute, prismatic and fixed joints"
            raise self.error(where, f'type "{kind}" is not supported; {known}')
        ends = {end: element.findtext(end, "").strip() for end in ("parent", "child")}
        for end, link in ends.items():
            if not link:
                raise self.error(where, f"has no <{end}>; name a link or a frame")
        parent, child = (self._carrier(link, where) for link in ends.values())
        if parent == child:
            raise self.error(where, f'joins "{parent}" to itself; parent and child must differ')
        pose = self._pose(name)
        # A parent given as a *frame* says where the joint sits on the parent; the standard's own
        # reading (the joint's drawn position) is the same thing whenever the drawing closes.
        on_parent = self._pose(ends["parent"]) if ends["parent"] in self._tagged("frame") else pose
        axis = np.zeros(3) if JOINT_TYPES[kind] == "fixed" else self._axis(element, where, pose)
        bearing, slot = self._annotation(element, Bearing), self._annotation(element, Slot)
        places = pose.translation, on_parent.translation
        return RawJoint(name, JOINT_TYPES[kind], parent, child, axis, *places, bearing, slot)

    def _axis(self, element: ET.Element, where: str, pose: Pose) -> Array:
        axis = element.find("axis")
        xyz = axis.find("xyz") if axis is not None else None
        if axis is None or xyz is None:
            raise self.error(where, "has no <axis><xyz>; give the direction of motion")
        direction = self._numbers(xyz, 3, f"{where}/<axis>/<xyz>")
        length = float(np.linalg.norm(direction))
        if length < 1e-9:
            raise self.error(f"{where}/<axis>/<xyz>", "has no length; give a direction")
        dynamics, spot = axis.find("dynamics"), f"{where}/<axis>/<dynamics>"
        for key in ("damping", "friction", "spring_stiffness"):
            if dynamics is not None and self._number(dynamics, key, spot, 0.0) != 0.0:
                raise self.error(f"{spot}/<{key}>", "is not supported; remove it or set it to 0")
        base = xyz.get("expressed_in", "")
        rotation = self._pose(base, where).rotation if base else pose.rotation
        return rotation @ (direction / length)

    def _annotation(self, element: ET.Element, kind: type[Part]) -> Part | None:
        """Read <linkages:bearing> or <linkages:slot>: its two lengths."""
        tag, keys = kind.__name__.lower(), [key.name for key in fields(kind)]
        found = next((child for child in element if child.tag.endswith("}" + tag)), None)
        if found is None:
            return None
        where = f"{_label(element)}/<linkages:{tag}>"
        values = {child.tag.split("}")[-1]: child for child in found}
        for key, child in values.items():
            if key not in keys:
                raise self.error(where, f"<{key}> is unknown; {nearest(key, keys)}")
            if not child.tag.startswith("{"):
                raise self.error(where, f"write <linkages:{key}>, not <{key}>")
        lengths = []
        for key in keys:
            if key not in values:
                raise self.error(where, f"has no <linkages:{key}>; give it in metres")
            value = float(self._numbers(values[key], 1, f"{where}/<linkages:{key}>")[0])
            if value <= 0.0:
                raise self.error(f"{where}/<linkages:{key}>", f"is {value:g} m; it must be positive")
            lengths.append(value)
        return kind(*lengths)

    # -- numbers -----------------------------------------------------------------------------------

    def _numbers(self, element: ET.Element, count: int, where: str) -> Array:
        words = (element.text or "").split()
        try:
            values = np.array([float(word) for word in words])
        except ValueError:
            raise self.error(where, f'"{" ".join(words)}" is not {_count(count)}') from None
        if len(values) != count:
            raise self.error(where, f"has {_count(len(values))}; {count} are needed")
        for problem in filter(None, map(implausible, values.tolist())):
            raise self.error(where, problem)
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
    """Where a number stands in the file: alone in an element, or as one of a <pose>, which may be empty."""

    element: ET.Element
    index: int | None = None

    @property
    def value(self) -> float:
        """The number, angles in radians; NaN where the text is none."""
        try:
            number = float(self._words()[self.index or 0])
        except (ValueError, IndexError):
            return math.nan
        return math.radians(number) if self._in_degrees() else number

    def put(self, value: float) -> None:
        """Replace the number."""
        words, index = [""] if self.index is None else self._words(), self.index or 0
        if index < len(words):  # else the <pose> has too few numbers, which is said when it is read
            words[index] = str(math.degrees(value) if self._in_degrees() else value)
            self.element.text = " ".join(words)

    def _words(self) -> list[str]:
        return (self.element.text or "").split() or ["0"] * 6

    def _in_degrees(self) -> bool:
        return self.index is not None and self.index >= 3 and _is_in_degrees(self.element)


def _places(element: ET.Element) -> Iterator[tuple[str, _Place]]:
    """Find every number that a dotted path can name; where a <pose> was left out, an empty one is added."""
    holders = (element, "pose", _POSE_KEYS), (element.find("inertial"), "com", _POSE_KEYS[:3])
    for holder, prefix, keys in holders:
        if holder is None:
            continue
        pose = holder.find("pose")
        if pose is None:
            pose = ET.SubElement(holder, "pose")
        for index, key in enumerate(keys[:3] if _is_quaternion(pose) else keys):
            yield f"{prefix}.{key}", _Place(pose, index)
    mass = element.find("inertial/mass")
    if mass is not None:
        yield "mass", _Place(mass)
    for annotation in element:
        _, prefixed, kind = annotation.tag.rpartition("}")
        if prefixed and kind in ("bearing", "slot"):
            for number in annotation:
                yield f"{kind}.{number.tag.rpartition('}')[2]}", _Place(number)


def _is_quaternion(pose: ET.Element) -> bool:
    return pose.get("rotation_format", "euler_rpy") == "quat_xyzw"


def _is_in_degrees(pose: ET.Element) -> bool:
    return pose.get("degrees", "false") in ("true", "1")


def _attached_to(element: ET.Element) -> str:
    """Name of what a link, frame or joint is attached to, and what its pose is relative to by default."""
    if element.tag == "joint":
        return element.findtext("child", "").strip()
    return (element.tag == "frame" and element.get("attached_to")) or "__model__"


def _find_model(path: Path) -> ET.Element:
    try:
        text = path.read_bytes()
    except OSError as problem:
        raise unreadable(path, problem) from None
    except ValueError as problem:  # a name with a null character
        raise InputError(path, "", f"cannot be read ({problem})") from None
    depth = 0

    def refuse(*_: object) -> None:
        problem = "document types and entities are refused; remove the declaration"
        raise InputError(path, "<!DOCTYPE>", problem)

    def declared(_: str, encoding: str | None, __: int) -> None:
        if encoding is not None and encoding.lower() not in _ENCODINGS:
            raise InputError(path, "<?xml?>", f'encoding "{encoding}" is not supported; save the file as UTF-8')

    def start(name: str, _: object) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise InputError(path, f"<{name}>", f"is nested more than {_DEEPEST} levels deep")

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser = expat.ParserCreate(namespace_separator=" ")
    parser.XmlDeclHandler, parser.StartDoctypeDeclHandler = declared, refuse
    parser.StartElementHandler, parser.EndElementHandler = start, end
    try:
        parser.Parse(text, True)
        root = ET.fromstring(text)
    except (expat.ExpatError, ET.ParseError) as problem:
        unbound = "unbound prefix" in str(problem)
        hint = '; declare xmlns:linkages="urn:linkages:sdf" on <sdf>' if unbound else ""
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
