"""Check of a run's loops: gaps of ideal joints, and the last sample with closed loops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from linkages.arrays import Array, Records
from linkages.outputs.columns import Columns
from linkages.planar.closure import LOOSE, loop_errors
from linkages.system.tree import Tree


class Loops(NamedTuple):
    """Loops that a trajectory must keep closed."""

    tree: Tree  # tree with the trajectory's coordinates, columns ``q.COORDINATE``
    rows: Records  # closure rows: `Tree.loop_rows` for a run, `Tree.closure_rows` if all joints are ideal

    def errors(self, columns: Columns) -> Array:
        """Compute the largest loop error (nt,) at each sample [m, rad]."""
        if not len(self.rows):
            return np.zeros(len(columns["time"]))
        q = np.stack([columns[f"q.{name}"] for name in self.tree.coordinates], axis=1)
        return loop_errors(self.tree.bodies, self.rows, q)

    def closed(self, errors: Array) -> int:
        """Count the samples before the first one with open loops."""
        loose = errors > LOOSE * self.tree.extent
        return int(np.argmax(loose)) if loose.any() else len(errors)
