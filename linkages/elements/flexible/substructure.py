"""A substructure of a flexible link as a deformable body: its modes are shapes, their amplitudes shape coordinates."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np

from linkages.base.arrays import Array, Records
from linkages.elements.flexible import numerics
from linkages.elements.flexible.internal_forces import STATION, STATION_MODE
from linkages.input.files.raw_model import LinkBeam
from linkages.mechanics.flexible.component_modes import ComponentModes
from linkages.mechanics.planar.bodies import DAMPING, ELASTIC, MATRIX, SHAPE, STIFFNESS

SAME = 1e-9  # places closer than this, relative to the beam's length, coincide


class Rod(Protocol):
    """A link, or a part of one, that a beam is; `linkages.input.model.mechanism.Link` is one, and explains these."""

    mass: float
    com: Array
    inertia: float
    beam: LinkBeam | None


@dataclass(frozen=True)
class Substructure:
    """A flexible link, or one of its substructures."""

    name: str
    rod: Rod  # beam and mass
    carrier: str  # the one that carries this one; empty if a joint carries it, or if it floats
    origin: Array  # of the frame in the reference configuration: on the beam, at the carrier, (2,) [m]
    direction: Array  # unit vector along the beam in the reference configuration, from its first to its last end
    abscissas: tuple[float, ...]  # sections to which joints and frames are fixed, from the origin [m]
    acting: frozenset[float]  # sections on which joints or loads act, without the carrier's [m]
    modes: ComponentModes
    damping: Array  # over stiffness of each mode, (nf,) [s]
    ends: tuple[float, float]  # abscissas of the substructure's ends [m]
    first: float  # distance of the origin from the first end of the link's beam [m]
    settles: bool  # whether it is deflected by its loads at t = 0
    is_chord: bool  # whether its axis passes through another joint; else it is tangent to the beam at the origin

    @property
    def beam(self) -> LinkBeam:
        """Return the beam of the substructure."""
        assert self.rod.beam is not None  # only links with a beam are flexible
        return self.rod.beam

    def abscissa(self, point: Array) -> float:
        """Return the abscissa of the section that carries a joint or frame at a reference point [m]."""
        return self.nearest(float((point - self.origin) @ self.direction))

    def nearest(self, s: float) -> float:
        """Return the section's abscissa nearest to s [m]."""
        return min(self.abscissas, key=lambda other: abs(other - s))

    def moves(self, s: float) -> bool:
        """Check whether a section moves or turns relative to the link's frame."""
        return s != 0.0 or self.is_chord

    def slopes(self, places: Array) -> Array:
        """Return the slopes at places (ns,) [m] per unit of each shape, (ns, nf)."""
        return self.modes.shapes(places, 1)[1]

    @property
    def bends(self) -> int:
        """Return the number of bending modes, which come first."""
        return self.modes.bending

    @property
    def size(self) -> int:
        """Return the number of its shape coordinates."""
        return len(self.modes.names)

    @property
    def frequencies(self) -> Array:
        """Return the frequency of each mode alone (nf,) [rad/s]."""
        return self.modes.frequencies

    @property
    def coordinates(self) -> list[str]:
        """Return the names of the shape coordinates: of its modes."""
        return [f"{self.name}.{mode}" for mode in self.modes.names]

    def fill(self, shapes: Array) -> None:
        """Fill the lines of the body in `linkages.mechanics.planar.bodies.Bodies.shapes`."""
        modes, nf = self.modes, len(self.modes.names)
        (a0, b0, h0), (a1, b1, h1), rest, twist = modes.moments()
        shapes[SHAPE, :nf] = np.stack([a0, b0, a1, b1], axis=-1)
        shapes[ELASTIC, :nf, STIFFNESS], shapes[ELASTIC, :nf, DAMPING] = modes.k, modes.k * self.damping
        shapes[MATRIX:][:nf, :nf] = np.stack([-h0, rest, -h1, twist], axis=-1)

    def fill_section(self, s: float, shapes: Array) -> None:
        """Fill the lines of a section."""
        nf = len(self.modes.names)
        a, b, slope, h = self.modes.at(s)
        shapes[SHAPE, :nf, :3] = np.stack([a, b, slope], axis=-1)
        shapes[MATRIX:][:nf, :nf, 0] = -h

    def stations(self, nm: int) -> tuple[Records, Records]:
        """Stations (n,) and their modes (n, nm): places on both sides of each section, and between sections."""
        modes, nf = self.modes, len(self.modes.names)
        density, length = self.beam.density * self.beam.area, self.beam.length
        ends = abscissas([*self.abscissas, *self.ends], 0.0, *self.ends)
        places = np.concatenate(
            [np.linspace(a + SAME * length, b - SAME * length, numerics.STATIONS) for a, b in pairwise(ends)]
        )
        stations: Records = np.zeros(len(places), STATION)
        at_modes: Records = np.zeros((len(places), nm), STATION_MODE)
        stations["place"] = places
        x, weight = np.polynomial.legendre.leggauss(numerics.STATION_POINTS)
        for side, end in ((places < 0.0, ends[0]), (places > 0.0, ends[-1])):
            within = places[side]
            if not within.size:
                continue
            edges = np.concatenate([[end], within if end < 0.0 else within[::-1]])  # from the ends to the origin
            half = 0.5 * np.abs(np.diff(edges))[:, None]
            s = (0.5 * (edges[:-1] + edges[1:])[:, None] + half * x).ravel()
            mass = (density * half * weight).ravel()
            a, b = modes.shapes(s)
            each = np.column_stack([np.ones_like(s), s, s * s, a, b, s[:, None] * a, s[:, None] * b]) * mass[:, None]
            sums = np.cumsum(each.reshape(len(within), numerics.STATION_POINTS, -1).sum(axis=1), axis=0)
            sums = sums if end < 0.0 else sums[::-1]
            whole, of_modes = np.split(sums, [3], axis=1)
            for k, name in enumerate(("mass", "first", "second")):
                stations[name][side] = whole[:, k]
            for name, values in zip(("mass_a", "mass_b", "first_a", "first_b"), np.split(of_modes, 4, 1), strict=True):
                at_modes[name][side, :nf] = values
        for name, values in zip("ab", modes.shapes(places), strict=True):
            at_modes[name][:, :nf] = values
        return stations, at_modes


def distinct(places: Iterable[float], length: float) -> list[float]:
    """Sort places along a beam of this length, without places that coincide with others [m]."""
    found: list[float] = []
    for place in sorted(places):
        if not found or place - found[-1] > SAME * length:
            found.append(place)
    return found


def abscissas(places: Sequence[float], origin: float, a: float, b: float) -> tuple[float, ...]:
    """Return the abscissas of distinct places on the beam between a and b, relative to the origin."""
    found = distinct((min(max(place, a), b) - origin for place in places), b - a)
    return tuple(0.0 if abs(place) <= SAME * (b - a) else place for place in found)
