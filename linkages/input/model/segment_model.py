"""Flexible links as chains of rigid segments: the same linkage with springs in its joints (rigid finite elements).

`linkages.elements.flexible.segment_chain` explains the chains.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from linkages.elements.flexible.segment_chain import SegmentChain
from linkages.elements.flexible.substructure import distinct
from linkages.input.model.beam_interfaces import interfaces, parts
from linkages.input.model.experiment import Experiment, experiment_of
from linkages.input.model.mechanism import Frame, Joint, Link, Mechanism
from linkages.input.model.output_names import SHAPE_QUANTITIES


def chains(mechanism: Mechanism, experiment: Experiment) -> dict[str, SegmentChain]:
    """Make the segment chains of all flexible links, by name."""
    found = {}
    for name, model in experiment.deforming.items():
        beam = mechanism.beam[name]
        damping = model.bending_damping(beam.elastic().pinned_frequency)
        ends = distinct([0.0, *interfaces(mechanism, experiment, name), beam.length], beam.length)
        found[name] = SegmentChain(mechanism.link[name], beam, model.segments, damping, ends)
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
    data["outputs"] = [name for name in experiment.outputs if name.rpartition(".")[2] not in SHAPE_QUANTITIES]
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
