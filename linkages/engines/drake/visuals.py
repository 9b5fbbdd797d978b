"""What a link looks like whose SDF file does not say: bars between its joints."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from linkages.model.mechanism import Link, Mechanism

Array = NDArray[np.float64]

_WIDTH = 0.02  # of a bar, over the size of the linkage
_BLOCK = 0.06  # side of a block, for a link with one joint
# Okabe and Ito's palette, as the figures
_COLORS = ("0.9 0.62 0", "0 0.45 0.7", "0 0.62 0.45", "0.8 0.47 0.65", "0.34 0.71 0.91", "0.84 0.37 0")


def skeleton(mechanism: Mechanism, link: Link, size: float) -> list[str]:
    """Make ``<visual>`` elements: a bar between any two joints of the link, or a block where there is but one place.

    Parameters
    ----------
    size : float
        Extent of the linkage [m].
    """
    places: list[Array] = []
    for joint in mechanism.joints:
        for body, at in ((joint.parent, joint.on_parent), (joint.child, joint.on_child)):
            if body == link.name and all(np.linalg.norm(at - other) > 1e-6 * size for other in places):
                places.append(at)
    color = _COLORS[mechanism.links.index(link) % len(_COLORS)]
    width = _WIDTH * size
    if len(places) < 2:
        at = places[0] if places else link.com
        return [_box(mechanism, link, 0, at, np.array([1.0, 0.0]), (_BLOCK * size, _BLOCK * size, width), color)]
    return [
        _box(mechanism, link, k, 0.5 * (a + b), b - a, (float(np.linalg.norm(b - a)) + width, width, width), color)
        for k, (a, b) in enumerate(combinations(places, 2))
    ]


def _box(
    mechanism: Mechanism, link: Link, number: int, middle: Array, along: Array, sides: tuple[float, ...], color: str
) -> str:
    """Make a box in link axes from its drawn middle and direction in plane axes."""
    basis = mechanism.basis
    x = basis[:, :2] @ along / np.linalg.norm(along)
    axes = np.column_stack([x, np.cross(basis[:, 2], x), basis[:, 2]])
    out_of_plane = basis[:, 2] * (basis[:, 2] @ link.translation)  # where the link frame lies
    position = link.rotation.T @ (basis[:, :2] @ middle + out_of_plane - link.translation)
    angles = Rotation.from_matrix(link.rotation.T @ axes).as_euler("xyz")
    pose = " ".join(repr(float(v)) for v in (*position, *angles))
    size = " ".join(repr(float(v)) for v in sides)
    return (
        f'<visual name="skeleton{number}"><pose>{pose}</pose><geometry><box><size>{size}</size></box></geometry>'
        f"<material><diffuse>{color} 1</diffuse></material></visual>"
    )
