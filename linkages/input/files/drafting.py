"""Geometry and mass of a described mechanism: positions of points, mass of links."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import nearest
from linkages.input.files.formula import parse
from linkages.input.files.raw_model import Pose, rotation

_LONGEST_CHAIN = 150  # parameters that refer to each other


class DraftError(Exception):
    """An invalid value of a description: dotted path and reason."""


class Numbers:
    """Numbers of a description by name: parameters (texts are formulas), coordinates ``A.x``, ``A.y`` of points.

    A point is ``[x, y]``; ``[point, distance, angle]``, where a point may stand for the direction; or ``[first,
    distance, second, distance]``, to the left of the line from first to second.
    """

    def __init__(self, parameters: Mapping[str, Any], points: Mapping[str, Sequence[Any]]) -> None:
        self.parameters, self.points = parameters, points
        self.found: dict[str, float] = {}
        self.asked: list[str] = []

    def number(self, value: Any, where: str) -> float:
        """Return a number, or the value of a formula."""
        if isinstance(value, int | float) and not isinstance(value, bool):
            return float(value)
        if not isinstance(value, str):
            raise DraftError(where, f"is {value!r}; give a number, or a formula or a quantity in quotes")
        try:
            formula = parse(value)
        except ValueError as problem:
            raise DraftError(where, str(problem)) from None
        result = formula({name: self.named(name, where) for name in sorted(formula.names)})
        if math.isnan(result):
            raise DraftError(where, f'"{value}" has no finite value')
        return result

    def named(self, name: str, where: str) -> float:
        """Return the number with a name."""
        owner, dot, part = name.partition(".")
        if name not in self.found:
            if name in self.asked:
                raise DraftError(where, f"depends on itself ({' -> '.join([*self.asked, name])}); break the circle")
            if len(self.asked) > _LONGEST_CHAIN:
                raise DraftError("parameters and points", "refer to each other in a chain that is too long")
            self.asked.append(name)
            if dot and owner in self.points and part in ("x", "y"):
                self.found[name] = self.place(owner, where)["xy".index(part)]
            elif name in self.parameters:
                self.found[name] = self.number(self.parameters[name], f"parameters.{name}")
            else:
                known = [*self.parameters, *(f"{point}.{axis}" for point in self.points for axis in "xy")]
                raise DraftError(where, f'"{name}" is unknown; {nearest(name, known)}')
            self.asked.pop()
        return self.found[name]

    def place(self, point: str, asked_by: str) -> tuple[float, float]:
        """Return the position of a point [m]."""
        if point not in self.points:
            raise DraftError(asked_by, f'there is no point "{point}"; {nearest(point, self.points)}')
        where, key = f"points.{point}", f"at {point}"
        if f"{point}.x" in self.found and f"{point}.y" in self.found:
            return self.found[f"{point}.x"], self.found[f"{point}.y"]
        if key in self.asked:
            raise DraftError(where, "depends on itself; break the circle")
        self.asked.append(key)
        match list(self.points[point]):
            case [x, y]:
                place = self.number(x, where), self.number(y, where)
            case [str(start), distance, towards]:
                x, y = self.place(start, where)
                if isinstance(towards, str) and towards in self.points:
                    end = self.place(towards, where)
                    angle = math.atan2(end[1] - y, end[0] - x)
                else:
                    angle = self.number(towards, where)
                length = self.number(distance, where)
                place = x + length * math.cos(angle), y + length * math.sin(angle)
            case [str(first), one, str(second), other]:
                place = self._between(first, self.number(one, where), second, self.number(other, where), where)
            case _:
                raise DraftError(where, "give [x, y], [point, distance, angle] or [point, distance, point, distance]")
        self.asked.pop()
        self.found[f"{point}.x"], self.found[f"{point}.y"] = place
        return place

    def _between(self, first: str, one: float, second: str, other: float, where: str) -> tuple[float, float]:
        """Return the intersection of two circles to the left of the line between their centres."""
        a, b = np.array(self.place(first, where)), np.array(self.place(second, where))
        apart = float(np.linalg.norm(b - a))
        along = (apart**2 + one**2 - other**2) / (2.0 * apart) if apart else math.inf
        if not abs(along) <= one:
            problem = f"no point is {one:g} m from {first} and {other:g} m from {second}, which are {apart:g} m apart"
            raise DraftError(where, f"{problem}; change a length")
        way = (b - a) / apart
        x, y = a + along * way + math.sqrt(one**2 - along**2) * np.array([-way[1], way[0]])
        return float(x), float(y)


class Body(NamedTuple):
    """Mass [kg], mass centre (2,) [m] and tensor of inertia about it (3, 3) [kg m2], in the plane's axes."""

    mass: float
    centre: Array
    inertia: Array


def body(points: Array, angle: float, section: tuple[float, float], density: float) -> Body:
    """Compute mass, mass centre and inertia of a link made of straight bars of rectangular section.

    Bars join successive points, and the last to the first if three or more points are not on a line. A link with one
    point is a block, twice as long as the section is wide, along the angle [rad]. Points (n, 2) [m]; width of the
    section in the plane, thickness normal to it [m]; density [kg/m3].
    """
    width, thick = section
    if len(points) == 1:
        half = width * np.array([math.cos(angle), math.sin(angle)])
        points = np.array([points[0] - half, points[0] + half])
    ends = [*pairwise(points)]
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if len(points) > 2 and spread[1] > 1e-9 * spread[0]:
        ends.append((points[-1], points[0]))
    mass, moment, about = 0.0, np.zeros(2), np.zeros((2, 2))
    for start, end in ends:
        length = float(np.linalg.norm(end - start))
        if not length:
            continue
        along, middle, part = (end - start) / length, (start + end) / 2.0, density * width * thick * length
        across = np.array([-along[1], along[0]])
        own = np.outer(along, along) * length**2 + np.outer(across, across) * width**2
        mass, moment = mass + part, moment + part * middle
        about += part * (own / 12.0 + np.outer(middle, middle))
    centre = moment / mass if mass else points.mean(axis=0)
    (xx, xy), (_, yy) = about - mass * np.outer(centre, centre)
    flat = mass * thick**2 / 12.0
    tensor = np.array([[yy + flat, -xy, 0.0], [-xy, xx + flat, 0.0], [0.0, 0.0, xx + yy]])
    return Body(mass, centre, tensor)


def upright(angle: float, place: Sequence[float]) -> Pose:
    """Return a pose in the plane: its angle [rad] and its origin [m]."""
    return Pose(rotation(np.array([0.0, 0.0, angle])), np.array([*place, 0.0]))
