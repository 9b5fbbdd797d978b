"""Flexible links as chains of rigid segments: the same linkage with springs in its joints (rigid finite elements).

Between neighbouring interfaces (`linkages.input.model.beam_interfaces.interfaces`) a beam is cut into equal cells of
length h. A segment is a thin rod that reaches from the middle of one cell to the middle of the next one, so that its
own middle is a node, to which joints attach. The hinges between segments have the stiffness EI/h and the damping of the
beam. Section angles and places on the beam are accurate to second order in h, at clamped and at pinned ends. Segments
are inextensible and shorten by bending as the beam does: geometric stiffening is exact.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from linkages.base.arrays import Array
from linkages.input.files.raw_model import LinkBeam
from linkages.input.model.beam_interfaces import distinct, interfaces, parts
from linkages.input.model.experiment import Experiment, experiment_of
from linkages.input.model.link_tables import LinkModel
from linkages.input.model.mechanism import Frame, Joint, Link, Mechanism
from linkages.input.model.output_names import BENDING_QUANTITIES

#: Separator of link name and hinge number in the name of a hinge.
HINGE = "/hinge"


@dataclass(frozen=True, eq=False)
class SegmentChain:
    """The chain of rigid segments of a flexible link; its interfaces and its beam's ends, from the beam's start [m]."""

    link: Link
    beam: LinkBeam
    model: LinkModel
    ends: list[float]

    @cached_property
    def _counts(self) -> list[int]:
        """Return the number of cells between neighbouring ends."""
        part = np.diff(self.ends) / self.beam.length
        return np.maximum(np.rint(self.model.segments * part), 1).astype(int).tolist()

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

    @cached_property
    def damping(self) -> float:
        """Return the damping over stiffness [s]."""
        return self.model.bending_damping(self.beam.elastic().pinned_frequency)

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


def chains(mechanism: Mechanism, experiment: Experiment) -> dict[str, SegmentChain]:
    """Make the segment chains of all flexible links, by name."""
    found = {}
    for name in experiment.flexible:
        beam = mechanism.beam[name]
        ends = distinct([0.0, *interfaces(mechanism, experiment, name), beam.length], beam.length)
        found[name] = SegmentChain(mechanism.link[name], beam, experiment.links[name], ends)
    return found


def segmented(mechanism: Mechanism, experiment: Experiment) -> tuple[Mechanism, Experiment]:
    """Return a mechanism with chains of rigid segments instead of flexible links, and its experiment.

    Frames, joints and loads keep their names; the name of a link becomes a frame on one of its segments.
    """
    cut = chains(mechanism, experiment)
    links: list[Link] = []
    for link in mechanism.links:
        if link.name in cut:
            chain = cut[link.name]
            segments = parts(mechanism, link, chain.segments, [0.0, *chain.hinges, chain.beam.length])
            links += [replace(segment, beam=None) for segment in segments]
        else:
            links.append(link)
    hinges = [hinge for chain in cut.values() for hinge in _hinges(chain, mechanism)]
    frames = [*mechanism.frames, *(mechanism.point[name] for name in cut)]
    machine = replace(
        mechanism,
        links=tuple(links),
        joints=(*hinges, *(_carried(joint, cut) for joint in mechanism.joints)),  # hinges are never cut
        frames=tuple(replace(f, link=cut[f.link].carrier(f.origin)) if f.link in cut else f for f in frames),
    )
    return machine, _experiment_of(machine, experiment, cut)


def _hinges(chain: SegmentChain, mechanism: Mechanism) -> Iterator[Joint]:
    beam, basis = chain.beam, mechanism.basis
    depth = basis[:, 2] * (basis[:, 2] @ chain.link.translation)
    for name, s, parent, child in zip(chain.joints, chain.hinges, chain.segments[:-1], chain.segments[1:], strict=True):
        at = beam.start + s / beam.length * (beam.end - beam.start)
        place = basis[:, :2] @ at + depth
        normal, none = basis[:, 2], np.zeros(2)
        yield Joint(name, "revolute", parent, child, normal, place, place, None, None, at, at, 1.0, none)


def _carried(joint: Joint, cut: dict[str, SegmentChain]) -> Joint:
    on_parent = joint.on_child if joint.type == "fixed" else joint.on_parent
    parent = cut[joint.parent].carrier(on_parent) if joint.parent in cut else joint.parent
    child = cut[joint.child].carrier(joint.on_child) if joint.child in cut else joint.child
    return replace(joint, parent=parent, child=child)


def _experiment_of(machine: Mechanism, experiment: Experiment, cut: dict[str, SegmentChain]) -> Experiment:
    own: dict[str, Frame] = {frame.name: frame for frame in machine.frames}

    def carrier(link: str) -> str:
        return own[link].link if link in cut else link

    data: dict[str, Any] = experiment.model_dump(exclude_unset=True)
    data["links"] = {}
    data["outputs"] = [name for name in experiment.outputs if name.rpartition(".")[2] not in BENDING_QUANTITIES]
    for torque in data.get("torques", {}).values():
        if torque.get("link") is not None:
            torque["link"] = carrier(torque["link"])
    springs = data.setdefault("torsion_springs", {})
    for spring in springs.values():
        if spring.get("links") is not None:
            spring["links"] = [carrier(link) for link in spring["links"]]
    for chain in cut.values():
        for name, joint, stiffness in zip(chain.springs, chain.joints, chain.stiffnesses.tolist(), strict=True):
            values = {"stiffness": stiffness, "damping": chain.damping * stiffness, "free_angle": 0.0}
            springs[name] = {"joint": joint, **values}
    return experiment_of(experiment.source, data, experiment.sources)
