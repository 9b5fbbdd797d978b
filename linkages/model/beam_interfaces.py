"""Interfaces of flexible links: places of joints and loads, substructures, and the check of the links' settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from linkages.errors import InputError, nearest
from linkages.files.beams import of_beam
from linkages.model.experiment import Experiment
from linkages.model.mechanism import Link, Mechanism

_ON_AXIS = 1e-6  # relative to a beam's length: largest distance of a joint from it
_SAME = 1e-9  # relative to a beam's length: closer places coincide


def interfaces(mechanism: Mechanism, experiment: Experiment, name: str) -> tuple[float, ...]:
    """Find the interfaces of a link with a beam: joints, forces, ends of springs, points and frames at lines.

    Returns
    -------
    tuple of float
        Distinct distances from the beam's start in increasing order [m].

    Raises
    ------
    InputError
        If a joint does not lie on the beam.
    """
    link = mechanism.link[name]
    assert link.beam is not None
    start, length = link.beam.start, link.beam.length
    along = (link.beam.end - start) / length
    found = []
    for joint in mechanism.joints:
        for body, place in ((joint.parent, joint.on_parent), (joint.child, joint.on_child)):
            if body == name:
                found.append(float((place - start) @ along))
                off = float(np.linalg.norm(place - start - min(max(found[-1], 0.0), length) * along))
                if off > _ON_AXIS * length:
                    ends = " to ".join(f'"{frame}"' for frame in link.beam.frames)
                    problem = f'is flexible, but its joint "{joint.name}" lies {off:g} m off its beam from {ends}'
                    fix = "put it on the beam, or on another link that is fixed to this one"
                    raise InputError(experiment.source, f"links.{name}", f"{problem}; {fix}")
    loaded: set[str | None] = {load.point for load in experiment.forces.values()}
    loaded |= {name for touch in experiment.contacts.values() for name in (touch.point, touch.line)}
    loaded |= {end for spring in experiment.springs.values() for end in (spring.point, spring.to)}
    points = [point for point in mechanism.point.values() if point.link == name and point.name in loaded]
    found += [float((point.origin - start) @ along) for point in points]
    places = np.sort(np.clip(found, 0.0, length))
    apart = np.diff(places, prepend=-length) > _SAME * length
    return tuple(places[apart].tolist())


class Substructure(NamedTuple):
    """A substructure of a flexible link: name, start, end and interfaces [m]."""

    name: str
    start: float
    end: float
    held: tuple[float, ...]


def substructures(mechanism: Mechanism, experiment: Experiment, name: str) -> list[Substructure]:
    """Divide a link with a beam into substructures, from its start; if divided, cuts are interfaces too."""
    beam, count = mechanism.link[name].beam, experiment.links[name].pieces
    assert beam is not None
    near, edges = _SAME * beam.length, np.linspace(0.0, beam.length, count + 1).tolist()
    held = np.sort([*interfaces(mechanism, experiment, name), *(edges if count > 1 else [])])
    held = held[np.diff(held, prepend=-beam.length) > near]
    names = [f"{name}/one{k + 1}" for k in range(count)] if count > 1 else [name]
    return [
        Substructure(own, a, b, tuple(held[(held > a - near) & (held < b + near)].tolist()))
        for own, (a, b) in zip(names, pairwise(edges), strict=True)
    ]


def parts(mechanism: Mechanism, link: Link, names: Sequence[str], edges: Sequence[float]) -> list[Link]:
    """Make a link without visuals from each part of a link's beam between `edges`, from its start [m]."""
    beam = link.beam
    assert beam is not None
    along = mechanism.basis[:, :2] @ (beam.end - beam.start)
    middle = link.translation + link.rotation @ link.com_local
    drawn = replace(beam, start=middle - 0.5 * along, end=middle + 0.5 * along)
    found = []
    for name, (a, b) in zip(names, pairwise(edges), strict=True):
        part = beam.part(a, b)
        rod = replace(link, name=name, com=0.5 * (part.start + part.end), inertia=part.inertia, visuals=())
        found.append(replace(of_beam(rod, drawn.part(a, b)), beam=part))
    return found


def check_links(mechanism: Mechanism, experiment: Experiment) -> None:
    """Reject tables of links that the mechanism lacks, or settings that do not suit the link."""
    for name, model in experiment.links.items():
        where = f"links.{name}"
        if name not in mechanism.link:
            problem = f"{mechanism.source.name} has no such link; {nearest(name, mechanism.link)}"
            raise InputError(experiment.source, where, problem)
        if not model.bends:
            continue
        if mechanism.link[name].beam is None:
            place = f'<link name="{name}"> of {mechanism.source.name}'
            raise InputError(experiment.source, f"{where}.model", f'"flexible" needs a <linkages:beam> in {place}')
        others = max(len(one.held) for one in substructures(mechanism, experiment, name)) - 1
        what = "joints and loads" if model.pieces == 1 else "joints, loads and ends of a substructure"
        for key, least in (("bending", 2 * others), ("axial", others)):
            count = getattr(model, key)
            if count and count < least:
                problem = f"is {count}; its {others + 1} {what} need {least} modes or more, or 0"
                raise InputError(experiment.source, f"{where}.{key}", problem)
