"""The machine: links, joints and frames of a planar linkage, read from SDFormat.

Everything here is given in the **drawn configuration**, the pose in which the SDF file draws the links,
and in **plane axes**: x_P, y_P span the plane of motion, its normal n = x_P x y_P is the axis of all
revolute joints. For joints about world z these are the world's x and y, about world y they are x and z,
about world x they are y and z. Angles are counter-clockwise about n. SI units.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, nearest
from linkages.files.sdf import RawJoint, RawModel, read_sdf

Array = NDArray[np.float64]

_INERTIA = re.compile(r"links\.[^.]+\.inertia")
_PARALLEL = 1e-6  # largest sine of the angle by which an axis may miss the normal (or the plane)


@dataclass(frozen=True)
class Link:
    """A rigid body.

    Attributes
    ----------
    origin : (2,) array
        Drawn position of the link frame's origin [m].
    angle : float
        Drawn angle of the link frame's x axis [rad] (of its y axis, less 90 degrees, where x is normal
        to the plane).
    com : (2,) array
        Drawn position of the mass centre [m].
    mass, inertia : float
        Mass [kg]; moment of inertia about the mass centre and the plane's normal [kg m2].
    rotation, translation, com_local, inertia_local : arrays
        The same in space: drawn pose of the link frame in the world, mass centre and inertia tensor
        about it in link axes.
    visuals : tuple of str
        ``<visual>`` elements, as written.
    """

    name: str
    origin: Array
    angle: float
    com: Array
    mass: float
    inertia: float
    rotation: Array
    translation: Array
    com_local: Array
    inertia_local: Array
    visuals: tuple[str, ...]


@dataclass(frozen=True)
class Bearing:
    """A journal bearing; the joint's parent carries the bearing, its child the journal. Lengths in m."""

    radius: float
    length: float


@dataclass(frozen=True)
class Slot:
    """A block in a slot; the joint's parent carries the slot, its child the block. Size of the block in m."""

    length: float
    height: float


@dataclass(frozen=True)
class Joint:
    """A joint; its coordinate is zero in the drawn configuration.

    Attributes
    ----------
    type : str
        "revolute", "prismatic" or "fixed".
    parent, child : str
        Link names, or "world".
    on_parent, on_child : (2,) arrays
        Drawn position of the joint on either body [m]; they coincide if the drawing closes.
    sign : float
        Revolute: +1 if the joint's axis is along the plane's normal, -1 if against it.
    direction : (2,) array
        Prismatic: unit vector of the axis, fixed to the parent.
    bearing : Bearing or None
    slot : Slot or None
        What a revolute, or a prismatic, joint is made of if it may have play.
    axis, position : (3,) arrays
        Drawn axis and position (on the child) in the world.
    """

    name: str
    type: str
    parent: str
    child: str
    on_parent: Array
    on_child: Array
    sign: float
    direction: Array
    bearing: Bearing | None
    slot: Slot | None
    axis: Array
    position: Array


@dataclass(frozen=True)
class Frame:
    """A named point and direction on a link: drawn origin [m] and angle of its x axis [rad]."""

    name: str
    link: str
    origin: Array
    angle: float


@dataclass(frozen=True)
class Mechanism:
    """A planar linkage.

    Attributes
    ----------
    source : Path
        The SDFormat file.
    basis : (3, 3) array
        Columns x_P, y_P, n in world axes.
    values : mapping of str to float
        Every number that can be replaced, by its dotted path (see `load_mechanism`).
    """

    name: str
    source: Path
    basis: Array
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    frames: tuple[Frame, ...]
    values: Mapping[str, float]

    @cached_property
    def link(self) -> dict[str, Link]:
        """Links by name."""
        return {link.name: link for link in self.links}

    @cached_property
    def joint(self) -> dict[str, Joint]:
        """Joints by name."""
        return {joint.name: joint for joint in self.joints}

    @cached_property
    def point(self) -> dict[str, Frame]:
        """Every named frame, link frames included."""
        own = {link.name: Frame(link.name, link.name, link.origin, link.angle) for link in self.links}
        return own | {frame.name: frame for frame in self.frames}

    def value(self, path: str) -> float:
        """Return the number at a dotted path.

        Raises
        ------
        InputError
            If there is none.
        """
        if path in self.values:
            return self.values[path]
        kind, _, rest = path.partition(".")
        name = rest.partition(".")[0]
        same = {other for other in self.values if other.startswith(f"{kind}.{name}.")}
        known = {other.rpartition(".")[0] for other in self.values}
        near = nearest(path, same) if same else nearest(f"{kind}.{name}", known)
        raise InputError(self.source, f"sdf.{path}", f"there is no such value; {near}")

    def with_inertial(self, values: Mapping[str, float]) -> Mechanism:
        """Return the mechanism with other masses and moments of inertia, without reading its file again.

        Parameters
        ----------
        values : mapping of str to float
            By the paths ``links.NAME.mass`` [kg] and ``links.NAME.inertia`` (about the mass centre and the plane's
            normal; the tensor in space is scaled) [kg m2].

        Raises
        ------
        InputError
            If there is no such link, or a value is not positive.
        """
        if not values:
            return self
        for path, value in values.items():
            if path not in self.values:
                raise InputError(
                    self.source,
                    f"sdf.{path}",
                    f'there is no link "{path.split(".")[1]}"; {nearest(path.split(".")[1], self.link)}',
                )
            if not 0.0 < value < np.inf:
                raise InputError(self.source, f"sdf.{path}", f"is {value:g}; it must be positive and finite")
        links = []
        for link in self.links:
            mass, inertia = values.get(_mass(link), link.mass), values.get(_inertia(link), link.inertia)
            if (mass, inertia) != (link.mass, link.inertia):
                link = replace(
                    link,
                    mass=mass,
                    inertia=inertia,
                    inertia_local=link.inertia_local * (inertia / link.inertia),
                )
            links.append(link)
        return replace(self, links=tuple(links), values={**self.values, **values})


def load_mechanism(path: str | Path, overrides: Mapping[str, float] | None = None) -> Mechanism:
    """Read a mechanism from an SDFormat file.

    Parameters
    ----------
    path : str or Path
        The ``.sdf`` file.
    overrides : mapping of str to float, optional
        Values that replace those of the file; see `linkages.files.sdf.read_sdf`. Besides those,
        ``links.NAME.inertia`` sets the moment of inertia about the plane's normal [kg m2] (the tensor
        is scaled).

    Returns
    -------
    Mechanism

    Raises
    ------
    InputError
        One line with file, element and reason.

    Examples
    --------
    >>> import linkages
    >>> mechanism = linkages.load_mechanism(linkages.find_file("seven_bar.sdf"), {"links.link2.mass": 0.3})
    >>> len(mechanism.links), len(mechanism.joints), mechanism.link["link2"].mass
    (6, 8, 0.3)
    """
    path = Path(path)
    overrides = dict(overrides or {})
    inertias = {key: value for key, value in overrides.items() if _INERTIA.fullmatch(key)}
    raw = read_sdf(path, {key: value for key, value in overrides.items() if key not in inertias})
    basis = _plane(path, raw)
    links = tuple(_link(name, raw, basis) for name in raw.links)
    joints = tuple(_joint(name, joint, basis) for name, joint in raw.joints.items())
    frames = tuple(
        Frame(name, frame.link, basis[:, :2].T @ frame.pose.translation, _angle(frame.pose.rotation, basis))
        for name, frame in raw.frames.items()
    )
    values = raw.values | {_inertia(link): link.inertia for link in links}
    mechanism = Mechanism(raw.name, path, basis, links, joints, frames, values).with_inertial(inertias)
    _check(mechanism)
    return mechanism


def _plane(path: Path, raw: RawModel) -> Array:
    """Basis (x_P, y_P, n) of the plane that all joint axes agree on."""
    revolute = [(n, j.axis) for n, j in raw.joints.items() if j.type == "revolute"]
    prismatic = [(n, j.axis) for n, j in raw.joints.items() if j.type == "prismatic"]
    if revolute:
        first, normal = revolute[0]
    else:
        first = "the prismatic joints"
        normal = np.array([0.0, 0.0, 1.0])
        for _, axis in prismatic[1:]:
            cross = np.cross(prismatic[0][1], axis)
            if np.linalg.norm(cross) > _PARALLEL:
                normal = cross / np.linalg.norm(cross)
                break
    for name, axis in revolute:
        if np.linalg.norm(np.cross(axis, normal)) > _PARALLEL:
            raise InputError(
                path, f'<joint name="{name}">', f'not planar: its axis is not parallel to that of "{first}"'
            )
    for name, axis in prismatic:
        if abs(axis @ normal) > _PARALLEL:
            raise InputError(
                path, f'<joint name="{name}">', f'not planar: it slides out of the plane normal to "{first}"'
            )
    return _basis(normal)


def _basis(normal: Array) -> Array:
    """Plane axes for a normal given up to sign: (x, y) for z, (x, z) for y, (y, z) for x."""
    normal = np.where(np.abs(normal) < 1e-12, 0.0, normal)
    x_axis = np.eye(3)[0] - normal[0] * normal
    if np.linalg.norm(x_axis) < 0.1:
        x_axis = np.eye(3)[1] - normal[1] * normal
    x_axis /= np.linalg.norm(x_axis)
    y_axis = np.cross(normal, x_axis)
    lead = y_axis[2] if abs(y_axis[2]) > 1e-9 else y_axis[1]
    if lead < 0.0:
        normal, y_axis = -normal, -y_axis
    return np.column_stack([x_axis, y_axis, normal])


def _angle(rotation: Array, basis: Array) -> float:
    """Angle of a frame's x axis in the plane; of its y axis, less 90 degrees, if x is normal to it."""
    x_axis = basis[:, :2].T @ rotation[:, 0]
    if np.linalg.norm(x_axis) > 0.1:
        return float(np.arctan2(x_axis[1], x_axis[0]))
    y_axis = basis[:, :2].T @ rotation[:, 1]
    return float(np.arctan2(-y_axis[0], y_axis[1]))


def _link(name: str, raw: RawModel, basis: Array) -> Link:
    link = raw.links[name]
    rotation = link.pose.rotation
    normal = rotation.T @ basis[:, 2]
    com = link.pose.translation + rotation @ link.com
    return Link(
        name,
        basis[:, :2].T @ link.pose.translation,
        _angle(rotation, basis),
        basis[:, :2].T @ com,
        link.mass,
        float(normal @ link.inertia @ normal),
        rotation,
        link.pose.translation,
        link.com,
        link.inertia,
        link.visuals,
    )


def _joint(name: str, raw: RawJoint, basis: Array) -> Joint:
    to_plane = basis[:, :2].T
    return Joint(
        name,
        raw.type,
        raw.parent,
        raw.child,
        to_plane @ raw.on_parent,
        to_plane @ raw.on_child,
        float(np.sign(raw.axis @ basis[:, 2])) if raw.type == "revolute" else 1.0,
        to_plane @ raw.axis if raw.type == "prismatic" else np.zeros(2),
        Bearing(*raw.bearing) if raw.bearing else None,
        Slot(*raw.slot) if raw.slot else None,
        raw.axis,
        raw.on_child,
    )


def _mass(link: Link) -> str:
    return f"links.{link.name}.mass"


def _inertia(link: Link) -> str:
    return f"links.{link.name}.inertia"


def _check(mechanism: Mechanism) -> None:
    path = mechanism.source
    for link in mechanism.links:
        if link.inertia <= 0.0:
            raise InputError(
                path,
                f'<link name="{link.name}">',
                "has no moment of inertia about the plane's normal; give one",
            )
    reached = {"world"}
    while True:
        more = {
            end
            for joint in mechanism.joints
            if {joint.parent, joint.child} & reached
            for end in (joint.parent, joint.child)
        }
        if more <= reached:
            break
        reached |= more
    for link in mechanism.links:
        if link.name not in reached:
            raise InputError(
                path, f'<link name="{link.name}">', "is not connected to the world by any chain of joints"
            )
    for joint in mechanism.joints:
        if joint.bearing is not None and joint.type != "revolute":
            raise InputError(
                path, f'<joint name="{joint.name}">', f"a {joint.type} joint cannot carry <linkages:bearing>"
            )
        if joint.slot is not None and joint.type != "prismatic":
            raise InputError(
                path, f'<joint name="{joint.name}">', f"a {joint.type} joint cannot carry <linkages:slot>"
            )
