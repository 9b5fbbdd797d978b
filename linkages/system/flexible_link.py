"""A link that bends, in its place in the tree: its pieces, if it is cut, with their frames, modes and sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.arrays import Array, Records
from linkages.files.raw_model import LinkBeam
from linkages.flexible.component_modes import ComponentModes, component_modes
from linkages.model.beam_interfaces import parts, pieces
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Joint, Link, Mechanism
from linkages.planar.bodies import DAMPING, ELASTIC, MATRIX, SHAPE, STIFFNESS
from linkages.planar.record_types import STATION, STATION_MODE

if TYPE_CHECKING:
    from linkages.model.link_tables import LinkModel


_SAME = 1e-9  # abscissas closer than this, in parts of the beam's length, are one
_BETWEEN = 17  # stations from a section to the next
_POINTS = 8  # of Gauss between stations


@dataclass(frozen=True)
class BentLink:
    """A link that bends, or a piece of one.

    Attributes
    ----------
    name : str
        The link's, or its own.
    model : LinkModel
    part : Link
        Its beam and its mass.
    carrier : str
        Piece that carries it; empty if a joint does, or none.
    origin : (2,) array
        Where its frame is drawn: on the beam, at what carries it [m].
    direction : (2,) array
        Of the beam as drawn, from its first end to its last.
    abscissas : tuple of float
        Sections to which joints and frames are fixed, from the origin [m].
    acting : frozenset of float
        Those on which something acts, what carries the piece aside.
    modes : ComponentModes
    damping : (nf,) array
        Damping over stiffness of each mode [s].
    ends : (float, float)
        Abscissas of its ends [m].
    first : float
        Place of the origin from the first end of the link's beam [m].
    is_chord : bool
        Whether the frame's axis goes through another joint; else it is tangent to the beam at the origin.
    """

    name: str
    model: LinkModel
    part: Link
    carrier: str
    origin: Array
    direction: Array
    abscissas: tuple[float, ...]
    acting: frozenset[float]
    modes: ComponentModes
    damping: Array
    ends: tuple[float, float]
    first: float
    is_chord: bool

    @property
    def beam(self) -> LinkBeam:
        """Its beam."""
        assert self.part.beam is not None  # it bends
        return self.part.beam

    def abscissa(self, point: Array) -> float:
        """Abscissa of the section that carries a point drawn at a joint or frame of the link [m]."""
        return self.nearest(float((point - self.origin) @ self.direction))

    def nearest(self, s: float) -> float:
        """Abscissa of the section nearest to one [m]."""
        return min(self.abscissas, key=lambda other: abs(other - s))

    def moves(self, s: float) -> bool:
        """Whether a section moves or turns in the link's frame."""
        return s != 0.0 or self.is_chord

    @property
    def coordinates(self) -> list[str]:
        """Names of its modal coordinates in a tree."""
        return [f"{self.name}.{mode}" for mode in self.modes.names]

    def fill(self, shapes: Array) -> None:
        """Fill a body's lines of `linkages.planar.bodies.Bodies.shapes`."""
        modes, nf = self.modes, len(self.modes.names)
        (a0, b0, h0), (a1, b1, h1), rest, twist = modes.moments()
        shapes[SHAPE, :nf] = np.stack([a0, b0, a1, b1], axis=-1)
        shapes[ELASTIC, :nf, STIFFNESS], shapes[ELASTIC, :nf, DAMPING] = modes.k, modes.k * self.damping
        shapes[MATRIX:][:nf, :nf] = np.stack([-h0, rest, -h1, twist], axis=-1)

    def fill_section(self, s: float, shapes: Array) -> None:
        """Fill a section's."""
        nf = len(self.modes.names)
        a, b, slope, h = self.modes.at(s)
        shapes[SHAPE, :nf, :3] = np.stack([a, b, slope], axis=-1)
        shapes[MATRIX:][:nf, :nf, 0] = -h

    def stations(self, nm: int) -> tuple[Records, Records]:
        """Stations (n,) and their modes (n, nm): places on both sides of each section, and between sections."""
        modes, nf = self.modes, len(self.modes.names)
        density, length = self.beam.density * self.beam.area, self.beam.length
        ends = sorted({*self.abscissas, *self.ends})
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
            edges = np.concatenate([[end], within if end < 0.0 else within[::-1]])  # from outside inwards
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


def bent_link(mechanism: Mechanism, experiment: Experiment, name: str, carrier: Joint | None) -> tuple[BentLink, ...]:
    """Return the pieces of a link that bends, carried by a joint (None: it floats), each behind what carries it.

    The frame's axis goes through the farthest joint of the link if what carries it lets it turn freely: slopes are
    then half as large as with a tangent axis, and so is the error of the model, which goes with their square. A drive
    acts on the section at its joint, and so needs the tangent there. Of a link that is cut the joint carries the piece
    that it lies on, whose axis may go through its end; the others are fixed to the ends of their neighbours.
    """
    link, model = mechanism.link[name], experiment.links[name]
    whole = link.beam
    if whole is None:
        raise AssertionError("a link that bends has a beam")  # `linkages.model.check` saw to it
    length = float(np.linalg.norm(whole.end - whole.start))
    direction = (whole.end - whole.start) / length

    def along(point: Array) -> float:
        return float((point - whole.start) @ direction)

    named, cells = _named(experiment), pieces(mechanism, experiment, name)
    points = {point.name: along(point.origin) for point in mechanism.point.values() if point.link == name}
    joints = {
        joint.name: along(place)
        for joint in mechanism.joints
        for end, place in ((joint.parent, joint.on_parent), (joint.child, joint.on_child))
        if end == name
    }
    carried = joints[carrier.name] if carrier else min(joints.values())
    free = carrier is None or (carrier.type == "revolute" and carrier.name not in experiment.drives)

    def piece_at(s: float) -> int:
        return int(np.searchsorted([cell.end for cell in cells[:-1]], s))

    edges = [0.0, *(cell.end for cell in cells)]
    rods = parts(mechanism, link, [cell.name for cell in cells], edges) if len(cells) > 1 else [link]
    root, found = piece_at(carried), []
    for k in (*range(root, len(cells)), *reversed(range(root))):
        _, a, b, held = cells[k]
        inner = k - 1 if k > root else k + 1
        origin = carried if k == root else (a if k > root else b)
        cuts = [s for s in (a, b) if 0.0 < s < length]
        own, frames = ({one: s for one, s in of.items() if piece_at(s) == k} for of in (joints, points))
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
            BentLink(
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


def section_at(link: Sequence[BentLink], point: Array) -> tuple[str, float]:
    """Name of the piece of a link and abscissa of its section that carry a point drawn at a joint or frame of it."""

    def beyond(piece: BentLink) -> float:
        s = float((point - piece.origin) @ piece.direction)
        return max(piece.ends[0] - s, s - piece.ends[1])

    piece = min(link, key=beyond)
    return piece.name, piece.abscissa(point)


def _named(experiment: Experiment) -> set[str]:
    """Names that stand in the tables of what acts on links and in joints, before a dot or alone."""
    found: set[str] = set()
    rest: list[Any] = [name for _, name in experiment.named]
    rest += [getattr(experiment, table)[name].model_dump() for table, name in experiment.named]
    rest += [load.signals for load in (*experiment.forces.values(), *experiment.torques.values())]
    for value in rest:  # which becomes longer meanwhile
        if isinstance(value, str):
            found |= {value, value.rpartition(".")[0]}
        elif isinstance(value, dict | list | tuple):
            rest += value.values() if isinstance(value, dict) else value
    return found


def _distinct(places: Sequence[float], origin: float, a: float, b: float) -> tuple[float, ...]:
    """Abscissas from the origin of distinct places within the piece of the beam from a to b."""
    found: list[float] = []
    for place in sorted(min(max(place, a), b) - origin for place in places):
        if not found or place - found[-1] > _SAME * (b - a):
            found.append(0.0 if abs(place) <= _SAME * (b - a) else place)
    return tuple(found)
