"""The mechanism's spanning tree as SDFormat that Drake accepts, and as a plant."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    PlanarJoint,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)

from linkages.base.arrays import Array, Indices
from linkages.base.errors import InputError
from linkages.elements.coordinates import WHEEL
from linkages.engines.numerics import PLANT_BLOCK, PLANT_LIGHT, PLANT_WIDTH
from linkages.input.files.raw_model import Pose, RawModel
from linkages.input.files.sdf_text import sdf_text
from linkages.input.model.mechanism import Link
from linkages.mechanics.planar.record_types import PRISMATIC
from linkages.system.spanning import freedoms
from linkages.system.tree import Tree


def tree_sdf(tree: Tree) -> str:
    """Write the spanning tree as plain SDFormat: no cut joints, no annotations, no frames to resolve.

    Links have the poses of the tree at zero coordinates: the reference configuration, shifted so that every joint of
    the tree is closed. Visuals are passed on, or made for links without any; collision geometry is omitted, because the
    joint laws compute the contacts.
    """
    shift = drawn_shifts(tree)
    links = [
        replace(
            link,
            translation=link.translation + shift[link.name],
            visuals=link.visuals or visuals(tree, link),
            beam=None,
        )
        for link in tree.links.values()
    ]
    joints = []
    for edge in tree.edges.values():
        if edge.joint in tree.play:
            continue
        joint = tree.joints[edge.joint]
        # on the child if it is a link (its reference position is the joint's), otherwise in the world
        place = joint.position + shift.get(joint.child, np.zeros(3))
        if joint.child == "world":  # not in plain SDFormat: the same coordinate about the opposite axis
            joint = replace(joint, parent="world", child=joint.parent, axis=-joint.axis)
        joints.append(replace(joint, position=place, position_on_parent=place, bearing=None, slot=None))
    return sdf_text(RawModel(tree.name, tuple(links), tuple(joints), {}, {}), at_frames=False)


def drawn_shifts(tree: Tree) -> dict[str, Array]:
    """Compute the displacement (3,) of each link that closes the tree's joints at zero coordinates [m]."""
    shift = {"world": np.zeros(3)}
    in_plane = tree.basis[:, :2]
    for name in tree.index:  # parents come before children
        if name == "world":
            continue
        edge = tree.edges.get(name)
        if edge is None:
            shift[name] = np.zeros(3)
            continue
        joint = tree.joints[edge.joint]
        gap = np.zeros(2) if joint.type == "fixed" else joint.on_parent - joint.on_child
        inner, sign = (joint.child, -1.0) if edge.reversed else (joint.parent, 1.0)
        shift[name] = shift[inner] + sign * (in_plane @ gap)
    return shift


def add_tree(plant: MultibodyPlant, tree: Tree) -> int:
    """Add the tree's links and joints to a plant that is not finalized; return the model instance.

    InputError if Drake rejects a ``<visual>`` of the user's file.
    """
    try:
        with _unheard(logging.ERROR):
            (instance,) = Parser(plant).AddModelsFromString(tree_sdf(tree), "sdf")
    except (RuntimeError, SystemExit) as problem:  # a failed assertion of Drake is a SystemExit
        raise InputError(tree.source, "<visual>", f"Drake rejects it: {problem}") from None
    for name in tree.index:
        if name == "world":
            continue
        if name not in tree.edges:
            _add_floating(plant, instance, tree, name)
        elif tree.edges[name].joint in tree.play:
            _add_freedoms(plant, instance, tree, name)
    for name, body in tree.wheels.items():
        _add_wheel(plant, instance, tree, name, float(tree.bodies.records[body]["inertia"]))
    return instance


@contextmanager
def _unheard(level: int) -> Iterator[None]:
    """Suppress Drake's log of this level on the terminal; the same message is raised."""

    def other(record: logging.LogRecord) -> bool:
        return record.levelno != level

    log = logging.getLogger("drake")
    log.addFilter(other)
    try:
        yield
    finally:
        log.removeFilter(other)


@dataclass(frozen=True)
class StatePlace:
    """Places of a tree's n coordinates in the state [q; v] of a plant.

    Attributes
    ----------
    positions : (n,) array of int
        Indices in the plant's positions, and in the state.
    velocities : (n,) array of int
        Indices in the plant's velocities and generalised forces.
    num_positions, num_velocities : int
        Of the whole plant.
    """

    positions: Indices
    velocities: Indices
    num_positions: int
    num_velocities: int

    @property
    def num_states(self) -> int:
        """Return the length of the plant's state."""
        return self.num_positions + self.num_velocities

    @property
    def v(self) -> Indices:
        """Return the indices of the rates in the state."""
        return self.num_positions + self.velocities


def state_place(plant: MultibodyPlant, tree: Tree, instance: int) -> StatePlace:
    """Find the places of the tree's coordinates in the state of a finalized plant."""
    positions, velocities = [], []
    for name in tree.coordinates:
        link, _, part = name.rpartition(".")
        floats = link in tree.index and link not in tree.edges
        joint = plant.GetJointByName(f"{link}_floating" if floats else name, instance)
        offset = ("x", "y", "angle").index(part) if floats else 0
        positions.append(joint.position_start() + offset)
        velocities.append(joint.velocity_start() + offset)
    return StatePlace(
        np.array(positions, dtype=np.int64),
        np.array(velocities, dtype=np.int64),
        plant.num_positions(),
        plant.num_velocities(),
    )


def _add_floating(plant: MultibodyPlant, instance: int, tree: Tree, name: str) -> None:
    link = tree.links[name]
    basis = tree.basis
    X_WF = RigidTransform(RotationMatrix(basis), basis[:, :2] @ link.com)
    X_WL = RigidTransform(RotationMatrix(link.rotation), link.translation)
    F = plant.AddFrame(FixedOffsetFrame(f"{name}_floating_F", plant.world_frame(), X_WF, instance))
    body = plant.GetBodyByName(name, instance)
    M = plant.AddFrame(FixedOffsetFrame(f"{name}_floating_M", body.body_frame(), X_WL.inverse() @ X_WF, instance))
    plant.AddJoint(PlanarJoint(f"{name}_floating", F, M, np.zeros(3)))


def _add_freedoms(plant: MultibodyPlant, instance: int, tree: Tree, name: str) -> None:
    """Carry a link by a joint with clearance and a drive: joints with massless bodies between them."""
    edge, shift = tree.edges[name], drawn_shifts(tree)
    joint, basis = tree.joints[edge.joint], tree.basis
    inner = joint.child if edge.reversed else joint.parent
    on_outer = joint.on_parent if edge.reversed else joint.on_child
    X_WP = RigidTransform(RotationMatrix(basis), basis[:, :2] @ on_outer + shift[name])

    def frame(link: str) -> Frame:
        """Fix a frame to a link, in the plane's axes."""
        if link == "world":
            return plant.AddFrame(FixedOffsetFrame(f"{joint.name}_at_world", plant.world_frame(), X_WP, instance))
        body, one = plant.GetBodyByName(link, instance), tree.links[link]
        X_WL = RigidTransform(RotationMatrix(one.rotation), one.translation + shift[link])
        return plant.AddFrame(
            FixedOffsetFrame(f"{joint.name}_at_{link}", body.body_frame(), X_WL.inverse() @ X_WP, instance)
        )

    found, at = freedoms(joint, edge.reversed, loose=True), frame(inner)
    for one in found:
        massless = SpatialInertia.Zero()
        body = frame(name) if one is found[-1] else plant.AddRigidBody(one.name, instance, massless).body_frame()
        if one.type == PRISMATIC:
            plant.AddJoint(PrismaticJoint(one.name, at, body, np.append(one.axis, 0.0)))
        else:
            plant.AddJoint(RevoluteJoint(one.name, at, body, np.array([0.0, 0.0, one.sign])))
        at = body


def _add_wheel(plant: MultibodyPlant, instance: int, tree: Tree, name: str, inertia: float) -> None:
    """Add the output wheel of a drive's gearbox: Drake needs a mass for its inertia, which is made negligible."""
    joint = tree.joints[name.removesuffix(WHEEL)]
    basis, shift = tree.basis, drawn_shifts(tree)
    X_WP = RigidTransform(RotationMatrix(basis), basis[:, :2] @ joint.on_parent + shift[joint.parent])
    at, X_LP = plant.world_frame(), X_WP
    if joint.parent != "world":
        one = tree.links[joint.parent]
        at = plant.GetBodyByName(one.name, instance).body_frame()
        X_LP = RigidTransform(RotationMatrix(one.rotation), one.translation + shift[one.name]).inverse() @ X_WP
    place = plant.AddFrame(FixedOffsetFrame(f"{name}_place", at, X_LP, instance))
    mass, radius = inertia * (PLANT_LIGHT / tree.extent) ** 2, tree.extent / PLANT_LIGHT
    disc = UnitInertia(0.5 * radius**2, 0.5 * radius**2, radius**2)
    wheel = plant.AddRigidBody(name, instance, SpatialInertia(mass, np.zeros(3), disc))
    plant.AddJoint(RevoluteJoint(name, place, wheel.body_frame(), np.array([0.0, 0.0, joint.sign])))


def _words(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def visuals(tree: Tree, link: Link) -> tuple[str, ...]:
    """Make ``<visual>`` elements: a box for each bar of the link's skeleton, or a block for a single place.

    The widths follow from the size of the linkage [m].
    """
    shape, size = tree.skeleton(link.name), tree.extent
    width = PLANT_WIDTH * size
    if not shape.bars:
        sides = (PLANT_BLOCK * size, PLANT_BLOCK * size, width)
        return (_box(tree.basis, link, 0, shape.places[0], np.array([1.0, 0.0]), sides, shape.color),)
    ends = [(shape.places[a], shape.places[b]) for a, b in shape.bars]
    lengths = [float(np.linalg.norm(b - a)) for a, b in ends]
    return tuple(
        _box(tree.basis, link, k, 0.5 * (a + b), b - a, (length + width, width, width), shape.color)
        for k, ((a, b), length) in enumerate(zip(ends, lengths, strict=True))
    )


def _box(
    basis: Array, link: Link, number: int, middle: Array, along: Array, sides: tuple[float, ...], color: str
) -> str:
    """Make a box in link axes from its reference middle and direction in plane axes."""
    x = basis[:, :2] @ along / np.linalg.norm(along)
    axes = np.column_stack([x, np.cross(basis[:, 2], x), basis[:, 2]])
    out_of_plane = basis[:, 2] * (basis[:, 2] @ link.translation)  # offset of the link frame
    position = link.rotation.T @ (basis[:, :2] @ middle + out_of_plane - link.translation)
    pose = Pose(link.rotation.T @ axes, position).text()
    diffuse = " ".join(f"{int(color[k : k + 2], 16) / 255:.3g}" for k in (1, 3, 5))
    return (
        f'<visual name="skeleton{number}"><pose>{pose}</pose><geometry><box><size>{_words(sides)}</size></box>'
        f"</geometry><material><diffuse>{diffuse} 1</diffuse></material></visual>"
    )
