"""Mode shapes of a linkage at named points, and at the lines that represent its links."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from linkages.arrays import Array
from linkages.explore.modes import Modes
from linkages.model.skeleton import skeleton
from linkages.planar.bodies import make_motion
from linkages.planar.kinematics import body_velocities, poses_at
from linkages.system.flexible_link import FlexibleLink

_SAMPLES = 25  # number of samples of a flexible link, or of a substructure


class ModeLine(NamedTuple):
    """A line of a link: name, colour, n points (n, 2) [m], and displacements (m, n, 2)."""

    link: str
    color: str
    places: Array
    ways: Array


class ModeShapes:
    """Displacements in the m modes of a linkage, scaled so that no point of a line moves farther than 1.

    Attributes
    ----------
    lines : list of ModeLine
        Flexible links are sampled along their beams; rigid ones are the bars between their joints and frames.
    scale : (m,) array
        Factor on the shapes of unit modal mass; its square is the modal mass of the scaled shape.
    """

    def __init__(self, modes: Modes) -> None:
        self._system, self._changes = modes.system, modes.full()
        bodies = self._system.tree.bodies
        self._pose = poses_at(bodies, self._system.assembly.q)
        moved = []
        for change in self._changes.T:
            motion = make_motion(bodies)
            body_velocities(bodies, self._pose, np.ascontiguousarray(change), motion)
            moved.append(motion)
        self._moved = np.array(moved)
        lines = list(self._lines())
        largest = np.max([np.linalg.norm(line.ways, axis=2).max(axis=1) for line in lines], axis=0)
        self.scale: Array = 1.0 / np.where(largest > 0.0, largest, 1.0)
        self.lines = [line._replace(ways=line.ways * self.scale[:, None, None]) for line in lines]

    def points(self) -> dict[str, Array]:
        """Return displacements along x and y, and turns, of all links' and frames' origins, (3, m) each."""
        found = {}
        for name in self._system.mechanism.point:
            body, x, y = self._system.tree.named_marker(name)
            arms = _turned(self._pose[body, 2], np.array([[x, y]]))
            turn = self._moved[:, body, 0]
            found[name] = np.vstack([self._displaced(body, arms)[:, 0].T, turn]) * self.scale
        return found

    def _lines(self) -> Iterator[ModeLine]:
        tree, mechanism = self._system.tree, self._system.mechanism
        for link in mechanism.links:
            shape = skeleton(mechanism, link, tree.extent)
            if link.name in tree.flexible:
                yield from (self._beam(link.name, shape.color, part) for part in tree.flexible[link.name])
                continue
            body = tree.index[link.name]
            arms = _turned(self._pose[body, 2], shape.places - tree.drawn[body])
            places, ways = self._pose[body, :2] + arms, self._displaced(body, arms)
            for bar in shape.bars or ((0, 0),):
                yield ModeLine(link.name, shape.color, places[list(bar)], ways[:, list(bar)])

    def _beam(self, link: str, color: str, part: FlexibleLink) -> ModeLine:
        """Sample a beam, or a substructure."""
        tree, body = self._system.tree, self._system.tree.index[part.name]
        s = np.linspace(*part.ends, _SAMPLES)
        along, across = part.modes.shapes(s)
        eta = int(tree.bodies.records[body]["eta"]) + np.arange(len(part.modes.names))
        angle, still = self._pose[body, 2] + np.arctan2(*part.direction[::-1]), self._system.assembly.q[eta]
        arms = _turned(angle, np.column_stack([s + along @ still, across @ still]))
        own = np.stack([self._changes[eta].T @ along.T, self._changes[eta].T @ across.T], axis=-1)
        return ModeLine(link, color, self._pose[body, :2] + arms, self._displaced(body, arms) + _turned(angle, own))

    def _displaced(self, body: int, arms: Array) -> Array:
        """Displacements (m, n, 2) of points fixed to a body's frame at arms (n, 2) from its origin."""
        turn, x, y = (self._moved[:, body, k, None] for k in range(3))
        return np.stack([x - turn * arms[:, 1], y + turn * arms[:, 0]], axis=-1)


def _turned(angle: float, vectors: Array) -> Array:
    """Rotate vectors (..., 2) by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vectors[..., 0] - s * vectors[..., 1], s * vectors[..., 0] + c * vectors[..., 1]], axis=-1)
