"""Construction of the spanning tree: its joints, the order of its bodies, sections of flexible links."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array, Records
from linkages.base.errors import InputError
from linkages.base.kernel.by_reference import packed
from linkages.base.kernel.simd import lane_array
from linkages.elements.coordinates import WHEEL
from linkages.input.files.raw_model import Chains
from linkages.input.model.mechanism import Joint, Mechanism
from linkages.mechanics.planar import record_types as types
from linkages.mechanics.planar.bodies import MATRIX, STRAIGHT, Bodies
from linkages.system.deformable import DeformableBody, section_at
from linkages.system.tree import TYPES, Edge, Tree

#: Values of a body's record that differ from zero or are no numbers, where it does not say others.
_USUAL = dict.fromkeys(types.BODY.names or (), 0) | {"dof": -1, "driven": -1, "sign": 1.0}

#: Functions that divide flexible links, by name, for the joints that carry them.
Bend = Mapping[str, Callable[[Joint | None], Sequence[DeformableBody]]]


class Freedom(NamedTuple):
    """A coordinate of a joint in the tree."""

    name: str
    type: int
    sign: float  # of a rotation, counter-clockwise positive
    axis: Array  # direction of a displacement, (2,)


def freedoms(joint: Joint, backwards: bool, loose: bool) -> list[Freedom]:
    """List the coordinates of a joint; each moves relative to the one before, the first relative to the inner link.

    The inner link is the parent, or if `backwards` the child. A `loose` joint has clearance and a drive. If it is
    revolute, its drive turns the child, whose place is free in the bearing: x and y in axes of the inner link. If it is
    prismatic, its drive moves the child along the slot, in which the block's place across and its angle are free.
    """
    way, name = -1.0 if backwards else 1.0, joint.name
    along = Freedom(name, TYPES[joint.type], way * joint.sign, way * joint.direction)
    if not loose:
        return [along]
    if joint.type == "revolute":
        slides = zip("xy", way * np.eye(2), strict=True)
        return [*(Freedom(f"{name}.{letter}", types.PRISMATIC, 1.0, axis) for letter, axis in slides), along]
    across = Freedom(f"{name}.across", types.PRISMATIC, 1.0, way * np.array([-joint.direction[1], joint.direction[0]]))
    found = [along, across, Freedom(f"{name}.angle", types.REVOLUTE, way, np.zeros(2))]
    return found[::-1] if backwards else found


def spanning_tree(
    mechanism: Mechanism,
    play: Collection[str] = (),
    driven: Sequence[str] = (),
    powered: Sequence[str] = (),
    bend: Bend | None = None,
    wheels: Mapping[str, float] | None = None,
) -> Tree:
    """Build the tree: clearance joints are cut first, then the fewest ideal joints that open all loops.

    Fixed joints and driven joints stay in the tree, with clearance too, so that a drive acts on a coordinate. `play`,
    `driven` and `powered` are names of joints, as in `Tree`. A drive in `wheels` has a gearbox with backlash, whose
    output wheel has this inertia [kg m2]: it acts on the coordinate of the wheel, and its joint is free. A flexible
    link is divided once its carrying joint is known. InputError if the driven and powered joints alone already close
    a loop.
    """
    wheels, every = wheels or {}, (tuple(driven), tuple(powered))
    driven, powered = (tuple(name for name in names if name not in wheels) for names in every)
    cut = {*play} - {*driven, *powered}
    joints = tuple((j.name, j.parent, j.child, j.type == "fixed") for j in mechanism.joints if j.name not in cut)
    kept, loops = _opened(tuple(mechanism.link), joints, driven, powered)
    for name in loops:
        if name in driven or name in powered:
            problem = "is driven, and closes a loop of driven and fixed joints only; drive fewer joints"
            raise InputError(mechanism.source, f'<joint name="{name}">', problem)
    moved = tuple(f"{name}{WHEEL}" if name in wheels else name for name in every[0])
    builder = _Builder(mechanism, play, moved, [mechanism.joint[name] for name in kept], bend or {})
    builder.grow("world")
    for link in mechanism.link:
        if link not in builder.index:
            builder.add_floating(link)
            builder.grow(link)
    for name, inertia in wheels.items():
        builder.add_wheel(mechanism.joint[name], inertia)
    bodies = builder.bodies()
    return Tree(
        mechanism,
        bodies,
        builder.index,
        tuple(builder.coordinates),
        builder.edges,
        np.array(builder.drawn),
        tuple(name for name in mechanism.joint if name in play),
        tuple(name for name in mechanism.joint if name in loops),
        *every,
        builder.deformable,
        builder.sections,
        builder.acting,
        wheels=builder.wheels,
    )


@lru_cache(maxsize=16)  # variants of a mechanism have the same links and joints
def _opened(
    links: tuple[str, ...],
    joints: tuple[tuple[str, str, str, bool], ...],
    driven: tuple[str, ...],
    powered: tuple[str, ...],
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Find the joints of the tree, and the joints to cut; each is given by name, its two links, whether it is fixed."""
    carried = Chains(links)
    kept: list[str] = []
    loops: list[str] = []
    rank = {name: [fixed, name in driven, name in powered, True].index(True) for name, _, _, fixed in joints}
    for name, parent, child, _ in sorted(joints, key=lambda joint: rank[joint[0]]):
        (kept if carried.join(parent, child) else loops).append(name)
    return tuple(kept), tuple(loops)


class _Builder:
    """Collects the bodies of a tree while it grows from its root."""

    def __init__(
        self, mechanism: Mechanism, play: Collection[str], driven: tuple[str, ...], joints: Sequence[Joint], bend: Bend
    ) -> None:
        self.mechanism, self.play, self.driven, self.bend = mechanism, play, driven, bend
        self.wheels: dict[str, int] = {}
        self.beside: dict[str, list[Joint]] = defaultdict(list)  # joints by each of their links
        for joint in joints:
            self.beside[joint.parent].append(joint)
            self.beside[joint.child].append(joint)
        self.deformable: dict[str, Sequence[DeformableBody]] = {}
        self.substructures: dict[str, DeformableBody] = {}
        self.sections: dict[tuple[str, float], int] = {}
        self.rows: list[dict[str, Any]] = []
        self.acting = 0
        self._row(-1, np.zeros(2), type=types.FIXED)
        self.index = {"world": 0}
        self.drawn = [np.zeros(2)]
        self.coordinates: list[str] = []
        self.edges: dict[str, Edge] = {}

    def grow(self, start: str) -> None:
        front = [start]
        for inner in front:  # grows during the iteration
            for joint in self.beside[inner]:
                outer = joint.child if inner == joint.parent else joint.parent
                if outer not in self.index:
                    self._attach(joint, inner, outer)
                    front.append(outer)

    def add_floating(self, name: str) -> None:
        """Add a link held by clearance joints alone: two prismatic joints and a revolute one at its mass centre."""
        com, none = self.mechanism.link[name].com, np.zeros(2)
        if name in self.bend:
            com = self._cut(name, None).origin
        x_slide, y_slide = len(self.rows), len(self.rows) + 1
        self._add(f"{name}.x", 0, types.PRISMATIC, 1.0, com, np.array([1.0, 0.0]), com, "")
        self._add(f"{name}.y", x_slide, types.PRISMATIC, 1.0, none, np.array([0.0, 1.0]), com, "")
        self._add(f"{name}.angle", y_slide, types.REVOLUTE, 1.0, none, none, com, name)

    def add_wheel(self, joint: Joint, inertia: float) -> None:
        """Add the output wheel of a gearbox with backlash, which turns about the joint on its parent."""
        parent, place = self.index[joint.parent], joint.on_parent
        if joint.parent in self.deformable:
            parent = self.sections[section_at(self.deformable[joint.parent], place)]
        at, name = place - self.drawn[parent], f"{joint.name}{WHEEL}"
        self._add(name, parent, types.REVOLUTE, joint.sign, at, np.zeros(2), place, "")
        self.wheels[name] = len(self.rows) - 1
        self.rows[-1]["inertia"] = inertia

    def _cut(self, link: str, carrier: Joint | None) -> DeformableBody:
        """Divide a flexible link into substructures; return the one that the joint carries."""
        self.deformable[link] = self.bend[link](carrier)
        self.substructures |= {part.name: part for part in self.deformable[link]} | {link: self.deformable[link][0]}
        return self.substructures[link]

    def _attach(self, joint: Joint, inner: str, outer: str) -> None:
        backwards = inner == joint.child
        self.edges[outer] = Edge(joint.name, backwards)
        on_outer = joint.on_parent if backwards and joint.type != "fixed" else joint.on_child
        on_inner = joint.on_parent if not backwards and joint.type != "fixed" else joint.on_child
        parent = self.index[inner]
        if inner in self.deformable:
            parent = self.sections[section_at(self.deformable[inner], on_inner)]
        if outer in self.bend:
            self._cut(outer, joint)
        at = on_inner - self.drawn[parent]
        for one in (chain := freedoms(joint, backwards, joint.name in self.play)):
            self._add(one.name, parent, one.type, one.sign, at, one.axis, on_outer, outer if one is chain[-1] else "")
            parent, at = len(self.rows) - 1, np.zeros(2)

    def _add(
        self, name: str, parent: int, kind: int, sign: float, at: Array, axis: Array, drawn: Array, link: str
    ) -> None:
        """Add a body (massless unless it is a link or substructure) and its carrying joint at `at` on the parent."""
        dof = -1
        if kind != types.FIXED:
            dof = len(self.coordinates)
            self.coordinates.append(name)
        motion = self.driven.index(name) if name in self.driven else -1
        moving = bool(self.rows[parent]["moving"]) or (dof >= 0 and motion < 0)
        row: dict[str, Any] = {"type": kind, "dof": dof, "driven": motion, "sign": sign, "ux": axis[0], "uy": axis[1]}
        part = self.substructures.get(link)
        if link:
            body = part.rod if part else self.mechanism.link[link]
            cx, cy = body.com - drawn
            row |= {"mass": body.mass, "cx": cx, "cy": cy, "inertia": body.inertia}
            self.index[link] = len(self.rows)
        if part:
            ex, ey = part.direction
            row |= {"shapes": part.size, "bends": part.bends, "ex": ex, "ey": ey}
            moving = moving or part.size > 0
        self._row(parent, at, moving=moving, **row)
        self.drawn.append(np.array(drawn))
        if part:
            self._add_sections(part)
        for part in self.deformable.get(link, ())[1:]:  # fixed to the ends of their carriers
            parent = self.sections[section_at([self.substructures[part.carrier]], part.origin)]
            at = part.origin - self.drawn[parent]
            self._add("", parent, types.FIXED, 1.0, at, np.zeros(2), part.origin, part.name)

    def _add_sections(self, part: DeformableBody) -> None:
        """Add the loaded massless sections of a substructure; `bodies` adds the others."""
        self.index[part.name] = len(self.rows) - 1
        for s in part.abscissas:
            self.sections[part.name, s] = self.index[part.name]
            if s in part.acting and part.moves(s):
                self._add_section(part, s)

    def _add_section(self, part: DeformableBody, s: float) -> None:
        self.sections[part.name, s] = len(self.rows)
        ux, uy = part.direction
        self._row(self.index[part.name], s * part.direction, type=types.NODE, moving=1, ux=ux, uy=uy)
        self.drawn.append(part.origin + s * part.direction)

    def _row(self, parent: int, at: Array, **values: Any) -> None:
        """Add a record of `linkages.mechanics.planar.record_types.BODY`, mounted at a place on its parent."""
        if self.rows:
            self.rows[parent]["carries"] = 1
        self.rows.append(_USUAL | {"mount": (parent, *at)} | values)

    def bodies(self) -> Bodies:
        """Return all bodies; assigns the shape coordinates after the joint coordinates.

        A section that never moves relative to its link's frame is the link itself.
        """
        self.acting = len(self.rows)
        for name, s in list(self.sections):
            if s not in self.substructures[name].acting and self.substructures[name].moves(s):
                self._add_section(self.substructures[name], s)
                self.rows[-1]["detached"] = 1
        substructures = [part for link in self.deformable.values() for part in link]
        nm = max((part.size for part in substructures), default=0)
        shapes = lane_array(len(self.rows), MATRIX + nm, nm)
        for part in substructures:
            body = self.index[part.name]
            row = self.rows[body]
            row["eta"] = len(self.coordinates)
            self.coordinates += part.coordinates
            part.fill(shapes[body])
            along = row["cx"] * row["ex"] + row["cy"] * row["ey"]
            shapes[body, STRAIGHT, 0] = along, 0.0, np.sqrt(row["inertia"] / row["mass"]), 0.0
            for s in part.abscissas:
                if self.sections[part.name, s] != body:
                    part.fill_section(s, shapes[self.sections[part.name, s]])
        records: Records = np.array([tuple(row.values()) for row in self.rows], types.BODY)
        return packed(Bodies(records, shapes))
