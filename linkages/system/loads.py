"""From an experiment's applied loads to the records that the kernels read; their names checked on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from linkages.errors import InputError, nearest
from linkages.model.load_tables import Force, Spring, Torque, TorsionSpring
from linkages.model.mechanism import Frame, Mechanism
from linkages.planar.kinematics import body_positions
from linkages.planar.loads import LOAD_OUTPUTS, Array, Loads, load_outputs
from linkages.planar.motion import Motions, Pieces
from linkages.planar.records import FORCE, LOAD, SPRING, TORQUE, TORSION
from linkages.system.tree import Tree

if TYPE_CHECKING:
    from linkages.model.experiment import Experiment

#: Tables of loads in an experiment, in the order in which the loads are packed.
TABLES = ("forces", "torques", "springs", "torsion_springs")

_COINCIDENT = 1e-9  # of the linkage's size: points closer than this have no direction between them


def load_names(experiment: Experiment) -> tuple[tuple[str, str], ...]:
    """Table and name of each load, in the order of `pack_loads`."""
    return tuple((table, name) for table in TABLES for name in getattr(experiment, table))


def pack_loads(tree: Tree, experiment: Experiment) -> Loads:
    """Pack the loads for `linkages.planar.loads`: records, and the values of forces and torques over time.

    Parameters
    ----------
    tree : Tree
    experiment : Experiment
        Checked by `check_loads`.
    """
    mechanism = tree.mechanism
    records: NDArray[np.record] = np.zeros(len(load_names(experiment)), LOAD)
    following = iter(records)
    motions: list[Pieces] = []

    def end(name: str) -> tuple[int, float, float]:
        point = mechanism.point[name]
        return tree.index[point.link], *tree.local(point.link, point.origin)

    for force in experiment.forces.values():
        record = next(following)
        record["kind"], record["turns"], record["motion"] = FORCE, force.axes == "body", len(motions)
        record["a"], record["ax"], record["ay"] = end(force.point)
        motions += _turned(force, mechanism.point[force.point].angle if force.axes == "body" else 0.0)
    for torque in experiment.torques.values():
        record = next(following)
        record["kind"], record["a"], record["motion"] = TORQUE, tree.index[torque.link], len(motions)
        motions.append(torque.history())
    for spring in experiment.springs.values():
        record = next(following)
        record["kind"], record["motion"] = SPRING, -1
        record["a"], record["ax"], record["ay"] = end(spring.point)
        other = end(spring.to) if spring.to is not None else (0, *(spring.anchor or ()))
        record["b"], record["bx"], record["by"] = other
        record["stiffness"], record["free"] = spring.stiffness, spring.free_length
        record["damping"] = spring.damping
    for torsion in experiment.torsion_springs.values():
        record = next(following)
        record["kind"], record["motion"] = TORSION, -1
        links, sign = torsion.links or [], 1.0
        if torsion.joint is not None:
            joint = mechanism.joint[torsion.joint]
            links, sign = [joint.parent, joint.child], joint.sign
        record["a"], record["b"] = (tree.index[link] for link in links)
        record["sign"], record["stiffness"], record["free"] = sign, torsion.stiffness, torsion.free_angle
        record["damping"] = torsion.damping
    return records, *Motions(motions).arrays


def _turned(force: Force, angle: float) -> tuple[Pieces, Pieces]:
    """Components over time, turned by an angle."""
    x, y = force.components()
    c, s = np.cos(angle), np.sin(angle)
    return Pieces(c * x.c - s * y.c, x.x), Pieces(s * x.c + c * y.c, y.x)


def check_loads(mechanism: Mechanism, experiment: Experiment) -> None:
    """Check that the names in the loads exist in the mechanism, and that tables cover the duration.

    Raises
    ------
    InputError
        One line with key and reason.
    """
    taken = {"world", *mechanism.point, *mechanism.joint}
    for table, name in load_names(experiment):
        check = _Check(mechanism, experiment, f"{table}.{name}")
        if name in taken:
            check.refuse("", "is also the name of a link, frame, joint or load; choose another one")
        if "." in name:
            check.refuse("", "has a dot in its name; choose another one")
        taken.add(name)
        checks: dict[str, Callable[[Any], None]] = {
            "forces": check.force,
            "torques": check.torque,
            "springs": check.spring,
            "torsion_springs": check.torsion_spring,
        }
        checks[table](getattr(experiment, table)[name])


@dataclass(frozen=True)
class _Check:
    """Checks of one load at the dotted path `where`."""

    mechanism: Mechanism
    experiment: Experiment
    where: str

    def force(self, load: Force) -> None:
        self.covers(load.times)
        if self.point("point", load.point).link == "world":
            self.refuse("point", f'"{load.point}" is fixed to the world; name a link\'s')

    def torque(self, load: Torque) -> None:
        self.covers(load.times)
        self.known("link", load.link, self.mechanism.link)

    def spring(self, load: Spring) -> None:
        link = self.point("point", load.point).link
        other = "world" if load.to is None else self.point("to", load.to).link
        if link == other:
            self.refuse("", f'joins two points of the same link, "{link}"')

    def torsion_spring(self, load: TorsionSpring) -> None:
        if load.joint is not None:
            self.known("joint", load.joint, self.mechanism.joint)
            kind = self.mechanism.joint[load.joint].type
            if kind != "revolute":
                self.refuse("joint", f'"{load.joint}" is {kind}; a revolute joint can turn')
            return
        first, second = load.links or ["", ""]
        for link in (first, second):
            self.known("links", link, ("world", *self.mechanism.link))
        if first == second:
            self.refuse("links", "are one and the same")

    def covers(self, times: list[float] | None) -> None:
        """Check that a table lasts as long as the run."""
        duration = self.experiment.duration
        if times is not None and times[-1] < duration:
            self.refuse("times", f"end at {times[-1]:g} s, before the duration of {duration:g} s")

    def point(self, key: str, name: str) -> Frame:
        """Find a named point."""
        if name == "world":
            self.refuse(key, 'is "world"; name a frame, or give a spring an anchor')
        self.known(key, name, self.mechanism.point)
        return self.mechanism.point[name]

    def known(self, key: str, name: str, names: Iterable[str]) -> None:
        """Check a name against those that the mechanism has."""
        if name not in names:
            self.refuse(key, f'"{name}" is not in {self.mechanism.source.name}; {nearest(name, names)}')

    def refuse(self, key: str, problem: str) -> NoReturn:
        raise InputError(self.experiment.source, f"{self.where}.{key}".rstrip("."), problem)


def check_lengths(tree: Tree, experiment: Experiment, q: Array) -> None:
    """Check that springs with a free length have a direction at the start.

    Parameters
    ----------
    q : (n,) array
        Coordinates at t = 0.

    Raises
    ------
    InputError
        If the points of one coincide there.
    """
    if not experiment.springs:
        return
    nb, names = len(tree.bodies), load_names(experiment)
    pose, outputs = np.empty((nb, 5)), np.empty((len(names), len(LOAD_OUTPUTS)))
    body_positions(tree.bodies, q, pose)
    load_outputs(pack_loads(tree, experiment), 0.0, pose, np.zeros((nb, 3)), outputs)
    length = {name: outputs[k, 1] for k, (table, name) in enumerate(names) if table == "springs"}
    for name, spring in experiment.springs.items():
        if spring.free_length > 0.0 and length[name] <= _COINCIDENT * tree.extent:
            raise InputError(
                experiment.source,
                f"springs.{name}",
                "its points coincide at t = 0, where a spring with a free length has no direction;"
                " set free_length = 0 or start elsewhere",
            )
