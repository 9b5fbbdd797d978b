"""Elements of other programs: converted to joints or entries, marked because they change the motion, or rejected."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, nearest
from linkages.input.files.elements import number
from linkages.input.files.magnitudes import decimal_or_nan
from linkages.input.files.models import MIMICS
from linkages.input.files.raw_model import free_name
from linkages.input.files.xml import OURS, label

#: Elements between links, converted by `linkages.input.files.constraints` to joints and frames.
CONSTRAINTS = ("drake:weld_constraint", "drake:ball_constraint", "drake:linear_spring_damper")

#: Start of notes about content that changes the motion and is not in the new file.
MARK = "changes the motion: "

#: Elements that are in the new file, by owner.
CARRIED = {
    "model": ("link", "joint", "frame", "pose", "static"),
    "link": ("pose", "inertial", "visual", *OURS["links"]),
    "joint": ("pose", "parent", "child", "axis", *OURS["joints"]),
    "axis": ("xyz", "use_parent_model_frame"),
    "frame": ("pose",),
}

_IDLE = """
    mesh visual material sensor light projector battery audio_sink audio_source particle_emitter self_collide
    selfCollide self_collision_checking allow_auto_disable enable_wind must_be_base_link contact contact_coefficients
    mu mu1 mu2 fdir1 kp kd maxVel minDepth maxContacts laserRetro laser_retro slip1 slip2 origin gripper transmission
    ros2_control version description author license mujoco fixed_frame safety_controller calibration
    hardwareInterface physics provideFeedback implicitSpringDamper cfmDamping fudgeFactor stopCfm stopErp stopKp stopKd
    preserveFixedJoint disableFixedJointLumping gravity kinematic velocity_decay
    drake:collision_filter_group drake:controller_gains drake:gear_ratio drake:visual drake:rotor_inertia armature
    world/gravity world/light world/physics world/scene world/gui world/audio world/atmosphere world/magnetic_field
    world/spherical_coordinates world/road world/actor world/population world/frame world/wind
"""

#: Elements without influence on the motion of a linkage that touches nothing outside its joints, with a reason for
#: those that need one.
HARMLESS = dict.fromkeys(_IDLE.split(), "") | {
    "gazebo": "it names no link or joint",
    "collision": "links touch each other in clearance joints only",
    "limit": "it limits effort and speed only",
    "world/model": "it is static, or was not chosen",
    "world/include": "it was not found, and can only be scenery",
}

#: Elements that change the motion and have no counterpart in the new file.
ACTING = {
    "limit": "the other program stops the joint there; write [stops] into the experiment if the motion reaches it",
    "plugin": "it can move joints or apply forces; write its drives or loads into the experiment",
    "world/plugin": "it can move joints or apply forces; write its drives or loads into the experiment",
    "world/state": "the other program starts there; write start angles into the experiment",
}

#: Plugins that measure, show or set up the simulation, by their file or name.
_PASSIVE = re.compile(
    r"publish|sensor|camera|lidar|laser|navsat|contact|odometr|altimeter|magnetometer|logger|record|broadcast|scene|visual"
    r"|user-?commands|physics|touch|disable-?link|(?<![a-z])(imu|ray|gps|p3d|light|label|gui)(?![a-z])",
    re.IGNORECASE,
)

_REFUSED = {
    "drake:linear_bushing_rpy": "is a soft joint; write a revolute joint, or springs in the experiment",
    "drake:tendon_constraint": "is not supported; write a gear, or springs in the experiment",
    "drake:joint": "is of a type that no planar linkage has; a planar linkage has revolute, prismatic and fixed joints",
    "world/joint": "joins models that are not imported; remove it, or write it into the model",
}
_ROTORS = ("drake:rotor_inertia", "armature")


class Entry(NamedTuple):
    """An entry of an experiment for an element (its name in messages) that the mechanism's file cannot contain.

    Table and name are such as "gears" and "A_mimic". The values by key are in SI units; joint coordinates are zero in
    the reference configuration.
    """

    element: str
    table: str
    name: str
    values: dict[str, Any]

    @property
    def joints(self) -> tuple[str, ...]:
        """Return the joints of the entry."""
        found = self.values.get("joints", self.values.get("joint", self.name if self.table == "drives" else ()))
        return found if isinstance(found, tuple) else (str(found),)

    @property
    def couples(self) -> bool:
        """Check whether it couples the coordinates of two joints."""
        return self.table == "gears"

    @property
    def keys(self) -> dict[str, Any]:
        """Return the values as an experiment has them."""
        return {key: list(value) if isinstance(value, tuple) else value for key, value in self.values.items()}

    def merged(self, old: str, new: str, sign: float) -> Entry:
        """Return the entry for a joint that was merged with another, whose coordinate is `sign` times its own."""
        if old not in self.joints:
            return self
        values = dict(self.values)
        if self.table == "gears":
            values["joints"] = tuple(new if name == old else name for name in self.joints)
            values["ratio"] *= sign
            values["offset"] *= sign if old == self.joints[1] else 1.0
        elif self.table == "drives":
            return self._replace(name=new, values=values | {"angle": sign * values["angle"]})
        else:
            values["joint"] = new
            if "free_angle" in values:
                values["free_angle"] *= sign
        return self._replace(values=values)

    def redrawn(self, at: Mapping[str, float]) -> Entry:
        """Return the entry for a new reference configuration at these old joint coordinates."""
        values, here = dict(self.values), [at[name] for name in self.joints]
        if self.table == "gears":
            values["offset"] += values["ratio"] * here[0] - here[1]
        for key in ("free_angle", "angle"):
            if key in values:
                values[key] -= here[0]
        return self._replace(values=values)

    def in_plane(self, basis: Array) -> Entry:
        """Return the entry with a force in plane axes, not the world's; basis (3, 3) has x_P, y_P, n as columns."""
        if "force" not in self.values or self.table != "forces":
            return self
        force = np.array(self.values["force"]) @ basis[:, :2]
        return self._replace(values=self.values | {"force": tuple(map(float, force + 0.0))})

    @property
    def note(self) -> str:
        """Return a line for users."""
        shown = ", ".join(f"{key} = {_toml(value)}" for key, value in self.values.items())
        where = f'{self.table}."{self.name.replace(".", "_") if self.table != "drives" else self.name}"'
        return f"{MARK}{self.element} left out; write it into the experiment as {where} = {{{shown}}}"


@dataclass
class Foreign:
    """Elements of an imported model other than links, joints and frames.

    They are constraints and springs between links, entries of the experiment, a note for each constraint that became a
    joint, and links without gravity.
    """

    path: Path
    constraints: list[ET.Element] = field(default_factory=list)
    entries: list[Entry] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    weightless: list[str] = field(default_factory=list)


def influence(owner: ET.Element, element: ET.Element, limited: set[str]) -> tuple[str, str]:
    """Describe the influence of an element on the motion that is left out of a model, link, joint or axis.

    `limited` has the joints with a limited coordinate. The result is `MARK`, or nothing if there is no influence, and
    the reason, which can be empty.
    """
    if owner.tag == "joint" and owner.get("type") == "fixed":
        return "", ""
    passive = element.tag.endswith("plugin") and _PASSIVE.search(_named(element))
    if passive or (element.tag == "limit" and owner.get("name") not in limited):
        return "", HARMLESS.get(element.tag, "")
    if element.tag in ACTING:
        return MARK, ACTING[element.tag]
    if element.tag in HARMLESS or element.tag.startswith("linkages:"):
        return "", HARMLESS.get(element.tag, "")
    return MARK, "it is unknown; check whether it moves joints or applies forces"


def is_detachable(element: ET.Element) -> bool:
    """Check whether an element is Gazebo's plugin that joins two links until a message parts them."""
    named = element.tag == "plugin" and "detachable" in _named(element).lower()
    return named and element.find("child_link") is not None


def _named(plugin: ET.Element) -> str:
    """Return file and name of a plugin, with hyphens for underscores."""
    return f"{plugin.get('filename', '')} {plugin.get('name', '')}".replace("_", "-")


def take_foreign(path: Path, model: ET.Element) -> Foreign:
    """Remove from a model all elements that change the motion; InputError if one has no counterpart here."""
    found = Foreign(path)
    for holder in [model, *model.findall("link"), *model.findall("joint")]:
        for plugin in holder.findall("plugin"):
            if _plugin(found, model, plugin):
                holder.remove(plugin)
    for joint in model.findall("joint"):
        if joint.get("type") == "ball":
            _turn_in_the_plane(path, label(joint), model, joint)
            joint.set("type", "revolute")
            found.notes.append(f"ball joint {joint.get('name')}: a revolute joint in the plane")
    for element in list(model):
        if element.tag in CONSTRAINTS:
            found.constraints.append(element)
            model.remove(element)
        elif element.tag not in ("link", "joint"):
            _refuse(path, element, label(model))
    for link in model.findall("link"):
        _check_link(path, link)
        for gravity in link.findall("gravity"):
            if (gravity.text or "").strip().lower() in ("false", "0"):
                found.weightless.append(link.get("name", ""))
                link.remove(gravity)
    for joint in model.findall("joint"):
        gears: list[Entry] = []
        for holder in (joint, *joint.findall("axis")) if joint.get("type") != "fixed" else ():
            for element in list(holder):
                if element.tag in MIMICS:
                    gears.append(_gear(path, model, joint, element))
                    holder.remove(element)
                    continue
                _refuse(path, element, label(joint))
                if element.tag == "dynamics":
                    found.entries += _dynamics(path, joint, element)
                elif element.tag == "initial_position":
                    start = number(path, holder, element.tag, f"{label(joint)}/<axis>")
                    if start:  # a drive without torque that starts there
                        values = {"torque" if _turns(joint) else "force": 0.0, "angle": start}
                        said, name = f"<initial_position> of joint {joint.get('name')}", joint.get("name", "")
                        found.entries.append(Entry(said, "drives", name, values))
                else:
                    continue
                holder.remove(element)
        if any(gear.values != gears[0].values for gear in gears):
            raise InputError(path, label(joint), "mimics in two different ways; keep one")
        found.entries += gears[:1]
    entries = {(entry.table, entry.name): entry for entry in found.entries}
    if twice := [entry for entry in found.entries if entries[entry.table, entry.name] is not entry]:
        raise InputError(path, twice[0].element, "is given twice; keep one")
    return found


def add_mimic(path: Path, model: ET.Element, where: str, values: tuple[str, str, str, str]) -> None:
    """Let a joint mimic another: values are its name, the other's name, multiplier and offset."""
    name, leader, multiplier, offset = (value.strip() for value in values)
    axis = deep(joint_of(path, model, where, name), "axis")
    ET.SubElement(axis, "mimic", joint=leader, multiplier=multiplier, offset=offset)


def joint_of(path: Path, model: ET.Element, where: str, name: str) -> ET.Element:
    """Return the joint of a name that an element gives."""
    joints = {joint.get("name", ""): joint for joint in model.findall("joint")}
    if name not in joints:
        raise InputError(path, where, f'names joint "{name}", which does not exist; {nearest(name, joints)}')
    return joints[name]


def deep(owner: ET.Element, place: str) -> ET.Element:
    """Return the element at a place below another, such as "axis/dynamics"; adds what is missing."""
    for tag in place.split("/"):
        found = owner.find(tag)
        owner = ET.SubElement(owner, tag) if found is None else found
    return owner


def _plugin(found: Foreign, model: ET.Element, plugin: ET.Element) -> bool:
    """Convert a plugin that makes joints or gears; return False for others."""
    path, where, kind = found.path, label(plugin), _named(plugin).lower()
    given = {part.tag: (part.text or "").strip() for part in plugin}
    if "mimic" in kind and "mimicJoint" in given:
        values = given["mimicJoint"], given.get("joint", ""), given.get("multiplier", "1"), given.get("offset", "0")
        add_mimic(path, model, where, values)
        return True
    taken = {part.get("name", "") for part in model}
    if is_detachable(plugin):
        other, name = given.get("child_model", ""), given["child_link"]
        ends = given.get("parent_link", ""), name if other == model.get("name") else f"{other}::{name}"
        if ends[1] not in taken:
            return False  # a joint to a model that is not imported
        type_, of = "fixed", "detachable_joint"
    elif re.search("closed-?loop", kind) and {"parent", "child"} <= given.keys():
        ends, type_, of = (given["parent"], given["child"]), "revolute", given.get("joint") or "closed_loop"
    else:
        return False
    name = free_name(taken, of)
    joint = ET.SubElement(model, "joint", name=name, type=type_)
    if type_ == "revolute":
        deep(joint, "pose").text = f"{given.get('position', '0 0 0')} {given.get('rotation', '0 0 0')}"
        _turn_in_the_plane(path, where, model, joint)
    for end, link in zip(("parent", "child"), ends, strict=True):
        deep(joint, end).text = link
    found.notes.append(f"{where}: {type_} joint {name} between {ends[0]} and {ends[1]}")
    return True


def _turn_in_the_plane(path: Path, where: str, model: ET.Element, joint: ET.Element) -> None:
    """Give a joint the axis of the first revolute joint, which is the plane's normal."""
    first = next((j for j in model.iterfind("joint") if j.find("axis/xyz") is not None and _turns(j)), None)
    if first is None:
        raise InputError(path, where, "is in a mechanism without revolute joints, so its plane is unknown")
    xyz, own = deep(joint, "axis/xyz"), deep(first, "axis/xyz")
    xyz.text = own.text
    xyz.set("expressed_in", own.get("expressed_in") or first.get("name") or "")


def _turns(joint: ET.Element) -> bool:
    return joint.get("type") in ("revolute", "continuous")


def _refuse(path: Path, element: ET.Element, where: str) -> None:
    problem = _REFUSED.get(element.tag)
    if problem is None and element.tag.removeprefix("world/").startswith("drake:") and element.tag not in HARMLESS:
        problem = "may change the motion and is not supported; remove it"
    parts = element.iter() if not element.tag.startswith("world/") else ()
    inertia = next((part for part in parts if part.tag in _ROTORS), None)
    if inertia is not None:
        value = inertia.text if inertia.get("value") is None else inertia.get("value")
        inertial = "adds the rotor's inertia to the joint; remove it, and add it to the driven link"
        problem = None if _is_zero(value) else inertial
    if problem is not None:
        raise InputError(path, f"{where}/<{(element if inertia is None else inertia).tag}>", problem)


def _check_link(path: Path, link: ET.Element) -> None:
    """Reject a link with forces other than weight and joint forces."""
    for key, usual in (("gravity", ("true", "1", "false", "0")), ("kinematic", ("false", "0"))):
        value = (link.findtext(key) or usual[0]).strip().lower()
        if value not in usual:
            raise InputError(path, f"{label(link)}/<{key}>", f"is {value}, which is not supported; remove it")
    for place in ("velocity_decay", "inertial/fluid_added_mass"):
        if any(not _is_zero(part.text) for part in link.iterfind(f"{place}/*")):
            raise InputError(path, f"{label(link)}/<{place}>", "is not supported; remove it")
    for element in link:
        _refuse(path, element, label(link))


def _is_zero(text: str | None) -> bool:
    return decimal_or_nan((text or "0").strip()) == 0.0


# -- entries of the experiment -----------------------------------------------------------------------------------------


def _gear(path: Path, model: ET.Element, joint: ET.Element, element: ET.Element) -> Entry:
    """Convert a joint that mimics another to a gear: multiplier (q - reference) + offset."""
    name, where = joint.get("name", ""), f"{label(joint)}/<{element.tag}>"
    leader = element.get("joint", "")
    names = [other.get("name", "") for other in model.findall("joint") if other is not joint]
    if leader not in names:
        raise InputError(path, where, f'follows joint "{leader}"; {nearest(leader, names)}')
    given = {}
    for key, default in (("multiplier", 1.0), ("offset", 0.0), ("reference", 0.0)):
        if (text := element.get(key)) is not None:
            ET.SubElement(element, key).text = text
        given[key] = number(path, element, key, where, default)
    if given["multiplier"] == 0.0:
        raise InputError(path, where, "has the multiplier 0; make the joint fixed")
    offset = given["offset"] - given["multiplier"] * given["reference"]
    values = {"joints": (leader, name), "ratio": given["multiplier"], "offset": offset}
    return Entry(f"<{element.tag}> of joint {name}", "gears", f"{name}_mimic", values)


def _dynamics(path: Path, joint: ET.Element, element: ET.Element) -> Iterator[Entry]:
    """Convert the <dynamics> of a joint to friction and a spring."""
    name, where = joint.get("name", ""), f"{label(joint)}/<axis>/<dynamics>"
    keys = ("damping", "friction", "spring_stiffness", "spring_reference")
    if other := [part.tag for part in element if part.tag not in keys and not _is_zero(part.text)]:
        raise InputError(path, f"{where}/<{other[0]}>", f"is unknown; {nearest(other[0], keys)}")
    damping, friction, stiffness, free = (number(path, element, key, where, 0.0) for key in keys)
    said = f"<dynamics> of joint {name}"
    if springs := stiffness != 0.0 or (_turns(joint) and damping != 0.0):
        spring = {"joint": name, "stiffness": stiffness, "free_angle": free, "damping": damping}
        yield Entry(said, "torsion_springs", f"{name}_spring", spring)
    losses = {"constant": friction, "viscous": 0.0 if springs else damping}
    if any(losses.values()):
        given = {key: value for key, value in losses.items() if value}
        yield Entry(said, "frictions", f"{name}_friction", {"joint": name, **given})


def _toml(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else f"{value!r}"
