"""Shapes of an experiment's elements: drives, loads, gears, stops, lines in contact with points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, InputError
from linkages.elements.element import Around, Arrow, Between, Picture, Turning
from linkages.elements.machine import elements_of, tell_elements
from linkages.input.model.experiment import Experiment
from linkages.input.model.load_tables import LineContact, Mesh, Stop
from linkages.input.model.mechanism import Joint
from linkages.mechanics.planar.kinematics import state_tables
from linkages.mechanics.planar.loads import LOAD_OUTPUTS
from linkages.show.plots.drawing.parts import BLOCK, Parts
from linkages.show.plots.drawing.shapes import DrawnPoint, Shape, shape
from linkages.system import System
from linkages.system.ideal_motion import IdealMotion

# lengths in units of the drawing
_ARROW = 9.0
_REACH = 12.0  # half the length of a contact line
_DRIVE, _TORQUE = 3.4, 4.3  # radii of the arrows around a joint
_ZIGZAG = np.arange(-4.0, 5.0), 1.2 * np.array([0, 0, 1, -1, 1, -1, 1, 0, 0])  # along the slot, and across
_NAME = 3.6  # distance of a load's name from its joint
_STOP = 2.6, 7.0  # distances from the joint of the ends of an angular stop
_PULLEYS = 0.3, 6.0  # the larger pulley of a belt: radius over the distance of the axes, or in units if they coincide
_TIMES = 501  # number of sampled times of drives and loads


class Done:
    """Makes the shapes of an experiment's elements; idle drives point along their coordinates."""

    def __init__(self, parts: Parts, asked: System) -> None:
        self.parts, self.tree, self.unit = parts, parts.tree, parts.unit
        self.senses, self.strongest = senses(asked), strongest(asked)

    def all(self, experiment: Experiment) -> Iterator[Shape]:
        """Draw all loads, gears, stops and lines."""
        for kind, name, keys in elements_of(experiment.elements):
            if (picture := kind.picture(keys)) is not None:
                yield from self._element(name, picture)
        for name, friction in experiment.frictions.items():
            joint = self.tree.joints[friction.joint]
            yield shape("friction", [self.parts.on(joint.child, joint.on_child)])
            yield self._beside(name, joint, _NAME)
        for name, gear in experiment.meshes.items():
            yield from self._gear(name, gear)
        for name, stop in experiment.stops.items():
            yield from self._stop(name, stop)
        for name, touch in experiment.contacts.items():
            yield from self._line(name, touch)

    def drive(self, joint: Joint) -> Iterator[Shape]:
        """Draw an arrow in the initial direction of a drive."""
        sense = self.senses.get(joint.name, 1.0)
        if joint.type == "prismatic":
            across = np.array([-joint.direction[1], joint.direction[0]])
            ends = (s * sense * joint.direction + 2.2 * across for s in (-2.5, 2.5))
            yield from self.parts.arrow("drive", [self.parts.on(joint.child, joint.on_child, end) for end in ends])
        else:
            yield from self.parts.turning("drive", joint.parent, joint.on_parent, _DRIVE, sense * joint.sign)

    def _beside(self, name: str, joint: Joint, away: float) -> Shape:
        """Draw the name of a load in a joint."""
        ends, away = (joint.parent, joint.child), max(away, BLOCK * (joint.type == "prismatic"))
        return self.parts.name_beside("load name", joint.child, joint.on_child, away, name, ends)

    def _arrow(self, name: str, picture: Arrow) -> Iterator[Shape]:
        """Draw an arrow to the point of action of a force, in the direction of its largest value."""
        point, parts = self.tree.points[picture.point], self.parts
        force = self.strongest.get(name, np.array([0.0, -1.0]))
        way = force / np.linalg.norm(force)
        at = parts.on(point.link, point.origin)
        beside: Callable[..., DrawnPoint] = parts.off
        if picture.turns:  # with the link
            angle = parts.poses[0, int(at[0]), 2]
            c, s = np.cos(angle), np.sin(angle)
            way, beside = np.array([c * way[0] + s * way[1], c * way[1] - s * way[0]]), parts.on
        yield from parts.arrow("load", [beside(point.link, point.origin, s * way) for s in (-_ARROW, -0.8)])
        tail = beside(point.link, point.origin, -(_ARROW + 1.6) * way)
        parts.take(parts.at(at), parts.at(tail) - parts.at(at))
        yield shape("load name", [tail], text=name)

    def _element(self, name: str, picture: Picture) -> Iterator[Shape]:
        """Draw an element."""
        match picture:
            case Between():
                yield from self._between(name, picture)
            case Around():
                yield from self._around(name, picture)
            case Arrow():
                yield from self._arrow(name, picture)
            case Turning():
                yield from self._turning(name, picture)

    def _between(self, name: str, picture: Between) -> Iterator[Shape]:
        """Draw a dashed line between two points; a support at a fixed one."""
        parts, ends = self.parts, []
        for point in (picture.one, picture.other):
            if isinstance(point, str):
                place = self.tree.points[point]
                ends.append(parts.on(place.link, place.origin))
            else:
                anchor = np.array(point)
                yield from parts.stand(anchor)
                ends.append(parts.on("world", anchor))
        yield shape("spring", ends)
        half = 0.5 * (parts.at(ends[1]) - parts.at(ends[0]))
        body, x, y, _, _ = ends[0]
        yield shape("load name", [(body, x, y, *(half + np.array([0.0, 1.6 * self.unit])))], text=name)

    def _around(self, name: str, picture: Around) -> Iterator[Shape]:
        """Draw a spiral in a joint, or at the centre of mass of a link; in a prismatic joint a zigzag."""
        joint = self.tree.joints[picture.joint] if picture.joint is not None else None
        if joint is not None:
            link, at = joint.child, joint.on_child
        else:
            link = picture.link or ""
            at = self.tree.links[link].com
        if joint is not None and joint.type == "prismatic":
            along, across = np.array(joint.direction), np.array([-joint.direction[1], joint.direction[0]])
            ways = np.outer(_ZIGZAG[0], along) + np.outer(_ZIGZAG[1], across)
        else:
            turn = np.linspace(0.0, 5.0 * np.pi, 60)
            radius = 1.4 + 0.12 * turn
            ways = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
        yield shape("load", [self.parts.on(link, at, way) for way in ways])
        if joint is not None:
            yield self._beside(name, joint, 4.6)
        else:
            yield shape("load name", [self.parts.off(link, at, (0.0, 4.6))], text=name)

    def _turning(self, name: str, picture: Turning) -> Iterator[Shape]:
        """Draw an arrow around a joint or a link's centre of mass, in the sense of the largest torque."""
        sign = float(np.sign(self.strongest.get(name, np.ones(1))[0]))
        if picture.joint is not None:
            joint = self.tree.joints[picture.joint]
            yield from self.parts.turning("load", joint.parent, joint.on_parent, _TORQUE, sign * joint.sign)
            yield self._beside(name, joint, _TORQUE + 2.0)
        else:
            link = self.tree.links[picture.link or ""]
            yield from self.parts.turning("load", link.name, link.com, 2.8, sign)
            yield shape("load name", [self.parts.off(link.name, link.com, (0.0, 4.4))], text=name)

    def _gear(self, name: str, gear: Mesh) -> Iterator[Shape]:
        """Draw the pitch circles of meshing wheels or of a rack's pinion; or the pulleys and the belt."""
        first, second = (self.tree.joints[joint] for joint in gear.joints)
        shared = (one for one in (first.parent, first.child) if one in (second.parent, second.child))
        carrier = gear.carrier or next(shared, None)
        apart = second.on_child - first.on_child
        distance, ratio = float(np.linalg.norm(apart)), abs(gear.ratio)
        turning = [joint for joint in (first, second) if joint.type == "revolute"]
        meshing = gear.ratio * first.sign * second.sign < 0.0
        if len(turning) == 2:
            sizes = np.array([ratio, 1.0])
            wide, alone = _PULLEYS
            if distance == 0.0:
                radii = alone * self.unit * sizes / sizes.max()
            elif meshing and carrier is not None:
                radii = distance * sizes / sizes.sum()
            else:
                radii = wide * distance * sizes / sizes.max()
        else:
            radii = np.array([ratio if first.type == "revolute" else 1.0 / ratio])
        for joint, radius in zip(turning, radii, strict=False):
            yield self._wheel(joint, carrier, float(radius))
        if distance > 0.0 and not (meshing and len(turning) == 2 and carrier is not None):
            yield from self._belt(first, second, carrier, apart / distance, radii if len(turning) == 2 else np.zeros(2))
        at = turning[0] if turning else first
        yield self._beside(name, at, _NAME)

    def _wheel(self, joint: Joint, carrier: str | None, radius: float) -> Shape:
        """Draw a circle with a spoke on the link that rotates on the carrier."""
        link, at = (joint.parent, joint.on_parent) if joint.child == carrier else (joint.child, joint.on_child)
        turn = np.linspace(0.0, 2.0 * np.pi, 73)
        rim = np.column_stack([np.cos(turn), np.sin(turn)]) * radius / self.unit
        return shape("gear", [self.parts.on(link, at, place) for place in (np.zeros(2), *rim)])

    def _belt(self, first: Joint, second: Joint, carrier: str | None, along: Array, radii: Array) -> Iterator[Shape]:
        """Draw the tangents of two wheels on a carrier; a line between the joints if there are none."""
        if carrier is None or not radii.any():
            yield shape("gear", [self.parts.on(joint.child, joint.on_child) for joint in (first, second)])
            return
        distance = float(np.linalg.norm(second.on_child - first.on_child))
        sine = (radii[0] - radii[1]) / distance
        for side in (1.0, -1.0):
            normal = sine * along + side * np.sqrt(1.0 - sine**2) * np.array([-along[1], along[0]])
            ends = zip((first, second), radii / self.unit, strict=True)
            yield shape("gear", [self.parts.on(carrier, joint.on_child, radius * normal) for joint, radius in ends])

    def _stop(self, name: str, stop: Stop) -> Iterator[Shape]:
        """Draw the limit of a joint's coordinate, hatched beyond it."""
        joint, beyond = self.tree.joints[stop.joint], 1.0 if stop.side == "upper" else -1.0
        if joint.type == "prismatic":
            across = np.array([-joint.direction[1], joint.direction[0]])
            at = (stop.limit / self.unit + beyond * 2.3) * joint.direction  # position of the block's edge
            ends = np.array([at + s * across for s in (-2.6, 2.6)])
            yield from self.parts.hatching(joint.parent, joint.on_parent, ends, beyond * joint.direction)
        else:
            held, link, sense = joint.parent, joint.child, joint.sign
            if link == "world":
                held, link, sense = joint.child, joint.parent, -joint.sign
            form = self.tree.skeleton(link)
            ways = form.places - joint.on_child
            way = ways[int(np.linalg.norm(ways, axis=1).argmax())]
            angle = np.arctan2(way[1], way[0]) + sense * stop.limit
            along = np.array([np.cos(angle), np.sin(angle)])
            normal = sense * beyond * np.array([-along[1], along[0]])
            edge = 0.65 * normal  # half of a bar
            ends = np.array([s * along + edge for s in _STOP])
            yield from self.parts.hatching(held, joint.on_parent, ends, normal)
        yield self._beside(name, joint, _NAME)

    def _line(self, name: str, touch: LineContact) -> Iterator[Shape]:
        """Draw a contact line of a point, hatched on the forbidden side."""
        frame = self.tree.points[touch.line] if touch.line is not None else None
        link, at, angle = "world", np.array(touch.anchor), touch.angle
        if frame is not None:
            link, at, angle = frame.link, frame.origin, frame.angle
        along, into = np.array([np.cos(angle), np.sin(angle)]), np.array([np.sin(angle), -np.cos(angle)])
        yield shape("rail", [self.parts.on(link, at, s * along) for s in (-_REACH, _REACH)])
        yield from self.parts.hatching(link, at, np.outer([-_REACH, _REACH], along), into)
        yield shape("load name", [self.parts.off(link, at, 2.2 * into)], text=name)


def senses(system: System) -> dict[str, float]:
    """Find the sense of each drive's first motion or torque: 1 along its coordinate, or -1; idle drives omitted."""
    times = np.linspace(0.0, system.settings.duration, _TIMES)
    moved = system.motions(times)[0]
    found = dict(zip(system.tree.driven, (moved - moved[:1]).T, strict=True))
    found |= dict(zip(system.tree.powered, system.torques(times)[0].T, strict=True))
    # without rounding errors of the largest value
    moving = {name: values[np.abs(values) > 1e-9 * np.abs(values).max()] for name, values in found.items()}
    return {name: float(np.sign(values[0])) for name, values in moving.items() if len(values)}


def strongest(system: System) -> Mapping[str, Array]:
    """Find the largest forces (2,) [N], plane axes, and torques (1,) [N m] in the ideal linkage's motion.

    They are the values of elements whose pictures are arrows. If the drives do not determine the motion, the values at
    the start are used; zero loads are omitted.
    """
    ideal = system.ideal()
    pictures = [(name, kind.picture(keys)) for kind, name, keys in elements_of(ideal.parts)]
    if not any(isinstance(picture, Arrow | Turning) for _, picture in pictures):
        return {}
    try:
        if ideal.determinate:
            motion = IdealMotion(ideal)
            times = np.linspace(0.0, motion.times[-1], _TIMES)
            q, v, _ = motion.states(times)
        else:
            times, q, v = np.zeros(1), ideal.assembly.q[None], ideal.assembly.v[None]
    except (AssemblyError, InputError):  # drawn in the file's pose, with gaps in red
        return {}
    pose, vel = state_tables(ideal.tree.bodies, q, v)
    values = np.empty((len(q), len(pictures), len(LOAD_OUTPUTS)))
    for k, time in enumerate(times):
        rates = np.concatenate([v[k], ideal.start_states])
        tell_elements(ideal.elements, ideal.packed.functions, time, rates, 0, pose[k], vel[k], values[k])
    found = {}
    for k, (name, picture) in enumerate(pictures):
        if isinstance(picture, Arrow | Turning):
            parts = values[:, k, : picture.values]
            largest = parts[np.linalg.norm(parts, axis=1).argmax()]
            if np.any(largest):
                found[name] = largest
    return found
