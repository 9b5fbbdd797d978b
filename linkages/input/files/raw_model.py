"""Content of a mechanism's file, in world coordinates of the reference configuration."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from linkages.base.arrays import Array
from linkages.mechanics.flexible.beam import Beam

#: Grid that is finer than all numbers.
UNROUNDED = 2.0**-200
#: Grid of the entries of rotation matrices that turn displacements: zero at right angles, equal for parallel links.
TURN = 2.0**-49


def rotation(angles: Array) -> Array:
    """Compute the rotation matrix (3, 3) of roll, pitch, yaw (3,) [rad], about fixed x, y, z in this order."""
    (a, b, c), (u, v, w) = np.cos(angles), np.sin(angles)
    return np.array(
        [
            [c * b, c * v * u - w * a, c * v * a + w * u],
            [w * b, w * v * u + c * a, w * v * a - c * u],
            [-v, b * u, b * a],
        ]
    )


def on_grid(lengths: Array, grid: float) -> Array:
    """Round lengths to multiples of a power of two [m].

    Sums of such multiples have no rounding errors. So the distance of two places does not depend on other lengths.
    """
    return np.asarray(np.rint(lengths / grid) * grid)


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid transform: rotation matrix (3, 3) and translation (3,) [m]."""

    rotation: Array = field(default_factory=lambda: np.eye(3))
    translation: Array = field(default_factory=lambda: np.zeros(3))

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.rotation @ other.rotation, self.rotation @ other.translation + self.translation)

    def carried(self, other: Pose, grid: float) -> Pose:
        """Return the pose of `other`, which is relative to this one, at a displacement `on_grid`."""
        return Pose(self.rotation @ other.rotation, self.translation + self.displacement(other.translation, grid))

    def displacement(self, local: Array, grid: float) -> Array:
        """Turn a displacement in own axes into the world's, each coordinate by itself `on_grid` [m]."""
        return np.asarray(on_grid(on_grid(self.rotation, TURN) * local, grid).sum(axis=1)) if local.any() else local

    def inverse(self) -> Pose:
        """Return the inverse transform."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    def text(self) -> str:
        """Write the numbers of a ``<pose>``: x y z [m] roll pitch yaw [rad], without rounding errors."""
        turn = self.rotation
        level = float(np.hypot(turn[0, 0], turn[1, 0]))
        if level > 1e-9:
            roll, yaw = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
        else:  # gimbal lock: roll and yaw rotate about the same axis
            roll, yaw = np.arctan2(-turn[1, 2], turn[1, 1]), 0.0
        numbers = (*self.translation, roll, np.arctan2(-turn[2, 0], level), yaw)
        return " ".join(repr(round(float(number), 15) + 0.0) for number in numbers)


@dataclass(frozen=True)
class BearingSize:
    """A journal bearing; the joint's parent carries the bearing, its child the journal.

    Attributes
    ----------
    radius, length : float
        Of the bearing [m].
    """

    radius: float
    length: float


@dataclass(frozen=True)
class Slot:
    """A block in a slot; the joint's parent carries the slot, its child the block.

    Attributes
    ----------
    length, height : float
        Size of the block [m].
    """

    length: float
    height: float


@dataclass(frozen=True)
class LinkBeam:
    """A uniform straight beam between two frames of a link.

    Attributes
    ----------
    frames : (str, str)
        Frames at its start and at its end.
    start, end : arrays
        Reference positions [m]: in the world, (3,); in a `linkages.input.model.mechanism.Link` in plane axes, (2,).
    section : str
        "rectangle", "circle", "tube" or "section".
    sizes : mapping of str to float
        Width (normal to the plane) and height (in the plane) of a rectangle; diameter; outer and inner diameter of a
        tube; or area, second moment of area and full height in the plane [m, m2, m4].
    youngs_modulus : float
        E [Pa].
    density : float
        Density [kg/m3].
    poisson : float
        Poisson's ratio [1].
    """

    frames: tuple[str, str]
    start: Array
    end: Array
    section: str
    sizes: Mapping[str, float]
    youngs_modulus: float
    density: float
    poisson: float

    @property
    def length(self) -> float:
        """[m]."""
        return float(np.linalg.norm(self.end - self.start))

    @property
    def area(self) -> float:
        """Return the area of the section [m2]."""
        return self._section[0]

    @property
    def second_moment(self) -> float:
        """Return the second moment of area about the normal of the plane, through the centroid [m4]."""
        return self._section[1]

    @property
    def height(self) -> float:
        """Return the full height of the section in the plane [m]; M height / (2 I) is the bending stress."""
        return self._section[2]

    @property
    def mass(self) -> float:
        """[kg]."""
        return self.density * self.area * self.length

    @property
    def inertia(self) -> float:
        """Compute the moment of inertia of a thin rod about the normal axis through its middle [kg m2]."""
        return self.mass * self.length**2 / 12.0

    def along(self, point: Array) -> float:
        """Return the distance from the beam's start of a point on it, in the axes of `start` [m]."""
        return float((point - self.start) @ (self.end - self.start)) / self.length

    def part(self, first: float, last: float) -> LinkBeam:
        """Return the part of the beam between two distances from its start [m]."""
        way = (self.end - self.start) / self.length
        return replace(self, start=self.start + first * way, end=self.start + last * way)

    def elastic(self) -> Beam:
        """Return the Euler-Bernoulli beam between the frames, without rotary inertia."""
        stiffness = self.youngs_modulus * self.area, self.youngs_modulus * self.second_moment
        return Beam(self.length, *stiffness, self.density * self.area)

    @property
    def _section(self) -> tuple[float, float, float]:
        s = self.sizes
        if self.section == "section":
            return s["area"], s["second_moment"], s["height"]
        if self.section == "rectangle":
            return s["width"] * s["height"], s["width"] * s["height"] ** 3 / 12.0, s["height"]
        outer, inner = s.get("outer", s.get("diameter", 0.0)), s.get("inner", 0.0)
        return math.pi / 4.0 * (outer**2 - inner**2), math.pi / 64.0 * (outer**4 - inner**4), outer


@dataclass(frozen=True, eq=False)
class RawLink:
    """A rigid body with the data of the file.

    Attributes
    ----------
    name : str
    mass : float
        Mass [kg].
    rotation, translation : (3, 3), (3,) arrays
        Reference pose of the link frame in the world [m].
    com_local : (3,) array
        Mass centre in link axes [m].
    inertia_local : (3, 3) array
        Tensor of inertia about the mass centre in link axes [kg m2].
    visuals : tuple of str
        ``<visual>`` elements of the file; the pose comes first, in link axes.
    beam : LinkBeam or None
        Beam of a link that can be flexible; it determines mass, mass centre and inertia.
    """

    name: str
    mass: float
    rotation: Array
    translation: Array
    com_local: Array
    inertia_local: Array
    visuals: tuple[str, ...]
    beam: LinkBeam | None

    @property
    def determined(self) -> tuple[str, ...]:
        """Return the keys of values that follow from others: from a beam."""
        return () if self.beam is None else ("mass", "inertia", "com")

    @property
    def pose(self) -> Pose:
        """Return the reference pose of the link frame in the world."""
        return Pose(self.rotation, self.translation)


@dataclass(frozen=True, eq=False)
class RawJoint:
    """A joint with the data of the file.

    Attributes
    ----------
    name : str
    type : str
        "revolute", "prismatic" or "fixed".
    parent, child : str
        Links; the parent may be "world".
    axis : (3,) array
        Axis in the world.
    position, position_on_parent : (3,) arrays
        Places on the child and on the parent, in the world [m].
    bearing : BearingSize or None
        Bearing of a revolute joint that can have clearance.
    slot : Slot or None
        Slot of a prismatic joint that can have clearance.
    """

    name: str
    type: str  # "revolute", "prismatic" or "fixed"
    parent: str
    child: str
    axis: Array
    position: Array
    position_on_parent: Array
    bearing: BearingSize | None
    slot: Slot | None

    @classmethod
    def fixed(cls, name: str, parent: str, child: str) -> RawJoint:
        """Return a fixed joint."""
        nowhere = np.zeros(3)
        return cls(name, "fixed", parent, child, nowhere, nowhere, nowhere, None, None)


@dataclass(frozen=True)
class RawModel:
    """The complete content of the file.

    `frames` has the link that carries each named frame, and its pose; `values` the numbers of the file, by the
    dotted paths that `linkages.input.files.sdf.read_sdf` replaces; `units` the units of parameters by the same paths;
    `unweighed` the links without an ``<inertial>``; `grid` the power of two of which all places are multiples [m].
    """

    name: str
    links: tuple[RawLink, ...]
    joints: tuple[RawJoint, ...]
    frames: dict[str, tuple[str, Pose]]
    values: dict[str, float]
    units: Mapping[str, str] = field(default_factory=dict)
    unweighed: tuple[str, ...] = ()
    grid: float = UNROUNDED

    def free_name(self, name: str) -> str:
        """Return a name, with a number if a link, joint or frame has it, or has it with the end _A or _B."""
        taken = {link.name for link in self.links} | {joint.name for joint in self.joints} | set(self.frames)
        return free_name(taken, name, ("", "_A", "_B"))

    def chains(self, *types: str) -> Chains:
        """Return the sets of links that joints of some types connect; default: all joints."""
        joints = (joint for joint in self.joints if not types or joint.type in types)
        return Chains((link.name for link in self.links), ((joint.parent, joint.child) for joint in joints))


def free_name(taken: Collection[str], name: str, ends: Sequence[str] = ("",)) -> str:
    """Return a name, with a number if it is taken with one of the ends."""
    names = (name if not count else f"{name}_{count + 1}" for count in range(len(taken) + 1))
    return next(found for found in names if not any(f"{found}{end}" in taken for end in ends))


class Chains:
    """Connected sets of links, grown joint by joint, each given by the links it joins; `of` has each link's set."""

    def __init__(self, links: Iterable[str], joints: Iterable[tuple[str, str]] = ()) -> None:
        self.of = {name: {name} for name in ("world", *links)}
        for joint in joints:
            self.join(*joint)

    def join(self, parent: str, child: str) -> bool:
        """Connect the two links of a joint; return False if they were connected before."""
        if child in self.of[parent]:
            return False
        together = self.of[parent] | self.of[child]
        self.of |= dict.fromkeys(together, together)
        return True
