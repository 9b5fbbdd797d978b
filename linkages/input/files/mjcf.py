"""Conversion of MJCF, the format of MuJoCo, to SDFormat: the same bodies, joints and places, in world coordinates.

| MJCF                                        | SDFormat, of which the import makes the machine                     |
|---------------------------------------------|---------------------------------------------------------------------|
| body, inertial, geom                        | link, its inertial or the shapes that it is computed of             |
| hinge, slide, ball; stiffness, damping, ... | joint, its dynamics and limits                                      |
| equality connect, weld, joint               | ball constraint, weld constraint, mimic                             |
| position and velocity actuators at rest     | stiffness and damping of the joint                                  |
| armature of a hinge at the ground           | inertia of the link                                                 |

Joint coordinates are zero in the file's reference pose, where MuJoCo has `ref`. Elements without an SDFormat
equivalent are passed on, so that the reader of the model can report them.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.input.files.elements import tensor_of
from linkages.input.files.foreign import MARK, add_mimic
from linkages.input.files.mjcf_actuators import Feedback, feedback_of
from linkages.input.files.mjcf_defaults import Defaults, Mjcf, included
from linkages.input.files.mjcf_shapes import add_shapes
from linkages.input.files.raw_model import Pose, free_name
from linkages.input.files.rigid import write_tensor
from linkages.input.files.xml import label

_JOINTS = {"hinge": "revolute", "slide": "prismatic", "ball": "ball"}
#: Sections without influence on a mechanism that touches nothing outside its joints.
_IDLE = ("asset", "visual", "statistic", "size", "sensor", "contact", "keyframe", "custom", "default", "compiler")
_OF_BODY = ("inertial", "joint", "freejoint", "geom", "site", "camera", "light", "body", "frame")
_FLUID = ("wind", "density", "viscosity")  # of <option>


def sdf_of_mjcf(path: Path, root: ET.Element) -> ET.Element:
    """Return the ``<model>`` of a ``<mujoco>``, with its gravity; "told" has notes, one a line.

    InputError for what a planar linkage cannot have, or the import does not support.
    """
    return _Conversion(Mjcf(path, included(path, root))).model


class _Conversion:
    def __init__(self, file: Mjcf) -> None:
        self.file, self.path, self.notes = file, file.path, list[str]()
        self.model = ET.Element("model", name=file.root.get("model", "") or self.path.stem, notation="MJCF")
        self.poses = {"world": Pose()}  # of bodies, in the world
        self.names: dict[str, str] = {}  # of joints here, by their names in the file
        self.sites: dict[str, tuple[str, Pose]] = {}
        self.taken = {"world", *(body.get("name", "") for body in file.root.iter("body"))}
        self.feedback: dict[str, Feedback] = feedback_of(file, self.notes)
        self._options()
        for world in file.root.findall("worldbody"):
            self._children(world, "world", Pose(), file.defaults, False)
        for section in file.root:
            if section.tag == "equality":
                for constraint in section:
                    self._equality(constraint)
            elif section.tag not in (*_IDLE, "option", "worldbody", "actuator"):
                self.model.extend(self._passed_on(section))
        self.model.set("told", "\n".join(self.notes))

    def _options(self) -> None:
        """Take gravity; refuse a medium that brakes."""
        gravity = "0 0 -9.81"
        for option in self.file.root.findall("option"):
            for key in _FLUID:
                if any(self.file.numbers(option, key, default="0")):
                    raise InputError(self.path, f"<option> {key}", "is a medium that acts on links; remove it")
            gravity = option.get("gravity", gravity)
            if option.find("flag[@gravity='disable']") is not None:
                gravity = "0 0 0"
        self.model.set("gravity", gravity)

    def _passed_on(self, section: ET.Element) -> Iterator[ET.Element]:
        """Yield elements that the import reports as unknown: tendons, plugins, deformable bodies."""
        for element in section:
            tag = f"{section.tag}_{element.tag}"
            yield ET.Element(tag, name=element.get("name", ""))

    # -- bodies --------------------------------------------------------------------------------------------------------

    def _children(self, owner: ET.Element, name: str, pose: Pose, usual: Defaults, nested: bool) -> None:
        """Add what a body, or a frame in it, contains; `pose` is its pose in the world."""
        for element in owner:
            if element.tag not in _OF_BODY:
                raise InputError(self.path, f"{label(owner)}/<{element.tag}>", "is not supported; remove it")
            if element.tag in ("body", "frame"):
                inner = usual.child(element.get("childclass"))
                placed = pose @ self.file.pose(element)
                if element.tag == "frame":
                    self._children(element, name, placed, inner, True)
                else:
                    self._body(element, name, placed, inner)
            elif element.tag == "site":
                given = usual.of(element)
                self._site(given, name, pose @ self.file.pose(given))
            elif nested and element.tag in ("inertial", "joint", "freejoint"):
                raise InputError(self.path, f"<frame>/<{element.tag}>", "is not supported; write it into the body")

    def _body(self, body: ET.Element, parent: str, pose: Pose, usual: Defaults) -> None:
        name = body.get("name") or free_name(self.taken, "body")
        self.taken.add(name)
        self.poses[name] = pose
        if body.get("mocap") == "true":
            raise InputError(self.path, label(body), "is moved from outside (mocap); fix it, or give it a joint")
        joints = [usual.of(joint) for joint in body.findall("joint")]
        free = body.find("freejoint") is not None or any(joint.get("type") == "free" for joint in joints)
        link = ET.Element("link", name=name)
        _text(link, "pose", pose.text())
        self._weight(body, link)
        add_shapes(self.file, body, link, usual)
        if not free:
            carrier = parent
            for k, joint in enumerate(joints):
                last = k == len(joints) - 1
                child = name if last else free_name(self.taken, f"{name}_{k + 1}")
                if not last:  # a body without mass between two of its joints
                    self.taken.add(child)
                    self.poses[child] = pose
                    between = ET.SubElement(self.model, "link", name=child)
                    _text(between, "pose", pose.text())
                    _massless(between)
                self._joint(joint, carrier, child, pose, link if carrier == "world" and last else None)
                carrier = child
            if not joints:
                self._fixed(parent, name)
        self.model.append(link)
        self._children(body, name, pose, usual, False)

    def _weight(self, body: ET.Element, link: ET.Element) -> None:
        (share,) = self.file.numbers(body, "gravcomp", 1, "0")
        if share not in (0.0, 1.0):
            raise InputError(self.path, f"{label(body)} gravcomp", f"is {share:g}; 0 and 1 are supported")
        if share:
            _text(link, "gravity", "false")

    def _fixed(self, parent: str, child: str) -> None:
        name = free_name(self.taken, f"{child}_to_{parent}")
        self.taken.add(name)
        joint = ET.SubElement(self.model, "joint", name=name, type="fixed")
        _text(joint, "parent", parent)
        _text(joint, "child", child)

    def _site(self, site: ET.Element, body: str, pose: Pose) -> None:
        """Keep a named site of a body as a frame, which is a point of the machine."""
        name = site.get("name", "")
        self.sites[name] = body, pose
        if name and body != "world" and name not in self.taken:
            self.taken.add(name)
            frame = ET.SubElement(self.model, "frame", name=name, attached_to=body)
            _text(frame, "pose", (self.poses[body].inverse() @ pose).text()).set("relative_to", body)

    # -- joints --------------------------------------------------------------------------------------------------------

    def _joint(self, joint: ET.Element, parent: str, child: str, pose: Pose, grounded: ET.Element | None) -> None:
        """Add a joint of a body at a pose; `grounded` is its link if the joint holds it at the world."""
        kind, where = joint.get("type", "hinge"), label(joint)
        if kind not in _JOINTS:
            raise InputError(self.path, where, f'has type "{kind}"; {nearest(kind, _JOINTS)}')
        theirs = joint.get("name", "")
        name = free_name(self.taken, theirs or f"{child}_joint")
        self.taken.add(name)
        if theirs:
            self.names[theirs] = name
            if name != theirs:
                self.notes.append(f"joint {theirs} has the name of another part: called {name}")
        made = ET.SubElement(self.model, "joint", name=name, type=_JOINTS[kind])
        place = Pose(pose.rotation, pose.rotation @ self.file.numbers(joint, "pos", 3, "0 0 0") + pose.translation)
        _text(made, "pose", place.text()).set("relative_to", "__model__")
        _text(made, "parent", parent)
        _text(made, "child", child)
        axis = ET.SubElement(made, "axis")
        _text(axis, "xyz", _words(self.file.numbers(joint, "axis", 3, "0 0 1")))
        unit = self.file.angle if kind == "hinge" else 1.0
        (start,) = self.file.numbers(joint, "ref", 1, "0")
        low, high = self.file.numbers(joint, "range", 2, "0 0")
        limited = joint.get("limited", "auto")
        if limited == "true" or (limited == "auto" and joint.get("range") is not None and self.file.autolimits):
            limit = ET.SubElement(axis, "limit")
            _text(limit, "lower", repr(float(unit * (low - start))))
            _text(limit, "upper", repr(float(unit * (high - start))))
        self._dynamics(joint, axis, unit, start, theirs)
        self._armature(joint, name, axis, pose, grounded if kind == "hinge" else None)

    def _dynamics(self, joint: ET.Element, axis: ET.Element, unit: float, start: float, name: str) -> None:
        """Add springs, damping, friction; springs of position actuators are springs too."""
        values = [float(self.file.numbers(joint, key, 1, "0")[0]) for key in ("stiffness", "damping", "frictionloss")]
        (stiffness, damping, friction), (rest,) = values, self.file.numbers(joint, "springref", 1, "0")
        drive = self.feedback.get(name, Feedback(0.0, 0.0))
        whole = stiffness + drive.stiffness
        pull = stiffness * unit * (rest - start) - drive.stiffness * unit * start
        if not any((whole, damping + drive.damping, friction)):
            return
        made = ET.SubElement(axis, "dynamics")
        given = damping + drive.damping, friction, whole, pull / whole if whole else 0.0
        for key, value in zip(("damping", "friction", "spring_stiffness", "spring_reference"), given, strict=True):
            _text(made, key, repr(float(value)))

    def _armature(self, joint: ET.Element, name: str, axis: ET.Element, pose: Pose, link: ET.Element | None) -> None:
        """Add a rotor's inertia to a link that turns about the ground; mark others."""
        (inertia,) = self.file.numbers(joint, "armature", 1, "0")
        if not inertia:
            return
        if link is None:
            said = "acts on a relative motion; add a link for the rotor, or ignore it where it is small"
            self.notes.append(f"{MARK}armature {inertia:g} of joint {name} left out: it {said}")
            return
        direction = np.array([float(word) for word in (axis.findtext("xyz") or "").split()])
        direction /= np.linalg.norm(direction)
        disc = np.eye(3) + np.outer(direction, direction)  # which no body's moments contradict
        tensor = link.find("inertial/inertia")
        assert tensor is not None  # of `add_shapes`
        write_tensor(tensor, tensor_of(self.path, tensor, label(link)) + 0.5 * inertia * disc)
        self.notes.append(f"armature {inertia:g} kg m2 of joint {name}: added to the inertia of {link.get('name')}")

    # -- constraints ---------------------------------------------------------------------------------------------------

    def _equality(self, constraint: ET.Element) -> None:
        """Convert a constraint; one that is not active is left out with a note."""
        given = self.file.defaults.child(constraint.get("class")).of(constraint, "equality")
        where, make = label(constraint), _EQUALITIES.get(constraint.tag)
        if given.get("active", "true") == "false":
            self.notes.append(f"{where} left out: it is not active")
        elif make is None:
            raise InputError(self.path, f"{where} in <equality>", f"is not supported; {nearest('', _EQUALITIES)}")
        else:
            make(self, given, where)

    def _points(self, given: ET.Element, where: str) -> list[tuple[str, Pose]]:
        """Return the two bodies of a constraint, and its frames on both in the world."""
        if given.get("site1") is not None:
            names = [given.get(key, "") for key in ("site1", "site2")]
            for name in names:
                if name not in self.sites:
                    raise InputError(self.path, where, f'names site "{name}"; {nearest(name, self.sites)}')
            return [self.sites[name] for name in names]
        bodies = [given.get("body1", ""), given.get("body2", "world")]
        for name in bodies:
            if name not in self.poses:
                raise InputError(self.path, where, f'names body "{name}"; {nearest(name, self.poses)}')
        anchor = self.file.numbers(given, "anchor", 3, "0 0 0")
        pose = self.poses[bodies[0]]
        place = Pose(np.eye(3), pose.rotation @ anchor + pose.translation)
        return [(name, place) for name in bodies]

    def _connect(self, given: ET.Element, where: str) -> None:
        ball = ET.SubElement(self.model, "drake:ball_constraint", name=self._free(given, "connect"))
        for body, point, (name, place) in zip("AB", ("AP", "BQ"), self._points(given, where), strict=True):
            here = (self.poses[name].inverse() @ place).translation
            _text(ball, f"drake:ball_constraint_body_{body}", name)
            _text(ball, f"drake:ball_constraint_p_{point}", _words(here))

    def _weld(self, given: ET.Element, where: str) -> None:
        if np.any(self.file.numbers(given, "relpose", 7, "0 0 0 1 0 0 0")[:3]):
            raise InputError(self.path, where, "has a relpose; place the bodies as they shall be welded, and remove it")
        weld, ends = ET.SubElement(self.model, "drake:weld_constraint"), self._points(given, where)
        for tag, (name, place) in zip(("parent", "child"), ends, strict=True):
            if given.get("site1") is None:
                place = self.poses[ends[0][0]]
            frame = free_name(self.taken, f"weld_{tag}")
            self.taken.add(frame)
            at = ET.SubElement(self.model, "frame", name=frame, attached_to=name)
            _text(at, "pose", (self.poses[name].inverse() @ place).text()).set("relative_to", name)
            _text(weld, tag, frame)

    def _coupled(self, given: ET.Element, where: str) -> None:
        polynomial = self.file.numbers(given, "polycoef", None, "0 1 0 0 0")
        constant, ratio, *curve = [*map(float, polynomial), 0.0, 0.0][: max(len(polynomial), 2)]
        if any(curve):
            raise InputError(self.path, where, "couples joints by a curve; polycoef must be two numbers and zeros")
        names = [given.get(key, "") for key in ("joint1", "joint2")]
        if not names[1]:
            raise InputError(self.path, where, "holds a joint; remove the joint, or weld the body")
        for name in names:
            if name not in self.names:
                raise InputError(self.path, where, f'names joint "{name}"; {nearest(name, self.names)}')
        follower, leader = (self.names[name] for name in names)
        add_mimic(self.path, self.model, where, (follower, leader, repr(ratio), repr(constant)))

    def _free(self, given: ET.Element, name: str) -> str:
        found = free_name(self.taken, given.get("name") or name)
        self.taken.add(found)
        return found


_EQUALITIES = {"connect": _Conversion._connect, "weld": _Conversion._weld, "joint": _Conversion._coupled}


def _massless(link: ET.Element) -> None:
    inertial = ET.SubElement(link, "inertial")
    _text(inertial, "mass", "0")
    tensor = ET.SubElement(inertial, "inertia")
    for key in ("ixx", "iyy", "izz"):
        _text(tensor, key, "0")


def _words(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _text(owner: ET.Element, tag: str, text: str) -> ET.Element:
    element = ET.SubElement(owner, tag)
    element.text = text
    return element
