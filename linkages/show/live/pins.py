"""Pins that are moved in a shown pose, as changes of lengths.

Both links of the pin get the lengths with which the loops stay closed there. The drives' coordinates, all other pins in
their links, and the lines of guides stay. A link with two pins may turn meanwhile, since its length alone matters; a
link with more pins, and the ground, do not. The values with this effect and the
least change, in parts of themselves, are chosen; values that are zero in the file change only if no others suffice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import InputError
from linkages.system import System
from linkages.system.joints import SystemJoint

_FAR = 1e-3  # error of a place over a move, from which the move is impossible
_ROUNDS = 8  # of Newton's method
_SOFT = 1e-2  # weight of the place of the moved pin against all other places
_FREE = 1e3  # weight of motions of links against changes of lengths
_STEP = 1e-4  # of a difference, over the size of the machine


class Places:
    """Where the joints are in their links, and how the lengths of a machine change that."""

    def __init__(self, system: System) -> None:
        self.system, drives = system, system.drives
        self._ends = [(joint, link) for joint in system.joints.values() for link in (joint.parent, joint.child)]
        self._local = _local(system)
        lengths = [path for path in system.machine_values if _is_length(system, path)]
        if any(path.startswith("parameters.") for path in lengths):
            lengths = [path for path in lengths if path.startswith("parameters.")]
        # a zero changes only if nothing else has the effect: frames of the ground first, then others, then links
        self._driven = {(j.parent, j.child) for j, _ in self._ends if j.name in drives and drives[j.name].prescribed}
        usual = [path for path in lengths if system.machine_values[path]]
        fixed = {child for _, child in self._driven}
        frames = {f"frames.{name}.": frame.link for name, frame in system.points.items() if frame.link not in fixed}
        ground = tuple(start for start, link in frames.items() if link == "world")
        further = (), ground, tuple(frames), (*frames, "links.")
        self._tried = [
            [path for path in lengths if path in usual or (starts and path.startswith(starts))] for starts in further
        ]
        self._slopes: dict[str, Array] = {}

    def moved(self, name: str, to: Sequence[float], pose: Mapping[str, float]) -> dict[str, float]:
        """Return the values that move the pin of a joint to a place [m] in a pose: outputs of links, by name.

        Where it is not free, it moves as near as it can; InputError if it cannot move at all.
        """
        angles = {link: pose[f"{link}.angle"] for link in self.system.links if f"{link}.angle" in pose}
        end = next(k for k, (joint, link) in enumerate(self._ends) if joint.name == name and link != "world")
        link = self._ends[end][1]
        here = np.array([pose[f"{link}.x"], pose[f"{link}.y"]]) + _turn(angles[link]) @ self._local[end]
        return self.shifted(name, np.asarray(to) - here, angles)

    def shifted(self, name: str, way: Array, angles: Mapping[str, float]) -> dict[str, float]:
        """Return the values that move a pin by `way` (2,) [m] in a pose with these angles of links [rad]."""
        extent, best, least = self.system.tree.extent, {}, float(np.hypot(*way)) * (1.0 - _FAR)
        together = self._together(name)
        for paths in self._tried:
            values = np.array([self.system.machine_values[path] for path in paths])
            scale = np.abs(values) + 1e-3 * extent * (values == 0.0)
            change, left = self._change(paths, scale, together, way, angles)
            if left < least * (1.0 - _FAR):
                kept = np.abs(change) > 1e-7 * extent
                new = zip(np.array(paths)[kept].tolist(), (values + change)[kept].tolist(), strict=True)
                best, least = {f"sdf.{path}": float(f"{value:.9g}") for path, value in new}, left
            if left <= _FAR * float(np.hypot(*way)):
                break
        if not best:
            raise InputError("page", f"joint {name}", "cannot move there: no length of the file has this effect")
        return best

    def _together(self, name: str) -> set[str]:
        """Return the joints at the place of a joint: each shares a link, and the place in it, with another."""
        found, near = {name}, 1e-5 * self.system.tree.extent
        for _ in self._ends:
            for (joint, link), here in zip(self._ends, self._local, strict=True):
                same = [
                    other.name
                    for (other, its), there in zip(self._ends, self._local, strict=True)
                    if its == link != "world"
                    and other.type == joint.type == "revolute"
                    and np.hypot(*(there - here)) < near
                ]
                if joint.name in found:
                    found |= set(same)
        return found

    def _change(
        self, paths: Sequence[str], scale: Array, moved: set[str], way: Array, angles: Mapping[str, float]
    ) -> tuple[Array, float]:
        """Find the least change (m,) of values, in parts of a scale (m,), and how far the pin stays away [m]."""
        slopes = np.array([self._slope(path) for path in paths]).reshape(len(paths), -1, 2)
        links = list(dict.fromkeys(link for _, link in self._ends if link != "world"))
        pose, change = np.zeros((len(links) + 1, 3)), np.zeros(len(paths))  # the last pose is the ground's
        pose[:-1, 2] = [angles.get(link, self.system.links[link].angle) for link in links]
        body = [links.index(link) if link in links else -1 for _, link in self._ends]
        across = [self._across(joint, angles) for joint, _ in self._ends]
        moves = np.array([joint.name in moved for joint, _ in self._ends])
        goal = np.array([_turn(pose[b, 2]) @ own for b, own in zip(body, self._local, strict=True)]) + np.outer(
            moves, way
        )
        held, left = np.zeros((len(self._driven), len(paths) + pose.size)), np.zeros((len(body), 2))
        for row, pair in zip(held, self._driven, strict=True):  # a drive's angle stays
            for link, sign in zip(pair, (-1.0, 1.0), strict=True):
                if link in links:
                    row[len(paths) + 3 * links.index(link) + 2] = sign * _FREE * self.system.tree.extent
        for round_ in range(_ROUNDS + 1):
            matrix = np.zeros((len(body), 2, len(paths) + pose.size))
            for k, b in enumerate(body):
                turn = _turn(pose[b, 2])
                arm = turn @ (self._local[k] + change @ slopes[:, k])
                left[k] = across[k] @ (goal[k] - arm - pose[b, :2])
                matrix[k, :, : len(paths)] = scale * (turn @ slopes[:, k].T)
                if b >= 0:  # the motions of links cost nothing
                    at = len(paths) + 3 * b
                    matrix[k, :, at : at + 3] = _FREE * np.array([[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]])
                matrix[k] = across[k] @ matrix[k]
            if round_ < _ROUNDS:
                weight = np.where(moves, _SOFT, 1.0)[:, None]
                whole = np.vstack([(weight[..., None] * matrix).reshape(2 * len(body), -1), held])
                asked = np.append(weight * left, np.zeros(len(held)))
                found = np.linalg.lstsq(whole, asked, rcond=1e-12)[0]
                change = change + scale * found[: len(paths)]
                pose = pose + _FREE * found[len(paths) :].reshape(pose.shape)
        return change, float(np.abs(left).max())

    def _across(self, joint: SystemJoint, angles: Mapping[str, float]) -> Array:
        """Return the matrix of the part of a move that counts: for a guide the one across its line."""
        if joint.type != "prismatic":
            return np.eye(2)
        link = self.system.links.get(joint.parent)
        turn = 0.0 if link is None else angles.get(link.name, link.angle) - link.angle
        normal = _turn(turn) @ [-joint.direction[1], joint.direction[0]]
        return np.outer(normal, normal)

    def _slope(self, path: str) -> Array:
        """Return the derivative of the local places with respect to a length."""
        if path not in self._slopes:
            step, self._slopes[path] = _STEP * self.system.tree.extent, np.zeros_like(self._local)
            with suppress(InputError):  # of a value out of the plane
                other = self.system.replaced({f"sdf.{path}": self.system.machine_values[path] + step})
                self._slopes[path] = (_local(other) - self._local) / step
        return self._slopes[path]


def _is_length(system: System, path: str) -> bool:
    """Return whether a value can be a length: a part of a place, or a parameter."""
    if path.startswith("parameters."):
        return system.mechanism.units.get(path, "m") == "m"
    return path.endswith((".pose.x", ".pose.y", ".pose.z"))


def _local(system: System) -> Array:
    """Return the places of the joints in their parents and children, in turn (2 n, 2), link axes [m]."""
    found = []
    for joint in system.joints.values():
        for name, place in ((joint.parent, joint.on_parent), (joint.child, joint.on_child)):
            link = system.links.get(name)
            found.append(place if link is None else _turn(-link.angle) @ (place - link.origin))
    return np.array(found)


def _turn(angle: float) -> Array:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])
