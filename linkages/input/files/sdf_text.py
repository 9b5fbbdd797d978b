"""Write a mechanism as SDFormat."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from html import escape

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.beams import beam_text
from linkages.input.files.elements import INERTIA
from linkages.input.files.raw_model import Pose, RawJoint, RawLink, RawModel

_SAME = 1e-12  # relative to the largest coordinate: places that are closer coincide


def sdf_text(model: RawModel, remarks: Sequence[str] = (), description: str = "", at_frames: bool = True) -> str:
    """Write a mechanism; `linkages.input.files.sdf.read_sdf` reads the same model back.

    Links have their poses in world axes, frames theirs on their links. A joint is at a frame of its parent and at a
    frame of its child, so that it moves with the frame. Without `at_frames` all poses are in world axes, as in files of
    earlier versions, and as Drake needs it, which knows no frames of the world. Remarks are items of the comment at the
    head of the file. A description (`linkages.input.files.description`) is stored.
    """
    comment = [line for remark in remarks for line in textwrap.wrap(f"- {remark}".replace("--", "- -"), 116)]
    frames = _Frames(model)
    joints = [line for joint in model.joints for line in _joint(joint, frames if at_frames else None)]
    body = [line for link in model.links for line in _link(link)]
    body += [
        _frame(name, link, frames.on_link(link, pose) if at_frames else pose, at_frames)
        for name, (link, pose) in frames.all.items()
    ]
    body += joints
    if description:
        body += ["<linkages:description>", *escape(description, False).splitlines(), "</linkages:description>"]
    lines = ["<!--", *comment, "-->"] if comment else []
    lines += ['<sdf version="1.9" xmlns:linkages="urn:linkages:sdf">', f"  <model name={_quoted(model.name)}>"]
    return "\n".join(['<?xml version="1.0"?>', *lines, *(f"    {line}" for line in body), "  </model>", "</sdf>", ""])


class _Frames:
    """The named frames of a model, and the additional frames of its joints."""

    def __init__(self, model: RawModel) -> None:
        self.all, self._model = dict(model.frames), model
        self._links = {link.name: link.pose for link in model.links} | {"world": Pose()}
        places = [self._links.values(), (pose for _, pose in self.all.values())]
        self._near = _SAME * max(
            (float(np.abs(pose.translation).max()) for part in places for pose in part), default=0.0
        )

    def on_link(self, link: str, pose: Pose) -> Pose:
        """Return a pose in the axes of the link that carries it."""
        return pose if link == "world" else self._links[link].inverse() @ pose

    def of_child(self, joint: RawJoint) -> tuple[str, Pose]:
        """Return name and pose of the child, or of its frame at the joint."""
        own = self._links[joint.child]
        if self._is_at(own, joint.position):
            return joint.child, own
        return self._of(joint.child, joint.position, joint.name)

    def of_parent(self, joint: RawJoint) -> tuple[str, Pose]:
        """Return name and pose of the parent's frame at the joint: the name of a link does not say a place."""
        return self._of(joint.parent, joint.position_on_parent, joint.name)

    def _of(self, link: str, place: Array, joint: str) -> tuple[str, Pose]:
        for name, (carrier, pose) in self.all.items():
            if carrier == link and self._is_at(pose, place):
                return name, pose
        taken = RawModel(self._model.name, self._model.links, self._model.joints, self.all, {})
        name, pose = taken.free_name(f"{joint}_on_{link}"), Pose(self._links[link].rotation, place)
        self.all[name] = link, pose
        return name, pose

    def _is_at(self, pose: Pose, place: Array) -> bool:
        return float(np.abs(pose.translation - place).max()) <= self._near


def _link(link: RawLink) -> Iterator[str]:
    inertia = link.inertia_local
    tensor = "".join(f"<{key}>{float(inertia[place])!r}</{key}>" for key, place in INERTIA.items())
    yield f"<link name={_quoted(link.name)}>"
    yield f"  <pose>{link.pose.text()}</pose>"
    yield "  <inertial>"
    yield f"    <pose>{Pose(np.eye(3), link.com_local).text()}</pose> <mass>{link.mass!r}</mass>"
    yield f"    <inertia>{tensor}</inertia>"
    yield "  </inertial>"
    for visual in link.visuals:
        yield f"  {' '.join(visual.split())}"
    for line in beam_text(link.beam) if link.beam is not None else ():
        yield f"  {line}"
    yield "</link>"


def _joint(joint: RawJoint, frames: _Frames | None) -> Iterator[str]:
    parent, child, axes, named = joint.parent, joint.child, np.eye(3), ""
    yield f'<joint name={_quoted(joint.name)} type="{joint.type}">'
    if frames is None or joint.type == "fixed":  # a fixed joint has no place
        yield f'  <pose relative_to="__model__">{Pose(np.eye(3), joint.position).text()}</pose>'
    else:
        (parent, rail), (child, pin) = frames.of_parent(joint), frames.of_child(joint)
        # a guide's direction belongs to the parent, which carries the slot
        slides = joint.type == "prismatic"
        axes, named = (rail.rotation, f" expressed_in={_quoted(parent)}") if slides else (pin.rotation, "")
    yield f"  <parent>{escape(parent, False)}</parent> <child>{escape(child, False)}</child>"
    if joint.type != "fixed":
        along = " ".join(repr(round(float(x), 15) + 0.0) for x in axes.T @ joint.axis)
        yield f"  <axis><xyz{named}>{along}</xyz></axis>"
    for tag in ("bearing", "slot"):
        if (part := getattr(joint, tag)) is not None:
            lengths = "".join(f"<linkages:{key}>{value!r}</linkages:{key}>" for key, value in vars(part).items())
            yield f"  <linkages:{tag}>{lengths}</linkages:{tag}>"
    yield "</joint>"


def _frame(name: str, link: str, pose: Pose, on_link: bool) -> str:
    base = "" if on_link else ' relative_to="__model__"'
    return f"<frame name={_quoted(name)} attached_to={_quoted(link)}><pose{base}>{pose.text()}</pose></frame>"


def _quoted(name: str) -> str:
    return f'"{escape(name)}"'
