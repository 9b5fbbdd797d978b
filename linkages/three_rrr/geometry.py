"""Dimensions of a planar 3-RRR robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.input.model.mechanism import Joint, Mechanism
from linkages.mechanics.flexible.triangle import signed_area

LEGS = (1, 2, 3)
_SMALLEST = 1e-9  # lengths below this fraction of the base count as zero


@dataclass(frozen=True)
class Geometry:
    """Lengths of the robot; any two triangles, any three legs.

    Attributes
    ----------
    base : (3, 2) array
        Pivots A_r in plane axes [m].
    platform : (3, 2) array
        Pivots C_r in platform axes [m].
    crank, coupler : (3,) arrays
        Lengths A_r B_r and B_r C_r [m].
    """

    base: Array
    platform: Array
    crank: Array
    coupler: Array

    def __post_init__(self) -> None:
        for name, shape in {"base": (3, 2), "platform": (3, 2), "crank": (3,), "coupler": (3,)}.items():
            value = np.asarray(getattr(self, name), dtype=float)
            if value.shape != shape or not np.all(np.isfinite(value)):
                raise InputError("geometry", name, f"must be {shape} finite numbers")
            object.__setattr__(self, name, value)
        smallest = _SMALLEST * max(self.size, 1e-300)
        for name in ("crank", "coupler"):
            for leg, length in zip(LEGS, getattr(self, name), strict=True):
                if length <= smallest:
                    problem = f"has the length {length:g} m; it must be positive"
                    raise InputError("geometry", f"{name}{leg}", problem)
        if abs(self.platform_area) <= smallest * self.size:
            problem = "its three pivots lie on a line; they must span a triangle"
            raise InputError("geometry", "platform", problem)

    @property
    def size(self) -> float:
        """Length scale: the longest chain from the base's first pivot [m]."""
        reach = float(np.max(np.linalg.norm(self.base - self.base[0], axis=1)))
        return reach + float(np.max(self.crank) + np.max(self.coupler))

    @property
    def platform_area(self) -> float:
        """Signed area of C_1 C_2 C_3 [m2]; positive if counter-clockwise."""
        return signed_area(self.platform)


def from_mechanism(mechanism: Mechanism) -> Geometry:
    """Read the dimensions off a mechanism with the joints A1..A3, B1..B3, C1..C3 and the link ``platform``.

    InputError if a joint is missing or joins other links, or a length is zero.
    """
    source = mechanism.source
    ends = {"A": ("world", "crank{}"), "B": ("crank{}", "coupler{}"), "C": ("coupler{}", "platform")}
    found: dict[str, list[Joint]] = {letter: [] for letter in ends}
    for letter, (parent, child) in ends.items():
        for leg in LEGS:
            name = f"{letter}{leg}"
            where = f'<joint name="{name}">'
            if name not in mechanism.joint:
                raise InputError(source, where, f"is missing; {nearest(name, mechanism.joint)}")
            joint = mechanism.joint[name]
            want = parent.format(leg), child.format(leg)
            if (joint.parent, joint.child) != want or joint.type != "revolute":
                raise InputError(
                    source,
                    where,
                    f"is a {joint.type} joint of {joint.parent} and {joint.child}; a 3-RRR robot needs"
                    f" a revolute joint of {want[0]} (parent) and {want[1]} (child)",
                )
            found[letter].append(joint)
    link = mechanism.link["platform"]
    c, s = np.cos(link.angle), np.sin(link.angle)
    pivots = np.array([joint.on_child for joint in found["C"]]) - link.origin
    base = np.array([joint.on_parent for joint in found["A"]])
    crank, coupler = _lengths(found["A"], found["B"]), _lengths(found["B"], found["C"])
    try:
        return Geometry(base, pivots @ np.array([[c, -s], [s, c]]), crank, coupler)
    except InputError as problem:
        raise InputError(source, "", str(problem).partition(": ")[2]) from None


def drawn_angles(mechanism: Mechanism) -> Array:
    """Crank angles (3,) of the pose that the SDF file draws [rad]."""
    rods = [mechanism.joint[f"B{leg}"].on_parent - mechanism.joint[f"A{leg}"].on_child for leg in LEGS]
    return np.array([np.arctan2(rod[1], rod[0]) for rod in rods])


def _lengths(first: list[Joint], second: list[Joint]) -> Array:
    """Lengths (3,) of the rods between two joints of each leg [m]."""
    return np.array([np.hypot(*(b.on_parent - a.on_child)) for a, b in zip(first, second, strict=True)])
