"""Shapes of an experiment's elements: drives, loads, elements of `linkages.elements`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, InputError
from linkages.elements.machine import all_elements_of, count, elements_of, tell_elements
from linkages.elements.pictures import (
    Around,
    Arrow,
    Between,
    Labelled,
    Named,
    Picture,
    Ring,
    Scene,
    Traced,
    Turning,
    Wall,
)
from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Joint
from linkages.mechanics.planar.kinematics import state_tables
from linkages.mechanics.planar.loads import LOAD_OUTPUTS
from linkages.show.plots.drawing.parts import BLOCK, Parts
from linkages.show.plots.drawing.shapes import DrawnPoint, Shape, shape
from linkages.system import System
from linkages.system.ideal_motion import IdealMotion

# lengths in units of the drawing
_ARROW = 9.0
_DRIVE, _TORQUE = 3.4, 4.3  # radii of the arrows around a joint
_ZIGZAG = np.arange(-4.0, 5.0), 1.2 * np.array([0, 0, 1, -1, 1, -1, 1, 0, 0])  # along the slot, and across
_NAME = 3.6  # distance of a load's name from its joint
_TIMES = 501  # number of sampled times of drives and loads


class Done:
    """Makes the shapes of an experiment's elements; idle drives point along their coordinates."""

    def __init__(self, parts: Parts, asked: System) -> None:
        self.parts, self.tree, self.unit = parts, parts.tree, parts.unit
        self.senses, self.strongest = senses(asked), strongest(asked, self)

    def all(self, experiment: Experiment) -> Iterator[Shape]:
        """Draw all elements."""
        for kind, name, keys in all_elements_of(experiment.elements):
            for picture in kind.picture(keys, self):
                yield from self._part(name, picture)

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

    def joint(self, name: str) -> Joint:
        """Return a joint."""
        return self.tree.joints[name]

    def frame(self, name: str) -> tuple[str, Array, float]:
        """Return link, origin (2,) [m] and angle of a link's or named frame, in the reference configuration."""
        frame = self.tree.points[name]
        return frame.link, frame.origin, frame.angle

    def farthest(self, link: str, point: Array) -> Array:
        """Return the way (2,) from a point to the farthest place of a link, in the reference configuration [m]."""
        ways = self.tree.skeleton(link).places - point
        return np.asarray(ways[int(np.linalg.norm(ways, axis=1).argmax())])

    def _part(self, name: str, picture: Picture) -> Iterator[Shape]:
        """Draw a part of the picture of an element with this name."""
        match picture:
            case Between():
                yield from self._between(name, picture)
            case Around():
                yield from self._around(name, picture)
            case Arrow():
                yield from self._arrow(name, picture)
            case Turning():
                yield from self._turning(name, picture)
            case Traced(points, style):
                yield shape(style, [self.parts.on(*point) for point in points])
            case Wall(link, place, ends, into):
                yield from self.parts.hatching(link, place, ends, into)
            case Ring(joint):
                one = self.tree.joints[joint]
                yield shape("ring", [self.parts.on(one.child, one.on_child)])
            case Named(joint):
                yield self._beside(name, self.tree.joints[joint], _NAME)
            case Labelled(link, place, away):
                yield shape("load name", [self.parts.off(link, place, away)], text=name)

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


def senses(system: System) -> dict[str, float]:
    """Find the sense of each drive's first motion or torque: 1 along its coordinate, or -1; idle drives omitted."""
    times = np.linspace(0.0, system.settings.duration, _TIMES)
    moved = system.motions(times)[0]
    found = dict(zip(system.tree.driven, (moved - moved[:1]).T, strict=True))
    found |= dict(zip(system.tree.powered, system.torques(times)[0].T, strict=True))
    # without rounding errors of the largest value
    moving = {name: values[np.abs(values) > 1e-9 * np.abs(values).max()] for name, values in found.items()}
    return {name: float(np.sign(values[0])) for name, values in moving.items() if len(values)}


def strongest(system: System, scene: Scene) -> Mapping[str, Array]:
    """Find the largest forces (2,) [N], plane axes, and torques (1,) [N m] in the ideal linkage's motion.

    They are the values of elements whose pictures are arrows. If the drives do not determine the motion, the values at
    the start are used; zero loads are omitted.
    """
    ideal = system.ideal()
    parts = [(name, _values_drawn(kind.picture(keys, scene))) for kind, name, keys in elements_of(ideal.parts)]
    if not any(shown for _, shown in parts):
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
    values = np.empty((len(q), count(ideal.elements), len(LOAD_OUTPUTS)))
    for k, time in enumerate(times):
        rates = np.concatenate([v[k], ideal.start_states])
        tell_elements(ideal.elements, ideal.packed.functions, time, rates, 0, pose[k], vel[k], values[k])
    found = {}
    for k, (name, shown) in enumerate(parts):
        own = values[:, k, :shown]
        largest = own[np.linalg.norm(own, axis=1).argmax()]
        if np.any(largest):
            found[name] = largest
    return found


def _values_drawn(pictures: Iterable[Picture]) -> int:
    """Return the number of values that an element's pictures show by arrows."""
    return max((one.values for one in pictures if isinstance(one, Arrow | Turning)), default=0)
