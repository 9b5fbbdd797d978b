"""Substructures of flexible links as records of the kernels."""

from __future__ import annotations

import numpy as np

from linkages.base.arrays import Records
from linkages.mechanics.planar.record_types import BEAM, STATION, STATION_MODE
from linkages.system.tree import Tree


def beam_records(tree: Tree) -> tuple[Records, Records, Records]:
    """Make records of the substructures of flexible links, of their stations, and of the modes at these."""
    nm = tree.bodies.shapes.shape[2]
    records, stations, modes = [], [np.zeros(0, STATION)], [np.zeros((0, nm), STATION_MODE)]
    for link, substructures in tree.flexible.items():
        ends = tree.beam_ends(link)
        for part in substructures:
            beam, (own, of_modes), first = part.beam, part.stations(nm), sum(map(len, stations))
            leverage = 0.5 * beam.height / beam.second_moment
            start = tree.sections[part.name, part.nearest(part.ends[0])]
            whole = tree.index[part.name], first, len(own), beam.area, leverage, part.first
            records.append((*whole, start, *ends))
            stations.append(own)
            modes.append(of_modes)
    return np.array(records, BEAM), np.concatenate(stations), np.concatenate(modes)
