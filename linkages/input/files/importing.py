"""Import of mechanisms of other programs, with a line for every change and omission."""

from __future__ import annotations

import copy
import os
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError, listed, nearest
from linkages.input.files.constraints import joined
from linkages.input.files.elements import numbers
from linkages.input.files.foreign import CARRIED, MARK, Entry, Foreign, influence, is_detachable, take_foreign
from linkages.input.files.formats import check_root, check_suffix
from linkages.input.files.joint_places import placed, take_joint_frames
from linkages.input.files.magnitudes import ALIGNED, SMALLEST, decimal_or_nan
from linkages.input.files.mjcf import sdf_of_mjcf
from linkages.input.files.models import flattened, is_static, update
from linkages.input.files.pairs import in_plane
from linkages.input.files.raw_model import Pose, RawJoint, RawModel
from linkages.input.files.reading import read_whole
from linkages.input.files.rigid import complete_inertials, correct_rounded, fixed_into, without_massless
from linkages.input.files.sdf import read_model
from linkages.input.files.urdf import sdf_of
from linkages.input.files.xacro_text import expanded, is_xacro
from linkages.input.files.xml import DEEPEST, label, parse_xml

_SHAPES = ("box", "cylinder", "sphere", "capsule", "ellipsoid")
_SAME_PLACE = 1e-6  # relative to the size of the mechanism: closer places coincide
_FAR = 1e6  # limits beyond this count as absent [rad or m]
_OF_INCLUDE = ("pose", "placement_frame", "static")  # of an <include>, instead of the included model's
_EXACT = 1e-9  # angles below this are rounding of the computer [rad]
USUAL_GRAVITY = (0.0, 0.0, -9.81)  # proposed if the file says nothing [m/s2]
_GRAVITY = (0.0, 0.0, -9.8)  # of an SDFormat world without <gravity> [m/s2]

#: Names in messages of elements that only URDF has.
_URDF_NAMES = {
    "<axis>/<limit>": "<limit>", "<axis>/<dynamics>": "<dynamics>", "<axis>/<mimic>": "<mimic>",
    "<axis>/<xyz>": "<axis> xyz", "<axis>/<initial_position>": "<gazebo>/<initialJointPosition>",
    "<model name=": "<robot name=", "<velocity_decay>": "<gazebo>/<dampingFactor>", "<pose>": "<origin>",
}  # fmt: skip


class Imported(NamedTuple):
    """An imported mechanism: limits of joint coordinates [rad or m], a line for every change and omission, entries.

    The coordinates are zero in the reference configuration. The entries belong into the experiment, as the gravity of
    the file's world or links [m/s2]; None if the file says nothing. `displaced`: joints may be at different places on
    both links.
    """

    model: RawModel
    limits: dict[str, tuple[float, float]]
    notes: list[str]
    entries: list[Entry]
    gravity: tuple[float, ...] | None
    displaced: bool


def import_model(path: Path, name: str = "", joints_at_parent: bool = False) -> Imported:
    """Read an SDFormat or URDF file that was written for another program.

    Use `linkages.load_mechanism` for files of this package. Elements that change the motion become joints or entries of
    an experiment, or are rejected. Nested models and included local files become one model. Links that are fixed to
    each other become one link, one link of each floating group is fixed to the world, and revolute joints on one axis
    between the same two links become one joint. Axes within 1e-3 rad of the plane's normal are aligned with it, and
    numbers below 1e-50 are zero. A `name` chooses one of several models that are not static. With `joints_at_parent`
    the place of a joint on its parent is the frame that <parent> names; SDFormat only takes the frame's link from it.
    """
    model = _model(path, (), name)
    try:
        return _imported(path, model, joints_at_parent)
    except InputError as problem:
        if model.get("notation") != "URDF":
            raise
        where, what = problem.where, problem.problem
        for theirs, own in _URDF_NAMES.items():
            where, what = where.replace(theirs, own), what.replace(theirs, own)
        raise InputError(problem.source, where, what) from None


def _imported(path: Path, model: ET.Element, joints_at_parent: bool) -> Imported:
    for element in model.iter():  # numbers below the smallest plausible one are rounding errors of other programs
        words = (element.text or "").split()
        if any("e-" in word.lower() for word in words):
            element.text = " ".join("0" if abs(decimal_or_nan(word)) < SMALLEST else word for word in words)
    by_default = complete_inertials(path, model) if model.get("notation") != "URDF" else []
    rounded = correct_rounded(path, model)
    limits = {joint.get("name", ""): ends for joint in model.findall("joint") if (ends := _limits(path, joint))}
    two_places = take_joint_frames(model)
    foreign = take_foreign(path, model)
    notes = list(filter(None, model.attrib.pop("told", "").splitlines()))
    notes += _leave_out(model, {name for name, ends in limits.items() if min(np.abs(ends)) < _FAR})
    raw = read_model(path, model)
    if model.get("notation") != "URDF":  # loops of URDF, written as frames, stay as they are
        raw = placed(raw, two_places, joints_at_parent, notes)
    raw = joined(foreign, raw)
    notes += foreign.notes
    if rounded:
        notes.append(f"moments of inertia of {', '.join(rounded)} are rounded: the smaller ones raised by up to 0.05 %")
    raw = _on_the_ground(raw, notes)
    standing = raw.chains("fixed").of["world"]
    if free := [name for name in by_default if name not in standing]:
        taken = "values that <inertial> lacks are 1 kg and 1 kg m2 about each axis, as SDFormat defines; is that meant?"
        notes.append(f"link{'s' * (len(free) > 1)} {', '.join(free)}: {taken}")
    raw, gravity = _gravity(model, raw, foreign, standing)
    raw = in_plane(raw, notes)
    raw = _aligned(_rigid(path, raw, notes), notes)
    raw = _coaxial(raw, foreign, notes)
    raw = without_massless(path, raw)
    if not raw.links:
        raise InputError(path, label(model), "has no moving link: every link is fixed to the world")
    names = {joint.name for joint in raw.joints}
    for entry in foreign.entries:
        if gone := [name for name in entry.joints if name not in names]:
            problem = f'joint "{gone[0]}" was merged with another, or removed; name a joint that is kept'
            raise InputError(path, entry.element, problem)
        if len(set(entry.joints)) < len(entry.joints):
            raise InputError(path, entry.element, f'couples joint "{entry.joints[0]}" with itself')
    limits = {name: ends for name, ends in limits.items() if name in names}
    displaced = model.get("notation") != "URDF" and bool(two_places or joints_at_parent)
    return Imported(raw, limits, notes, foreign.entries, gravity, displaced)


def _model(path: Path, passed: tuple[Path, ...], name: str = "") -> ET.Element:
    """Read the <model> of a file, the only one that is not static or the one with a name, with its included models.

    Its attributes "gravity" and "notation" say which gravity a world has, and that the file is URDF.
    """
    here = path.resolve()
    if here in passed or len(passed) > DEEPEST:
        raise InputError(passed[-1], f"<include> {path.name}", "includes itself; break the circle")

    def follow(include: ET.Element) -> ET.Element:
        model = copy.deepcopy(_model(_included(path, include), (*passed, here)))
        if include.get("merge") == "true":
            raise InputError(path, "<include>", "is merged, which is not supported; remove merge")
        model.set("name", include.findtext("name", model.get("name", "")).strip())
        if other := [part.tag for part in include if part.tag not in ("uri", "name", "plugin", *_OF_INCLUDE)]:
            problem = "is not supported; write the change into the included file"
            raise InputError(path, f"<include>/<{other[0]}>", problem)
        model.extend(include.findall("plugin"))
        for key in _OF_INCLUDE:
            if (own := include.find(key)) is not None:
                for old in model.findall(key):
                    model.remove(old)
                model.append(own)
        return model

    check_suffix(path)
    root = parse_xml(path, read_whole(path))
    if root.tag == "robot":
        root = expanded(path) if is_xacro(root) else root
        return sdf_of(path, _chosen(path, [root], name, []))
    if root.tag == "mujoco":
        return sdf_of_mjcf(path, root)
    check_root(path, root)
    update(path, root)
    world = root.find("world")
    world = ET.Element("world") if world is None else world
    models, missing = [*root.findall("model"), *world.findall("model")], []
    for element in world.findall("include"):
        try:
            _included(path, element)
        except InputError as problem:
            missing.append(problem)
            element.set("name", element.findtext("uri", "").strip())  # left out, if there is another model
        else:
            world.remove(element)
            models.append(follow(element))
    model = _chosen(path, models if name else _joined_models(world, models), name, missing)
    for key in ("gravity", "notation"):
        model.attrib.pop(key, None)
    placed = model.get("placement_frame") or model.findtext("placement_frame")
    if placed or any(pose.get("relative_to") not in (None, "", "world") for pose in model.findall("pose")):
        raise InputError(path, label(model), "is placed relative to a frame, which is not supported; give its <pose>")
    for joint in world.findall("joint"):
        if _own_joint(model, joint):
            model.append(joint)
            world.remove(joint)
    if root.find("world") is not None:
        gravity = world.find("gravity")
        gravity = world.find("physics/gravity") if gravity is None else gravity  # SDFormat before 1.5
        values = numbers(path, gravity, 3, "<world>/<gravity>") if gravity is not None else _GRAVITY
        model.set("gravity", " ".join(repr(float(value)) for value in values))
    inside = [id(part) for part in model]
    others = {id(part): part for part in (*models, *world) if part.tag != "gravity" and id(part) not in inside}
    for element in others.values():
        if element is not model:
            element.tag = f"world/{element.tag}"  # left out, with a note
            model.append(element)
    return flattened(path, model, follow)


def _chosen(path: Path, models: list[ET.Element], name: str, missing: list[InputError]) -> ET.Element:
    """Return the model of a name; without a name the only one, or the only one that is not static."""
    names = [model.get("name", "") for model in models]
    if name and name not in names:
        raise InputError(path, f'<model name="{name}">', f"does not exist; {nearest(name, names)}")
    found = [model for model in models if (model.get("name") == name if name else not is_static(model))]
    found = models if len(models) == 1 else found
    if not found and missing:
        raise missing[0]
    if len(found) != 1:
        many = f": {listed([model.get('name', '') for model in found])}; choose one with --model NAME" if found else ""
        problem = f"has {len(found)} <model> elements that are not static{many or '; one is needed'}"
        raise InputError(path, "<sdf>", problem)
    return found[0]


def _joined_models(world: ET.Element, models: list[ET.Element]) -> list[ET.Element]:
    """Put models that are not static into one, with the joints of the world, if any joint connects them."""
    joints, moving = world.findall("joint"), [model for model in models if not is_static(model)]
    if len(moving) < 2 or not (joints or any(is_detachable(plugin) for model in moving for plugin in model)):
        return models
    whole = ET.Element("model", name=world.get("name") or "world")
    whole.extend([*moving, *joints])
    for joint in joints:
        world.remove(joint)
        for parent in joint.findall("parent"):
            owner = (parent.text or "").strip().partition("::")[0]
            if any(is_static(model) and model.get("name") == owner for model in models):
                parent.text = "world"
    for model in moving:
        if model in list(world):
            world.remove(model)
    return [whole, *(model for model in models if is_static(model))]


def _own_joint(model: ET.Element, joint: ET.Element) -> bool:
    """Check whether a joint of a world joins only the model and the world, and write it as one of the model."""
    start = f"{model.get('name')}::"
    ends = [end for tag in ("parent", "child") for end in joint.findall(tag)]
    names = [(end.text or "").strip() for end in ends]
    if len(names) != 2 or not all(name == "world" or name.startswith(start) for name in names):
        return False
    for end, name in zip(ends, names, strict=True):
        end.text = name.removeprefix(start)
    for part in joint.iter():
        for key in ("relative_to", "expressed_in"):
            if part.get(key):
                part.set(key, part.get(key, "").removeprefix(start))
    return True


def _gravity(
    model: ET.Element, raw: RawModel, foreign: Foreign, standing: set[str]
) -> tuple[RawModel, tuple[float, ...] | None]:
    """Return the gravity of the file's world; zero if no link that moves has a weight.

    Forces in the experiment cancel the weight of single links; the mechanism has frames at their mass centres.
    """
    told = model.get("gravity")
    gravity = tuple(map(float, told.split())) if told else None
    heavy = [link for link in raw.links if link.mass > 0.0 and link.name not in standing]
    off = [link for link in heavy if link.name in foreign.weightless]
    if off and len(off) == len(heavy):
        return raw, (0.0, 0.0, 0.0)
    frames = dict(raw.frames)
    for link in off:
        frame = raw.free_name(f"{link.name}_mass_centre")
        frames[frame] = link.name, Pose(np.eye(3), link.rotation @ link.com_local + link.translation)
        force = tuple(-link.mass * x for x in gravity or USUAL_GRAVITY)
        said, values = f"<gravity> of link {link.name} (with the gravity below)", {"point": frame, "force": force}
        foreign.entries.append(Entry(said, "forces", f"{link.name}_weight", values))
    return replace(raw, frames=frames), gravity


def _included(path: Path, include: ET.Element) -> Path:
    """Find the file of an <include>: in the folder of the including file or its parent, or in their folder "models"."""
    uri = include.findtext("uri", "").strip()
    scheme, _, name = uri.rpartition("://")
    if scheme not in ("", "file", "model", "package") or not name:
        raise InputError(path, f"<include> {uri}", "is not a local file; download it, and write its path")
    folders = path.parent, path.parent.parent
    for folder in (*folders, *(folder / "models" for folder in folders)):
        file = folder / name
        if os.path.isdir(file):  # unlike Path.is_dir, returns False for invalid names
            file = file / "model.sdf"
        if os.path.isfile(file):
            return file
    raise InputError(path, f"<include> {uri}", f"is neither in {path.parent} nor in its parent folder")


def _limits(path: Path, joint: ET.Element) -> tuple[float, float] | None:
    limit = joint.find("axis/limit")
    if limit is None or joint.get("type") in ("continuous", "fixed"):
        return None
    if limit.find("lower") is None and limit.find("upper") is None:
        return None
    words = limit.findtext("lower", "-inf").strip(), limit.findtext("upper", "inf").strip()
    low, high = map(decimal_or_nan, words)
    if not low <= high:
        problem = f"from {' to '.join(words)} is not a range; write two numbers, or remove it"
        raise InputError(path, f"{label(joint)}/<axis>/<limit>", problem)
    return low, high


def _leave_out(model: ET.Element, limited: set[str]) -> list[str]:
    """Remove elements that cannot be converted; return one line per kind."""
    owners: dict[tuple[str, str, str, str], list[str]] = {}
    for owner in [model, *model]:
        for holder in (owner, *owner.findall("axis")):
            for element in list(holder):
                if element.tag in CARRIED.get(holder.tag, (element.tag,)) and not _is_mesh(element):
                    continue
                element.tag = "mesh" if _is_mesh(element) else element.tag
                name = element.get("name", element.get("reference")) if owner is model else owner.get("name")
                key = owner.tag, element.tag, *influence(owner, element, limited)
                owners.setdefault(key, []).append(name or "")
                holder.remove(element)
    notes = []
    for (owner_tag, tag, mark, why), names in owners.items():
        of = "" if owner_tag == "model" else f"of {owner_tag}{'s' * (len(set(names)) > 1)} "
        named = ", ".join(dict.fromkeys(filter(None, names)))
        notes.append(mark + " ".join(f"<{tag}> {of}{named} left out{f': {why}' * bool(why)}".split()))
    return notes


def _is_mesh(element: ET.Element) -> bool:
    return element.tag == "visual" and not any(element.find(f"geometry/{shape}") is not None for shape in _SHAPES)


def _on_the_ground(model: RawModel, notes: list[str]) -> RawModel:
    """Weld one link of each floating group to the world."""
    chains = model.chains()
    children = {joint.child for joint in model.joints}
    joints = list(model.joints)
    for link in sorted(model.links, key=lambda link: link.name in children):
        if link.name in chains.of["world"]:
            continue
        chains.join("world", link.name)
        joints.append(RawJoint.fixed(f"{link.name} to world", "world", link.name))
        notes.append(f"{MARK}link {link.name} was not connected to the world: fixed to it in the file's pose")
    return replace(model, joints=tuple(joints))


def _rigid(path: Path, model: RawModel, notes: list[str]) -> RawModel:
    """Merge links that are fixed to each other into the parent; the name of the other becomes a frame.

    A link with a beam is kept: links fixed to it move with one of its sections.
    """
    kept = {link.name for link in model.links if link.determined}
    while joint := next((j for j in model.joints if j.type == "fixed" and kept.isdisjoint((j.parent, j.child))), None):
        gone, stays = (joint.parent, joint.child) if joint.child == "world" else (joint.child, joint.parent)
        notes.append(f"link {gone} is fixed to {stays}: merged into it, as a frame of that name")
        model = fixed_into(path, model, joint, gone)
    return model


def _aligned(model: RawModel, notes: list[str]) -> RawModel:
    """Align axes that rounded angles of the file have tilted: with the plane of the first revolute joint.

    The plane's normal is the nearest axis of the world, if it is as near.
    """
    normal = next((joint.axis for joint in model.joints if joint.type == "revolute"), None)
    if normal is None:
        return model
    upright = np.eye(3)[np.argmax(np.abs(normal))] * np.sign(normal[np.argmax(np.abs(normal))])
    tilts = {joint.name: _tilt(joint, normal) for joint in model.joints if joint.type != "fixed"}
    tilted = {name: tilt for name, tilt in tilts.items() if _EXACT < tilt <= ALIGNED}
    if not tilted:
        return model
    normal = upright if np.linalg.norm(np.cross(normal, upright)) <= ALIGNED else normal
    joints = []
    for joint in model.joints:
        if tilts.get(joint.name, np.inf) <= ALIGNED:
            along = joint.axis @ normal
            axis = np.sign(along) * normal if joint.type == "revolute" else joint.axis - along * normal
            joint = replace(joint, axis=axis / np.linalg.norm(axis))
        joints.append(joint)
    most = f"up to {max(tilted.values()):.2g} rad"
    notes.append(f"axes of {', '.join(tilted)} are tilted against the other axes by {most}: aligned")
    return replace(model, joints=tuple(joints))


def _tilt(joint: RawJoint, normal: Array) -> float:
    """Compute the angle between a joint's axis and the normal, or the plane if the joint is prismatic [rad]."""
    across = np.linalg.norm(np.cross(joint.axis, normal)) if joint.type == "revolute" else abs(joint.axis @ normal)
    return float(np.arcsin(min(across, 1.0)))


def _coaxial(model: RawModel, foreign: Foreign, notes: list[str]) -> RawModel:
    """Merge revolute joints on one axis between the same two links, which are one joint in the plane.

    Springs, friction and gears of a merged joint act in the joint that is kept.
    """
    places = np.array([joint.position for joint in model.joints])
    near = _SAME_PLACE * float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0
    kept: list[RawJoint] = []
    for joint in model.joints:
        twin = next((other for other in kept if _same(joint, other, near)), None)
        if twin is None:
            kept.append(joint)
        else:
            sign = float(np.sign(joint.axis @ twin.axis)) * (1.0 if joint.parent == twin.parent else -1.0)
            foreign.entries = [entry.merged(joint.name, twin.name, sign) for entry in foreign.entries]
            axis = f"joint {joint.name} has the axis of {twin.name} between the same links"
            notes.append(f"{axis}: merged into {twin.name}")
    return replace(model, joints=tuple(kept))


def _same(joint: RawJoint, other: RawJoint, near: float) -> bool:
    if {joint.type, other.type} != {"revolute"} or {joint.parent, joint.child} != {other.parent, other.child}:
        return False
    ends = (joint.position, joint.position_on_parent)
    if joint.parent != other.parent:
        ends = ends[::-1]
    return all(
        np.linalg.norm(np.cross(place - there, other.axis)) <= near
        for place, there in zip(ends, (other.position, other.position_on_parent), strict=True)
    )
