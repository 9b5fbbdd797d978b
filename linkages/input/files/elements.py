"""Content of single elements: numbers, annotations (prefix ``linkages``), poses, inertia, places of numbers."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.input.files.magnitudes import decimal, decimal_or_nan, implausible
from linkages.input.files.raw_model import Pose, rotation
from linkages.input.files.xml import ANNOTATIONS, label

_UNITS = {"m": "metres"}
_POSE_KEYS = ("x", "y", "z", "roll", "pitch", "yaw")

#: Entries of an <inertia>: their indices in the tensor.
INERTIA = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


def numbers(path: Path, element: ET.Element, count: int, where: str) -> Array:
    """Read the numbers of an element, `where` in the file; InputError for another count or other text."""
    words = (element.text or "").split()
    try:
        values = np.array([decimal(word) for word in words])
    except ValueError:
        raise InputError(path, where, f'"{" ".join(words)}" is not {_count(count)}') from None
    if len(values) != count:
        raise InputError(path, where, f"has {_count(len(values))}; {count} are needed")
    for problem in filter(None, map(implausible, values.tolist())):
        raise InputError(path, where, problem)
    return values


def number(path: Path, parent: ET.Element, key: str, where: str, default: float | None = None) -> float:
    """Read the number in the child `key` of an element, optional if there is a default; errors as `numbers`."""
    element = parent.find(key)
    if element is None:
        if default is None:
            raise InputError(path, where, f"has no <{key}>")
        return default
    return float(numbers(path, element, 1, f"{where}/<{key}>")[0])


def _count(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"


# -- annotations -------------------------------------------------------------------------------------------------------


def annotation(element: ET.Element, kind: str) -> ET.Element | None:
    """Find ``<linkages:KIND>`` in an element."""
    return next((child for child in element if child.tag.endswith(f":{kind}")), None)


def add_size(element: ET.Element, kind: str, key: str) -> None:
    """Add an empty ``<linkages:KEY>`` to the ``<linkages:KIND>`` of an element, which is made if it is missing."""
    table = annotation(element, kind)
    if table is not None and kind == "beam":
        table = annotation(table, "rectangle" if key in ("width", "height") else "material")
    ET.SubElement(ET.SubElement(element, f"linkages:{kind}") if table is None else table, f"linkages:{key}")


def add_beam(link: ET.Element, ends: Sequence[str]) -> None:
    """Add a ``<linkages:beam>`` with a rectangle as its section between two frames, without its numbers."""
    beam = ET.SubElement(link, "linkages:beam")
    for key, text in zip(("from", "to", "rectangle", "material"), (*ends, None, None), strict=True):
        ET.SubElement(beam, f"linkages:{key}").text = text


def parts(path: Path, element: ET.Element, where: str, keys: Iterable[str]) -> dict[str, ET.Element]:
    """Return the elements of an annotation by name; `keys` are the known names."""
    found = {child.tag.rpartition(":")[2]: child for child in element}
    for key, child in found.items():
        if key not in keys:
            raise InputError(path, where, f"<{key}> is unknown; {nearest(key, keys)}")
        if ":" not in child.tag:
            raise InputError(path, where, f"write <linkages:{key}>, not <{key}>")
    return found


def sizes(path: Path, element: ET.Element, where: str, units: Mapping[str, str], **defaults: float) -> dict[str, float]:
    """Read the positive numbers of an annotation; keys of `units` without a default are mandatory."""
    found, values = parts(path, element, where, units), defaults
    for key, unit in units.items():
        if key in found:
            values[key] = float(numbers(path, found[key], 1, f"{where}/<linkages:{key}>")[0])
        if key not in values:
            raise InputError(path, where, f"has no <linkages:{key}>; give it in {_UNITS.get(unit, unit)}")
        if values[key] <= 0.0:
            raise InputError(path, f"{where}/<linkages:{key}>", f"is {values[key]:g} {unit}; it must be positive")
    return values


# -- poses and inertia -------------------------------------------------------------------------------------------------


def own_pose(path: Path, element: ET.Element, where: str) -> Pose:
    """Read the <pose> of an element, relative to its base."""
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return Pose()
    quaternion = _is_quaternion(pose)
    values = numbers(path, pose, 7 if quaternion else 6, f"{where}/<pose>")
    if quaternion:
        if abs(np.linalg.norm(values[3:]) - 1.0) > 1e-6:
            raise InputError(path, f"{where}/<pose>", "its quaternion does not have length one")
        from scipy.spatial.transform import Rotation  # half a second of import time

        return Pose(Rotation.from_quat(values[3:]).as_matrix(), values[:3])
    return Pose(rotation(np.radians(values[3:]) if _is_in_degrees(pose) else values[3:]), values[:3])


def inertial(path: Path, link: ET.Element) -> tuple[float, Array, Array]:
    """Read mass, mass centre and inertia tensor about it in link axes; zeros without an <inertial>."""
    where, inertial = f"{label(link)}/<inertial>", link.find("inertial")
    if inertial is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    if inertial.get("auto") == "true":
        raise InputError(path, where, "is automatic; `linkages import` computes its values")
    mass = number(path, inertial, "mass", where)
    if inertial.find("pose[@relative_to]") is not None:
        raise InputError(path, f"{where}/<pose>", "is relative to another element; write it in the link's axes")
    if mass < 0.0:
        raise InputError(path, f"{where}/<mass>", f"is {mass:g} kg; it must be positive")
    centre = own_pose(path, inertial, where)
    tensor = inertial.find("inertia")
    if tensor is None:
        raise InputError(path, where, "has no <inertia>; give ixx, iyy, izz")
    spot = f"{where}/<inertia>"
    matrix = tensor_of(path, tensor, spot)
    principal = np.linalg.eigvalsh(matrix)
    slack = 1e-9 * max(abs(principal[-1]), 1e-300)
    if principal[0] < -slack or principal[-1] > principal[0] + principal[1] + slack:
        moments = ", ".join(f"{moment:g}" for moment in principal)
        rule = "none may be negative or larger than the sum of the others"
        raise InputError(path, spot, f"the principal moments {moments} kg m2 are impossible; {rule}")
    return mass, centre.translation, centre.rotation @ matrix @ centre.rotation.T


def tensor_of(path: Path, element: ET.Element, where: str) -> Array:
    """Read the tensor (3, 3) of an <inertia>, in its axes; products of inertia are optional."""
    tensor = np.empty((3, 3))
    for key, (i, j) in INERTIA.items():
        tensor[i, j] = tensor[j, i] = number(path, element, key, where, None if i == j else 0.0)
    return tensor


def with_pose(visual: ET.Element, pose: Pose) -> str:
    """Write a <visual> with another pose."""
    visual = copy.deepcopy(visual)
    if (own := visual.find("pose")) is not None:
        visual.remove(own)
    placed = ET.Element("pose")
    placed.text = pose.text()
    visual.insert(0, placed)
    visual.tail = None  # the text behind the element
    return ET.tostring(visual, encoding="unicode")


def _is_quaternion(pose: ET.Element) -> bool:
    return pose.get("rotation_format", "euler_rpy") == "quat_xyzw"


def _is_in_degrees(pose: ET.Element) -> bool:
    return pose.get("degrees") == "true"


# -- numbers that dotted paths replace ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class NumberPlace:
    """Place of a number in the file: the text of an element, or one word of a <pose>, which may be empty."""

    element: ET.Element
    index: int | None = None

    @property
    def value(self) -> float:
        """Return the number, angles in radians; NaN if the text is not a number."""
        number = decimal_or_nan(next(iter(self._words()[self.index or 0 :]), ""))
        return math.radians(number) if self._is_angle() else number

    def put(self, value: float) -> None:
        """Replace the number."""
        words, index = [""] if self.index is None else self._words(), self.index or 0
        if index < len(words):  # otherwise the <pose> is too short; reading it reports this
            words[index] = str(math.degrees(value) if self._is_angle() else value)
            self.element.text = " ".join(words)

    def _words(self) -> list[str]:
        return (self.element.text or "").split() or ["0"] * 6

    def _is_angle(self) -> bool:
        return self.index is not None and self.index >= 3 and _is_in_degrees(self.element)


def places(element: ET.Element) -> Iterator[tuple[str, NumberPlace]]:
    """Find every number of a link, joint or frame that a dotted path can name; adds a missing <pose>.

    The mass of a link with a beam has no place, as it follows from the beam. Yields the end of the path (``pose.x``),
    and the place.
    """
    inertial = None if annotation(element, "beam") is not None else element.find("inertial")
    holders = (element, "pose", _POSE_KEYS), (inertial, "com", _POSE_KEYS[:3])
    for holder, prefix, keys in holders:
        if holder is None:
            continue
        pose = holder.find("pose")
        if pose is None:
            pose = ET.SubElement(holder, "pose")
        for index, key in enumerate(keys[:3] if _is_quaternion(pose) else keys):
            yield f"{prefix}.{key}", NumberPlace(pose, index)
    mass = None if inertial is None else inertial.find("mass")
    if mass is not None:
        yield "mass", NumberPlace(mass)
    for kind in (*ANNOTATIONS["joints"], *ANNOTATIONS["links"]):
        found = annotation(element, kind)
        for number in found.iter() if found is not None else ():
            key = number.tag.rpartition(":")[2]
            if number is not found and not len(number) and key not in ("from", "to"):
                yield f"{kind}.{key}", NumberPlace(number)
