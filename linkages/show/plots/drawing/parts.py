"""Shapes of a mechanism's parts: links, joints, ground, reported points; common elements of shapes."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from linkages.base.arrays import Array
from linkages.base.palette import LINE
from linkages.input.model.mechanism import Joint, Link
from linkages.show.plots.drawing.shapes import STYLES, DrawnPoint, Shape, below, hatched, placed, shape
from linkages.system.tree import Tree

# lengths in units of the drawing
_SIDE = (4.6, 3.2)  # sides of a block
_STAND = (1.7, 2.6)  # half the width, and the height, of a support on the ground
_HATCH = 0.75  # distance of hatching lines
_HEAD = 1.5
_ALONG, _BESIDE = (0.55, 0.4, 0.7, 0.25), 0.95  # of a link's name: fractions of the bar, distance from its middle line
_BELOW = 0.1  # of the line under a link's name
_AWAY, BLOCK, _BEYOND = 2.9, 4.2, 5.0  # distance of a name from a pin, from a block, and from the arrow of a drive

_STEP, _BAR = 0.5, 0.65  # distance of the sample points of a line, half a bar's width
# relative to the size of a text
_LETTER, _HEIGHT = 0.31, 0.6  # half the width of a letter, half the height of a line
# cost of a position of a name
_OUTSIDE, _ON_TEXT, _ON_LINE, _MOST = 4.0, 3.0, 0.1, 12  # per point of a line; most counted points


class Room:
    """Occupied lines and boxes at the start of a drawing with corners (2,) [m], which names must avoid."""

    def __init__(self, low: Array, high: Array) -> None:
        self.low, self.high, self.unit = low, high, float(high[0] - low[0]) / 100.0
        self._points: list[Array] = []
        self._boxes: list[tuple[Array, Array]] = []

    def take_line(self, points: Sequence[Array] | Array) -> None:
        """Mark a line through points (n, 2) [m] as occupied."""
        ends = np.asarray(points, dtype=np.float64)
        for start, end in pairwise(ends):
            count = 2 + int(np.linalg.norm(end - start) / (_STEP * self.unit))
            self._points.append(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))

    def take_box(self, one: Array, other: Array) -> None:
        """Mark a box between two corners (2,) [m] as occupied."""
        self._boxes.append((np.minimum(one, other), np.maximum(one, other)))

    def take_name(self, role: str, middle: Array, text: str) -> None:
        """Mark the box of a name around its middle (2,) [m] as occupied."""
        half = self.half(role, text)
        self.take_box(middle - half, middle + half)

    def half(self, role: str, text: str) -> Array:
        """Compute half the width and height of a text (2,) [m]."""
        size = STYLES[role].size * self.unit
        return np.array([_LETTER * size * len(text), _HEIGHT * size])

    def cost(self, role: str, middle: Array, text: str) -> float:
        """Compute the cost of a text around its middle (2,) [m]: 0 in free space within the picture."""
        half = self.half(role, text)
        low, high = middle - half, middle + half
        total = _OUTSIDE if np.any(low < self.low) or np.any(high > self.high) else 0.0
        total += _ON_TEXT * sum(bool(np.all(low < above) and np.all(below < high)) for below, above in self._boxes)
        if self._points:
            points, around = np.concatenate(self._points), _BAR * self.unit
            inside = np.all((points > low - around) & (points < high + around), axis=1).sum()
            total += _ON_LINE * min(int(inside), _MOST)
        return total


class Parts:
    """Makes the shapes of a mechanism's parts in a picture with these corners (2,) [m].

    All shown poses (n, nb, 3) count; the first one is the start.
    """

    def __init__(self, tree: Tree, low: Array, high: Array, poses: Array) -> None:
        self.tree, self.poses = tree, poses
        self.room = Room(low, high)
        self.unit = self.room.unit
        self._taken: list[tuple[Array, Array]] = []  # positions, and occupied directions there

    def on(self, link: str, drawn: Array, along: Array | tuple[float, float] = (0.0, 0.0)) -> DrawnPoint:
        """Return a point of a link from its reference position, moved by `along` (units, link axes)."""
        body, x, y = self.tree.marker(link, drawn)
        return body, x + self.unit * along[0], y + self.unit * along[1], 0.0, 0.0

    def off(self, link: str, drawn: Array, away: Array | tuple[float, float]) -> DrawnPoint:
        """Return a point offset from a link's point by `away` (units, plane axes)."""
        body, x, y, _, _ = self.on(link, drawn)
        return body, x, y, self.unit * away[0], self.unit * away[1]

    def at(self, point: DrawnPoint) -> Array:
        """Return the position of a point at the start (2,) [m]."""
        return placed(np.array([point]), self.poses[0])[0]

    def take(self, here: Array, way: Array) -> None:
        """Mark a direction (2,) at a position (2,) as occupied, so that names avoid it."""
        self._taken.append((here, way / np.linalg.norm(way)))

    def name_beside(self, role: str, link: str, drawn: Array, away: float, text: str, links: Iterable[str]) -> Shape:
        """Draw the name of a point at a distance [units] in a free direction, away from bars, ground and names."""
        here = self.at(self.on(link, drawn))
        taken = [way for place, way in self._taken if self._same(place, here)]
        for name in links:
            if name == "world":
                taken.append(np.array([0.0, -1.0]))
                continue
            places = self.tree.skeleton(name).places
            ends = [self.at(self.on(name, place)) for place in places]
            taken += [(end - here) / np.linalg.norm(end - here) for end in ends if not self._same(end, here)]
        turn = np.linspace(0.5 * np.pi, 2.5 * np.pi, 24, endpoint=False)
        ways = np.column_stack([np.cos(turn), np.sin(turn)])
        nearest = np.max([ways @ other for other in taken], axis=0) if taken else np.zeros(len(ways))
        letters = max(len(text) - 1, 0)
        reach = away + 0.5 * letters * np.abs(ways[:, 0])
        middle = here + self.unit * reach[:, None] * ways
        crowded = np.array([self.room.cost(role, at, text) for at in middle])
        best = int(np.argmin(np.round(nearest + crowded, 6)))
        self.take(here, ways[best])
        self.room.take_name(role, middle[best], text)
        return shape(role, [self.off(link, drawn, reach[best] * ways[best])], text=text)

    def _same(self, one: Array, other: Array) -> bool:
        return bool(np.linalg.norm(one - other) < 1e-5 * self.tree.extent)

    def link(self, link: Link) -> Iterator[Shape]:
        """Draw plate, bars and centre of mass."""
        form = self.tree.skeleton(link.name)
        places = [self.on(link.name, place) for place in form.places]
        if form.plate:
            yield shape("plate", [places[k] for k in form.plate], form.color)
        for a, b in form.bars:
            self.room.take_line([self.at(places[a]), self.at(places[b])])
            yield shape("bar", [places[a], places[b]], form.color)
        slides = any(joint.type == "prismatic" and joint.child == link.name for joint in self.tree.joints.values())
        if not form.bars and not slides:  # `joint` draws the block of a guide
            yield shape("block", self._rectangle(link.name, form.places[0], np.array([1.0, 0.0])), form.color)
        if link.mass > 0.0:
            yield shape("centre", [self.on(link.name, link.com)], form.color)

    def link_name(self, link: Link) -> Iterator[Shape]:
        """Draw the name of a link next to the middle of its longest bar, underlined in the link's colour."""
        form = self.tree.skeleton(link.name)
        if not form.bars:
            here = self.at(self.on(link.name, form.places[0]))
            self.take(here, np.array([0.0, -1.0]))
            self.room.take_name("link name", here - [0.0, 4.0 * self.unit], link.name)
            yield from self._underlined(link, form.places[0], np.array([0.0, -4.0]), form.color)
            return
        a, b = max(form.bars, key=lambda bar: float(np.linalg.norm(form.places[bar[1]] - form.places[bar[0]])))
        start, end = (self.at(self.on(link.name, form.places[k])) for k in (a, b))
        across = np.array([start[1] - end[1], end[0] - start[0]]) / max(float(np.linalg.norm(end - start)), 1e-300)
        reach = _BESIDE + float(self.room.half("link name", link.name) @ np.abs(across)) / self.unit
        tried: list[tuple[float, Array, Array, Array]] = []
        for part in _ALONG:
            middle = form.places[a] + part * (form.places[b] - form.places[a])
            for away in (reach * across, -reach * across):
                at = self.at(self.on(link.name, middle)) + self.unit * away
                tried.append((self.room.cost("link name", at, link.name), middle, away, at))
        _, middle, away, at = min(tried, key=lambda one: one[0])
        self.room.take_name("link name", at, link.name)
        yield from self._underlined(link, middle, away, form.color)

    def _underlined(self, link: Link, drawn: Array, away: Array, color: str) -> Iterator[Shape]:
        """Draw the name of a link at a distance from its point (units, plane axes), and a line below it."""
        half = self.room.half("link name", link.name) / self.unit
        below = [away + np.array([side * half[0], -half[1] - _BELOW]) for side in (-0.9, 0.9)]
        ends = [self.off(link.name, drawn, end) for end in below]
        yield shape("link mark", ends, color)
        yield shape("link name", [self.off(link.name, drawn, away)], color, link.name)

    def beneath(self, joint: Joint) -> Iterator[Shape]:
        """Draw the shapes under the links: the ground of a joint, the rail of a guide."""
        if joint.type == "prismatic":
            yield from self._rail(joint)
        grounded = [side for side in (joint.parent, joint.child) if side == "world"]
        if grounded and (joint.type != "prismatic" or joint.child == "world"):
            yield from self.stand(joint.on_parent if joint.parent == "world" else joint.on_child)

    def stand(self, drawn: Array) -> Iterator[Shape]:
        """Draw a support on hatched ground."""
        wide, high = _STAND
        foot = [self.off("world", drawn, (x, y)) for x, y in ((0.0, 0.0), (-wide, -high), (wide, -high))]
        self.room.take_line([self.at(at) for at in (*foot, foot[0])])
        yield shape("ground", foot)
        ends = np.array([[-1.6 * wide, -high], [1.6 * wide, -high]])
        yield from self.hatching("world", drawn, ends, np.array([0.0, -1.0]))

    def joint(self, joint: Joint, play: bool) -> Iterator[Shape]:
        """Draw the shapes over the links: pin, block, weld; a gap if the loops are open."""
        here = self.on(joint.child, joint.on_child)
        if joint.type == "prismatic":
            color = self._color(joint.child)
            yield shape("block", self._rectangle(joint.child, joint.on_child, joint.direction), color)
            if play:
                yield shape("play", [here])
        elif joint.type == "revolute":
            if play or joint.bearing is not None:
                yield shape("play" if play else "bearing", [here])
            yield shape("pin", [here])
        else:
            yield shape("fixed", [here])
        there = self.on(joint.parent, joint.on_parent)
        if joint.type == "revolute" and np.linalg.norm(self.at(here) - self.at(there)) > 1e-5 * self.tree.extent:
            yield shape("gap", [here, there])
            yield shape("pin", [there])

    def joint_names(self, driven: Collection[str]) -> Iterator[Shape]:
        """Draw the names of the joints (one label per place), away from bars."""
        joints = list(self.tree.joints.values())
        here = np.array([self.at(self.on(joint.child, joint.on_child)) for joint in joints])
        while joints:
            same = np.linalg.norm(here - here[0], axis=1) < 1e-5 * self.tree.extent
            group = [joint for joint, is_here in zip(joints, same, strict=True) if is_here]
            links = {name: None for joint in group for name in (joint.parent, joint.child)}
            blocks = any(joint.type == "prismatic" for joint in group)
            away = _BEYOND if any(joint.name in driven for joint in group) else BLOCK if blocks else _AWAY
            text = ", ".join(joint.name for joint in group)
            yield self.name_beside("joint name", group[0].child, group[0].on_child, away, text, links)
            joints, here = [joint for joint in joints if joint not in group], here[~same]

    def point(self, name: str) -> Iterator[Shape]:
        """Mark a reported point."""
        point = self.tree.places[name]
        yield shape("point", [self.on(point.link, point.origin)], text=name)
        ends = [joint.on_child for joint in self.tree.joints.values()]
        if all(np.linalg.norm(point.origin - end) > 1e-6 * self.tree.extent for end in ends):
            yield self.name_beside("point name", point.link, point.origin, 1.9, name, [point.link])

    def _color(self, link: str) -> str:
        if link == "world":
            return LINE
        return self.tree.skeleton(link).color

    def _rectangle(self, link: str, drawn: Array, along: Array) -> list[DrawnPoint]:
        across = np.array([-along[1], along[0]])
        corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
        return [self.on(link, drawn, 0.5 * (x * _SIDE[0] * along + y * _SIDE[1] * across)) for x, y in corners]

    def _rail(self, joint: Joint) -> Iterator[Shape]:
        """Draw the line of a block over its stroke; hatched on the ground."""
        rail = (self.on(joint.parent, joint.on_parent, s * joint.direction) for s in (0.0, 1.0))
        points = np.array([*rail, self.on(joint.child, joint.on_child)])
        way = []
        for pose in self.poses:
            start, ahead, block = placed(points, pose) / self.unit
            way.append(float((block - start) @ (ahead - start)))
        reach = np.array([min(way) - 2.5, max(way) + 2.5])
        ends = [self.on(joint.parent, joint.on_parent, s * joint.direction) for s in reach]
        if joint.parent != "world":
            yield shape("slot", ends, self._color(joint.parent))
            return
        yield shape("rail", ends)
        normal = below(joint.direction)
        foot = np.outer(reach, joint.direction) + 0.5 * _SIDE[1] * normal
        yield from self.hatching("world", joint.on_parent, foot, normal)

    def hatching(self, link: str, drawn: Array, ends: Array, normal: Array) -> Iterator[Shape]:
        """Draw a line (2, 2) fixed to a link, in units from a point, hatched on the side of the normal."""
        for line in (ends, *hatched(ends, normal, _HATCH, 0.8)):
            yield shape("hatch", [self.on(link, drawn, end) for end in line])

    def arrow(self, role: str, ends: list[DrawnPoint]) -> Iterator[Shape]:
        """Draw a straight arrow from one point to another."""
        tail, tip = (np.array(end) for end in ends)
        self.room.take_line([self.at(ends[0]), self.at(ends[1])])
        way = tip - tail
        length = float(np.hypot(np.hypot(way[1], way[2]), np.hypot(way[3], way[4]))) or 1.0
        way /= length
        side = np.array([0.0, -way[2], way[1], -way[4], way[3]])
        foot = tip - _HEAD * self.unit * way
        yield shape(role, [tuple(tail), tuple(foot)])
        wings = [foot + 0.45 * _HEAD * self.unit * s * side for s in (1.0, -1.0)]
        yield shape(f"{role} head", [tuple(tip), *map(tuple, wings)])

    def turning(self, role: str, link: str, drawn: Array, radius: float, sign: float) -> Iterator[Shape]:
        """Draw a round arrow, counter-clockwise for a positive sign."""
        turn = sign * np.linspace(-0.2, 1.25 * np.pi, 40)
        ring = radius * np.column_stack([np.cos(turn), np.sin(turn)])
        arc = [self.off(link, drawn, at) for at in ring]
        self.room.take_line([self.at(at) for at in arc])
        yield shape(role, arc)
        way = sign * np.array([-ring[-1, 1], ring[-1, 0]]) / radius
        side = ring[-1] / radius
        corners = [ring[-1] + _HEAD * way, *(ring[-1] + s * 0.45 * _HEAD * side for s in (1.0, -1.0))]
        yield shape(f"{role} head", [self.off(link, drawn, at) for at in corners])
