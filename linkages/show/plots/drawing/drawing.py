"""All shapes of a mechanism, and its poses over each drive's range of motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError
from linkages.elements.machine import all_elements_of
from linkages.explore.range_of_motion import Travel, movable, travel
from linkages.input.model.experiment import Experiment
from linkages.input.model.plausibility import doubts
from linkages.mechanics.planar.kinematics import poses_at
from linkages.show.plots.drawing.actions import Done
from linkages.show.plots.drawing.facts import facts, joint_table, link_table
from linkages.show.plots.drawing.parts import Parts
from linkages.show.plots.drawing.shapes import Shape, placed, shape
from linkages.show.plots.style import asked_points, round_length
from linkages.system import System
from linkages.system.spanning import spanning_tree
from linkages.system.tree import Tree

_MARGIN = 11.0  # margin around the picture, in units
_LEAST = 0.45  # smallest height over width
_PATH = 400  # most points of a path
_WIDE = "pitch line", "path", "rail", "slot", "hatch"  # roles of shapes that reach beyond the joints
_SHOWN = 181  # number of poses of a slider


@dataclass(frozen=True)
class Slider:
    """A motion as a slider: the range of a drive, or a run."""

    name: str  # joint, or time
    unit: str  # of `values`: deg or mm, or s
    values: Array  # (n,)
    poses: Array  # (n, nb, 3) position [m] and angle [rad] of each body
    first: int  # index of the start
    sense: float  # initial sense of the playback: 1 or -1
    digits: int = 1  # decimals of the shown value


@dataclass(frozen=True)
class Drawing:
    """A mechanism as a movable picture."""

    title: str
    shapes: tuple[Shape, ...]  # from bottom to top
    pose: Array  # (nb, 3) pose at the start
    reference: Array  # (nb, 3) pose in the reference configuration of each link, even if the loops are open there
    links_of: dict[int, str]  # a link on each body, by the body's index
    sliders: tuple[Slider, ...]
    low: Array  # (2,) lower left corner of the picture, plane axes [m]
    high: Array  # (2,) upper right corner
    facts: tuple[str, ...]  # properties of the mechanism
    doubts: tuple[str, ...]  # questions about implausible values
    joints: tuple[tuple[str, ...], ...]  # tables with headings in the first row
    links: tuple[tuple[str, ...], ...]
    problem: str = ""  # reason why it cannot be moved; empty if it can

    @property
    def unit(self) -> float:
        """Return the unit of the drawing: a hundredth of its width [m]."""
        return float(self.high[0] - self.low[0]) / 100.0


def draw(asked: System, spread: bool = False) -> Drawing:
    """Draw a mechanism with ideal joints, movable by its drives or by suitable ones.

    Drives, loads, clearance joints and outputs are drawn too. If the loops do not close, it is drawn in the file's pose
    (`Drawing.problem` has the reason). With `spread` it is no movable picture of the start, which may be a dead centre:
    it is in the pose of its first drive that spreads its joints most, and cropped to it.
    """
    mechanism, experiment = asked.mechanism, asked.experiment
    starts = {name: drive.start(experiment.values) for name, drive in experiment.drives.items()}  # [rad or m]
    try:
        system = movable(mechanism, starts, experiment.couplings_alone)
        ways = [travel(system, name) for name in system.drives]
        tree, pose, problem = system.tree, _pose(system.tree, system.assembly.q), ""
    except AssemblyError as failure:
        system, ways, problem = None, [], str(failure)
        tree = spanning_tree(mechanism)
        pose = _pose(tree, np.zeros(tree.size))
    still = spread and bool(ways)
    if still:
        pose = _most_spread(tree, ways[0].pose[:, :, :3])
    poses = np.concatenate([pose[None], *(way.pose[:, :, :3] for way in ways)])
    elements = all_elements_of(experiment.elements)
    fixed = [point for kind, _, keys in elements for point in kind.points(keys) if not isinstance(point, str)]
    anchors = [np.array(anchor) for anchor in fixed]

    def drawn(low: Array, high: Array) -> tuple[Done, tuple[Shape, ...]]:
        """Draw everything in a picture with these corners."""
        done = Done(Parts(tree, low, high, poses), asked)
        return done, tuple(_shapes(done.parts, done, experiment, ways, low, high))

    shown, roles = (poses[:1], _WIDE) if still else (poses, _WIDE[:1])
    reached = _reached(tree, shown, anchors)
    low, high = _box(tree, reached)
    done, shapes = drawn(low, high)
    wheels = [placed(one.at, pose) for one in shapes if one.role in roles for pose in shown]
    if wheels:  # their radii follow from the shapes
        low, high = _box(tree, np.concatenate([reached, *wheels]))
        done, shapes = drawn(low, high)
    title = experiment.title or mechanism.name
    moved = () if still else ways
    sliders = tuple(_slider(system, way, done.senses.get(way.drive, 1.0)) for way in moved if system)
    return Drawing(
        title, shapes, pose, _reference(tree), {body: link for link, body in tree.index.items()},
        sliders, low, high,
        tuple(facts(mechanism, system, ways, starts, tree.extent)), tuple(doubts(mechanism, tree.extent, experiment)),
        joint_table(mechanism, experiment), link_table(mechanism, tree.extent), problem,
    )  # fmt: skip


def _most_spread(tree: Tree, poses: Array) -> Array:
    """Return the pose (nb, 3) of several whose joints have the largest determinant of their covariance."""
    areas = [np.linalg.det(np.cov(_reached(tree, pose[None], ()).T)) for pose in poses]
    found: Array = poses[int(np.argmax(areas))]
    return found


def _pose(tree: Tree, q: Array) -> Array:
    return poses_at(tree.bodies, q)[:, :3]


def _reference(tree: Tree) -> Array:
    return np.column_stack([tree.drawn, _pose(tree, np.zeros(tree.size))[:, 2]])


def _reached(tree: Tree, poses: Array, anchors: Sequence[Array]) -> Array:
    """Return the places (n, 2) of all joints, frames and fixed points in all poses."""
    ends = [end for j in tree.joints.values() for end in ((j.parent, j.on_parent), (j.child, j.on_child))]
    ends += [(point.link, point.origin) for point in tree.frames]
    ends += [(link.name, link.com) for link in tree.links.values()] + [("world", anchor) for anchor in anchors]
    at = np.array([(*tree.marker(*end), 0.0, 0.0) for end in ends])
    return np.concatenate([placed(at, pose) for pose in poses])


def _box(tree: Tree, reached: Array) -> tuple[Array, Array]:
    """Find the corners of the picture around places (n, 2)."""
    low, high = reached.min(axis=0), reached.max(axis=0)
    span = high - low
    width = max(span[0] / (1.0 - 0.02 * _MARGIN), 1e-3 * tree.extent, 0.8 * span[1])
    size = np.array([width, max(span[1] + 0.02 * _MARGIN * width, _LEAST * width)])
    middle = 0.5 * (low + high)
    return middle - 0.5 * size, middle + 0.5 * size


def _shapes(
    parts: Parts, done: Done, experiment: Experiment, ways: Sequence[Travel], low: Array, high: Array
) -> Iterator[Shape]:
    """Return all shapes from bottom to top."""
    tree, play = parts.tree, experiment.play
    points = asked_points(experiment.outputs)
    yield from _furniture(parts, experiment, low, high)
    for joint in tree.joints.values():
        yield from parts.beneath(joint)
    if ways:
        for name in points:
            frame = tree.places[name]
            marker = np.array([parts.on(frame.link, frame.origin)])
            path = np.concatenate([placed(marker, pose) for pose in ways[0].pose[:: 1 + len(ways[0].pose) // _PATH]])
            yield shape("path", [(0, 0.0, 0.0, *at) for at in path])
    for link in tree.links.values():
        yield from parts.link(link)
    for joint in sorted(tree.joints.values(), key=lambda joint: joint.type != "prismatic"):  # pins above blocks
        yield from parts.joint(joint, joint.name in play)
    for way in ways:
        yield from done.drive(tree.joints[way.drive])
    for link in tree.links.values():
        yield from parts.link_name(link)
    yield from done.all(experiment)
    for name in points:
        yield from parts.point(name)
    yield from parts.joint_names([way.drive for way in ways])


def _furniture(parts: Parts, experiment: Experiment, low: Array, high: Array) -> Iterator[Shape]:
    """Draw scale, axes, and the direction of gravity."""
    unit, basis = parts.unit, parts.tree.basis

    def at(corner: Array, x: float, y: float) -> tuple[float, float, float, float, float]:
        return 0.0, 0.0, 0.0, float(corner[0] + x * unit), float(corner[1] + y * unit)

    def take(corner: Array, one: tuple[float, float], other: tuple[float, float]) -> None:
        parts.room.take_box(corner + unit * np.array(one), corner + unit * np.array(other))

    length, text = round_length(22.0 * unit)
    right = np.array([high[0], low[1]])
    wide = length / unit
    for line in (((-3 - wide, 2), (-3, 2)), ((-3 - wide, 1.4), (-3 - wide, 2.6)), ((-3, 1.4), (-3, 2.6))):
        yield shape("scale", [at(right, *end) for end in line])
    yield shape("note", [at(right, -3 - 0.5 * wide, 3.6)], text=text)
    take(right, (-4 - wide, 0.5), (-2, 5))
    take(low, (0.5, 0.5), (10, 10))
    for way, name in (((1, 0), _axis(basis[:, 0])), ((0, 1), _axis(basis[:, 1]))):
        yield shape("scale", [at(low, 2, 2), at(low, 2 + 5 * way[0], 2 + 5 * way[1])])
        yield shape("note", [at(low, 2 + 6.4 * way[0], 2 + 6.4 * way[1])], text=name)
    gravity = basis[:, :2].T @ experiment.gravity
    if np.linalg.norm(gravity) > 0.0:
        down = gravity / np.linalg.norm(gravity)
        yield from parts.arrow("drive", [at(high, *(s * down - 6.0)) for s in (-3.5, 3.5)])
        yield shape("note", [at(high, -3.4, -6.0)], text="g")
        take(high, (-10.5, -10.5), (-1.5, -1.5))


def _axis(direction: Array) -> str:
    """Return the name of the world's axis in a direction, or of the plane's axis."""
    k = int(np.argmax(np.abs(direction)))
    return "xyz"[k] if direction[k] > 1.0 - 1e-9 else ("x_P" if abs(direction[2]) < 1e-9 else "y_P")


def _slider(system: System, way: Travel, sense: float) -> Slider:
    """Reduce a range of motion to the visible resolution."""
    turns = system.joints[way.drive].type == "revolute"
    start = system.drives[way.drive].start(system.values)
    evenly = np.linspace(0, len(way.values) - 1, _SHOWN).round().astype(int)
    keep = np.unique([*evenly, int(np.argmin(np.abs(way.values - start)))])
    values = way.values[keep]
    factor = 180.0 / np.pi if turns else 1e3
    first = int(np.argmin(np.abs(values - start)))
    return Slider(way.drive, "deg" if turns else "mm", factor * values, way.pose[keep][:, :, :3], first, sense)
