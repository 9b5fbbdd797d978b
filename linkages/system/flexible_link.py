"""A flexible link in the spanning tree: its substructures, if it is divided, with their frames, modes and sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.base.arrays import Array, Records
from linkages.input.files.raw_model import LinkBeam
from linkages.input.functions.definitions import names_in
from linkages.input.model.beam_interfaces import distinct, parts, substructures
from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Joint, Link, Mechanism
from linkages.mechanics.flexible.component_modes import ComponentModes, component_modes
from linkages.mechanics.planar.bodies import DAMPING, ELASTIC, MATRIX, SHAPE, STIFFNESS
from linkages.mechanics.planar.record_types import STATION, STATION_MODE

if TYPE_CHECKING:
    from linkages.input.model.link_tables import LinkModel


_SAME = 1e-9  # abscissas closer than this, relative to the beam's length, coincide
_BETWEEN = 17  # number of stations between neighbouring sections
_POINTS = 8  # number of Gauss points between stations


@dataclass(frozen=True)
class FlexibleLink:
    """A flexible link, or one of its substructures."""

    name: str
    model: LinkModel  # settings of the link
    part: Link  # beam and mass of the substructure
    carrier: str  # the one that carries this one; empty if a joint carries it, or if it floats
    origin: Array  # of the frame in the reference configuration: on the beam, at the carrier, (2,) [m]
    direction: Array  # unit vector along the beam in the reference configuration, from its first to its last end
    abscissas: tuple[float, ...]  # sections to which joints and frames are fixed, from the origin [m]
    acting: frozenset[float]  # sections on which joints or loads act, without the carrier's [m]
    modes: ComponentModes
    damping: Array  # over stiffness of each mode, (nf,) [s]
    ends: tuple[float, float]  # abscissas of the substructure's ends [m]
    first: float  # distance of the origin from the first end of the link's beam [m]
    is_chord: bool  # whether its axis passes through another joint; else it is tangent to the beam at the origin

    @property
    def beam(self) -> LinkBeam:
        """Return the beam of the substructure."""
        assert self.part.beam is not None  # only links with a beam are flexible
        return self.part.beam

    def abscissa(self, point: Array) -> float:
        """Return the abscissa of the section that carries a joint or frame at a reference point [m]."""
        return self.nearest(float((point - self.origin) @ self.direction))

    def nearest(self, s: float) -> float:
        """Return the section's abscissa nearest to s [m]."""
        return min(self.abscissas, key=lambda other: abs(other - s))

    def moves(self, s: float) -> bool:
        """Check whether a section moves or turns relative to the link's frame."""
        return s != 0.0 or self.is_chord

    @property
    def coordinates(self) -> list[str]:
        """Return the names of the modal coordinates."""
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
        ends = _distinct([*self.abscissas, *self.ends], 0.0, *self.ends)
        places = np.concatenate(
            [np.linspace(a + _SAME * length, b - _SAME * length, _BETWEEN) for a, b in pairwise(ends)]
        )
        stations: Records = np.zeros(len(places), STATION)
        at_modes: Records = np.zeros((len(places), nm), STATION_MODE)
        stations["place"] = places
        x, weight = np.polynomial.legendre.leggauss(_POINTS)
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
            sums = np.cumsum(each.reshape(len(within), _POINTS, -1).sum(axis=1), axis=0)
            sums = sums if end < 0.0 else sums[::-1]
            whole, of_modes = np.split(sums, [3], axis=1)
            for k, name in enumerate(("mass", "first", "second")):
                stations[name][side] = whole[:, k]
            for name, values in zip(("mass_a", "mass_b", "first_a", "first_b"), np.split(of_modes, 4, 1), strict=True):
                at_modes[name][side, :nf] = values
        for name, values in zip("ab", modes.shapes(places), strict=True):
            at_modes[name][:, :nf] = values
        return stations, at_modes


def flexible_link(
    mechanism: Mechanism, experiment: Experiment, name: str, carrier: Joint | None
) -> tuple[FlexibleLink, ...]:
    """Divide a flexible link into substructures, each listed after its carrier; `carrier` None: the link floats.

    The frame's axis passes through the farthest joint of the link if the carrying joint leaves the rotation free.
    Slopes are then half as large as with a tangent axis, and the model's error, which grows with the squared slope, is
    a quarter. A drive acts on the section at its joint and therefore needs the tangent. In a divided link the joint
    carries the substructure on which it lies, whose axis may pass through its end; the others are fixed to their
    neighbours' ends.
    """
    link, model, whole = mechanism.link[name], experiment.links[name], mechanism.beam[name]
    length = whole.length
    direction = (whole.end - whole.start) / length
    named, cells = _named(experiment), substructures(mechanism, experiment, name)
    points = {point.name: whole.along(point.origin) for point in mechanism.point.values() if point.link == name}
    joints = {
        joint.name: whole.along(place)
        for joint in mechanism.joints
        for end, place in ((joint.parent, joint.on_parent), (joint.child, joint.on_child))
        if end == name
    }
    carried = joints[carrier.name] if carrier else min(joints.values())
    free = carrier is None or (carrier.type == "revolute" and carrier.name not in experiment.drives)

    def index_at(s: float) -> int:
        return int(np.searchsorted([cell.end for cell in cells[:-1]], s))

    edges = [0.0, *(cell.end for cell in cells)]
    rods = parts(mechanism, link, [cell.name for cell in cells], edges) if len(cells) > 1 else [link]
    root, found = index_at(carried), []
    for k in (*range(root, len(cells)), *reversed(range(root))):
        _, a, b, held = cells[k]
        inner = k - 1 if k > root else k + 1
        origin = carried if k == root else (a if k > root else b)
        cuts = [s for s in (a, b) if 0.0 < s < length]
        own, frames = ({one: s for one, s in of.items() if index_at(s) == k} for of in (joints, points))
        sections = _distinct([*own.values(), *frames.values(), *cuts], origin, a, b)
        used = [s for joint, s in own.items() if carrier is None or joint != carrier.name or joint in named]
        used += [s for point, s in frames.items() if point in named] + cuts
        chord = max((s - origin for s in (*own.values(), *cuts)), key=abs) if free and k == root else 0.0
        modes = component_modes(
            (rods[k].beam or whole).elastic(),
            a - origin,
            b - origin,
            [s - origin for s in held],
            chord or None,
            2 * (len(held) - 1) if model.bending is None and len(cells) > 1 else model.bending,
            model.axial,
            model.stiffening,
        )
        found.append(
            FlexibleLink(
                name=cells[k].name,
                model=model,
                part=rods[k],
                carrier="" if k == root else cells[inner].name,
                origin=whole.start + origin * direction,
                direction=direction,
                abscissas=sections,
                acting=frozenset(min(sections, key=lambda place: abs(place + origin - s)) for s in used),
                modes=modes,
                damping=model.damping_factors(modes, whole.elastic()),
                ends=(a - origin, b - origin),
                first=origin,
                is_chord=bool(chord),
            )
        )
    return tuple(found)


def section_at(link: Sequence[FlexibleLink], point: Array) -> tuple[str, float]:
    """Return the substructure's name and section's abscissa that carry a joint or frame at a reference point."""

    def beyond(part: FlexibleLink) -> float:
        s = float((point - part.origin) @ part.direction)
        return max(part.ends[0] - s, s - part.ends[1])

    part = min(link, key=beyond)
    return part.name, part.abscissa(point)


def _named(experiment: Experiment) -> set[str]:
    """Collect the names of joints, links and frames that the experiment's tables mention."""
    found: set[str] = set()
    rest: list[Any] = [name for _, name in experiment.named]
    rest += [getattr(experiment, table)[name].model_dump() for table, name in experiment.named]
    rest += experiment.functions_read
    rest += [name for one in experiment.quantities.values() for name in names_in(one.definition)]
    for value in rest:  # grows during the iteration
        if isinstance(value, str):
            found |= {value, value.rpartition(".")[0]}
        elif isinstance(value, dict | list | tuple):
            rest += value.values() if isinstance(value, dict) else value
    return found


def _distinct(places: Sequence[float], origin: float, a: float, b: float) -> tuple[float, ...]:
    """Return the abscissas of distinct places on the beam between a and b, relative to the origin."""
    found = distinct((min(max(place, a), b) - origin for place in places), b - a)
    return tuple(0.0 if abs(place) <= _SAME * (b - a) else place for place in found)
