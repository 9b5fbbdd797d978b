"""Visuals in Drake for links without any in the SDF file: the skeleton as boxes."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.raw_model import Pose
from linkages.input.model.mechanism import Link, Mechanism
from linkages.input.model.skeleton import skeleton

_WIDTH = 0.02  # width of a bar over the size of the linkage
_BLOCK = 0.06  # side of a block over the size of the linkage, for a link with one joint


def visuals(mechanism: Mechanism, link: Link, size: float) -> list[str]:
    """Make ``<visual>`` elements: a box for each bar of the link's skeleton, or a block for a single place.

    Parameters
    ----------
    mechanism : Mechanism
    link : Link
    size : float
        Extent of the linkage [m].
    """
    shape, width = skeleton(mechanism, link, size), _WIDTH * size
    if not shape.bars:
        sides = (_BLOCK * size, _BLOCK * size, width)
        return [_box(mechanism, link, 0, shape.places[0], np.array([1.0, 0.0]), sides, shape.color)]
    ends = [(shape.places[a], shape.places[b]) for a, b in shape.bars]
    lengths = [float(np.linalg.norm(b - a)) for a, b in ends]
    return [
        _box(mechanism, link, k, 0.5 * (a + b), b - a, (length + width, width, width), shape.color)
        for k, ((a, b), length) in enumerate(zip(ends, lengths, strict=True))
    ]


def _box(
    mechanism: Mechanism, link: Link, number: int, middle: Array, along: Array, sides: tuple[float, ...], color: str
) -> str:
    """Make a box in link axes from its reference middle and direction in plane axes."""
    basis = mechanism.basis
    x = basis[:, :2] @ along / np.linalg.norm(along)
    axes = np.column_stack([x, np.cross(basis[:, 2], x), basis[:, 2]])
    out_of_plane = basis[:, 2] * (basis[:, 2] @ link.translation)  # offset of the link frame
    position = link.rotation.T @ (basis[:, :2] @ middle + out_of_plane - link.translation)
    pose = Pose(link.rotation.T @ axes, position).text()
    size = " ".join(repr(float(v)) for v in sides)
    diffuse = " ".join(f"{int(color[k : k + 2], 16) / 255:.3g}" for k in (1, 3, 5))
    return (
        f'<visual name="skeleton{number}"><pose>{pose}</pose><geometry><box><size>{size}</size></box></geometry>'
        f"<material><diffuse>{diffuse} 1</diffuse></material></visual>"
    )
