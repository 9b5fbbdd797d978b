"""Reading of MJCF: included files, default classes, angles, frames."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.input.files.magnitudes import decimal_or_nan
from linkages.input.files.raw_model import Pose
from linkages.input.files.reading import read_whole
from linkages.input.files.xml import DEEPEST, label, parse_xml

_MAIN = "main"  # usual name of the outermost class
_REFUSED = {"settotalmass": "-1", "boundmass": "0", "boundinertia": "0", "balanceinertia": "false"}  # usual values


def included(path: Path, root: ET.Element, passed: tuple[Path, ...] = ()) -> ET.Element:
    """Replace each ``<include file>`` of a file by what the named file contains."""
    for owner in list(root.iter()):
        for element in owner.findall("include"):
            other = path.parent / element.get("file", "")
            if other.resolve() in passed or len(passed) > DEEPEST:
                raise InputError(path, f"<include> {other.name}", "includes itself; break the circle")
            content = included(other, parse_xml(other, read_whole(other)), (*passed, path.resolve()))
            place = list(owner).index(element)
            owner.remove(element)
            for k, part in enumerate(content):
                owner.insert(place + k, part)
    return root


class Defaults:
    """A class of default attributes, with the classes inside it by name."""

    def __init__(self, own: Mapping[str, Mapping[str, str]], every: dict[str, Defaults]) -> None:
        self._own, self._every = own, every

    @classmethod
    def read(cls, root: ET.Element) -> Defaults:
        """Read all classes of a file; return the outermost one."""
        every: dict[str, Defaults] = {}

        def read(element: ET.Element | None, own: dict[str, dict[str, str]], name: str) -> Defaults:
            own = {tag: dict(given) for tag, given in own.items()}
            for part in element if element is not None else ():
                if part.tag != "default":
                    own[part.tag] = own.get(part.tag, {}) | dict(part.attrib)
            every[name] = cls(own, every)
            for part in element.findall("default") if element is not None else ():
                read(part, own, part.get("class", ""))
            return every[name]

        outer = ET.Element("default")
        name = _MAIN
        for element in root.findall("default"):
            outer.extend(element)
            name = element.get("class", name)
        return read(outer, {}, name)

    def child(self, name: str | None) -> Defaults:
        """Return the class of a name; without a name this one, as if there were none with an unknown name."""
        return self._every.get(name or "", self)

    def of(self, element: ET.Element, tag: str | None = None) -> ET.Element:
        """Return a copy of an element with the attributes of its class, or of this one, that it does not give."""
        made = copy.deepcopy(element)
        usual = self.child(element.get("class"))._own.get(tag or element.tag, {})
        made.attrib.update({**usual, **element.attrib})
        return made


class Mjcf:
    """A file with its defaults and conventions.

    Attributes
    ----------
    path, root
        The file, and its element ``<mujoco>`` with all that it includes.
    defaults : Defaults
    angle : float
        The file's unit of angles [rad].
    autolimits : bool
        Whether a range limits a joint that does not say so.
    from_shapes : str
        "true", "false" or "auto": whether inertia is computed of shapes.
    """

    def __init__(self, path: Path, root: ET.Element) -> None:
        self.path, self.root, self.defaults = path, root, Defaults.read(root)
        given = {key: value for compiler in root.findall("compiler") for key, value in compiler.attrib.items()}
        if given.get("coordinate", "local") != "local":
            raise InputError(path, "<compiler> coordinate", 'is "global", which is not supported; write local places')
        for key, usual in _REFUSED.items():
            if given.get(key, usual) not in (usual, "0"):
                raise InputError(path, f"<compiler> {key}", "changes masses, which is not supported; remove it")
        self.angle = 1.0 if given.get("angle") == "radian" else math.pi / 180.0
        self._sequence = given.get("eulerseq", "xyz")
        self.autolimits = given.get("autolimits", "true") == "true"
        self.from_shapes = given.get("inertiafromgeom", "auto")

    def numbers(self, element: ET.Element, key: str, count: int | None = None, default: str = "") -> Array:
        """Return the numbers of an attribute, (count,) or as many as there are; InputError for others."""
        text = element.get(key, default)
        values = np.array([decimal_or_nan(word) for word in text.split()])
        if not len(values) or not np.isfinite(values).all() or (count is not None and len(values) != count):
            wanted = "numbers" if count is None else f"{count} number{'s' * (count > 1)}"
            problem = f'is "{text}"; give {wanted}' if text else f"is missing; give {wanted}"
            raise InputError(self.path, f"{label(element)} {key}", problem)
        return values

    def pose(self, element: ET.Element) -> Pose:
        """Return the pose of an element in the body or frame that contains it."""
        return Pose(self.rotation(element), self.numbers(element, "pos", 3, "0 0 0"))

    def rotation(self, element: ET.Element) -> Array:
        """Return the rotation matrix of an element, from any of MuJoCo's five notations."""
        if element.get("quat") is not None:
            w, *v = self.numbers(element, "quat", 4)
            return _of_quaternion(w, np.array(v))
        if element.get("axisangle") is not None:
            *axis, angle = self.numbers(element, "axisangle", 4)
            return _about(np.array(axis), self.angle * angle)
        if element.get("euler") is not None:
            turned = np.eye(3)
            for which, angle in zip(self._sequence, self.numbers(element, "euler", 3), strict=True):
                step = _about(np.eye(3)["xyz".index(which.lower())], self.angle * angle)
                turned = turned @ step if which.islower() else step @ turned  # about turned axes, or fixed ones
            return turned
        if element.get("xyaxes") is not None:
            x, y = self.numbers(element, "xyaxes", 6).reshape(2, 3)
            x = x / np.linalg.norm(x)
            y = y - (x @ y) * x
            y = y / np.linalg.norm(y)
            return np.column_stack([x, y, np.cross(x, y)])
        if element.get("zaxis") is not None:
            return turned_to(self.numbers(element, "zaxis", 3))
        return np.eye(3)


def turned_to(direction: Array) -> Array:
    """Return the smallest rotation that turns z into a direction."""
    direction = direction / np.linalg.norm(direction)
    across = np.cross([0.0, 0.0, 1.0], direction)
    if not across.any():
        return np.diag([1.0, 1.0, 1.0]) if direction[2] > 0.0 else np.diag([1.0, -1.0, -1.0])
    return _about(across, math.atan2(float(np.linalg.norm(across)), float(direction[2])))


def _about(axis: Array, angle: float) -> Array:
    axis = axis / np.linalg.norm(axis)
    return _of_quaternion(math.cos(0.5 * angle), math.sin(0.5 * angle) * axis)


def _of_quaternion(w: float, v: Array) -> Array:
    size = math.sqrt(w * w + float(v @ v))
    w, (x, y, z) = w / size, v / size
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
