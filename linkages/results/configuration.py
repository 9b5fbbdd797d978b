"""The configuration of a linkage as comparable numbers, for two times of a run or for two runs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from linkages.arrays import Array
from linkages.system import System
from linkages.system.rigid_segments import system_of


def configuration(system: System, columns: Mapping[str, Array]) -> Array:
    """Compute the configuration (nt, m) of a linkage from the columns of a run, at its steps or at any times.

    It has the eccentricities of the journals over their clearances, and coordinates of joints without prescribed
    motion: cosine and sine of angles, lengths over the linkage's length. Empty (m = 0) if the drives determine
    everything.
    """
    entries = []
    for (_, label), clearance in zip(system.tree.contacts, system.laws["clearance"], strict=False):
        if f"{label}.ex" in columns:
            entries += [columns[f"{label}.{axis}"] / clearance for axis in ("ex", "ey")]
    if not system.determinate:
        tree = system_of(system, columns).tree
        for name in (tree.coordinates[k] for k in tree.closing_dofs):
            slides = ("." in name and not name.endswith(".angle")) or (
                name in system.mechanism.joint and system.mechanism.joint[name].type == "prismatic"
            )
            value = columns[f"q.{name}"]
            entries += [value / system.tree.extent] if slides else [np.cos(value), np.sin(value)]
    return np.array(entries).T if entries else np.zeros((len(columns["time"]), 0))
