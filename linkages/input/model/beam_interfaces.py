"""Interfaces of flexible links, the places of joints and loads, and substructures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from linkages.base.errors import InputError
from linkages.elements.flexible.substructure import SAME, distinct
from linkages.elements.machine import all_elements_of
from linkages.input.files.beams import of_beam
from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Link, Mechanism

_ON_AXIS = 1e-6  # relative to a beam's length: largest distance of a joint from it


def interfaces(mechanism: Mechanism, experiment: Experiment, name: str) -> list[float]:
    """Find the interfaces of a link with a beam: joints, forces, ends of springs, points and frames at lines.

    They are distinct distances from the beam's start in increasing order [m]. InputError if a joint is not on the beam.
    """
    beam = mechanism.beam[name]
    found = []
    for joint in mechanism.joints:
        for body, place in ((joint.parent, joint.on_parent), (joint.child, joint.on_child)):
            if body == name:
                found.append(min(max(beam.along(place), 0.0), beam.length))
                nearest_place = beam.start + found[-1] / beam.length * (beam.end - beam.start)
                off = float(np.linalg.norm(place - nearest_place))
                if off > _ON_AXIS * beam.length:
                    ends = " to ".join(f'"{frame}"' for frame in beam.frames)
                    problem = f'is flexible, but its joint "{joint.name}" lies {off:g} m off its beam from {ends}'
                    fix = "put it on the beam, or on another link that is fixed to this one"
                    raise InputError(experiment.source, f"links.{name}", f"{problem}; {fix}")
    parts = all_elements_of(experiment.elements)
    loaded = {point for kind, _, keys in parts for point in kind.points(keys) if isinstance(point, str)}
    points = [point for point in mechanism.point.values() if point.link == name and point.name in loaded]
    return distinct([*found, *(min(max(beam.along(point.origin), 0.0), beam.length) for point in points)], beam.length)


class Cell(NamedTuple):
    """A substructure of a flexible link: name, start, end and interfaces [m]."""

    name: str
    start: float
    end: float
    held: tuple[float, ...]


def substructures(mechanism: Mechanism, experiment: Experiment, name: str) -> list[Cell]:
    """Divide a link with a beam into substructures, from its start; if divided, cuts are interfaces too."""
    length, count = mechanism.beam[name].length, experiment.deforming[name].pieces
    near, edges = SAME * length, np.linspace(0.0, length, count + 1).tolist()
    held = distinct([*interfaces(mechanism, experiment, name), *(edges if count > 1 else [])], length)
    names = [f"{name}/one{k + 1}" for k in range(count)] if count > 1 else [name]
    return [
        Cell(own, a, b, tuple(s for s in held if a - near < s < b + near))
        for own, (a, b) in zip(names, pairwise(edges), strict=True)
    ]


def parts(mechanism: Mechanism, link: Link, names: Sequence[str], edges: Sequence[float]) -> list[Link]:
    """Make a link without visuals from each part of a link's beam between `edges`, from its start [m]."""
    beam = mechanism.beam[link.name]
    along = mechanism.basis[:, :2] @ (beam.end - beam.start)
    middle = link.translation + link.rotation @ link.com_local
    drawn = replace(beam, start=middle - 0.5 * along, end=middle + 0.5 * along)
    found = []
    for name, (a, b) in zip(names, pairwise(edges), strict=True):
        part = beam.part(a, b)
        rod = replace(link, name=name, com=0.5 * (part.start + part.end), inertia=part.inertia, visuals=())
        found.append(replace(of_beam(rod, drawn.part(a, b)), beam=part))
    return found
