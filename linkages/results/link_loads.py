"""Balanced loads of each link at an instant: joints, drives, applied loads, contacts, weight and inertia.

All act on the link; inertia is a force against the acceleration (d'Alembert), so their sums are zero. The opposite
force of a joint acts on its other link at the same place, for a journal with clearance at the journal's centre.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.flexible.inertia import Moved, inertia_at_nodes
from linkages.elements.flexible.substructure import Substructure
from linkages.elements.machine import add_elements, apart, elements_of, markers_of
from linkages.input.files.raw_model import LinkBeam
from linkages.mechanics.planar.arrays import functions_of
from linkages.mechanics.planar.closure_rows import add_row_wrench
from linkages.mechanics.planar.loads import load_wrenches
from linkages.mechanics.planar.markers import arm, turned
from linkages.mechanics.planar.newton_euler import inertial_forces
from linkages.mechanics.planar.reactions import add_known_contacts
from linkages.mechanics.planar.record_types import OF_ROWS, PRISMATIC, REVOLUTE
from linkages.results.outputs.evaluation import make_snapshot, tabulate
from linkages.results.outputs.quantity import Snapshot
from linkages.results.outputs.registry import pack
from linkages.system import System

#: Coordinates, rates, accelerations (n,) and contacts (nc, WIDTH) at an instant.
State = tuple[Array, Array, Array, Array]


@dataclass(frozen=True)
class Load:
    """A force [N] and a moment about its place [N m]; in the axes of the link it acts on."""

    name: str  # of the joint, drive, load, contact or gear; "weight", "inertia", "node"
    x: float  # [m]
    y: float
    fx: float
    fy: float
    moment: float


class Field(NamedTuple):
    """Acceleration field of a body, as gravity and a centrifugal load describe it."""

    x: float  # of the axis [m]
    y: float
    gx: float  # gravity less the acceleration of the axis [m/s2]
    gy: float
    square: float  # square of the angular velocity [rad2/s2]


@dataclass(frozen=True)
class Part:
    """A beam, or a substructure of one, with weight and inertia as forces at nodes, in the axes of the link."""

    field: Field
    nodes: Array  # places of the deformed axis, (nn, 2) [m]
    forces: Array  # weight and inertia, (nn, 2) [N]
    others: Array  # the same without those of the field, (nn, 2) [N]


@dataclass(frozen=True)
class LinkLoads:
    """All loads of a link at an instant, in its axes: origin and x axis of the link's frame."""

    link: str
    loads: tuple[Load, ...]
    field: Field  # about the mass centre; of a deformable link see `parts`
    parts: tuple[Part, ...]  # empty for a rigid link
    size: float  # of the linkage [m]
    beam: LinkBeam | None = None  # of a deformable link

    @property
    def sums(self) -> Array:
        """Return the sums of forces [N], and of moments about the origin [N m]: zero but for rounding."""
        rows = [(one.fx, one.fy, one.x * one.fy - one.y * one.fx + one.moment) for one in self.loads]
        return np.asarray(np.sum(rows, axis=0))

    @property
    def largest(self) -> float:
        """Return the largest force, or moment over the linkage's length [N]."""
        return max(max(np.hypot(one.fx, one.fy), abs(one.moment) / self.size) for one in self.loads)

    @property
    def imbalance(self) -> float:
        """Return the largest sum, of moments over the linkage's length, in parts of the largest load."""
        return float(np.abs(self.sums / (1.0, 1.0, self.size)).max() / (self.largest or 1.0))


def link_loads(system: System, time: float, state: State) -> dict[str, LinkLoads]:
    """Compute the loads of all links but the ground at a time [s] and state, by link."""
    seen = _snapshot(system, time, state)
    owners = _owners(system, seen)
    found: dict[str, list[tuple[str, Array, Array, float]]] = {link: [] for link in owners.values()}
    for name, body, place, force, moment in (
        *_in_joints(system, seen), *_of_drives(system, seen), *_applied(system, seen, time)
    ):  # fmt: skip
        found[owners[body]].append((name, place, force, moment))
    needed = _needed(seen)
    return {
        link: _of_link(system, seen, link, found[link], needed)
        for link in system.links
        if link in found and link != "world"
    }


def _snapshot(system: System, time: float, state: State) -> Snapshot:
    """Compute motion, contacts and forces at an instant."""
    seen = make_snapshot(system.arrays, len(state[0]))
    numbers = (np.ascontiguousarray(part[None], dtype=np.float64) for part in state)
    tabulate(pack(system, ()), True, seen, np.array([time]), *numbers, np.empty((0, 1)))  # type: ignore[call-arg]
    return seen


def _owners(system: System, seen: Snapshot) -> dict[int, str]:
    """Return the link of each body, of nodes of deformable ones too."""
    tree = system.tree
    owners = {body: tree.deformable_at(body) or name for name, body in tree.index.items()}
    owners |= {body: name for name, body in tree.wheels.items()}
    nodes = ((i, tree.deformable_at(i)) for i in range(len(seen.model.bodies.records)) if i not in owners)
    return owners | {i: link for i, link in nodes if link}


_Action = tuple[str, int, Array, Array, float]  # name, body, place, force, moment about the place


def _in_joints(system: System, seen: Snapshot) -> Iterator[_Action]:
    """Yield the force on both links of each joint."""
    for joint, record, (fx, fy, moment) in zip(
        system.joints.values(), seen.model.joints, seen.forces.tolist(), strict=True
    ):
        force, place = np.array([fx, fy]), _place(seen, record["child"])
        parent, opposite = int(record["parent"]), place
        if record["source"] == OF_ROWS and record["type"] == REVOLUTE:  # its rows act at both ends
            opposite = _place(seen, np.array(system.tree.marker(joint.parent, joint.on_parent), record["child"].dtype))
        yield joint.name, int(record["child"]["body"]), place, force, moment
        yield joint.name, parent, opposite, -force, -moment


def _of_drives(system: System, seen: Snapshot) -> Iterator[_Action]:
    """Yield the effort of each drive on both links of its joint."""
    names = [joint.name for joint in system.joints.values()]
    drives = (*system.tree.driven, *system.tree.powered)
    bodies = (*seen.model.driven_bodies, *seen.model.powered_bodies)
    for name, carried, effort in zip(drives, bodies, seen.efforts.tolist(), strict=True):
        record, body = seen.model.joints[names.index(name)], seen.model.bodies.records[carried]
        place, force, moment = _place(seen, record["child"]), np.zeros(2), float(body["sign"]) * effort
        if record["type"] == PRISMATIC:
            mount = int(body["mount"]["body"])
            force, moment = effort * np.array(turned(seen.state.pose, mount, body["ux"], body["uy"])), 0.0
        ends = int(record["child"]["body"]), int(record["parent"])
        outer, inner = reversed(ends) if record["reversed"] else ends
        if name in system.wheels:
            outer, inner = int(carried), int(record["parent"])
        yield name, outer, place, force, moment
        yield name, inner, place, -force, -moment


def _applied(system: System, seen: Snapshot, time: float) -> Iterator[_Action]:
    """Yield the forces of applied loads, stops, points at lines, and gears."""
    model, w = seen.model, seen.state
    functions = functions_of(model)
    for (_, name, _), one in zip(elements_of(system.parts), apart(model.elements), strict=True):
        wrench = np.zeros_like(w.wrench)
        add_elements(one, functions, time, w.v, w.pose, w.vel, wrench)
        yield from _split(seen, name, wrench, markers_of(one))
    for k, (_, name) in enumerate(system.named_loads):
        wrench = np.zeros_like(w.wrench)
        load_wrenches((model.loads[k : k + 1], *functions), time, w.v, w.pose, w.vel, wrench)
        record = model.loads[k]
        yield from _split(seen, name, wrench, (record["term"]["a"], record["term"]["b"]))
    for k in range(len(system.tree.contacts), len(system.contacts)):
        wrench, end = np.zeros_like(w.wrench), model.ends[k : k + 1]
        add_known_contacts(end, seen.contacts[k : k + 1], w.pose, wrench)
        markers = [end[0]["bearing"], end[0]["journal"], *row_markers(end[0]["row"])]
        yield from _split(seen, system.contacts[k][1], wrench, markers)
    for name, row, size in zip(
        reversed([*system.tree.coupled]), reversed(model.rows), w.reaction[::-1].tolist(), strict=False
    ):
        wrench = np.zeros_like(w.wrench)
        add_row_wrench(row, w.pose, size, wrench)
        yield from _split(seen, name, wrench, row_markers(row))


def row_markers(row: np.record) -> list[np.record]:
    """List the markers of a row's terms."""
    return [row[term][end] for term in ("term", "other") for end in "ab"]


def _split(seen: Snapshot, name: str, wrench: Array, markers: Sequence[np.record]) -> Iterator[_Action]:
    """Yield the force on each body of a wrench, at its first marker."""
    for body in np.flatnonzero(np.abs(wrench).max(axis=1)).tolist():
        marker = next(one for one in markers if int(one["body"]) == body)
        place, (moment, fx, fy) = _place(seen, marker), wrench[body].tolist()
        rx, ry = place - seen.state.pose[body, :2]
        yield name, body, place, np.array([fx, fy]), moment - rx * fy + ry * fx


def _needed(seen: Snapshot) -> Array:
    """Compute the wrench about the frame that each body's motion needs without weight, (nb, 3)."""
    w = seen.state
    w.wrench[:] = 0.0
    needed = np.zeros_like(w.wrench)
    inertial_forces(seen.model.bodies, w, seen.model.gravity, needed, np.zeros(len(w.q)))
    return needed


def _place(seen: Snapshot, marker: Any) -> Array:
    """Place of a marker [m]."""
    return np.asarray(seen.state.pose[int(marker["body"]), :2] + np.array(arm(seen.state.pose, marker)))


class _Axes(NamedTuple):
    """Axes of a link: origin [m], and the matrix that turns plane axes into them."""

    origin: Array
    turn: Array

    def load(self, name: str, place: Array, force: Array, moment: float) -> Load:
        (x, y), (fx, fy) = self.places(place).tolist(), self.vectors(force).tolist()
        return Load(name, x, y, fx, fy, moment)

    def places(self, places: Array) -> Array:
        return np.asarray((places - self.origin) @ self.turn.T)

    def vectors(self, vectors: Array) -> Array:
        return np.asarray(vectors @ self.turn.T)

    def field(self, place: Array, gravity: Array, square: float) -> Field:
        (x, y), (gx, gy) = self.places(place).tolist(), self.vectors(gravity).tolist()
        return Field(x, y, gx, gy, square)


def _axes(system: System, seen: Snapshot, link: str) -> _Axes:
    body, x, y = system.tree.named_marker(link)
    pose = seen.state.pose
    angle = pose[body, 2] + system.places[link].angle
    c, s = np.cos(angle), np.sin(angle)
    return _Axes(pose[body, :2] + np.array(turned(pose, body, x, y)), np.array([[c, s], [-s, c]]))


def _of_link(
    system: System, seen: Snapshot, link: str, found: Sequence[tuple[str, Array, Array, float]], needed: Array
) -> LinkLoads:
    axes = _axes(system, seen, link)
    loads = [axes.load(*one) for one in found]
    if link in system.tree.deformable:
        bodies = (body for body in system.tree.deformable[link] if isinstance(body, Substructure))
        parts = tuple(_part(system, seen, axes, body, needed) for body in bodies)
        for part in parts:
            rows = np.hstack([part.nodes, part.forces]).tolist()
            loads += [Load("node", x, y, fx, fy, 0.0) for x, y, fx, fy in rows]
        return LinkLoads(link, tuple(loads), parts[0].field, parts, system.tree.extent, system.links[link].beam)
    i = system.tree.index[link]
    body, pose, acc, square = (
        seen.model.bodies.records[i],
        seen.state.pose,
        seen.state.acc[i],
        seen.state.vel[i, 0] ** 2,
    )
    r, mass, gravity = np.array(turned(pose, i, body["cx"], body["cy"])), float(body["mass"]), seen.model.gravity
    moment, *force = (-needed[i]).tolist()
    moment -= r[0] * force[1] - r[1] * force[0]
    centre, weight = pose[i, :2] + r, mass * gravity
    loads.append(axes.load("weight", centre, weight, 0.0))
    loads.append(axes.load("inertia", centre, np.array(force) - weight, moment))
    acceleration = acc[1:] + acc[0] * np.array([-r[1], r[0]]) - square * r
    return LinkLoads(link, tuple(loads), axes.field(centre, gravity - acceleration, square), (), system.tree.extent)


def _part(system: System, seen: Snapshot, axes: _Axes, part: Substructure, needed: Array) -> Part:
    """Distribute weight and inertia of a deformable body over nodes on its deformed axis."""
    i, w = system.tree.index[part.name], seen.state
    body, gravity, spin = seen.model.bodies.records[i], seen.model.gravity - w.acc[i, 1:], w.vel[i, 0]
    first = np.array(turned(w.pose, i, body["ex"], body["ey"]))
    basis = np.array([first, [-first[1], first[0]]])
    own = slice(int(body["eta"]), int(body["eta"]) + part.size)
    wanted = -np.array([needed[i, 0], *(basis @ needed[i, 1:])])
    moved = Moved(w.q[own], w.v[own], w.a[own], spin, w.acc[i, 0], basis @ gravity)
    nodes, field, others = inertia_at_nodes(part, moved, wanted)
    return Part(
        axes.field(w.pose[i, :2], gravity, spin**2),
        axes.places(w.pose[i, :2] + nodes @ basis),
        axes.vectors((field + others) @ basis),
        axes.vectors(others @ basis),
    )
