"""Reads the part of SDFormat that describes a mechanism: links, joints, frames and their poses.

Poses follow the standard: ``relative_to`` names any link, joint or frame of the model (nested to any depth). By
default a link's pose is relative to the model, a frame's pose to the link or frame it is attached to, and a joint's
pose to its child. Unsupported elements are rejected, never ignored, except elements that only pictures or contact
sensors need.
"""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.input.files import elements
from linkages.input.files.beams import FOLLOWS, check_inertial, of_beam, written_beam
from linkages.input.files.models import find_model, flattened, is_static
from linkages.input.files.raw_model import UNROUNDED, BearingSize, LinkBeam, Pose, RawJoint, RawLink, RawModel, Slot
from linkages.input.files.reading import read_whole
from linkages.input.files.rigid import without_massless
from linkages.input.files.xml import DEEPEST, label, parse_xml

Part = TypeVar("Part", BearingSize, Slot)
Own = TypeVar("Own")

#: Joint types of the standard that a planar linkage can have.
JOINT_TYPES = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}

_BEARING = "bearing.radius", "bearing.length"
_SIZES = {"revolute": _BEARING, "continuous": _BEARING, "prismatic": ("slot.length", "slot.height")}  # of joint types

_BEAM = "beam.width", "beam.height", "beam.youngs_modulus", "beam.density"  # of a beam that is added

_HARMLESS = ("linkages", "collision_filter_group")  # ignored elements with a prefix, by prefix or name


def read_sdf(path: Path, overrides: Mapping[str, float] | None = None, text: bytes | None = None) -> RawModel:
    """Read one SDFormat file; `text` is its content if it has been read. InputError with file, element and reason.

    Overrides replace values of the file by dotted path: ``links.NAME.mass`` [kg], ``links.NAME.com.x|y|z`` [m],
    ``links|joints|frames.NAME.pose.x|y|z|roll|pitch|yaw`` [m, rad], ``joints.NAME.bearing.radius|length`` and
    ``joints.NAME.slot.length|height`` [m] (together they add a bearing or a slot to a joint without),
    ``links.NAME.beam.width|height|diameter|outer|inner`` [m] ``|area`` [m2] ``|second_moment`` [m4]
    ``|youngs_modulus`` [Pa] ``|density`` [kg/m3] ``|poisson`` (width, height, youngs_modulus and density together add a
    beam between the two frames of a link that joints name); for a mechanism written from a description,
    ``parameters.NAME``. The mass and the mass centre of a link with a beam follow from the beam.
    """
    reader = _flat_reader(path, read_whole(path) if text is None else text)
    values = dict(overrides or {})
    parameters: dict[str, float] = {}
    units: dict[str, str] = {}
    if (description := reader.model.findtext("linkages:description")) is not None:
        from linkages.input.files.description import redrawn  # needed by few files

        own = {key: values.pop(key) for key in list(values) if key.startswith("parameters.")}
        model, parameters, units = redrawn(path, reader.model, description, own)
        reader = _Reader(path, model, reader.grid) if own else reader
    raw = without_massless(path, reader.replaced(values).read())
    return replace(raw, values=raw.values | parameters, units=units)


@lru_cache(maxsize=8)  # designs of a batch replace values of one file
def _flat_reader(path: Path, text: bytes) -> _Reader:
    """Read all elements of a file; readers with replaced values share the elements that the values do not affect."""
    reader = _Reader(path, flattened(path, find_model(path, parse_xml(path, text))))
    with suppress(InputError):  # of a value that may be replaced
        reader.measure()
        reader.read()
    return reader


def _changeable(element: ET.Element) -> ET.Element:
    """Copy an element; elements for pictures, without replaceable values, are shared with the original."""
    result = ET.Element(element.tag, element.attrib)
    result.text, result.tail = element.text, element.tail
    result.extend([part if part.tag in ("visual", "collision") else _changeable(part) for part in element])
    return result


def read_model(path: Path, model: ET.Element) -> RawModel:
    """Read a ``<model>`` without nested models, as `read_sdf`; a missing mass of a link is zero."""
    return _Reader(path, model).read()


class _OwnJoint(NamedTuple):
    """Data of a joint's element without the poses of other elements; names are empty if none are given."""

    type: str
    parent: str
    child: str
    parent_frame: str
    direction: Array
    expressed_in: str
    bearing: BearingSize | None
    slot: Slot | None


class _Reader:
    """Reads the elements of a model, each once.

    `elements` has copies of links, joints and frames by name, `names` their names by tag, `namers` the elements that
    name an element (itself included), `places` owner and place of each number that can be replaced, by dotted path,
    `values` these numbers, `grid` the grid of all places.
    """

    def __init__(self, path: Path, model: ET.Element, grid: float = UNROUNDED) -> None:
        self.path = path
        self.model = model
        self.grid = grid
        self.elements: dict[str, ET.Element] = {}
        for element in self.model:
            if element.tag in ("link", "joint", "frame"):
                self._declare(element)
            else:
                self._refuse_unknown(element, label(self.model))
        if is_static(self.model):
            raise self.error("<static>", "a static model cannot move; remove it or set it to false")
        tags = ("link", "joint", "frame")
        self.names = {tag: tuple(name for name, part in self.elements.items() if part.tag == tag) for tag in tags}
        self.places: dict[str, tuple[str, elements.NumberPlace]] = {}
        self._change(self.elements)
        self.values = {path: place.value for path, (_, place) in self.places.items()}
        self._resolved: dict[str, Pose] = {}
        self._resolving: list[str] = []
        self._parts: dict[str, Any] = {}
        self._own: dict[tuple[str, str], Any] = {}  # what elements say by themselves, by reading function and name
        self._check_beams()
        self.namers = _namers(self.elements)

    def _change(self, names: Iterable[str]) -> None:
        """Copy elements whose numbers are replaced, and find the places of these numbers."""
        for name in list(names):
            element = self.elements[name] = _changeable(self.elements[name])
            for key, place in elements.places(element):
                self.places[f"{element.tag}s.{name}.{key}"] = name, place

    def replaced(self, overrides: Mapping[str, float]) -> _Reader:
        """Return a reader with other values; elements that they do not affect are not read again."""
        other, changed = copy.copy(self), {self._place(path)[0] for path in overrides}
        other.elements, other.places = dict(self.elements), dict(self.places)
        other._change(changed)
        if added := [path for path in overrides if path not in other.places]:
            for path in added:
                _, name, kind, key = path.split(".")
                if kind == "beam" and elements.annotation(other.elements[name], kind) is None:
                    elements.add_beam(other.elements[name], self._ends(name))
                    follow = f"links.{name}.mass", f"links.{name}.com"
                    other.places = {key: place for key, place in other.places.items() if not key.startswith(follow)}
                elements.add_size(other.elements[name], kind, key)
            other._change({path.split(".")[1] for path in added})
            for path in overrides:
                other._place(path)
        for path, value in overrides.items():
            other.places[path][1].put(value)
        other.values = self.values | {path: other.places[path][1].value for path in overrides}
        affected = list(changed)
        for name in affected:  # grows during the iteration
            affected += [each for each in self.namers[name] if each not in affected]
        other._resolved = {name: pose for name, pose in self._resolved.items() if name not in affected}
        other._parts = {name: part for name, part in self._parts.items() if name not in affected}
        stays = "_own_visuals"  # no number in them can be replaced
        other._own = {key: own for key, own in self._own.items() if key[1] not in changed or key[0] == stays}
        other._resolving = []
        return other

    def error(self, where: str, problem: str) -> InputError:
        return InputError(self.path, where, problem)

    def measure(self) -> None:
        """Choose the grid of all places: the distance of the two farthest of the file is exact on it."""
        farthest = max((float(np.abs(self._pose(name).translation).max()) for name in self.elements), default=0.0)
        self.grid, self._resolved = 2.0 ** (math.frexp(farthest)[1] - 52) if farthest else UNROUNDED, {}

    def read(self) -> RawModel:
        links = tuple(self._read("link", self._link).values())
        if not links:
            raise self.error(label(self.model), "has no <link>; a mechanism needs at least one")
        joints = tuple(self._read("joint", self._joint).values())
        frames = self._read("frame", lambda name, _: (self._carrier(name), self._pose(name)))
        values = dict(self.values)
        for link in links:
            if link.beam is not None:
                values[f"links.{link.name}.mass"] = link.mass
                values |= {
                    f"links.{link.name}.com.{axis}": float(x) for axis, x in zip("xyz", link.com_local, strict=True)
                }
        light = [link.name for link in links if link.beam is None]
        unweighed = tuple(name for name in light if self.elements[name].find("inertial") is None)
        return RawModel(self.model.get("name", ""), links, joints, frames, values, unweighed=unweighed, grid=self.grid)

    def _read(self, tag: str, part: Callable[[str, ET.Element], Any]) -> dict[str, Any]:
        """Read all elements with a tag that are not read yet; return them by name."""
        for name in self.names[tag]:
            if name not in self._parts:
                self._parts[name] = part(name, self.elements[name])
        return {name: self._parts[name] for name in self.names[tag]}

    def _said(self, name: str, read: Callable[..., Own], *arguments: object) -> Own:
        """Return an element's own data, read once."""
        key = read.__name__, name
        if key not in self._own:
            self._own[key] = read(*arguments)
        own: Own = self._own[key]
        return own

    def _place(self, path: str) -> tuple[str, elements.NumberPlace | None]:
        """Find the number at a dotted path, None for one that can be added, and its element's name."""
        if path in self.places:
            return self.places[path]
        where = f"sdf.{path}"
        kind, _, rest = path.partition(".")
        if kind not in ("links", "joints", "frames"):
            raise self.error(where, f'"{kind}" is unknown; paths start with links., joints. or frames.')
        name, _, key = rest.partition(".")
        tag = kind.removesuffix("s")
        if name not in self.names[tag]:
            raise self.error(where, f'there is no {tag} "{name}"; {nearest(name, self.names[tag])}')
        if key.partition(".")[0] in ("mass", "com") and elements.annotation(self.elements[name], "beam") is not None:
            raise self.error(where, FOLLOWS)
        if kind == "joints" and key in _SIZES.get(self.elements[name].get("type", ""), ()):
            return name, None
        if kind == "links" and key in _BEAM and len(self._ends(name)) == 2:
            return name, None
        start = f"{kind}.{name}."
        known = [other.removeprefix(start) for other in self.places if other.startswith(start)]
        raise self.error(where, f'"{key}" is unknown; {nearest(key, known)}')

    def _ends(self, link: str) -> list[str]:
        """Return the names by which joints refer to a link: its own, and the ones of its frames."""
        joints = [self.elements[name] for name in self.names["joint"]]
        named = [(joint.findtext(end) or "").strip() for joint in joints for end in ("parent", "child")]
        return list(dict.fromkeys(name for name in named if name and self._carrier(name) == link))

    def _check_beams(self) -> None:
        """Check that each <inertial> agrees with the link's beam, before any value is replaced."""
        for name in self.names["link"]:
            element = self.elements[name]
            if (beam := self._beam(name, element)) is not None:
                written = self._written(name, element)
                check_inertial(self.path, written, of_beam(written, beam))

    # -- names and poses ---------------------------------------------------------------------------

    def _declare(self, element: ET.Element) -> None:
        name = element.get("name", "")
        if not name:
            raise self.error(f"<{element.tag}>", 'has no name; write name="..."')
        if name == "world" or (name.startswith("__") and name.endswith("__")):
            raise self.error(label(element), "is a reserved name; choose another")
        if name in self.elements:
            other = self.elements[name].tag
            raise self.error(label(element), f"is defined twice (also as a <{other}>); names must be unique")
        self.elements[name] = element

    def _refuse_unknown(self, element: ET.Element, where: str) -> None:
        """Reject an unknown element that can change the motion."""
        if ":" in element.tag and not any(part in _HARMLESS for part in element.tag.split(":", 1)):
            problem = "is unknown; remove it, or use `linkages import` to write a file without it"
            raise self.error(f"{where}/<{element.tag}>", problem)

    def _find(self, name: str, asked_by: str) -> ET.Element:
        if name not in self.elements:
            known = nearest(name, [*self.elements, "world"])
            raise self.error(asked_by, f'names "{name}", which does not exist; {known}')
        return self.elements[name]

    def _pose(self, name: str, asked_by: str = "") -> Pose:
        """Return the world pose of a link, joint, frame, the model, or the world."""
        if name == "world":
            return Pose()
        if name == "__model__":
            return Pose().carried(elements.own_pose(self.path, self.model, label(self.model)), self.grid)
        if name in self._resolved:
            return self._resolved[name]
        element = self._find(name, asked_by)
        where = label(element)
        if name in self._resolving:
            chain = " -> ".join([*self._resolving[self._resolving.index(name) :], name])
            raise self.error(where, f"its pose is relative to itself ({chain}); break the circle")
        if len(self._resolving) == DEEPEST:
            raise self.error(where, f"its pose is the last of more than {DEEPEST} that are relative to each other")
        self._resolving.append(name)
        base = self._said(name, _base, element)
        own = self._said(name, elements.own_pose, self.path, element, where)
        result = self._pose(base, where).carried(own, self.grid)
        self._resolving.pop()
        self._resolved[name] = result
        return result

    def _carrier(self, name: str, asked_by: str = "", passed: tuple[str, ...] = ()) -> str:
        """Return the link that carries the link, frame or joint with this name."""
        if name == "world":
            return name
        if name == "__model__":
            return self.model.get("canonical_link") or self.names["link"][0]
        found = self._find(name, asked_by)
        if found.tag == "link":
            return name
        if name in passed:
            raise self.error(label(found), "is attached to itself; break the circle")
        if len(passed) == DEEPEST:
            raise self.error(label(found), f"is the last of more than {DEEPEST} frames that are attached to each other")
        return self._carrier(_attached_to(found), label(found), (*passed, name))

    # -- elements ----------------------------------------------------------------------------------

    def _link(self, name: str, element: ET.Element) -> RawLink:
        link, beam = self._written(name, element), self._beam(name, element)
        return link if beam is None else of_beam(link, beam)

    def _beam(self, name: str, element: ET.Element) -> LinkBeam | None:
        """Read the beam of a link, with the positions of its ends."""
        beam = written_beam(self.path, element)
        if beam is None:
            return None
        where = f"{label(element)}/<linkages:beam>"
        for key, frame in zip(("from", "to"), beam.frames, strict=True):
            if (carrier := self._carrier(frame, f"{where}/<linkages:{key}>")) != name:
                problem = f'"{frame}" is on "{carrier}"; it must be a frame of "{name}"'
                raise self.error(f"{where}/<linkages:{key}>", problem)
        start, end = (self._pose(frame).translation for frame in beam.frames)
        if np.linalg.norm(end - start) < 1e-9:
            raise self.error(where, f'has no length: "{beam.frames[0]}" and "{beam.frames[1]}" coincide')
        return replace(beam, start=start, end=end)

    def _written(self, name: str, element: ET.Element) -> RawLink:
        """Read a link with the values of its <inertial>."""
        pose = self._pose(name)
        visuals = self._said(name, self._own_visuals, element)
        if visuals is None:
            visuals = tuple(self._visual(visual, pose, label(element)) for visual in element.findall("visual"))
        mass, centre, inertia = self._said(name, elements.inertial, self.path, element)
        return RawLink(name, mass, pose.rotation, pose.translation, centre, inertia, visuals, None)

    def _own_visuals(self, element: ET.Element) -> tuple[str, ...] | None:
        """Write the visuals of a link; None if the place of one depends on other elements."""
        found = element.findall("visual")
        if any(pose.get("relative_to") for visual in found for pose in visual.findall("pose")):
            return None
        return tuple(self._visual(visual, Pose(), label(element)) for visual in found)

    def _visual(self, element: ET.Element, link: Pose, where: str) -> str:
        """Write a <visual> with its pose first, and in link axes."""
        spot = f"{where}/{label(element)}"
        own, pose = elements.own_pose(self.path, element, spot), element.find("pose")
        if pose is not None and (base := pose.get("relative_to")):
            own = link.inverse() @ self._pose(base, spot) @ own
        return elements.with_pose(element, own)

    def _joint(self, name: str, element: ET.Element) -> RawJoint:
        own = self._said(name, self._own_joint, element)
        pose = self._pose(name)
        # A parent given as a *frame* defines the joint's place on the parent; the standard's place
        # (the joint's reference position) is the same if the file's pose closes the loops.
        on_parent = self._pose(own.parent_frame) if own.parent_frame else pose
        turned = self._pose(own.expressed_in, label(element)) if own.expressed_in else pose
        places = pose.translation, on_parent.translation
        axis = turned.rotation @ own.direction
        return RawJoint(name, own.type, own.parent, own.child, axis, *places, own.bearing, own.slot)

    def _own_joint(self, element: ET.Element) -> _OwnJoint:
        where = label(element)
        for part in element:
            self._refuse_unknown(part, where)
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
        on_frame = ends["parent"] in self.elements and self.elements[ends["parent"]].tag == "frame"
        axis = (np.zeros(3), "") if JOINT_TYPES[kind] == "fixed" else self._axis(element, where)
        bearing, slot = self._annotation(element, "bearing", BearingSize), self._annotation(element, "slot", Slot)
        frame = ends["parent"] if on_frame else ""
        return _OwnJoint(JOINT_TYPES[kind], parent, child, frame, *axis, bearing, slot)

    def _axis(self, element: ET.Element, where: str) -> tuple[Array, str]:
        """Read the direction of a joint's axis, and the name of the frame in which it is given, if it is named."""
        axis = element.find("axis")
        xyz = axis.find("xyz") if axis is not None else None
        if axis is None or xyz is None:
            raise self.error(where, "has no <axis><xyz>; give the direction of motion")
        if axis.find("mimic") is not None:
            problem = "a joint that mimics another is geared to it; write a gear into the experiment"
            raise self.error(f"{where}/<axis>/<mimic>", problem)
        for part in axis:
            self._refuse_unknown(part, f"{where}/<axis>")
        direction = elements.numbers(self.path, xyz, 3, f"{where}/<axis>/<xyz>")
        length = float(np.linalg.norm(direction))
        if length < 1e-9:
            raise self.error(f"{where}/<axis>/<xyz>", "has no length; give a direction")
        dynamics, spot = axis.find("dynamics"), f"{where}/<axis>/<dynamics>"
        for key in ("damping", "friction", "spring_stiffness"):
            if dynamics is not None and elements.number(self.path, dynamics, key, spot, 0.0) != 0.0:
                raise self.error(f"{spot}/<{key}>", "is not supported; remove it or set it to 0")
        return direction / length, xyz.get("expressed_in", "")

    def _annotation(self, element: ET.Element, tag: str, kind: type[Part]) -> Part | None:
        """Read <linkages:bearing> or <linkages:slot>: its two lengths."""
        found, where = elements.annotation(element, tag), f"{label(element)}/<linkages:{tag}>"
        units = dict.fromkeys((key.name for key in fields(kind)), "m")
        return None if found is None else kind(**elements.sizes(self.path, found, where, units))


def _attached_to(element: ET.Element) -> str:
    """Return the name of the element that a link, frame or joint is attached to (default of ``relative_to``)."""
    if element.tag == "joint":
        return element.findtext("child", "").strip()
    return (element.tag == "frame" and element.get("attached_to")) or "__model__"


def _base(element: ET.Element) -> str:
    """Return the name of the element to which the pose of another is relative."""
    pose = element.find("pose")
    return (pose.get("relative_to", "") if pose is not None else "") or _attached_to(element)


def _namers(named: Mapping[str, ET.Element]) -> dict[str, list[str]]:
    """Find the elements that name each element, as in ``relative_to`` or ``<child>``."""
    namers: dict[str, list[str]] = {name: [] for name in named}
    for name, element in named.items():
        words = {word for part in element.iter() for word in ((part.text or "").strip(), *part.attrib.values())}
        for other in words & named.keys():
            namers[other].append(name)
    return namers
