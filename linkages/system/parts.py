"""The named elements of a system, by table and name: links, drives, loads, springs, gears, stops, contacts, states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from linkages.input.model.experiment import DEFINING, LOADS, OTHERS, Experiment

#: Keys of the elements, by table and name.
NamedElements = Mapping[str, dict[str, Any]]


def parts_of(experiment: Experiment) -> NamedElements:
    """Return the named elements of an experiment, by table.

    Besides the tables of the file there are ``meshes``, the gears and couplings, of which ``closed`` have no backlash
    and ``slack`` have one, gearboxes of drives included (as ``JOINT.backlash``); and ``gearboxes``, by driven joint.
    """
    tables = {
        table: getattr(experiment, table) for table in dict.fromkeys(("links", "drives", *LOADS, *OTHERS, *DEFINING))
    }
    made = {table: getattr(experiment, table) for table in ("meshes", "closed", "slack", "gearboxes")}
    return tables | experiment.elements | made
