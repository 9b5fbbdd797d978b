"""Places of the numbers in an SDFormat file, by the dotted paths that replace them."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass

from linkages.files.elements import annotation
from linkages.files.magnitudes import decimal

_POSE_KEYS = ("x", "y", "z", "roll", "pitch", "yaw")


@dataclass(frozen=True)
class Place:
    """Place of a number in the file: the text of an element, or one word of a <pose>, which may be empty."""

    element: ET.Element
    index: int | None = None

    @property
    def value(self) -> float:
        """Return the number, angles in radians; NaN if the text is not a number."""
        try:
            number = decimal(self._words()[self.index or 0])
        except (ValueError, IndexError):
            return math.nan
        return math.radians(number) if self._in_degrees() else number

    def put(self, value: float) -> None:
        """Replace the number."""
        words, index = [""] if self.index is None else self._words(), self.index or 0
        if index < len(words):  # otherwise the <pose> is too short; reading it reports this
            words[index] = str(math.degrees(value) if self._in_degrees() else value)
            self.element.text = " ".join(words)

    def _words(self) -> list[str]:
        return (self.element.text or "").split() or ["0"] * 6

    def _in_degrees(self) -> bool:
        return self.index is not None and self.index >= 3 and is_in_degrees(self.element)


def places(element: ET.Element) -> Iterator[tuple[str, Place]]:
    """Find every number that a dotted path can name; adds an empty <pose> where it is missing.

    Parameters
    ----------
    element : Element
        A link, joint or frame. The mass of a link with a beam has no place, as it follows from the beam.

    Yields
    ------
    (str, Place)
        The end of the path (``pose.x``), and the place of the number.
    """
    inertial = None if annotation(element, "beam") is not None else element.find("inertial")
    holders = (element, "pose", _POSE_KEYS), (inertial, "com", _POSE_KEYS[:3])
    for holder, prefix, keys in holders:
        if holder is None:
            continue
        pose = holder.find("pose")
        if pose is None:
            pose = ET.SubElement(holder, "pose")
        for index, key in enumerate(keys[:3] if is_quaternion(pose) else keys):
            yield f"{prefix}.{key}", Place(pose, index)
    mass = None if inertial is None else inertial.find("mass")
    if mass is not None:
        yield "mass", Place(mass)
    for kind in ("bearing", "slot", "beam"):
        found = annotation(element, kind)
        for number in found.iter() if found is not None else ():
            key = number.tag.rpartition(":")[2]
            if number is not found and not len(number) and key not in ("from", "to"):
                yield f"{kind}.{key}", Place(number)


def is_quaternion(pose: ET.Element) -> bool:
    """Check whether a <pose> gives its rotation as a quaternion."""
    return pose.get("rotation_format", "euler_rpy") == "quat_xyzw"


def is_in_degrees(pose: ET.Element) -> bool:
    """Check whether a <pose> gives its angles in degrees."""
    return pose.get("degrees", "false") in ("true", "1")
