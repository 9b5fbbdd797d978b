"""The mechanism: links, joints and frames of a planar linkage, read from SDFormat.

All quantities are given in the **reference configuration**, the pose of the SDF file, and in **plane axes**: x_P, y_P
span the plane of motion; its normal n = x_P x y_P is the axis of all revolute joints. For joints about world z these
are the world's x and y, about world y they are x and z, about world x they are y and z. Angles are counter-clockwise
about n. SI units.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from linkages.base.arrays import Array
from linkages.base.brief import Brief, counted
from linkages.base.errors import InputError, nearest
from linkages.input.files.beams import FOLLOWS
from linkages.input.files.magnitudes import ALIGNED, implausible
from linkages.input.files.raw_model import UNROUNDED, Chains, LinkBeam, Pose, RawJoint, RawLink, RawModel
from linkages.input.files.reading import read_whole
from linkages.input.files.sdf import read_sdf

if TYPE_CHECKING:
    from linkages.input.model.experiment import Experiment


_INERTIA = re.compile(r"links\.[^.]+\.inertia")
_PALEST, _LUMINANCE = 0.7, np.array([0.2126, 0.7152, 0.0722])  # largest luminance of a link; ITU-R BT.709
_PARALLEL = 1e-6  # largest sine of the angle between an axis and the normal (or the plane)


@dataclass(frozen=True, eq=False)
class Link(RawLink):
    """A rigid body: the file's data, and quantities in the plane in the reference configuration.

    Attributes
    ----------
    origin : (2,) array
        Origin of the link frame [m].
    angle : float
        Angle of the link frame's x axis [rad] (of its y axis less 90 degrees, where x is the plane's normal).
    com : (2,) array
        Mass centre [m].
    inertia : float
        Moment of inertia about the mass centre and the plane's normal [kg m2].
    color : str
        Colour of the file's visuals as ``#rrggbb``, darkened if it is too pale for a name on paper.
    """

    origin: Array
    angle: float
    com: Array
    inertia: float
    color: str = ""


@dataclass(frozen=True, eq=False)
class Joint(RawJoint):
    """A joint: the file's data, and quantities in the plane; coordinate zero in the reference configuration.

    Its reference positions on both bodies coincide if the file's pose closes the loops.

    Attributes
    ----------
    on_parent, on_child : (2,) arrays
        Reference positions on both bodies [m].
    sign : float
        Revolute: +1 if the joint's axis is along the plane's normal, -1 if against it.
    direction : (2,) array
        Prismatic: unit vector of the axis, fixed to the parent.
    """

    on_parent: Array
    on_child: Array
    sign: float
    direction: Array


@dataclass(frozen=True)
class Frame:
    """A named frame on a link, in the reference configuration.

    Attributes
    ----------
    name, link : str
    origin : (2,) array
        Its origin [m].
    angle : float
        Angle of its x axis [rad].
    """

    name: str
    link: str
    origin: Array
    angle: float


@dataclass(frozen=True, repr=False)
class Mechanism(Brief):
    """A planar linkage; made by `load_mechanism`.

    Attributes
    ----------
    name : str
    source : Path
        The SDFormat file.
    basis : (3, 3) array
        Columns x_P, y_P, n in world axes.
    links, joints, frames : tuples of Link, Joint, Frame
        In the order of the file.
    values : mapping of str to float
        All replaceable numbers, by dotted path (see `load_mechanism`).
    units : mapping of str to str
        SI units of the parameters of a described mechanism, where they are known.
    text : bytes or None
        Content of the file; variants are made from it.
    unweighed : tuple of str
        Links of the file without an ``<inertial>``: massless here, frames of the links to which they are fixed.
    grid : float
        Power of two of which all coordinates of places are multiples, 2^-52 of the file's farthest coordinate [m]. So
        their differences have no rounding errors, whatever the other lengths are.
    """

    name: str
    source: Path
    basis: Array
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    frames: tuple[Frame, ...]
    values: Mapping[str, float]
    units: Mapping[str, str]
    text: bytes | None = None
    unweighed: tuple[str, ...] = ()
    grid: float = UNROUNDED

    def _facts(self) -> tuple[str, dict[str, str]]:
        line = f"{self.name}, {counted(len(self.links), 'link')}, {counted(len(self.joints), 'joint')}"
        rows = {"file": self.source.name, "links": ", ".join(f"{link.name} {link.mass:.4g} kg" for link in self.links)}
        for joint in self.joints:
            rows[f"joint {joint.name}"] = f"{joint.type}, {joint.parent} and {joint.child}"
        return line, rows

    @cached_property
    def link(self) -> dict[str, Link]:
        """Return the links by name."""
        return {link.name: link for link in self.links}

    @cached_property
    def beam(self) -> dict[str, LinkBeam]:
        """Return the beams of links by the links' names."""
        return {link.name: link.beam for link in self.links if link.beam is not None}

    @cached_property
    def joint(self) -> dict[str, Joint]:
        """Return the joints by name."""
        return {joint.name: joint for joint in self.joints}

    def slides(self, joint: str) -> bool:
        """Tell whether a joint is prismatic."""
        return self.joint[joint].type == "prismatic"

    @cached_property
    def point(self) -> dict[str, Frame]:
        """Return all named frames, link frames included."""
        own = {link.name: Frame(link.name, link.name, link.origin, link.angle) for link in self.links}
        return own | {frame.name: frame for frame in self.frames}

    @cached_property
    def pin(self) -> dict[str, Frame]:
        """Return the joints' places by name: on the child, or on the parent if the child is the world."""
        ends = {
            joint.name: (joint.child, joint.on_child) if joint.child != "world" else (joint.parent, joint.on_parent)
            for joint in self.joints
        }
        return {name: Frame(name, link, origin, 0.0) for name, (link, origin) in ends.items()}

    @cached_property
    def place(self) -> dict[str, Frame]:
        """Return everything with a position: named frames, and joints."""
        return self.pin | self.point

    def rigid_groups(self, known: Collection[str]) -> dict[str, str]:
        """Map each link to its group of links that move as one body, if these joints cannot move."""
        group = {name: name for name in ("world", *self.link)}
        for joint in self.joints:
            if joint.name in known:
                old, new = group[joint.child], group[joint.parent]
                group = {link: new if name == old else name for link, name in group.items()}
        return group

    def meet(self, one: str, two: str) -> bool:
        """Tell whether two joints share a link, or have links that fixed joints make one body."""
        body = self.rigid_groups([joint.name for joint in self.joints if joint.type == "fixed"])
        first, second = ({body[joint.parent], body[joint.child]} for joint in (self.joint[one], self.joint[two]))
        return bool(first & second)

    def value(self, path: str) -> float:
        """Return the number at a dotted path; InputError if there is none."""
        if path in self.values:
            return self.values[path]
        kind, _, rest = path.partition(".")
        name = rest.partition(".")[0]
        same = {other for other in self.values if other.startswith(f"{kind}.{name}.")}
        known = {other.rpartition(".")[0] for other in self.values}
        near = nearest(path, same) if same else nearest(f"{kind}.{name}", known)
        raise InputError(self.source, f"sdf.{path}", f"there is no such value; {near}")

    def replaced(self, overrides: Mapping[str, float], paths: Collection[str]) -> Mechanism:
        """Return the mechanism of the same file with other overrides, which differ at some paths."""
        if all(path in overrides and is_inertial(path) for path in paths):  # an empty table has no override
            return self.with_inertial({path: overrides[path] for path in paths})
        text = read_whole(self.source) if self.text is None else self.text
        return mechanism_of_text(self.source, text, overrides)

    def with_inertial(self, values: Mapping[str, float]) -> Mechanism:
        """Return the mechanism with other masses and moments of inertia, without reading its file again.

        The values have the paths ``links.NAME.mass`` [kg] and ``links.NAME.inertia`` (about the mass centre and the
        plane's normal; the tensor in space is scaled) [kg m2]. InputError if the link does not exist, has a beam (which
        determines them), or a value is not positive.
        """
        if not values:
            return self
        for path, value in values.items():
            name = path.split(".")[1]
            problem = "" if value > 0.0 else f"is {value:g}; it must be positive"
            if path not in self.values:
                problem = f'there is no link "{name}"; {nearest(name, self.link)}'
            elif name in self.beam:
                problem = FOLLOWS
            if problem := problem or implausible(value):
                raise InputError(self.source, f"sdf.{path}", problem)
        links = []
        for link in self.links:
            start = f"links.{link.name}."
            mass, inertia = values.get(start + "mass", link.mass), values.get(start + "inertia", link.inertia)
            if (mass, inertia) != (link.mass, link.inertia):
                tensor = link.inertia_local * (inertia / link.inertia) if link.inertia else inertia * np.eye(3)
                link = replace(link, mass=mass, inertia=inertia, inertia_local=tensor)
            links.append(link)
        return replace(self, links=tuple(links), values={**self.values, **values})


def load_mechanism(path: str | Path, overrides: Mapping[str, float] | None = None) -> Mechanism:
    """Read a mechanism from an SDFormat file.

    To simulate it, use `linkages.load` with an experiment file, which names the mechanism.

    Parameters
    ----------
    path : str or Path
        The ``.sdf`` file.
    overrides : mapping of str to float, optional
        Values that override the file; see `linkages.input.files.sdf.read_sdf`. In addition,
        ``links.NAME.inertia`` sets the moment about the plane's normal [kg m2] (the tensor is scaled).

    Raises
    ------
    InputError
        If the input is invalid: one line with file, element and reason.

    Examples
    --------
    >>> import linkages
    >>> mechanism = linkages.load_mechanism(linkages.find_file("seven_bar.sdf"), {"links.link2.mass": 0.3})
    >>> len(mechanism.links), len(mechanism.joints), mechanism.link["link2"].mass
    (6, 8, 0.3)
    """
    path = Path(path)
    return mechanism_of_text(path, read_whole(path), overrides or {})


def mechanism_of_text(path: Path, text: bytes, overrides: Mapping[str, float] = MappingProxyType({})) -> Mechanism:
    """Make the mechanism of an SDFormat text; errors name the file `path`, see `load_mechanism`."""
    inertias = {key: value for key, value in overrides.items() if _INERTIA.fullmatch(key)}
    raw = read_sdf(path, {key: value for key, value in overrides.items() if key not in inertias}, text)
    return planar(path, raw, inertias, text)


def is_inertial(path: str) -> bool:
    """Check whether a path names a mass or a moment of inertia."""
    return path.startswith("links.") and path.endswith((".mass", ".inertia"))


@contextmanager
def faults_of_values(experiment: Experiment) -> Iterator[None]:
    """Attribute a fault of an experiment's mechanism to the key that caused it.

    The key is an override of the experiment, or the name of a file that is not a mechanism.
    """
    try:
        yield
    except InputError as fault:
        if fault.source == experiment.mechanism_path and not fault.where:
            problem = f'is "{experiment.mechanism}", which {fault.problem}'
            raise InputError(experiment.origin("mechanism"), "mechanism", problem) from None
        path, values = experiment.mechanism_path, experiment.sdf_overrides
        for known in ({}, *({key: value} for key, value in values.items())):
            try:
                load_mechanism(path, known)
            except InputError as problem:
                if not known:
                    break
                where = f"sdf.{next(iter(known))}"
                if str(problem) != str(fault) and where != fault.where:  # of a pair of values that are given together
                    continue
                what = str(problem).removeprefix(f"{path.name}: ").removeprefix(f"{where}: ")
                raise InputError(experiment.origin(where), where, what) from None
        raise


def planar(path: Path, raw: RawModel, inertias: Mapping[str, float], text: bytes | None = None) -> Mechanism:
    """Return a mechanism in its plane, with overrides of moments of inertia, and the content of its file."""
    moving = [joint for joint in raw.joints if joint.type != "fixed"]
    axes = np.array([joint.axis for joint in moving]).tobytes()
    basis = _plane(path, tuple((joint.name, joint.type) for joint in moving), axes)
    plane = basis.tobytes()
    links = tuple(_link(path, link, plane, raw.grid) for link in raw.links)
    joints = tuple(_joint(joint, plane) for joint in raw.joints)
    frames = tuple(_frame(name, link, pose, plane) for name, (link, pose) in raw.frames.items())
    values = raw.values | {f"links.{link.name}.inertia": link.inertia for link in links}
    own = raw.units, text, raw.unweighed, raw.grid
    mechanism = Mechanism(raw.name, path, basis, links, joints, frames, values, *own)
    mechanism = mechanism.with_inertial(inertias)
    _check(mechanism)
    return mechanism


@lru_cache(maxsize=16)  # variants of a mechanism have the same axes
def _plane(path: Path, joints: tuple[tuple[str, str], ...], axes: bytes) -> Array:
    """Find the basis (x_P, y_P, n) of the plane common to the axes of joints, given by name and type."""
    along = dict(zip(joints, np.frombuffer(axes).reshape(-1, 3), strict=True))
    revolute, prismatic = ([(n, along[n, t]) for n, t in joints if t == kind] for kind in ("revolute", "prismatic"))
    if revolute:
        first, normal = revolute[0]
    else:
        first, normal = "the prismatic joints", np.array([0.0, 0.0, 1.0])
        crosses = [np.cross(prismatic[0][1], axis) for _, axis in prismatic[1:]]
        if lying := [cross for cross in crosses if np.linalg.norm(cross) > _PARALLEL]:
            normal = lying[0] / np.linalg.norm(lying[0])
    for name, axis in revolute:
        if (sine := float(np.linalg.norm(np.cross(axis, normal)))) > _PARALLEL:
            problem = f'not planar: its axis is not parallel to the axis of "{first}"{_off(sine)}'
            raise _wrong(path, "joint", name, problem)
    for name, axis in prismatic:
        if (sine := float(abs(axis @ normal))) > _PARALLEL:
            raise _wrong(path, "joint", name, f'not planar: its axis leaves the plane normal to "{first}"{_off(sine)}')
    return _basis(normal)


def _off(sine: float) -> str:
    """Write the angle between an axis and its right direction; `sine` is its sine."""
    angle = math.asin(min(sine, 1.0))
    aligned = "; `linkages import` aligns it" if angle <= ALIGNED else ""
    return f" by {angle:.3g} rad ({math.degrees(angle):.3g} degrees){aligned}"


def _basis(normal: Array) -> Array:
    """Return plane axes for a normal given up to sign: (x, y) for z, (x, z) for y, (y, z) for x."""
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
    """Return the angle of a frame's x axis in the plane; if x is normal to it, of y minus 90 degrees."""
    x_axis = basis[:, :2].T @ rotation[:, 0]
    if np.linalg.norm(x_axis) > 0.1:
        return float(np.arctan2(x_axis[1], x_axis[0]))
    y_axis = basis[:, :2].T @ rotation[:, 1]
    return float(np.arctan2(-y_axis[0], y_axis[1]))


@lru_cache(maxsize=512)  # variants of a mechanism share links and joints
def _link(path: Path, raw: RawLink, plane: bytes, grid: float) -> Link:
    basis = np.frombuffer(plane).reshape(3, 3)
    to_plane, normal = basis[:, :2].T, raw.rotation.T @ basis[:, 2]
    beam = raw.beam
    if beam is not None:
        if abs(basis[:, 2] @ (beam.end - beam.start)) > _PARALLEL * beam.length:
            raise _wrong(path, "link", raw.name, "its <linkages:beam> does not lie in the plane of motion")
        beam = replace(beam, start=to_plane @ beam.start, end=to_plane @ beam.end)
    return Link(
        **vars(raw) | {"beam": beam},
        origin=to_plane @ raw.translation,
        angle=_angle(raw.rotation, basis),
        com=to_plane @ (raw.translation + raw.pose.displacement(raw.com_local, grid)),
        inertia=float(normal @ raw.inertia_local @ normal),
        color=_color("".join(raw.visuals)),
    )


def _color(visuals: str) -> str:
    """Return the first diffuse colour of visuals."""
    found = re.search(r"<diffuse>([^<]*)</diffuse>", visuals)
    try:
        rgb = np.array(found[1].split()[:3], dtype=np.float64).clip(0.0, 1.0) if found else np.zeros(0)
    except ValueError:  # Drake reports it
        return ""
    if rgb.shape != (3,) or not np.isfinite(rgb).all():
        return ""
    rgb *= min(1.0, _PALEST / max(float(_LUMINANCE @ rgb), _PALEST))
    return "#" + "".join(f"{round(255 * part):02x}" for part in rgb)


@lru_cache(maxsize=512)
def _joint(raw: RawJoint, plane: bytes) -> Joint:
    basis = np.frombuffer(plane).reshape(3, 3)
    to_plane = basis[:, :2].T
    return Joint(
        **vars(raw),
        on_parent=to_plane @ raw.position_on_parent,
        on_child=to_plane @ raw.position,
        sign=float(np.sign(raw.axis @ basis[:, 2])) if raw.type == "revolute" else 1.0,
        direction=to_plane @ raw.axis if raw.type == "prismatic" else np.zeros(2),
    )


@lru_cache(maxsize=512)
def _frame(name: str, link: str, pose: Pose, plane: bytes) -> Frame:
    basis = np.frombuffer(plane).reshape(3, 3)
    return Frame(name, link, basis[:, :2].T @ pose.translation, _angle(pose.rotation, basis))


def _check(mechanism: Mechanism) -> None:
    path = mechanism.source
    pairs = tuple((joint.parent, joint.child) for joint in mechanism.joints)
    for name in _loose(tuple(link.name for link in mechanism.links), pairs):
        raise _wrong(path, "link", name, "is not connected to the world by any chain of joints")
    for joint in mechanism.joints:
        for part, kind in (("bearing", "revolute"), ("slot", "prismatic")):
            if getattr(joint, part) is not None and joint.type != kind:
                problem = f"a {joint.type} joint cannot carry <linkages:{part}>"
                raise _wrong(path, "joint", joint.name, problem)


@lru_cache(maxsize=16)
def _loose(links: tuple[str, ...], pairs: tuple[tuple[str, str], ...]) -> tuple[str, ...]:
    """Return the links that no chain of joints, given by the links they connect, connects to the world."""
    connected = Chains(links, pairs).of["world"]
    return tuple(name for name in links if name not in connected)


def _wrong(path: Path, tag: str, name: str, problem: str) -> InputError:
    return InputError(path, f'<{tag} name="{name}">', problem)
