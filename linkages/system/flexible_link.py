"""A flexible link in the spanning tree: its substructures, with their frames, modes and sections, and their records."""

from __future__ import annotations

from typing import Any

import numpy as np

from linkages.base.arrays import Records
from linkages.elements.flexible.internal_forces import BEAM, STATION, STATION_MODE
from linkages.elements.flexible.substructure import Substructure, abscissas
from linkages.input.functions.definitions import names_in
from linkages.input.model.beam_interfaces import parts, substructures
from linkages.input.model.experiment import Experiment
from linkages.input.model.mechanism import Joint, Mechanism
from linkages.mechanics.flexible.component_modes import component_modes
from linkages.system.tree import Tree


def flexible_link(
    mechanism: Mechanism, experiment: Experiment, name: str, carrier: Joint | None
) -> tuple[Substructure, ...]:
    """Divide a flexible link into substructures, each listed after its carrier; `carrier` None: the link floats.

    The frame's axis passes through the farthest joint of the link if the carrying joint leaves the rotation free.
    Slopes are then half as large as with a tangent axis, and the model's error, which grows with the squared slope, is
    a quarter. A drive acts on the section at its joint and therefore needs the tangent. In a divided link the joint
    carries the substructure on which it lies, whose axis may pass through its end; the others are fixed to their
    neighbours' ends.
    """
    link, model, whole = mechanism.link[name], experiment.deforming[name], mechanism.beam[name]
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
        sections = abscissas([*own.values(), *frames.values(), *cuts], origin, a, b)
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
            Substructure(
                name=cells[k].name,
                rod=rods[k],
                carrier="" if k == root else cells[inner].name,
                origin=whole.start + origin * direction,
                direction=direction,
                abscissas=sections,
                acting=frozenset(min(sections, key=lambda place: abs(place + origin - s)) for s in used),
                modes=modes,
                damping=model.damping_factors(modes, whole.elastic()),
                ends=(a - origin, b - origin),
                first=origin,
                settles=model.start == "quasi-static",
                is_chord=bool(chord),
            )
        )
    return tuple(found)


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


def beam_records(tree: Tree) -> tuple[Records, Records, Records]:
    """Make records of the substructures of flexible links, of their stations, and of the modes at these."""
    nm = tree.bodies.shapes.shape[2]
    records, stations, modes = [], [np.zeros(0, STATION)], [np.zeros((0, nm), STATION_MODE)]
    for link, bodies in tree.deformable.items():
        ends = tree.ends_of(link)
        for part in (body for body in bodies if isinstance(body, Substructure)):
            beam, (own, of_modes), first = part.beam, part.stations(nm), sum(map(len, stations))
            leverage = 0.5 * beam.height / beam.second_moment
            start = tree.sections[part.name, part.nearest(part.ends[0])]
            whole = tree.index[part.name], first, len(own), beam.area, leverage, part.first
            records.append((*whole, start, *ends))
            stations.append(own)
            modes.append(of_modes)
    return np.array(records, BEAM), np.concatenate(stations), np.concatenate(modes)
