"""What an element says by itself: its pose relative to its base, a link's inertia; texts of visuals."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from linkages.arrays import Array
from linkages.errors import InputError
from linkages.files.elements import number, numbers
from linkages.files.places import is_in_degrees, is_quaternion
from linkages.files.raw_model import Pose, rotation
from linkages.files.xml import label


def own_pose(path: Path, element: ET.Element, where: str) -> Pose:
    """Read the <pose> of an element, relative to its base."""
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return Pose()
    quaternion = is_quaternion(pose)
    values = numbers(path, pose, 7 if quaternion else 6, f"{where}/<pose>")
    if quaternion:
        if abs(np.linalg.norm(values[3:]) - 1.0) > 1e-6:
            raise InputError(path, f"{where}/<pose>", "its quaternion does not have length one")
        from scipy.spatial.transform import Rotation  # half a second of import time

        return Pose(Rotation.from_quat(values[3:]).as_matrix(), values[:3])
    return Pose(rotation(np.radians(values[3:]) if is_in_degrees(pose) else values[3:]), values[:3])


def inertial(path: Path, link: ET.Element) -> tuple[float, Array, Array]:
    """Read mass, mass centre and inertia tensor about it in link axes; zeros without an <inertial>."""
    where, inertial = f"{label(link)}/<inertial>", link.find("inertial")
    if inertial is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    if inertial.get("auto", "false") in ("true", "1"):
        raise InputError(path, where, "is automatic; `linkages import` computes its values")
    mass = number(path, inertial, "mass", where)
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
    """Read the tensor (3, 3) of an <inertia>, in its axes."""
    xx, yy, zz = (number(path, element, key, where) for key in ("ixx", "iyy", "izz"))
    xy, xz, yz = (number(path, element, key, where, 0.0) for key in ("ixy", "ixz", "iyz"))
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


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
