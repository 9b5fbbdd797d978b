"""Write a mechanism as SDFormat."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from html import escape

import numpy as np

from linkages.input.files.beams import beam_text
from linkages.input.files.elements import INERTIA
from linkages.input.files.raw_model import Pose, RawJoint, RawLink, RawModel


def sdf_text(model: RawModel, remarks: Sequence[str] = (), description: str = "") -> str:
    """Write a mechanism with all poses in world axes; `linkages.input.files.sdf.read_sdf` reads the same model back.

    Remarks are items of the comment at the head of the file. A description (`linkages.input.files.description`) is
    stored.
    """
    comment = [line for remark in remarks for line in textwrap.wrap(f"- {remark}".replace("--", "- -"), 116)]
    body = [line for link in model.links for line in _link(link)]
    for name, (link, pose) in model.frames.items():
        body.append(_frame(name, link, pose))
    for joint in model.joints:
        body += _joint(joint, model)
    if description:
        body += ["<linkages:description>", *escape(description, False).splitlines(), "</linkages:description>"]
    lines = ["<!--", *comment, "-->"] if comment else []
    lines += ['<sdf version="1.9" xmlns:linkages="urn:linkages:sdf">', f"  <model name={_quoted(model.name)}>"]
    return "\n".join(['<?xml version="1.0"?>', *lines, *(f"    {line}" for line in body), "  </model>", "</sdf>", ""])


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


def _joint(joint: RawJoint, model: RawModel) -> Iterator[str]:
    parent = joint.parent
    if np.linalg.norm(joint.position_on_parent - joint.position) > 0.0:
        parent = model.free_name(f"{joint.name}_on_{joint.parent}")
        yield _frame(parent, joint.parent, Pose(np.eye(3), joint.position_on_parent))
    yield f'<joint name={_quoted(joint.name)} type="{joint.type}">'
    yield f'  <pose relative_to="__model__">{Pose(np.eye(3), joint.position).text()}</pose>'
    yield f"  <parent>{escape(parent, False)}</parent> <child>{escape(joint.child, False)}</child>"
    if joint.type != "fixed":
        yield f"  <axis><xyz>{' '.join(repr(round(float(x), 15) + 0.0) for x in joint.axis)}</xyz></axis>"
    for tag in ("bearing", "slot"):
        if (part := getattr(joint, tag)) is not None:
            lengths = "".join(f"<linkages:{key}>{value!r}</linkages:{key}>" for key, value in vars(part).items())
            yield f"  <linkages:{tag}>{lengths}</linkages:{tag}>"
    yield "</joint>"


def _frame(name: str, link: str, pose: Pose) -> str:
    attached = f"name={_quoted(name)} attached_to={_quoted(link)}"
    return f'<frame {attached}><pose relative_to="__model__">{pose.text()}</pose></frame>'


def _quoted(name: str) -> str:
    return f'"{escape(name)}"'
