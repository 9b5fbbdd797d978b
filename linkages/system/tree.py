"""Spanning tree of a mechanism: which joints carry the bodies, which are cut, what the coordinates are."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError
from linkages.files.raw_model import Chains
from linkages.model.mechanism import Joint, Mechanism
from linkages.planar import record_types as types

Array = NDArray[np.float64]

#: Closure rows of a cut joint.
ROWS = {"fixed": 3, "revolute": 2, "prismatic": 2}
_TYPE = {"fixed": types.FIXED, "revolute": types.REVOLUTE, "prismatic": types.PRISMATIC}
_MOVING = list(types.BODY.names or ()).index("moving")
#: Corners of a block, along and across its slot, in units of half its sides.
CORNERS = ((1, 1), (-1, 1), (-1, -1), (1, -1))


@dataclass(frozen=True)
class Edge:
    """A joint of the tree that carries body `child` from body `parent`; `reversed` if the SDF has it the other way."""

    joint: str
    reversed: bool


@dataclass(frozen=True)
class Tree:
    """A spanning tree of the mechanism, rooted at the world.

    Attributes
    ----------
    bodies : array of BODY
        World first, then parents before children. Links that float on clearance joints alone stand
        behind two massless bodies, their x and y slides.
    index : dict
        Body index of each link name, "world" included.
    coordinates : tuple of str
        Name of each coordinate: a joint's name, or ``link.x``, ``link.y``, ``link.angle`` of a floating link.
    edges : dict
        Tree joint that carries each link; floating links are absent.
    drawn : (nb, 2) array
        Origin of each body frame in the drawn configuration of its own link [m].
    play : tuple of str
        Clearance joints, always cut.
    loops : tuple of str
        Ideal joints that are cut to open the remaining loops.
    driven : tuple of str
        Joints with a prescribed motion.
    powered : tuple of str
        Joints with an applied torque.
    """

    mechanism: Mechanism
    bodies: NDArray[np.record]
    index: dict[str, int]
    coordinates: tuple[str, ...]
    edges: dict[str, Edge]
    drawn: Array
    play: tuple[str, ...]
    loops: tuple[str, ...]
    driven: tuple[str, ...]
    powered: tuple[str, ...]

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    @cached_property
    def play_rows(self) -> NDArray[np.record]:
        """Closure rows of the clearance joints, two each: the journal's offset along x_P and y_P."""
        return self._rows(self.play)

    @cached_property
    def loop_rows(self) -> NDArray[np.record]:
        """Closure rows of the cut ideal joints."""
        return self._rows(self.loops)

    @cached_property
    def closure_rows(self) -> NDArray[np.record]:
        """Rows that close the whole ideal linkage: those of the clearance joints first."""
        return np.concatenate([self.play_rows, self.loop_rows])

    @cached_property
    def contacts(self) -> tuple[tuple[str, str], ...]:
        """Joint and label of each contact: one for a journal, four (the corners of its block) for a guide."""
        result = []
        for name in self.play:
            if self.mechanism.joint[name].type == "prismatic":
                result += [(name, f"{name}.corner{i + 1}") for i in range(len(CORNERS))]
            else:
                result.append((name, name))
        return tuple(result)

    @property
    def journals(self) -> tuple[str, ...]:
        """Clearance joints that are journals in bearings."""
        return tuple(name for name, label in self.contacts if name == label)

    @cached_property
    def ends(self) -> NDArray[np.record]:
        """The two ends of each contact."""
        rows = []
        for name in self.play:
            joint = self.mechanism.joint[name]
            bearing = self.marker(joint.parent, joint.on_parent)
            if joint.slot is None:
                rows.append((types.JOURNAL, bearing, self.marker(joint.child, joint.on_child), 0.0, 0.0, 0.0))
                continue
            along = joint.direction
            across = np.array([-along[1], along[0]])
            for x, y in CORNERS:
                corner = 0.5 * (x * joint.slot.length * along + y * joint.slot.height * across)
                marker = self.marker(joint.child, joint.on_child + corner)
                rows.append((types.CORNER, bearing, marker, *(y * across), 0.5 * joint.slot.height))
        return np.array(rows, types.ENDS)

    @cached_property
    def joints(self) -> NDArray[np.record]:
        """Where the force in each of the mechanism's joints comes from, with play where there is."""
        first = {name: k for k, (name, _) in reversed(list(enumerate(self.contacts)))}
        return self._joints(self.loops, first)

    @cached_property
    def ideal_joints(self) -> NDArray[np.record]:
        """The same with every joint ideal, closed by `closure_rows`."""
        return self._joints((*self.play, *self.loops), {})

    def _joints(self, cut: Sequence[str], contacts: Mapping[str, int]) -> NDArray[np.record]:
        rows = np.cumsum([0, *(ROWS[self.mechanism.joint[name].type] for name in cut)])
        first = dict(zip(cut, rows.tolist(), strict=False))
        carried = {edge.joint: (self.index[link], edge.reversed) for link, edge in self.edges.items()}
        records = []
        for joint in self.mechanism.joints:
            name, backwards = joint.name, False
            if name in contacts:
                source, at = types.OF_JOURNAL if joint.slot is None else types.OF_CORNERS, contacts[name]
            elif name in first:
                source, at = types.OF_ROWS, first[name]
            else:
                source, (at, backwards) = types.OF_TREE, carried[name]
            child, parent = self.marker(joint.child, joint.on_child), self.index[joint.parent]
            records.append((source, _TYPE[joint.type], at, backwards, parent, child, *joint.direction))
        return np.array(records, types.JOINT)

    @cached_property
    def driven_bodies(self) -> NDArray[np.int64]:
        """Body that each driven joint carries."""
        return self._bodies_of(self.driven_dofs)

    @cached_property
    def powered_bodies(self) -> NDArray[np.int64]:
        """Body that each powered joint carries."""
        return self._bodies_of(self.powered_dofs)

    def _bodies_of(self, dofs: NDArray[np.int64]) -> NDArray[np.int64]:
        return np.array([np.flatnonzero(self.bodies["dof"] == dof)[0] for dof in dofs], dtype=np.int64)

    @cached_property
    def free_dofs(self) -> NDArray[np.int64]:
        """Coordinates that no drive prescribes, powered ones among them."""
        return np.setdiff1d(np.arange(self.size), self.driven_dofs)

    @cached_property
    def driven_dofs(self) -> NDArray[np.int64]:
        """Coordinate of each driven joint."""
        return np.array([self.coordinates.index(name) for name in self.driven], dtype=np.int64)

    @cached_property
    def powered_dofs(self) -> NDArray[np.int64]:
        """Coordinate of each joint with an applied torque."""
        return np.array([self.coordinates.index(name) for name in self.powered], dtype=np.int64)

    @cached_property
    def extent(self) -> float:
        """Length scale of the linkage: the diagonal of the box around its drawn joints [m]."""
        points = [point for joint in self.mechanism.joints for point in (joint.on_parent, joint.on_child)]
        return float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0 if points else 1.0

    def marker(self, link: str, point: Array) -> tuple[int, float, float]:
        """Marker (a record of `linkages.planar.record_types.MARKER`) of a point drawn on `link` [m]."""
        body = self.index[link]
        x, y = point - self.drawn[body]
        return body, float(x), float(y)

    def named_marker(self, name: str) -> tuple[int, float, float]:
        """Marker of a link's or frame's origin."""
        point = self.mechanism.point[name]
        return self.marker(point.link, point.origin)

    def _rows(self, names: Sequence[str]) -> NDArray[np.record]:
        rows = []
        for name in names:
            joint = self.mechanism.joint[name]
            # a fixed joint keeps the drawn relative pose, whatever frames it was written with
            on_parent = joint.on_child if joint.type == "fixed" else joint.on_parent
            ends = self.marker(joint.parent, on_parent), self.marker(joint.child, joint.on_child)
            if joint.type == "prismatic":
                across = (-joint.direction[1], joint.direction[0])
                rows += [(types.ALONG_BODY, *ends, *across), (types.ANGLE, *ends, 0.0, 0.0)]
            else:
                rows += [(types.ALONG_WORLD, *ends, 1.0, 0.0), (types.ALONG_WORLD, *ends, 0.0, 1.0)]
            if joint.type == "fixed":
                rows.append((types.ANGLE, *ends, 0.0, 0.0))
        return np.array(rows, types.ROW)


def spanning_tree(
    mechanism: Mechanism, play: Collection[str] = (), driven: Sequence[str] = (), powered: Sequence[str] = ()
) -> Tree:
    """Build the tree: clearance joints are cut first, then the fewest ideal joints that open all loops.

    Fixed joints and driven joints stay in the tree, so that a drive acts on a coordinate. Play, driven and
    powered are names of joints, as in `Tree`.

    Raises
    ------
    InputError
        If the driven and powered joints alone already close a loop.
    """
    carried = Chains(mechanism.link)

    def priority(joint: Joint) -> int:
        return [joint.type == "fixed", joint.name in driven, joint.name in powered, True].index(True)

    kept, loops = [], set()
    for joint in sorted((j for j in mechanism.joints if j.name not in play), key=priority):
        if carried.join(joint):
            kept.append(joint)
            continue
        loops.add(joint.name)
        if joint.name in driven or joint.name in powered:
            problem = "is driven, and closes a loop of driven and fixed joints only; drive fewer joints"
            raise InputError(mechanism.source, f'<joint name="{joint.name}">', problem)
    builder = _Builder(mechanism, tuple(driven), kept)
    builder.grow("world")
    for link in mechanism.link:
        if link not in builder.index:
            builder.add_floating(link)
            builder.grow(link)
    return Tree(
        mechanism,
        np.array(builder.rows, types.BODY),
        builder.index,
        tuple(builder.coordinates),
        builder.edges,
        np.array(builder.drawn),
        tuple(name for name in mechanism.joint if name in play),
        tuple(name for name in mechanism.joint if name in loops),
        tuple(driven),
        tuple(powered),
    )


class _Builder:
    """Collects the bodies of a tree while it grows from its root."""

    def __init__(self, mechanism: Mechanism, driven: tuple[str, ...], joints: Sequence[Joint]) -> None:
        self.mechanism = mechanism
        self.driven = driven
        self.joints = joints
        self.rows: list[tuple[Any, ...]] = [((-1, 0.0, 0.0), types.FIXED, -1, -1, 0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)]
        self.index = {"world": 0}
        self.drawn = [np.zeros(2)]
        self.coordinates: list[str] = []
        self.edges: dict[str, Edge] = {}

    def grow(self, start: str) -> None:
        front = [start]
        for inner in front:  # which becomes longer meanwhile
            for joint in self.joints:
                if inner not in (joint.parent, joint.child):
                    continue
                outer = joint.child if inner == joint.parent else joint.parent
                if outer not in self.index:
                    self._attach(joint, inner, outer)
                    front.append(outer)

    def add_floating(self, name: str) -> None:
        """Add a link on clearance joints alone: x and y slides and a turn at its mass centre, from the world."""
        com, none = self.mechanism.link[name].com, np.zeros(2)
        x_slide, y_slide = len(self.rows), len(self.rows) + 1
        self._add(f"{name}.x", 0, types.PRISMATIC, 1.0, com, np.array([1.0, 0.0]), com, "")
        self._add(f"{name}.y", x_slide, types.PRISMATIC, 1.0, none, np.array([0.0, 1.0]), com, "")
        self._add(f"{name}.angle", y_slide, types.REVOLUTE, 1.0, none, none, com, name)

    def _attach(self, joint: Joint, inner: str, outer: str) -> None:
        backwards = inner == joint.child
        self.edges[outer] = Edge(joint.name, backwards)
        on_outer = joint.on_parent if backwards and joint.type != "fixed" else joint.on_child
        on_inner = joint.on_parent if not backwards and joint.type != "fixed" else joint.on_child
        sign, parent = -1.0 if backwards else 1.0, self.index[inner]
        at, axis = on_inner - self.drawn[parent], sign * joint.direction
        self._add(joint.name, parent, _TYPE[joint.type], sign * joint.sign, at, axis, on_outer, outer)

    def _add(
        self, name: str, parent: int, kind: int, sign: float, at: Array, axis: Array, drawn: Array, link: str
    ) -> None:
        """Add a body, massless if it is no link, and the joint at `at` on its parent that carries it."""
        dof = -1
        if kind != types.FIXED:
            dof = len(self.coordinates)
            self.coordinates.append(name)
        motion = self.driven.index(name) if name in self.driven else -1
        mass, com, inertia = 0.0, np.zeros(2), 0.0
        if link:
            body = self.mechanism.link[link]
            mass, com, inertia = body.mass, body.com - drawn, body.inertia
            self.index[link] = len(self.rows)
        moving = bool(self.rows[parent][_MOVING]) or (dof >= 0 and motion < 0)
        self.rows.append(((parent, *at), kind, dof, motion, moving, sign, *axis, mass, *com, inertia))
        self.drawn.append(np.array(drawn))
