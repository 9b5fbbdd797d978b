"""Universal and ball joints that other programs write as hinges at one place, with links without mass between them."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.foreign import MARK
from linkages.input.files.magnitudes import ALIGNED
from linkages.input.files.raw_model import RawJoint, RawModel

_SAME_PLACE = 1e-6  # relative to the size of the mechanism: closer places coincide


def in_plane(model: RawModel, notes: list[str]) -> RawModel:
    """Hold the hinges of universal and ball joints that would turn out of the plane.

    Such a hinge joins a link without mass, at the place of another hinge of that link which turns in the plane. A
    planar motion does not turn it. The plane's normal is the direction that most hinges have.
    """
    normal = _normal(model)
    if normal is None:
        return model
    massless = {link.name for link in model.links if link.mass == 0.0}
    while held := next((joint for joint in model.joints if _turns_out(model, joint, normal, massless)), None):
        fixed = replace(RawJoint.fixed(held.name, held.parent, held.child), position=held.position)
        model = replace(model, joints=tuple(fixed if joint is held else joint for joint in model.joints))
        notes.append(f"{MARK}joint {held.name} of a universal or ball joint would turn out of the plane: held")
    return model


def _normal(model: RawModel) -> Array | None:
    """Return the direction of most hinges, whatever its sign."""
    axes = [joint.axis for joint in model.joints if joint.type == "revolute"]
    counts = Counter({k: sum(_along(axis, other) for other in axes) for k, axis in enumerate(axes)})
    return axes[counts.most_common(1)[0][0]] if axes else None


def _along(axis: Array, other: Array) -> bool:
    return bool(np.linalg.norm(np.cross(axis, other)) <= ALIGNED)


def _turns_out(model: RawModel, joint: RawJoint, normal: Array, massless: set[str]) -> bool:
    """Tell whether a hinge across the normal shares a link without mass, and its place, with another hinge."""
    if joint.type != "revolute" or abs(joint.axis @ normal) > ALIGNED:
        return False
    places = np.array([one.position for one in model.joints])
    near = _SAME_PLACE * float(np.linalg.norm(np.ptp(places, axis=0)))
    links = massless & {joint.parent, joint.child}
    return any(
        other is not joint
        and other.type == "revolute"
        and links & {other.parent, other.child}
        and np.linalg.norm(other.position - joint.position) <= near
        for other in model.joints
    )
