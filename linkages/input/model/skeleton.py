"""Default shape of a link without visuals: bars between its joints and other points, and the plate they span."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from linkages.base.arrays import Array
from linkages.base.palette import INK, link_color
from linkages.input.model.mechanism import Link, Mechanism

OTHER = INK  # not of a moving link
_SAME = 1e-6  # relative to the linkage's size: closer places coincide, closer points lie on a line


@dataclass(frozen=True)
class Skeleton:
    """A link as points and the bars between them."""

    places: Array  # (n, 2) distinct joints and frames in the reference pose, plane axes [m]; else the mass centre
    bars: tuple[tuple[int, int], ...]  # pairs of joined places; empty for a single place
    plate: tuple[int, ...]  # corners of the places' convex hull, counter-clockwise; empty if they lie on a line
    color: str  # ``#rrggbb``: the link's own, else one of `linkages.base.palette.LINKS`


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
    return mechanism.link[link].color or _chosen(mechanism)[_family(link)]


def _chosen(mechanism: Mechanism) -> dict[str, str]:
    """Choose the colours of all links so that those of links that touch differ; segments have their link's."""
    found = {_family(link.name): link.color for link in mechanism.links if link.color}
    families = list(dict.fromkeys(map(_family, mechanism.link)))
    pairs = [{_family(joint.parent), _family(joint.child)} for joint in mechanism.joints]
    for order, name in enumerate(families):
        near = {other for pair in pairs if name in pair for other in pair - {name}}
        if name not in found:
            found[name] = link_color(order, [found[other] for other in near if other in found])
    return found


def _family(link: str) -> str:
    """Return the name of the link to which a segment belongs."""
    return link.partition("/")[0]


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
