"""Spanning tree of a mechanism: joints that carry the bodies, cut joints, coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.base.arrays import Array, Records
from linkages.base.kernel.by_reference import packed
from linkages.base.kernel.simd import LaneArray
from linkages.elements.coordinates import WHEEL, Coupled
from linkages.elements.pictures import Point
from linkages.input.functions.definitions import OF_JOINTS
from linkages.input.model.mechanism import Frame, Joint, Link, Mechanism
from linkages.input.model.skeleton import Skeleton, skeleton
from linkages.mechanics.planar import record_types as types
from linkages.mechanics.planar.bodies import ELASTIC, LOCK, STIFFNESS, Bodies, make_pose
from linkages.mechanics.planar.closure import closure_error
from linkages.mechanics.planar.workspace import Workspace, make_workspace
from linkages.system.deformable import DeformableBody, section_at

#: Closure rows of a cut joint.
ROWS = {"fixed": 3, "revolute": 2, "prismatic": 2}
#: Types of joints in records of bodies.
TYPES = {"fixed": types.FIXED, "revolute": types.REVOLUTE, "prismatic": types.PRISMATIC}
NO_TERM = (0, (0, 0.0, 0.0), (0, 0.0, 0.0), 0.0, 0.0)  # of a row with one term only
_SAME = 1e-6  # relative to the linkage's size: points whose box is smaller coincide
_IMMOBILE = 1e30  # mass that immobilises a mode [kg]
#: Last fields of the ends of a contact that limits no row: lever, arm, row.
NO_ROW = (1.0, 0.0, (NO_TERM, 0.0, NO_TERM, 0.0, 1.0))
#: Corners of a block, along and across its slot, relative to half its sides.
CORNERS = ((1, 1), (-1, 1), (-1, -1), (1, -1))


def without(dofs: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the coordinates that are not among others; for so few, NumPy's `setdiff1d` takes ten times as long."""
    gone = others.tolist()
    return np.array([dof for dof in dofs.tolist() if dof not in gone], dtype=np.int64)


def chained(first: Records, second: Records) -> Records:
    """Concatenate records of one type; NumPy's `concatenate` compares all their fields first."""
    if not len(first) or not len(second):
        return first if len(first) else second
    both: Records = np.empty(len(first) + len(second), first.dtype)
    both[: len(first)], both[len(first) :] = first, second
    return both


@dataclass(frozen=True)
class Edge:
    """A tree joint that carries body `child` on body `parent`; `reversed` if the SDF file has them exchanged."""

    joint: str
    reversed: bool


def joint_ends(joints: Iterable[Joint]) -> Array:
    """Return the places of both ends of each joint in the reference configuration, (np, 2) [m]."""
    return np.array([end for joint in joints for end in (joint.on_parent, joint.on_child)])


def extent_of(ends: Array) -> Array:
    """Compute the diagonal of the box around points (..., np, 2) [m]."""
    return np.asarray(np.linalg.norm(ends.max(axis=-2) - ends.min(axis=-2), axis=-1))


@dataclass(frozen=True)
class Tree:
    """A spanning tree of the mechanism, rooted at the world.

    The world comes first among the bodies, then parents before children. A link that floats on clearance joints, or
    that a joint with clearance and a drive carries, follows two massless bodies; the massless sections of flexible
    links come last. Coordinates have the name of a joint, ``link.x``, ``link.y``, ``link.angle`` of a floating link, or
    names of `linkages.system.spanning.freedoms`; then follow shape coordinates, ``link.bending1``. A link that is not
    divided is its only substructure; else its name in `index` is the body that its joint carries, and the names of the
    other substructures follow.
    """

    mechanism: Mechanism
    bodies: Bodies
    index: dict[str, int]  # body index of each link name, "world" included
    coordinates: tuple[str, ...]  # name of each coordinate
    edges: dict[str, Edge]  # tree joint that carries each link; floating links are absent
    drawn: Array  # origin of each body frame in its link's reference configuration, (nb, 2) [m]
    play: tuple[str, ...]  # clearance joints: cut, or with the coordinates of `freedoms`
    loops: tuple[str, ...]  # ideal joints cut to open the remaining loops
    driven: tuple[str, ...]  # joints with a prescribed motion
    powered: tuple[str, ...]  # joints with an applied torque
    deformable: Mapping[str, Sequence[DeformableBody]]  # substructures of the deformable links, by link
    sections: Mapping[tuple[str, float], int]  # bodies of sections, by substructure and abscissa on its beam [m]
    acting: int  # number of bodies without the unloaded sections at the end, which only outputs read
    coupled: Mapping[str, Coupled] = field(default_factory=dict)  # joints with coupled coordinates, by element
    loose: Mapping[str, Coupled] = field(default_factory=dict)  # the same within a free travel
    wheels: Mapping[str, int] = field(default_factory=dict)  # bodies of the gearboxes' output wheels, by coordinate
    hinges: tuple[str, ...] = ()  # joints between rigid segments of flexible links

    @property
    def name(self) -> str:
        """Return the name of the mechanism."""
        return self.mechanism.name

    @property
    def source(self) -> Path:
        """Return the file of the mechanism, which errors name."""
        return self.mechanism.source

    @property
    def joints(self) -> Mapping[str, Joint]:
        """Return the joints by name, in the reference configuration."""
        return self.mechanism.joint

    @property
    def links(self) -> Mapping[str, Link]:
        """Return the links by name, in the reference configuration; masses and inertias are the bodies'."""
        return self.mechanism.link

    @property
    def frames(self) -> tuple[Frame, ...]:
        """Return the named frames, in the reference configuration."""
        return self.mechanism.frames

    @property
    def points(self) -> Mapping[str, Frame]:
        """Return the frames of links and the named frames, by name."""
        return self.mechanism.point

    @property
    def places(self) -> Mapping[str, Frame]:
        """Return everything with a position, by name: `points`, and joints."""
        return self.mechanism.place

    @property
    def basis(self) -> Array:
        """Return the plane's axes x_P, y_P and its normal in world axes, as columns (3, 3)."""
        return self.mechanism.basis

    def skeleton(self, link: str) -> Skeleton:
        """Return the shape of a link without visuals: its joints and frames, and the bars between them."""
        return skeleton(self.mechanism, self.links[link], self.extent)

    @property
    def size(self) -> int:
        """Return the number of coordinates."""
        return len(self.coordinates)

    @cached_property
    def substructures(self) -> dict[str, DeformableBody]:
        """Return the substructures of all deformable links, by name (the link's name if it is not divided)."""
        return {part.name: part for link in self.deformable.values() for part in link}

    def deformable_at(self, body: int) -> str:
        """Return the deformable link that a body, or the body of a node, belongs to; empty if it is none."""
        record = self.bodies.records[body]
        carrier = int(record["mount"]["body"]) if record["type"] == types.NODE else body
        owned = ((link, part.name) for link, parts in self.deformable.items() for part in parts)
        return next((link for link, part in owned if self.index[part] == carrier), "")

    @cached_property
    def loop_rows(self) -> Records:
        """Return the closure rows of cut ideal joints, then of couplings: reactions along the second joints' terms."""
        return chained(self._rows(self.loops), self._coupled_rows(self.coupled))

    @cached_property
    def closure_rows(self) -> Records:
        """Return the rows that close the whole ideal linkage.

        First come two for each clearance joint, along x_P and y_P, then the loose couplings.
        """
        return chained(chained(self._rows(self.play), self._coupled_rows(self.loose)), self.loop_rows)

    def _coupled_rows(self, pairs: Mapping[str, Coupled]) -> Records:
        rows = [self.coupled_row(*one.joints, one.ratio, one.offset, one.carrier)[0] for one in pairs.values()]
        return np.array(rows, types.ROW)

    def coupled_row(
        self, first: str, second: str, ratio: float, offset: float = 0.0, carrier: str | None = None
    ) -> tuple[tuple[Any, ...], float]:
        """Return the row of second = ratio * first + offset, and the sign of its value along the second."""
        (one, sign), (two, other) = (self.seen_coordinate(name, carrier) for name in (second, first))
        return (one, sign * other * ratio, two, sign * offset, 1.0), sign

    def gaps(self, q: Array) -> Array:
        """Compute the errors (nr,) of the closure rows at coordinates q [m, rad]."""
        return self._values(self.closure_rows, q)

    def joint_coordinates(self, names: Sequence[str], q: Array) -> Array:
        """Compute the coordinates of some joints, of cut ones too, at coordinates q of the tree [rad, m]."""
        terms, signs = zip(*map(self.coordinate, names), strict=True) if names else ((), ())
        return np.array(signs) * self._values(
            np.array([(term, 0.0, NO_TERM, 0.0, 1.0) for term in terms], types.ROW), q
        )

    def _values(self, rows: Records, q: Array) -> Array:
        values = np.empty(len(rows))
        closure_error(self.bodies, rows, np.zeros(len(rows)), q, make_pose(self.bodies), values)
        return values

    def workspace(self, rows: Records) -> Workspace:
        """Make a workspace for this tree and closure rows, all zero."""
        nb, nm = len(self.bodies.records), self.bodies.shapes.shape[2]
        return packed(make_workspace(nb, self.size, len(rows), nm))

    @cached_property
    def contacts(self) -> tuple[tuple[str, str], ...]:
        """Return joint and label of each contact: one per journal, four (corners of the block) per guide."""
        result = []
        for name in self.play:
            if self.mechanism.joint[name].type == "prismatic":
                result += [(name, f"{name}.corner{i + 1}") for i in range(len(CORNERS))]
            else:
                result.append((name, name))
        return tuple(result)

    @property
    def journals(self) -> tuple[str, ...]:
        """Return the clearance joints that are journal bearings."""
        return tuple(name for name, label in self.contacts if name == label)

    @cached_property
    def ends(self) -> Records:
        """Return the records of both ends of each contact."""
        rows = []
        for name in self.play:
            joint = self.mechanism.joint[name]
            bearing = self.marker(joint.parent, joint.on_parent)
            if joint.slot is None:
                journal = self.marker(joint.child, joint.on_child)
                rows.append((types.JOURNAL, bearing, journal, 0.0, 0.0, 0.0, *NO_ROW))
                continue
            along = joint.direction
            across = np.array([-along[1], along[0]])
            for x, y in CORNERS:
                corner = 0.5 * (x * joint.slot.length * along + y * joint.slot.height * across)
                marker = self.marker(joint.child, joint.on_child, corner)
                rows.append((types.CORNER, bearing, marker, *(y * across), 0.5 * joint.slot.height, *NO_ROW))
        return np.array(rows, types.ENDS)

    def joint_records(self, ideal: bool = False) -> Records:
        """Return the records that give each joint force, with clearances, or with every joint ideal."""
        cut = (*self.play, *self.loops) if ideal else self.loops
        contacts = {} if ideal else {name: k for k, (name, _) in reversed(list(enumerate(self.contacts)))}
        rows = accumulate((ROWS[self.mechanism.joint[name].type] for name in cut), initial=0)
        loose = len(self.loose) if ideal else 0
        first = {name: row + (name in self.loops) * loose for name, row in zip(cut, rows, strict=False)}
        carried = {edge.joint: (self.index[link], edge.reversed) for link, edge in self.edges.items()}
        records = []
        for joint in self.mechanism.joints:
            name = joint.name
            body, backwards = carried.get(name, (-1, False))
            if name in contacts:
                source, at = types.OF_JOURNAL if joint.slot is None else types.OF_CORNERS, contacts[name]
            elif name in first:
                source, at = types.OF_ROWS, first[name]
            else:
                source, at = types.OF_TREE, body
            child, parent = self.marker(joint.child, joint.on_child), self._body_at(joint.parent, joint.on_parent)
            records.append((source, TYPES[joint.type], at, backwards, parent, child, *joint.direction.tolist()))
        return np.array(records, types.JOINT)

    def bodies_of(self, dofs: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the body that the joint of each of these coordinates carries."""
        carried = self.bodies.records["dof"].tolist()
        return np.array([carried.index(dof) for dof in dofs.tolist()], dtype=np.int64)

    @cached_property
    def free_dofs(self) -> NDArray[np.int64]:
        """Return the coordinates without prescribed motion, including powered ones."""
        return without(np.arange(self.size), self.driven_dofs)

    @cached_property
    def free_angles(self) -> NDArray[np.int64]:
        """Return the places of the angles of revolute joints among the free coordinates."""
        records = self.bodies.records
        return np.flatnonzero(np.isin(self.free_dofs, records["dof"][records["type"] == types.REVOLUTE]))

    @cached_property
    def joint_dofs(self) -> NDArray[np.int64]:
        """Return the coordinates of joints and floating links, without modes and hinges."""
        count = self.size - len(self.shape_frequencies)
        return np.array([k for k in range(count) if self.coordinates[k] not in self.hinges], dtype=np.int64)

    @cached_property
    def shape_frequencies(self) -> Array:
        """Return the frequency of each shape alone [rad/s]; shape coordinates are the last ones."""
        parts = [part.frequencies for link in self.deformable.values() for part in link]
        return np.concatenate([np.zeros(0), *parts])

    @cached_property
    def hinge_dofs(self) -> NDArray[np.int64]:
        """Return the coordinates of the hinges between rigid segments."""
        return self._dofs(self.hinges)

    def _dofs(self, names: Sequence[str]) -> NDArray[np.int64]:
        wheels = (f"{name}{WHEEL}" for name in names)
        moved = [wheel if wheel in self.wheels else name for name, wheel in zip(names, wheels, strict=True)]
        return np.array([self.coordinates.index(name) for name in moved], dtype=np.int64)

    @cached_property
    def closing_dofs(self) -> NDArray[np.int64]:
        """Return the free coordinates that close loops at a fixed shape of the links."""
        return without(self.joint_dofs, self.driven_dofs)

    def acting_bodies(self, bodies: Bodies) -> Bodies:
        """Return the bodies without unloaded sections."""
        return packed(Bodies(bodies.records[: self.acting], bodies.shapes[: self.acting].view(LaneArray)))

    @cached_property
    def undeforming_bodies(self) -> Bodies:
        """Return the bodies with immobile shapes."""
        return self._with_shape_masses(lambda stiffnesses: _IMMOBILE)

    def stiff_bodies(self, rate: float) -> Bodies:
        """Return the bodies with masses of their shapes increased by stiffness over the square of a rate [rad/s].

        A change that is small relative to the kinetic energy of motions at that rate is then small relative to the
        strain energy too.
        """
        return self._with_shape_masses(lambda stiffnesses: stiffnesses / rate**2)

    def _with_shape_masses(self, added: Callable[[Array], Array | float]) -> Bodies:
        """Return the bodies with added masses of their shapes: a function of the stiffnesses (n, nm)."""
        shapes, bends = self.bodies.shapes.copy(), self.bodies.records["shapes"] > 0
        if not bends.any():
            return self.bodies
        shapes[bends, ELASTIC, :, LOCK] = added(shapes[bends, ELASTIC, :, STIFFNESS])
        return packed(Bodies(self.bodies.records, shapes))

    @cached_property
    def driven_dofs(self) -> NDArray[np.int64]:
        """Return the coordinate of each driven joint, or of its gearbox' output wheel."""
        return self._dofs(self.driven)

    @cached_property
    def powered_dofs(self) -> NDArray[np.int64]:
        """Return the coordinate of each joint with an applied torque."""
        return self._dofs(self.powered)

    @cached_property
    def extent(self) -> float:
        """Return the linkage's length scale: the diagonal of the box around its joints [m].

        Where they coincide, as in a cart with a pendulum, it is the box around joints, frames and mass centres; where
        these coincide too, the largest radius of gyration.
        """
        machine, ends = self.mechanism, joint_ends(self.mechanism.joints)
        frames = [frame.origin for frame in machine.frames if frame.link != "world"]
        boxes = [points for points in (ends, [*ends, *frames, *(link.com for link in machine.links)]) if len(points)]
        radii = [math.sqrt(link.inertia / link.mass) for link in machine.links if link.mass > 0.0]
        sizes = [*(float(extent_of(np.array(points))) for points in boxes), max(radii, default=0.0)]
        return next((size for size in sizes if size > _SAME * max(sizes)), 1.0)

    def marker(self, link: str, point: Array, beside: Array | float = 0.0) -> tuple[int, float, float]:
        """Return the marker (`MARKER`) of a reference point on `link` [m], or `beside` it.

        On a flexible link the section at the point carries it.
        """
        body = self._body_at(link, point)
        (x, y), (x_body, y_body) = (point + beside).tolist(), self._origins[body]
        return body, x - x_body, y - y_body

    def _body_at(self, link: str, point: Array) -> int:
        """Return the body that carries a reference point on a link: the link, or a section of a flexible one."""
        if link in self.deformable:
            return self.sections[section_at(self.deformable[link], point)]
        return self.index[link]

    @cached_property
    def _origins(self) -> list[list[float]]:
        return self.drawn.tolist()

    def ends_of(self, link: str) -> tuple[int, int]:
        """Return the bodies of the nodes at the first and last end of a deformable link."""
        parts = sorted(self.deformable[link], key=lambda part: part.first + part.ends[0])
        ends = (parts[0], parts[0].ends[0]), (parts[-1], parts[-1].ends[1])
        first, last = (self.sections[part.name, part.nearest(end)] for part, end in ends)
        return first, last

    def named_marker(self, name: str) -> tuple[int, float, float]:
        """Return the marker of the origin of a link or frame, or of a joint's place on its child."""
        point = self.mechanism.place[name]
        return self.marker(point.link, point.origin)

    def marker_of(self, point: Point) -> tuple[int, float, float]:
        """Return the marker of the origin of a link or frame, or of a fixed point in plane axes."""
        return self.named_marker(point) if isinstance(point, str) else (0, float(point[0]), float(point[1]))

    def angle_of(self, point: str) -> float:
        """Return the angle of a frame in the body of its link [rad]."""
        return self.mechanism.point[point].angle

    def coordinate_of(self, joint: str | None, links: Iterable[str]) -> tuple[tuple[Any, ...], float]:
        """Return the term of a joint's coordinate, or of the angle of the second of two links, and its sign."""
        if joint is not None:
            return self.coordinate(joint)
        ends = ((0, 0.0, 0.0) if link == "world" else self.named_marker(link) for link in links)
        return (types.ANGLE, *ends, 0.0, 0.0), 1.0

    def coordinate(self, name: str) -> tuple[tuple[Any, ...], float]:
        """Return the term (`TERM`) of the coordinate of a joint or a gearbox' output wheel, and its sign."""
        joint = self.mechanism.joint[name.removesuffix(WHEEL)]
        ends = self.marker(joint.parent, joint.on_parent), self.marker(joint.child, joint.on_child)
        if name in self.wheels:
            ends = ends[0], (self.wheels[name], 0.0, 0.0)
        if joint.type == "prismatic":
            return (types.ALONG_BODY, *ends, *joint.direction), 1.0
        return (types.ANGLE, *ends, 0.0, 0.0), joint.sign

    def seen_coordinate(self, name: str, carrier: str | None) -> tuple[tuple[Any, ...], float]:
        """Return the term of a joint's coordinate as seen from a carrier, and its sign.

        It is the joint's own coordinate if there is no carrier, or the joint joins it; else the angle of the joint's
        child (its parent, if the child is the world) from the carrier.
        """
        (kind, inner, outer, *rest), sign = self.coordinate(name)
        joint = self.mechanism.joint[name.removesuffix(WHEEL)]
        if carrier is None or carrier in (joint.parent, joint.child):
            return (kind, inner, outer, *rest), sign
        place = self.mechanism.point[carrier].origin if carrier != "world" else joint.on_parent
        seat = self.marker(carrier, place)
        if joint.child == "world":
            return (kind, seat, inner, *rest), -sign
        return (kind, seat, outer, *rest), sign

    def signal(self, name: str) -> tuple[Any, ...]:
        """Return the `linkages.mechanics.planar.record_types.SIGNAL` record of a position or speed, as ``slider.x``."""
        owner, _, part = name.rpartition(".")
        if part in OF_JOINTS:
            term, scale = self.coordinate(owner)
            return term, scale, 0.0, part == "rate"
        ends, rate = ((0, 0.0, 0.0), self.named_marker(owner)), part in ("vx", "vy", "omega")
        if part in ("angle", "omega"):
            return (types.ANGLE, *ends, 0.0, 0.0), 1.0, -self.mechanism.point[owner].angle, rate
        x_axis = float(part in ("x", "vx"))
        return (types.ALONG_WORLD, *ends, x_axis, 1.0 - x_axis), 1.0, 0.0, rate

    def _rows(self, names: Sequence[str]) -> Records:
        rows: list[tuple[Any, ...]] = []
        for name in names:
            joint = self.mechanism.joint[name]
            # a fixed joint keeps the relative pose of the reference configuration, whatever its frames
            on_parent = joint.on_child if joint.type == "fixed" else joint.on_parent
            ends = self.marker(joint.parent, on_parent), self.marker(joint.child, joint.on_child)
            if joint.type == "prismatic":
                across = (-joint.direction[1], joint.direction[0])
                rows += [(types.ALONG_BODY, *ends, *across), (types.ANGLE, *ends, 0.0, 0.0)]
            else:
                rows += [(types.ALONG_WORLD, *ends, 1.0, 0.0), (types.ALONG_WORLD, *ends, 0.0, 1.0)]
            if joint.type == "fixed":
                rows.append((types.ANGLE, *ends, 0.0, 0.0))
        return np.array([(row, 0.0, NO_TERM, 0.0, 1.0) for row in rows], types.ROW)
