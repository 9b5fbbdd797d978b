"""Rigid operations on a model: move links, merge links that are fixed to each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.input.files.elements import own_pose, with_pose
from linkages.input.files.raw_model import Pose, RawJoint, RawLink, RawModel
from linkages.input.files.xml import parse_xml


def without_massless(path: Path, model: RawModel) -> RawModel:
    """Convert massless links that are fixed to another link, or to the world, to frames; InputError for other ones."""
    while massless := [link for link in model.links if link.mass == 0.0]:
        for link in massless:
            joint = next((j for j in model.joints if j.type == "fixed" and link.name in (j.parent, j.child)), None)
            if joint is None:
                fix = "give its mass and inertia, or fix it to the world or a link that has them"
                raise InputError(path, f'<link name="{link.name}">', f"has no <inertial>, or one without mass; {fix}")
            model = fixed_into(path, model, joint, link.name)
            break
    return model


def fixed_into(path: Path, model: RawModel, joint: RawJoint, name: str) -> RawModel:
    """Merge the two links of a fixed joint; the link of this name becomes a frame of the other.

    Joints and frames of the merged link belong to the other link, at the same places. InputError if another joint
    connects the two links.
    """
    stays = joint.parent if joint.child == name else joint.child
    gone = next(link for link in model.links if link.name == name)
    links = tuple(_together(link, gone) if link.name == stays else link for link in model.links if link is not gone)
    joints = []
    for other in model.joints:
        parent, child = (stays if end == name else end for end in (other.parent, other.child))
        moved = replace(other, parent=parent, child=child)
        if moved.parent != moved.child:
            joints.append(moved)
        elif moved.type != "fixed":
            problem = f'joins "{other.parent}" and "{other.child}", which are fixed to each other'
            raise InputError(path, f'<joint name="{other.name}">', problem)
    frames = {key: (stays if link == name else link, pose) for key, (link, pose) in model.frames.items()}
    return replace(model, links=links, joints=tuple(joints), frames={**frames, name: (stays, gone.pose)})


def moved(model: RawModel, moves: Mapping[str, Pose]) -> RawModel:
    """Move links with their joints and frames by displacements from their reference poses, in world axes.

    Other links stay. A joint's axis moves with its parent.
    """

    def move(link: str, place: Array) -> Array:
        pose = moves.get(link, still)
        return pose.rotation @ place + pose.translation

    still = Pose()
    links = []
    for link in model.links:
        at, beam = moves.get(link.name, still) @ link.pose, link.beam
        if beam is not None:
            beam = replace(beam, start=move(link.name, beam.start), end=move(link.name, beam.end))
        links.append(replace(link, rotation=at.rotation, translation=at.translation, beam=beam))
    joints = [
        replace(
            joint,
            position=move(joint.child, joint.position),
            position_on_parent=move(joint.parent, joint.position_on_parent),
            axis=moves.get(joint.parent, still).rotation @ joint.axis,
        )
        for joint in model.joints
    ]
    frames = {name: (link, moves.get(link, still) @ at) for name, (link, at) in model.frames.items()}
    return replace(model, links=tuple(links), joints=tuple(joints), frames=frames)


def combined(bodies: Sequence[tuple[float, Array, Array]]) -> tuple[float, Array, Array]:
    """Return mass, mass centre and inertia tensor about it of bodies given by theirs, in the same axes."""
    mass = sum(body[0] for body in bodies)
    centre = np.sum([part * place for part, place, _ in bodies], axis=0) / mass if mass else bodies[0][1]
    tensor = np.sum([own for _, _, own in bodies], axis=0)
    for part, place, _ in bodies:
        off = place - centre
        tensor += part * (off @ off * np.eye(3) - np.outer(off, off))
    return mass, centre, tensor


def _together(link: RawLink, other: RawLink) -> RawLink:
    """Return a link with the mass, inertia and shapes of another, in the first link's axes."""
    pose = link.pose.inverse() @ other.pose
    turned = pose.rotation @ other.inertia_local @ pose.rotation.T
    added = other.mass, pose.rotation @ other.com_local + pose.translation, turned
    mass, com, inertia = combined([(link.mass, link.com_local, link.inertia_local), added])
    visuals = (*link.visuals, *(_visual_moved(visual, pose, other.name) for visual in other.visuals))
    return replace(link, mass=mass, com_local=com, inertia_local=inertia, visuals=visuals)


def _visual_moved(visual: str, pose: Pose, owner: str) -> str:
    element = parse_xml(Path(owner), visual.encode())
    element.set("name", f"{owner}_{element.get('name', '')}")
    return with_pose(element, pose @ own_pose(Path(owner), element, visual))
