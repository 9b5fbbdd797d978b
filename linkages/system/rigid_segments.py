"""Chains of rigid segments instead of flexible links, and hinge angles for given modal coordinates."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.base.errors import AssemblyError, Status
from linkages.elements.flexible.segment_chain import SegmentChain
from linkages.input.model.segment_model import chains
from linkages.input.model.segment_model import segmented as cut
from linkages.mechanics.planar.closure import close, consistent_rates
from linkages.system.assembly import Assembly
from linkages.system.system import System
from linkages.system.tree import Tree, without

_SAME = 1e-9  # relative to a segment's length: closer places coincide


@dataclass(frozen=True, eq=False)
class Segmented(System):
    """A rigid linkage with sprung hinges, equivalent to a linkage with flexible links; made by `segmented`."""

    whole: System = field(kw_only=True)  # the equivalent linkage with flexible links
    chains: Mapping[str, SegmentChain] = field(kw_only=True)  # segments of each flexible link

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the linkage with flexible links."""
        return segmented, (self.whole,)

    @cached_property
    def tree(self) -> Tree:
        """Return the spanning tree; loop closure keeps its hinge angles fixed, like modal coordinates."""
        names = frozenset(name for chain in self.chains.values() for name in chain.joints)
        hinges = tuple(name for name in super().tree.coordinates if name in names)
        return replace(super().tree, hinges=hinges)

    @property
    def stiff(self) -> bool:
        """Return True: hinges are stiff."""
        return True

    @cached_property
    def assembly(self) -> Assembly:
        """Assemble at the start of the flexible linkage: hinges follow its sections, joints close the loops."""
        start, tree, whole = self.whole.assembly, self.tree, self.whole.tree
        closure, offset = tree.closure_rows, whole.gaps(start.q)
        q, v = self.coordinates(start.q), self.coordinates(start.v)
        free = without(tree.closing_dofs, tree.powered_dofs)
        if not close(tree.bodies, closure, offset, free, tree.extent, q):
            raise AssemblyError(Status.NO_ASSEMBLY, "the loops do not close with links divided into rigid segments")
        consistent_rates(tree.bodies, closure, free, q, v, np.zeros(tree.size))
        return Assembly(q, v, start.mobility, start.quality)

    def coordinates(self, q: Array) -> Array:
        """Compute coordinates (..., n) of this tree from those (..., m) of the flexible linkage; rates from rates.

        Hinges follow the section rotations at the segments' nodes; small gaps of the loops remain.
        """
        whole, tree = self.whole.tree, self.tree
        result = np.zeros((*q.shape[:-1], tree.size))
        place = {name: k for k, name in enumerate(tree.coordinates)}
        for k, name in enumerate(whole.coordinates):
            link, _, part = name.rpartition(".")
            name = f"{self.chains[link].segments[0]}.{part}" if link in self.chains else name
            if name in place:
                result[..., place[name]] = q[..., k]
        for link, chain in self.chains.items():
            turns = _section_turns(whole, link, chain.nodes, q)
            for k, name in enumerate(chain.joints):
                result[..., place[name]] = turns[..., k + 1] - turns[..., k]
            carried, at = whole.edges.get(link), chain.segments[0]
            if carried is not None:
                at = next(link for link, edge in tree.edges.items() if edge.joint == carried.joint)
            turn = turns[..., chain.segments.index(at)]
            name = f"{at}.angle" if carried is None else carried.joint
            if whole.deformable[link][0].is_chord and name in place:
                result[..., place[name]] += float(whole.bodies.records[whole.index[link]]["sign"]) * turn
        return result

    def largest_deflection(self, q: Array) -> float:
        """Compute the largest distance [m] of a hinge from its beam's chord, at coordinates (nt, n)."""
        found = 0.0
        for chain in self.chains.values():
            turns = q[:, [self.tree.coordinates.index(name) for name in chain.joints]].cumsum(axis=1)
            edges = np.array([*chain.hinges, chain.length])
            across = np.hstack([np.zeros((len(q), 1)), (turns * np.diff(edges)).cumsum(axis=1)])
            part = (edges - chain.hinges[0]) / np.ptp(edges)
            found = max(found, float(np.abs(across - np.outer(across[:, -1], part)).max()))
        return found


def _section_turns(tree: Tree, link: str, places: Array, q: Array) -> Array:
    """Compute rotations (..., ns) of a flexible link's sections relative to the frame at its carrying joint [rad].

    Places (ns,) are distances from the beam's first end [m]; rates instead of coordinates q (..., n) give rates.
    """
    found = np.zeros((*q.shape[:-1], len(places)))
    ends: dict[tuple[str, float], Array] = {}
    for piece in tree.deformable[link]:
        s, near = places - piece.first, _SAME * (piece.ends[1] - piece.ends[0])
        eta = int(tree.bodies.records[tree.index[piece.name]]["eta"]) + np.arange(piece.size)
        frame = ends[piece.carrier, piece.first] if piece.carrier else 0.0
        cuts = [other.first for other in tree.deformable[link] if other.carrier == piece.name]
        own = np.flatnonzero((s > piece.ends[0] - near) & (s < piece.ends[1] + near))
        slopes = piece.slopes(np.concatenate([s[own], np.array(cuts) - piece.first]))
        turns = q[..., eta] @ slopes.T + frame
        found[..., own] = turns[..., : len(own)]
        ends |= {(piece.name, cut): turns[..., len(own) + k, None] for k, cut in enumerate(cuts)}
    return found


def segmented(system: System) -> System:
    """Return the same linkage with chains of rigid segments instead of flexible links; the system if it has none."""
    found = chains(system.mechanism, system.experiment)
    if not found:
        return system
    return Segmented(*cut(system.mechanism, system.experiment), whole=system, chains=found)


def system_of(system: System, columns: Collection[str]) -> System:
    """Return the system whose coordinates are among a run's columns: with rigid segments if the run used them."""
    return segmented(system) if has_segments(system, columns) else system


def has_segments(system: System, columns: Collection[str]) -> bool:
    """Check by its columns whether a run used rigid segments instead of flexible links."""
    links = system.tree.substructures.values()
    return any(f"q.{name}" not in columns for link in links for name in link.coordinates)
