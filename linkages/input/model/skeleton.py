"""Default shape of a link without visuals: bars between its joints and other points, and the plate they span."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from linkages.base.arrays import Array
from linkages.input.model.mechanism import Link, Mechanism

#: Colours of links in their order: Okabe and Ito's palette, distinct to colour-blind readers, and two more.
COLORS = ("#E69F00", "#0072B2", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#8B6F47", "#6A51A3")
OTHER = "#1A1A1A"  # not of a moving link
_SAME = 1e-6  # relative to the linkage's size: closer places coincide, closer points lie on a line


@dataclass(frozen=True)
class Skeleton:
    """A link as points and the bars between them."""

    places: Array  # (n, 2) distinct joints and frames in the reference pose, plane axes [m]; else the mass centre
    bars: tuple[tuple[int, int], ...]  # pairs of joined places; empty for a single place
    plate: tuple[int, ...]  # corners of the places' convex hull, counter-clockwise; empty if they lie on a line
    color: str  # ``#rrggbb``: the link's own, else one of `COLORS`


def skeleton(mechanism: Mechanism, link: Link, size: float) -> Skeleton:
    """Join all joints and frames of a link; `size` is the extent of the linkage [m]."""
    color = color_of(mechanism, link.name)
    places = _places(mechanism, link, _SAME * size)
    if len(places) < 2:
        return Skeleton(places, (), (), color)
    middle = places - places.mean(axis=0)
    _, spread, axes = np.linalg.svd(middle, full_matrices=False)
    if len(places) == 2 or spread[1] <= _SAME * size:
        order = np.argsort(middle @ axes[0]).tolist()
        return Skeleton(places, tuple(pairwise(order)), (), color)
    from scipy.spatial import ConvexHull  # slow to import

    hull = ConvexHull(places).vertices.tolist()
    inner = [k for k in range(len(places)) if k not in hull]
    near = [(k, hull[int(np.argmin(np.linalg.norm(places[hull] - places[k], axis=1)))]) for k in inner]
    return Skeleton(places, (*zip(hull, [*hull[1:], hull[0]], strict=True), *near), tuple(hull), color)


def color_of(mechanism: Mechanism, name: str) -> str:
    """Return the colour of a link, of a frame's link, of the link that a joint carries (its child); else `OTHER`."""
    link = mechanism.place[name].link if name in mechanism.place else name
    if link not in mechanism.link:
        return OTHER
    # segments have their link's colour
    families = list(dict.fromkeys(other.partition("/")[0] for other in mechanism.link))
    return mechanism.link[link].color or COLORS[families.index(link.partition("/")[0]) % len(COLORS)]


def colors_of(mechanism: Mechanism) -> dict[str, str]:
    """Return `color_of` of everything with a position, by name."""
    return {name: color_of(mechanism, name) for name in mechanism.place}


def _places(mechanism: Mechanism, link: Link, same: float) -> Array:
    """Return the joints and frames of a link (n, 2), or its mass centre.

    A frame that is named after the link and one of its joints stands for the joint, whose own place counts: written
    files of earlier versions do not move both together.
    """
    ends = [end for j in mechanism.joints for end in ((j.parent, j.on_parent), (j.child, j.on_child))]
    own = {f"{link.name}_{joint.name}" for joint in mechanism.joints if link.name in (joint.parent, joint.child)}
    points = [(frame.link, frame.origin) for frame in mechanism.frames if frame.name not in own]
    found: list[Array] = []
    for body, at in (*ends, *points):
        if body == link.name and all(np.linalg.norm(at - other) > same for other in found):
            found.append(at)
    return np.array(found or [link.com])
