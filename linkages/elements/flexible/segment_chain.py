"""The chain of rigid segments that the Drake engine runs instead of a flexible link: rigid finite elements.

Between neighbouring interfaces (joints and loads) a beam is cut into equal cells of
length h. A segment is a thin rod that reaches from the middle of one cell to the middle of the next one, so that its
own middle is a node, to which joints attach. The hinges between segments have the stiffness EI/h and the damping of the
beam. Section angles and places on the beam are accurate to second order in h, at clamped and at pinned ends. Segments
are inextensible and shorten by bending as the beam does: geometric stiffening is exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np

from linkages.base.arrays import Array
from linkages.elements.coordinates import HINGE
from linkages.input.files.raw_model import LinkBeam

Columns = Mapping[str, Array]  #: of a run of the rigid linkage, by name


class Cut(Protocol):
    """A link to divide; `linkages.input.model.mechanism.Link` is one, and explains these."""

    @property
    def name(self) -> str:
        """Return its name."""

    @property
    def angle(self) -> float:
        """Return the angle of its frame [rad]."""

    @property
    def translation(self) -> Array:
        """Return the place of its frame in the world, (3,) [m]."""


@dataclass(frozen=True, eq=False)
class SegmentChain:
    """The chain of rigid segments of a flexible link; its interfaces and its beam's ends, from the beam's start [m]."""

    link: Cut
    beam: LinkBeam
    count: int  # about the number of segments
    damping: float  # over stiffness [s]
    ends: list[float]

    @property
    def length(self) -> float:
        """Return the length of the beam [m]."""
        return self.beam.length

    @cached_property
    def _counts(self) -> list[int]:
        """Return the number of cells between neighbouring ends."""
        part = np.diff(self.ends) / self.beam.length
        return np.maximum(np.rint(self.count * part), 1).astype(int).tolist()

    @cached_property
    def nodes(self) -> Array:
        """Return the places (n + 1,) of the segments' nodes, from the beam's start [m]."""
        spans = zip(pairwise(self.ends), self._counts, strict=True)
        return np.concatenate([[0.0], *(np.linspace(a, b, count + 1)[1:] for (a, b), count in spans)])

    @cached_property
    def hinges(self) -> Array:
        """Return the places (n,) of the hinges, from the beam's start [m]."""
        middles: Array = 0.5 * (self.nodes[1:] + self.nodes[:-1])
        return middles

    @cached_property
    def stiffnesses(self) -> Array:
        """Return the stiffnesses (n,) of the hinges [N m/rad]."""
        return self.beam.youngs_modulus * self.beam.second_moment / np.diff(self.nodes)

    @property
    def segments(self) -> list[str]:
        """Return the names of the n + 1 segments, as links."""
        return [f"{self.link.name}/piece{k}" for k in range(len(self.nodes))]

    @property
    def joints(self) -> list[str]:
        """Return the names of the n hinges, as joints."""
        return [f"{self.link.name}{HINGE}{k + 1}" for k in range(len(self.hinges))]

    @property
    def springs(self) -> list[str]:
        """Return the names of the hinges' n torsion springs."""
        return [f"{self.link.name}/spring{k + 1}" for k in range(len(self.hinges))]

    def carrier(self, point: Array) -> str:
        """Return the name of the segment that carries a reference point on the link."""
        return self.segments[int(np.searchsorted(self.hinges, self.beam.along(point)))]

    def stations(self) -> tuple[Array, Array]:
        """Return places (ns,) [m], and the factors (ns, n) that interpolate values at the hinges there.

        The places are the hinges, and both sides of each end, where forces may jump: extrapolated through two hinges.
        """
        places, factors, first = [self.hinges], [np.eye(len(self.hinges))], 0
        for (a, b), count in zip(pairwise(self.ends), self._counts, strict=True):
            if count > 1:
                last = first + count - 1
                lines = np.zeros((2, len(self.hinges)))
                lines[0, first : first + 2] = lines[1, [last, last - 1]] = 1.5, -0.5
                places.append(np.array([a, b]))
                factors.append(lines)
            first += count
        return np.concatenate(places), np.concatenate(factors)

    def deflection(self, name: str, drawn: Array, table: Columns) -> Array:
        """Compute the change of a frame's distance from the beam's chord due to deformation."""
        (x, y), (x0, y0), (x1, y1) = ((table[f"{at}.x"], table[f"{at}.y"]) for at in (name, *self.beam.frames))
        dx, dy = x1 - x0, y1 - y0
        (ux, uy), (rx, ry) = (self.beam.end - self.beam.start) / self.beam.length, drawn - self.beam.start
        distance: Array = (dx * (y - y0) - dy * (x - x0)) / np.hypot(dx, dy) - (ux * ry - uy * rx)
        return distance

    def largest_deflection(self, table: Columns) -> dict[str, Array]:
        """Compute the largest distance of a hinge from the beam's chord, and its place."""
        edges = np.array([0.0, *self.hinges, self.beam.length])
        angles, lengths = np.array([table[f"{name}.angle"] for name in self.segments]), np.diff(edges)[:, None]
        x, y = np.cumsum(lengths * np.cos(angles), axis=0), np.cumsum(lengths * np.sin(angles), axis=0)
        distances = np.abs(x[-1] * y - y[-1] * x) / np.hypot(x[-1], y[-1])
        name = self.link.name
        return {
            f"{name}.deflection": distances.max(axis=0),
            f"{name}.deflection_place": edges[1 + distances.argmax(axis=0)],
        }

    def internal_forces(self, table: Columns) -> dict[str, Array]:
        """Compute largest bending moment, normal stress and compression from the hinges' springs and forces."""
        beam, (places, factors) = self.beam, self.stations()
        moments = factors @ np.array([table[f"{name}.torque"] for name in self.springs])
        way = np.arctan2(*(beam.end - beam.start)[::-1]) - self.link.angle
        pulls = []
        for name, inner, outer in zip(self.joints, self.segments[:-1], self.segments[1:], strict=True):
            angle = way + 0.5 * (table[f"{inner}.angle"] + table[f"{outer}.angle"])
            pulls.append(-np.cos(angle) * table[f"{name}.fx"] - np.sin(angle) * table[f"{name}.fy"])
        force = factors @ np.array(pulls)
        stress = np.abs(force) / beam.area + np.abs(moments) * 0.5 * beam.height / beam.second_moment
        name = self.link.name
        return {
            f"{name}.bending": np.abs(moments).max(axis=0),
            f"{name}.stress": stress.max(axis=0),
            f"{name}.stress_place": places[stress.argmax(axis=0)],
            f"{name}.compression": np.maximum(-force, 0.0).max(axis=0),
        }
